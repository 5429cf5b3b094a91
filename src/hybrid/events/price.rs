//! The prices of exact steps and of steps over events, by which a run chooses between them.
//!
//! ```text
//!     C = (1/h) c_c (i + 5) n                               cost of steps over events for a second of the motion (s/s)
//!     E = n_s c (n + 3 n_c)² + c_d (3 n_c)³                 expected cost of exact steps for a calm second of it (s/s)
//!     begin:   R > max(2 C, 1), if steps over events keep to the tolerance, else R > 20               R: cost of events (`parts/spending.rs`)
//!              c_d (3 n_c)³ > max(2 C, 1), or 3, where a run begins                                   cost of its decision (s)
//!     end:     E < C/2;   or E < 0.2 in a scene of a few bodies, n_s c (3 n)² < 0.08 s, whose error is estimated
//! ```
//!
//! n: rates; n_c: closed contacts; h: length of a step (s), i: its iterations, of a usual one at most; n_s: number of exact steps in a calm second; c and c_c:
//! measured costs of an iteration for each squared unknown, and of a step over events for each rate; c_d: of a decision for each cubed unknown, which is
//! dense. All are counts: the choice does not depend on a clock.

use crate::events::crowd::step::Made;
use crate::events::integrator::Eventful;
use crate::events::parts::spending::{DEAREST, Patience};

/// c and c_c (s), n_s.
pub(super) const ITERATION: f64 = 2e-7;
/// A look at the gap of two hulls with many vertices (s).
pub(super) const LOOK: f64 = 3e-5;
const STEP: f64 = 4e-7;
const CALM_STEPS: f64 = 200.0;
/// c_d (s).
const DECISION: f64 = 4e-8;
/// Iterations that the other work of a step is worth, and iterations of a usual step.
const OVERHEAD: f64 = 5.0;
const USUAL: f64 = 8.0;
/// Exact steps that cost less than this stay (s for a second of the motion).
pub(super) const CHEAP: f64 = 1.0;
/// The same of the decision of a start where steps over events do not keep to the tolerance (s): what rests may never move.
const PATIENT: f64 = 3.0;
/// Exact steps that cost less than this are worth a run that begins again (s for a second of the motion).
const LITTLE: f64 = 0.2;
/// The same with a contact for three rates, in a scene of a few bodies: two on a floor.
const FEW: f64 = 0.08;

impl Eventful {
    /// Whether steps that end at given instants, to which few stages are not enough, are as good a reason for steps over events as events are.
    pub(super) fn counts_instants(&self) -> bool {
        !self.progress.estimated || self.progress.beyond_horizon
    }

    /// Whether exact steps stay that cost little: an impact that is met in its order may decide what follows in a scene of a few bodies.
    fn is_worth_a_wait(&self) -> bool {
        are_few(self.model.whole.velocity_count) && !self.counts_instants()
    }

    /// Whether exact steps have become too dear at a time (s).
    pub(super) fn are_exact_steps_too_dear(&self, time: f64) -> bool {
        let (length, keeps) = self.crowd_length();
        let good = self.workspaces.crowd.is_some() && keeps && !self.needs_events();
        let (price, patience) = if !good {
            (DEAREST, Patience::Long)
        } else if self.is_worth_a_wait() {
            (self.price_of_crowds(length), Patience::Order)
        } else if self.counts_instants() {
            (self.price_of_crowds(length), Patience::Short)
        } else {
            (self.price_of_crowds(length), Patience::Medium)
        };
        self.progress.spending.rate(time, patience) > price
    }

    /// The cost of a second of the motion that is dearer than steps over events of this length (s/s).
    pub(super) fn price_of_crowds(&self, length: f64) -> f64 {
        (2.0 * self.cost_of_crowds(length, USUAL)).max(CHEAP)
    }

    /// The expected cost of steps of this length (s) and iterations for a second of the motion (s).
    fn cost_of_crowds(&self, length: f64, iterations: f64) -> f64 {
        STEP * (iterations + OVERHEAD) * self.model.whole.velocity_count as f64 / length
    }

    /// Whether the decision of the mode in which a run begins, with this number of contacts, costs more than steps over events.
    pub(super) fn is_start_too_dear(&self, contacts: usize) -> bool {
        let (length, keeps) = self.crowd_length();
        decision(contacts) > self.price_of_crowds(length).max(if keeps { CHEAP } else { PATIENT })
    }

    /// Whether exact steps are expected to cost less than steps over events of this length (s) after one of these.
    pub(super) fn are_exact_steps_cheaper(&self, length: f64, made: &Made) -> bool {
        let exact = cost_of_exact(self.model.whole.velocity_count, made.held);
        let over = self.cost_of_crowds(length, (made.iterations as f64).min(USUAL));
        let little = if self.is_worth_a_wait() && self.crowd_length().1 { LITTLE } else { 0.0 };
        exact < little.max(0.5 * over)
    }
}

/// The expected cost of exact steps with so many rates and closed contacts for a calm second of the motion (s).
fn cost_of_exact(rates: usize, contacts: usize) -> f64 {
    CALM_STEPS * ITERATION * (rates as f64 + 3.0 * contacts as f64).powi(2) + decision(contacts)
}

/// Whether exact steps with so many rates and closed contacts are expected to cost little for a calm second of the motion. Steps of a robot do, and steps of
/// a pile of eight boxes do not.
pub fn is_cheap(rates: usize, contacts: usize) -> bool {
    cost_of_exact(rates, contacts) < LITTLE
}

/// Whether a scene with this number of rates has a few bodies: exact steps cost little there, however many contacts close.
pub fn are_few(rates: usize) -> bool {
    CALM_STEPS * ITERATION * (3.0 * rates as f64).powi(2) < FEW
}

/// The cost of the decision of a mode with this number of closed contacts (s).
pub(super) fn decision(contacts: usize) -> f64 {
    DECISION * (3.0 * contacts as f64).powi(3)
}
