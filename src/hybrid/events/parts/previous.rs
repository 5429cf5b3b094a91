//! The last step, for the next one and for reports: the state that it left, its mode, and the efforts in it.
//!
//! Invariants: `left` is the state after all events at the end of the step, so that a state that differs from it was given from outside; `outside`
//! are the efforts given from outside in it.

use crate::events::forces::reporting::Reporting;
use crate::events::modes::mode::{Mode, MotorMode};
use crate::events::modes::narrowed::Felt;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::ground::shared::Shared;
use crate::mechanism::motion::state::State;
use std::cell::RefCell;

/// What is kept of the last step.
#[derive(Clone)]
pub(crate) struct PreviousStep {
    /// The state after all events at its end.
    pub left: Option<State>,
    /// Its mode, where there are pairs that may touch.
    pub stepped_in: Option<Mode>,
    /// The modes of motors in it.
    pub motors: Vec<MotorMode>,
    /// Efforts in it that follow the state.
    pub felt: Felt,
    /// The efforts from outside in it.
    pub outside: Vec<f64>,
    /// For the forces that are reported.
    pub reporting: RefCell<Shared<Reporting>>,
}

impl PreviousStep {
    /// Before the first step.
    pub fn new(mechanism: &Mechanism) -> Self {
        PreviousStep {
            left: None,
            stepped_in: None,
            motors: Vec::new(),
            felt: Felt::default(),
            outside: Vec::new(),
            reporting: RefCell::new(Shared::new(Reporting::new(mechanism))),
        }
    }
}
