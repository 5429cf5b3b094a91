//! Places of small polytopes by separating axes against the places by all pairs of features.

use super::scenes::{Numbers, cuboid, pair};
use crate::pair::Before;
use catena_mechanism::description::contact::Shape;
use catena_mechanism::description::joint::Pose;
use nalgebra::{Rotation3, Translation3, Vector3};
use std::sync::Arc;

/// A wedge of an arch.
fn wedge() -> Shape {
    let corner = |number: usize| {
        let (side, out, angle) = (number & 1, number >> 1 & 1, 0.15 * (number >> 2) as f64);
        let radius = [0.3, 0.4][out];
        Vector3::new(radius * angle.sin(), [-0.1, 0.1][side], radius * angle.cos() - 0.35)
    };
    Shape::Hull(Arc::new((0..8).map(corner).collect()))
}

#[test]
fn axes_find_the_distance_that_all_pairs_of_features_find_or_a_bound_of_it_that_is_beyond_what_was_asked() {
    let mut numbers = Numbers::new(7);
    let (mut apart, mut near) = (0, 0);
    for shapes in [
        [cuboid(0.1, 0.1, 0.1), cuboid(0.1, 0.1, 0.1)],
        [cuboid(0.2, 0.1, 0.05), cuboid(0.1, 0.15, 0.1)],
        [wedge(), cuboid(0.1, 0.1, 0.1)],
    ] {
        let of = pair(shapes[0].clone(), shapes[1].clone());
        for _ in 0..3000 {
            let (a, b) = (numbers.pose(0.01), numbers.pose(0.25));
            let exact = of.distance(&a, &b).distance;
            let within = 0.02;
            // Corners that are deep in the other shape lie over several faces; steps do not leave them there.
            if exact < -within {
                continue;
            }
            let (places, bound) = of.touches_soon(&a, &b, within, &mut Before::default());
            // Roundings of lengths of 0.5 m: some 1e-16 m each.
            if places.is_empty() {
                assert!(exact >= within - 1e-12, "{exact} although none is found");
                assert!(bound <= exact + 1e-12, "{bound} is no lower bound of {exact}");
                apart += 1;
                continue;
            }
            near += 1;
            // One place has the distance; faces beside the nearest ones are deeper. Where corners are nearest, the planes that part them are less far apart.
            let off = places.iter().map(|place| (place.gap - exact).abs()).fold(f64::INFINITY, f64::min);
            let least = places.iter().map(|place| place.gap).fold(f64::INFINITY, f64::min);
            assert!(off < 1e-12 || exact > 0.0 && least <= exact, "{least} for {exact}");
        }
    }
    assert!(apart > 500 && near > 500, "{apart} {near}");
}

#[test]
fn boxes_that_lie_on_each_other_have_the_same_places_by_axes_as_by_all_pairs_of_features() {
    let of = pair(cuboid(0.1, 0.1, 0.1), cuboid(0.1, 0.1, 0.1));
    let mut numbers = Numbers::new(3);
    for number in 0..400 {
        let turn = Rotation3::new(Vector3::z() * 3.0 * numbers.next() + numbers.vector() * 1e-3);
        let place = Vector3::new(0.08 * numbers.next(), 0.08 * numbers.next(), 0.2005);
        let (a, b) = (Pose::identity(), Pose::from_parts(Translation3::from(place), turn));
        let (soon, _) = of.touches_soon(&a, &b, 2e-3, &mut Before::default());
        let all = of.touches(&a, &b, 2e-3);
        let missing =
            all.iter().filter(|place| !soon.iter().any(|other| (other.points[0] - place.points[0]).norm() < 1e-9));
        assert_eq!((soon.len(), missing.count()), (all.len(), 0), "pose {number}: {soon:?} {all:?}");
    }
}
