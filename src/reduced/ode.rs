//! The mechanism as a first-order system in joint coordinates.
//!
//! ```text
//!     y = (q, v)          q the joint positions [m, rad, -], v the joint velocities [m/s, rad/s]
//!     q̇ = v               for lengths and angles
//!     q̇ = ½ q ∘ (0, ω)    for quaternions, ω the child's angular velocity in its joint frame
//!     v̇ = q̈(q, v)         by the articulated-body algorithm
//! ```
//!
//! The quaternion equation keeps |q|, and the accelerations do not depend on it, so rounding and truncation errors in
//! |q| do no harm between the renormalisations at the ends of the steps.

use super::articulated_body::ArticulatedBody;
use crate::model::{FreeRotation, Mechanism};
use crate::state::{State, quaternion_product};
use std::ops::Range;

/// The right-hand side of the first-order system of one mechanism.
#[derive(Clone, Debug)]
pub struct ReducedOde {
    articulated: ArticulatedBody,
    position_count: usize,
    velocity_count: usize,
    /// Runs of positions whose rates are velocities: first position, first velocity, length.
    plain: Vec<(usize, usize, usize)>,
    /// First entries of each quaternion and of its angular velocity.
    quaternions: Vec<(usize, usize)>,
}

impl ReducedOde {
    /// Sets up the system.
    pub fn new(mechanism: &Mechanism) -> Self {
        let mut plain: Vec<(usize, usize, usize)> = Vec::new();
        let mut quaternions = Vec::new();
        for body in &mechanism.bodies {
            let joint = &body.joint;
            let (position, velocity) = (joint.position_index, joint.velocity_index);
            let ball = joint.kind.rotation() == FreeRotation::Ball;
            let scalars = joint.kind.velocity_count() - if ball { 3 } else { 0 };
            match plain.last_mut() {
                Some((p, v, length)) if *p + *length == position && *v + *length == velocity => *length += scalars,
                _ => plain.push((position, velocity, scalars)),
            }
            if ball {
                quaternions.push((position + scalars, velocity + scalars));
            }
        }
        ReducedOde {
            articulated: ArticulatedBody::new(mechanism),
            position_count: mechanism.position_count,
            velocity_count: mechanism.velocity_count,
            plain,
            quaternions,
        }
    }

    /// Length of y.
    pub fn dimension(&self) -> usize {
        self.position_count + self.velocity_count
    }

    /// The entries of y that are velocities.
    pub fn velocity_range(&self) -> Range<usize> {
        self.position_count..self.dimension()
    }

    /// Writes ẏ into `slope`. Does not allocate.
    pub fn derivative(&mut self, y: &[f64], slope: &mut [f64]) {
        let (position, velocity) = y.split_at(self.position_count);
        let (position_rate, acceleration) = slope.split_at_mut(self.position_count);
        for &(p, v, length) in &self.plain {
            position_rate[p..p + length].copy_from_slice(&velocity[v..v + length]);
        }
        for &(p, v) in &self.quaternions {
            let half = [0.0, 0.5 * velocity[v], 0.5 * velocity[v + 1], 0.5 * velocity[v + 2]];
            position_rate[p..p + 4].copy_from_slice(&quaternion_product(&position[p..p + 4], &half));
        }
        self.articulated.accelerations(position, velocity, None, acceleration);
    }

    /// The joint accelerations of a state, without the rest of ẏ.
    pub fn accelerations(&mut self, position: &[f64], velocity: &[f64], acceleration: &mut [f64]) {
        self.articulated.accelerations(position, velocity, None, acceleration);
    }

    /// Scales every quaternion in y (or in its positions alone) to unit length.
    pub fn normalise(&self, y: &mut [f64]) {
        for &(p, _) in &self.quaternions {
            let quaternion = &mut y[p..p + 4];
            let norm = quaternion.iter().map(|c| c * c).sum::<f64>().sqrt();
            quaternion.iter_mut().for_each(|c| *c /= norm);
        }
    }

    /// Copies a state into y. What rounding cut off the positions is added back as far as a number can hold it.
    pub fn load(&self, state: &State, y: &mut [f64]) {
        let (position, velocity) = y.split_at_mut(self.position_count);
        for ((entry, &value), &rest) in position.iter_mut().zip(&state.position).zip(&state.compensation) {
            *entry = value + rest;
        }
        velocity.copy_from_slice(&state.velocity);
    }

    /// Copies y into a state; the time is left alone.
    pub fn store(&self, y: &[f64], state: &mut State) {
        let (position, velocity) = y.split_at(self.position_count);
        state.position.copy_from_slice(position);
        state.compensation.fill(0.0);
        state.velocity.copy_from_slice(velocity);
    }
}

/// The name of the joint that owns entry `index` of y.
pub(super) fn joint_of_entry(mechanism: &Mechanism, index: usize) -> String {
    let owns = |joint: &crate::model::Joint| match index.checked_sub(mechanism.position_count) {
        Some(velocity) => joint.velocity_range().contains(&velocity),
        None => joint.position_range().contains(&index),
    };
    mechanism.bodies.iter().find(|body| owns(&body.joint)).map_or_else(String::new, |body| body.joint.name.clone())
}

/// The end of a step of at most `step` towards `until`, and the length of the step.
///
/// A rest that is longer than the step only by rounding is taken whole, so that no sliver of a step remains.
pub(super) fn next_time(time: f64, step: f64, until: f64) -> (f64, f64) {
    let remaining = until - time;
    if remaining <= step * 1.000_000_1 { (until, remaining) } else { (time + step, step) }
}
