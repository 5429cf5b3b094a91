//! Places of shapes with many vertices: a few of them, and all of them without a look at all pairs.

use super::scenes::{Numbers, at, pair};
use crate::pair::Before;
use catena_mechanism::description::contact::Shape;
use catena_mechanism::description::joint::Pose;
use nalgebra::{Rotation3, Translation3, Vector3};
use std::sync::Arc;

/// Points on an ellipsoid with semi-axes of 0.1 to 0.3 m, cut flat below and above if it is a slab.
fn dense(count: usize, slab: bool) -> Shape {
    let golden = 2.399_963_229_728_653;
    let point = |index: usize| {
        let z = 1.0 - 2.0 * (index as f64 + 0.5) / count as f64;
        let (radius, turn) = ((1.0 - z * z).sqrt(), golden * index as f64);
        let z = if slab { z.clamp(-0.3, 0.3) } else { z };
        Vector3::new(0.3 * radius * turn.cos(), 0.2 * radius * turn.sin(), 0.1 * z)
    };
    Shape::Hull(Arc::new((0..count).map(point).collect()))
}

#[test]
fn of_thousands_of_places_of_dense_hulls_a_few_are_left_with_the_nearest_among_them() {
    let mut numbers = Numbers::new(11);
    let near = 0.03;
    for slab in [false, true] {
        let of = pair(dense(2000, slab), dense(1500, slab));
        for round in 0..60 {
            let (a, mut b) = (numbers.pose(0.3), numbers.pose(0.3));
            let first = of.distance(&a, &b);
            // From apart to an overlap of a tenth of a millimetre.
            let gap = [1e-2, 1e-4, 1e-9, 0.0, -1e-10, -1e-6][round % 6];
            b.translation = Translation3::from(b.translation.vector + first.normal * (gap - first.distance));
            let exact = of.distance(&a, &b).distance;
            let (places, _) = of.touches_soon(&a, &b, near, &mut Before::default());
            assert!(!places.is_empty() && places.len() <= 25, "{slab} {round}: {}", places.len());
            let off = |gap: f64| (gap - exact).abs();
            let nearest = places.iter().map(|place| off(place.gap)).fold(f64::INFINITY, f64::min);
            // An overlap is the least one up to its own size, and of places at one point the simplest pair stands for all.
            let same = if exact < 2e-9 { exact.abs() } else { 0.0 };
            assert!(nearest <= same + 1e-12, "{slab} {round}: {nearest:e} off {exact:e}");
            // Where shapes touch, or nearly, a vertex beyond a face by a thousandth of the size counts as over it; the faces beside slope down by 0.1 rad.
            let sharp = if exact < 2e-9 { 0.1 * 3e-4 } else { 1e-12 };
            assert!(places.iter().all(|place| place.gap >= exact - sharp), "{slab} {round}: {exact:e}");
        }
    }
}

#[test]
fn dense_slabs_on_each_other_touch_around_their_common_face() {
    let of = pair(dense(2000, true), dense(1500, true));
    let (a, b) = (Pose::identity(), at(0.05, 0.02, 0.06));
    let (places, _) = of.touches_soon(&a, &b, 0.01, &mut Before::default());
    assert!(places.len() >= 8 && places.iter().filter(|place| place.gap.abs() < 1e-12).count() >= 8, "{places:?}");
    // The middle of both is well inside of what is supported.
    for turn in 0..16 {
        let (sine, cosine) = (0.4 * f64::from(turn)).sin_cos();
        let out = Vector3::new(cosine, sine, 0.0);
        let reach = places.iter().map(|place| out.dot(&(place.points[0] - Vector3::new(0.025, 0.01, 0.03))));
        assert!(reach.fold(f64::NEG_INFINITY, f64::max) > 0.1, "direction {turn}");
    }
}

#[test]
fn after_a_small_turn_the_lowest_vertex_is_one_of_a_few_but_for_a_part_of_the_turn() {
    let of = pair(Shape::HalfSpace, dense(4000, false));
    let mut numbers = Numbers::new(5);
    let near = 0.01;
    for _ in 0..40 {
        let turn = numbers.pose(0.0).rotation;
        let high = |height: f64, turn: Rotation3<f64>| Pose::from_parts(Translation3::new(0.0, 0.0, height), turn);
        let height = 1.0 - of.distance(&Pose::identity(), &high(1.0, turn)).distance;
        let (places, _) = of.touches_soon(&Pose::identity(), &high(height, turn), near, &mut Before::default());
        assert!(places.len() <= 25, "{}", places.len());
        // Half of the turn that the places are for.
        let by = Rotation3::new(numbers.vector().normalize() * (0.5 * near / 0.3));
        let lowest = of.distance(&Pose::identity(), &high(height, by * turn)).distance;
        let of_few = places.iter().map(|place| (by * (place.points[1] - Vector3::z() * height)).z + height);
        let missed = of_few.fold(f64::INFINITY, f64::min) - lowest;
        // The bodies turn by 0.017 rad about places with radii of curvature up to 0.9 m: ½ R θ² = 1.3e-4 m without any choice.
        assert!((-1e-12..3e-5).contains(&missed), "{missed:e}");
    }
}

#[test]
fn a_normal_that_is_kept_changes_no_place_and_bounds_the_distance() {
    let of = pair(dense(300, false), dense(200, true));
    let mut numbers = Numbers::new(29);
    let near = 0.02;
    let (mut before, mut bounded, mut touched) = (Before::default(), 0, 0);
    let (a, mut b) = (Pose::identity(), at(0.0, 0.0, 0.4));
    for round in 0..300 {
        // To and fro, with turns by a tenth of a radian, from 0.25 m apart to an overlap of a centimetre.
        let height = 0.24 + 0.15 * (0.1 * f64::from(round)).sin();
        let turn = Rotation3::new(numbers.vector() * 0.1) * b.rotation;
        b = Pose::from_parts(Translation3::new(0.05, 0.02, height), turn);
        let exact = of.distance(&a, &b).distance;
        let (anew, _) = of.touches_soon(&a, &b, near, &mut Before::default());
        let (kept, bound) = of.touches_soon(&a, &b, near, &mut before);
        assert_eq!(kept, anew, "{round}");
        assert_eq!(before.touches, !kept.is_empty());
        if kept.is_empty() {
            assert!(bound > near && bound <= exact + 1e-12, "{round}: {bound:e} for {exact:e}");
            bounded += 1;
        } else {
            touched += 1;
        }
    }
    assert!(bounded > 50 && touched > 50, "{bounded} {touched}");
}

#[test]
fn the_distance_for_a_search_of_roots_is_exact_but_for_deep_overlaps_of_hulls_that_it_bounds_from_below() {
    let mut numbers = Numbers::new(11);
    let pair = pair(dense(80, false), dense(90, true));
    let (mut same, mut deep) = (0, 0);
    for _ in 0..300 {
        let (a, b) = (numbers.pose(0.1), numbers.pose(0.5));
        let (exact, searched) = (pair.distance(&a, &b).distance, pair.distance_unless_deep(&a, &b));
        if exact == searched {
            same += 1;
            continue;
        }
        // A ten thousandth of the size, which is 0.3 m.
        deep += 1;
        assert!(exact < -2.9e-5 && searched <= exact + 1e-15, "{exact} {searched}");
    }
    assert!(same > 60 && deep > 20, "{same} {deep}");
}
