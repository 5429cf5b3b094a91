//! Positions and rates of joints that were not given at the start, by the mimic relations to joints that were.
//!
//! ```text
//!     q_f = m q_l + b,   q̇_f = m q̇_l          a follower f was not given: it follows its leader l
//!     q_l = (q_f − b)/m,   q̇_l = q̇_f/m         a leader was not given, and a follower was: m ≠ 0
//! ```
//!
//! Given joints come first, and each relation hands on from a joint whose value is decided to one whose value is not. Joints that no given joint
//! decides have their leader at zero, and follow it. Given joints keep their values: if two of them contradict a relation, the assembly moves the
//! start.

use crate::mechanism::description::closure::{Coordinate, Mimic};

/// A row of values, one for each joint of one freedom.
pub(crate) struct Followed<'v> {
    pub values: &'v mut [f64],
    /// The place of the value of a joint.
    pub place: fn(Coordinate) -> usize,
    /// Whether offsets count: of positions, not of rates.
    pub offsets: bool,
}

impl Followed<'_> {
    /// Decides the values of joints that were not given; `given` tells for each body whether the value of its joint was.
    pub fn decide(&mut self, mimics: &[Mimic], mut given: Vec<bool>) {
        self.hand_on(mimics, &mut given);
        // The leader of leaders is no follower.
        for mimic in mimics {
            let leads = |leader: Coordinate| !mimics.iter().any(|other| other.follower == leader);
            for (leader, _) in mimic.terms().skip(1) {
                if !given[leader.body] && leads(leader) {
                    given[leader.body] = true;
                    self.hand_on(mimics, &mut given);
                }
            }
        }
    }

    /// Hands values on along the relations until each that can be decided is.
    fn hand_on(&mut self, mimics: &[Mimic], decided: &mut [bool]) {
        // A value goes along one relation in each pass at least.
        for _ in 0..=mimics.len() {
            let mut changed = false;
            for mimic in mimics {
                let offset = if self.offsets { mimic.offset } else { 0.0 };
                if !mimic.more.is_empty() {
                    changed |= self.complete(mimic, offset, decided);
                    continue;
                }
                let (follower, leader) = ((self.place)(mimic.follower), (self.place)(mimic.leader));
                if decided[mimic.leader.body] && !decided[mimic.follower.body] {
                    self.values[follower] = mimic.multiplier * self.values[leader] + offset;
                    decided[mimic.follower.body] = true;
                    changed = true;
                } else if decided[mimic.follower.body] && !decided[mimic.leader.body] && mimic.multiplier != 0.0 {
                    self.values[leader] = (self.values[follower] - offset) / mimic.multiplier;
                    decided[mimic.leader.body] = true;
                    changed = true;
                }
            }
            if !changed {
                break;
            }
        }
    }

    /// Decides the one joint of a relation of several whose value is open, if there is one; whether there was.
    fn complete(&mut self, mimic: &Mimic, offset: f64, decided: &mut [bool]) -> bool {
        let mut open = mimic.terms().filter(|(own, coefficient)| !decided[own.body] && *coefficient != 0.0);
        let (Some((own, coefficient)), None) = (open.next(), open.next()) else { return false };
        let others = mimic.terms().filter(|(other, _)| *other != own);
        let sum: f64 = others.map(|(other, coefficient)| coefficient * self.values[(self.place)(other)]).sum();
        self.values[(self.place)(own)] = (offset - sum) / coefficient;
        decided[own.body] = true;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(body: usize) -> Coordinate {
        Coordinate { body, position: body, freedom: body }
    }

    fn decided(values: [f64; 4], given: [bool; 4], offsets: bool) -> [f64; 4] {
        let mimic = |follower, leader, multiplier, offset| Mimic {
            name: String::new(),
            follower: at(follower),
            leader: at(leader),
            multiplier,
            offset,
            more: Vec::new(),
            over_time: None,
        };
        // Joint 2 follows 1, 1 follows 0; joint 3 follows 0 and is listed first.
        let mimics = [mimic(3, 0, 4.0, 0.0), mimic(2, 1, 2.0, -0.3), mimic(1, 0, 0.5, 0.1)];
        let mut all = values;
        let place = |of: Coordinate| of.position;
        Followed { values: &mut all, place, offsets }.decide(&mimics, given.to_vec());
        all
    }

    fn assert_near(found: [f64; 4], wanted: [f64; 4]) {
        // Three roundings of numbers up to two.
        assert!(found.iter().zip(wanted).all(|(found, wanted)| (found - wanted).abs() < 1e-15), "{found:?}");
    }

    #[test]
    fn joints_that_were_not_given_follow_those_that_were_up_and_down_chains() {
        let wanted = [0.3, 0.25, 0.2, 1.2];
        for (index, value) in wanted.into_iter().enumerate() {
            let (mut values, mut given) = ([0.0; 4], [false; 4]);
            (values[index], given[index]) = (value, true);
            assert_near(decided(values, given, true), wanted);
        }
        // Nobody was given: the leader is at zero.
        assert_near(decided([0.0; 4], [false; 4], true), [0.0, 0.1, -0.1, 0.0]);
        // Rates have no offsets.
        assert_near(decided([0.0, 0.5, 0.0, 0.0], [false, true, false, false], false), [1.0, 0.5, 1.0, 4.0]);
    }

    #[test]
    fn given_joints_keep_their_values_even_where_they_contradict_each_other() {
        let found = decided([0.3, 0.9, 0.0, 0.0], [true, true, false, false], true);
        assert_near(found, [0.3, 0.9, 1.5, 1.2]);
    }
}
