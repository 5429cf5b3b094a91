//! The entries of the trace of a run: its steps, and the jumps between them.

use crate::events::effects::impact::Meeting;
use crate::events::finding::watched::Watched;
use crate::events::modes::mode::Mode;
use crate::instant::holding::held::Closures;
use crate::instant::holding::touching::Contact;
use crate::mechanism::motion::state::State;

/// A step of the scheme.
#[derive(Clone)]
pub(crate) struct TracedStep {
    /// The state of the whole mechanism at the start, and at the end, before the event there.
    pub start: State,
    pub end: State,
    pub mode: Mode,
    /// The states at the inner stages; empty if the step was made in another way.
    pub inside: Vec<State>,
    /// For each body whether its joint is held.
    pub held: Vec<bool>,
    /// The closed contacts as closures.
    pub closures: Closures,
    /// The functions that are zero at the end; empty for a step to a given instant.
    pub triggers: Vec<Watched>,
}

/// What happens at one instant.
#[derive(Clone)]
pub(crate) struct TracedJump {
    pub before: State,
    pub after: State,
    /// Limits and contacts that meet.
    pub meetings: Vec<Meeting>,
    pub contacts: Vec<Contact>,
}

/// An entry of a trace.
#[derive(Clone)]
pub(crate) enum Traced {
    Step(Box<TracedStep>),
    Jump(Box<TracedJump>),
}

/// The trace of a run so far.
#[derive(Clone)]
pub(crate) struct Trace {
    pub entries: Vec<Traced>,
    /// c of the inner stages of its steps.
    pub nodes: &'static [f64],
}
