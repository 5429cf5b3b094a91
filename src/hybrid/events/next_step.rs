//! The kind of the next step, and how a step ended: each is decided in one place, for the loop in [`crate::events::steps`].

use crate::events::finding::watched::Watched;
use crate::events::integrator::Eventful;
use crate::events::parts::model::HybridModel;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;

/// A step that does not look at all functions is no shorter than this (s).
const BLIND: f64 = 1e-9;
/// A step that passes a pair or a limit is no longer than this (s), and what closes moves by no more than this way in it (m or rad) if the shortest step
/// lets it; overlaps that it leaves are moved apart.
const BLIND_TO_BOUNDS: f64 = 1e-7;
const BLIND_WAY: f64 = 2e-10;
/// The longest step to a gap that closes at once (s).
const MOMENT: f64 = 1e-7;

/// The kind of the next step. A mode in which all bodies rest has steps, too: only the time goes on in them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum NextStep {
    /// All watched functions are looked at.
    Watched,
    /// Some are not, because their last events have left the mode as it was, or come back; the step is no longer than this (s).
    Passing { at_most: f64 },
    /// Of first order: events crowd, or no mode was decided.
    FirstOrder,
}

/// How a step ended.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Ending {
    /// As far as it was to go.
    Full,
    /// At events: these functions are zero there.
    AtEvent(Vec<Watched>),
    /// At events where it began: no time has passed.
    AtStart(Vec<Watched>),
    /// At a gap that closes sooner than a step can be solved: under constant accelerations.
    Ballistic(Vec<Watched>),
}

impl Ending {
    /// The functions that are zero there.
    pub fn triggers(&self) -> &[Watched] {
        match self {
            Ending::Full => &[],
            Ending::AtEvent(triggers) | Ending::AtStart(triggers) | Ending::Ballistic(triggers) => triggers,
        }
    }

    /// Whether no time has passed.
    pub fn is_at_start(&self) -> bool {
        matches!(self, Ending::AtStart(_))
    }

    /// Whether a step of this length (s) goes to a gap that closes at once. No certificate covers it; bodies move by a micrometre at 10 m/s.
    pub fn is_moment(&self, length: f64) -> bool {
        matches!(self, Ending::Ballistic(_)) && length <= MOMENT
    }

    /// Whether the scheme has made a step.
    pub fn is_of_scheme(&self) -> bool {
        matches!(self, Ending::Full | Ending::AtEvent(_))
    }
}

impl Eventful {
    /// Decides from the steps before of which kind the next one is, and counts it among those that may crowd.
    pub(super) fn next_step(&mut self, state: &State) -> NextStep {
        if self.is_crowded(state) {
            return NextStep::FirstOrder;
        }
        if self.progress.repeats.are_to_be_passed() {
            let shortest = self.shortest_passing(state.time);
            let at_most = self.progress.repeats.passing_length(shortest, self.longest_past_bounds(state));
            return NextStep::Passing { at_most };
        }
        self.progress.repeats.look_at_all();
        NextStep::Watched
    }

    /// How long a step may be (s) in which pairs and limits are passed that close; those that rest there, and scenes without pairs, have no bound.
    fn longest_past_bounds(&self, state: &State) -> f64 {
        let HybridModel { whole, elements, touching, .. } = &self.model;
        if touching.pairs.is_empty() {
            return f64::INFINITY;
        }
        let passes = |watched: &&Watched| matches!(watched, Watched::Approach(_) | Watched::Gap(..));
        let mut passed = self.progress.repeats.ignored.iter().filter(passes).peekable();
        if passed.peek().is_none() {
            return f64::INFINITY;
        }
        // Wheels that roll from one box to the next move fast, and close no gap.
        let mut later = state.clone();
        later.displace(whole, &state.velocity.iter().map(|rate| BLIND_TO_BOUNDS * rate).collect::<Vec<_>>());
        let bodies = [state, &later].map(|state| body_states(whole, state));
        let closing = passed.map(|watched| match *watched {
            Watched::Approach(pair) => {
                let [now, then] = [0, 1].map(|when| touching.gap(pair, &bodies[when]));
                (now - then) / BLIND_TO_BOUNDS
            }
            Watched::Gap(joint, _) => elements.joints[joint].rate(state).abs(),
            _ => 0.0,
        });
        (BLIND_WAY / closing.fold(0.0, f64::max)).min(BLIND_TO_BOUNDS)
    }

    /// An event that is nearer to the start of a step than this is there (s).
    pub(super) fn shortest_passing(&self, since: f64) -> f64 {
        BLIND.max(self.shortest(since))
    }
}
