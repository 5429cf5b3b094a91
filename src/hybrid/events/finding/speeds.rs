//! How fast the gap of a pair can close within a step.
//!
//! Seen from body b, no point of body a moves faster than
//!
//! ```text
//!     V = |u| + |ω| R_a,    u = v_a − v_b − ω_b × (c_a − c_b),   ω = ω_a − ω_b     R_a: reach of a shape from the centre of mass c_a of its body (m)
//! ```
//!
//! and the same holds with a and b exchanged: bodies that fall together do not approach, however fast they fall. Shapes of revolution do not approach by turning
//! about their axes ([`crate::instant::holding::revolving`]).
//!
//! Bodies are known at the samples of a step, and between them at instants that are looked at. V is their largest speed at the samples, a quarter
//! more, and half of its change from one sample to the next. For a stretch the speeds at its ends are enough, with half of the change that is
//! possible in that time, and a quarter more, if that is less.
//!
//! Source: B. Mirtich, Impulse-based Dynamic Simulation, PhD thesis, Berkeley 1996, chapter 2.

use crate::events::finding::detection::SAMPLES;
use crate::geometry::Revolved;
use crate::instant::holding::pairs::Pair;
use crate::instant::holding::revolving::without_spin;
use crate::instant::moved::{CHANGING, FASTER};
use crate::mechanism::description::body_state::{BodyState, WORLD};
use nalgebra::Vector3;

/// Speeds are steady while the least of them is this part of the largest.
const STEADY: f64 = 0.9;

/// The speeds of bodies that bound the rate of a gap over a step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Speeds {
    /// Number of bodies, and where they are at each sample of the step, sample after sample.
    count: usize,
    bodies: Vec<BodyState>,
    /// Which samples are known.
    known: [bool; SAMPLES + 1],
}

impl Speeds {
    /// The speeds of bodies at rest.
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

    /// The bodies at the start of the step.
    pub fn first(&self) -> &[BodyState] {
        &self.bodies[..self.count]
    }

    /// The bodies at its end.
    pub fn last(&self) -> &[BodyState] {
        &self.bodies[SAMPLES * self.count..][..self.count]
    }

    /// The known samples, in the order of their times.
    fn samples(&self) -> impl Iterator<Item = usize> + Clone + '_ {
        (0..=SAMPLES).filter(|&sample| self.known[sample])
    }

    /// A body, or the world, at a sample.
    fn at(&self, sample: usize, body: Option<usize>) -> &BodyState {
        body.map_or(&WORLD, |body| &self.bodies[sample * self.count + body])
    }

    /// Whether every body has kept its speeds to a tenth, so that more samples would add no information.
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

    /// V of a pair [m/s].
    pub fn closing_of(&self, pair: &Pair) -> f64 {
        Between::all(pair).map(|between| self.closing(&between)).sum()
    }

    /// The most that V of a pair changes by in a second [m/s²]; `length` is the length of the step (s).
    pub fn changing_of(&self, pair: &Pair, length: f64) -> f64 {
        Between::all(pair).map(|between| self.changing(&between, length)).sum()
    }

    /// V of a pair with a closed contact [m/s], and the most that it changes by in a second [m/s²]; `length` is the length of the step (s).
    pub fn beside_contacts(&self, pair: &Pair, length: f64) -> [f64; 2] {
        let Some(rolling) = &pair.rolling else { return [self.closing_of(pair), self.changing_of(pair, length)] };
        let motions = self.samples().map(|sample| rolling.motion(self.at(sample, Some(rolling.body))));
        let weights = [1.0, rolling.shape.reach];
        [fastest(motions.clone(), weights), self.changes(motions, weights, length)]
    }

    /// The same bound of the angular speed of the bodies of a pair seen from each other [rad/s].
    pub fn turning_of(&self, pair: &Pair) -> f64 {
        let [a, b] = pair.bodies;
        fastest(self.samples().map(|sample| relative([self.at(sample, a), self.at(sample, b)])), [0.0, 1.0])
    }

    /// V of two bodies [m/s].
    fn closing(&self, between: &Between) -> f64 {
        let seen = |side: usize| fastest(self.motions(between, side), [1.0, between.reach[side]]);
        match between.ends {
            [Some(_), None] => seen(0),
            [None, Some(_)] => seen(1),
            _ => seen(0).min(seen(1)),
        }
    }

    /// The largest change of u and ω, at the reach, from a sample to the next, over the time between them [m/s²]; `length` is the length of the step
    /// (s).
    fn changing(&self, between: &Between, length: f64) -> f64 {
        let seen = |side: usize| self.changes(self.motions(between, side), [1.0, between.reach[side]], length);
        match between.ends {
            [Some(_), None] => seen(0),
            [None, Some(_)] => seen(1),
            _ => seen(0).max(seen(1)),
        }
    }

    /// The motion of one of two bodies, seen from the other, at the known samples.
    fn motions<'s>(&'s self, between: &'s Between, side: usize) -> impl Iterator<Item = Motion> + Clone + 's {
        let at = move |sample: usize, side: usize| between.moves(side, self.at(sample, between.ends[side]));
        self.samples().map(move |sample| relative([&at(sample, side), &at(sample, 1 - side)]))
    }

    /// The largest change of u and ω at the known samples, with these weights, from one to the next, over the time between them [m/s²].
    fn changes(&self, motions: impl Iterator<Item = Motion> + Clone, weights: [f64; 2], length: f64) -> f64 {
        let times = self.samples().zip(self.samples().skip(1));
        let rates = motions.clone().zip(motions.skip(1)).zip(times).map(|((before, after), (from, to))| {
            change([before, after], weights) * SAMPLES as f64 / ((to - from) as f64 * length)
        });
        rates.fold(0.0, f64::max)
    }

    /// V of a body with its reach, seen from another, or from the world [m/s].
    pub fn seen_from(&self, body: Option<usize>, other: Option<usize>, reach: f64) -> f64 {
        fastest(self.samples().map(|sample| relative([self.at(sample, body), self.at(sample, other)])), [1.0, reach])
    }
}

/// u and ω of a body, seen from another [m/s, rad/s].
type Motion = [Vector3<f64>; 2];

/// Two bodies, the reaches of what may touch of them (m), and which of these shapes are of revolution.
struct Between {
    ends: [Option<usize>; 2],
    reach: [f64; 2],
    revolved: [Option<Revolved>; 2],
}

impl Between {
    /// The parts of a pair: a rope through several points has more than one.
    fn all(pair: &Pair) -> impl Iterator<Item = Self> + '_ {
        pair.parts.iter().map(|&(ends, reach)| {
            let revolved = pair.revolved;
            let reach = [0, 1].map(|side: usize| revolved[side].map_or(reach[side], |shape| shape.reach));
            Between { ends, reach, revolved }
        })
    }

    /// A body as its shape moves.
    fn moves(&self, side: usize, body: &BodyState) -> BodyState {
        self.revolved[side].map_or(*body, |shape| without_spin(&shape, body))
    }
}

/// V over the time between motions of a body, seen from another [m/s]; u counts with a weight of 1, and ω with the reach (m).
fn fastest(motions: impl Iterator<Item = Motion>, weights: [f64; 2]) -> f64 {
    let (mut speed, mut turning, mut changes) = (0.0_f64, 0.0_f64, 0.0_f64);
    let mut before: Option<Motion> = None;
    for [moves, turns] in motions {
        (speed, turning) = (speed.max(moves.norm()), turning.max(turns.norm()));
        if let Some(before) = before {
            changes = changes.max(change([before, [moves, turns]], weights));
        }
        before = Some([moves, turns]);
    }
    let [along, reach] = weights;
    FASTER * (along * speed + times_reach(turning, reach)) + CHANGING * changes
}

/// The change of u and ω between two instants, with these weights [m/s].
fn change([[moved, turned], [moves, turns]]: [Motion; 2], [along, reach]: [f64; 2]) -> f64 {
    along * (moves - moved).norm() + times_reach((turns - turned).norm(), reach)
}

/// The speed that turning gives a point at the reach (m), zero without turning [m/s].
fn times_reach(turning: f64, reach: f64) -> f64 {
    if turning > 0.0 { turning * reach } else { 0.0 }
}

/// u and ω of a body, seen from another [m/s, rad/s].
fn relative([own, from]: [&BodyState; 2]) -> Motion {
    let carried = from.velocity + from.angular_velocity.cross(&(own.position - from.position));
    [own.velocity - carried, own.angular_velocity - from.angular_velocity]
}

/// V over a stretch of `long` seconds, from V at its ends and the most that V changes by in a second [m/s²].
pub(crate) fn speed_between(ends: [f64; 2], changing: f64, long: f64) -> f64 {
    FASTER * (ends[0].max(ends[1]) + CHANGING * changing * long)
}

/// V of a pair at one instant [m/s].
pub(crate) fn speed_of(pair: &Pair, bodies: &[BodyState]) -> f64 {
    let of_part = |between: Between| {
        let reach = [0, 1].map(|side: usize| between.ends[side].map_or(f64::INFINITY, |_| between.reach[side]));
        let body = |side: usize| between.moves(side, between.ends[side].map_or(&WORLD, |body| &bodies[body]));
        speed_at([body(0), body(1)], reach)
    };
    Between::all(pair).map(of_part).sum()
}

/// V of a pair with a closed contact at one instant [m/s].
pub(crate) fn speed_beside_contacts(pair: &Pair, bodies: &[BodyState]) -> f64 {
    let Some(rolling) = &pair.rolling else { return speed_of(pair, bodies) };
    let [moves, turns] = rolling.motion(&bodies[rolling.body]);
    moves.norm() + times_reach(turns.norm(), rolling.shape.reach)
}

/// V of two bodies with their reaches at one instant [m/s].
pub(crate) fn speed_at([a, b]: [BodyState; 2], reach: [f64; 2]) -> f64 {
    let seen = |own: &BodyState, from: &BodyState, reach: f64| {
        let [moves, turns] = relative([own, from]);
        moves.norm() + times_reach(turns.norm(), reach)
    };
    seen(&a, &b, reach[0]).min(seen(&b, &a, reach[1]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{PairGeometry, PreparedShape};
    use crate::instant::cone::scenes::Random;
    use crate::mechanism::description::contact::{Collider, Shape};
    use crate::mechanism::description::joint::Pose;
    use nalgebra::{Rotation3, Translation3};

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
        // Two bodies on one rigid motion, 0.3 m apart, 5 m/s and 7 rad/s: every point of one is at rest as seen from the other. The second is then
        // 0.1 m/s faster, and turns by 0.2 rad/s more, so that with a reach of 0.5 m its points are faster by at most 0.2 m/s.
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
            speeds.closing(&Between { ends: [Some(0), Some(1)], reach, revolved: [None; 2] })
        };
        assert!(closing(carried, [0.5, 0.5]) < 1e-14);
        // Seen from the first, whose own reach does not matter.
        let found = closing(faster, [1e3, 0.5]);
        assert!((found - FASTER * 0.2).abs() < 1e-14, "{found}");
        // Beside the world every point of the first falls and turns.
        let mut speeds = Speeds::default();
        speeds.reset(1);
        speeds.take(0, &[first]);
        let beside = Between { ends: [Some(0), None], reach: [0.5, f64::INFINITY], revolved: [None; 2] };
        assert!((speeds.closing(&beside) - FASTER * (5.0 + 0.5 * 7.0)).abs() < 1e-14);
    }

    #[test]
    fn no_gap_beside_shapes_of_revolution_changes_faster_than_they_move_without_their_spin() {
        // A cylinder, a capsule and a ball away from the centre of mass of their body, each beside a box that moves, too.
        let frame = Pose::from_parts(Translation3::new(0.05, 0.1, -0.02), Rotation3::new(Vector3::new(0.4, 0.2, -0.3)));
        let round = [
            Shape::Cylinder { radius: 0.1, half: 0.15 },
            Shape::Capsule { radius: 0.1, half: 0.15 },
            Shape::Sphere { radius: 0.1 },
        ];
        let prepared = |shape: Shape, pose: Pose| {
            PreparedShape::new(&Collider::still("one", Some(0), pose, shape)).expect("a shape")
        };
        let box_shape = prepared(Shape::Box { half: Vector3::new(0.2, 0.1, 0.3) }, Pose::identity());
        let mut random = Random::new(7);
        let mut vector = |size: f64| Vector3::from_fn(|_, _| size * random.signed());
        let mut nearest = 0.0_f64;
        for shape in round {
            let pair = PairGeometry::of(&prepared(shape.clone(), frame), &box_shape);
            let [Some(revolved), None] = pair.revolved() else { panic!("one is of revolution") };
            let axis = revolved.axis.unwrap_or(Vector3::x());
            for _ in 0..400 {
                let rotations = [vector(3.0), vector(3.0)].map(Rotation3::new);
                let places = [Vector3::new(0.0, 0.0, 1.0) + vector(0.3), vector(0.1)];
                // It spins, and turns otherwise by up to 1 rad/s.
                let (moves, others) = ([vector(0.5), vector(0.5)], [vector(1.0), vector(1.0)]);
                let turns = [others[0] + rotations[0] * axis * 100.0, others[1]];
                let gap = |time: f64| {
                    let [a, b] = [0, 1].map(|side: usize| {
                        let place = Translation3::from(places[side] + moves[side] * time);
                        Pose::from_parts(place, Rotation3::new(turns[side] * time) * rotations[side])
                    });
                    pair.distance(&a, &b).distance
                };
                let bodies = [0, 1].map(|side: usize| BodyState {
                    position: places[side],
                    rotation: rotations[side].into_inner(),
                    velocity: moves[side],
                    angular_velocity: turns[side],
                });
                let reach = [revolved.reach, pair.reach()[1]];
                let bound = speed_at([without_spin(&revolved, &bodies[0]), bodies[1]], reach);
                let rate = (gap(1e-6) - gap(-1e-6)).abs() / 2e-6;
                // Central differences are off by some 1e-8 at 100 rad/s.
                assert!(rate <= bound + 1e-6, "{shape:?}: {rate} {bound}");
                nearest = nearest.max(rate / bound);
            }
            // It spins about its own axis alone.
            let turning = axis * 100.0;
            let spins = BodyState { velocity: -turning.cross(&revolved.centre), angular_velocity: turning, ..WORLD };
            assert!(speed_at([without_spin(&revolved, &spins), WORLD], [revolved.reach, 0.0]) < 1e-12);
        }
        assert!(nearest > 0.5, "the bound is near: {nearest}");
    }
}
