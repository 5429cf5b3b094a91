//! Efforts that motors hold between ticks, with their derivatives.
//!
//! ```text
//!     at a tick     τ = clamp(drive(t) − kp q − kd v)          held to the next tick, at which the state has the derivatives of its own
//! ```

use crate::derivatives::events::efforts::EffortLaws;
use crate::derivatives::events::walk::{AT_TICK, Subject, Walk};
use crate::derivatives::forward::step::{Part, WIDTH};
use crate::events::trace::{Mode, MotorMode};

impl Walk<'_> {
    /// The derivatives of efforts that motors work out at a tick.
    pub(super) fn meet_ticks(&mut self, mode: &Mode, since: f64) {
        let Subject { elements, laws, parameters, .. } = *self.subject;
        let of = EffortLaws { elements, laws, parameters, varied: &self.varied };
        for (index, motor) in elements.motors.iter().enumerate() {
            let MotorMode::Given(effort) = mode.motors[index] else { continue };
            let ticks = since / motor.period;
            if self.begun && (ticks - ticks.round()).abs() > AT_TICK {
                continue;
            }
            let (at, p) = (motor.coordinate, parameters.len());
            let (_, slopes, rate) = of.drive(index, since, since);
            for column in 0..p {
                let law = &self.varied.chunks()[column / WIDTH].laws.motors[index];
                let part = |value: &Part| value.parts[column % WIDTH];
                let bounded = effort.abs() >= motor.max_effort;
                self.given[(index, column)] = if bounded {
                    effort.signum() * part(&law.bound)
                } else {
                    slopes[column] + rate * self.tangent.times[column]
                        - law.kp.value * self.tangent.positions[(at.freedom, column)]
                        - law.kd.value * self.tangent.velocities[(at.freedom, column)]
                        - part(&law.kp) * self.state.position[at.position]
                        - part(&law.kd) * self.state.velocity[at.freedom]
                };
            }
        }
        self.begun = true;
    }
}
