//! A run in a crowd: when it begins and ends, and its steps (`crowd/`).
//!
//! ```text
//!     many events, or a step that cannot be made ─▶ steps over impacts ─▶ calm for some steps ─▶ the mode decided anew, exact steps
//! ```

use crate::events::crowd::contacts::{Scene, has_row};
use crate::events::crowd::step::Made;
use crate::events::effects::resting::energy;
use crate::events::integrator::Eventful;
use crate::events::modes::mode::MotorMode;
use crate::mechanism::forces::total::Exchange;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::integrator::StepOutcome;
use crate::mechanism::motion::state::State;

impl Eventful {
    /// Makes one step of a crowd towards `until`, if it can be made.
    pub(super) fn step_in_crowd(&mut self, inputs: Inputs, state: &mut State, until: f64, length: f64) -> Option<StepOutcome> {
        let step = length.min(until - state.time);
        self.origin.copy_from(state);
        let mut end = state.clone();
        let Eventful { whole, elements, touching, response, mode, crowd, .. } = self;
        let crowd = crowd.as_mut()?;
        let mut forces = |at: &State, accelerations: &mut [f64], efforts: &mut [f64]| {
            inputs.write_constant(efforts);
            inputs.add_feedback(at, efforts);
            for (motor, mode) in elements.motors.iter().zip(&mode.motors).filter(|(motor, _)| !has_row(motor)) {
                let place = motor.coordinate;
                efforts[place.freedom] += match *mode {
                    MotorMode::Given(effort) => effort,
                    _ => {
                        let position = at.position[place.position] + at.compensation[place.position];
                        motor.effort(at.time, position, at.velocity[place.freedom])
                    }
                };
            }
            response.accelerations(at, efforts, accelerations);
        };
        let scene = Scene { whole, elements, touching };
        let Made { iterations, residual: _, unsolved, overlap, work, dissipated, friction, lost, .. } =
            crowd.step(scene, &mut forces, &mut end, step)?;
        // The end is the given instant to the last bit.
        if step == until - state.time {
            end.time = until;
        }
        state.copy_from(&end);
        for index in 0..self.elements.motors.len() {
            let motor = &self.elements.motors[index];
            if motor.period > 0.0 && motor.next_instant(self.origin.time) <= state.time {
                self.mode.motors[index] = self.motor_mode(index, state);
            }
        }
        self.unsolved += unsolved;
        self.overlap = self.overlap.max(overlap);
        self.first_order = (self.first_order.0 + 1, self.first_order.1 + step);
        let start = self.origin.clone();
        self.see_jump(&start, state);
        self.stepped_over = Some(state.clone());
        self.memory.kinetic = self.memory.kinetic.max(energy(&self.whole, state).kinetic);
        self.steps += 1;
        self.stepped += step;
        let impacts = lost - dissipated - friction;
        let exchange = Exchange { work, dissipated, friction, impacts };
        Some(StepOutcome { step, iterations, exchange, ..StepOutcome::default() })
    }
}
