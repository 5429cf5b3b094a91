//! Distances of all pairs of kinds at random poses, against their own certificates and against a search over normals.

use super::scenes::{Numbers, collider, support};
use crate::PairGeometry;
use nalgebra::{Translation3, Vector3};
use std::ops::Range;

const KINDS: [&str; 6] = ["half space", "sphere", "capsule", "box", "hull", "cylinder"];

/// Largest certificate of a pair of kinds, relative to the size, over random poses with gaps on either side of zero. Rounds before the first are
/// drawn, but not looked at.
fn worst_certificate(one: &str, other: &str, size: f64, rounds: Range<usize>) -> (f64, String) {
    let mut numbers = Numbers::new(7);
    let mut worst = (0.0, String::new());
    let mut pair = None;
    for round in 0..rounds.end {
        if round % 50 == 0 {
            let (a, b) = (collider(one, size, &mut numbers), collider(other, size, &mut numbers));
            pair = PairGeometry::new(&a, &b).ok();
        }
        let pair = pair.as_ref().expect("shapes that are possible");
        let (a, mut b) = (numbers.pose(0.3 * size), numbers.pose(0.3 * size));
        if round < rounds.start {
            continue;
        }
        let first = pair.distance(&a, &b);
        let gap = size * [0.1, 1e-3, 1e-6, 1e-9, 1e-12, 0.0, -1e-12, -1e-9, -1e-6, -1e-3][round % 10];
        b.translation = Translation3::from(b.translation.vector + first.normal * (gap - first.distance));
        let found = pair.distance(&a, &b);
        let between = (found.points[1] - found.points[0] - found.normal * found.distance).norm();
        let certificate = found.certificate.max(between) / size;
        if certificate.is_nan() || certificate > worst.0 {
            worst = (certificate, format!("{one}-{other} at {:.1e}, round {round}", found.distance / size));
        }
    }
    worst
}

/// Every pair of kinds in both orders: 1e-13 of the size is a hundred roundings of coordinates about one size.
fn all_certified(size: f64, count: usize) {
    for one in KINDS {
        for other in KINDS.into_iter().filter(|other| [one, *other] != ["half space", "half space"]) {
            let (worst, at) = worst_certificate(one, other, size, 0..count);
            assert!(worst <= 1e-13, "{at}: {worst:.1e} of the size {size:e}");
        }
    }
}

#[test]
fn distances_of_all_pairs_are_certified_at_size_one() {
    all_certified(1.0, 600);
}

#[test]
fn distances_of_all_pairs_are_certified_at_ten_micrometres() {
    all_certified(1e-5, 300);
}

#[test]
fn distances_of_all_pairs_are_certified_at_a_kilometre() {
    all_certified(1e3, 300);
}

#[test]
fn distances_of_ellipsoids_to_half_spaces_are_certified() {
    // As of all pairs: a hundred roundings of coordinates about one size.
    for (size, (one, other)) in
        [1e-5, 1.0, 1e3].into_iter().zip([("half space", "ellipsoid"), ("ellipsoid", "half space")].into_iter().cycle())
    {
        let (worst, at) = worst_certificate(one, other, size, 0..600);
        assert!(worst <= 1e-13, "{at}: {worst:.1e} of the size {size:e}");
    }
}

/// An edge that leaves over a rim, with its normal 2.5e-4 rad from the axis: only the guess at one end of the edge leads to this place, and the guess
/// of the normal there has the other sign. The points of the largest separation alone are 1.2e-13 of the size off.
#[test]
fn an_edge_on_a_rim_is_found_on_either_side_of_the_normal_that_was_guessed() {
    let (worst, at) = worst_certificate("cylinder", "box", 1e-5, 12277..12278);
    assert!(worst <= 1e-15, "{at}: {worst:.1e} of the size");
}

/// A hundred thousand poses of a pair of kinds at each of three sizes; the worst of each is printed, with the time of a pose.
fn certified_at_length(one: &str, other: &str) {
    let mut missed = Vec::new();
    for size in [1e-5, 1.0, 1e3] {
        let start = std::time::Instant::now();
        let (worst, at) = worst_certificate(one, other, size, 0..100_000);
        let each = start.elapsed().as_secs_f64() * 1e6 / 2e5;
        println!("{one}-{other}, size {size:e}: {worst:.1e} ({at}), {each:.0} µs for a distance");
        if worst.is_nan() || worst > 1e-13 {
            missed.push((size, worst, at));
        }
    }
    assert!(missed.is_empty(), "{missed:?}");
}

/// One test for each pair of kinds, so that pairs can be run one by one:
/// `cargo test --release -p catena-geometry hundred_thousand_poses::cylinder_box -- --ignored --nocapture`.
macro_rules! hundred_thousand_poses {
    ($($name:ident $one:literal $other:literal,)*) => {
        mod hundred_thousand_poses {
            $(
                #[test]
                #[ignore = "minutes: cargo test --release -p catena-geometry hundred_thousand -- --ignored --nocapture"]
                fn $name() {
                    super::certified_at_length($one, $other);
                }
            )*

            /// The pairs that have a test.
            pub const PAIRS: &[[&str; 2]] = &[$([$one, $other],)*];
        }
    };
}

hundred_thousand_poses! {
    half_space_sphere "half space" "sphere",
    half_space_capsule "half space" "capsule",
    half_space_box "half space" "box",
    half_space_hull "half space" "hull",
    half_space_cylinder "half space" "cylinder",
    sphere_half_space "sphere" "half space",
    sphere_sphere "sphere" "sphere",
    sphere_capsule "sphere" "capsule",
    sphere_box "sphere" "box",
    sphere_hull "sphere" "hull",
    sphere_cylinder "sphere" "cylinder",
    capsule_half_space "capsule" "half space",
    capsule_sphere "capsule" "sphere",
    capsule_capsule "capsule" "capsule",
    capsule_box "capsule" "box",
    capsule_hull "capsule" "hull",
    capsule_cylinder "capsule" "cylinder",
    box_half_space "box" "half space",
    box_sphere "box" "sphere",
    box_capsule "box" "capsule",
    box_box "box" "box",
    box_hull "box" "hull",
    box_cylinder "box" "cylinder",
    hull_half_space "hull" "half space",
    hull_sphere "hull" "sphere",
    hull_capsule "hull" "capsule",
    hull_box "hull" "box",
    hull_hull "hull" "hull",
    hull_cylinder "hull" "cylinder",
    cylinder_half_space "cylinder" "half space",
    cylinder_sphere "cylinder" "sphere",
    cylinder_capsule "cylinder" "capsule",
    cylinder_box "cylinder" "box",
    cylinder_hull "cylinder" "hull",
    cylinder_cylinder "cylinder" "cylinder",
}

#[test]
fn every_pair_of_kinds_has_a_test_of_a_hundred_thousand_poses() {
    let all = KINDS.into_iter().flat_map(|one| KINDS.into_iter().map(move |other| [one, other]));
    let wanted: Vec<[&str; 2]> = all.filter(|pair| *pair != ["half space", "half space"]).collect();
    assert_eq!(hundred_thousand_poses::PAIRS, wanted);
}

#[test]
fn no_normal_separates_two_shapes_by_more_than_their_distance() {
    let mut numbers = Numbers::new(11);
    for one in KINDS.into_iter().skip(1) {
        for other in KINDS.into_iter().skip(1) {
            for _ in 0..12 {
                let (a, b) = (collider(one, 1.0, &mut numbers), collider(other, 1.0, &mut numbers));
                let pair = PairGeometry::new(&a, &b).expect("shapes that are possible");
                let (of_a, of_b) = (numbers.pose(0.25), numbers.pose(0.25));
                let found = pair.distance(&of_a, &of_b);
                let separation = |normal: &Vector3<f64>| {
                    -support(&b.shape, &(of_b * b.pose), &-normal) - support(&a.shape, &(of_a * a.pose), normal)
                };
                let mut best = (f64::NEG_INFINITY, Vector3::z());
                for _ in 0..3000 {
                    let normal = numbers.vector().normalize();
                    let value = separation(&normal);
                    best = if value > best.0 { (value, normal) } else { best };
                }
                let mut width = 0.1;
                for _ in 0..3000 {
                    let normal = (best.1 + numbers.vector() * width).normalize();
                    let value = separation(&normal);
                    if value > best.0 {
                        best = (value, normal);
                    } else {
                        width = (width * 0.99).max(1e-9);
                    }
                }
                // The lower bound is the bound of the theory, to rounding; the upper one is the accuracy of the search on ridges.
                let off = found.distance - best.0;
                assert!(
                    off >= -1e-12,
                    "{one}-{other}: {:.3e}, but a normal separates by {:.3e}",
                    found.distance,
                    best.0
                );
                assert!(off <= 2e-2, "{one}-{other}: {:.3e}, but the search found only {:.3e}", found.distance, best.0);
                assert!((separation(&found.normal) - found.distance).abs() <= 1e-13, "{one}-{other}: the normal");
            }
        }
    }
}

#[test]
fn reach_is_the_distance_of_the_farthest_point_from_the_origin_of_the_body() {
    let mut numbers = Numbers::new(3);
    for kind in KINDS.into_iter().skip(1) {
        let (a, b) = (collider(kind, 1.0, &mut numbers), collider("half space", 1.0, &mut numbers));
        let [reach, of_half_space] = PairGeometry::new(&a, &b).expect("shapes that are possible").reach();
        let farthest =
            (0..20_000).map(|_| support(&a.shape, &a.pose, &numbers.vector().normalize())).fold(0.0, f64::max);
        // A cylinder may say more than it reaches by its own size, never less.
        assert!(reach >= farthest && reach <= farthest + 0.2, "{kind}: {reach} for {farthest}");
        assert_eq!(of_half_space, f64::INFINITY);
    }
}
