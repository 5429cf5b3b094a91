//! What makes the steps of a run or island: the scheme, the scheme on another tree, or a motion with events.
//!
//! ```text
//!     StepMaker (stepping) ─▶ RunSteps: copies, the motion with events inside, targets of motors
//! ```

use crate::events::Eventful;
use crate::lobatto::coupled::counted::Counted;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::state::State;
use crate::stepping::integrator::Lobatto;
use crate::stepping::step_maker::StepMaker;
use crate::stepping::trees::other_tree::OnOtherTree;
use std::sync::Arc;

/// What makes the steps of a run or island. A motion without events has next to nothing to say here.
pub trait RunSteps: StepMaker {
    /// The same steps with the same past: they go on to the same bits.
    fn duplicate(&self) -> Box<dyn RunSteps>;

    /// The motion with events, if it has any.
    fn events(&self) -> Option<&Eventful> {
        None
    }

    /// The same, to be told of what changes.
    fn events_mut(&mut self) -> Option<&mut Eventful> {
        None
    }

    /// Takes the ranks of the closures in the state that the first step begins from. Events and limits hold joints, which leaves other mechanisms:
    /// they count anew, and so does another spanning tree.
    fn take_counted(&mut self, _counted: Option<Arc<Counted>>) {}

    /// Does what the first step from a state and under these inputs begins with, so that copies have it in common; `false` for steps that begin with
    /// little.
    fn begin(&mut self, _mechanism: &Mechanism, _inputs: Inputs, _state: &mut State) -> bool {
        false
    }

    /// Whether forces inside their cones are known to hold all closed contacts in the state at the end of the last step.
    fn holds_all(&self, _state: &State) -> bool {
        false
    }

    /// Gives a motor a target from now on.
    fn aim(&mut self, _motor: usize, _value: f64) {}
}

impl RunSteps for Lobatto {
    fn duplicate(&self) -> Box<dyn RunSteps> {
        Box::new(self.clone())
    }

    fn take_counted(&mut self, counted: Option<Arc<Counted>>) {
        Lobatto::take_counted(self, counted);
    }
}

impl RunSteps for OnOtherTree {
    fn duplicate(&self) -> Box<dyn RunSteps> {
        Box::new(self.clone())
    }
}

impl RunSteps for Eventful {
    fn duplicate(&self) -> Box<dyn RunSteps> {
        Box::new(self.clone())
    }

    fn events(&self) -> Option<&Eventful> {
        Some(self)
    }

    fn events_mut(&mut self) -> Option<&mut Eventful> {
        Some(self)
    }

    fn begin(&mut self, mechanism: &Mechanism, inputs: Inputs, state: &mut State) -> bool {
        self.begin_at(mechanism, inputs, state)
    }

    fn holds_all(&self, state: &State) -> bool {
        Eventful::holds_all(self, state)
    }

    fn aim(&mut self, motor: usize, value: f64) {
        Eventful::aim(self, motor, value);
    }
}
