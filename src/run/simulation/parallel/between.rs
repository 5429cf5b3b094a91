//! The energies of a run of islands at the event of one of them, while the others are inside their steps.
//!
//! ```text
//!     E(t) = Σ_i E_i(t)      E_i: linear in t between neighbouring samples and ends of steps of island i     (J)
//! ```
//!
//! The island of the event is at the end of a step, where its energies are known. Curves are drawn as straight lines between samples, so that the
//! others have the values that are drawn for them. A sum of energies that stays the same in each island is the same between these instants, too. The
//! exchange of energy with the outside is known at the ends of steps alone, and linear between them.

use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::forces::total::Exchange;
use crate::mechanism::motion::energy::{Energy, energy_with_forces};
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use crate::simulation::steps::observer::StepEnd;

/// The energies of one island at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Knot {
    /// s.
    pub time: f64,
    pub energy: Energy,
    /// Since the start of the run (J).
    pub exchange: Exchange,
}

impl Knot {
    /// At the end of a step, after its impacts.
    pub fn after(end: &StepEnd) -> Self {
        Knot { time: end.time, energy: end.energy, exchange: end.exchange }
    }

    /// At the end of a step, before its impacts.
    pub fn before(end: &StepEnd) -> Self {
        let mut knot = Knot::after(end);
        let impacts = end.outcome.exchange.impacts;
        knot.energy.kinetic += impacts;
        knot.exchange.impacts -= impacts;
        knot
    }

    /// At a sample; its exchange is not known.
    pub fn of_sample(mechanism: &Mechanism, state: &State) -> Self {
        let energy = energy_with_forces(mechanism, &state.position, &body_states(mechanism, state));
        Knot { time: state.time, energy, exchange: Exchange::default() }
    }

    /// On the line from this knot to a later one, at a time (s).
    pub fn towards(&self, later: &Knot, time: f64) -> Self {
        let span = later.time - self.time;
        let part = if span > 0.0 { ((time - self.time) / span).clamp(0.0, 1.0) } else { 0.0 };
        let mix = |from: f64, to: f64| from + part * (to - from);
        let (e, f, x, y) = (&self.energy, &later.energy, &self.exchange, &later.exchange);
        Knot {
            time,
            energy: Energy {
                kinetic: mix(e.kinetic, f.kinetic),
                potential: mix(e.potential, f.potential),
                spring: mix(e.spring, f.spring),
                load: mix(e.load, f.load),
            },
            exchange: Exchange {
                dissipated: mix(x.dissipated, y.dissipated),
                work: mix(x.work, y.work),
                friction: mix(x.friction, y.friction),
                impacts: mix(x.impacts, y.impacts),
            },
        }
    }
}
