//! Whether the last step is covered: for each pair that may close in it a certificate without a hole, and the depth of overlaps in it.
//!
//! ```text
//!     Σ stretches of a pair = [t₀, t₀ + h],     overlap = max(0, −least gap)   of open pairs over the stretches, of closed contacts at x = 1/3 and 1
//! ```

use crate::events::finding::approach::Approaching;
use crate::events::finding::cover::{Cover, are_checked};
use crate::events::finding::detection::{FIRST_SAMPLES, SAMPLES};
use crate::events::finding::speeds::{speed_beside_contacts, speed_of};
use crate::events::finding::watched::{Seen, Watched};
use crate::events::integrator::Eventful;
use crate::events::modes::instants::Inside;
use crate::events::parts::model::HybridModel;
use crate::events::parts::trial::StepTrial;
use crate::instant::holding::pairs::Pair;
use crate::mechanism::motion::state::State;
use crate::mechanism::motion::touches::touch_motion;

/// Roots within this part of a step before its end are its end.
pub(super) const SAME_END: f64 = 1e-9;
/// Bodies move less in a moment (m).
const IN_A_MOMENT: f64 = 1e-6;
/// Closed contacts are looked at inside one span of this number: states inside spans are projected on the contacts, which takes as long as the span.
const SELDOM: usize = 16;
/// A gap that was larger than this part of what is open as interpolated is likely open.
const LIKELY: f64 = 0.5;
/// Overlaps of this part of the size of a pair are not missed between samples.
const RESOLUTION: f64 = 2e-3;
/// A stretch in which this part of its size can close is short enough to be searched, however thin the shapes are.
const FINEST: f64 = 1e-6;
/// Instants at which a step that is checked is asked.
const ASKED: usize = 48;

/// A stretch in which a pair closes by less than this is searched (m).
pub(super) fn resolution(of: &Pair) -> f64 {
    (RESOLUTION * of.size()).min(of.breadth).max(FINEST * of.size())
}

/// The gap of a pair inside the last step.
pub(super) struct GapInside<'e> {
    pub eventful: &'e mut Eventful,
    /// Start of the step (s).
    since: f64,
    /// Whether the dense output is used as interpolated.
    roughly: bool,
    /// Whether the pair has a closed contact, so that its gap is that of its other features.
    beside_contacts: bool,
    /// Its number among the watched functions, and among the pairs.
    watched: usize,
    pair: usize,
    /// A gap of more than this is open as interpolated, however it began (m).
    open: f64,
    /// The instant at which it was looked at last, if it is open as interpolated there (s), and the gap at the look before (m).
    seen_open: Option<f64>,
    before: f64,
    /// The end of the step (s), and the gap there once it was asked for (m).
    end: f64,
    pub at_end: Option<f64>,
}

impl<'e> GapInside<'e> {
    /// The gap of a pair, by its number among the watched functions and among the pairs, in a step between two times (s). A gap of more than `open` is
    /// open as interpolated (m).
    pub fn new(eventful: &'e mut Eventful, [since, end]: [f64; 2], (watched, pair): (usize, usize), open: f64) -> Self {
        let roughly = eventful.is_known_roughly(pair);
        let beside_contacts = eventful.is_closed(pair);
        let (seen_open, before, at_end) = (None, f64::INFINITY, None);
        GapInside { eventful, since, roughly, beside_contacts, watched, pair, open, seen_open, before, end, at_end }
    }

    /// An instant of the step, as accurate as the pair needs it there.
    fn inside(&self, time: f64) -> Inside {
        Inside { time, roughly: self.roughly || self.seen_open == Some(time) }
    }

    /// Its gap at an instant (m).
    fn gap_at(&mut self, instant: Inside) -> f64 {
        let number = self.eventful.look_at(instant);
        let Eventful {
            model: HybridModel { elements, touching, .. },
            trial: StepTrial { holding, sample, watched, inside, slips, turns, looks, .. },
            mode,
            ..
        } = &mut *self.eventful;
        *looks += usize::from(touching.pairs[self.pair].is_dense());
        let (since, time, state, bodies) = (self.since, instant.time, sample, inside.bodies(number));
        // The value for a pair does not ask for the state.
        let seen = Seen { elements, touching, mode, holding, since, time, state, bodies, slips, turns };
        watched[self.watched].value(&seen)
    }
}

impl Approaching for GapInside<'_> {
    fn gap(&mut self, time: f64) -> f64 {
        // A state on all closures costs ten times as much, and differs where gaps are about zero. Where the gap was small at the look before, it is
        // likely needed.
        if !self.roughly && time > self.since && time < self.end && self.before > LIKELY * self.open {
            let interpolated = self.gap_at(Inside::roughly(time));
            self.seen_open = (interpolated > self.open).then_some(time);
            if self.seen_open.is_some() {
                self.before = interpolated;
                return interpolated;
            }
        }
        let value = self.gap_at(self.inside(time));
        self.before = value;
        if time == self.end {
            self.at_end = Some(value);
        }
        value
    }

    fn least_gap(&mut self, time: f64, enough: f64) -> f64 {
        let number = self.eventful.look_at(self.inside(time));
        let Eventful { model: HybridModel { touching, .. }, trial: StepTrial { inside, .. }, .. } = &*self.eventful;
        let least = touching.least_distance(self.pair, inside.bodies(number), enough);
        if time == self.end {
            self.at_end = Some(least);
        }
        least
    }

    fn speed(&mut self, time: f64) -> f64 {
        let number = self.eventful.look_at(self.inside(time));
        let Eventful { model: HybridModel { touching, .. }, trial: StepTrial { inside, .. }, .. } = &*self.eventful;
        let of = &touching.pairs[self.pair];
        let speed = if self.beside_contacts { speed_beside_contacts } else { speed_of };
        speed(of, inside.bodies(number))
    }
}

impl Eventful {
    /// A bound of the overlap of all pairs in the steps so far (m): at their ends, and between them.
    pub fn overlap(&self) -> f64 {
        self.trial.overlap
    }

    /// Whether a pair that may close has a stretch of the last step in which it was not looked at.
    pub(super) fn has_hole(&self, since: f64) -> bool {
        let end = self.workspaces.active().small.time;
        let covered = end - SAME_END * (end - since);
        let until = |watched: usize| {
            // They are in the order of their numbers.
            let own = self.trial.covers.binary_search_by_key(&watched, |(watched, _)| *watched);
            own.map_or(f64::NEG_INFINITY, |place| self.trial.covers[place].1.until)
        };
        // The reserves of all others last.
        let mut asked = self.trial.reserves.asked().iter().filter_map(|&pair| self.open_pair(pair));
        end > since && asked.any(|watched| until(watched) < covered)
    }

    /// Whether all open pairs but these are apart by more than bodies move in a moment, at its end.
    pub(super) fn closes_alone(&mut self, triggers: &[Watched], end: &State) -> bool {
        let Eventful {
            model: HybridModel { whole, touching, .. },
            trial: StepTrial { bodies, placed, near, .. },
            mode,
            ..
        } = self;
        placed.place(whole, end, bodies);
        let closes = |pair: usize| triggers.contains(&Watched::Approach(pair));
        let is_closed = |pair: usize| mode.touches(pair);
        let is_apart = |pair: usize| touching.distance_within(pair, bodies, IN_A_MOMENT) >= IN_A_MOMENT;
        near.pairs().iter().all(|&pair| closes(pair) || is_closed(pair) || is_apart(pair))
    }

    /// Bounds how deep shapes overlap in the last step (m).
    pub(super) fn bound_overlap(&mut self, since: f64) {
        let end = self.workspaces.active().small.time;
        self.trial.evaluated.bodies = false;
        let mut least = self.trial.covers.iter().map(|(_, cover)| cover.least).fold(0.0, f64::min);
        if !self.mode.contacts.is_empty() && end > since {
            let short = self.is_short_span();
            let inside = (!short || self.tally.steps.is_multiple_of(SELDOM))
                .then(|| since + (end - since) * FIRST_SAMPLES[1] as f64 / SAMPLES as f64);
            for time in inside.into_iter().chain([end]) {
                self.place(Inside::at(time));
                let gaps =
                    self.mode.contacts.iter().map(|closed| touch_motion(&closed.contact.joint, &self.trial.bodies).gap);
                least = gaps.fold(least, f64::min);
            }
        }
        // A step that does not look at a pair knows its ends alone: between them it moves by less than a micrometre.
        if self.progress.repeats.ignored.iter().any(|watched| matches!(watched, Watched::Approach(_))) {
            self.place(Inside::at(end));
            for watched in &self.progress.repeats.ignored {
                if let Watched::Approach(pair) = watched {
                    least = least.min(self.model.touching.distance_within(*pair, &self.trial.bodies, 0.0));
                }
            }
        }
        self.trial.overlap = self.trial.overlap.max(-least);
    }

    /// Asks whether the pairs that were left out of the last step have their certificates, and are as far apart at its ends and halfway.
    fn check_left_out(&mut self, since: f64, end: f64) {
        let touching = self.model.touching.clone();
        let pairs = &touching.pairs;
        if pairs.are_few() || self.progress.asleep {
            return;
        }
        let (near, speeds) = (&self.trial.near, &self.trial.speeds);
        let moves = |body: usize| (end - since) * speeds.seen_from(Some(body), None, 0.0);
        let left_out = |pair: &usize| near.pairs().binary_search(pair).is_err();
        let left_out: Vec<usize> = (0..pairs.len()).filter(left_out).collect();
        for &pair in &left_out {
            let proved = near.proves_apart(pairs, pair, speeds.first(), moves);
            assert!(proved, "pair {pair} is left out from {since} to {end} s, and its bodies are not at home");
        }
        for time in [since, 0.5 * (since + end), end] {
            self.place(Inside::roughly(time));
            for &pair in &left_out {
                let [a, b] = pairs.bodies_of(pair).map(|body| body.unwrap_or_default());
                let apart = (self.trial.bodies[a].position - self.trial.bodies[b].position).norm();
                let gap = apart - pairs.reach_of(a) - pairs.reach_of(b);
                assert!(gap > 0.0, "pair {pair} is left out, and its bodies are {gap:e} m apart at {time} s");
            }
        }
    }

    /// Asks the last step at many instants whether its certificates are true: no pair overlaps in a covered stretch, or moves faster than its bound.
    ///
    /// # Panics
    /// If it is not: in tests and in debug builds alone.
    pub(super) fn check_covers(&mut self, since: f64) {
        if !(are_checked() || cfg!(debug_assertions)) {
            return;
        }
        let end = self.workspaces.active().small.time;
        assert!(!self.has_hole(since), "a hole in the step from {since} to {end} s: {:?}", self.trial.covers);
        self.check_left_out(since, end);
        for watched in 0..Watched::after_gaps(&self.trial.watched) {
            let Watched::Approach(pair) = self.trial.watched[watched] else { continue };
            if self.open_pair(pair).is_none() {
                continue;
            }
            let looked_at = self.trial.covers.iter().find(|(known, _)| *known == watched).map(|(_, cover)| *cover);
            let cover = looked_at.unwrap_or_else(|| Cover { until: end, least: self.trial.reserves.at_end(pair) });
            // A step of first order may have left as much.
            let (allowed, most) = (
                self.model.touching.pairs[pair].closed_anew(),
                self.fastest_of(pair, &self.trial.speeds, end - since)[0],
            );
            // A pair that waits is far apart: its bound holds at the ends and halfway. One that is open as interpolated is open.
            let open = resolution(&self.model.touching.pairs[pair]);
            let (asked, open) = if looked_at.is_some() { (ASKED, open) } else { (2, f64::INFINITY) };
            for part in 0..=asked {
                let time = since + (cover.until.min(end) - since) * part as f64 / asked as f64;
                let mut inside = GapInside::new(self, [since, end], (watched, pair), open);
                let (gap, speed) = (inside.gap(time), inside.speed(time));
                assert!(gap >= -allowed, "pair {pair} overlaps by {:e} m at {time} s, in a step from {since} s", -gap);
                let lasts = looked_at.is_some() || gap >= cover.least - allowed;
                assert!(lasts, "pair {pair} is {gap:e} m apart at {time} s, not {:e} m at least", cover.least);
                // Velocities are rounded, too. Bodies that are faster by less than a hundredth of their gap cannot close it unseen.
                let farther = (speed - most) * (end - since);
                assert!(
                    farther <= allowed.max(0.01 * gap),
                    "pair {pair} moves at {speed} m/s at {time} s, not {most} m/s at most"
                );
            }
        }
    }
}
