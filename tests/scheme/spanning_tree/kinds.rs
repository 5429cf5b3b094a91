//! Joints of all kinds, cut, hung on and turned round.

use super::{apart, end, random_tree};
use crate::common;
use catena::mechanism::description::closure::{Attachment, LoopJoint, LoopKind};
use catena::mechanism::description::forces::JointDamper;
use catena::mechanism::description::joint::{Joint, JointKind, Pose};
use catena::mechanism::description::mechanism::{Body, Mechanism};
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use catena::mechanism::structure::other_tree::OtherTree;
use catena::mechanism::structure::spanning_tree::{Edge, Graph};
use nalgebra::{Rotation3, Translation3, Vector3};

/// A tree with joints of all kinds in space, whose ends are joined by loop joints of all kinds that can carry bodies; some of their axes point
/// opposite ways.
fn all_kinds(numbers: &mut common::Numbers) -> (Mechanism, State) {
    use JointKind::{Floating, Planar, Prismatic, Revolute, Spherical};
    let mut pose = || {
        let mut three = |size: f64| [(); 3].map(|()| numbers.next(-size, size));
        let ([x, y, z], [a, b, c]) = (three(0.5), three(2.0));
        Pose::from_parts(Translation3::new(x, y, z), Rotation3::from_euler_angles(a, b, c))
    };
    let above = [None, Some(0), Some(1), Some(2), Some(1), Some(4), Some(5), None, Some(7), Some(8), Some(9)];
    let kinds = [
        Floating, Spherical, Revolute, Spherical, Planar, Revolute, Spherical, Spherical, Prismatic, Planar, Spherical,
    ];
    let bodies = above.iter().zip(kinds).enumerate().map(|(index, (&parent, kind))| Body {
        name: format!("body{index}"),
        parent,
        mass: 0.8 + 0.1 * index as f64,
        inertia: Vector3::new(0.05, 0.08, 0.1),
        joint: Joint::new(&format!("joint{index}"), kind, pose(), pose()),
    });
    let mut mechanism = Mechanism::new("all kinds", Vector3::new(0.0, 0.0, -9.81), bodies.collect()).unwrap();
    let mut state = State::zero(&mechanism);
    let push: Vec<f64> = (0..mechanism.velocity_count).map(|freedom| 0.4 * (freedom as f64 + 0.5).sin()).collect();
    state.displace(&mechanism, &push);
    let placed = body_states(&mechanism, &state);
    let ends = [
        (3, Some(6), LoopKind::Spherical),
        (6, Some(10), LoopKind::Revolute),
        (3, None, LoopKind::Planar),
        (10, Some(0), LoopKind::Prismatic),
    ];
    for (number, (a, b, kind)) in ends.into_iter().enumerate() {
        let there = pose();
        let fixed = |body: Option<usize>, frame: &Pose| {
            let on = body.map_or(Pose::identity(), |body: usize| {
                let turn = Rotation3::from_matrix_unchecked(placed[body].rotation);
                Pose::from_parts(Translation3::from(placed[body].position), turn)
            });
            Attachment { body, frame: on.inv_mul(frame) }
        };
        let half = Rotation3::from_axis_angle(&Vector3::y_axis(), std::f64::consts::PI);
        let opposite = if number % 2 == 1 { Pose::from_parts(there.translation, there.rotation * half) } else { there };
        let (a, b) = (fixed(Some(a), &there), fixed(b, &opposite));
        mechanism.loops.push(LoopJoint { name: format!("loop{number}"), kind, a, b });
    }
    (mechanism, state)
}

#[test]
fn joints_of_all_kinds_are_cut_hung_on_and_turned_round_without_a_trace_in_the_motion() {
    let mut numbers = common::Numbers::new(7);
    let (mechanism, start) = all_kinds(&mut numbers);
    let expected = end(&mechanism, &start, 0.01, 0.2);
    let (mut cut, mut turned) = (vec![0; mechanism.bodies.len()], vec![0; mechanism.bodies.len()]);
    let mut hung = vec![0; mechanism.loops.len()];
    for _ in 0..40 {
        let tree = random_tree(&mechanism, None, &mut numbers);
        tree.cut_joints().for_each(|body| cut[body] += 1);
        tree.hung_loops().for_each(|index| hung[index] += 1);
        for hang in tree.hangs.iter().filter(|hang| hang.backwards) {
            if let Edge::Tree(of) = hang.by {
                turned[of] += 1;
            }
        }
        let mut other = OtherTree::new(&mechanism, &tree, None, &start).expect("depth first");
        let mut own = State::zero(&other.mechanism);
        other.take(&mechanism, &start, &mut own);
        let begin = apart((&mechanism, &start), (&other.mechanism, &own));
        assert!(begin < 1e-13, "{begin:e} off at the start on {tree:?}");
        let own = end(&other.mechanism, &own, 0.01, 0.2);
        let off = apart((&mechanism, &expected), (&other.mechanism, &own));
        // Twenty steps solved to rounding.
        assert!(off < 1e-10, "{off:e} m apart on {tree:?}");
        let mut back = start.clone();
        other.give(&mechanism, &own, &mut back);
        let back = body_states(&mechanism, &back).into_iter().zip(body_states(&mechanism, &expected));
        let off = back.map(|(a, b)| (a.position - b.position).norm().max((a.velocity - b.velocity).norm()));
        let off = off.fold(0.0, f64::max);
        assert!(off < 1e-10, "{off:e} off in the coordinates of the file");
    }
    // All but the floating base, which stays.
    assert!(cut[0] == 0 && hung.iter().all(|&times| times > 0), "{cut:?} {hung:?}");
    for kind in [JointKind::Revolute, JointKind::Prismatic, JointKind::Planar, JointKind::Spherical] {
        let of_kind = |times: &[usize]| -> usize {
            let bodies = mechanism.bodies.iter().zip(times).filter(|(body, _)| body.joint.kind == kind);
            bodies.map(|(_, times)| times).sum()
        };
        assert!(of_kind(&cut) > 0 && of_kind(&turned) > 0, "{kind:?} {cut:?} {turned:?}");
    }
}

#[test]
fn joints_with_coordinates_of_their_own_on_either_end_are_not_turned_round_where_something_acts_along_them() {
    let mut numbers = common::Numbers::new(11);
    let (mut mechanism, start) = all_kinds(&mut numbers);
    // The second ball, about one of its axes more than about the others.
    let ball = mechanism.bodies[3].joint.velocity_index;
    for axis in 0..3 {
        let coefficient = 0.1 + 0.3 * axis as f64;
        mechanism.forces.joint_dampers.push(JointDamper { freedom: ball + axis, coefficient });
    }
    let graph = Graph::new(&mechanism, None);
    let expected = end(&mechanism, &start, 0.01, 0.1);
    let (mut refused, mut taken) = (0, 0);
    for _ in 0..30 {
        let tree = random_tree(&mechanism, None, &mut numbers);
        if graph.turns(&mechanism, &tree) {
            refused += 1;
            continue;
        }
        taken += 1;
        let mut other = OtherTree::new(&mechanism, &tree, None, &start).expect("depth first");
        let mut own = State::zero(&other.mechanism);
        other.take(&mechanism, &start, &mut own);
        let own = end(&other.mechanism, &own, 0.01, 0.1);
        let off = apart((&mechanism, &expected), (&other.mechanism, &own));
        assert!(off < 1e-10, "{off:e} m apart on {tree:?}");
    }
    assert!(refused > 0 && taken > 3, "{refused} refused, {taken} taken");
}
