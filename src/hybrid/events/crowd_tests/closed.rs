//! Trees that closures join have the rates and the energy of the mechanism.

use super::{Numbers, put};
use crate::crowd::tree::Tree;
use crate::crowd::trees::Trees;
use crate::instant::dynamics::mass_matrix::mass_matrix;
use crate::mechanism::description::closure::{Attachment, Coordinate, LoopJoint, LoopKind, Mimic};
use crate::mechanism::description::joint::{Joint, JointKind, Pose};
use crate::mechanism::description::mechanism::{Body, Mechanism};
use crate::mechanism::motion::gaps::{loop_gaps, mimic_gap};
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use nalgebra::{Translation3, Vector3};

#[test]
fn independent_rates_of_trees_that_closures_join_give_rates_on_all_closures_with_the_energy_of_the_mechanism() {
    let arm = |parent: Option<usize>, kind: JointKind| {
        let turn = nalgebra::Rotation3::from_euler_angles(0.4, 0.2, 0.7);
        let frame = Pose::from_parts(Translation3::new(0.3, 0.1, -0.2), turn);
        let joint = Joint { armature: 0.0, ..Joint::new("joint", kind, frame, frame.inverse()) };
        Body { name: "link".into(), parent, mass: 1.5, inertia: Vector3::new(0.1, 0.2, 0.25), joint }
    };
    // A floating arm with two joints of which one follows, another tree that a ball joint closes on it, and a third that is free.
    let bodies = vec![
        arm(None, JointKind::Floating),
        arm(Some(0), JointKind::Revolute),
        arm(Some(1), JointKind::Prismatic),
        arm(None, JointKind::Spherical),
        arm(Some(3), JointKind::Revolute),
        arm(None, JointKind::Revolute),
    ];
    let mut mechanism = Mechanism::new("arms", Vector3::zeros(), bodies).expect("trees");
    let own = |body: usize| {
        let joint = &mechanism.bodies[body].joint;
        Coordinate { body, position: joint.position_index, freedom: joint.velocity_index }
    };
    let (follower, leader) = (own(2), own(1));
    let follows = Mimic {
        name: "slide".into(),
        follower,
        leader,
        multiplier: 0.3,
        offset: 0.1,
        more: Vec::new(),
        over_time: None,
    };
    mechanism.mimics.push(follows);
    let end =
        |body: usize, at: [f64; 3]| Attachment { body: Some(body), frame: Pose::translation(at[0], at[1], at[2]) };
    let (a, b) = (end(2, [0.1, 0.0, 0.2]), end(4, [-0.2, 0.3, 0.0]));
    mechanism.loops.push(LoopJoint { name: "ball".into(), kind: LoopKind::Spherical, a, b });
    let mut state = State::zero(&mechanism);
    put(&mut state, 0, [0.1, 0.2, 0.3], [0.5, -0.4, 0.3]);
    state.position[7] = 0.4;
    state.position[8] = 0.1 + 0.3 * 0.4;
    let mut trees = Trees::new(&mechanism);
    let mut bodies = body_states(&mechanism, &state);
    trees.choose(&mechanism, &bodies);
    assert!(trees.close(&mechanism, &mut state, &mut bodies));
    let (gap, _) = loop_gaps(&mechanism.loops[0], &bodies).largest();
    assert!(gap < 1e-14, "{gap:e}");
    // The relation of the follower is one of the equations that are closed.
    assert!(mimic_gap(&mechanism.mimics[0], &state).0.abs() < 1e-14);
    trees.choose(&mechanism, &bodies);
    let sizes: Vec<[usize; 2]> = trees.trees.iter().map(|tree| [tree.freedoms.len(), tree.all.len()]).collect();
    // Twelve freedoms with four equations, and one.
    assert_eq!(sizes, [[8, 12], [1, 1]]);
    let mut numbers = Numbers(4);
    for tree in &trees.trees {
        tree.freedoms.iter().for_each(|&freedom| state.velocity[freedom] = numbers.next());
    }
    trees.complete(&mut state.velocity);
    let (_, rate) = loop_gaps(&mechanism.loops[0], &body_states(&mechanism, &state)).largest();
    assert!(rate < 1e-14 && mimic_gap(&mechanism.mimics[0], &state).1.abs() < 1e-14, "{rate:e}");
    let rates = nalgebra::DVector::from_column_slice(&state.velocity);
    let expected = 0.5 * rates.dot(&(mass_matrix(&mechanism, &state) * &rates));
    let of_tree = |tree: &Tree| {
        let own: Vec<f64> = tree.freedoms.iter().map(|&freedom| state.velocity[freedom]).collect();
        let mut momenta = vec![0.0; own.len()];
        tree.add_mass(&own, &mut momenta);
        0.5 * own.iter().zip(&momenta).map(|(rate, momentum)| rate * momentum).sum::<f64>()
    };
    let energy: f64 = trees.trees.iter().map(of_tree).sum();
    assert!((energy - expected).abs() < 1e-13 * expected, "{energy} {expected}");
}
