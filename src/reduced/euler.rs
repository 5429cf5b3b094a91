//! Semi-implicit Euler in joint coordinates, order 1: the method of most real-time engines.
//!
//! ```text
//!     v₁ = v₀ + h q̈(q₀, v₀)        velocity first
//!     q₁ = q₀ ⊕ h v₁               then positions with the new velocity; quaternions by the exponential map
//! ```
//!
//! Source: E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, Springer 2006, section I.1.2.

use crate::ode::{ReducedOde, joint_of_entry, next_time};
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::forces::total::Exchange;
use catena_mechanism::motion::inputs::Inputs;
use catena_mechanism::motion::integrator::{Integrator, MethodDescription, StepError, StepOutcome};
use catena_mechanism::motion::state::State;

/// Semi-implicit Euler with a fixed step.
#[derive(Clone, Debug)]
pub struct Euler {
    ode: ReducedOde,
    step: f64,
    start: State,
    end: State,
    velocity: Vec<f64>,
    increment: Vec<f64>,
}

impl Euler {
    /// For one mechanism, with a fixed step (s).
    pub fn new(mechanism: &Mechanism, step: f64) -> Self {
        Euler::of_system(mechanism, ReducedOde::new(mechanism), step)
    }

    /// For a system of a mechanism, with a fixed step (s).
    pub fn of_system(mechanism: &Mechanism, ode: ReducedOde, step: f64) -> Self {
        Euler {
            ode,
            step,
            start: State::zero(mechanism),
            end: State::zero(mechanism),
            velocity: vec![0.0; mechanism.velocity_count],
            increment: vec![0.0; mechanism.velocity_count],
        }
    }
}

impl Integrator for Euler {
    fn step(
        &mut self,
        mechanism: &Mechanism,
        inputs: Inputs,
        state: &mut State,
        until: f64,
    ) -> Result<StepOutcome, StepError> {
        if let Some(now) = self.ode.changed(mechanism, inputs) {
            *self = Euler::new(&now, self.step);
        }
        self.ode.drive_at(state.time, inputs);
        let (time, step) = next_time(state.time, self.step, until);
        self.ode.accelerations(&state.position, &state.velocity, &mut self.velocity);
        // As accurate as the method.
        let powers = self.ode.powers(&state.velocity);
        let exchange =
            Exchange { dissipated: step * powers.dissipated, work: step * powers.work, ..Exchange::default() };
        for (entry, &old) in self.velocity.iter_mut().zip(&state.velocity) {
            *entry = old + step * *entry;
        }
        // The search begins at the end, because a failure in a leaf spoils everything that carries it.
        if let Some(bad) = self.velocity.iter().rposition(|value| !value.is_finite()) {
            let joint = joint_of_entry(mechanism, mechanism.position_count + bad);
            return Err(StepError::NotFinite { time: state.time, step, joint });
        }
        for (entry, &rate) in self.increment.iter_mut().zip(&self.velocity) {
            *entry = step * rate;
        }
        self.start.clone_from(state);
        state.displace(mechanism, &self.increment);
        state.velocity.copy_from_slice(&self.velocity);
        state.time = time;
        self.end.clone_from(state);
        Ok(StepOutcome::new(step, 1, exchange))
    }

    /// Linear in between, which is as accurate as the method.
    fn dense(&mut self, _mechanism: &Mechanism, time: f64, position: &mut [f64], velocity: &mut [f64]) {
        let fraction = (time - self.start.time) / (self.end.time - self.start.time);
        let blend = |from: &[f64], to: &[f64], out: &mut [f64]| {
            for ((entry, &a), &b) in out.iter_mut().zip(from).zip(to) {
                *entry = a + fraction * (b - a);
            }
        };
        blend(&self.start.position, &self.end.position, position);
        blend(&self.start.velocity, &self.end.velocity, velocity);
        self.ode.normalise(position);
    }

    fn description(&self) -> MethodDescription {
        MethodDescription::fixed("euler", 1, 1, self.step)
    }
}
