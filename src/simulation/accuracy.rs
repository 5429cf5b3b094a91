//! From a wanted accuracy to the local accuracy that gives it: trial runs.
//!
//! An error made at a step is amplified by the motion until the end of the run, by 10² for a pendulum over seconds,
//! by 10⁶ for a falling arm, without bound for chaos. Two trial runs, with iteration stops `ε` and `ε/30`, show it: where
//! they are `d` apart, the coarser is wrong by about `d`, and because errors are proportional to the stop, the stop that
//! keeps every error near a tenth of the wanted accuracy `E` is
//!
//! ```text
//!     ε_run = ε E / (10 max_t d(t))
//! ```
//!
//! with the distance of [`crate::mechanism::motion::distance`], seen at up to 32 instants where steps of the coarser trial run end. That has the coarsest stop
//! that a run is given, however calm its motion. Trial runs that are apart by more than a hundredth of the mechanism's size have parted and say
//! nothing; then the finer one is the coarser of the next pair, unless they parted so early that this one would part, too. If the finest
//! pair cannot hold the accuracy to the end, the calibration says until when it is held; where it parted long before, after another look at the
//! time until then.
//!
//! A coarse trial run may be right by luck, a hundred times nearer than its stop lets expect in one of fifty runs of a chain of ten links. So
//! where `ε_run` would be about as coarse as its stop, a third trial run tries it, and the finer one of the pair says how far off that is. Where
//! it would be that very stop, because no run gets a coarser one, the trial run has tried it, and luck would have to be more than a
//! hundredfold before the run were ten times further off than is wanted.
//!
//! Roundings do not fall with the stop. Where `ε_run` is near them, and the coarser trial run was further off than is wanted, one more trial run with
//! `ε_run` shows what they leave.
//!
//! Trial runs have the number of stages of the run ([`crate::stepping::stage_choice`]), later pairs that of a tolerance that would begin with them. A pair
//! with few stages whose first steps are limited by stability, and not by accuracy, restarts with more.

use crate::lobatto::coupled::counted::Counted;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::description::rules::Rule;
use crate::mechanism::motion::distance::size;
use crate::mechanism::motion::event::Event;
use crate::mechanism::motion::integrator::{StepError, StepOutcome};
use crate::mechanism::motion::state::State;
use crate::simulation::event_order::first_difference;
use crate::simulation::run_integrator::RunIntegrator;
use crate::simulation::trial_run::{CalibrationError, Course, GoOn, Pair, TrialRun};
use crate::stepping::control::COARSEST_STOP;
use crate::stepping::integrator::{Lobatto, MethodError};
use crate::stepping::recipe::Steps;
use crate::stepping::stage_choice::StageChoice;
use std::sync::Arc;

/// Ratio of the stops of the two trial runs of a pair.
const RATIO: f64 = 30.0;
/// The finest stop: rounding.
const FINEST: f64 = 1e-16;
/// The finest stop of the next pair, over that of one that has parted.
const REFINEMENT: f64 = 1e-6;
/// The coarsest stop of a first pair: what is coarser shows a motion that has little to do with the true one.
const COARSEST: f64 = 1e-3;
/// The run stops at no more than this part of the tolerance, however calm the motion: the energy has to be kept as well,
const CALM: f64 = 0.03;
/// and balanced where forces take part in it, which costs a digit.
const CALM_WITH_FORCES: f64 = 0.01;
/// What trial runs may change the energy by, over their stops, at least: with that of the run the coarse ones would take more steps than it.
const ENERGY: f64 = 300.0;
/// The run aims at this part of the tolerance: two runs of one motion, with other steps, differ by some such factor.
const AIM: f64 = 10.0;
/// Runs with a stop above this part of that of the coarser trial run are tried first.
const LUCKY: f64 = 0.25;
/// Runs with a finer stop than this may be off by rounding.
const ROUNDED: f64 = 1e-13;
/// Trial runs that are apart by this share of the mechanism's size have parted and say nothing about smaller errors.
const SATURATED: f64 = 1e-2;

/// Finest trial runs that have parted before so many of the instants at which they were compared are looked at more closely.
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
    /// Efforts from outside act, which what tells the accuracy does not feel.
    #[error("a program sets efforts on the joints, and the error estimate does not know its law")]
    Driven,
    /// A trial run failed, as the run will.
    #[error("a trial run failed: {0}")]
    TrialFailed(StepError),
}

/// What the trial runs found, or the run itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibration {
    /// The iteration stop to run with.
    pub stop: f64,
    /// The number of stages it is for.
    pub stages: StageChoice,
    /// The error to expect at the end of the worst step of the run (m).
    pub estimate: f64,
    /// The last instant up to which the wanted accuracy is expected to hold (s); the end of the run if it is reached.
    pub holds_until: f64,
    /// Whether the finest trial runs part before the end, so that nothing finer would help.
    pub parted: bool,
    /// Where the accuracy does not hold to the end, the first instant (s) from which the finest trial runs meet other events: impacts, sticking, bounds of motors.
    pub events_differ: Option<f64>,
    /// Number of trial runs: none where the run itself has told its accuracy.
    pub pilots: usize,
    /// How often the run has begun.
    pub begun: usize,
}

impl Calibration {
    /// The integrator that was calibrated, for the same smooth mechanism and tolerance (m).
    pub fn integrator(&self, mechanism: &Mechanism, tolerance: f64) -> Lobatto {
        Lobatto::adaptive_with_stages(mechanism, tolerance, self.stop, self.stages)
    }

    /// The integrator of a run that was calibrated, for the same mechanism, tolerance (m) and rules.
    ///
    /// # Errors
    /// [`MethodError`]: none of what was calibrated.
    pub(crate) fn run_integrator(
        &self,
        mechanism: &Mechanism,
        tolerance: f64,
        kept: &[Rule],
    ) -> Result<RunIntegrator, MethodError> {
        RunIntegrator::new(mechanism, Steps::Chosen { tolerance, stop: self.stop, stages: self.stages }, kept)
    }
}

/// Finds the iteration stop with which a run of `duration` from `state` is accurate to `tolerance` (m), with these rules switched off.
///
/// # Errors
/// [`CalibrationError`] if a trial run fails or `go_on`, which sees the time and the outcome of every step of the trial runs, says no.
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

/// The same where the closures were counted already.
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

    // Errors below rounding cannot be seen and need not be.
    let mut amplification = coarse.worst().max(1e-16 * size) / coarse.stop;
    let mut apart: Vec<f64> = coarse.apart.iter().map(|apart| apart / coarse.stop).collect();
    let tried = search.stop_for(amplification);
    if !parted && tried > LUCKY * coarse.stop && tried != coarse.stop {
        let trial = search.trial(tried, &fine, go_on);
        let found = match &trial {
            Ok(trial) => trial.worst() / tried,
            // What fails so coarsely may do as the coarser trial run did.
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
        // With the stop of the finer trial run it is the same run, and shows nothing.
        let seen = if trial.worst() > 0.0 { &trial } else { &coarse };
        worst = worst.max(seen.worst());
        for (error, &seen) in errors.iter_mut().zip(&seen.apart) {
            *error = error.max(seen);
        }
    }
    let held = errors.iter().take_while(|&&error| error <= tolerance).count();
    let holds_until = if held == 0 { state.time } else { coarse.trail[held - 1].0 };
    // Where other events change next to nothing they are none of the user's business.
    let compared = if errors.len() > held { coarse.trail.get(coarse.apart.len() - 1) } else { None };
    let differ = compared.and_then(|&(end, _)| {
        let until =
            |run: &TrialRun| -> Vec<Event> { run.events.iter().copied().filter(|event| event.time <= end).collect() };
        first_difference(&until(&coarse), &until(&fine))
    });
    Ok(Calibration {
        stop,
        stages: coarse.stages,
        // What has parted ends as far apart as the mechanism is large.
        // No position is known better than it is rounded.
        estimate: if parted { size } else { worst.max(f64::EPSILON * size) },
        holds_until: differ.map_or(holds_until, |differ| holds_until.min(differ)),
        events_differ: differ,
        parted,
        pilots: search.pilots,
        begun: 1,
    })
}

/// What is looked for, and by what.
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

/// The pair that tells how errors grow.
struct Couple<'s> {
    coarse: TrialRun<'s>,
    fine: TrialRun<'s>,
    /// Whether it has parted, though there is no finer one.
    parted: bool,
}

impl<'s> Search<'s> {
    /// A trial run at the start of the run.
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

    /// The stop of a run whose errors are amplified so much.
    fn stop_for(&self, amplification: f64) -> f64 {
        (self.tolerance / (AIM * amplification)).min(self.coarsest).clamp(FINEST, COARSEST_STOP)
    }

    /// The stop with which a pair that has parted would not have, if errors go on to grow as they did: exponentially, between the times
    /// up to which the pair `before` and this one have lasted, or, where there was none, from the start.
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
                // So coarse a trial run may fail where a finer one does not.
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
                    let stages = if stiff { StageChoice::Filling } else { wanted };
                    let goes_on = stop == fine.stop && stages == fine.stages;
                    coarse = if goes_on { fine } else { self.pilot(stop, stages)? };
                }
                Pair::HeldBack => {
                    stiff = true;
                    coarse = self.pilot(coarse.stop, StageChoice::Filling)?;
                }
            }
        }
    }

    /// The same pair up to where it was seen to have parted, compared at instants that are nearer to each other.
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

    /// A trial run with another stop than those of a pair, compared with the finer one.
    fn trial(&mut self, stop: f64, fine: &TrialRun, go_on: GoOn) -> Result<TrialRun<'s>, CalibrationError> {
        let mut trial = self.pilot(stop, fine.stages)?;
        trial.follow(fine, go_on)?;
        Ok(trial)
    }
}
