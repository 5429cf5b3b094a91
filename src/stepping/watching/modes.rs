//! The data of the motion that the step control uses: its fastest mode and its pace.
//!
//! A tree under gravity has both from its geometric stiffness ([`crate::watching::dynamics`]); with forces or closures the mode comes from
//! differences of accelerations ([`crate::watching::linearised`]), and the pace is not available.

use crate::watching::dynamics::Dynamics;
use crate::watching::fastest_mode::Fastest;
use crate::watching::linearised::Linearised;
use crate::watching::pace::Pace;
use crate::watching::watch::{Mode, Transient};
use catena_lobatto::coupled::known::Known;
use catena_lobatto::plan::tree::Plan;
use catena_lobatto::stages::start::Start;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::motion::state::State;

/// The workspace of all looks at one mechanism.
#[derive(Clone)]
pub struct Modes {
    plan: Plan,
    /// The state at hand, as the start of a step.
    start: Start,
    /// For a tree under gravity.
    dynamics: Option<Dynamics>,
    fastest: Fastest,
    /// For all other mechanisms.
    linearised: Option<Box<Linearised>>,
    jerks: Vec<f64>,
}

impl Modes {
    /// Modes without known directions.
    pub fn new(mechanism: &Mechanism) -> Self {
        let plan = Plan::new(mechanism);
        let freedoms = mechanism.velocity_count;
        let plain = mechanism.is_plain_tree();
        Modes {
            dynamics: plain.then(|| Dynamics::new(&plan, freedoms)),
            fastest: Fastest::new(freedoms),
            linearised: (!plain).then(|| Box::new(Linearised::new(mechanism))),
            jerks: vec![0.0; freedoms],
            start: Start::with_units(mechanism),
            plan,
        }
    }

    /// Forgets the motion: the next look is at another.
    pub fn forget(&mut self) {
        self.fastest.forget();
        if let Some(linearised) = &mut self.linearised {
            linearised.forget();
        }
    }

    /// Takes over the ranks and flags of the closures.
    pub fn heed(&mut self, known: &Known) {
        if let Some(linearised) = &mut self.linearised {
            linearised.heed(known);
        }
    }

    /// The fastest mode at a state, after some power iterations.
    pub fn fastest(&mut self, mechanism: &Mechanism, state: &State, iterations: usize) -> Mode {
        let Modes { plan, start, dynamics, fastest, linearised, .. } = self;
        if let Some(dynamics) = dynamics {
            start.set(mechanism, state);
            let frequency = fastest.estimate(dynamics, plan, start, &mechanism.gravity.into(), iterations);
            return Mode { frequency, damping: 0.0 };
        }
        linearised.as_mut().map(|linearised| linearised.estimate(mechanism, state, iterations)).unwrap_or_default()
    }

    /// The motion that dampers are about to stop at a state, if there is one that counts.
    pub fn transient(&mut self, mechanism: &Mechanism, state: &State) -> Option<Transient> {
        self.linearised.as_mut().and_then(|linearised| linearised.transient(mechanism, state))
    }

    /// The rate at which the hardest damper stops something at a state [1/s], after some power iterations.
    pub fn hardest_damper(&mut self, mechanism: &Mechanism, state: &State, iterations: usize) -> f64 {
        self.linearised.as_mut().map_or(0.0, |linearised| linearised.hardest_damper(mechanism, state, iterations))
    }

    /// The pace of the motion at a state; `None` with forces and closures, which it does not know.
    pub fn pace(&mut self, mechanism: &Mechanism, state: &State) -> Option<Pace> {
        let Modes { plan, start, dynamics, jerks, .. } = self;
        let dynamics = dynamics.as_mut()?;
        start.set(mechanism, state);
        Some(Pace::at(dynamics, plan, start, &mechanism.gravity.into(), jerks))
    }
}
