//! The number of places of contact, and the properties of each.

use super::scenes::{Numbers, at, collider, cuboid, floor, pair};
use crate::shapes::plane::across;
use crate::{FeatureId, PairGeometry, TouchPlace};
use catena_mechanism::description::contact::{Feature, Shape};
use catena_mechanism::description::joint::Pose;
use nalgebra::{Rotation3, Translation3, UnitQuaternion, Vector3};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_6};

/// A pose turned by a rotation vector (rad).
fn turned(x: f64, y: f64, z: f64, by: Vector3<f64>) -> Pose {
    Pose::from_parts(Translation3::new(x, y, z), Rotation3::new(by))
}

/// A pose with its z axis along x.
fn lying(z: f64) -> Pose {
    turned(0.013, 0.02, z, Vector3::y() * FRAC_PI_2)
}

fn capsule() -> Shape {
    Shape::Capsule { radius: 0.05, half: 0.2 }
}

fn cylinder() -> Shape {
    Shape::Cylinder { radius: 0.05, half: 0.2 }
}

fn flat() -> Shape {
    floor(8, 0.1, |_, _| 0.0)
}

/// The gap (m) of a place, from its features and frames alone.
fn gap(place: &TouchPlace, a: &Pose, b: &Pose) -> f64 {
    let (one, other) = if place.swapped { (b, a) } else { (a, b) };
    let (one, other) = (one * place.frames[0], other * place.frames[1]);
    let (p, q) = (one.translation.vector, other.translation.vector);
    let (z, w) = (one.rotation * Vector3::z(), other.rotation * Vector3::z());
    match place.features {
        [Feature::Point { radius: r }, Feature::Point { radius: s }] => (q - p).norm() - r - s,
        [Feature::Plane, Feature::Point { radius }] => z.dot(&(q - p)) - radius,
        [Feature::Line { radius: r }, Feature::Point { radius: s }] => z.cross(&(q - p)).norm() - r - s,
        [Feature::Line { radius: r }, Feature::Line { radius: s }] => {
            place.side * z.cross(&w).normalize().dot(&(q - p)) - r - s
        }
        [Feature::Plane, Feature::Rim { radius }] => z.dot(&(q - p)) - radius * w.cross(&z).norm(),
        // An edge across a rim, which it meets at m from the axis: the height of one over the other along their common normal.
        [Feature::Line { .. }, Feature::Rim { radius }] => {
            let through = p + z * (w.dot(&(q - p)) / w.dot(&z));
            let out = (through - q).normalize();
            place.side * (out * w.dot(&z) - w * out.dot(&z)).normalize().dot(&(q + out * radius - through))
        }
        [Feature::Rim { radius }, Feature::Line { radius: 0.0 }] => {
            let level = |vector: Vector3<f64>| vector - z * z.dot(&vector);
            let (off, along) = (level(q - p), level(w));
            let half = off.dot(&along) / along.norm_squared();
            let root = (half * half - (off.norm_squared() - radius * radius) / along.norm_squared()).sqrt();
            let through = q + w * (root - half);
            let out = level(through - p) / radius;
            place.side * (out * z.dot(&w) - z * out.dot(&w)).normalize().dot(&(through - p - out * radius))
        }
        // A rim is sampled and halved down to its nearest place to the round feature.
        [Feature::Rim { radius }, Feature::Point { .. } | Feature::Line { .. }] => {
            let (off, round) = match place.features[1] {
                Feature::Line { radius } => (w, radius),
                Feature::Point { radius } => (Vector3::zeros(), radius),
                _ => unreachable!("matched above"),
            };
            let (x, y) = across(&z);
            let far = |turn: f64| {
                let between = q - p - (x * turn.cos() + y * turn.sin()) * radius;
                (between - off * off.dot(&between)).norm()
            };
            let near = (0..720).map(|step| f64::from(step) * FRAC_PI_2 / 180.0);
            let nearest = near.min_by(|one, other| far(*one).total_cmp(&far(*other))).expect("angles");
            let (mut low, mut high) = (nearest - 0.01, nearest + 0.01);
            for _ in 0..100 {
                let thirds = [low + (high - low) / 3.0, high - (high - low) / 3.0];
                if far(thirds[0]) < far(thirds[1]) { high = thirds[1] } else { low = thirds[0] }
            }
            far(0.5 * (low + high)) - round
        }
        // The place at which the second goes through the plane of the first, downwards.
        [Feature::Rim { radius }, Feature::Rim { radius: other }] => {
            let (x, y) = across(&w);
            let height = |turn: f64| z.dot(&(q + (x * turn.cos() + y * turn.sin()) * other - p));
            // It goes down from where it is highest to half a turn later.
            let highest = z.dot(&y).atan2(z.dot(&x));
            let (mut high, mut low) = (highest, highest + std::f64::consts::PI);
            for _ in 0..100 {
                let middle = 0.5 * (low + high);
                if height(middle) > 0.0 { high = middle } else { low = middle }
            }
            let through = q + (x * low.cos() + y * low.sin()) * other;
            let out = (through - p).normalize();
            let normal = z.cross(&out).cross(&w.cross(&(through - q))).normalize() * place.side;
            normal.dot(&(through - p - out * radius))
        }
        other => panic!("{other:?} is no pair of a joint"),
    }
}

#[test]
fn every_scene_has_as_many_places_as_the_area_of_contact_has_corners() {
    let o = Pose::identity();
    let cube = || cuboid(0.1, 0.1, 0.1);
    let table = [
        ("box on half space", Shape::HalfSpace, cuboid(0.1, 0.2, 0.3), o, at(0.0, 0.0, 0.3), 4),
        ("half space under box", cuboid(0.1, 0.2, 0.3), Shape::HalfSpace, at(0.0, 0.0, 0.3), o, 4),
        ("box on box", cube(), cube(), o, at(0.0, 0.0, 0.2), 4),
        ("box on box, shifted", cube(), cube(), o, at(0.05, 0.03, 0.2), 4),
        ("box on box, turned", cube(), cube(), o, turned(0.0, 0.0, 0.2, Vector3::z() * FRAC_PI_6), 8),
        ("box on mesh", flat(), cuboid(0.15, 0.15, 0.1), o, turned(0.02, 0.03, 0.1, Vector3::z() * 0.3), 4),
        ("box on mesh, along its edges", flat(), cuboid(0.15, 0.15, 0.1), o, at(0.05, 0.05, 0.1), 4),
        ("ball over an edge of a mesh", flat(), Shape::Sphere { radius: 0.1 }, o, at(0.1, 0.05, 0.1), 1),
        ("capsule on mesh", flat(), capsule(), o, lying(0.05), 2),
        ("capsule on half space", Shape::HalfSpace, capsule(), o, lying(0.05), 2),
        ("capsule along capsule", capsule(), capsule(), o, at(0.1, 0.0, 0.1), 2),
        ("capsule across capsule", capsule(), capsule(), o, turned(0.1, 0.0, 0.1, Vector3::x()), 1),
        ("capsule across box", cube(), capsule(), o, lying(0.15), 2),
        ("cylinder lying on half space", Shape::HalfSpace, cylinder(), o, lying(0.05), 2),
        ("cylinder lying on box", cuboid(1.0, 1.0, 0.1), cylinder(), o, lying(0.15), 2),
        ("cylinder lying across box", cube(), cylinder(), o, lying(0.15), 2),
        ("cylinder lying on mesh", flat(), cylinder(), o, lying(0.05), 2),
        ("cylinder standing on half space", Shape::HalfSpace, cylinder(), o, at(0.0, 0.0, 0.2), 4),
        ("cylinder standing on box", cube(), cylinder(), o, at(0.0, 0.0, 0.3), 4),
        ("cylinder standing on mesh", flat(), cylinder(), o, at(0.0, 0.0, 0.2), 4),
        ("box on its vertex", cube(), cube(), o, turned(0.0, 0.0, 0.5, Vector3::zeros()), 0),
    ];
    for (name, a, b, of_a, of_b, count) in table {
        let places = pair(a, b).touches(&of_a, &of_b, 1e-9);
        let found: Vec<_> = places.iter().map(|place| place.identity).collect();
        assert_eq!(places.len(), count, "{name}: {found:?}");
        for place in &places {
            let disc = name.starts_with("cylinder standing");
            assert_eq!(place.exact, !disc, "{name}");
            // Coordinates of 0.3 m have roundings of 5e-17.
            assert!(place.gap.abs() <= 1e-15 && (gap(place, &of_a, &of_b) - place.gap).abs() <= 1e-15, "{name}");
        }
    }
}

#[test]
fn the_frames_of_a_place_give_its_gap_and_its_normal_also_after_the_bodies_have_moved() {
    let kinds = ["half space", "sphere", "capsule", "box", "hull", "cylinder"];
    let mut numbers = Numbers::new(5);
    let (mut stand_ins, mut count) = (0, 0);
    for one in kinds {
        for other in kinds.into_iter().filter(|other| [one, *other] != ["half space", "half space"]) {
            for round in 0..40 {
                let (a, b) = (collider(one, 1.0, &mut numbers), collider(other, 1.0, &mut numbers));
                let pair = PairGeometry::new(&a, &b).expect("shapes that are possible");
                let (of_a, mut of_b) = (numbers.pose(0.3), numbers.pose(0.3));
                let first = pair.distance(&of_a, &of_b);
                let apart = [0.1, 1e-3, 1e-9, 0.0][round % 4];
                of_b.translation =
                    Translation3::from(of_b.translation.vector + first.normal * (apart - first.distance));
                let distance = pair.distance(&of_a, &of_b).distance;
                let places = pair.touches(&of_a, &of_b, apart + 1e-10);
                assert!(!places.is_empty(), "{one}-{other} at {apart:e}");
                let least = places.iter().map(|place| place.gap).fold(f64::INFINITY, f64::min);
                // A sharp vertex that is beyond a face by less than the bound counts as over it: its height is less than its distance.
                let beyond = if apart <= 1e-9 { apart + 1e-10 } else { 0.0 };
                assert!(
                    least >= distance - beyond - 1e-12 && least <= distance + 1e-12,
                    "{one}-{other} at {apart:e}: {least:e} for {distance:e}"
                );
                for place in &places {
                    count += 1;
                    // Only sharp features that are apart have stand-ins: where they touch all have a form of their own.
                    assert!(place.exact || apart > 1e-9, "{one}-{other} at {apart:e}: {place:?}");
                    stand_ins += usize::from(!place.exact);
                    let said = gap(place, &of_a, &of_b);
                    assert!(
                        (said - place.gap).abs() <= 1e-13,
                        "{one}-{other}: {said:e} for {:e}, {place:?}",
                        place.gap
                    );
                    // Moved along the normal, every gap grows as much: the frames belong to the bodies and the normal is theirs. The gap of an edge
                    // and a rim, and of two rims, is a distance to first order only.
                    let crosses = matches!(
                        place.features,
                        [Feature::Line { radius: 0.0 }, Feature::Rim { .. }]
                            | [Feature::Rim { .. }, Feature::Line { radius: 0.0 } | Feature::Rim { .. }]
                    );
                    let far = if crosses { 1e-9 } else { 1e-6 };
                    let moved = Translation3::from(place.normal * far) * of_b;
                    let grown = gap(place, &of_a, &moved) - said;
                    assert!((grown - far).abs() <= 1e-13, "{one}-{other}: {grown:e}, {place:?}");
                }
            }
        }
    }
    assert!(stand_ins * 30 < count, "{stand_ins} of {count} places are stand-ins");
}

#[test]
fn an_edge_across_the_rim_of_a_cylinder_crosses_it_twice() {
    // A box whose edge lies on the cap of a standing cylinder, along a chord, and an end of it inside of the rim.
    let tipped = Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_4);
    let pair = pair(Shape::Cylinder { radius: 0.1, half: 0.2 }, cuboid(0.3, 0.02, 0.02));
    let over = |x: f64, y: f64| Pose::from_parts(Translation3::new(x, y, 0.2 + 0.02 * 2f64.sqrt()), tipped);
    let chord = pair.touches(&Pose::identity(), &over(0.0, 0.03), 1e-9);
    let mut places: Vec<f64> = chord.iter().map(|place| place.points[0].x).collect();
    places.sort_by(f64::total_cmp);
    let half = (0.1f64.powi(2) - 0.03f64.powi(2)).sqrt();
    assert_eq!(places.len(), 2, "{chord:?}");
    assert!((places[0] + half).abs() < 1e-12 && (places[1] - half).abs() < 1e-12, "{places:?}");
    // Whichever way the edge goes on beyond its end over the cap, it crosses the rim once.
    for end in [-0.05, -0.01, 0.04, 0.09] {
        let chord = pair.touches(&Pose::identity(), &over(end + 0.3, 0.03), 1e-9);
        let mut places: Vec<f64> = chord.iter().map(|place| place.points[0].x).collect();
        places.sort_by(f64::total_cmp);
        assert_eq!(places.len(), 2, "{chord:?}");
        assert!((places[0] - end).abs() < 1e-12 && (places[1] - half).abs() < 1e-12, "{places:?}");
    }
}

#[test]
fn exchanged_colliders_touch_at_the_same_places() {
    let mut numbers = Numbers::new(9);
    let (a, b) = (collider("box", 1.0, &mut numbers), collider("capsule", 1.0, &mut numbers));
    let (one, other) = (PairGeometry::new(&a, &b).expect("a pair"), PairGeometry::new(&b, &a).expect("a pair"));
    for _ in 0..100 {
        let (of_a, of_b) = (numbers.pose(0.3), numbers.pose(0.3));
        let (there, back) = (one.distance(&of_a, &of_b), other.distance(&of_b, &of_a));
        assert!((there.distance - back.distance).abs() <= 1e-14, "{there:?} {back:?}");
        let near = there.distance + 1e-9;
        let (places, others) = (one.touches(&of_a, &of_b, near), other.touches(&of_b, &of_a, near));
        assert_eq!(places.len(), others.len());
        for place in places {
            let same = others
                .iter()
                .find(|other| (other.identity.a, other.identity.b) == (place.identity.b, place.identity.a));
            let same = same.expect("the same place");
            let alike = std::mem::discriminant(&place.features[0]) == std::mem::discriminant(&place.features[1]);
            let expected = if alike { [place.features[1], place.features[0]] } else { place.features };
            assert_eq!(same.features, expected, "only features of one kind follow the order of the colliders");
            assert!((same.normal + place.normal).norm() <= 1e-14);
        }
    }
}

#[test]
fn four_points_stand_for_the_rim_of_a_cylinder_only_while_it_is_flat_on_the_plane() {
    let pair = pair(Shape::HalfSpace, cylinder());
    let tilted = |angle: f64| {
        let height = 0.2 * angle.cos() + 0.05 * angle.sin();
        pair.touches(&Pose::identity(), &turned(0.0, 0.0, height, Vector3::x() * angle), 1e-9)
    };
    assert!(tilted(0.0).iter().all(|place| matches!(place.identity.b, FeatureId::RimPoint { .. })));
    let slanted = tilted(1e-6);
    assert_eq!(slanted.len(), 1);
    assert_eq!((slanted[0].identity.b, slanted[0].exact), (FeatureId::Rim(0), true));
}

#[test]
fn two_discs_that_lie_on_each_other_touch_on_the_arcs_of_both_rims_wherever_they_are() {
    let [radius, half] = [0.3, 0.2];
    for other in [0.3, 0.1, 0.02] {
        let pair = pair(Shape::Cylinder { radius, half }, Shape::Cylinder { radius: other, half });
        for turn in [0.0, 0.4, 1.0, 2.5] {
            // The offsets go from next to the middle to a tenth of the smaller disc left on the other.
            for beside in [1e-6, 0.01, 0.1, 0.2, radius - 0.5 * other, radius, radius + 0.9 * other] {
                let (sine, cosine) = f64::sin_cos(turn);
                let upper = at(beside * cosine, beside * sine, 2.0 * half);
                let places = pair.touches(&at(0.0, 0.0, 0.0), &upper, 1e-9);
                let on: Vec<Vector3<f64>> = places.iter().map(|place| place.points[1]).collect();
                for point in &on {
                    let apart = [point.xy().norm(), (point - upper.translation.vector).xy().norm()];
                    // Rim points are on one circle to rounding, and in the other.
                    assert!(apart[0] <= radius + 1e-12 && apart[1] <= other + 1e-12, "{other} {beside}: {apart:?}");
                }
                // Twice the area of the largest triangle, compared with the lens: the points carry a pressure in any direction.
                let mut area = 0.0_f64;
                for a in &on {
                    for b in &on {
                        on.iter().for_each(|c| area = area.max((b - a).cross(&(c - a)).norm()));
                    }
                }
                let wide = (radius + other - beside).min(2.0 * other);
                assert!(on.len() >= 3 && area > 0.2 * wide * wide, "{other} {beside} {turn}: {area} of {on:?}");
            }
        }
    }
}

#[test]
fn an_edge_beside_the_tangent_of_a_rim_touches_the_cap_with_its_middle() {
    let pair = pair(Shape::Cylinder { radius: 0.3, half: 0.2 }, cuboid(1.0, 0.5, 0.1));
    // The edge of the box at x = −1 is this far inside the rim, in a direction in which no other point of the rim is looked at.
    let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), 0.3);
    for (inside, meets) in [(1e-9, true), (1e-6, true), (-1e-6, false)] {
        let pose = Pose::from_parts(Translation3::from(turn * Vector3::new(1.3 - inside, 0.1, 0.3)), turn);
        let places = pair.touches(&at(0.0, 0.0, 0.0), &pose, 1e-9);
        if !meets {
            assert!(places.is_empty(), "{places:?}");
            continue;
        }
        let [place] = &places[..] else { panic!("{inside}: {places:?}") };
        // On the cap, next to the tangent, and as far inside as the edge.
        assert!((place.points[0] - turn * Vector3::new(0.3 - inside, 0.0, 0.2)).norm() < 1e-14, "{place:?}");
        let margin = pair.margin(place, &at(0.0, 0.0, 0.0), &pose);
        assert!((margin - inside).abs() < 1e-14, "{margin:e}");
    }
}

#[test]
fn a_stand_in_ends_where_the_shapes_are_elsewhere() {
    // Two discs whose rims cross at less than a milliradian, the upper one tilted down to where they do.
    let disc = |radius| Shape::Cylinder { radius, half: 0.1 };
    let (wide, narrow, beside) = (0.2, 0.15, 0.05 + 1e-7_f64);
    let along = (beside * beside + wide * wide - narrow * narrow) / (2.0 * beside);
    let corner = Vector3::new(along, (wide * wide - along * along).sqrt(), 0.0);
    let from_other = corner - Vector3::x() * beside;
    let down = (corner / wide + from_other / narrow).normalize();
    let tangent = Vector3::z().cross(&down);
    let tilted = |slides: f64| {
        let turn = Rotation3::from_scaled_axis(tangent * 0.01);
        let centre = corner + tangent * slides + Vector3::z() * 0.1 + turn * (Vector3::z() * 0.1 - from_other);
        Pose::from_parts(Translation3::from(centre), turn)
    };
    let pair = pair(disc(wide), disc(narrow));
    let here = Pose::identity();
    let places = pair.touches(&here, &tilted(0.0), 1e-12);
    let place = places.iter().find(|place| place.is_stand_in()).expect("one without a form of its own");
    assert!(pair.margin(place, &here, &tilted(0.0)) > 0.0);
    // A millimetre along the common tangent they are elsewhere, which the stand-in does not see.
    let apart = pair.distance(&here, &tilted(1e-3)).distance;
    let said = gap(place, &here, &tilted(1e-3));
    assert!((apart - said).abs() > 1e-9, "{apart:e} {said:e}");
    assert!(pair.margin(place, &here, &tilted(1e-3)) < 0.0);
}

#[test]
fn a_level_cylinder_above_a_floor_touches_it_nowhere() {
    // Turned about the vertical its axis has roundings, and the middle of its end is above the place that is nearest to itself: neither is a
    // direction.
    let pair = pair(Shape::HalfSpace, Shape::Cylinder { radius: 0.05, half: 0.0285 });
    for turn in 0..500 {
        // The rotation comes from a quaternion: the square of its length is one but for rounding.
        let rotation = UnitQuaternion::from_scaled_axis(Vector3::z() * (0.0123 * f64::from(turn))).to_rotation_matrix();
        let above = Pose::from_parts(Translation3::new(-0.0027, 0.0105, 0.0295), rotation);
        let found = pair.touches(&Pose::identity(), &above, 1e-9);
        assert!(found.is_empty(), "{turn}: {:?}, {:e} m", found[0].identity, found[0].gap);
        assert!((pair.distance(&Pose::identity(), &above).distance - 1e-3).abs() <= 1e-16, "{turn}");
    }
}
