//! Accelerations are those of the dense mass matrix, and reactions those of Newton and Euler, for every kind of joint.

use super::{GRAVITY, body, chain};
use crate::common::Numbers;
use crate::models::turned_frame;
use catena::mechanism::description::body_state::WORLD;
use catena::mechanism::description::joint::{FreeRotation, JointKind, Pose};
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::energy::momentum;
use catena::mechanism::motion::kinematics::{body_states, forward_kinematics};
use catena::mechanism::motion::state::State;
use catena::reduced::{ArticulatedBody, joint_reactions};
use nalgebra::{DMatrix, DVector, Vector3};

fn vector(numbers: &mut Numbers) -> Vector3<f64> {
    Vector3::from_fn(|_, _| numbers.next(-1.0, 1.0))
}

fn pose(numbers: &mut Numbers) -> Pose {
    let place = vector(numbers);
    turned_frame(place, 2.0 * vector(numbers))
}

/// A tree with oblique joint frames: `kinds` gives the parent, the joint and whether the body has mass.
fn oblique_tree(kinds: &[(Option<usize>, JointKind, bool)]) -> Mechanism {
    let mut numbers = Numbers::new(7);
    let bodies = kinds.iter().enumerate().map(|(index, &(parent, kind, massive))| {
        let size = if massive { 1.0 } else { 0.0 };
        let mass = size * (1.2 + numbers.next(-1.0, 1.0));
        let inertia = size * vector(&mut numbers).map(|value| 0.4 + 0.1 * value);
        body(index, parent, mass, inertia.into(), (kind, pose(&mut numbers), pose(&mut numbers)))
    });
    Mechanism::new("oblique tree", Vector3::new(0.3, -1.0, -9.7), bodies.collect()).expect("depth first")
}

fn scattered_state(mechanism: &Mechanism) -> State {
    let mut numbers = Numbers::new(11);
    let mut state = State::zero(mechanism);
    let increment: Vec<f64> = (0..mechanism.velocity_count).map(|_| numbers.next(-1.0, 1.0)).collect();
    state.displace(mechanism, &increment);
    state.velocity.iter_mut().for_each(|rate| *rate = 2.0 * numbers.next(-1.0, 1.0));
    state
}

/// Every joint kind on the world, and a branching tree with every kind inside, one body of it without mass.
fn every_kind() -> Vec<Mechanism> {
    use JointKind::{Floating, Planar, Prismatic, Revolute, Spherical};
    let mut mechanisms: Vec<Mechanism> = [Revolute, Prismatic, Planar, Spherical, Floating]
        .iter()
        .map(|&kind| oblique_tree(&[(None, kind, true), (Some(0), Revolute, true)]))
        .collect();
    mechanisms.push(oblique_tree(&[
        (None, Floating, true),
        (Some(0), Revolute, true),
        (Some(1), Spherical, true),
        (Some(1), Revolute, false),
        (Some(3), Planar, true),
        (Some(4), Prismatic, true),
        (Some(3), Revolute, true),
        (Some(0), Prismatic, true),
        (Some(7), Floating, true),
        (None, Revolute, true),
        (Some(9), Revolute, true),
        (Some(9), Spherical, true),
    ]));
    mechanisms
}

fn accelerations(mechanism: &Mechanism, state: &State, joint_force: Option<&[f64]>) -> Vec<f64> {
    let mut acceleration = vec![0.0; mechanism.velocity_count];
    ArticulatedBody::new(mechanism).accelerations(&state.position, &state.velocity, joint_force, &mut acceleration);
    acceleration
}

/// The joint forces for given joint accelerations: each joint's reaction on its own free directions.
fn joint_forces(mechanism: &Mechanism, state: &State, acceleration: &[f64]) -> Vec<f64> {
    let reactions = joint_reactions(mechanism, &state.position, &state.velocity, acceleration);
    let bodies = body_states(mechanism, state);
    let mut forces = Vec::new();
    for (index, (body, reaction)) in mechanism.bodies.iter().zip(reactions).enumerate() {
        let parent = body.parent.map_or(WORLD, |parent| bodies[parent]);
        let on_parent = parent.rotation * body.joint.on_parent.rotation.matrix();
        let on_child = bodies[index].rotation * body.joint.on_child.rotation.matrix();
        forces
            .extend(body.joint.kind.translation_axes().iter().map(|&axis| on_parent.column(axis).dot(&reaction.force)));
        let turns = match body.joint.kind.rotation() {
            FreeRotation::None => 0..0,
            FreeRotation::AboutZ => 2..3,
            FreeRotation::Ball => 0..3,
        };
        forces.extend(turns.map(|axis| on_child.column(axis).dot(&reaction.torque)));
    }
    forces
}

/// M(q) = Σ m Jᵀ J + Jωᵀ R J Rᵀ Jω with Jacobians column by column: the bodies' velocities at unit joint velocities.
fn mass_matrix(mechanism: &Mechanism, state: &State) -> DMatrix<f64> {
    let (count, degrees) = (mechanism.bodies.len(), mechanism.velocity_count);
    let mut root_mass_jacobian = DMatrix::zeros(6 * count, degrees);
    let mut bodies = vec![WORLD; count];
    for column in 0..degrees {
        let mut unit = vec![0.0; degrees];
        unit[column] = 1.0;
        forward_kinematics(mechanism, &state.position, &unit, &mut bodies);
        for (index, (body, moving)) in mechanism.bodies.iter().zip(&bodies).enumerate() {
            let spin = moving.rotation.transpose() * moving.angular_velocity;
            for axis in 0..3 {
                root_mass_jacobian[(6 * index + axis, column)] = body.mass.sqrt() * moving.velocity[axis];
                root_mass_jacobian[(6 * index + 3 + axis, column)] = body.inertia[axis].sqrt() * spin[axis];
            }
        }
    }
    root_mass_jacobian.transpose() * root_mass_jacobian
}

#[test]
fn accelerations_equal_the_dense_mass_matrix_solution_for_every_joint_kind() {
    for mechanism in every_kind() {
        let state = scattered_state(&mechanism);
        let mut numbers = Numbers::new(23);
        let applied: Vec<f64> = (0..mechanism.velocity_count).map(|_| 5.0 * numbers.next(-1.0, 1.0)).collect();
        let nothing = vec![0.0; mechanism.velocity_count];
        let bias = DVector::from_vec(joint_forces(&mechanism, &state, &nothing));
        let mass = mass_matrix(&mechanism, &state);
        for force in [None, Some(&applied[..])] {
            let pushed = DVector::from_row_slice(force.unwrap_or(&nothing)) - &bias;
            let expected = mass.clone().cholesky().expect("positive definite").solve(&pushed);
            let found = DVector::from_vec(accelerations(&mechanism, &state, force));
            // Both lose a few digits to the condition of M, below 1e3 in these trees.
            let error = (&found - &expected).amax() / expected.amax();
            assert!(error < 1e-12, "{}: {error:e}", mechanism.bodies[0].joint.kind.name());
        }
    }
}

#[test]
fn reactions_leave_the_free_directions_free() {
    for mechanism in every_kind() {
        let state = scattered_state(&mechanism);
        let acceleration = accelerations(&mechanism, &state, None);
        let largest = joint_forces(&mechanism, &state, &acceleration).iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        // The reactions themselves are tens of newtons: this is their rounding.
        assert!(largest < 1e-11, "{largest:e}");
    }
}

#[test]
fn reactions_change_the_momentum_as_newton_and_euler_say() {
    for mechanism in every_kind() {
        let state = scattered_state(&mechanism);
        let acceleration = accelerations(&mechanism, &state, None);
        // Momentum about the world origin a time δ away on the parabola of the motion, whose error is of order δ³.
        let later = |delta: f64| {
            let mut moved = state.clone();
            let rates = state.velocity.iter().zip(&acceleration);
            let increment: Vec<f64> = rates.map(|(v, a)| delta * v + 0.5 * delta * delta * a).collect();
            moved.displace(&mechanism, &increment);
            moved.velocity.iter_mut().zip(&acceleration).for_each(|(v, a)| *v += delta * a);
            momentum(&mechanism, &body_states(&mechanism, &moved))
        };
        let rate = |delta: f64| {
            let (after, before) = (later(delta), later(-delta));
            ((after.0 - before.0) / (2.0 * delta), (after.1 - before.1) / (2.0 * delta))
        };
        let (coarse, fine) = (rate(2e-3), rate(1e-3));
        let linear = (4.0 * fine.0 - coarse.0) / 3.0;
        let angular = (4.0 * fine.1 - coarse.1) / 3.0;
        let bodies = body_states(&mechanism, &state);
        let (mut force, mut torque) = (mechanism.gravity * mechanism.total_mass(), Vector3::zeros());
        for (body, moving) in mechanism.bodies.iter().zip(&bodies) {
            torque += moving.position.cross(&(mechanism.gravity * body.mass));
        }
        let reactions = joint_reactions(&mechanism, &state.position, &state.velocity, &acceleration);
        for (_, reaction) in mechanism.bodies.iter().zip(&reactions).filter(|(body, _)| body.parent.is_none()) {
            force += reaction.force;
            torque += reaction.torque + reaction.anchor.cross(&reaction.force);
        }
        // Extrapolated central differences: fourth order in 1e-3 with fifth derivatives of some 1e4 N s⁻⁴.
        assert!((linear - force).amax() < 1e-6, "force {:e}", (linear - force).amax());
        assert!((angular - torque).amax() < 1e-6, "torque {:e}", (angular - torque).amax());
    }
}

#[test]
fn a_chain_hanging_at_rest_carries_the_weight_below_each_joint() {
    let mechanism = chain(5, 2.0, 0.3, [0.01, 0.01, 0.001], |_| [1.0, 0.0, 0.0]);
    let state = State::zero(&mechanism);
    let acceleration = accelerations(&mechanism, &state, None);
    assert!(acceleration.iter().all(|value| value.abs() < 1e-13), "it is in equilibrium: {acceleration:?}");
    for (index, reaction) in
        joint_reactions(&mechanism, &state.position, &state.velocity, &acceleration).iter().enumerate()
    {
        let weight = 2.0 * (5 - index) as f64 * GRAVITY;
        assert!((reaction.force - Vector3::new(0.0, 0.0, weight)).amax() < 1e-12, "joint {index}: {reaction:?}");
        assert!(reaction.torque.amax() < 1e-12, "joint {index}: {reaction:?}");
        assert!((reaction.anchor.z + 0.3 * index as f64).abs() < 1e-14, "joint {index}: {reaction:?}");
    }
}
