//! What runs of groups of bodies hand on to the runs of other groups: how fine they are, the motions beside them, and their errors.
//!
//! ```text
//!     groups a, b, … ──▶ group c of some of their bodies:   companion of c = the companions of a, b, … there      its distance goes on to grow
//!                                                           error of c ≥ max of the errors of a, b, …
//!     opinions of c:  begin where its companion begins, so that they show no less than it had to show
//! ```
//!
//! The part of the distance that steps over events make the error goes on with it, and so does a finer companion: one finer among coarser ones makes all finer.
//! Errors that a companion does not show, of flights and rebounds that were left out, add up.

use crate::events::crowded::CrowdsSoFar;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::state::State;
use crate::simulation::tolerance::accuracy_so_far::AccuracySoFar;
use crate::simulation::tolerance::horizon::Horizon;
use crate::simulation::tolerance::terms::Terms;
use crate::stepping::length::stage_choice::StageChoice;

/// How fine a run is, and what its restarts have shown.
#[derive(Clone, Debug)]
pub(crate) struct Fineness {
    pub stop: f64,
    pub stages: StageChoice,
    /// How many times it was begun.
    pub begun: usize,
    pub may_begin_again: bool,
    pub may_refine: bool,
    /// The part of the accuracy that steps over events are made for.
    pub over_events: f64,
    pub horizon: Horizon,
}

impl Fineness {
    /// Of a run at its first beginning.
    pub fn first(mechanism: &Mechanism, terms: &Terms) -> Self {
        Fineness {
            stop: terms.first_stop(mechanism),
            stages: StageChoice::of(mechanism, terms.tolerance),
            begun: 1,
            may_begin_again: true,
            may_refine: true,
            over_events: terms.over_events,
            horizon: Horizon::default(),
        }
    }

    /// As fine as the finer one of both.
    #[must_use]
    pub fn with(self, other: &Fineness) -> Self {
        Fineness {
            stop: self.stop.min(other.stop),
            stages: if self.stages == StageChoice::Many { self.stages } else { other.stages },
            begun: self.begun.max(other.begun),
            may_begin_again: self.may_begin_again && other.may_begin_again,
            may_refine: self.may_refine && other.may_refine,
            over_events: self.over_events.min(other.over_events),
            horizon: if self.begun >= other.begun { self.horizon } else { other.horizon },
        }
    }
}

/// The motion beside a run at an instant, and whether it is the finer one of both.
#[derive(Clone)]
pub(crate) struct Companion {
    pub state: State,
    pub is_finer: bool,
}

/// What the run of a group hands on at an instant.
#[derive(Clone)]
pub(crate) struct Handed {
    /// That instant (s), and the steps on the way there.
    pub time: f64,
    pub steps: usize,
    pub fineness: Fineness,
    /// The motion beside it there, if it was carried on to that instant, and the part of the distance that is the error by steps of first order.
    pub companion: Option<Companion>,
    pub share: f64,
    /// The accuracy up to there.
    pub so_far: Option<AccuracySoFar>,
    /// The largest error that the motion beside it has shown, and the errors that it does not show (m).
    pub largest: f64,
    pub unseen: f64,
    /// The crowds of events that the run and the motion beside it have seen.
    pub crowds: [Option<CrowdsSoFar>; 2],
    /// Whether runs have parted, and since when they met different events (s).
    pub parted: bool,
    pub differ: Option<f64>,
    /// Whether efforts from outside have acted.
    pub driven: bool,
}

impl Handed {
    /// Adds what another group hands on to the same one; companions are put together by the caller.
    pub fn add(&mut self, other: &Handed) {
        self.fineness = self.fineness.clone().with(&other.fineness);
        self.so_far = AccuracySoFar::together(self.so_far.into_iter().chain(other.so_far));
        self.steps = self.steps.max(other.steps);
        self.largest = self.largest.max(other.largest);
        self.unseen = self.unseen.max(other.unseen);
        self.share = self.share.max(other.share);
        for (own, other) in self.crowds.iter_mut().zip(other.crowds) {
            *own = [*own, other].into_iter().flatten().reduce(CrowdsSoFar::with);
        }
        self.parted |= other.parted;
        self.differ = [self.differ, other.differ].into_iter().flatten().reduce(f64::min);
        self.driven |= other.driven;
    }
}
