//! Gaps that close within a step, however fast the bodies are: no contact is missed.
//!
//! No point of two bodies moves faster towards the other body than
//!
//! ```text
//!     V = |v_a| + |v_b| + |ω_a| R_a + |ω_b| R_b        R: reach of a shape from the centre of mass of its body (m)
//! ```
//!
//! so a gap φ cannot close between two instants of distance τ while `φ₁ + φ₂ ≥ V τ`. Where it might, the middle is looked at, first the earlier half:
//! down to a 1536th of the step, where the parabola through three samples tells whether a minimum is below zero.
//!
//! Source: B. Mirtich, Impulse-based Dynamic Simulation, PhD thesis, Berkeley 1996, chapter 2 (conservative advancement).

use crate::events::finding::detection::soon_positive;

/// Halvings of each interval between samples, at most.
const DEPTH: usize = 20;
/// Bodies may be faster between the samples of a step than at them by this factor.
const FASTER: f64 = 1.25;
/// Speeds are steady while the least of them is this part of the largest.
const STEADY: f64 = 0.9;

/// What limits the speed of a gap over a step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Speeds {
    /// Largest speed of the centre of mass [m/s] and largest angular speed [rad/s] of each body.
    bodies: Vec<(f64, f64)>,
    /// The smallest.
    least: Vec<(f64, f64)>,
}

/// A gap that closes between two times (s): open at the first, closed at the second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Closing {
    /// Between these.
    Between(f64, f64),
    /// It is closed from the start on.
    AtStart,
}

impl Speeds {
    /// Nothing has moved.
    pub fn reset(&mut self, bodies: usize) {
        self.bodies.clear();
        self.bodies.resize(bodies, (0.0, 0.0));
        self.least.clear();
        self.least.resize(bodies, (f64::INFINITY, f64::INFINITY));
    }

    /// Takes a sample of the step.
    pub fn take(&mut self, body: usize, speed: f64, turning: f64) {
        let (fastest, most) = &mut self.bodies[body];
        (*fastest, *most) = (fastest.max(speed), most.max(turning));
        let (slowest, least) = &mut self.least[body];
        (*slowest, *least) = (slowest.min(speed), least.min(turning));
    }

    /// Whether no body has changed its speeds by more than a tenth, so that more samples would tell nothing.
    pub fn are_steady(&self) -> bool {
        let all = self.bodies.iter().zip(&self.least);
        all.into_iter().all(|(most, least)| least.0 >= STEADY * most.0 && least.1 >= STEADY * most.1)
    }

    /// V of two bodies with their reaches [m/s].
    pub fn closing(&self, bodies: [Option<usize>; 2], reach: [f64; 2]) -> f64 {
        let ends = bodies.iter().zip(reach).map(|(body, reach)| match *body {
            None => 0.0,
            Some(body) => {
                let (speed, turning) = self.bodies[body];
                speed + if turning > 0.0 { turning * reach } else { 0.0 }
            }
        });
        FASTER * ends.sum::<f64>()
    }
}

/// The first interval over `start … end` (s) in which a gap closes by more than the resolution (m), at a speed of at most V [m/s]. It counts as closed at the start if it is at most `noise` there.
pub(crate) fn first_closing(
    [start, end]: [f64; 2],
    samples: usize,
    noise: f64,
    [speed, resolution]: [f64; 2],
    gap: &mut impl FnMut(f64) -> f64,
) -> Option<Closing> {
    let time = |j: usize| if j == samples { end } else { start + (end - start) * j as f64 / samples as f64 };
    let mut low = (start, gap(start));
    // One look at the end is enough for what is far away.
    let last = gap(end);
    if low.1 > noise && last > 0.0 && low.1 + last >= speed * (end - start) {
        return None;
    }
    let mut next = 1;
    if low.1 <= noise {
        let value = gap(time(1));
        if value <= 0.0 {
            return Some(match soon_positive(start, time(1), gap) {
                Some((open, closed)) => Closing::Between(open, closed),
                None => Closing::AtStart,
            });
        }
        low = (time(1), value);
        next = 2;
    }
    for j in next..=samples {
        let high = (time(j), if j == samples { last } else { gap(time(j)) });
        if let Some((from, to)) = between(low, high, [speed, resolution], DEPTH, gap) {
            return Some(Closing::Between(from, to));
        }
        low = high;
    }
    None
}

/// The first interval between two samples in which the gap closes; the first of them is open.
fn between(
    low: (f64, f64),
    high: (f64, f64),
    [speed, resolution]: [f64; 2],
    depth: usize,
    gap: &mut impl FnMut(f64) -> f64,
) -> Option<(f64, f64)> {
    if high.1 > 0.0 && low.1 + high.1 >= speed * (high.0 - low.0) {
        return None;
    }
    if depth == 0 || speed * (high.0 - low.0) <= resolution {
        return (high.1 <= 0.0).then_some((low.0, high.0));
    }
    let at = 0.5 * (low.0 + high.0);
    let middle = (at, gap(at));
    if middle.1 <= 0.0 {
        return between(low, middle, [speed, resolution], depth - 1, gap).or(Some((low.0, middle.0)));
    }
    between(low, middle, [speed, resolution], depth - 1, gap)
        .or_else(|| between(middle, high, [speed, resolution], depth - 1, gap))
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
                let mut gap = |time: f64| (20.0 * (time - enters - 2.5e-4)).abs() - 5e-3;
                let found = first_closing([0.0, long], 6, 0.0, [20.0, 2e-3], &mut gap);
                let Some(Closing::Between(low, high)) = found else { panic!("missed, step {long}") };
                assert!(low <= enters && enters <= high + 5e-4, "{low} {enters} {high}");
            }
        }
    }

    #[test]
    fn speeds_are_steady_until_a_body_is_a_tenth_slower_or_turns_a_tenth_slower() {
        let steady = |samples: &[(f64, f64)]| {
            let mut speeds = Speeds::default();
            speeds.reset(2);
            for &(speed, turning) in samples {
                speeds.take(0, speed, turning);
                // One that rests is steady.
                speeds.take(1, 0.0, 0.0);
            }
            speeds.are_steady()
        };
        assert!(steady(&[(2.0, 1.0), (1.81, 0.91), (1.9, 0.95)]));
        assert!(!steady(&[(2.0, 1.0), (1.79, 0.91), (1.9, 0.95)]));
        assert!(!steady(&[(2.0, 1.0), (1.81, 0.89), (1.9, 0.95)]));
    }

    #[test]
    fn what_is_far_away_is_looked_at_twice() {
        let mut looks = 0;
        let mut gap = |time: f64| {
            looks += 1;
            3.0 - time
        };
        assert_eq!(first_closing([0.0, 1.0], 6, 0.0, [1.0, 1e-3], &mut gap), None);
        assert_eq!(looks, 2);
    }

    #[test]
    fn a_bounce_shorter_than_a_sample_is_found_from_a_closed_start() {
        let mut gap = |time: f64| time * (1e-4 - time);
        let found = first_closing([0.0, 1.0], 6, 1e-12, [1.0, 1e-3], &mut gap);
        let Some(Closing::Between(low, high)) = found else { panic!("missed") };
        assert!(low < 1e-4 && high >= 1e-4);
        assert_eq!(first_closing([0.0, 1.0], 6, 1e-12, [1.0, 1e-3], &mut |time: f64| -time), Some(Closing::AtStart));
    }
}
