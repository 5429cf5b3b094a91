//! The same run with half the step, on another core: its end tells the error of the steps.

use crate::lobatto::coupled::counted::Counted;
use crate::mechanism::description::rules::Rule;
use crate::mechanism::motion::state::State;
use crate::session::asked::Settled;
use crate::session::model::Model;
use crate::simulation::{Simulation, SimulationOptions};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// A run that is to be made with half the step.
pub(crate) struct Halved {
    pub model: Model,
    pub settled: Settled,
    pub state: State,
    pub counted: Option<Arc<Counted>>,
    pub kept: Vec<Rule>,
    pub interrupt: Arc<AtomicBool>,
}

impl Halved {
    /// The end of the run; `None` if it ends early.
    pub fn end(self) -> Option<State> {
        let Settled { duration, choice, .. } = self.settled;
        let options = SimulationOptions {
            switched_off: &self.kept,
            interrupt: Some(&*self.interrupt),
            counted: self.counted.as_ref(),
            ..SimulationOptions::new(duration, choice.with_half_the_step())
        };
        let mut simulation = Simulation::new(&self.model.description().mechanism, self.state, options).ok()?;
        simulation.run().ok()?;
        Some(simulation.finish().state)
    }
}
