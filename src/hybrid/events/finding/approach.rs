//! Gaps that close within a step, however fast the bodies are: no contact is missed.
//!
//! No gap φ closes faster than V ([`crate::events::finding::speeds`]). It cannot close between two instants of distance τ while `φ₁ + φ₂ ≥ V τ`. If it might, the middle is looked at, first the earlier half, until `V τ` is less than a resolution.
//! There a minimum that lies between is searched. A gap that is closed at the start and open later is looked at from both sides: at instants whose
//! distances from the start are powers of a quarter, the first of which is nearer than the resolution. So every instant belongs to a stretch
//! ([`crate::events::finding::cover`]).
//!
//! Source: B. Mirtich, Impulse-based Dynamic Simulation, PhD thesis, Berkeley 1996, chapter 2 (conservative advancement).

use crate::events::finding::cover::Cover;
use crate::events::finding::detection::{least_below_zero, soon_positive};
use crate::events::finding::speeds::speed_between;

/// Halvings of each interval between samples, at most: the resolution is reached before, unless bodies are as fast as light.
const DEPTH: usize = 44;
/// A gap that was closed at the start is looked at at instants that are nearer to it by this factor each.
const NEARER: f64 = 0.25;
/// The most such instants.
const NEAREST: i32 = 24;
/// A parabola that is least beyond the ends of a stretch by this part of its half has no minimum in it.
const AT_END: f64 = 1.2;
/// A parabola that is least near an end is looked at this far inside.
const INSIDE: f64 = 0.98;
/// A gap that closes between two times (s): open at the first, closed at the second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Closing {
    /// Between these.
    Between(f64, f64),
    /// It is closed from the start on.
    AtStart,
}

/// A pair inside a step.
pub(crate) trait Approaching {
    /// Its gap at a time (s), in metres.
    fn gap(&mut self, time: f64) -> f64;

    /// A lower bound of its gap at a time (s), in metres, for little work, and for a little more if the first one is at most `enough` (m).
    fn least_gap(&mut self, _time: f64, _enough: f64) -> f64 {
        f64::NEG_INFINITY
    }

    /// V of its bodies there [m/s].
    fn speed(&mut self, time: f64) -> f64;

    /// A look at it at a time (s).
    fn look(&mut self, time: f64) -> Seen {
        let gap = self.gap(time);
        Seen { time, gap, speed: self.speed(time) }
    }
}

/// A pair at an instant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen {
    time: f64,
    gap: f64,
    /// V of its bodies at this instant [m/s].
    speed: f64,
}

/// The bounds and resolution for the search of a gap.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Measure {
    /// It counts as closed at the start if it is at most this (m).
    pub closed: f64,
    /// At other instants it counts as closed if it is below minus this (m).
    pub zero: f64,
    /// V over the whole step [m/s].
    pub speed: f64,
    /// A stretch in which no more than this can close (m) is searched for a minimum.
    pub resolution: f64,
    /// The most that V changes by in a second [m/s²].
    pub changing: f64,
}

/// The first interval over `start … end` (s) in which a gap closes; `cover` takes the stretches before it, or all.
pub(crate) fn first_closing(
    [start, end]: [f64; 2],
    samples: usize,
    measure: &Measure,
    pair: &mut impl Approaching,
    cover: &mut Cover,
) -> Option<Closing> {
    let time = |j: usize| if j == samples { end } else { start + (end - start) * j as f64 / samples as f64 };
    // Lower bounds are enough for most pairs.
    let closes = measure.speed * (end - start);
    let at_start = pair.least_gap(start, closes);
    if at_start > measure.zero {
        let at_end = pair.least_gap(end, closes);
        if at_end > 0.0 && at_start + at_end >= closes {
            cover.take([start, end], at_start.min(at_end));
            return None;
        }
    }
    let mut low = pair.look(start);
    // One look at the end is enough for distant bodies.
    let last = pair.look(end);
    if low.gap > measure.closed && last.gap > 0.0 && low.gap + last.gap >= closes {
        cover.take([start, end], low.gap.min(last.gap));
        return None;
    }
    let mut next = 1;
    if low.gap <= measure.closed {
        // One that has just left is among its roundings first, of either sign, as long as its force begins at zero.
        let roundings = if measure.closed.is_infinite() { measure.zero } else { 0.0 };
        let mut look = |j: usize| if j == samples { last } else { pair.look(time(j)) };
        let mut first = look(1);
        while next < samples && first.gap.abs() <= roundings {
            next += 1;
            first = look(next);
        }
        if first.gap.is_nan() {
            return None;
        }
        if first.gap <= -roundings {
            let Some((open, closed)) = soon_positive(start, first.time, &mut |time| pair.gap(time)) else {
                return Some(Closing::AtStart);
            };
            let (open, closed) = (pair.look(open), pair.look(closed));
            if let Some(closing) = leaving(low, open, measure, pair, cover) {
                return Some(closing);
            }
            // Between the two it may pass through, and come back from the other side.
            return between(open, closed, measure, DEPTH, pair, cover).map(|(from, to)| Closing::Between(from, to));
        }
        if let Some(closing) = leaving(low, first, measure, pair, cover) {
            return Some(closing);
        }
        low = first;
        next += 1;
    }
    for j in next..=samples {
        let high = if j == samples { last } else { pair.look(time(j)) };
        if let Some((from, to)) = between(low, high, measure, DEPTH, pair, cover) {
            return Some(Closing::Between(from, to));
        }
        low = high;
    }
    None
}

/// The first interval in which a gap closes again that is closed at the start, and open at a later instant.
fn leaving(
    start: Seen,
    open: Seen,
    measure: &Measure,
    pair: &mut impl Approaching,
    cover: &mut Cover,
) -> Option<Closing> {
    let nearer = |steps: i32| start.time + (open.time - start.time) * NEARER.powi(steps);
    let far = |steps: i32| measure.speed * (nearer(steps) - start.time) > measure.resolution;
    let nearest = (0..NEAREST).find(|&steps| !far(steps)).unwrap_or(NEAREST);
    let closed = Seen { gap: 0.0, ..start };
    let mut low = closed;
    for steps in (0..=nearest).rev() {
        let high = if steps == 0 { open } else { pair.look(nearer(steps)) };
        // A gap that opens from zero with a force that begins at zero is among its roundings first, of either sign.
        if low.gap <= measure.zero {
            // It has not left yet, by less than a resolution.
            if high.gap < -measure.zero {
                let soon = soon_positive(start.time, high.time, &mut |time| pair.gap(time));
                return Some(soon.map_or(Closing::AtStart, |(open, closed)| Closing::Between(open, closed)));
            }
            if high.gap > 0.0
                && let Some(to) = dip(closed, high, measure, pair, cover)
            {
                let soon = soon_positive(start.time, to, &mut |time| pair.gap(time));
                return Some(soon.map_or(Closing::AtStart, |(open, closed)| Closing::Between(open, closed)));
            }
            // Where it leaves late, it is looked at as where a step begins. One that is among its roundings at both instants has been searched for a dip.
            let long = measure.speed * (high.time - low.time) > measure.resolution;
            if high.gap > measure.zero
                && low.time > start.time
                && long
                && let Some(closing) = leaving(low, high, measure, pair, cover)
            {
                return Some(closing);
            }
            cover.take([low.time, high.time], high.gap.min(0.0));
        } else if let Some((from, to)) = between(low, high, measure, DEPTH, pair, cover) {
            return Some(Closing::Between(from, to));
        }
        low = high;
    }
    None
}

/// The first interval between two instants in which the gap closes; the first of them is open.
fn between(
    low: Seen,
    high: Seen,
    measure: &Measure,
    depth: usize,
    pair: &mut impl Approaching,
    cover: &mut Cover,
) -> Option<(f64, f64)> {
    let long = high.time - low.time;
    // Soon after the start of a long step bodies are much slower than later.
    let own = speed_between([low.speed, high.speed], measure.changing, long);
    let closes = own.min(measure.speed) * long;
    if high.gap > 0.0 && low.gap + high.gap >= closes {
        cover.take([low.time, high.time], low.gap.min(high.gap));
        return None;
    }
    if depth == 0 || closes <= measure.resolution {
        if high.gap <= 0.0 {
            return Some((low.time, high.time));
        }
        let dips = dip(low, high, measure, pair, cover).map(|to| (low.time, to));
        if dips.is_none() && !high.gap.is_nan() {
            cover.take([low.time, high.time], low.gap.min(high.gap));
        }
        return dips;
    }
    let middle = pair.look(0.5 * (low.time + high.time));
    if middle.gap <= 0.0 {
        return between(low, middle, measure, depth - 1, pair, cover).or(Some((low.time, middle.time)));
    }
    between(low, middle, measure, depth - 1, pair, cover)
        .or_else(|| between(middle, high, measure, depth - 1, pair, cover))
}

/// An instant in a short stretch at which a gap that is open at both ends is closed, if its minimum is.
///
/// ```text
///     φ(x) ≈ φ₀ + s x + c x²/2,  x = −1, 0, 1 at the ends and in the middle        least at x = −s/c if c > 0, by s²/2c below φ₀
/// ```
fn dip(low: Seen, high: Seen, measure: &Measure, pair: &mut impl Approaching, cover: &mut Cover) -> Option<f64> {
    let half = 0.5 * (high.time - low.time);
    let middle = (low.time + half, pair.gap(low.time + half));
    cover.least = cover.least.min(middle.1);
    if middle.1 < -measure.zero {
        return Some(middle.0);
    }
    let (slope, bend) = (0.5 * (high.gap - low.gap), low.gap - 2.0 * middle.1 + high.gap);
    let at = -slope / bend;
    if !(bend > 0.0 && at.abs() < AT_END) {
        return None;
    }
    let at = at.clamp(-INSIDE, INSIDE);
    let below = -(slope + 0.5 * bend * at) * at;
    // As much below its parabola as that is below the middle, and a tenth of its bend: farther off it does not touch.
    if middle.1 - 2.0 * below - 0.1 * bend > -measure.zero {
        return None;
    }
    let least = (middle.0 + at * half, pair.gap(middle.0 + at * half));
    cover.least = cover.least.min(least.1);
    if least.1 < -measure.zero {
        return Some(least.0);
    }
    let mut value = |time: f64| pair.gap(time) + measure.zero;
    let bracketed = least.1 <= low.gap.min(high.gap);
    if bracketed { least_below_zero(low.time, high.time, least.0, least.1 + measure.zero, &mut value) } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thin_wall_is_met_however_long_the_step() {
        // A point passes a wall of 1 cm at 20 m/s: both ends of every step are far outside.
        for long in [0.05, 0.2, 1.0] {
            for offset in 0..37 {
                let enters = 0.013 * long * f64::from(offset) / 37.0 + 0.4 * long;
                let gap = |time: f64| (20.0 * (time - enters - 2.5e-4)).abs() - 5e-3;
                let found = look(gap, 20.0, [0.0, long], 0.0, 2e-3).0;
                let Some(Closing::Between(low, high)) = found else { panic!("missed, step {long}") };
                assert!(low <= enters && enters <= high + 5e-4, "{low} {enters} {high}");
            }
        }
    }

    #[test]
    fn what_is_far_away_is_looked_at_twice() {
        let mut looks = 0;
        let gap = |time: f64| {
            looks += 1;
            3.0 - time
        };
        let (found, cover) = look(gap, 1.0, [0.0, 1.0], 0.0, 1e-3);
        assert_eq!((found, looks), (None, 2));
        assert_eq!(cover, Cover { until: 1.0, least: 2.0 });
    }

    #[test]
    fn a_bounce_shorter_than_a_sample_is_found_from_a_closed_start() {
        let gap = |time: f64| time * (1e-4 - time);
        let Some(Closing::Between(low, high)) = look(gap, 1.0, [0.0, 1.0], 1e-12, 1e-3).0 else { panic!("missed") };
        assert!(low < 1e-4 && high >= 1e-4);
        assert_eq!(look(|time: f64| -time, 1.0, [0.0, 1.0], 1e-12, 1e-3).0, Some(Closing::AtStart));
    }

    #[test]
    fn what_leaves_at_the_start_is_covered_from_there_on_and_found_when_it_comes_back_through_a_thin_wall() {
        // A ball leaves a wall of 1 cm at v, comes back at 2 v/g, and is beyond the wall at the first of six samples whenever the step is long
        // enough.
        let (radius, wall) = (2e-3, 1e-2);
        for long in [0.3, 1.0, 2.5, 10.0] {
            for leaves in [1e-3, 0.03, 0.5, 2.0] {
                let back = 2.0 * leaves / 9.81;
                let height = |time: f64| leaves * time - 0.5 * 9.81 * time * time;
                let gap = |time: f64| height(time).max(-height(time) - wall - 2.0 * radius);
                let (found, cover) = look(gap, leaves + 9.81 * long, [0.0, long], f64::INFINITY, 1e-3);
                if back >= long {
                    assert_eq!((found, cover.until), (None, long), "{long} {leaves}");
                    continue;
                }
                let Some(Closing::Between(low, high)) = found else { panic!("missed: {long} {leaves} {found:?}") };
                assert!(low <= back && (back..back + 1e-2).contains(&high), "{low} {back} {high}");
                assert_eq!(cover.until, low, "{long} {leaves}: what is before the interval is covered");
            }
        }
    }

    #[test]
    fn a_gap_that_leaves_among_its_roundings_does_not_close_there() {
        // A release: the force begins at zero, and the gap grows with t³. Roundings of either sign hide it for the first 1e-5 of the step.
        for turn in 0..40 {
            let rounding = |time: f64| 3e-13 * (1e9 * time + f64::from(turn)).sin();
            let (found, cover) =
                look(|time| 100.0 * time.powi(3) + rounding(time), 1.0, [0.0, 1e-2], f64::INFINITY, 1e-8);
            assert_eq!((found, cover.until), (None, 1e-2), "{turn}");
        }
    }

    #[test]
    fn a_gap_that_stays_among_its_roundings_before_it_opens_is_looked_at_a_few_hundred_times() {
        // A box slides off one belt onto another at the same height: 2^24 looks, as if it left between any two of them.
        let looks = std::cell::Cell::new(0);
        let gap = |time: f64| {
            looks.set(looks.get() + 1);
            1e-17 * (1e9 * time).sin() + 0.3 * (time - 0.4).max(0.0)
        };
        let (found, cover) = look(gap, 0.3, [0.0, 0.6], f64::INFINITY, 1e-10);
        assert_eq!((found, cover.until), (None, 0.6));
        assert!(looks.get() < 1000, "{} looks", looks.get());
    }

    #[test]
    fn what_comes_back_from_the_other_side_by_the_first_sample_is_found_where_it_came_first() {
        // Gone through at 0.1 s, out at 0.12 s, and in another wall at 0.16 s, where the first of six samples is.
        let gap = |time: f64| if time < 0.05 { time } else { (0.1 - time).max((time - 0.12).min(0.16 - time)) };
        let Some(Closing::Between(low, high)) = look(gap, 1.0, [0.0, 1.0], f64::INFINITY, 1e-3).0 else {
            panic!("missed")
        };
        assert!(low <= 0.1 && (0.1..0.102).contains(&high), "{low} {high}");
    }

    #[test]
    fn a_graze_that_is_shorter_than_the_resolution_is_found_and_one_that_misses_is_not() {
        // The gap dips to −d or to +d within 2e-4 s at 1 m/s, with a resolution of 1e-2 m, between the instants that halving looks at.
        for place in 0..50 {
            let at = 0.2 + 0.6 * f64::from(place) / 50.0;
            for (depth, hits) in [(1e-9, true), (1e-6, true), (-1e-9, false)] {
                let gap = |time: f64| 0.5 * (time - at).powi(2) - depth;
                let (found, cover) = look(gap, 1.0, [0.0, 1.0], 0.0, 1e-2);
                assert_eq!(found.is_some(), hits, "{at} {depth}");
                assert!(hits || cover.until == 1.0);
            }
        }
    }

    /// The first closing of a gap (m) at a speed of at most V, and the covered stretches.
    fn look(
        gap: impl FnMut(f64) -> f64,
        speed: f64,
        span: [f64; 2],
        closed: f64,
        resolution: f64,
    ) -> (Option<Closing>, Cover) {
        struct Plain<F>(F, f64);
        impl<F: FnMut(f64) -> f64> Approaching for Plain<F> {
            fn gap(&mut self, time: f64) -> f64 {
                self.0(time)
            }
            fn speed(&mut self, _: f64) -> f64 {
                self.1
            }
        }
        let mut cover = Cover::from(span[0]);
        let measure = Measure { closed, zero: 1e-12, speed, resolution, changing: f64::INFINITY };
        let found = first_closing(span, 6, &measure, &mut Plain(gap, speed), &mut cover);
        (found, cover)
    }
}
