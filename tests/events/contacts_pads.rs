//! Flat pads: a box that slips between two of them, and a foot that stands over the edge of a box. Their pressures press, and balance the load.

use crate::exact::near;
use crate::loose::{DOWN, cuboid, loose, meet, obstacle, put};
use crate::mechanisms::{GRAVITY, fixed, mechanism, motor, run, slide};
use catena::mechanism::description::contact::Collider;
use catena::mechanism::description::joint::{Joint, JointKind, Pose};
use catena::mechanism::description::mechanism::{Body, Mechanism};
use catena::mechanism::description::nonsmooth::MotorLaw;
use catena::mechanism::description::target::Target;
use catena::mechanism::motion::state::State;
use catena::simulation::StepChoice;
use nalgebra::Vector3;

/// Mass (kg) and half sizes (m) of the box, the force of each jaw (N), and how far from the middle a pad reaches up and across (m).
const MASS: f64 = 0.8;
const HALF: [f64; 3] = [0.05, 0.02, 0.15];
const FORCE: f64 = 10.0;
const PAD: [f64; 2] = [0.04, 0.03];

/// Two jaws that slide along x press on a box with these coefficients of friction.
fn gripper(frictions: [f64; 2]) -> Mechanism {
    let joint = Joint::new("box", JointKind::Floating, Pose::identity(), Pose::identity());
    let held =
        Body { name: "box".into(), parent: None, mass: MASS, inertia: Vector3::new(2e-3, 2.5e-3, 1.5e-3), joint };
    let jaws = [("left", Vector3::x()), ("right", -Vector3::x())].map(|(name, axis)| slide(name, axis, 0.3));
    let [left, right] = jaws;
    let mut gripper = mechanism(vec![left, right, held]);
    let pad = cuboid(0.01, PAD[1], PAD[0]);
    for (body, (place, shape)) in
        [(-HALF[0] - 0.01, pad.clone()), (HALF[0] + 0.01, pad), (0.0, cuboid(HALF[0], HALF[1], HALF[2]))]
            .into_iter()
            .enumerate()
    {
        let (name, pose) = (gripper.bodies[body].name.clone(), Pose::translation(place, 0.0, 0.0));
        gripper.nonsmooth.colliders.push(Collider::still(name, Some(body), pose, shape));
    }
    for (jaw, friction) in frictions.into_iter().enumerate() {
        meet(&mut gripper, jaw, 2, friction, 0.0);
        motor(&mut gripper, jaw, MotorLaw::Effort, Target::constant(FORCE), f64::INFINITY, 0.0);
    }
    gripper
}

#[test]
fn a_box_slips_down_between_two_pads_with_what_friction_lacks_and_every_corner_presses() {
    // What one coefficient for both would have to be.
    let holds = MASS * GRAVITY / (2.0 * FORCE);
    let (until, mut missed) = (0.2, Vec::new());
    for frictions in [[holds * 0.999; 2], [0.3; 2], [0.1; 2], [0.6, 0.1], [0.05, 0.7]] {
        let falls = GRAVITY - (frictions[0] + frictions[1]) * FORCE / MASS;
        for steps in [fixed(5, 0.01), fixed(9, 0.02), StepChoice::Tolerance(1e-9)] {
            let gripper = gripper(frictions);
            let done = run(&gripper, &State::zero(&gripper), until, steps);
            let (place, rate) = (&done.state.position[2..9], &done.state.velocity[2..8]);
            // A turn between the pads is held by friction alone, which is solved to 1e-8 of what presses.
            let turns = place[4..].iter().fold(0.0, |most: f64, part| most.max(part.abs()));
            let moved = [place[0], place[1], place[2] + 0.5 * falls * until * until];
            if moved.iter().any(|off| off.abs() > 1e-9) || (rate[2] + falls * until).abs() > 1e-9 || turns > 1e-8 {
                missed.push(format!("{frictions:?}, {steps:?}: {moved:?} m, {turns:e} rad"));
                continue;
            }
            let mut heights = [0.0; 2];
            for (jaw, friction) in frictions.into_iter().enumerate() {
                let points: Vec<_> = done.contacts.iter().filter(|point| point.pair == jaw).collect();
                assert_eq!(points.len(), 4, "{points:?}");
                let presses =
                    |point: &&catena::mechanism::motion::contact_point::ContactPoint| point.force.dot(&point.normal);
                assert!(
                    points.iter().all(|point| presses(point) >= 0.0 && point.cone_violation(friction) <= 1e-9),
                    "{points:?}"
                );
                near(points.iter().map(presses).sum(), FORCE, 1e-8);
                near(points.iter().map(|point| point.force.z).sum::<f64>().abs(), friction * FORCE, 1e-8);
                heights[jaw] = points.iter().map(|point| presses(point) * point.position.z).sum::<f64>() / FORCE;
            }
            // The pressures of both pads balance the moment of unequal friction: (z₁ − z₂) F = −(μ₁ − μ₂) F b.
            near(heights[0] - heights[1], -(frictions[0] - frictions[1]) * HALF[0], 1e-8);
        }
    }
    assert!(missed.is_empty(), "{}", missed.join("\n"));
    let gripper = gripper([holds * (1.0 + 1e-6); 2]);
    let start = State::zero(&gripper);
    assert_eq!(run(&gripper, &start, until, fixed(9, 0.02)).state.position, start.position);
}

#[test]
fn a_foot_over_the_edge_of_a_box_stands_while_its_centre_is_over_the_box_and_every_corner_presses() {
    let [length, width, height] = [0.1, 0.05, 0.02];
    for turned in [0.0, 0.4, 0.785, 1.3, 2.6] {
        // How far the centre of mass is inside of the edge, and beside the middle of the foot along and across it.
        for [inside, along, across] in
            [[1e-3, 0.06, 0.0], [1e-3, -0.06, 0.02], [1e-6, 0.0, 0.0], [0.02, 0.0, -0.03], [0.04, 0.05, 0.03]]
        {
            let mut mechanism = loose(DOWN, &[(2.0, cuboid(length, width, height))]);
            mechanism.nonsmooth.colliders[0].pose = Pose::translation(-along, -across, height - 0.1);
            let step = obstacle(&mut mechanism, cuboid(0.5, 0.5, 0.1), Vector3::new(-0.5, 0.0, -0.1));
            meet(&mut mechanism, step, 0, 0.5, 0.0);
            let mut start = State::zero(&mechanism);
            let (at, none) = (Vector3::new(-inside, 0.0, 0.1), Vector3::zeros());
            put(&mechanism, &mut start, 0, [at, Vector3::z() * turned, none, none]);
            let done = run(&mechanism, &start, 0.5, fixed(9, 0.05));
            assert_eq!(done.state.position, start.position, "{turned}, {inside}: {:?}", done.events);
            let load = 2.0 * GRAVITY;
            let press = |weight: &dyn Fn(Vector3<f64>) -> f64| -> f64 {
                done.contacts.iter().map(|point| point.force.dot(&point.normal).abs() * weight(point.position)).sum()
            };
            println!(
                "{turned}, {inside}, {along}: {:?}",
                done.contacts.iter().map(|point| point.force.dot(&point.normal)).collect::<Vec<_>>()
            );
            assert!(done.contacts.iter().all(|point| point.force.dot(&point.normal) >= 0.0), "{:?}", done.contacts);
            near(press(&|_| 1.0), load, 1e-9);
            near(press(&|place| place.x), -load * inside, 1e-9);
            near(press(&|place| place.y), 0.0, 1e-9);
        }
    }
}
