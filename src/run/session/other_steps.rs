//! The same run in steps of another length, on another core: the distance of the ends tells the error of the steps.
//!
//! ```text
//!     asked for:                           h/2,    error d/(1 − 2^−p)
//!     where bodies rebound, otherwise:     2 h,    error d/5                  d: distance of the ends (m), h: step (s), p: order
//! ```
//!
//! Rebounds amplify errors: a spinning body that hits a floor a microsecond later leaves it elsewhere, and hits it elsewhere. Its energy says nothing of
//! that. Of 120 random scenes three were off by more than 1e-6 m: by d, d/70 and d/250.

use crate::lobatto::coupled::counted::Counted;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::description::rules::Rule;
use crate::mechanism::motion::state::State;
use crate::session::asked::Settled;
use crate::session::model::Model;
use crate::simulation::{Simulation, SimulationOptions, StepChoice};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// A run that is to be made in other steps.
pub(crate) struct OtherSteps {
    pub length: Length,
    pub model: Model,
    pub settled: Settled,
    pub state: State,
    pub counted: Option<Arc<Counted>>,
    pub kept: Vec<Rule>,
    pub interrupt: Arc<AtomicBool>,
}

/// The length of these steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Length {
    Half,
    Twice,
}

impl Length {
    /// Those of a run: asked for, or needed because its bodies rebound in steps of a given length. `None` without.
    pub fn of(asked: bool, choice: StepChoice, mechanism: &Mechanism) -> Option<Self> {
        let given = matches!(choice, StepChoice::Fixed { stages, .. } if stages != StepChoice::OVER_EVENTS);
        let rebounds =
            || mechanism.nonsmooth.pairs.runs().iter().any(|run| run.pairs().any(|pair| pair.restitution > 0.0));
        if asked { Some(Length::Half) } else { (given && rebounds()).then_some(Length::Twice) }
    }

    fn factor(self) -> f64 {
        match self {
            Length::Half => 0.5,
            Length::Twice => 2.0,
        }
    }
}

impl OtherSteps {
    /// The end of the run, and the length of its steps; `None` if it ends early.
    pub fn end(self) -> Option<(State, Length)> {
        let Settled { duration, choice, .. } = self.settled;
        let options = SimulationOptions {
            switched_off: &self.kept,
            interrupt: Some(&*self.interrupt),
            counted: self.counted.as_ref(),
            ..SimulationOptions::new(duration, choice.with_steps_times(self.length.factor()))
        };
        let mut simulation = Simulation::new(&self.model.description().mechanism, self.state, options).ok()?;
        simulation.run().ok()?;
        Some((simulation.finish().state, self.length))
    }
}
