//! Events that repeat, and the steps that pass them without looking at their functions.
//!
//! ```text
//!     > 20 events at one instant, or one that left the mode as it was    ─▶ a step that passes them
//!     its length:  shortest · 16ⁿ,  n ≤ 5 consecutive events that left the mode as it was;  ≤ 1e-7 s and 2e-10 m past a pair or a limit
//! ```
//!
//! A function may be zero at the start of step after step: on the dense output alone, by roundings, or because one event opens what the next one
//! closes. A step that does not look at it gets past. Overlaps that such a step leaves are moved apart at its end.
//!
//! Invariants: `ignored` is empty before a step that watches all functions; `unfounded` counts only events at the start of a step.

use crate::events::finding::cycle::Cycle;
use crate::events::finding::detection::ONE_INSTANT;
use crate::events::finding::watched::Watched;
use crate::events::modes::mode::Mode;
use crate::mechanism::motion::state::State;

/// Events at one instant before a step is made without a look at their functions.
const FLIPS: usize = 20;
/// Such a step is longer by this factor each time that its event left the mode unchanged.
const LONGER: f64 = 16.0;
/// The most such lengthenings.
const MOST_UNFOUNDED: i32 = 5;

/// The events at the instant where the last step ended, as far as they may repeat.
#[derive(Clone)]
pub(crate) struct Repeats {
    /// Number of events after the first one at an instant, and that instant (s).
    flips: (usize, f64),
    /// Modes in which steps ended where they began.
    cycle: Cycle,
    /// Consecutive events at the start of a step that left the mode unchanged.
    unfounded: i32,
    /// Whether the last event left the mode unchanged.
    looks_away: bool,
    /// Functions that the step does not look at.
    pub(crate) ignored: Vec<Watched>,
}

impl Repeats {
    /// No events so far.
    pub fn new() -> Self {
        Repeats { flips: (0, f64::MIN), cycle: Cycle::default(), unfounded: 0, looks_away: false, ignored: Vec::new() }
    }

    /// Whether the next step is to pass the last events without looking at their functions.
    pub fn are_to_be_passed(&self) -> bool {
        self.flips.0 > FLIPS || self.looks_away
    }

    /// How long that step may be (s), if an event within `shortest` of its start is there, and no longer one than `longest` may be made past what it ignores.
    pub fn passing_length(&self, shortest: f64, longest: f64) -> f64 {
        (shortest * LONGER.powi(self.unfounded)).min(longest.max(shortest))
    }

    /// The next step looks at all functions.
    pub fn look_at_all(&mut self) {
        self.ignored.clear();
    }

    /// Whether the last events were at this very time (s).
    pub fn are_at(&self, time: f64) -> bool {
        self.flips.1 == time
    }

    /// A step has ended at an event: in this mode and state, at its start or not. It has passed earlier ones or looked at all functions.
    pub fn see(&mut self, mode: &Mode, state: &State, at_start: bool, passed: bool) {
        self.flips = match self.flips {
            (count, time) if state.time - time <= ONE_INSTANT * time.abs().max(1.0) => (count + 1, time),
            _ => (0, state.time),
        };
        if at_start && !passed {
            self.cycle.see(mode, state);
        } else {
            self.cycle.leave();
        }
    }

    /// Notes the events of an instant among all watched functions: events that repeat there, or leave the mode unchanged, are not looked at in the
    /// next step.
    pub fn note(&mut self, triggers: &[Watched], at_start: bool, watched: &[Watched]) {
        if !at_start {
            self.ignored.clear();
        }
        for trigger in triggers {
            if !self.ignored.contains(trigger) {
                self.ignored.push(*trigger);
            }
        }
        // Contacts of one pair that slide leave their features at about the same time: one step without looking goes beyond all of these borders.
        if at_start && triggers.iter().any(|trigger| matches!(trigger, Watched::Feature(_))) {
            let borders = watched.iter().filter(|watched| matches!(watched, Watched::Feature(_)));
            let more: Vec<Watched> = borders.filter(|border| !self.ignored.contains(border)).copied().collect();
            self.ignored.extend(more);
        }
    }

    /// If an event at the start of a step has led back to a mode and state that were seen at this instant, all later ones would come back, too, and
    /// are passed: returns how many would have been counted. `fastest` is the largest velocity of the run [m/s or rad/s].
    pub fn close_cycle(&mut self, mode: &Mode, state: &State, fastest: f64) -> Option<usize> {
        if self.flips.0 > FLIPS || !self.cycle.comes_back(mode, state, fastest) {
            return None;
        }
        let left = FLIPS - self.flips.0;
        self.flips.0 = FLIPS + 1;
        Some(left)
    }

    /// Takes whether the event left the mode unchanged: an artefact of the dense output. The next step skips its function, and is longer each time
    /// that this happens.
    pub fn take_change(&mut self, unchanged: bool) {
        self.looks_away = unchanged;
        if self.looks_away || self.flips.0 > FLIPS {
            self.unfounded = (self.unfounded + 1).min(MOST_UNFOUNDED);
        }
    }

    /// A step was made that looked at all functions.
    pub fn advance(&mut self) {
        self.unfounded = 0;
    }
}
