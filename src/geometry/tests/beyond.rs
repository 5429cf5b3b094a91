//! The next contacts of shapes that touch at some places.

use super::scenes::{cuboid, floor, pair};
use crate::PlaceId;
use catena_mechanism::description::joint::Pose;
use nalgebra::{Rotation3, Translation3, Unit, Vector3};

#[test]
fn a_plate_that_tilts_about_two_corners_of_what_it_shares_with_another_is_seen_to_sink_at_a_third() {
    // Two equal plates, the upper one turned by 10 mrad and aside by some millimetres, so that they share a polygon of these many corners.
    for (turn, aside, corners) in [(0.01, [0.004, 0.003], 4), (-0.01, [0.0055, 0.0], 6)] {
        let (pair, o) = (pair(cuboid(0.1, 0.1, 0.05), cuboid(0.1, 0.1, 0.05)), Pose::identity());
        let turned = Rotation3::from_axis_angle(&Vector3::z_axis(), turn);
        let upper = Pose::from_parts(Translation3::new(aside[0], aside[1], 0.1), turned);
        let places = pair.touches(&o, &upper, 1e-9);
        assert_eq!(places.len(), corners, "{places:?}");
        let least = |closed: &[usize], upper: &Pose| {
            let identities: Vec<PlaceId> = closed.iter().map(|&place| places[place].identity).collect();
            let now = pair.touches(&o, upper, 1e-6);
            // One whose features are left where the plate tilts is an event of its own.
            let of = |identity: &PlaceId| {
                let at = now.iter().find(|place| place.identity == *identity)?;
                pair.beyond(identity, &identities, [&at.normal, &at.points[0]], [&o, upper], 10.0)
            };
            identities.iter().filter_map(of).reduce(f64::min)
        };
        // Held vertices are left out, and the rest is the height of a plate away; the others hold each corner.
        let all: Vec<usize> = (0..corners).collect();
        assert!(least(&all, &upper).is_some_and(|height| height >= 0.1 - 1e-12));
        for left_out in 0..corners {
            let closed: Vec<usize> = all.iter().copied().filter(|&place| place != left_out).collect();
            let height = least(&closed, &upper).expect("places that are held");
            assert!(height >= 0.1 - 1e-12, "{turn} without {left_out}: {height}");
        }
        // Tilted about two corners by a microradian it sinks at one of the others by up to 0.14 µm, about a diagonal whichever way it tilts.
        let (mut diagonals, mut looked) = (0, 0);
        for (one, other) in all.iter().flat_map(|&one| (0..one).map(move |other| (one, other))) {
            let (from, to) = (places[one].points[0], places[other].points[0]);
            let axis = Unit::new_normalize(to - from);
            let side = |place: usize| axis.cross(&(places[place].points[0] - from)).z;
            let others = || all.iter().filter(|place| ![one, other].contains(place)).map(|&place| side(place));
            let diagonal = others().any(|side| side > 0.0) && others().any(|side| side < 0.0);
            for tilt in [-1e-6, 1e-6] {
                let turn = Rotation3::from_axis_angle(&axis, tilt);
                let moved = from + turn * (upper.translation.vector - from);
                let tilted = Pose::from_parts(moved.into(), turn * turned);
                let deep = -pair.distance(&o, &tilted).distance;
                assert!(!diagonal || deep > 1e-10, "{one} {other} {tilt}: {deep:e}");
                let Some(height) = least(&[one, other], &tilted) else { continue };
                looked += 1;
                assert!(deep < 1e-10 || height <= -0.5 * deep, "{one} {other} {tilt}: {height:e} at {deep:e}");
            }
            diagonals += usize::from(diagonal);
        }
        assert_eq!(diagonals, corners * (corners - 3) / 2);
        assert!(looked > corners * (corners - 1) / 2, "{looked}");
    }
}

#[test]
fn a_box_on_a_flat_mesh_is_as_far_from_all_but_its_corners_as_on_a_plane_and_one_beside_a_step_is_not_known() {
    let o = Pose::identity();
    // A box of 0.2 by 0.2 by 0.1 m lies 13 mm beside seams of the mesh; in the second one a step of 1 cm begins 0.3 m beside its middle.
    let on = |mesh| pair(mesh, cuboid(0.1, 0.1, 0.05));
    let flat = on(floor(20, 0.1, |_, _| 0.0));
    let stepped = on(floor(20, 0.1, |x, _| if x > 0.35 { 0.01 } else { 0.0 }));
    let lowest = |pair: &crate::PairGeometry, x: f64| {
        let upper = Pose::from_parts(Translation3::new(x, 0.021, 0.05), Rotation3::identity());
        let places = pair.touches(&o, &upper, 1e-9);
        assert_eq!(places.len(), 4, "the corners");
        let closed: Vec<PlaceId> = places.iter().map(|place| place.identity).collect();
        let of = |place: &crate::TouchPlace| {
            pair.beyond(&place.identity, &closed, [&place.normal, &place.points[0]], [&o, &upper], 10.0)
        };
        places.iter().map(of).collect::<Vec<_>>()
    };
    // The upper corners are 0.1 m over the plane.
    assert!(lowest(&flat, 0.013).iter().all(|height| height.is_some_and(|height| (height - 0.1).abs() < 1e-15)));
    // Far from the step the mesh is flat as far as a twentieth of the box's 0.15 m.
    assert!(lowest(&stepped, 0.013).iter().all(|height| height.is_some_and(|height| (height - 0.0075).abs() < 1e-15)));
    // A corner 5 mm beside the slope of the step.
    assert!(lowest(&stepped, 0.195).iter().all(Option::is_none));
}
