//! Bodies that come near: a run looks at more pairs when their bodies may meet in the step at hand.
//!
//! ```text
//!     at home in a step:   |x(t₀) − c| + V h + z ≤ s        V: bound of the speed of the centre [m/s], h: length of the step (s), z: a gap that counts as closed (m)
//! ```
//!
//! A pair that is left out has two bodies that stay in homes that are apart ([`crate::instant::holding::near`]): that is its certificate in each step.

use crate::events::finding::watched::Watched;
use crate::events::integrator::Eventful;
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;

/// Gaps up to this part of the reach of a body may be closed.
const CLOSED: f64 = 1e-6;

impl Eventful {
    /// The pairs near the places of bodies are looked at from a state on.
    pub(super) fn look_around(&mut self, state: &State) {
        let pairs = &self.model.touching.pairs;
        // Bodies are not asked where all pairs are looked at.
        let bodies = if pairs.are_few() { Vec::new() } else { body_states(&self.model.whole, state) };
        let near = &mut self.trial.near;
        near.see(pairs, &bodies, |body| CLOSED * pairs.reach_of(body));
        near.leave_out(pairs);
        self.trial.reserves.take(near.pairs(), pairs);
    }

    /// Adds the pairs of bodies that may come near when they move by these distances (m), for a body and its reach (m), also to the watched functions; says whether there are any.
    pub(super) fn look_ahead(&mut self, bodies: &[BodyState], moves: impl Fn(usize, f64) -> f64) -> bool {
        let touching = self.model.touching.clone();
        let pairs = &touching.pairs;
        let margin = |body: usize| {
            let reach = pairs.reach_of(body);
            moves(body, reach) + CLOSED * reach
        };
        if pairs.are_few() || !self.trial.near.see(pairs, bodies, margin) {
            return false;
        }
        self.trial.reserves.take(self.trial.near.pairs(), pairs);
        let gaps = self.watched_gaps();
        let after = Watched::after_gaps(&self.trial.watched);
        self.trial.watched.splice(..after, gaps);
        true
    }

    /// The gaps of the near pairs whose bodies move against each other in the mode.
    fn watched_gaps(&self) -> Vec<Watched> {
        let near = self.trial.near.pairs().iter().copied();
        near.filter(|&pair| self.moves_apart(pair)).map(Watched::Approach).collect()
    }

    /// Whether the bodies of a pair move against each other in the mode.
    pub(super) fn moves_apart(&self, pair: usize) -> bool {
        let moving = &self.workspaces.active().moving;
        let groups = |bodies: [Option<usize>; 2]| bodies.map(|body| body.and_then(|body| moving.group(body)));
        self.model.touching.pairs[pair].parts.iter().map(|(bodies, _)| groups(*bodies)).any(|[a, b]| a != b)
    }

    /// Looks for bodies that may come near in the last step, before its functions are looked at.
    pub(super) fn see_step(&mut self, since: f64) {
        if self.model.touching.pairs.are_few() || self.progress.asleep {
            return;
        }
        let end = self.workspaces.active().small.time;
        let mut speeds = std::mem::take(&mut self.trial.speeds);
        self.take_speeds([since, end], &mut speeds);
        self.look_ahead(speeds.first(), |body, _| (end - since) * speeds.seen_from(Some(body), None, 0.0));
        self.trial.speeds = speeds;
    }
}
