//! How far the bodies of a run have moved since an instant, as a bound over whole steps.
//!
//! ```text
//!     m(t) ≤ max_i |x(t_i) − x₀| + ½ δ V       V = F max(|v_i|, |v_(i+1)|) + C |v_(i+1) − v_i|,   F = 1.25,  C = 0.5
//! ```
//!
//! t_i are four instants of each step and δ is the time between them (s); x are places (m) or rotations, v are their speeds [m/s or rad/s]. A step that
//! ends with an impact has its last speed before the impact from the one before.

use crate::instant::meeting::Moved;
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::integrator::Integrator;
use crate::mechanism::motion::kinematics::{body_states, place_bodies};
use crate::mechanism::motion::state::State;

/// Instants of a step.
const PARTS: usize = 4;
/// F and C.
const FASTER: f64 = 1.25;
const CHANGING: f64 = 0.5;

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
                let between = |before: f64, after: f64, change: f64| {
                    0.5 * part * (FASTER * before.max(after) + CHANGING * change)
                };
                let place = between(last.velocity.norm(), now.velocity.norm(), (now.velocity - last.velocity).norm());
                let turn = between(
                    last.angular_velocity.norm(),
                    now.angular_velocity.norm(),
                    (now.angular_velocity - last.angular_velocity).norm(),
                );
                let at = Moved::between(origin, now);
                *moved = moved.most(Moved { place: at.place + place, turn: at.turn + turn });
            }
            self.last.copy_from_slice(&self.now);
        }
    }

    /// How far each body has moved at most.
    pub fn moved(&self) -> &[Moved] {
        &self.moved
    }
}
