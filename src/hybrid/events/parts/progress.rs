//! The progress of a run with events: what the next step depends on beside the state and its mode.
//!
//! Invariants: `asleep` only if all bodies rest and nothing acts that changes with time; `quiet` counts steps at rest in a row; `in_crowd` only for
//! mechanisms that have a workspace for steps over many impacts.

use crate::events::parts::jams::Jams;
use crate::events::parts::repeats::Repeats;
use crate::events::parts::spells::Spells;
use crate::events::parts::spending::Spending;
use crate::instant::holding::blocks::Of;
use crate::mechanism::motion::state::State;
use nalgebra::Vector3;

/// The length of the first step over slips (s).
const FIRST: f64 = 5e-4;

/// A slip that passes near its stop, as it was in the last step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pass {
    /// Its contact, among the closed ones, and the pair of that.
    pub contact: usize,
    pub pair: usize,
    /// How fast it changes [m/s²].
    pub rate: Vector3<f64>,
}

/// The progress of a run.
#[derive(Clone)]
pub(crate) struct Progress {
    /// When the run began (s).
    pub began: f64,
    /// When the present mode was entered (s).
    pub entered: f64,
    /// Whether a given instant bounds the next step, and not only the end of the run.
    pub bounded: bool,
    /// Events that may repeat, and the functions that the step does not look at.
    pub repeats: Repeats,
    /// The slips that pass near their stops now.
    pub passes: Vec<Pass>,
    /// What exact steps have spent on events.
    pub spending: Spending,
    /// Crowds of events that follow each other, and steps that could not be made.
    pub spells: Spells,
    pub jams: Jams,
    /// Whether the run makes steps over many impacts now.
    pub in_crowd: bool,
    /// Whether hard dampers of a mechanism without shapes let events follow each other without an end.
    pub chatters: bool,
    /// Whether it begins in a crowd that another run has met.
    pub goes_on_in_crowd: bool,
    /// Whether they are those that keep to the tolerance by an estimate of their own, and the length of the next one (s).
    pub is_careful: bool,
    pub careful: f64,
    /// Whether the error of the run is estimated, which steps over events end.
    pub estimated: bool,
    /// Whether runs that differ by roundings have met other events before, so that no step can be accurate.
    pub beyond_horizon: bool,
    /// Whether the laws could not be solved at all where the last step ended: the next one is of first order.
    pub undecided: bool,
    /// The limit or contact on which joints that are moved in time press without end; a contact is named by its pair.
    pub blocked: Option<Of>,
    /// Whether all bodies rest on contacts, and stay there until the next event.
    pub asleep: bool,
    /// Consecutive steps at rest.
    pub quiet: usize,
    /// The end of the last step, if it has no inside: one of first order, or one under constant accelerations.
    pub stepped_over: Option<State>,
}

impl Progress {
    /// Before the first step.
    pub fn new() -> Self {
        Progress {
            began: 0.0,
            entered: f64::NEG_INFINITY,
            bounded: false,
            repeats: Repeats::new(),
            passes: Vec::new(),
            spending: Spending::NONE,
            spells: Spells::NONE,
            jams: Jams::NONE,
            in_crowd: false,
            chatters: false,
            goes_on_in_crowd: false,
            is_careful: false,
            careful: FIRST,
            estimated: false,
            beyond_horizon: false,
            undecided: false,
            blocked: None,
            asleep: false,
            quiet: 0,
            stepped_over: None,
        }
    }
}
