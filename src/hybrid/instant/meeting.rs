//! Which parts of a scene may meet soon, and which have not met.
//!
//! ```text
//!     τ = φ / (V_a + V_b)                                   V = |v| + |ω| R: the speed of a body and of its farthest point [m/s]
//!     joined:    φ ≤ c D,  or  τ ≤ c T                      c = 1, and 2 for parts that were joined before
//!     apart for L seconds:   L = ½ min τ  of all other pairs
//!     have not met:          φ > m_a + m_b                  m = max |x − x₀| + |R − R₀| R/√2: how far a body has moved since (m)
//! ```
//!
//! φ is the gap of a pair of two parts where the time begins (m), D the length of its smaller shape (m), R the reach of a shape from the centre of mass of its body (m). Parts are what joints,
//! springs, ropes and mimic relations tie. The first two lines are a guess, which costs little where it is wrong; the last one is a proof.
//!
//! Source: B. Mirtich, Timewarp Rigid Body Simulation, SIGGRAPH 2000: groups of bodies that advance apart, and go back where they have met.

use crate::instant::holding::near::Near;
use crate::instant::holding::touching::Touching;
use crate::instant::moved::Moved;
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::ground::disjoint_sets::DisjointSets;
use crate::mechanism::structure::islands::first_of_parts;

/// D over the smaller shape of a pair, and T (s). Bodies that are nearer than their size will be a pile, which costs less as one.
const NEAR: f64 = 1.0;
const SOON: f64 = 0.01;
/// c of parts that were joined before.
const STAY: f64 = 2.0;
/// L over the least time to a meeting, its least and its largest value (s).
const AHEAD: f64 = 0.5;
const LENGTHS: [f64; 2] = [0.005, 0.25];

/// The pairs of parts that may meet.
pub struct Meeting {
    touching: Touching,
    /// The part of each body, by its first body.
    part: Vec<usize>,
}

impl Meeting {
    /// Of the parts of a mechanism.
    pub fn new(mechanism: &Mechanism) -> Self {
        Meeting { touching: Touching::new(mechanism), part: first_of_parts(mechanism) }
    }

    /// The number of the group of each body, from 0 in the order of their first bodies, and how long groups are expected to stay apart (s). `before` are the
    /// groups until now, if there are any.
    pub fn groups(&self, bodies: &[BodyState], before: Option<&[usize]>) -> (Vec<usize>, f64) {
        let fastest = |body: usize, reach: f64| {
            let BodyState { velocity, angular_velocity, .. } = &bodies[body];
            Moved { place: velocity.norm(), turn: angular_velocity.norm() }.of_reach(reach)
        };
        let ahead = LENGTHS[1] / AHEAD;
        let mut joined = DisjointSets::new(self.part.len());
        for (body, &first) in self.part.iter().enumerate() {
            joined.unite(body, first);
        }
        let mut soonest = f64::INFINITY;
        let near = Near::within(&self.touching.pairs, bodies, |body| {
            ahead * fastest(body, self.touching.pairs.reach_of(body)) + NEAR * self.touching.pairs.reach_of(body)
        });
        for &pair in near.pairs() {
            let [Some(a), Some(b)] = self.touching.pairs.bodies_of(pair) else { continue };
            if joined.first(a) == joined.first(b) {
                continue;
            }
            let of = &self.touching.pairs[pair];
            let speed = fastest(a, of.reach[0]) + fastest(b, of.reach[1]);
            let stay = if before.is_some_and(|before| before[a] == before[b]) { STAY } else { 1.0 };
            let close = stay * NEAR * of.arm();
            let gap = self.touching.distance_within(pair, bodies, close.max(ahead * speed));
            if gap <= close || gap <= stay * SOON * speed {
                joined.unite(a, b);
            } else if speed > 0.0 {
                soonest = soonest.min(gap / speed);
            }
        }
        (joined.numbers(), (AHEAD * soonest).clamp(LENGTHS[0], LENGTHS[1]))
    }

    /// Two groups of bodies that may have met, for each pair of groups of which that is true, where bodies have moved from these places.
    pub fn met(&self, bodies: &[BodyState], moved: &[Moved], groups: &[usize]) -> Vec<[usize; 2]> {
        let mut met = Vec::new();
        let near =
            Near::within(&self.touching.pairs, bodies, |body| moved[body].of_reach(self.touching.pairs.reach_of(body)));
        for &pair in near.pairs() {
            let [Some(a), Some(b)] = self.touching.pairs.bodies_of(pair) else { continue };
            let both = [groups[a].min(groups[b]), groups[a].max(groups[b])];
            if both[0] == both[1] || met.contains(&both) {
                continue;
            }
            let reach = self.touching.pairs[pair].reach;
            let gone = moved[a].of_reach(reach[0]) + moved[b].of_reach(reach[1]);
            // What is not a number has met.
            let apart = self.touching.distance_within(pair, bodies, gone) > gone;
            if !apart {
                met.push(both);
            }
        }
        met
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanism::description::body_state::WORLD;
    use crate::mechanism::description::contact::{Collider, ContactPair, Shape};
    use crate::mechanism::description::joint::{Joint, JointKind, Pose};
    use crate::mechanism::description::mechanism::Body;
    use nalgebra::Vector3;

    /// Three balls of radius 0.1 m at these places along x (m), with these speeds [m/s].
    fn balls(places: [f64; 3], speeds: [f64; 3]) -> (Meeting, Vec<BodyState>) {
        let body = |_| {
            let joint = Joint::new("ball", JointKind::Floating, Pose::identity(), Pose::identity());
            Body { name: "ball".into(), parent: None, mass: 1.0, inertia: Vector3::repeat(0.01), joint }
        };
        let mut mechanism = Mechanism::new("balls", Vector3::zeros(), (0..3).map(body).collect()).expect("free bodies");
        for body in 0..3 {
            let shape = Shape::Sphere { radius: 0.1 };
            mechanism.nonsmooth.colliders.push(Collider::still("ball", Some(body), Pose::identity(), shape));
        }
        for (number, [a, b]) in [[0, 1], [0, 2], [1, 2]].into_iter().enumerate() {
            mechanism.nonsmooth.pairs.push(ContactPair::without_moments(number, [a, b], 0.5, 0.0));
        }
        let states = places.into_iter().zip(speeds).map(|(x, speed)| BodyState {
            position: Vector3::x() * x,
            velocity: Vector3::x() * speed,
            ..WORLD
        });
        (Meeting::new(&mechanism), states.collect())
    }

    #[test]
    fn bodies_nearer_than_their_size_are_one_group_and_part_at_twice_that_distance() {
        let groups = |gap: f64, before: Option<&[usize]>| {
            let (meeting, bodies) = balls([0.0, 0.2 + gap, 9.0], [0.0; 3]);
            meeting.groups(&bodies, before).0
        };
        // Their length is the radius.
        assert_eq!(groups(0.09, None), [0, 0, 1]);
        assert_eq!(groups(0.11, None), [0, 1, 2]);
        assert_eq!(groups(0.19, Some(&[0, 0, 1])), [0, 0, 1]);
        assert_eq!(groups(0.21, Some(&[0, 0, 1])), [0, 1, 2]);
    }

    #[test]
    fn groups_stay_apart_for_half_the_time_to_the_next_meeting() {
        let (meeting, bodies) = balls([0.0, 1.2, 9.0], [4.0, -1.0, 0.0]);
        let (groups, length) = meeting.groups(&bodies, None);
        assert_eq!(groups, [0, 1, 2]);
        // 1 m at 5 m/s.
        assert!((length - 0.1).abs() < 1e-12, "{length}");
        let (meeting, bodies) = balls([0.0, 3.0, 9.0], [0.0; 3]);
        assert_eq!(meeting.groups(&bodies, None).1, LENGTHS[1]);
    }

    #[test]
    fn groups_have_met_unless_their_bodies_have_moved_by_less_than_their_gap() {
        let (meeting, bodies) = balls([0.0, 1.2, 9.0], [0.0; 3]);
        let met = |moved: [f64; 3]| {
            let moved = moved.map(|place| Moved { place, turn: 0.0 });
            meeting.met(&bodies, &moved, &[0, 1, 2])
        };
        assert!(met([0.5, 0.49, 0.0]).is_empty());
        assert_eq!(met([0.5, 0.51, 0.0]), [[0, 1]]);
        assert_eq!(met([0.0, 0.0, f64::NAN]), [[0, 2], [1, 2]]);
        // A turn moves points at the reach.
        let moved = [Moved { place: 0.0, turn: 10.1 }, Moved::default(), Moved::default()];
        assert_eq!(meeting.met(&bodies, &moved, &[0, 1, 2]), [[0, 1]]);
    }
}
