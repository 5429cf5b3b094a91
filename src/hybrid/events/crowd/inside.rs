//! States inside a step of a crowd, on all closures: its middle, and samples.
//!
//! ```text
//!     q(t) = q_k ⊕ (t − t_k) w,   v(t) = v_k + (t − t_k)/h (v_{k+1} − v_k),   the middle: v = w          dependent coordinates and rates follow
//! ```

use crate::events::crowd::step::Crowd;
use crate::mechanism::description::joint::FreeRotation;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::kinematics::{body_states, place_bodies};
use crate::mechanism::motion::state::State;

impl Crowd {
    /// A state inside the last step, from `start` to `end`, at a time (s); `None` if the last step was another.
    pub fn inside(&self, mechanism: &Mechanism, start: &State, end: &State, time: f64) -> Option<State> {
        let own = self.end.as_ref().is_some_and(|(own, _)| own.time == end.time && own.position == end.position);
        if !own || time >= end.time {
            return None;
        }
        let mut inside = start.clone();
        let moved: Vec<f64> = self.displacement.iter().map(|rate| (time - start.time) * rate).collect();
        inside.displace(mechanism, &moved);
        let part = (time - start.time) / (end.time - start.time);
        for ((rate, a), b) in inside.velocity.iter_mut().zip(&start.velocity).zip(&end.velocity) {
            *rate = a + part * (b - a);
        }
        inside.time = time;
        if self.trees.have_loops() {
            let mut bodies = body_states(mechanism, &inside);
            self.trees.close_beside(mechanism, &mut inside, &mut bodies);
        }
        Some(inside)
    }

    /// Makes w of the joints of trees with loops the displacement from one state to another (s).
    pub(super) fn take_displacement(
        &self,
        whole: &Mechanism,
        start: &State,
        end: &State,
        step: f64,
        displacement: &mut [f64],
    ) {
        if !self.trees.have_loops() {
            return;
        }
        for (index, body) in whole.bodies.iter().enumerate() {
            let joint = &body.joint;
            let turns = if joint.kind.rotation() == FreeRotation::Ball { 3 } else { 0 };
            if self.trees.trees[self.trees.of_body[index]].ways().is_none() {
                continue;
            }
            for offset in 0..joint.kind.velocity_count() - turns {
                let place = joint.position_index + offset;
                let moved =
                    end.position[place] - start.position[place] + (end.compensation[place] - start.compensation[place]);
                displacement[joint.velocity_index + offset] = moved / step;
            }
        }
    }

    /// The state at the middle of the step, and the largest speeds of the bodies at its start and there; `false` where loops do not close in it.
    pub(super) fn place_middle(&mut self, start: &State, displacement: &[f64], step: f64, whole: &Mechanism) -> bool {
        let Crowd { middle, bodies, began, speeds, resting, trees, .. } = self;
        let middle = middle.get_or_insert_with(|| start.clone());
        middle.copy_from(start);
        place_bodies(whole, middle, bodies);
        began.copy_from_slice(bodies);
        speeds.begin(bodies);
        let half: Vec<f64> = displacement.iter().map(|rate| 0.5 * step * rate).collect();
        middle.displace(whole, &half);
        resting.keep(whole, start, middle);
        middle.time = start.time + 0.5 * step;
        middle.velocity.copy_from_slice(displacement);
        place_bodies(whole, middle, bodies);
        let closed = trees.close_beside(whole, middle, bodies);
        if trees.have_loops() {
            place_bodies(whole, middle, bodies);
        }
        speeds.go_on(bodies);
        closed
    }
}
