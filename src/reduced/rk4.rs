//! The classical Runge–Kutta method of order 4 in joint coordinates, with a fixed step.
//!
//! ```text
//!     k₁ = f(y₀),  k₂ = f(y₀ + h/2 k₁),  k₃ = f(y₀ + h/2 k₂),  k₄ = f(y₀ + h k₃)
//!     y₁ = y₀ + h/6 (k₁ + 2 k₂ + 2 k₃ + k₄)
//! ```
//!
//! Source: E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, Springer 1993, table II.1.2.

use crate::ode::{ReducedOde, joint_of_entry, next_time};
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::motion::inputs::Inputs;
use catena_mechanism::motion::integrator::{Integrator, MethodDescription, StepError, StepOutcome};
use catena_mechanism::motion::state::State;
use std::cell::RefCell;

/// Classical Runge–Kutta with a fixed step.
#[derive(Clone, Debug)]
pub struct Rk4 {
    /// In a cell because dense output needs the slope at the end of the step, which no step does.
    ode: RefCell<ReducedOde>,
    step: f64,
    start_time: f64,
    end_time: f64,
    start: Vec<f64>,
    end: Vec<f64>,
    stage: Vec<f64>,
    slopes: [Vec<f64>; 4],
}

impl Rk4 {
    /// For one mechanism, with a fixed step (s).
    pub fn new(mechanism: &Mechanism, step: f64) -> Self {
        Rk4::of_system(ReducedOde::new(mechanism), step)
    }

    /// For a system, with a fixed step (s).
    pub fn of_system(ode: ReducedOde, step: f64) -> Self {
        let zeros = vec![0.0; ode.dimension()];
        Rk4 {
            ode: RefCell::new(ode),
            step,
            start_time: 0.0,
            end_time: 0.0,
            start: zeros.clone(),
            end: zeros.clone(),
            stage: zeros.clone(),
            slopes: std::array::from_fn(|_| zeros.clone()),
        }
    }
}

impl Integrator for Rk4 {
    fn step(
        &mut self,
        mechanism: &Mechanism,
        inputs: Inputs,
        state: &mut State,
        until: f64,
    ) -> Result<StepOutcome, StepError> {
        if let Some(now) = self.ode.get_mut().changed(mechanism, inputs) {
            *self = Rk4::new(&now, self.step);
        }
        let (time, step) = next_time(state.time, self.step, until);
        let ode = self.ode.get_mut();
        ode.drive_at(state.time, inputs);
        ode.load(state, &mut self.start);
        let [k1, k2, k3, k4] = &mut self.slopes;
        ode.derivative(&self.start, k1);
        add_scaled(&self.start, 0.5 * step, k1, &mut self.stage);
        ode.drive_at(state.time + 0.5 * step, inputs);
        ode.derivative(&self.stage, k2);
        add_scaled(&self.start, 0.5 * step, k2, &mut self.stage);
        ode.derivative(&self.stage, k3);
        add_scaled(&self.start, step, k3, &mut self.stage);
        ode.drive_at(time, inputs);
        ode.derivative(&self.stage, k4);
        let slopes = k1.iter().zip(k2.iter()).zip(k3.iter().zip(k4.iter()));
        for ((end, &start), ((&a, &b), (&c, &d))) in self.end.iter_mut().zip(&self.start).zip(slopes) {
            *end = start + step / 6.0 * (a + 2.0 * (b + c) + d);
        }
        if let Some(bad) = self.end.iter().rposition(|value| !value.is_finite()) {
            return Err(StepError::NotFinite { time: state.time, step, joint: joint_of_entry(mechanism, bad) });
        }
        ode.normalise(&mut self.end);
        ode.store(&self.end, state);
        (self.start_time, self.end_time) = (state.time, time);
        state.time = time;
        Ok(StepOutcome::new(step, 4, ode.exchange(&self.start, &self.end)))
    }

    /// Cubic Hermite interpolation, as accurate as the method.
    fn dense(&mut self, mechanism: &Mechanism, time: f64, position: &mut [f64], velocity: &mut [f64]) {
        let step = self.end_time - self.start_time;
        let s = (time - self.start_time) / step;
        let mut end_slope = vec![0.0; self.end.len()];
        self.ode.borrow_mut().derivative(&self.end, &mut end_slope);
        let start_slope = &self.slopes[0];
        let at = |i: usize| {
            let rise = self.end[i] - self.start[i];
            let bend = (1.0 - 2.0 * s) * rise + step * ((s - 1.0) * start_slope[i] + s * end_slope[i]);
            (1.0 - s) * self.start[i] + s * self.end[i] + s * (s - 1.0) * bend
        };
        position.iter_mut().enumerate().for_each(|(i, entry)| *entry = at(i));
        velocity.iter_mut().enumerate().for_each(|(i, entry)| *entry = at(mechanism.position_count + i));
        self.ode.borrow().normalise(position);
    }

    fn description(&self) -> MethodDescription {
        MethodDescription::fixed("rk4", 4, 4, self.step)
    }
}

/// `out = y + h k`.
fn add_scaled(y: &[f64], step: f64, slope: &[f64], out: &mut [f64]) {
    for ((entry, &value), &rate) in out.iter_mut().zip(y).zip(slope) {
        *entry = value + step * rate;
    }
}
