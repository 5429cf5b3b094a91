//! How far a step is iterated beside hard dampers.
//!
//! ```text
//!     h γ > 15, or soon after a step that changed the energy too much:    ends at increments of  min(ε, 1e-15, r)
//!     r = clip(1e-3 T/γ, 1e-14 h, 1e-13)                                  increments that stay below r are rounding
//! ```
//!
//! h is the length of the step (s), γ the rate at which the hardest damper stops a motion [1/s], ε the stop (rad, m), and T the tolerance (rad, m): rates
//! are compared with T in a second. An iteration that leaves δ of a displacement leaves a rate of up to γ δ at the end of the step, which the scheme carries
//! on into the next ones. It is far from normal, so that δ may be a hundred times the last increment. Roundings of displacements grow with h
//! (doc/decisions/046-rates-beside-hard-dampers.md).

use crate::length::companion::STOPPED;
use crate::length::control::Control;
use catena_lobatto::stages::attempt::StopRule;

/// The coarsest stop beside hard dampers (rad, m).
pub(crate) const DAMPED_STOP: f64 = 1e-15;
/// The largest r (rad, m), and its least part of the length of a step [rad/s, m/s].
const ROUNDED: f64 = 1e-13;
const OF_STEP: f64 = 1e-14;
/// Staying increments leave rates of this part of the tolerance in a second [1/s].
const OF_RATES: f64 = 1e-3;

impl Control {
    /// The rule for a step of some length (s) where dampers stop motions at the rate `decay` [1/s].
    pub(crate) fn beside_dampers(&self, rule: StopRule, decay: f64, length: f64) -> StopRule {
        if length * decay <= STOPPED && self.memory.polished == 0 {
            return rule;
        }
        let rounding = (OF_RATES * self.tolerance / decay).clamp(OF_STEP * length.min(1.0), ROUNDED);
        StopRule { increment: rule.increment.min(DAMPED_STOP).min(rounding), rounding, ..rule }
    }
}
