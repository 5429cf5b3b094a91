//! An estimate of the error at the end of a run with fixed steps.
//!
//! ```text
//!     by half the step:  d/(1 − 2^−p)               d: the distance of the ends of two runs, with h and h/2 (m); p: the order
//!     by twice the step: d/5                        d: the same with h and 2 h, where bodies rebound: errors are amplified, and their order is not seen
//!     by the energy:     10 · e · v T,    v = sqrt(2 T_max / m)          e: largest energy error over the largest kinetic energy T_max (J)
//! ```
//!
//! An energy error e is a relative error e/2 of velocities, which leaves e v T / 2 of the way that bodies of mass m (kg) go in the time T (s); most
//! motions amplify that, and the factor of ten stands for it. It is an order of magnitude for calm motions, and too small for chaotic ones.

use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::ground::words::rounded;
use crate::mechanism::motion::integrator::MethodDescription;
use crate::output::report::rounding::{COARSE, is_energy_rounding};
use crate::simulation::StepChoice;
use crate::simulation::Summary;
use serde::Serialize;

/// The amplification of errors of velocities by motions, as a guess for want of knowing better.
const AMPLIFIED: f64 = 10.0;
/// Errors beyond this (m, rad of a body of one metre) are said to the user.
const NOTICEABLE: f64 = 1e-3;
/// A run in steps twice as long is off by this many times the error; by hundreds of times where errors are small, and by as much where both are far off.
const OF_TWICE: f64 = 5.0;
/// Energy errors below this are rounding, which does not depend on steps. They give no estimate.
const ROUNDING: f64 = 1e-11;

/// The estimated error of a run with fixed steps.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StepErrorReport {
    /// The error at the end (m).
    pub estimated: f64,
    /// The source of the estimate: `half the step`, `twice the step` or `energy`.
    pub by: &'static str,
}

impl StepErrorReport {
    /// The estimate of a method of this order from the distance of a run with half the step at the end (m).
    pub(crate) fn by_half_the_step(apart: f64, order: usize) -> Self {
        StepErrorReport { estimated: apart / (1.0 - 0.5_f64.powi(order as i32)), by: "half the step" }
    }

    /// The estimate where bodies rebound, from the distance of a run with twice the step at the end (m).
    pub(crate) fn by_twice_the_step(apart: f64) -> Self {
        StepErrorReport { estimated: apart / OF_TWICE, by: "twice the step" }
    }

    /// The estimate from the energy error of a run of this duration (s); `None` if rounding hides it, and for steps over events, whose balance of energy
    /// does not depend on their error.
    pub(crate) fn by_energy(
        mechanism: &Mechanism,
        method: &MethodDescription,
        summary: &Summary,
        duration: f64,
    ) -> Option<Self> {
        if method.stages == StepChoice::OVER_EVENTS
            || summary.max_relative_energy_error > COARSE && is_energy_rounding(summary)
        {
            return None;
        }
        let error = summary.max_relative_energy_error;
        let speed = (2.0 * summary.largest_kinetic / mechanism.total_mass().max(f64::MIN_POSITIVE)).sqrt();
        let estimated = AMPLIFIED * error.max(ROUNDING) * speed * duration;
        Some(StepErrorReport { estimated, by: "energy" })
    }

    /// The warning of steps that were too long.
    pub(crate) fn warning(&self, description: &MethodDescription) -> Option<String> {
        let StepErrorReport { estimated, by } = *self;
        if estimated <= NOTICEABLE {
            return None;
        }
        let step = rounded(description.step);
        let remedy = if by != "half the step" {
            "add --check for an estimate by half the step, or use --tolerance"
        } else {
            "use --tolerance"
        };
        Some(format!(
            "steps of {step} s are too long: the estimated error at the end is {estimated:.1e} m (by {by}); use a smaller --step, or {remedy}"
        ))
    }
}
