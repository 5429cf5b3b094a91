//! How far the bodies of a run have moved since an instant, as a bound over whole steps.
//!
//! ```text
//!     m(t) ≤ max_i m_i + b_i       m_i: from x₀ to x(t_i);  b_i: beside the way from t_(i−1) to t_i       (crate::instant::moved)
//! ```
//!
//! t_i are four instants of each step (s), x are places (m) and rotations. A step that ends with an impact has its last speed before the impact from the
//! one before.

use crate::instant::moved::Moved;
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::integrator::Integrator;
use crate::mechanism::motion::kinematics::{body_states, place_bodies};
use crate::mechanism::motion::state::State;

/// Instants of a step.
const PARTS: usize = 4;

/// The bodies at the instant from which it is measured, at the last one, and how far they have moved at most.
pub(crate) struct Way {
    origin: Vec<BodyState>,
    last: Vec<BodyState>,
    now: Vec<BodyState>,
    moved: Vec<Moved>,
    inside: State,
}

impl Way {
    /// From a state on.
    pub fn new(mechanism: &Mechanism, state: &State) -> Self {
        let bodies = body_states(mechanism, state);
        let moved = vec![Moved::default(); bodies.len()];
        Way { origin: bodies.clone(), last: bodies.clone(), now: bodies, moved, inside: state.clone() }
    }

    /// From another state on.
    pub fn begin(&mut self, mechanism: &Mechanism, state: &State) {
        place_bodies(mechanism, state, &mut self.origin);
        self.last.copy_from_slice(&self.origin);
        self.moved.fill(Moved::default());
    }

    /// Takes a step from an instant (s) to a state.
    pub fn go_on<I: Integrator + ?Sized>(
        &mut self,
        mechanism: &Mechanism,
        integrator: &mut I,
        from: f64,
        state: &State,
    ) {
        let part = (state.time - from) / PARTS as f64;
        for index in 1..=PARTS {
            if index == PARTS {
                place_bodies(mechanism, state, &mut self.now);
            } else if part > 0.0 {
                self.inside.time = from + index as f64 * part;
                let State { time, position, velocity, compensation } = &mut self.inside;
                integrator.dense(mechanism, *time, position, velocity);
                compensation.fill(0.0);
                place_bodies(mechanism, &self.inside, &mut self.now);
            } else {
                continue;
            }
            for (((origin, last), now), moved) in self.origin.iter().zip(&self.last).zip(&self.now).zip(&mut self.moved)
            {
                *moved = moved.most(Moved::between(origin, now).with_way(last, now, part));
            }
            self.last.copy_from_slice(&self.now);
        }
    }

    /// How far each body has moved at most.
    pub fn moved(&self) -> &[Moved] {
        &self.moved
    }
}
