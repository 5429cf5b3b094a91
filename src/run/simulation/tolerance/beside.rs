//! A run beside another, with its own steps: their distance is an estimate of the error. It is coarser, for the least cost; one that seems to be far off
//! may be off itself, and a finer one has the last word.

use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::event::Event;
use crate::mechanism::motion::state::State;
use crate::simulation::method::run_integrator::RunIntegrator;
use crate::simulation::tolerance::forecast::{FINEST, ROUNDED};
use crate::simulation::tolerance::terms::Terms;
use crate::stepping::length::control::COARSEST_STOP;
use crate::stepping::length::stage_choice::StageChoice;

/// Stop of this run over the stop of the run beside it.
pub(crate) const RATIO: f64 = 30.0;
/// The stop of steps of a coarser run that ticks of motors end early, over its stop. Both runs make the same such steps, often with the same number of
/// iterations; so it is finer in them, and their distance has the error of the run.
const BOUNDED: f64 = 1.0 / (RATIO * RATIO);
/// The least energy change that may be made, over the stop. If it had the bound of the run, a coarse companion would take more steps than the run.
const ENERGY: f64 = 300.0;
/// Length of its steps over events over the length of such steps of the run beside it.
const OVER_EVENTS: f64 = 2.0;
/// The stop of a finer run beside one whose stop is at rounding, over that stop: its steps are others.
const OTHER_STEPS: f64 = 10.0;
/// The error of a run is at most this times its distance from a finer one: errors of both may have the same sign.
const NEAR_TRUTH: f64 = 1.25;

/// The error of a run is at most this times the error of a coarser one over [`RATIO`], because that may be accurate by luck.
const LUCK: f64 = 3.0;
/// Factor for the rounding errors of two motions that round independently.
pub(crate) const OWN_ROUNDINGS: f64 = 2.0;

/// Why a separate run has not reached the time that was asked for.
pub(crate) enum Behind {
    /// It has failed: so coarse a run may fail although a finer one succeeds.
    Failed,
    /// It was interrupted, and may go on from where it is.
    Interrupted,
}

/// A separate run, and its state.
pub(crate) struct Beside {
    /// Whether it is finer than the run beside it.
    is_finer: bool,
    pub(crate) run: RunIntegrator,
    pub(crate) state: State,
    pub(crate) events: Vec<Event>,
    /// Number of its steps, and of those that end at a tick of a motor.
    steps: usize,
    ticks: usize,
    /// Where it has been, at an instant to which the run may go back.
    past: Option<State>,
}

impl Beside {
    /// A coarser run with these settings and beside this stop, from a state on; `None` for invalid steps.
    pub(crate) fn coarser(
        mechanism: &Mechanism,
        terms: &Terms,
        stop: f64,
        stages: StageChoice,
        state: &State,
    ) -> Option<Self> {
        let stop = (RATIO * stop).min(COARSEST_STOP);
        let coarser = Terms {
            tolerance: terms.tolerance.max(ENERGY * stop),
            kept: terms.kept.clone(),
            counted: terms.counted.clone(),
            interrupt: terms.interrupt.clone(),
            ..*terms
        };
        let bounded = if mechanism.nonsmooth.samples() { BOUNDED } else { 1.0 };
        let run = coarser.run_bounded(mechanism, stop, stages, bounded).ok()?;
        // Impacts of both that end at the same height would hide what that leaves.
        let mut run = run.leaving(stop / coarser.first_stop(mechanism), RATIO);
        run.coarsen_over_events(OVER_EVENTS);
        Some(Beside { is_finer: false, run, state: state.clone(), events: Vec::new(), steps: 0, ticks: 0, past: None })
    }

    /// A finer run, whose accumulating impacts and steps over events leave less.
    pub(crate) fn finer(
        mechanism: &Mechanism,
        terms: &Terms,
        stop: f64,
        stages: StageChoice,
        state: &State,
    ) -> Option<Self> {
        let finer = if stop < ROUNDED { OTHER_STEPS * stop } else { (stop / RATIO).max(FINEST) };
        let run = terms.run(mechanism, finer, stages).ok()?;
        let mut run = run.leaving(stop / (RATIO * terms.first_stop(mechanism)), 1.0 / RATIO);
        run.coarsen_over_events(1.0 / OVER_EVENTS);
        Some(Beside { is_finer: true, run, state: state.clone(), events: Vec::new(), steps: 0, ticks: 0, past: None })
    }

    /// Whether it is finer than the run beside it.
    pub(crate) fn is_finer(&self) -> bool {
        self.is_finer
    }

    /// The part of the distance of both runs that is the error of the run beside it, which has this stop and stages, and has made this number of steps.
    pub(crate) fn share(&self, run: &RunIntegrator, stop: f64, stages: StageChoice, steps: usize) -> f64 {
        if self.is_finer {
            return NEAR_TRUTH.max(self.share_of_first_order(run));
        }
        let share = if RATIO * stop < ROUNDED { OWN_ROUNDINGS } else { LUCK / RATIO };
        // The iterations of nine stages leave errors in proportion to the stop. With five stages truncation is far larger.
        let truncated = match stages {
            StageChoice::Many => 0.0,
            few => (LUCK * self.share_of_truncation(steps, few.count())).min(1.0),
        };
        let at_ticks = self.ticks as f64 / self.steps.max(1) as f64;
        share.max(self.share_of_first_order(run)).max(truncated).max(at_ticks)
    }

    /// The part of the distance of both runs that is the error of the run beside it, as far as steps of first order have made it.
    ///
    /// ```text
    ///     e = C Σ h²,    |e′ − e| = C |Σ h′² − Σ h²|      over events: the error of each step is in proportion to h² (m)
    ///     e = C Σ h                                       over jams, which leave an error of the velocity in proportion to h
    /// ```
    pub(crate) fn share_of_first_order(&self, run: &RunIntegrator) -> f64 {
        let [own, beside] = [run, &self.run].map(RunIntegrator::smeared);
        let shares = own.into_iter().zip(beside).filter(|(own, _)| *own > 0.0);
        let apart = |own: f64, beside: f64| {
            if self.is_finer { (own - beside).max(own / RATIO) } else { (beside - own).max(own) }
        };
        shares.map(|(own, beside)| own / apart(own, beside)).fold(0.0, f64::max)
    }

    /// The part of the distance of both runs that is the error of the finer one, which has made this number of steps of s stages, as far as truncation
    /// has made it. Events end the steps of both runs: between events that are near each other, the coarser run makes as many.
    ///
    /// ```text
    ///     e′/e = (n/n′)^(2s − 2)        n, n′: the numbers of steps
    /// ```
    fn share_of_truncation(&self, steps: usize, stages: usize) -> f64 {
        let longer = steps as f64 / self.steps.max(1) as f64;
        longer.max(1.0).powi(2 - 2 * stages as i32)
    }

    /// Whether it alone steps over events, or any of both runs steps over slips, so that they do not say which events they have met.
    pub(crate) fn hides_events(&self, finer: &RunIntegrator) -> bool {
        let over_slips = |run: &RunIntegrator| run.description().over_slips_steps > 0;
        self.run.smeared()[0] > 0.0 && finer.smeared()[0] == 0.0 || over_slips(&self.run) || over_slips(finer)
    }

    /// Advances to a time (s) by way of an instant (s) to which the run may go back, unless it has passed that.
    ///
    /// # Errors
    /// [`Behind`] if it does not reach that time.
    pub(crate) fn advance_by_way_of(
        &mut self,
        mechanism: &Mechanism,
        terms: &Terms,
        [back, until]: [f64; 2],
    ) -> Result<(), Behind> {
        self.advance(mechanism, terms, back)?;
        if self.state.time == back {
            self.past = Some(self.state.clone());
        }
        self.advance(mechanism, terms, until)
    }

    /// Where it was at an instant (s), if it was there.
    pub(crate) fn at(&self, time: f64) -> Option<&State> {
        std::iter::once(&self.state).chain(&self.past).find(|state| state.time == time)
    }

    /// Advances to a time (s), at which a step ends. The steps of the finer run do not end there, so the steps of the two runs differ.
    ///
    /// # Errors
    /// [`Behind`] if it does not reach that time.
    pub(crate) fn advance(&mut self, mechanism: &Mechanism, terms: &Terms, until: f64) -> Result<(), Behind> {
        while self.state.time < until {
            if terms.is_interrupted() {
                return Err(Behind::Interrupted);
            }
            let from = self.state.time;
            self.run.advance(mechanism, &mut self.state, until).map_err(|_| Behind::Failed)?;
            self.steps += 1;
            let ticks = mechanism.nonsmooth.motors.iter().any(|motor| motor.ticks(from, self.state.time));
            self.ticks += usize::from(ticks);
            self.run.take_events(&mut self.events);
        }
        Ok(())
    }
}
