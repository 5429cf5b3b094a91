//! A step of the kernel, from its start to the next: begun, attempted, finished and accepted.
//!
//! ```text
//!     state ──set──▶ start ──iteration──▶ θ ──(2.5.11h)──▶ displacements and velocities at the end ──set──▶ end, the next start
//! ```

use crate::coupled::closing::Closing;
use crate::coupled::counted::Counted;
use crate::coupled::known::Known;
use crate::coupled::touching::Touching;
use crate::numbers::extended::Extended;
use crate::numbers::lanes::{Lanes, in_lanes};
use crate::numbers::reductions::{at_end, weigh, write_ends};
use crate::solve::iteration::{Equations, Guarded, exact_at_first};
use crate::solve::kept_factors::Chord;
use crate::stages::attempt::{Attempt, Carrying, Guess, StopRule};
use crate::step::interface::Step;
use crate::step::kernel::{Kernel, land};
use crate::step::workspace::Workspace;
use catena_mechanism::description::body_state::BodyState;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::forces::total::Exchange;
use catena_mechanism::motion::energy::Energy;
use catena_mechanism::motion::state::State;
use std::sync::Arc;

impl<V: Lanes, W: Workspace<V>> Kernel<V, W> {
    /// Takes the end of a step that was solved to 32 digits: moves `state` there; returns its energy.
    pub(crate) fn arrive(
        &mut self,
        mechanism: &Mechanism,
        state: &mut State,
        displaced: &[Extended],
        rates: &[Extended],
    ) -> Energy {
        let parts: [fn(Extended) -> f64; 2] = [Extended::rounded, Extended::remainder];
        for part in parts {
            for (own, &displacement) in self.displaced.iter_mut().zip(displaced) {
                *own = part(displacement);
            }
            state.displace(mechanism, &self.displaced);
        }
        for (own, &rate) in state.velocity.iter_mut().zip(rates) {
            *own = rate.rounded();
        }
        self.workspace.set_end(&mut self.end, mechanism, state);
        W::energy(&self.end)
    }
}

impl<V: Lanes, W: Workspace<V>> Step for Kernel<V, W> {
    fn duplicate(&self) -> Box<dyn Step> {
        Box::new(self.clone())
    }

    fn expect(&mut self, mechanism: &Mechanism, stop: f64) {
        self.workspace.prepare_single(mechanism, self.tableau, stop);
    }

    fn expect_at(&mut self, counted: Arc<Counted>) {
        if let Some(closing) = &mut self.closing {
            closing.expect(counted);
        }
    }

    fn begin(&mut self, mechanism: &Mechanism, state: &State) {
        self.workspace.begin(mechanism, state);
        self.predictor.forget();
        self.chord = Chord::NEW;
        self.exact_for = exact_at_first(mechanism);
        if let Some(closing) = &mut self.closing {
            closing.begin(mechanism, state);
        }
    }

    fn drive(&mut self, efforts: &[f64]) {
        if let Some(applied) = self.workspace.applied_mut() {
            applied.drive(efforts);
        }
    }

    fn clock(&mut self, time: f64) {
        if let Some(applied) = self.workspace.applied_mut() {
            applied.clock(time);
        }
        self.time = time;
    }

    fn change(&mut self, freedoms: &[usize], at_stages: &[f64]) {
        let stages = self.tableau.stages;
        if let Some(applied) = self.workspace.applied_mut() {
            applied.change(freedoms, at_stages, stages);
        }
    }

    fn retract(&mut self) {
        std::mem::swap(self.workspace.start_mut(), &mut self.end);
        self.predictor.forget();
    }

    fn stage_displacements(&self, freedom: usize, displacements: &mut [f64]) {
        displacements.copy_from_slice(&self.workspace.displacement()[freedom].to_array().as_ref()[..self.active()]);
    }

    fn energy(&self) -> Energy {
        W::energy(self.workspace.start())
    }

    fn bodies(&self) -> Option<&[BodyState]> {
        W::bodies(self.workspace.start())
    }

    fn carried_bodies(&self) -> Option<&[BodyState]> {
        self.carried.as_ref().and_then(|carried| W::bodies(&carried.start))
    }

    fn has_past(&self) -> bool {
        self.predictor.has_past()
    }

    fn attempt(&mut self, mechanism: &Mechanism, step: f64, rule: &StopRule, guess: Guess) -> Attempt {
        self.solve(mechanism, step, rule, guess)
    }

    fn finish(&mut self, mechanism: &Mechanism, state: &mut State) -> Energy {
        let active = self.active();
        let Kernel {
            workspace, velocity, displaced, end, closing, newton, at_contacts, refined, moving, length, ..
        } = self;
        (*at_contacts, *moving) = (Exchange::default(), 0.0);
        // The end knows its time: joints may be moved in time.
        state.time += *length;
        if let (Some(newton), Some(closing)) = (&mut *newton, &mut *closing)
            && newton.exchanges()
        {
            // At the solution: the bodies are where they were in the last iteration.
            let (geometry, bias) = newton.bodies();
            workspace.place_stages(geometry, bias);
            *at_contacts = newton.exchanged();
            closing.lean(newton.rubbing().map_or(&[], Touching::leans));
        }
        let square = workspace.end_velocities(*refined, velocity);
        write_ends(workspace.displacement(), active, displaced);
        land(workspace, square, displaced, velocity, mechanism, state, end);
        if let Some(closing) = closing {
            *at_contacts += closing.velocities(mechanism, end, &mut state.velocity);
            workspace.set_end(end, mechanism, state);
            if mechanism.moves_joints() {
                *moving = closing.moving_work(end) + newton.as_ref().map_or(0.0, |newton| newton.moving_work());
            }
        }
        W::energy(end)
    }

    fn exchange(&self) -> Exchange {
        let exchange = self.workspace.applied().map_or(Exchange::default(), |applied| applied.exchange);
        let Exchange { friction, work, .. } = self.at_contacts;
        Exchange { friction, work: exchange.work + work + self.moving, ..exchange }
    }

    fn take_kept(&mut self) -> usize {
        self.chord.take_count()
    }

    fn known(&self) -> Option<&Known> {
        self.closing.as_ref().map(Closing::known)
    }

    fn closure_forces(&self, forces: &mut Vec<[f64; 3]>) -> bool {
        let newton = self.newton.as_ref().filter(|_| self.closing.is_some());
        newton.is_some_and(|newton| newton.closure_forces(self.length, forces))
    }

    fn redundant(&self) -> Option<usize> {
        self.closing.as_ref().and_then(Closing::weak)
    }

    fn close(&mut self, mechanism: &Mechanism, time: f64, position: &mut [f64], velocity: &mut [f64]) {
        if let Some(closing) = &mut self.closing {
            closing.project(mechanism, time, position, velocity);
        }
    }

    fn begin_to_carry(&mut self, mechanism: &Mechanism, state: &State) {
        self.start_carrying(mechanism, state);
    }

    fn carry_on(&mut self, mechanism: &Mechanism, state: &mut State, carrying: &Carrying) {
        self.carry(mechanism, state, carrying);
    }

    fn finish_both(
        &mut self,
        mechanism: &Mechanism,
        state: &mut State,
        beside: &mut State,
        carrying: &Carrying,
    ) -> Option<Energy> {
        let energy = self.end_both(mechanism, [&mut *state, beside], carrying)?;
        state.time += self.length;
        Some(energy)
    }

    fn keep_carried(&mut self) {
        self.settle_carried();
    }

    fn accept(&mut self) {
        let Kernel { workspace, predictor, end, .. } = self;
        let unknowns = workspace.unknowns();
        in_lanes!(V, predictor.learn(unknowns));
        std::mem::swap(workspace.start_mut(), end);
    }

    fn weigh_displacements(&self, weights: [&[f64]; 2], sums: &mut [[f64; 2]]) {
        weigh(self.workspace.displacement(), weights, sums);
    }

    fn last_displacement(&self, freedom: usize) -> f64 {
        at_end(self.workspace.displacement()[freedom], self.active())
    }

    fn accelerations(&mut self, step: f64, out: &mut [f64]) {
        self.workspace.set_step(step);
        self.guess(Guess::Plain);
        self.chord.restart();
        self.workspace.leave_single();
        self.iterate(false);
        write_ends(self.workspace.increment(), self.active(), out);
        for out in out {
            *out = 2.0 * *out / (step * step);
        }
    }
}
