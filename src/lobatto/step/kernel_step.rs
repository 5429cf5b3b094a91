//! A step of the kernel, from its start to the next: begun, attempted, finished and accepted.
//!
//! ```text
//!     state ──set──▶ start ──iteration──▶ stages ──ending──▶ displacements and rates at the end ──set──▶ end, the next start
//! ```

use crate::coupled::closing::Closing;
use crate::ending::refinement::have_lost_digits;
use crate::numbers::extended::Extended;
use crate::numbers::lanes::{Lanes, in_lanes};
use crate::numbers::reductions::{at_end, weigh, write_ends};
use crate::solve::iteration::{Equations, Guarded, exact_at_first};
use crate::solve::kept_factors::Chord;
use crate::stages::attempt::{Attempt, Guess, StopRule};
use crate::step::kernel::Kernel;
use crate::step::step::Step;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::forces::total::Exchange;
use catena_mechanism::motion::energy::Energy;
use catena_mechanism::motion::state::State;

impl<V: Lanes> Kernel<V> {
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
        self.end.set(mechanism, state);
        self.end.energy
    }

    /// Refines the velocities at the end of a step, of which this is the square, if they need it.
    fn refine(&mut self, mechanism: &Mechanism, state: &mut State, square: f64) {
        let Kernel { stages, ending, gravity, velocity, end, .. } = self;
        if have_lost_digits(square, end.energy.kinetic * stages.start.units) {
            in_lanes!(V, ending.refine(stages, gravity, velocity, square));
            state.velocity.copy_from_slice(velocity);
            end.set_with::<V>(mechanism, state);
        }
    }
}

impl<V: Lanes> Step for Kernel<V> {
    fn expect(&mut self, mechanism: &Mechanism, stop: f64) {
        self.first.prepare(mechanism, &self.stages.plan, self.tableau, stop);
    }

    fn begin(&mut self, mechanism: &Mechanism, state: &State) {
        self.stages.start.set(mechanism, state);
        self.predictor.forget();
        self.chord = Chord::NEW;
        self.first.forget();
        self.exact_for = exact_at_first(mechanism);
    }

    fn drive(&mut self, efforts: &[f64]) {
        if let Some(applied) = &mut self.stages.applied {
            applied.drive(efforts);
        }
    }

    fn energy(&self) -> Energy {
        self.stages.start.energy
    }

    fn has_past(&self) -> bool {
        self.predictor.has_past()
    }

    fn attempt(&mut self, mechanism: &Mechanism, step: f64, rule: &StopRule, guess: Guess) -> Attempt {
        self.solve(mechanism, step, rule, guess)
    }

    fn finish(&mut self, mechanism: &Mechanism, state: &mut State) -> Energy {
        let Kernel { stages, ending, gravity, velocity, .. } = self;
        let square = if stages.plan.tumbles {
            in_lanes!(V, stages.place_tumbler(gravity));
            in_lanes!(V, ending.tumbler_velocities(stages, gravity, velocity));
            None
        } else {
            in_lanes!(V, stages.sweep_poses());
            if stages.applied.is_some() {
                in_lanes!(V, stages.sweep_applied(true));
            }
            let square = if V::GENERAL_ALONE || stages.applied.is_some() {
                in_lanes!(V, ending.velocities::<V, true, true>(stages, gravity, velocity))
            } else if self.refined {
                in_lanes!(V, ending.velocities::<V, true, false>(stages, gravity, velocity))
            } else {
                in_lanes!(V, ending.velocities::<V, false, false>(stages, gravity, velocity))
            };
            // What dampers brake is in the factors, and no kinetic energy.
            stages.applied.is_none().then_some(square)
        };
        write_ends(&stages.displacement, stages.coefficients.active, &mut self.displaced);
        state.displace(mechanism, &self.displaced);
        state.velocity.copy_from_slice(&self.velocity);
        self.end.set_with::<V>(mechanism, state);
        if let Some(square) = square {
            self.refine(mechanism, state, square);
        }
        if let Some(closing) = &mut self.closing {
            closing.velocities(mechanism, &self.end, &mut state.velocity);
            self.end.set_with::<V>(mechanism, state);
        }
        self.end.energy
    }

    fn exchange(&self) -> Exchange {
        self.stages.applied.as_ref().map_or(Exchange::default(), |applied| applied.exchange)
    }

    fn take_kept(&mut self) -> usize {
        self.chord.take_count()
    }

    fn redundant(&self) -> Option<usize> {
        self.closing.as_ref().and_then(Closing::weak)
    }

    fn close(&mut self, mechanism: &Mechanism, position: &mut [f64], velocity: &mut [f64]) {
        if let Some(closing) = &mut self.closing {
            closing.project(mechanism, position, velocity);
        }
    }

    fn accept(&mut self) {
        let (stages, predictor) = (&mut self.stages, &mut self.predictor);
        in_lanes!(V, predictor.learn(stages.unknowns()));
        std::mem::swap(&mut self.stages.start, &mut self.end);
    }

    fn weigh_displacements(&self, weights: [&[f64]; 2], sums: &mut [[f64; 2]]) {
        weigh(&self.stages.displacement, weights, sums);
    }

    fn last_displacement(&self, freedom: usize) -> f64 {
        at_end(self.stages.displacement[freedom], self.stages.coefficients.active)
    }

    fn accelerations(&mut self, step: f64, out: &mut [f64]) {
        self.stages.step = step;
        self.guess(Guess::Plain);
        self.chord.restart();
        self.first.leave();
        self.iterate(false);
        write_ends(&self.stages.increment, self.stages.coefficients.active, out);
        for out in out {
            *out = 2.0 * *out / (step * step);
        }
    }
}
