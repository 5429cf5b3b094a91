//! Whole turns of joints whose angles are computed from the places of bodies, between −π and π.
//!
//! The rates are known at two instants, between which a joint turns by little:
//!
//! ```text
//!     turned = ½ (t₁ − t₀) (q̇₀ + q̇₁)        q₁ += 2π round((q₀ + turned − q₁) / 2π)
//! ```
//!
//! A long step is looked at in parts, with dense output.

use catena_mechanism::description::joint::{FreeRotation, Joint};
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::motion::state::State;
use std::f64::consts::{FRAC_PI_4, TAU};

/// The angles of joints that are computed from places, at instants of the last step between which they turn little.
#[derive(Clone)]
pub(crate) struct Turns {
    /// Their entries of the file's position and velocity vectors.
    joints: Vec<(usize, usize)>,
    /// One an instant: the time (s), the angles (rad) and rates [rad/s] of all joints.
    times: Vec<f64>,
    angles: Vec<f64>,
    rates: Vec<f64>,
    position: Vec<f64>,
    velocity: Vec<f64>,
}

/// Between two instants no joint turns by more than this (rad).
const LITTLE: f64 = FRAC_PI_4;
/// A step is looked at in no more parts than this: eight turns of a joint, which no step makes.
const PARTS: usize = 64;

impl Turns {
    /// The turns of the revolute joints of these bodies.
    pub fn new(mechanism: &Mechanism, bodies: &[usize]) -> Self {
        let joints = bodies.iter().map(|&body| &mechanism.bodies[body].joint);
        let turning = joints.filter(|joint| joint.kind.rotation() == FreeRotation::AboutZ);
        let slides = |joint: &Joint| joint.kind.translation_axes().len();
        let entries = |joint: &Joint| (joint.position_index + slides(joint), joint.velocity_index + slides(joint));
        let joints: Vec<_> = turning.map(entries).collect();
        Turns {
            times: Vec::with_capacity(PARTS),
            angles: Vec::with_capacity(PARTS * joints.len()),
            rates: Vec::with_capacity(PARTS * joints.len()),
            joints,
            position: vec![0.0; mechanism.position_count],
            velocity: vec![0.0; mechanism.velocity_count],
        }
    }

    /// A step begins at a state.
    pub fn begin(&mut self, state: &State) {
        self.times.clear();
        self.angles.clear();
        self.rates.clear();
        self.keep(state.time, &state.position, &state.velocity);
    }

    fn keep(&mut self, time: f64, position: &[f64], velocity: &[f64]) {
        self.times.push(time);
        self.angles.extend(self.joints.iter().map(|&(slot, _)| position[slot]));
        self.rates.extend(self.joints.iter().map(|&(_, freedom)| velocity[freedom]));
    }

    /// Adds whole turns to the angles at the end of a step, of whose inside `dense` writes positions and velocities.
    pub fn follow(&mut self, end: &mut State, mut dense: impl FnMut(f64, &mut [f64], &mut [f64])) {
        let begin = self.times[0];
        let rates = self.joints.iter().map(|&(_, freedom)| end.velocity[freedom]).chain(self.rates.iter().copied());
        let fastest = rates.fold(0.0, |most: f64, rate| most.max(rate.abs()));
        let parts = (fastest * (end.time - begin) / LITTLE).ceil().clamp(1.0, PARTS as f64);
        let (mut position, mut velocity) = (std::mem::take(&mut self.position), std::mem::take(&mut self.velocity));
        for part in 1..parts as usize {
            let time = begin + (end.time - begin) * (part as f64 / parts);
            dense(time, &mut position, &mut velocity);
            self.unwrap(time, &mut position, &velocity);
            self.keep(time, &position, &velocity);
        }
        (self.position, self.velocity) = (position, velocity);
        self.unwrap(end.time, &mut end.position, &end.velocity);
    }

    /// Adds whole turns to the angles at a time of the step (s), by the rates since the last instant before it.
    pub fn unwrap(&self, time: f64, position: &mut [f64], velocity: &[f64]) {
        let last = self.times.partition_point(|&before| before < time).saturating_sub(1);
        for (joint, &(slot, freedom)) in self.joints.iter().enumerate() {
            let entry = last * self.joints.len() + joint;
            let turned = 0.5 * (time - self.times[last]) * (self.rates[entry] + velocity[freedom]);
            position[slot] += TAU * ((self.angles[entry] + turned - position[slot]) / TAU).round();
        }
    }
}
