//! Edges that lie on parallel edges: several normals separate two bodies, and roundings must not choose among them.
//!
//! ```text
//!     gap = max over the normals n of sep(n):   of normals with equal gaps the one with the largest rate counts
//! ```
//!
//! A body that slides flush over an edge passes. Of two cards that lean on each other, mirror images, each moves as one that leans on a smooth wall: the
//! force between them has no part along the wall.

use crate::scene_files::{link, report, written};
use catena::prelude::*;
use nalgebra::{Rotation3, Vector3};

/// Where the origin of turned scenes is (m).
const BESIDE: Vector3<f64> = Vector3::new(0.01, -0.02, 0.0);

/// Two boxes, turned about the vertical: one of 0.1 m, whose lower front edge lies on the edge of the other, over which it slides at 1 m/s.
fn box_at_an_edge(turn: &Rotation3<f64>) -> String {
    let along = turn * Vector3::x();
    format!(
        "[contact]\nfriction = 0.4\n\
         [[body]]\nname = \"box\"\nshape = {{ type = \"box\", size = [0.1, 0.1, 0.1] }}\nmass = 1\n{}\n\
         velocity = {{ linear = [{:?}, {:?}, {:?}] }}\n{}",
        pose(turn, [-0.05, 0.0, 0.15]),
        along.x,
        along.y,
        along.z,
        slab("slab", turn, 0.2)
    )
}

/// A slab that lies on the floor, with its centre at this x before the turn.
fn slab(name: &str, turn: &Rotation3<f64>, x: f64) -> String {
    let size = "size = [0.4, 0.3, 0.1]";
    let pose = pose(turn, [x, 0.0, 0.05]);
    format!("[[body]]\nname = \"{name}\"\nshape = {{ type = \"box\", {size} }}\nmass = 4\n{pose}\n")
}

/// A pose that is turned about the vertical, beside the origin.
fn pose(turn: &Rotation3<f64>, at: [f64; 3]) -> String {
    let (roll, pitch, yaw) = turn.euler_angles();
    let at = turn * Vector3::from(at) + BESIDE;
    format!("pose = {{ position = [{:?}, {:?}, {:?}], rpy = [{roll:?}, {pitch:?}, {yaw:?}] }}", at.x, at.y, at.z)
}

#[test]
fn a_box_that_starts_at_an_edge_without_gravity_passes_in_steps_over_events() {
    let (duration, step) = (0.05, 2e-3);
    for number in 0..12 {
        let turn = Rotation3::from_euler_angles(0.0, 0.0, 0.55 * f64::from(number));
        let file =
            written(&format!("edges_free_{number}"), &(box_at_an_edge(&turn) + "[scene]\ngravity = [0, 0, 0]\n"));
        let model = Model::load(&file).expect("a scene");
        let mut simulation = Simulation::new(&model).fixed(1, step).duration(duration);
        simulation.run().expect("a run");
        let ended = simulation.finish().expect("a report");
        let moved = Vector3::from(link(&ended, "box").position) - turn * Vector3::new(-0.05, 0.0, 0.15) - BESIDE;
        let off = (moved - turn * Vector3::x() * duration).norm();
        // Roundings of 25 steps. Where it meets the edge it loses 0.19 J and is 2 cm off.
        assert!(off <= 1e-12, "turned {number}: {off:e} m off its way");
        assert!(ended.energy.impacts.abs() <= 1e-12, "turned {number}: {:e} J", ended.energy.impacts);
    }
}

#[test]
fn a_box_that_starts_on_the_seam_of_two_slabs_slides_on() {
    // It slows down by friction: s = v t − μ g t²/2; the slabs stick to the floor, whose friction holds 36 N.
    let (duration, friction): (f64, f64) = (0.15, 0.4);
    let way = duration - 0.5 * friction * 9.81 * duration * duration;
    for number in 0..6 {
        let turn = Rotation3::from_euler_angles(0.0, 0.0, 1.1 * f64::from(number));
        // Another slab, flush with the first.
        let floor = "[[obstacle]]\nname = \"floor\"\nshape = { type = \"half_space\" }\n";
        let scene = box_at_an_edge(&turn) + &slab("beside", &turn, -0.2) + floor;
        let file = written(&format!("edges_seam_{number}"), &scene);
        let ended = report(&file, &[], &[], Some(duration), 1e-6);
        let moved = Vector3::from(link(&ended, "box").position) - turn * Vector3::new(-0.05, 0.0, 0.15) - BESIDE;
        let off = (moved - turn * Vector3::x() * way).norm();
        // Ten tolerances.
        assert!(off <= 1e-5, "turned {number}: {off:e} m off its way");
        assert!(ended.energy.impacts.abs() <= 1e-9, "turned {number}: {:e} J", ended.energy.impacts);
    }
}

/// A card of this thickness, width and height (m) that leans with its upper edge over x = 0, on the side of positive x if `side` is 1.
fn card(name: &str, side: f64, tilt: f64, [thick, wide, high]: [f64; 3]) -> String {
    let (sine, cosine) = tilt.to_radians().sin_cos();
    let x = 0.5 * (thick * cosine + high * sine);
    let z = 0.5 * (thick * sine + high * cosine);
    format!(
        "[[body]]\nname = \"{name}\"\nshape = {{ type = \"box\", size = [{thick:?}, {wide:?}, {high:?}] }}\nmass = 0.5\n\
         pose = {{ position = [{:?}, 0, {z:?}], rpy = [0, \"{:?} deg\", 0] }}\n",
        side * x,
        -side * tilt
    )
}

#[test]
fn two_cards_that_lean_on_each_other_slide_as_one_at_a_smooth_wall() {
    for (number, (tilt, size, floor, between)) in
        [(17.0, [0.02, 0.6, 0.6], 0.1, 0.5), (14.0, [0.01, 0.3, 0.5], 0.05, 0.8), (25.0, [0.03, 0.2, 0.4], 0.15, 1.0)]
            .into_iter()
            .enumerate()
    {
        let ground = format!(
            "[contact]\nfriction = {between:?}\n[[obstacle]]\nname = \"floor\"\nshape = {{ type = \"half_space\" }}\nfriction = {floor:?}\n"
        );
        let wall =
            "[[obstacle]]\nname = \"wall\"\nshape = { type = \"half_space\", normal = [1, 0, 0] }\nfriction = 0\n";
        let alone = ground.clone() + &card("right", 1.0, tilt, size) + wall;
        let both = ground + &card("right", 1.0, tilt, size) + &card("left", -1.0, tilt, size);
        let run = |name: &str, text: &str| report(&written(name, text), &[], &[], Some(0.3), 1e-6);
        let alone = run(&format!("edges_wall_{number}"), &alone);
        let both = run(&format!("edges_cards_{number}"), &both);
        let right = link(&alone, "right");
        assert!(right.linear_velocity[0] > 0.05, "it slides: {:?}", right.linear_velocity);
        for (name, mirror) in [("right", 1.0), ("left", -1.0)] {
            let found = link(&both, name);
            let off = Vector3::from(found.position)
                - Vector3::from(right.position).component_mul(&Vector3::new(mirror, 1.0, 1.0));
            // Ten tolerances.
            assert!(off.norm() <= 1e-5, "cards {number}: {name} is {:e} m off", off.norm());
            let [w, x, y, z] = found.orientation;
            let wanted = [right.orientation[0], 0.0, mirror * right.orientation[2], 0.0];
            let turned = [w, x, y, z].iter().zip(wanted).map(|(one, other)| (one - other).abs()).fold(0.0, f64::max);
            assert!(turned <= 1e-5, "cards {number}: {name} is turned by {turned:e}");
        }
        assert!(both.warnings.is_empty(), "cards {number}: {:?}", both.warnings);
    }
}
