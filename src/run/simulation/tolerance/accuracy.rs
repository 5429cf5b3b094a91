//! Finds the local accuracy of steps that gives a wanted accuracy of the run, by trial runs.
//!
//! The motion amplifies the error of a step until the end of the run: by 10² for a pendulum over seconds, by 10⁶ for a falling arm, without bound for
//! chaos. Two trial runs with iteration stops `ε` and `ε/30` measure this. If their distance is `d`, the error of the coarser one is about `d`.
//! Errors are proportional to the stop. So the stop that keeps every error near a tenth of the wanted accuracy `E` is
//!
//! ```text
//!     ε_run = ε E / (10 max_t d(t))
//! ```
//!
//! with the distance of [`crate::mechanism::motion::distance`], computed at up to 32 instants where steps of the coarser trial run end. Its stop is
//! the coarsest that any run gets. Trial runs whose distance exceeds a hundredth of the mechanism's size have parted and give no estimate. Then the
//! finer one becomes the coarser of the next pair, unless it would part early, too. If the finest pair cannot hold the accuracy to the end, the
//! calibration gives the time until which it holds; if the pair parted long before the end, more instants before that time are compared.
//!
//! A coarse trial run may be accurate by luck: in one of fifty runs of a chain of ten links, a hundred times more than its stop suggests. So if
//! `ε_run` is nearly as coarse as its stop, a third trial run with `ε_run` is compared with the finer one of the pair. If `ε_run` is that very
//! stop, the coarser trial run is this test. Then the run misses the tolerance tenfold only if luck made the trial run more than a hundred times
//! too accurate.
//!
//! Rounding errors do not fall with the stop. If `ε_run` is near rounding, and the coarser trial run missed the tolerance, one more trial run with
//! `ε_run` measures them.
//!
//! Trial runs have the number of stages of the run ([`crate::stepping::length::stage_choice`]); later pairs have the stages of a tolerance that would
//! begin with them. A pair with few stages whose first steps are limited by stability, not by accuracy, restarts with more stages.

use crate::lobatto::coupled::counted::Counted;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::description::nonsmooth::Nonsmooth;
use crate::mechanism::description::rules::Rule;
use crate::mechanism::motion::distance::size;
use crate::mechanism::motion::event::Event;
use crate::mechanism::motion::integrator::{StepError, StepOutcome};
use crate::mechanism::motion::state::State;
use crate::simulation::method::run_integrator::RunIntegrator;
use crate::simulation::tolerance::event_order::first_difference;
use crate::simulation::tolerance::trial_run::{CalibrationError, Course, GoOn, Pair, TrialRun};
use crate::stepping::integrator::{Lobatto, MethodError};
use crate::stepping::length::control::COARSEST_STOP;
use crate::stepping::length::stage_choice::StageChoice;
use crate::stepping::recipe::Steps;
use std::sync::Arc;

/// Ratio of the stops of the two trial runs of a pair.
const RATIO: f64 = 30.0;
/// The finest stop, at rounding.
const FINEST: f64 = 1e-16;
/// The finest stop of the next pair, over the finest of a pair that has parted.
const REFINEMENT: f64 = 1e-6;
/// The coarsest stop of a first pair: a coarser one would give a motion that is far from the true one.
const COARSEST: f64 = 1e-3;
/// The run stops at no more than this part of the tolerance, however calm the motion, so that its energy is accurate too,
const CALM: f64 = 0.03;
/// and at this part if forces exchange energy, which costs a digit.
const CALM_WITH_FORCES: f64 = 0.01;
/// The least energy change that trial runs may make, over their stops. If they had the bound of the run, coarse trial runs would take more steps than
/// the run.
const ENERGY: f64 = 300.0;
/// The run aims at this part of the tolerance, because two runs of one motion with different steps differ by about this factor.
const AIM: f64 = 10.0;
/// A run with a stop above this part of the coarser trial run's stop is tested by a third trial run.
const LUCKY: f64 = 0.25;
/// Runs with a finer stop than this may be limited by rounding.
const ROUNDED: f64 = 1e-13;
/// Trial runs have parted if their distance exceeds this share of the mechanism's size; then they give no estimate of smaller errors.
const SATURATED: f64 = 1e-2;

/// If the finest trial runs have parted before this many instants of comparison, they are compared at more instants.
const CLOSELY: usize = 8;

/// Why the accuracy of a run is not known.
#[derive(Clone, Debug, thiserror::Error)]
pub enum UnknownAccuracy {
    /// Stages and steps were given.
    #[error("no --tolerance was asked for")]
    NotAsked,
    /// The run has made no step yet.
    #[error("the run ended before its error could be estimated")]
    NotYet,
    /// External efforts act, which the companion of the error estimate does not have.
    #[error("a program sets efforts on the joints, and the error estimate does not know its law")]
    Driven,
    /// The run was asked for no estimate.
    #[error("the run makes no estimate (--no-estimate); each step keeps to its share of the tolerance")]
    NotEstimated,
    /// A program makes the steps of the run.
    #[error(
        "a program makes this run step by step: each step keeps to its share of the tolerance, and the error at the end is not estimated"
    )]
    Stepped,
    /// A trial run failed, and the run will fail for the same reason.
    #[error("a trial run failed: {0}")]
    TrialFailed(StepError),
}

/// The result of the trial runs, or of the run's own estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibration {
    /// The iteration stop to run with.
    pub stop: f64,
    /// The number of stages for this stop.
    pub stages: StageChoice,
    /// The estimated error at the end of the worst step of the run (m).
    pub estimate: f64,
    /// The error of samples inside the steps, beside the error of their ends (m); `None` if it is not known.
    pub between_steps: Option<f64>,
    /// The last instant up to which the estimated error meets the tolerance (s); the end of the run if it always does.
    pub holds_until: f64,
    /// The instant up to which this is known (s): the end of the run, or a little before if it was interrupted; for trial runs the end that was
    /// asked for.
    pub told_until: f64,
    /// Whether the finest trial runs part before the end, so that finer steps would not help.
    pub parted: bool,
    /// Whether its errors may grow from almost zero, as errors of chaotic motions do ([`may_be_chaotic`]).
    pub amplifies: bool,
    /// If the accuracy does not hold to the end: the first instant (s) from which the finest trial runs meet different events (impacts, sticking,
    /// bounds of motors).
    pub events_differ: Option<f64>,
    /// Number of trial runs: zero if the run itself estimated its error.
    pub pilots: usize,
    /// How many times the run was begun.
    pub begun: usize,
}

/// Whether a motion can amplify errors for ever. A single freedom cannot, without impacts, dry friction and targets that change in time.
pub(crate) fn may_be_chaotic(mechanism: &Mechanism) -> bool {
    let Nonsmooth { limits, friction, motors, pairs, .. } = &mechanism.nonsmooth;
    let is_struck = !limits.is_empty() || !friction.is_empty() || !pairs.is_empty();
    mechanism.velocity_count > 1 || is_struck || motors.iter().any(|motor| !motor.target.is_constant())
}

impl Calibration {
    /// The calibrated integrator, for the same smooth mechanism and tolerance (m).
    pub fn integrator(&self, mechanism: &Mechanism, tolerance: f64) -> Lobatto {
        Lobatto::adaptive_with_stages(mechanism, tolerance, self.stop, self.stages)
    }

    /// The calibrated integrator of a run, for the same mechanism, tolerance (m) and rules.
    ///
    /// # Errors
    /// [`MethodError`]: never for values that were calibrated.
    pub fn run_integrator(
        &self,
        mechanism: &Mechanism,
        tolerance: f64,
        kept: &[Rule],
    ) -> Result<RunIntegrator, MethodError> {
        RunIntegrator::new(mechanism, Steps::Chosen { tolerance, stop: self.stop, stages: self.stages }, kept)
    }
}

/// Finds the iteration stop with which a run of `duration` from `state` is accurate to `tolerance` (m), with these rules disabled.
///
/// # Errors
/// [`CalibrationError`] if a trial run fails, or if `go_on` returns false. `go_on` gets the time and the outcome of every step of the trial runs.
pub fn calibrate(
    mechanism: &Mechanism,
    state: &State,
    duration: f64,
    tolerance: f64,
    kept: &[Rule],
    go_on: &mut dyn FnMut(f64, &StepOutcome) -> bool,
) -> Result<Calibration, CalibrationError> {
    calibrate_counted(mechanism, state, None, duration, tolerance, kept, go_on)
}

/// The same with ranks of closures that were computed before.
///
/// # Errors
/// As of [`calibrate`].
pub(crate) fn calibrate_counted(
    mechanism: &Mechanism,
    state: &State,
    counted: Option<&Arc<Counted>>,
    duration: f64,
    tolerance: f64,
    kept: &[Rule],
    go_on: &mut dyn FnMut(f64, &StepOutcome) -> bool,
) -> Result<Calibration, CalibrationError> {
    let calm = if mechanism.is_plain_tree() { CALM } else { CALM_WITH_FORCES };
    let size = size(mechanism, state);
    let course = Course { start: state.time, end: state.time + duration, apart: SATURATED * size };
    let mut search =
        Search { mechanism, state, counted, tolerance, coarsest: calm * tolerance, kept, course, pilots: 0 };
    let Couple { coarse, fine, parted } = search.couple(go_on)?;

    // Errors below rounding cannot be measured and do not matter.
    let mut amplification = coarse.worst().max(1e-16 * size) / coarse.stop;
    let mut apart: Vec<f64> = coarse.apart.iter().map(|apart| apart / coarse.stop).collect();
    let tried = search.stop_for(amplification);
    if !parted && tried > LUCKY * coarse.stop && tried != coarse.stop {
        let trial = search.trial(tried, &fine, go_on);
        let found = match &trial {
            Ok(trial) => trial.worst() / tried,
            // If so coarse a run fails, the coarser trial run's error is used.
            Err(CalibrationError::Step(_)) => tolerance / (AIM * coarse.stop),
            Err(CalibrationError::Method(error)) => return Err(CalibrationError::Method(error.clone())),
            Err(CalibrationError::Interrupted) => return Err(CalibrationError::Interrupted),
        };
        amplification = amplification.max(found);
        for (apart, tried_apart) in apart.iter_mut().zip(trial.iter().flat_map(|trial| &trial.apart)) {
            *apart = apart.max(tried_apart / tried);
        }
    }
    let stop = search.stop_for(amplification);
    let mut errors: Vec<f64> = apart.iter().map(|apart| apart * stop).collect();
    let mut worst = amplification * stop;
    if !parted && stop < ROUNDED && coarse.worst() > tolerance {
        let trial = search.trial(stop, &fine, go_on)?;
        // A run with the stop of the finer trial run is the same run, so it gives no estimate.
        let seen = if trial.worst() > 0.0 { &trial } else { &coarse };
        worst = worst.max(seen.worst());
        for (error, &seen) in errors.iter_mut().zip(&seen.apart) {
            *error = error.max(seen);
        }
    }
    let held = errors.iter().take_while(|&&error| error <= tolerance).count();
    let holds_until = if held == 0 { state.time } else { coarse.trail[held - 1].0 };
    // Different events with negligible effect are not reported.
    let compared = if errors.len() > held { coarse.trail.get(coarse.apart.len() - 1) } else { None };
    let differ = compared.and_then(|&(end, _)| {
        let until =
            |run: &TrialRun| -> Vec<Event> { run.events.iter().copied().filter(|event| event.time <= end).collect() };
        first_difference(&until(&coarse), &until(&fine))
    });
    Ok(Calibration {
        stop,
        stages: coarse.stages,
        // Runs that have parted may end at any distance up to the size of the mechanism.
        // No position is known better than it is rounded.
        estimate: if parted { size } else { worst.max(f64::EPSILON * size) },
        between_steps: None,
        holds_until: differ.map_or(holds_until, |differ| holds_until.min(differ)),
        told_until: search.course.end,
        events_differ: differ,
        parted,
        amplifies: may_be_chaotic(mechanism),
        pilots: search.pilots,
        begun: 1,
    })
}

/// The arguments of the search.
struct Search<'s> {
    mechanism: &'s Mechanism,
    state: &'s State,
    counted: Option<&'s Arc<Counted>>,
    tolerance: f64,
    /// The coarsest stop of a run.
    coarsest: f64,
    kept: &'s [Rule],
    course: Course,
    /// Trial runs so far.
    pilots: usize,
}

/// The pair of trial runs that measures the growth of errors.
struct Couple<'s> {
    coarse: TrialRun<'s>,
    fine: TrialRun<'s>,
    /// Whether it has parted and no finer pair exists.
    parted: bool,
}

impl<'s> Search<'s> {
    /// Starts a trial run.
    fn pilot(&mut self, stop: f64, stages: StageChoice) -> Result<TrialRun<'s>, CalibrationError> {
        self.pilots += 1;
        let energy = self.tolerance.max(ENERGY * stop);
        let steps = Steps::Chosen { tolerance: energy, stop, stages };
        Ok(TrialRun {
            mechanism: self.mechanism,
            integrator: RunIntegrator::new(self.mechanism, steps, self.kept)?.counted(self.counted.cloned()),
            stop,
            stages,
            state: self.state.clone(),
            trail: Vec::new(),
            held_back: false,
            events: Vec::new(),
            apart: Vec::new(),
        })
    }

    /// The stop of a run with this amplification of errors.
    fn stop_for(&self, amplification: f64) -> f64 {
        (self.tolerance / (AIM * amplification)).min(self.coarsest).clamp(FINEST, COARSEST_STOP)
    }

    /// The stop with which a pair would not have parted, if errors grow exponentially as before: between the times up to which the pair `before` and
    /// this one lasted, or from the start without such a pair.
    fn enough(&self, stop: f64, lasted: f64, before: Option<(f64, f64)>) -> f64 {
        let Course { start, end, apart } = self.course;
        match before {
            Some((coarser, less)) if less < lasted => stop * (stop / coarser).powf((end - lasted) / (lasted - less)),
            _ => apart * (stop / apart).min(1.0).powf((end - start) / (lasted - start)),
        }
    }

    /// Pairs of trial runs, each finer than the one before, until one stays together.
    fn couple(&mut self, go_on: GoOn) -> Result<Couple<'s>, CalibrationError> {
        let first = self.coarsest.clamp(FINEST * RATIO, COARSEST);
        let (mut stiff, mut before) = (false, None);
        let mut coarse = self.pilot(first, StageChoice::of(self.mechanism, self.tolerance))?;
        loop {
            // The last pair has the ratio of all others.
            let finest = if coarse.stop > FINEST * RATIO { FINEST * RATIO } else { FINEST };
            let mut fine = self.pilot((coarse.stop / RATIO).max(finest), coarse.stages)?;
            let pair = match coarse.accompany(&mut fine, self.course, go_on) {
                // So coarse a trial run may fail although a finer one succeeds.
                Err(CalibrationError::Step(_)) if coarse.stop == first && fine.stop > FINEST => Pair::Parted,
                pair => pair?,
            };
            match pair {
                Pair::Together => return Ok(Couple { coarse, fine, parted: false }),
                Pair::Parted if fine.stop <= FINEST => {
                    let parted = Couple { coarse, fine, parted: true };
                    return if parted.coarse.trail.len() < CLOSELY { self.closer(parted, go_on) } else { Ok(parted) };
                }
                Pair::Parted => {
                    let lasted = coarse.trail.last().map_or(self.course.start, |&(time, _)| time);
                    let enough = self.enough(coarse.stop, lasted, before);
                    before = Some((coarse.stop, lasted));
                    let stop = enough.clamp(coarse.stop * REFINEMENT, fine.stop).max(FINEST * RATIO);
                    let wanted = StageChoice::of(self.mechanism, stop * (self.tolerance / self.coarsest));
                    let stages = if stiff { StageChoice::Many } else { wanted };
                    let goes_on = stop == fine.stop && stages == fine.stages;
                    coarse = if goes_on { fine } else { self.pilot(stop, stages)? };
                }
                Pair::HeldBack => {
                    stiff = true;
                    coarse = self.pilot(coarse.stop, StageChoice::Many)?;
                }
            }
        }
    }

    /// Repeats the pair up to the instant at which it had parted, with more instants of comparison.
    fn closer(&mut self, parted: Couple<'s>, go_on: GoOn) -> Result<Couple<'s>, CalibrationError> {
        let end = parted.coarse.trail.last().map_or(self.course.end, |&(time, _)| time);
        let course = Course { end, ..self.course };
        let mut coarse = self.pilot(parted.coarse.stop, parted.coarse.stages)?;
        let mut fine = self.pilot(parted.fine.stop, parted.fine.stages)?;
        match coarse.accompany(&mut fine, course, go_on)? {
            Pair::HeldBack => Ok(parted),
            Pair::Together | Pair::Parted => Ok(Couple { coarse, fine, parted: true }),
        }
    }

    /// A trial run with another stop than the stops of a pair, compared with the finer one.
    fn trial(&mut self, stop: f64, fine: &TrialRun, go_on: GoOn) -> Result<TrialRun<'s>, CalibrationError> {
        let mut trial = self.pilot(stop, fine.stages)?;
        trial.follow(fine, go_on)?;
        Ok(trial)
    }
}
