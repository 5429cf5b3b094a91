//! The sparse algebra of loops: fronts that stay small, and projections that equal dense ones.

use super::frame;
use crate::{closed, common};
use catena::lobatto::coupled::projection::Projection;
use catena::lobatto::plan::elimination::Elimination;
use catena::lobatto::stages::start::Start;
use catena::mechanism::description::closure::{Attachment, LoopJoint, LoopKind};
use catena::mechanism::description::joint::{Joint, JointKind};
use catena::mechanism::description::mechanism::{Body, Mechanism};
use catena::mechanism::motion::gaps::loop_gaps;
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use nalgebra::{DMatrix, DVector, Vector3};

#[test]
fn the_fronts_of_ladders_do_not_grow_with_their_length() {
    let slots =
        |count, width, rows| Elimination::new(&closed::four_bars(count, 5).0, width, &vec![rows; count], false).slots;
    // The twist, and the equations of two neighbouring loops.
    assert_eq!([10, 100, 1000].map(|count| slots(count, 6, 5)), [16; 3]);
    assert_eq!([10, 100, 1000].map(|count| slots(count, 3, 2)), [7; 3], "in the plane");
}

/// Two arms of ball and planar joints on a floating body, joined at their hands by a universal joint.
fn floating_ring() -> (Mechanism, State) {
    let mut numbers = common::Numbers::new(11);
    let mut place = || Vector3::new(numbers.next(-0.6, 0.6), numbers.next(-0.6, 0.6), numbers.next(-0.6, 0.6));
    let kinds = [
        (None, JointKind::Floating),
        (Some(0), JointKind::Spherical),
        (Some(1), JointKind::Planar),
        (Some(0), JointKind::Revolute),
        (Some(3), JointKind::Prismatic),
    ];
    let bodies = kinds.map(|(parent, kind)| {
        let (on_parent, on_child) = (frame(place(), place()), frame(place(), place()));
        let joint = Joint::new("joint", kind, on_parent, on_child);
        Body { name: "body".into(), parent, mass: 1.3, inertia: Vector3::new(0.05, 0.08, 0.1), joint }
    });
    let mut mechanism = Mechanism::new("ring", Vector3::zeros(), bodies.to_vec()).unwrap();
    for (name, kind, a, b) in [("hands", LoopKind::Universal, 2, Some(4)), ("rope", LoopKind::Distance(1.1), 1, None)] {
        let (a, b) = (
            Attachment { body: Some(a), frame: frame(place(), place()) },
            Attachment { body: b, frame: frame(place(), place()) },
        );
        mechanism.loops.push(LoopJoint { name: name.into(), kind, a, b });
    }
    let mut state = State::zero(&mechanism);
    let push: Vec<f64> = (0..mechanism.velocity_count).map(|freedom| 0.3 * (freedom as f64 + 0.5).sin()).collect();
    state.displace(&mechanism, &push);
    state.velocity.copy_from_slice(&push);
    (mechanism, state)
}

#[test]
fn the_sparse_projection_of_velocities_equals_the_dense_one() {
    for (mechanism, state) in [closed::four_bars(3, 5), closed::bricard(), floating_ring()] {
        let count = mechanism.velocity_count;
        let wanted: Vec<f64> = (0..count).map(|freedom| (2.3 * freedom as f64 + 0.7).cos()).collect();
        let mut unit = state.clone();
        let mut of_unit = |freedom: usize| {
            unit.velocity.fill(0.0);
            unit.velocity[freedom] = 1.0;
            body_states(&mechanism, &unit)
        };
        let moved: Vec<_> = (0..count).map(&mut of_unit).collect();
        let mass = DMatrix::from_fn(count, count, |i, j| {
            let pairs = moved[i].iter().zip(&moved[j]);
            mechanism.bodies.iter().zip(pairs).fold(0.0, |sum, (body, (one, other))| {
                let turn = one.rotation.transpose();
                let spins =
                    (turn * one.angular_velocity).dot(&(turn * other.angular_velocity).component_mul(&body.inertia));
                sum + body.mass * one.velocity.dot(&other.velocity) + spins
            })
        });
        let rates = |bodies: &[catena::mechanism::description::body_state::BodyState]| -> Vec<f64> {
            let gaps = mechanism.loops.iter().map(|joint| loop_gaps(joint, bodies));
            gaps.flat_map(|gaps| gaps.velocity[..gaps.count].to_vec()).collect()
        };
        let columns: Vec<Vec<f64>> = moved.iter().map(|bodies| rates(bodies)).collect();
        let gradient = DMatrix::from_fn(columns[0].len(), count, |row, freedom| columns[freedom][row]);
        let inverse = mass.cholesky().unwrap().inverse();
        let mobility = &gradient * &inverse * gradient.transpose();
        let start_velocity = DVector::from_column_slice(&wanted);
        let multipliers = mobility.pseudo_inverse(1e-9).unwrap() * (&gradient * &start_velocity);
        let dense = &start_velocity - &inverse * gradient.transpose() * multipliers;

        let mut projection = Projection::new(&mechanism);
        let mut start = Start::new(&mechanism);
        start.set(&mechanism, &state);
        let mut sparse = wanted.clone();
        projection.velocities(&mechanism, &start, &mut sparse);
        let apart = sparse.iter().zip(dense.iter()).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
        // The condition of the mass matrices is below 1e4.
        assert!(apart < 1e-11, "{}: {apart:e}", mechanism.name);
    }
}
