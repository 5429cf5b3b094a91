//! The pairs that close in the last step: each pair that may is looked at, and takes its certificate.
//!
//! ```text
//!     rest of the reserve of a pair > 0                           ─▶ it cannot close: nothing is looked at         finding/reserves.rs
//!     ω h < least slope beside its closed vertices on a half space ─▶ no other vertex can touch                 closing_pairs.rs
//!     otherwise φ over the stretches of the step                  ─▶ a bracket, or a cover without a hole          finding/approach.rs
//! ```
//!
//! φ is the gap of a pair (m). The first bracket of all pairs ends the step ([`crate::events::location`]).

use crate::events::covered::{GapInside, SAME_END, resolution};
use crate::events::finding::approach::{Approaching, Closing, Measure, first_closing};
use crate::events::finding::cover::Cover;
use crate::events::finding::detection::{Bracket, ENDS, FIRST_SAMPLES, SAMPLES, close_in};
use crate::events::finding::speeds::Speeds;
use crate::events::finding::watched::Watched;
use crate::events::integrator::Eventful;
use crate::events::modes::instants::Inside;
use crate::events::modes::tolerances::AT_EVENT;

/// The root is looked for as in a step that is this many times as long as its bracket, to 1e-9 of that length. An end that is off by more than
/// roundings shows the slope.
const ROUGHLY: f64 = 10.0;
/// A pair that closes at the end of a step is looked at up to this part of it.
const NEARLY: f64 = 0.999;

impl Eventful {
    /// The first gap of a pair that closes in the last step before a time (s); a pair that is known to close at its end is looked at before that.
    pub(super) fn look_for_contacts(&mut self, since: f64, before: f64, known: Option<Bracket>) -> Option<Bracket> {
        self.trial.covers.clear();
        if !self.trial.watched.first().is_some_and(|first| matches!(first, Watched::Approach(_))) {
            return None;
        }
        let end = self.workspaces.active().small.time;
        let mut speeds = std::mem::take(&mut self.trial.speeds);
        let mut sampled = self.is_short_span();
        // Where bodies may come near, they have been taken.
        if self.model.touching.pairs.are_few() {
            self.take_speeds([since, end], &mut speeds);
        }
        self.trial.reserves.begin(&speeds, before - since);
        let mut first: Option<Bracket> = None;
        for place in 0..self.trial.reserves.asked().len() {
            let pair = self.trial.reserves.asked()[place];
            let Some(watched) = self.open_pair(pair) else { continue };
            // The only contact of balls is held: no other features can meet.
            if self.model.touching.pairs[pair].has_one_place() && self.is_closed(pair) {
                self.trial.covers.push((watched, Cover { until: end, least: f64::INFINITY }));
                continue;
            }
            let ends_it = known.is_some_and(|known| known.watched == watched);
            if !ends_it && self.turns_about_its_contacts(pair, &speeds, end - since) {
                self.trial.covers.push((watched, Cover { until: end, least: f64::INFINITY }));
                continue;
            }
            if let Some(rest) = self.reserve(pair, &speeds, before - since) {
                self.trial.covers.push((watched, Cover { until: end, least: rest }));
                continue;
            }
            if std::mem::take(&mut sampled) {
                self.sample_speeds([since, end], &mut speeds);
            }
            let of = &self.model.touching.pairs[pair];
            let resolution = resolution(of);
            let (zero, anew) = (of.within(AT_EVENT), of.closed_anew());
            let [speed, changing] = self.fastest_of(pair, &speeds, end - since);
            let measure = Measure {
                closed: if self.trial.fresh_pairs.holds(pair) { f64::INFINITY } else { zero },
                zero,
                speed,
                resolution,
                changing,
            };
            // A gap of more than can close in a stretch that is searched is as open as that of a pair that was open before.
            let mut gap = GapInside::new(self, [since, end], (watched, pair), resolution);
            let mut until = first.map_or(before, |known| known.high);
            let mut cover = Cover::from(since);
            // The pair at which the step ends was open until its bracket, which is shorter than the resolution.
            let own = known.filter(|known| known.watched == watched);
            if let Some(own) = own {
                until = until.min(own.low.clamp(since, since + NEARLY * (end - since)));
            }
            let closing = first_closing([since, until], SAMPLES, &measure, &mut gap, &mut cover);
            let found = match closing {
                None => None,
                Some(Closing::AtStart) => Some(Bracket::at_start(watched, since)),
                Some(Closing::Between(low, high)) => {
                    let length = (ROUGHLY * (high - low)).min(end - since);
                    Some(close_in(watched, low, high, false, length, &mut |time| gap.gap(time)))
                }
            };
            // A pair that closes at the end was open before.
            let at_end = |found: Bracket| found.root >= end - SAME_END * (end - since);
            if found.map_or(own.is_some(), |found| !found.at_start && at_end(found)) {
                // An end that overlaps is no root, but a jump from the inside of the step to its end.
                let there = gap.gap(end);
                if there >= -anew {
                    cover.take([cover.until, end], there);
                }
            }
            // A closed pair has the gap of its other features.
            if let (None, Some(at_end)) = (found, gap.at_end)
                && !self.is_closed(pair)
                && !self.model.touching.pairs[pair].is_reeved()
            {
                self.trial.reserves.note(pair, at_end);
            }
            self.trial.covers.push((watched, cover));
            if let Some(found) = found
                && first.is_none_or(|known| found.root < known.root)
            {
                first = Some(found);
            }
        }
        self.trial.speeds = speeds;
        first
    }

    /// The number of the watched gap of a pair, if it is looked at.
    pub(super) fn open_pair(&self, pair: usize) -> Option<usize> {
        let open = Watched::Approach(pair);
        let watched = Watched::gap_of(&self.trial.watched, pair)?;
        (!self.progress.repeats.ignored.contains(&open)).then_some(watched)
    }

    /// Whether a contact of a pair is closed, or kept by loops.
    pub(super) fn is_closed(&self, pair: usize) -> bool {
        self.mode.touches(pair)
    }

    /// The rest of the reserve of a pair at the end of the last step, of this length (s), if it lasts until there (m).
    fn reserve(&mut self, pair: usize, speeds: &Speeds, length: f64) -> Option<f64> {
        let of = &self.model.touching.pairs[pair];
        // Beside closed contacts other features have the gap, one after another, and no speed bounds its change. A rope goes through
        // more bodies than the two whose travel is known.
        if self.trial.fresh_pairs.holds(pair) || self.is_closed(pair) || of.is_reeved() {
            return None;
        }
        self.trial.reserves.lasts(pair, length * speeds.closing_of(of))
    }

    /// Whether a pair that is closed at vertices on a half space turns too little about them in the last step, of this length (s), for any other of its
    /// vertices to touch.
    fn turns_about_its_contacts(&self, pair: usize, speeds: &Speeds, length: f64) -> bool {
        if self.trial.fresh_pairs.holds(pair) {
            return false;
        }
        let closed = self.mode.touching(pair);
        let least = self.model.touching.turns_at_least(pair, closed, speeds.first());
        least.is_some_and(|least| length * speeds.turning_of(&self.model.touching.pairs[pair]) < least)
    }

    /// Whether a round shape has a closed contact with a plane.
    fn rolls(&self) -> bool {
        let pairs = &self.model.touching.pairs;
        self.mode.contacts.iter().any(|closed| pairs[closed.contact.pair].rolling.is_some())
    }

    /// Whether the last step is a span that is short beside the steps of the motion.
    pub(super) fn is_short_span(&self) -> bool {
        self.workspaces.active().steps.as_ref().is_some_and(|steps| steps.is_short_span())
    }

    /// Takes the speeds of the bodies in the last step, from its start to its end (s), as far as they are needed to tell whether a reserve lasts: in a
    /// short span those at its ends.
    pub(super) fn take_speeds(&mut self, [since, end]: [f64; 2], speeds: &mut Speeds) {
        speeds.reset(self.model.whole.bodies.len());
        for (sample, time) in ENDS.into_iter().zip([since, end]) {
            self.place(Inside::roughly(time));
            speeds.take(sample, &self.trial.bodies);
        }
        if !self.is_short_span() {
            self.sample_speeds([since, end], speeds);
        }
    }

    /// Takes the speeds of the bodies inside the last step, from its start to its end (s), at the samples that its motion needs.
    fn sample_speeds(&mut self, [since, end]: [f64; 2], speeds: &mut Speeds) {
        let first = FIRST_SAMPLES.len();
        let rest = (0..=SAMPLES).filter(|sample| !FIRST_SAMPLES.contains(sample));
        for (count, sample) in FIRST_SAMPLES.into_iter().chain(rest).enumerate() {
            // The tilt of what rolls may swing unseen beside its speed.
            if count == first && speeds.are_steady() && !self.rolls() {
                break;
            }
            if !ENDS.contains(&sample) {
                self.place(Inside::roughly(since + (end - since) * sample as f64 / SAMPLES as f64));
                speeds.take(sample, &self.trial.bodies);
            }
        }
    }

    /// Whether interpolation alone is accurate enough for the gap of a pair, as for pairs that were open before. Roundings count for gaps of touching
    /// pairs, unless no closure holds their bodies.
    pub(super) fn is_known_roughly(&self, pair: usize) -> bool {
        let was_open = !self.trial.fresh_pairs.holds(pair) && !self.is_closed(pair);
        was_open || self.trial.loose.are_loose(self.model.touching.pairs[pair].all_bodies())
    }

    /// The most that a pair can close by in the last step, of this length (s), by the speeds in it [m/s], and the most that this changes by in a
    /// second [m/s²].
    pub(super) fn fastest_of(&self, pair: usize, speeds: &Speeds, length: f64) -> [f64; 2] {
        let of = &self.model.touching.pairs[pair];
        match self.is_closed(pair) {
            true => speeds.beside_contacts(of, length),
            false => [speeds.closing_of(of), speeds.changing_of(of, length)],
        }
    }
}
