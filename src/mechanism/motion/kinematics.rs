//! Forward kinematics from joint coordinates to maximal coordinates: the poses and velocities of all bodies.
//!
//! ```text
//!     R = R_p F_p.R Rj F_c.Rᵀ                      a = x_p + R_p (F_p.t + F_p.R t)            x = a − R F_c.t
//!     ω = ω_p + R F_c.R w                          v = v_p + ω_p × (a − x_p) + R_p F_p.R u − ω × R F_c.t
//! ```
//!
//! with the joint's displacement `(t, Rj)`, translation rates `u` [m/s] and rotation rates `w` [rad/s]
//! ([`crate::description::joint`]); and their accelerations, with `r = a − x_p` and `c = a − x`:
//!
//! ```text
//!     ω̇ = ω̇_p + R F_c.R ẇ + ω_p × R F_c.R w
//!     ẍ = ẍ_p + ω̇_p × r + ω_p × (ω_p × r) + 2 ω_p × R_p F_p.R u + R_p F_p.R u̇ − ω̇ × c − ω × (ω × c)
//! ```

use crate::description::body_state::{BodyState, WORLD};
use crate::description::joint::{FreeRotation, Joint, JointKind};
use crate::description::mechanism::Mechanism;
use crate::ground::matrices::{column, cross, product, product_transposed, times};
use crate::motion::state::State;
use nalgebra::{Matrix3, Vector3};

/// Translation rates (in the joint frame on the parent) and rotation rates (in the joint frame on the child).
#[inline(always)]
pub fn joint_rates(joint: &Joint, velocity: &[f64]) -> (Vector3<f64>, Vector3<f64>) {
    let axes = joint.kind.translation_axes();
    let mut translation = Vector3::zeros();
    for (&axis, &value) in axes.iter().zip(velocity) {
        translation[axis] = value;
    }
    let turn = &velocity[axes.len()..];
    let rotation = match joint.kind.rotation() {
        FreeRotation::None => Vector3::zeros(),
        FreeRotation::AboutZ => Vector3::new(0.0, 0.0, turn[0]),
        FreeRotation::Ball => Vector3::new(turn[0], turn[1], turn[2]),
    };
    (translation, rotation)
}

/// A placed body, with intermediate results.
pub struct Placed {
    /// The body.
    pub body: BodyState,
    /// The joint frame on the parent, in the world: `R_p F_p.R`.
    pub frame: Matrix3<f64>,
    /// The joint's translation `t`, in that frame (m).
    pub translation: Vector3<f64>,
}

/// Places a body on its parent for the positions of its joint, their rounding errors (or an empty slice), and the velocities.
#[inline(always)]
pub fn place(joint: &Joint, parent: &BodyState, position: &[f64], rest: &[f64], velocity: &[f64]) -> Placed {
    let (translation, turn) = joint.displacement(position, rest);
    let (frame_on_parent, frame_on_child) = (joint.on_parent.rotation.matrix(), joint.on_child.rotation.matrix());
    let mut anchor = joint.on_parent.translation.vector;
    let mut sliding = Vector3::zeros();
    let turning = if joint.kind == JointKind::Revolute {
        column(frame_on_child, 2) * velocity[0]
    } else {
        let (translation_rate, turn_rate) = joint_rates(joint, velocity);
        anchor += times(frame_on_parent, &translation);
        sliding = times(&parent.rotation, &times(frame_on_parent, &translation_rate));
        times(frame_on_child, &turn_rate)
    };
    let arm_on_parent = times(&parent.rotation, &anchor);
    let frame = product(&parent.rotation, frame_on_parent);
    let rotation = product_transposed(&product(&frame, &turn), frame_on_child);
    let arm_on_child = times(&rotation, &joint.on_child.translation.vector);
    let angular_velocity = parent.angular_velocity + times(&rotation, &turning);
    let body = BodyState {
        position: parent.position + arm_on_parent - arm_on_child,
        rotation,
        velocity: parent.velocity + cross(&parent.angular_velocity, &arm_on_parent) + sliding
            - cross(&angular_velocity, &arm_on_child),
        angular_velocity,
    };
    Placed { body, frame, translation }
}

/// Poses and velocities of all bodies, written into `out` (one entry a body). Does not allocate.
#[inline]
pub fn forward_kinematics(mechanism: &Mechanism, position: &[f64], velocity: &[f64], out: &mut [BodyState]) {
    place_all(mechanism, position, None, velocity, out);
}

/// The same of a state, with all digits of its positions. Does not allocate.
#[inline]
pub fn place_bodies(mechanism: &Mechanism, state: &State, out: &mut [BodyState]) {
    place_all(mechanism, &state.position, Some(&state.compensation), &state.velocity, out);
}

/// The same of a state, in a new vector.
pub fn body_states(mechanism: &Mechanism, state: &State) -> Vec<BodyState> {
    let mut out = vec![WORLD; mechanism.bodies.len()];
    place_bodies(mechanism, state, &mut out);
    out
}

fn place_all(mechanism: &Mechanism, position: &[f64], rest: Option<&[f64]>, velocity: &[f64], out: &mut [BodyState]) {
    for (index, body) in mechanism.bodies.iter().enumerate() {
        let parent = body.parent.map_or(WORLD, |parent| out[parent]);
        let joint = &body.joint;
        let rest = rest.map_or(&[][..], |rest| &rest[joint.position_range()]);
        let (position, velocity) = (&position[joint.position_range()], &velocity[joint.velocity_range()]);
        out[index] = place(joint, &parent, position, rest, velocity).body;
    }
}

/// Linear acceleration of a body's centre of mass [m/s²] and its angular acceleration [rad/s²], in the world.
pub type BodyAcceleration = (Vector3<f64>, Vector3<f64>);

/// The accelerations of all bodies for the accelerations of the joints, written into `accelerations`. Does not allocate.
pub fn body_accelerations(
    mechanism: &Mechanism,
    bodies: &[BodyState],
    velocity: &[f64],
    acceleration: &[f64],
    accelerations: &mut [BodyAcceleration],
) {
    for (index, body) in mechanism.bodies.iter().enumerate() {
        let joint = &body.joint;
        let state = &bodies[index];
        let (parent, (parent_linear, parent_angular)) = match body.parent {
            Some(parent) => (&bodies[parent], accelerations[parent]),
            None => (&WORLD, Default::default()),
        };
        let (velocity, acceleration) = (&velocity[joint.velocity_range()], &acceleration[joint.velocity_range()]);
        let arm_on_child = times(&state.rotation, &joint.on_child.translation.vector);
        let arm_on_parent = state.position + arm_on_child - parent.position;
        let (turn, turn_rate) = if joint.kind == JointKind::Revolute {
            let axis = times(&state.rotation, &column(joint.on_child.rotation.matrix(), 2));
            (axis * velocity[0], axis * acceleration[0])
        } else {
            let frame_on_child = product(&state.rotation, joint.on_child.rotation.matrix());
            let in_world = |rates: &[f64]| times(&frame_on_child, &joint_rates(joint, rates).1);
            (in_world(velocity), in_world(acceleration))
        };
        let angular = parent_angular + turn_rate + cross(&parent.angular_velocity, &turn);
        let mut linear = parent_linear
            + cross(&parent_angular, &arm_on_parent)
            + cross(&parent.angular_velocity, &cross(&parent.angular_velocity, &arm_on_parent));
        if !joint.kind.translation_axes().is_empty() {
            let frame_on_parent = product(&parent.rotation, joint.on_parent.rotation.matrix());
            let in_world = |rates: &[f64]| times(&frame_on_parent, &joint_rates(joint, rates).0);
            linear = linear + 2.0 * cross(&parent.angular_velocity, &in_world(velocity)) + in_world(acceleration);
        }
        linear = linear
            - cross(&angular, &arm_on_child)
            - cross(&state.angular_velocity, &cross(&state.angular_velocity, &arm_on_child));
        accelerations[index] = (linear, angular);
    }
}
