//! A coarser run beside another, with its own steps: their distance is an estimate of the error.

use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::event::Event;
use crate::mechanism::motion::integrator::Integrator;
use crate::mechanism::motion::state::State;
use crate::simulation::method::run_integrator::RunIntegrator;
use crate::simulation::tolerance::terms::Terms;
use crate::stepping::length::control::COARSEST_STOP;
use crate::stepping::length::stage_choice::StageChoice;

/// Stop of this run over the stop of the run beside it.
pub(crate) const RATIO: f64 = 30.0;
/// The least energy change that may be made, over the stop. If it had the bound of the run, a coarse companion would take more steps than the run.
const ENERGY: f64 = 300.0;
/// Length of its steps over events over those of the run beside it.
const OVER_EVENTS: f64 = 2.0;

/// Why a separate run has not reached the time that was asked for.
pub(crate) enum Behind {
    /// It has failed: so coarse a run may fail although a finer one succeeds.
    Failed,
    /// It was interrupted, and may go on from where it is.
    Interrupted,
}

/// A separate coarser run, and its state.
pub(crate) struct Beside {
    pub(crate) run: RunIntegrator,
    pub(crate) state: State,
    pub(crate) events: Vec<Event>,
    /// Number of its steps.
    steps: usize,
}

impl Beside {
    /// A run with these settings and this stop, from a state on; `None` for invalid steps.
    pub(crate) fn new(
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
            ..*terms
        };
        let run = coarser.run(mechanism, stop, stages).ok()?;
        // Impacts of both that end at the same height would hide what that leaves.
        let mut run = run.leaving(stop / coarser.first_stop(mechanism), RATIO);
        run.coarsen_over_events(OVER_EVENTS);
        Some(Beside { run, state: state.clone(), events: Vec::new(), steps: 0 })
    }

    /// The part of the distance of both runs that is the error of the finer one, as far as steps of first order have made it.
    ///
    /// ```text
    ///     e = C Σ h²,    e′ − e = C (Σ h′² − Σ h²)        over events: the error of each step is in proportion to h² (m)
    ///     e = C Σ h                                       over jams, which leave an error of the velocity in proportion to h
    /// ```
    pub(crate) fn share_of_first_order(&self, finer: &RunIntegrator) -> f64 {
        let [own, coarser] = [finer, &self.run].map(RunIntegrator::smeared);
        let shares = own.into_iter().zip(coarser).filter(|(own, _)| *own > 0.0);
        shares.map(|(own, coarser)| own / (coarser - own).max(own)).fold(0.0, f64::max)
    }

    /// The part of the distance of both runs that is the error of the finer one, which has made this number of steps of s stages, as far as truncation
    /// has made it. Events end the steps of both runs: between events that are near each other, the coarser run makes as many.
    ///
    /// ```text
    ///     e′/e = (n/n′)^(2s − 2)        n, n′: the numbers of steps
    /// ```
    pub(crate) fn share_of_truncation(&self, steps: usize, stages: usize) -> f64 {
        let longer = steps as f64 / self.steps.max(1) as f64;
        longer.max(1.0).powi(2 - 2 * stages as i32)
    }

    /// Whether it alone steps over events, so that it does not say which events it has met.
    pub(crate) fn hides_events(&self, finer: &RunIntegrator) -> bool {
        self.run.smeared()[0] > 0.0 && finer.smeared()[0] == 0.0
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
            self.run.advance(mechanism, &mut self.state, until).map_err(|_| Behind::Failed)?;
            self.steps += 1;
            self.run.take_events(&mut self.events);
        }
        Ok(())
    }
}
