//! The bodies in the states that were asked for last.
//!
//! The end of a step is asked for its bodies by the search of events, the look at overlaps and the speeds, and it is the start of the next step. To
//! compare coordinates takes a fiftieth of the time that placing takes.

use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::kinematics::place_bodies;
use crate::mechanism::motion::state::State;

/// States that are kept: the start of a step, its end, and two inside.
const KEPT: usize = 4;

/// Placed bodies of some states of one mechanism.
#[derive(Clone, Debug, Default)]
pub(crate) struct PlacedBodies {
    known: Vec<(State, Vec<BodyState>)>,
    /// The place of the next state once all places are used.
    oldest: usize,
}

impl PlacedBodies {
    /// Forgets all: the mechanism is another.
    pub fn forget(&mut self) {
        self.known.clear();
        self.oldest = 0;
    }

    /// Writes the bodies of a state, as [`place_bodies`] does. Allocates only until there is room for all.
    pub fn place(&mut self, mechanism: &Mechanism, state: &State, out: &mut [BodyState]) {
        let same = |(known, _): &&(State, Vec<BodyState>)| {
            known.position == state.position
                && known.velocity == state.velocity
                && known.compensation == state.compensation
        };
        if let Some((_, bodies)) = self.known.iter().find(same) {
            out.copy_from_slice(bodies);
            return;
        }
        place_bodies(mechanism, state, out);
        if self.known.len() < KEPT {
            self.known.push((state.clone(), out.to_vec()));
            return;
        }
        let (known, bodies) = &mut self.known[self.oldest];
        known.copy_from(state);
        bodies.copy_from_slice(out);
        self.oldest = (self.oldest + 1) % KEPT;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instant::cone::scenes::Random;
    use crate::mechanism::description::body_state::WORLD;
    use crate::mechanism::description::joint::{Joint, JointKind, Pose};
    use crate::mechanism::description::mechanism::Body;
    use crate::mechanism::motion::kinematics::body_states;
    use nalgebra::Vector3;

    /// Rods, one below the other.
    fn rods(count: usize) -> Mechanism {
        let bodies = (0..count).map(|index| {
            let on_child = Pose::translation(0.0, 0.0, 0.5);
            let joint = Joint::new(&format!("joint {index}"), JointKind::Revolute, Pose::identity(), on_child);
            let (parent, inertia) = (index.checked_sub(1), Vector3::new(0.05, 0.06, 0.02));
            Body { name: format!("body {index}"), parent, mass: 1.0, inertia, joint }
        });
        Mechanism::new("rods", Vector3::new(0.0, 0.0, -9.81), bodies.collect()).expect("a mechanism")
    }

    #[test]
    fn bodies_that_were_kept_are_those_that_are_placed_to_the_last_bit() {
        let mechanism = rods(5);
        let mut random = Random::new(3);
        let mut state = State::zero(&mechanism);
        let (mut placed, mut found) = (PlacedBodies::default(), vec![WORLD; mechanism.bodies.len()]);
        let mut states = Vec::new();
        for _ in 0..3 * KEPT {
            let entries = state.position.iter_mut().chain(&mut state.velocity);
            entries.for_each(|entry| *entry = random.signed());
            states.push(state.clone());
            // A rounding of a position is another state.
            state.compensation[1] = 1e-17 * random.signed();
            states.push(state.clone());
            for known in states.iter().rev().take(KEPT + 2) {
                placed.place(&mechanism, known, &mut found);
                assert_eq!(found, body_states(&mechanism, known));
            }
        }
        let other = rods(4);
        placed.forget();
        found.truncate(4);
        placed.place(&other, &State::zero(&other), &mut found);
        assert_eq!(found, body_states(&other, &State::zero(&other)));
    }
}
