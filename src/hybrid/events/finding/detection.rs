//! The first sign change of a watched function within a step, on dense output.
//!
//! Samples are at `x_j = j/6`; the thirds of the step come first. A function whose least value there is more than twice its change is not looked
//! at any further: a step that has the accuracy of its stages is shorter than a wave and a half. Under loads in time, which may be quicker than the
//! motion, all samples come first. A sign that changes between two samples is a bracket. Between two samples that are positive the function may dip
//! below zero ([`crate::events::finding::dips`]). The start of a step may be a root itself, of an element that has just changed its state. It counts as
//! positive, and if the first sample is negative, an earlier positive one is looked for.
//!
//! The root of the dense output is of lower order than the ends of steps. So it only starts the location of the event.

use crate::events::finding::dips::{DIP_LOOKS, bend_before, dips};
use std::ops::Range;

/// Samples of a step besides its start.
pub(crate) const SAMPLES: usize = 6;
/// The samples at which pairs are looked at first: certificates cover the stretches between.
pub(crate) const FIRST_SAMPLES: [usize; 3] = [0, 2, SAMPLES];
/// Both ends.
pub(crate) const ENDS: [usize; 2] = [0, SAMPLES];
/// The samples at which other functions are looked at first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum First {
    /// Both ends: a span that is short beside the steps of the motion, in which forces change in proportion to time.
    Ends,
    /// Both ends, and the thirds between: a step of the motion.
    Thirds,
    /// Every sample: a step under loads in time.
    All,
}

impl First {
    pub fn samples(self) -> &'static [usize] {
        match self {
            First::Ends => &ENDS,
            First::Thirds => &[0, 2, 4, SAMPLES],
            First::All => &[0, 1, 2, 3, 4, 5, SAMPLES],
        }
    }
}

/// A function is not looked at any more if its least value there exceeds this many times its change.
const CALM: f64 = 2.0;
/// Halvings of the first interval in search of a positive value.
const HALVINGS: i32 = 44;
/// The root is bracketed to this part of the step.
const WIDTH: f64 = 1e-10;
/// In short steps late in a run, the root is bracketed to the roundings of times.
const SAME_INSTANT: f64 = 2.0 * f64::EPSILON;

/// A bracket in time (s) of the first root of a function: positive at `low`, negative at `high`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bracket {
    /// Which function.
    pub watched: usize,
    pub low: f64,
    pub high: f64,
    /// About where (s).
    pub root: f64,
    /// About its rate there.
    pub slope: f64,
    /// Whether it is negative from the start on.
    pub at_start: bool,
}

impl Bracket {
    /// The bracket of a function that is negative from the start (s) on.
    pub fn at_start(watched: usize, start: f64) -> Self {
        Bracket { watched, low: start, high: start, root: start, slope: 0.0, at_start: true }
    }
}

/// Instants that are nearer to each other are one (relative to one second, or to the time if that is more).
pub(crate) const ONE_INSTANT: f64 = 1e-12;

/// Room for a look at a step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Looking {
    /// The functions that are looked at, the value that counts as zero for each, and the same at the start: infinite where it begins there.
    pub which: Vec<usize>,
    pub zero: Vec<f64>,
    pub noise: Vec<f64>,
    /// The numbers of functions that ring through zero, which are left out.
    pub ringing: Vec<usize>,
    pub room: Room,
}

/// Room for the samples of a look.
#[derive(Clone, Debug, Default)]
pub(crate) struct Room {
    /// Sample after sample.
    values: Vec<f64>,
    /// Which functions the first of them have shown to stay far from zero.
    calm: Vec<bool>,
    /// Whether a function was too rough to tell whether it dips below zero in the last look.
    pub unclear: bool,
}

/// The first sign change of any function over `start … end` (s): `sample(time, which, values)` evaluates those that are asked for. Values down to
/// `−noise` of a function count as zero at the start, and changes up to `zero` as no change. Functions that the `first` samples show far from zero are
/// not looked at any further.
///
/// Allocates only where there are more functions than ever before.
pub(crate) fn first_sign_change(
    room: &mut Room,
    count: usize,
    start: f64,
    end: f64,
    [zero, noise]: [&[f64]; 2],
    first: First,
    mut sample: impl FnMut(f64, Range<usize>, &mut [f64]),
) -> Option<Bracket> {
    let length = end - start;
    let time = |j: usize| if j == SAMPLES { end } else { start + length * j as f64 / SAMPLES as f64 };
    let Room { values, calm, unclear } = room;
    *unclear = false;
    values.resize(count * (SAMPLES + 1), 0.0);
    let first = first.samples();
    for &j in first {
        sample(time(j), 0..count, &mut values[j * count..][..count]);
    }
    calm.clear();
    calm.extend((0..count).map(|watched| is_calm(first.iter().map(|j| values[j * count + watched]))));
    for j in (0..=SAMPLES).filter(|j| !first.contains(j)) {
        for watched in (0..count).filter(|&watched| !calm[watched]) {
            sample(time(j), watched..watched + 1, &mut values[j * count + watched..][..1]);
        }
    }
    let mut earliest: Option<Bracket> = None;
    for watched in (0..count).filter(|&watched| !calm[watched]) {
        let of: [f64; SAMPLES + 1] = std::array::from_fn(|j| values[j * count + watched]);
        let mut value = |at: f64| {
            if let Some(j) = (0..=SAMPLES).find(|&j| time(j) == at) {
                return of[j];
            }
            let mut one = [0.0];
            sample(at, watched..watched + 1, &mut one);
            one[0]
        };
        let mut looks = DIP_LOOKS;
        let found = bracket(&of, &time, [zero[watched], noise[watched]], &mut looks, &mut value);
        *unclear |= looks == 0;
        let Some((low, high, at_start)) = found else {
            continue;
        };
        // Whatever is still positive at a known root has its own later.
        if earliest.is_some_and(|known| low >= known.root || !at_start && value(known.root) > 0.0) {
            continue;
        }
        let found = close_in(watched, low, high, at_start, length, &mut value);
        // No root is earlier than the start.
        if at_start {
            return Some(found);
        }
        if earliest.is_none_or(|known| found.root < known.root) {
            earliest = Some(found);
        }
    }
    earliest
}

/// Whether a function stays far from zero: it is larger at all samples than all that it changes by between them, several times.
fn is_calm(samples: impl Iterator<Item = f64>) -> bool {
    let (least, most) =
        samples.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), value| (least.min(value), most.max(value)));
    least > 0.0 && (least == f64::INFINITY || least > CALM * (most - least))
}

/// The first interval in which the sampled function becomes negative: positive at its start, negative at its end.
fn bracket(
    of: &[f64],
    time: &impl Fn(usize) -> f64,
    [zero, noise]: [f64; 2],
    looks: &mut u32,
    value: &mut impl FnMut(f64) -> f64,
) -> Option<(f64, f64, bool)> {
    for j in 1..of.len() {
        let interval = [(time(j - 1), of[j - 1]), (time(j), of[j])];
        let below = if of[j] < 0.0 {
            Some(time(j))
        } else if j > 1 || noise.is_finite() {
            dips(interval, bend_before(of, j, time(j) - time(j - 1)), zero, looks, value)
        } else {
            // One that has just changed its state leaves zero, and is among roundings first.
            None
        };
        let Some(below) = below else { continue };
        if j > 1 || of[0] > noise {
            return Some((time(j - 1), below, false));
        }
        return Some(match soon_positive(time(0), below, value) {
            Some((near, high)) => (near, high, false),
            None if of[j] < 0.0 => (time(0), time(0), true),
            None => (time(0), below, true),
        });
    }
    None
}

/// An interval soon after the start in which a function that is negative at the end changes its sign: the longest halved interval at whose end it is
/// positive, and the one before. Such a function is positive from the start on, so that every fourth halving is asked first.
pub(crate) fn soon_positive(start: f64, end: f64, value: &mut impl FnMut(f64) -> f64) -> Option<(f64, f64)> {
    let at = |halvings: i32| start + (end - start) * 0.5_f64.powi(halvings);
    let found = (1..=HALVINGS / 4).map(|four| 4 * four).find(|&halvings| value(at(halvings)) > 0.0)?;
    let first = (found - 3..found).find(|&halvings| value(at(halvings)) > 0.0).unwrap_or(found);
    Some((at(first), if first == 1 { end } else { at(first - 1) }))
}

/// A point between two where the function is negative, if its minimum is: golden section.
pub(crate) fn least_below_zero(
    mut low: f64,
    mut high: f64,
    mut middle: f64,
    mut least: f64,
    value: &mut impl FnMut(f64) -> f64,
) -> Option<f64> {
    const GOLDEN: f64 = 0.381_966_011_250_105;
    let width = high - low;
    for _ in 0..40 {
        let (left, right) = (middle - low, high - middle);
        let trial = if left > right { middle - GOLDEN * left } else { middle + GOLDEN * right };
        let found = value(trial);
        if found < 0.0 {
            return Some(trial);
        }
        if found < least {
            if trial < middle {
                high = middle
            } else {
                low = middle
            }
            (middle, least) = (trial, found);
        } else if trial < middle {
            low = trial;
        } else {
            high = trial;
        }
        // The remainder of a parabola below its least sample, seen from the sides: a part of 1e-12 of its change.
        if high - low < (1e-6 * width).max(SAME_INSTANT * high.abs()) {
            break;
        }
    }
    None
}

/// Narrows a bracket by the method of false position (Illinois).
pub(crate) fn close_in(
    watched: usize,
    low: f64,
    high: f64,
    at_start: bool,
    length: f64,
    value: &mut impl FnMut(f64) -> f64,
) -> Bracket {
    let (mut a, mut b) = (low, high);
    if at_start {
        return Bracket { watched, low, high, root: low, slope: 0.0, at_start };
    }
    let (mut above, mut below) = (value(a).max(0.0), value(b));
    let mut slope = (below - above) / (b - a);
    let mut last = 0;
    for _ in 0..60 {
        if b - a <= (WIDTH * length).max(SAME_INSTANT * b.abs()) || above <= 0.0 || below >= 0.0 {
            break;
        }
        let secant = a + (b - a) * (above / (above - below));
        let middle = if secant > a && secant < b { secant } else { 0.5 * (a + b) };
        let found = value(middle);
        if b - a > 1e-4 * length {
            slope = (below - above) / (b - a);
        }
        if found > 0.0 {
            (a, above) = (middle, found);
            below *= if last == 1 { 0.5 } else { 1.0 };
            last = 1;
        } else {
            (b, below) = (middle, found);
            above *= if last == -1 { 0.5 } else { 1.0 };
            last = -1;
        }
    }
    // An end at which the function is zero is the root, however wide the bracket is. A start at which it is zero is not: it has left from there.
    let root = if below == 0.0 { b } else { 0.5 * (a + b) };
    Bracket { watched, low, high, root, slope, at_start }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn first(function: impl Fn(f64) -> f64) -> Option<Bracket> {
        first_sign_change(&mut Room::default(), 1, 0.0, 1.0, [&[1e-12]; 2], First::Thirds, |time, _, values| {
            values[0] = function(time)
        })
    }

    #[test]
    fn the_end_of_a_bracket_at_which_the_function_is_zero_is_its_root() {
        // Another event ends the step there at the same instant, to the last digit.
        let root = |function: fn(f64) -> f64| close_in(0, 0.5, 1.0, false, 1.0, &mut |time| function(time)).root;
        assert_eq!(root(|time| 3.0 * (1.0 - time)), 1.0);
        // The first secant of a line is its root.
        assert_eq!(root(|time| 0.75 - time), 0.75);
    }

    #[test]
    fn two_roots_between_samples_are_found_by_the_minimum() {
        // The ends of the samples miss almost all of these 400 parabolas, which dip below zero for less than a sixth of the step.
        for place in 0..40 {
            for depth in 1..=10 {
                let (at, depth) = (0.2 + 0.6 * f64::from(place) / 40.0, f64::from(depth) * 1e-3);
                let function = |time: f64| 5.0 * (time - at).powi(2) - depth;
                let root = at - (depth / 5.0).sqrt();
                let found = first(function).unwrap_or_else(|| panic!("missed {at}, {depth}"));
                assert!((found.root - root).abs() < 1e-7, "{} for {root}", found.root);
            }
        }
    }

    #[test]
    fn dips_of_waves_are_found_wherever_they_are_between_samples_and_at_the_ends_of_the_step() {
        // A quarter of a wave to more than a half over the step, whose trough is below zero for a part of 1e-3 to 0.1 of it.
        for turns in [0.25, 0.4, 0.6] {
            for place in 0..60 {
                for depth in [1e-6, 1e-4, 1e-2] {
                    let at = f64::from(place) / 60.0 + 1e-3;
                    let angular = std::f64::consts::TAU * turns;
                    let function = |time: f64| 1.0 - depth - (angular * (time - at)).cos();
                    let half = (1.0_f64 - depth).acos() / angular;
                    if at - half <= 0.0 {
                        continue;
                    }
                    let found = first(function).unwrap_or_else(|| panic!("missed {turns}, {at}, {depth}"));
                    // The bracket to 1e-10 of the step, and roundings of the cosine over its slope.
                    assert!((found.root - (at - half)).abs() < 1e-9, "{} for {}", found.root, at - half);
                }
            }
        }
    }

    #[test]
    fn a_whole_wave_over_the_step_that_is_the_same_at_both_ends_and_a_third_of_it_is_not_taken_for_calm() {
        let wave = |time: f64| 0.9 - (std::f64::consts::TAU * time - std::f64::consts::FRAC_PI_3).cos();
        assert!((wave(0.0) - wave(1.0 / 3.0)).abs() + (wave(0.0) - wave(1.0)).abs() < 1e-15);
        let root = 1.0 / 6.0 - 0.9_f64.acos() / std::f64::consts::TAU;
        let found = first(wave).expect("a root");
        assert!((found.root - root).abs() < 1e-9, "{} for {root}", found.root);
    }

    #[test]
    fn a_dip_before_the_first_sample_is_found_of_a_function_that_falls_at_the_start_from_next_to_nothing() {
        // A limit that a joint approaches from 1e-12, and leaves again before a sixth of the step: it has a root at about 1e-10.
        for speed in [1e-2, 0.1, 1.0, 4.0] {
            let function = |time: f64| 1e-12 - speed * time + 30.0 * time * time;
            let found = first(function).unwrap_or_else(|| panic!("missed {speed}"));
            assert!(!found.at_start && function(found.low) > 0.0 && function(found.high) < 0.0, "{found:?}");
            // The root to the width of brackets.
            assert!((found.root - 1e-12 / speed).abs() < WIDTH, "{found:?} at {speed}");
        }
    }

    #[test]
    fn a_function_that_stays_far_from_zero_is_looked_at_four_times_and_one_that_comes_near_at_all_samples() {
        let looks = |function: &dyn Fn(f64) -> f64| {
            let mut count = 0;
            let found = first_sign_change(
                &mut Room::default(),
                1,
                0.0,
                1.0,
                [&[1e-12]; 2],
                First::Thirds,
                |time, _, values| {
                    count += 1;
                    values[0] = function(time);
                },
            );
            (count, found.is_some())
        };
        // It changes by 0.4, and is 0.8 at least; the other is 0.79.
        assert_eq!(looks(&|time| 1.21 - 0.4 * time), (First::Thirds.samples().len(), false));
        assert_eq!(looks(&|time| 1.19 - 0.4 * time), (SAMPLES + 1, false));
        // A function that is not looked at: infinite, as of an element without bound.
        assert_eq!(looks(&|_| f64::INFINITY), (First::Thirds.samples().len(), false));
        // Negative from the start on, however little it changes.
        assert!(looks(&|_| -1.0).1);
        // A function that stays at zero, to roundings: as of a joint that is held by all that it can bear.
        assert_eq!(looks(&|time| 1e-16 * (1e3 * time).sin().abs()), (SAMPLES + 1, false));
        assert_eq!(looks(&|_| 0.0), (SAMPLES + 1, false));
    }

    #[test]
    fn the_start_is_no_root_and_one_soon_after_it_is_found() {
        // A bounce that ends at 1e-4 of the step: positive only before.
        let found = first(|time| time * (1e-4 - time)).expect("a root");
        assert!((found.root - 1e-4).abs() < 1e-10, "{found:?}");
        assert!(first(|time| time * time).is_none());
        assert!(first(|time| -time).expect("at once").at_start);
    }
}
