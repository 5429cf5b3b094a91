//! Contacts that part together: their pressures end sooner than a step can be solved.
//!
//! ```text
//!     λ_N(t₀) > 0,   λ_N(t₀ + h) < 0      of several contacts, h the shortest step [s]
//! ```
//!
//! An event of forces that is nearer to the start t₀ of a step than h is there. A contact whose pressure λ_N (N) ends within h ends with it: the
//! decision at t₀ sees the pressure that is left, closes it again as often as one of the others parts, and lets the friction of roundings turn its slip.

use crate::events::finding::watched::Watched;
use crate::events::integrator::Eventful;
use crate::events::modes::instants::Inside;
use crate::mechanism::motion::inputs::Inputs;

impl Eventful {
    /// Notes the contacts whose pressures end in the shortest step from a time (s) on, on the dense output of the last one: an event of forces, among
    /// the watched functions, is at its start.
    pub(super) fn see_what_parts(&mut self, inputs: Inputs, since: f64, event: usize) {
        if !self.trial.watched[event].needs_efforts() {
            return;
        }
        let until = (since + self.shortest(since)).min(self.workspaces.active().small.time);
        let presses = |index: &usize| matches!(self.trial.watched[*index], Watched::Presses(_));
        let which: Vec<usize> = (0..self.trial.watched.len()).filter(presses).collect();
        let mut values = vec![0.0; which.len()];
        self.evaluate(inputs, since, Inside::at(until), &which, &mut values);
        let ends = which.into_iter().zip(values).filter(|(_, value)| *value < 0.0);
        self.trial.parts.extend(ends.map(|(index, _)| self.trial.watched[index]));
    }
}
