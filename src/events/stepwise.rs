//! First-order time stepping, used where events crowd or no step of the scheme can be solved, so that a run always continues.
//!
//! ```text
//!     v_f = v₀ + h a(q₀, v₀)                       under all forces, motors and inputs; without what follows
//!     v̄  = v_f + Y Wᵀ P,   u = D P + W v_f
//!     limits and contacts:   0 ≤ P_N ⊥ u_N + φ/h ≥ 0      for all that may close in the step, plastic, within Coulomb's cone
//!     friction of joints:    |P| ≤ h τ_f
//!     q̄  = q₀ + h v̄,  on closures, within limits and out of overlaps by the least motion
//! ```
//!
//! of first order, with steps of a tenth of a millisecond. A step that would gain energy has its velocities scaled down. What it loses beside the work of motors counts as lost in
//! impacts.
//!
//! Source: J. J. Moreau, Unilateral contact and dry friction in finite freedom dynamics (1988); M. Jean, The non-smooth contact dynamics method,
//! Computer Methods in Applied Mechanics and Engineering 177 (1999).

use crate::events::crowding::STEP;
use crate::events::effects::resting::energy;
use crate::events::integrator::Eventful;
use crate::instant::assembly::assemble;
use crate::instant::blocks::{Block, Of, Rows, row_of_freedom, rows_of_contact};
use crate::instant::cone::problem::{Law, Problem, Unsolved};
use crate::instant::cone::solve;
use crate::instant::elements::inward;
use crate::mechanism::forces::total::Exchange;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::integrator::StepOutcome;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;

/// A step that gains more than this part of the kinetic energy is scaled.
const GAIN: f64 = 1e-14;

impl Eventful {
    /// Whether steps between events have become so many and so short that the run would not get on.
    pub(super) fn is_crowded(&mut self, state: &State) -> bool {
        !self.touching.pairs.is_empty() && self.crowding.count(state.time)
    }

    /// Makes one such step towards `until` from the start of the step that failed.
    pub(super) fn stumble(&mut self, inputs: Inputs, state: &mut State, until: f64) -> StepOutcome {
        let start = self.origin.clone();
        state.copy_from(&start);
        let step = STEP.min(until - start.time);
        let efforts = self.mode.driving_efforts(&self.elements, inputs, state);
        let mut free = vec![0.0; self.whole.velocity_count];
        self.response.accelerations(state, &efforts, &mut free);
        for (rate, acceleration) in state.velocity.iter_mut().zip(&free) {
            *rate += step * acceleration;
        }
        let (blocks, gaps) = self.closing_within(step, &start, &state.velocity);
        if !blocks.is_empty() {
            let rows = Rows::of(&mut self.response, &start, &blocks);
            let mut rates = rows.rates(&state.velocity);
            let mut row = 0;
            for (block, gap) in blocks.iter().zip(&gaps) {
                rates[row] += gap / step;
                row += block.rows.len();
            }
            let laws: Vec<Law> = blocks.iter().map(|block| block.law).collect();
            let impulses = match solve(&Problem { mobility: &rows.square, free: &rates, laws: &laws }, None) {
                Ok(answer) => answer.forces,
                Err(Unsolved::Stopped { best }) => best.forces,
                Err(_) => vec![0.0; rates.len()],
            };
            rows.add(&impulses, &mut state.velocity);
        }
        let moved: Vec<f64> = state.velocity.iter().map(|rate| step * rate).collect();
        state.displace(&self.whole, &moved);
        state.time = start.time + step;
        // Where it fails something stays open by what a step of first order leaves.
        let wanted = state.velocity.clone();
        let _ = assemble(&self.whole, state);
        if !state.velocity.iter().all(|rate| rate.is_finite()) {
            state.velocity = wanted;
        }
        let work: f64 = efforts.iter().zip(&moved).map(|(effort, moved)| effort * moved).sum();
        self.bound(&start, state, work);
        self.unsolved += 1;
        self.see_jump(&start, state);
        self.stepped_over = Some(state.clone());
        self.outside.clear();
        self.outside.extend_from_slice(inputs.efforts);
        let events = self.events.len();
        self.pass_anew(inputs, state);
        self.events.truncate(events);
        // What closed has been moved: that gains nothing either.
        let impacts = self.bound(&start, state, work);
        let piece = &mut self.pieces[self.current];
        piece.small = piece.moving.gather(&self.whole, state);
        self.steps += 1;
        self.stepped += step;
        StepOutcome {
            step,
            iterations: 1,
            exchange: Exchange { work, impacts, ..Exchange::default() },
            ..StepOutcome::default()
        }
    }

    /// What may close or hold in a step of this length from a state, for velocities without it: blocks, and their gaps (m or rad).
    fn closing_within(&self, step: f64, start: &State, velocity: &[f64]) -> (Vec<Block>, Vec<f64>) {
        let (mut blocks, mut gaps) = (Vec::new(), Vec::new());
        let unbounded = Law::Interval { lower: 0.0, upper: f64::INFINITY };
        for (index, joint) in self.elements.joints.iter().enumerate() {
            let freedom = joint.coordinate.freedom;
            let mut add = |law: Law, sign: f64, gap: f64| {
                let rows = vec![row_of_freedom(velocity.len(), freedom, sign)];
                blocks.push(Block { of: Of::Joint(index), law, rows });
                gaps.push(gap);
            };
            if joint.friction > 0.0 {
                let most = step * joint.friction;
                add(Law::Interval { lower: -most, upper: most }, 1.0, 0.0);
            }
            for side in joint.sides() {
                let gap = joint.gap(side, joint.position(start));
                if gap + step * inward(side) * velocity[freedom] < 0.0 {
                    add(unbounded, inward(side), gap);
                }
            }
        }
        let bodies = body_states(&self.whole, start);
        for (pair, of) in self.touching.pairs.iter().enumerate() {
            let speed = of.bodies.iter().zip(of.reach).filter_map(|(body, reach)| {
                let state = &bodies[(*body)?];
                Some(state.velocity.norm() + state.angular_velocity.norm() * reach.min(of.size))
            });
            let within = 2.0 * step * speed.sum::<f64>() + 10.0 * step * step;
            if self.touching.distance(pair, &bodies) > within {
                continue;
            }
            for (contact, gap) in self.touching.near(pair, &bodies, within) {
                let rows = rows_of_contact(&self.whole, &bodies, &contact.joint, of.friction > 0.0);
                let law = Law::of_contact(of.friction, None);
                blocks.push(Block { of: Of::Contact(pair), law, rows });
                gaps.push(gap);
            }
        }
        (blocks, gaps)
    }

    /// Takes from the velocities what a step has gained beside the work (J); returns what it has lost (J).
    fn bound(&self, start: &State, end: &mut State, work: f64) -> f64 {
        let (before, after) = (energy(&self.whole, start), energy(&self.whole, end));
        let gained = after.total() - before.total() - work;
        if gained > GAIN * after.kinetic && after.kinetic > 0.0 {
            let factor = ((after.kinetic - gained) / after.kinetic).max(0.0).sqrt();
            end.velocity.iter_mut().for_each(|rate| *rate *= factor);
        }
        before.total() + work - energy(&self.whole, end).total()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanism::description::contact::{Collider, ContactPair, Shape};
    use crate::mechanism::description::joint::{Joint, JointKind, Pose};
    use crate::mechanism::description::mechanism::{Body, Mechanism};
    use crate::mechanism::motion::integrator::Integrator;
    use crate::stepping::integrator::StepPace;
    use crate::stepping::length::stage_choice::StageChoice;
    use crate::stepping::recipe::{Recipe, Steps};
    use nalgebra::Vector3;

    #[test]
    fn steps_that_have_failed_do_not_leave_their_length_to_those_after_the_one_that_stands_for_them() {
        // A ball in the air over a floor.
        let joint = Joint::new("ball", JointKind::Floating, Pose::identity(), Pose::identity());
        let body = Body { name: "ball".into(), parent: None, mass: 1.0, inertia: Vector3::repeat(4e-3), joint };
        let mut mechanism = Mechanism::new("ball", Vector3::z() * -9.81, vec![body]).expect("a free body");
        let nonsmooth = &mut mechanism.nonsmooth;
        for (body, shape) in [(Some(0), Shape::Sphere { radius: 0.1 }), (None, Shape::HalfSpace)] {
            nonsmooth.colliders.push(Collider { name: "one".into(), body, pose: Pose::identity(), shape });
        }
        nonsmooth.pairs.push(ContactPair { number: 0, a: 0, b: 1, friction: 0.5, restitution: 0.0 });
        let steps = Steps::Chosen { tolerance: 1e-6, stop: 1e-10, stages: StageChoice::Many };
        let mut eventful = Eventful::new(&mechanism, Recipe { steps, kept: Vec::new() }).expect("possible steps");
        let mut state = State::zero(&mechanism);
        state.position[2] = 100.0;
        let inputs = Inputs::constant(&[0.0; 6]);
        eventful.step(&mechanism, inputs, &mut state, 1e-3).expect("a step");
        // As short as a step is when it is given up.
        let piece = &mut eventful.pieces[eventful.current];
        let pace = StepPace::Step { length: 1e-14, kinetic: 1.0 };
        piece.steps.as_mut().expect("a body that moves").go_on_at(pace, state.time);
        piece.small.position[2] += 1e-9;
        let short = eventful.step(&mechanism, inputs, &mut state, 1.0).expect("a step").step;
        assert!(short > 0.0 && short < 1e-13, "{short:e}");
        eventful.origin.copy_from(&state);
        eventful.stumble(inputs, &mut state, 1.0);
        eventful.left = Some(state.clone());
        let after = eventful.step(&mechanism, inputs, &mut state, 1.0).expect("a step").step;
        assert!(after >= 0.9 * STEP, "{after:e}");
    }
}
