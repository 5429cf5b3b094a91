//! Gaps that close within a step, however fast the bodies are: no contact is missed.
//!
//! Seen from body b, no point of body a moves faster than
//!
//! ```text
//!     V = |u| + |ω| R_a,    u = v_a − v_b − ω_b × (c_a − c_b),   ω = ω_a − ω_b        R_a: reach of a shape from the centre of mass c_a of its body (m)
//! ```
//!
//! and the same holds with a and b exchanged: what falls together does not approach, however fast it falls. A gap φ cannot close between two instants of
//! distance τ while `φ₁ + φ₂ ≥ V τ`. Where it might, the middle is looked at, first the earlier half:
//! down to a 1536th of the step, where the parabola through three samples tells whether a minimum is below zero.
//!
//! Source: B. Mirtich, Impulse-based Dynamic Simulation, PhD thesis, Berkeley 1996, chapter 2 (conservative advancement).

use crate::events::finding::detection::{SAMPLES, soon_positive};
use crate::mechanism::description::body_state::{BodyState, WORLD};
use nalgebra::Vector3;

/// Halvings of each interval between samples, at most.
const DEPTH: usize = 20;
/// Bodies may be faster between the samples of a step than at them by this factor,
const FASTER: f64 = 1.25;
/// and by this part of what their velocity changes by from a sample to the next.
const CHANGING: f64 = 0.5;
/// Speeds are steady while the least of them is this part of the largest.
const STEADY: f64 = 0.9;

/// What limits the speed of a gap over a step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Speeds {
    /// Number of bodies, and where they are at each sample of the step, sample after sample.
    count: usize,
    bodies: Vec<BodyState>,
    /// Which samples are known.
    known: [bool; SAMPLES + 1],
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
        self.count = bodies;
        self.bodies.resize(bodies * (SAMPLES + 1), WORLD);
        self.known = [false; SAMPLES + 1];
    }

    /// Takes a sample of the step.
    pub fn take(&mut self, sample: usize, bodies: &[BodyState]) {
        self.bodies[sample * self.count..][..self.count].copy_from_slice(bodies);
        self.known[sample] = true;
    }

    /// The known samples, in the order of their times.
    fn samples(&self) -> impl Iterator<Item = usize> + '_ {
        (0..=SAMPLES).filter(|&sample| self.known[sample])
    }

    /// A body, or the world, at a sample.
    fn at(&self, sample: usize, body: Option<usize>) -> &BodyState {
        body.map_or(&WORLD, |body| &self.bodies[sample * self.count + body])
    }

    /// Whether no body has changed its speeds by more than a tenth, so that more samples would tell nothing.
    pub fn are_steady(&self) -> bool {
        let steady = |body: usize, speed: fn(&BodyState) -> f64| {
            let speeds = self.samples().map(|sample| speed(self.at(sample, Some(body))));
            let (least, most) =
                speeds.fold((f64::INFINITY, 0.0_f64), |(least, most), speed| (least.min(speed), most.max(speed)));
            least >= STEADY * most
        };
        (0..self.count).all(|body| {
            steady(body, |state| state.velocity.norm()) && steady(body, |state| state.angular_velocity.norm())
        })
    }

    /// V of two bodies with their reaches [m/s].
    pub fn closing(&self, [a, b]: [Option<usize>; 2], reach: [f64; 2]) -> f64 {
        match (a, b) {
            (Some(_), None) => self.seen_from(a, b, reach[0]),
            (None, Some(_)) => self.seen_from(b, a, reach[1]),
            _ => self.seen_from(a, b, reach[0]).min(self.seen_from(b, a, reach[1])),
        }
    }

    /// V of a body with its reach, seen from another [m/s].
    fn seen_from(&self, body: Option<usize>, other: Option<usize>, reach: f64) -> f64 {
        let (mut speed, mut turning, mut change) = (0.0_f64, 0.0_f64, 0.0_f64);
        let mut before: Option<[Vector3<f64>; 2]> = None;
        let times_reach = |turning: f64| if turning > 0.0 { turning * reach } else { 0.0 };
        for sample in self.samples() {
            let (own, from) = (self.at(sample, body), self.at(sample, other));
            let carried = from.velocity + from.angular_velocity.cross(&(own.position - from.position));
            let (moves, turns) = (own.velocity - carried, own.angular_velocity - from.angular_velocity);
            (speed, turning) = (speed.max(moves.norm()), turning.max(turns.norm()));
            if let Some([moved, turned]) = before {
                change = change.max((moves - moved).norm() + times_reach((turns - turned).norm()));
            }
            before = Some([moves, turns]);
        }
        FASTER * (speed + times_reach(turning)) + CHANGING * change
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
            for (sample, &(speed, turning)) in samples.iter().enumerate() {
                let moving = BodyState {
                    velocity: Vector3::new(0.0, speed, 0.0),
                    angular_velocity: Vector3::new(turning, 0.0, 0.0),
                    ..WORLD
                };
                // One that rests is steady.
                speeds.take(sample, &[moving, WORLD]);
            }
            speeds.are_steady()
        };
        assert!(steady(&[(2.0, 1.0), (1.81, 0.91), (1.9, 0.95)]));
        assert!(!steady(&[(2.0, 1.0), (1.79, 0.91), (1.9, 0.95)]));
        assert!(!steady(&[(2.0, 1.0), (1.81, 0.89), (1.9, 0.95)]));
    }

    #[test]
    fn what_falls_and_turns_together_does_not_approach() {
        // Two bodies on one rigid motion, 0.3 m apart, 5 m/s and 7 rad/s: nothing of one moves as seen from the other. The second is then 0.1 m/s faster,
        // and turns by 0.2 rad/s more, so that with a reach of 0.5 m its points are faster by at most 0.2 m/s.
        let spin = Vector3::new(3.0, -2.0, 6.0);
        let fall = Vector3::new(0.0, 0.0, -5.0);
        let apart = Vector3::new(0.1, 0.2, -0.2);
        let first = BodyState { velocity: fall, angular_velocity: spin, ..WORLD };
        let carried = BodyState { position: apart, velocity: fall + spin.cross(&apart), ..first };
        let faster = BodyState {
            velocity: carried.velocity + Vector3::new(0.0, 0.1, 0.0),
            angular_velocity: spin + Vector3::new(0.0, 0.0, 0.2),
            ..carried
        };
        let closing = |second: BodyState, reach: [f64; 2]| {
            let mut speeds = Speeds::default();
            speeds.reset(2);
            [0, 2, SAMPLES].into_iter().for_each(|sample| speeds.take(sample, &[first, second]));
            speeds.closing([Some(0), Some(1)], reach)
        };
        assert!(closing(carried, [0.5, 0.5]) < 1e-14);
        // Seen from the first, whose own reach does not matter.
        let found = closing(faster, [1e3, 0.5]);
        assert!((found - FASTER * 0.2).abs() < 1e-14, "{found}");
        // Beside the world every point of the first falls and turns.
        let mut speeds = Speeds::default();
        speeds.reset(1);
        speeds.take(0, &[first]);
        assert!((speeds.closing([Some(0), None], [0.5, f64::INFINITY]) - FASTER * (5.0 + 0.5 * 7.0)).abs() < 1e-14);
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
