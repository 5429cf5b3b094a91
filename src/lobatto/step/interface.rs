//! The interface of a step for integrators: when its iteration ends, how an attempt at it ended, and the queries about it. It is made by
//! [`crate::step::kernel`], to 32 digits by [`crate::step::precise`].

use crate::coupled::counted::Counted;
use crate::coupled::known::Known;
use crate::stages::attempt::{Attempt, Carrying, Guess, StopRule};
use catena_mechanism::description::body_state::BodyState;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::forces::total::Exchange;
use catena_mechanism::motion::energy::Energy;
use catena_mechanism::motion::state::State;
use std::sync::Arc;

/// A step of the scheme for one number of lanes, as the integrator sees it.
pub trait Step: Send + Sync {
    /// The same step with the same past: it goes on to the same bits.
    fn duplicate(&self) -> Box<dyn Step>;
    /// Steps iterated as far as `stop` (rad, m) are to come: makes room for their workspace.
    fn expect(&mut self, _mechanism: &Mechanism, _stop: f64) {}
    /// Takes the ranks of the closures counted at the start of the next steps.
    fn expect_at(&mut self, _counted: Arc<Counted>) {}
    /// Takes a state as the start of the next step, when it is not where the last step ended.
    fn begin(&mut self, mechanism: &Mechanism, state: &State);
    /// Takes the efforts that drive the joints in the next step, one entry a degree of freedom; without entries the efforts are zero. Only steps of a
    /// mechanism whose forces are [driven](catena_mechanism::description::forces::Forces::driven) heed them.
    fn drive(&mut self, _efforts: &[f64]) {}
    /// Takes the time at the start of the next step, or of the last one that is made again (s). Only steps of a mechanism with forces that change need
    /// it.
    fn clock(&mut self, _time: f64) {}
    /// Takes efforts along some freedoms of scalar coordinates at all stages of the next attempt, freedom after freedom. Only steps of a mechanism
    /// whose forces are driven heed them.
    fn change(&mut self, _freedoms: &[usize], _at_stages: &[f64]) {}
    /// Takes back the acceptance of the last step: its start is the start again, and its solution the guess of
    /// [`Guess::Longer`].
    fn retract(&mut self) {}
    /// Displacements of a degree of freedom at the stages 2 … s of the last solved step.
    fn stage_displacements(&self, _freedom: usize, _displacements: &mut [f64]) {}
    /// Energy at the start of the step.
    fn energy(&self) -> Energy;
    /// Poses and velocities of all bodies at the start of the step; `None` where steps do not place them in space.
    fn bodies(&self) -> Option<&[BodyState]> {
        None
    }
    /// The same of the carried motion.
    fn carried_bodies(&self) -> Option<&[BodyState]> {
        None
    }
    /// Whether there is a step before this one to guess from: without, every guess is a plain one.
    fn has_past(&self) -> bool;
    /// Solves the stage equations of a step of length `step` from the start and a guess.
    fn attempt(&mut self, mechanism: &Mechanism, step: f64, rule: &StopRule, guess: Guess) -> Attempt;
    /// Projects the momentum at the end of the solved step (2.5.11h): moves `state` there; returns its energy.
    fn finish(&mut self, mechanism: &Mechanism, state: &mut State) -> Energy;
    /// Energy dissipated in the finished step, and work put into it, by the quadrature of the scheme (J).
    fn exchange(&self) -> Exchange;
    /// How many iterations have kept the factors of an earlier one since this was asked last.
    fn take_kept(&mut self) -> usize;
    /// Ranks and flags of the closures, if there are any, determined at the latest state that no step had left.
    fn known(&self) -> Option<&Known> {
        None
    }
    /// Writes the forces on the second ends of the closures, loops and then contacts, at the stages 1 … s − 1 of the last solved step: of each closure
    /// one force (N) a stage. Whether the step solved for them.
    fn closure_forces(&self, _forces: &mut Vec<[f64; 3]>) -> bool {
        false
    }
    /// Number of redundant equations of the closures at the end of the finished step; `None` without closures, or if the projection had no work
    /// there.
    fn redundant(&self) -> Option<usize>;
    /// Brings positions and velocities near the closures, if there are any, on them.
    fn close(&mut self, mechanism: &Mechanism, time: f64, position: &mut [f64], velocity: &mut [f64]);
    /// Carries a second motion beside this one from its next step on, from this state; without effect in steps of 32 digits.
    fn begin_to_carry(&mut self, _mechanism: &Mechanism, _state: &State) {}
    /// Moves the carried motion, which is in this state, through the step that was finished and is not accepted yet.
    fn carry_on(&mut self, _mechanism: &Mechanism, _state: &mut State, _carrying: &Carrying) {}
    /// [`Step::finish`] for both motions: `beside`, the state of the carried motion, moves to its end, too, to the same bits at lower cost. `None`,
    /// without any effect, if the step has no such code.
    fn finish_both(
        &mut self,
        _mechanism: &Mechanism,
        _state: &mut State,
        _beside: &mut State,
        _carrying: &Carrying,
    ) -> Option<Energy> {
        None
    }
    /// The carried motion stays where [`Step::finish_both`] has moved it: in place of [`Step::carry_on`].
    fn keep_carried(&mut self) {}
    /// Keeps the finished step: its end is the start of the next one.
    fn accept(&mut self);
    /// Two weighted sums, for each degree of freedom, of its displacements at the stages 2 … s of the last solved step.
    fn weigh_displacements(&self, weights: [&[f64]; 2], sums: &mut [[f64; 2]]);
    /// Displacement of a degree of freedom at the last stage of the last solved step.
    fn last_displacement(&self, freedom: usize) -> f64;
    /// Rough second derivatives of the displacements at the start, from one iteration of a step of this length (s). Zero for the freedoms that
    /// need no iteration ([`Plan::known`](crate::plan::tree::Plan::known)): no step is shorter for these.
    fn accelerations(&mut self, step: f64, out: &mut [f64]);
}

impl Clone for Box<dyn Step> {
    fn clone(&self) -> Self {
        self.duplicate()
    }
}
