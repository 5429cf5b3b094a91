//! From a wanted accuracy to the local accuracy that gives it: pilot runs.
//!
//! An error made at a step is amplified by the motion until the end of the run, by 10² for a pendulum over seconds,
//! by 10⁶ for a falling arm, without bound for chaos. Two pilot runs, with iteration stops `ε` and `ε/30`, show it: where
//! they are `d` apart, the coarser is wrong by about `d`, and because errors are proportional to the stop, the stop that
//! keeps every error near a tenth of the wanted accuracy `E` is
//!
//! ```text
//!     ε_run = ε E / (10 max_t d(t))
//! ```
//!
//! with the distance of [`crate::distance`], seen at 32 instants. A coarse pilot may be right by luck, a hundred times nearer than its stop lets
//! expect in one of fifty runs of a chain of ten links. So where `ε_run` would be about as coarse as its stop, or coarser, a third pilot tries
//! it, and the finer one of the pair says how far off that is.
//!
//! Roundings do not fall with the stop. Where `ε_run` is near them, and the coarser pilot was further off than is wanted, one more pilot with
//! `ε_run` shows what they leave.
//!
//! Pilots that are apart by more than a hundredth of the mechanism's size have parted and say nothing; the next pair is 10⁴ times finer. If
//! the finest pair cannot hold the accuracy to the end, the calibration says until when it is held.
//!
//! Pilots have the number of stages of the run ([`crate::lobatto::stage_choice`]), later pairs that of a tolerance that would begin with them. A pair
//! with few stages whose first steps are limited by stability, and not by accuracy, begins again with more.

use crate::distance::{distance, probes, size};
use crate::lobatto::Lobatto;
use crate::lobatto::control::COARSEST_STOP;
use crate::lobatto::lanes::Isa;
use crate::lobatto::stage_choice::StageChoice;
use crate::model::{Mechanism, Rule};
use crate::simulation::{Integrator, StepError, StepOutcome};
use crate::state::State;
use nalgebra::Vector3;

/// Stop of the first pair over the tolerance.
const FIRST: f64 = 1e-3;
/// Instants at which two pilots are compared.
const INSTANTS: usize = 32;
/// Up to so many instants stability decides on the stages: what is stiff is so from the start, and to begin again later is dear.
const EARLY: usize = 2;
/// Ratio of the stops of the two pilots of a pair.
const RATIO: f64 = 30.0;
/// The finest stop: rounding.
const FINEST: f64 = 1e-16;
/// The coarsest stop of a first pair: what is coarser shows a motion that has little to do with the true one.
const COARSEST: f64 = 1e-3;
/// The run stops at no more than this part of the tolerance, however calm the motion: the energy has to be kept as well,
const CALM: f64 = 0.03;
/// and balanced where forces take part in it, which costs a digit.
const CALM_WITH_FORCES: f64 = 0.01;
/// The run aims at this part of the tolerance: two runs of one motion, with other steps, differ by some such factor.
const AIM: f64 = 10.0;
/// Runs with a stop above this part of that of the coarser pilot are tried first.
const LUCKY: f64 = 0.25;
/// Runs with a finer stop than this may be off by rounding.
const ROUNDED: f64 = 1e-13;
/// Ratio of the stops of successive pairs.
const REFINEMENT: f64 = 1e-4;
/// Pilots that are apart by this share of the mechanism's size have parted and say nothing about smaller errors.
const SATURATED: f64 = 1e-2;

/// What the pilot runs found.
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
    /// Whether the finest pilots part before the end, so that nothing finer would help.
    pub parted: bool,
    /// Number of pilot runs.
    pub pilots: usize,
}

/// Why there is no calibration.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CalibrationError {
    /// A pilot failed, and so will the run.
    #[error(transparent)]
    Step(#[from] StepError),
    /// The caller did not want to go on.
    #[error("interrupted during the pilot runs that calibrate the tolerance")]
    Interrupted,
}

impl Calibration {
    /// The integrator that was calibrated, for the same mechanism and tolerance (m).
    pub fn integrator(&self, mechanism: &Mechanism, tolerance: f64) -> Lobatto {
        Lobatto::adaptive_with_stages(mechanism, tolerance, self.stop, self.stages)
    }
}

/// Finds the iteration stop with which a run of `duration` from `state` is accurate to `tolerance` (m), with these rules switched off.
///
/// # Errors
/// [`CalibrationError`] if a pilot fails or `go_on`, which sees every step of the pilots, says no.
pub fn calibrate(
    mechanism: &Mechanism,
    state: &State,
    duration: f64,
    tolerance: f64,
    kept: &[Rule],
    go_on: &mut dyn FnMut(&StepOutcome) -> bool,
) -> Result<Calibration, CalibrationError> {
    let size = size(mechanism, state);
    let end = state.time + duration;
    // The last is the end itself, to the bit.
    let instant = |index: usize| match index {
        INSTANTS => end,
        _ => state.time + duration * index as f64 / INSTANTS as f64,
    };
    let mut stop = (FIRST * tolerance).clamp(FINEST * RATIO, COARSEST);
    let (mut accuracy, mut stiff) = (tolerance, false);
    let count = |stages: StageChoice| stages.count(Isa::detect());
    let mut pilots = 0;
    loop {
        let stages = if stiff { StageChoice::Filling } else { StageChoice::of(mechanism, accuracy) };
        let pilot = |stop| Pilot {
            mechanism,
            lobatto: Lobatto::adaptive_with_stages(mechanism, tolerance, stop, stages).keeping(mechanism, kept),
            state: state.clone(),
            apart: Vec::with_capacity(INSTANTS),
        };
        let (mut coarse, mut fine) = (pilot(stop), pilot(stop / RATIO));
        pilots += 2;
        let mut truth = Vec::with_capacity(INSTANTS);
        // Pilots that have parted need no following.
        let mut held_back = false;
        while truth.len() < INSTANTS && coarse.worst() <= SATURATED * size && !held_back {
            let until = instant(truth.len() + 1);
            truth.push((until, fine.advance(until, go_on)?));
            coarse.follow(&truth[truth.len() - 1..], go_on)?;
            held_back = truth.len() <= EARLY
                && count(stages) < count(StageChoice::Filling)
                && coarse.lobatto.was_held_by_stability();
        }
        if held_back {
            stiff = true;
            continue;
        }
        let saturated = coarse.worst() > SATURATED * size;
        if saturated && stop > FINEST * RATIO * (1.0 + 1e-9) {
            stop = (stop * REFINEMENT).max(FINEST * RATIO);
            accuracy = stop / FIRST;
            continue;
        }
        // Errors below rounding cannot be seen and need not be.
        let mut amplification = coarse.worst().max(1e-16 * size) / stop;
        let calm = if mechanism.is_plain_tree() { CALM } else { CALM_WITH_FORCES };
        let stop_for =
            |amplification: f64| (tolerance / (AIM * amplification)).min(calm * tolerance).clamp(FINEST, COARSEST_STOP);
        let mut apart: Vec<f64> = coarse.apart.iter().map(|apart| apart / stop).collect();
        let tried = stop_for(amplification);
        if !saturated && tried > LUCKY * stop {
            let mut trial = pilot(tried);
            pilots += 1;
            let found = match trial.follow(&truth, go_on) {
                Ok(()) => trial.worst() / tried,
                // What fails so coarsely may do as the coarser pilot did.
                Err(CalibrationError::Step(_)) => tolerance / (AIM * stop),
                Err(interrupted) => return Err(interrupted),
            };
            amplification = amplification.max(found);
            for (apart, tried_apart) in apart.iter_mut().zip(&trial.apart) {
                *apart = apart.max(tried_apart / tried);
            }
        }
        let run_stop = stop_for(amplification);
        let mut errors: Vec<f64> = apart.iter().map(|apart| apart * run_stop).collect();
        let mut worst = amplification * run_stop;
        if !saturated && run_stop < ROUNDED && coarse.worst() > tolerance {
            let mut trial = pilot(run_stop);
            pilots += 1;
            trial.follow(&truth, go_on)?;
            // With the stop of the finer pilot it is the same run, and shows nothing.
            let seen = if trial.worst() > 0.0 { &trial } else { &coarse };
            worst = worst.max(seen.worst());
            for (error, &seen) in errors.iter_mut().zip(&seen.apart) {
                *error = error.max(seen);
            }
        }
        let held = errors.iter().take_while(|&&error| error <= tolerance).count();
        return Ok(Calibration {
            stop: run_stop,
            stages,
            // What has parted ends as far apart as the mechanism is large.
            estimate: if saturated { size } else { worst },
            holds_until: instant(held),
            parted: saturated,
            pilots,
        });
    }
}

/// A run that is made only to be compared.
struct Pilot<'m> {
    mechanism: &'m Mechanism,
    lobatto: Lobatto,
    state: State,
    /// How far it is from another at every instant up to now, the worst so far: an error that has been made does not heal (m).
    apart: Vec<f64>,
}

impl Pilot<'_> {
    /// The furthest that it has been from another (m).
    fn worst(&self) -> f64 {
        self.apart.last().copied().unwrap_or(0.0)
    }

    /// Goes on to the next instants and sees how far it is from where another was there.
    fn follow(
        &mut self,
        other: &[(f64, Vec<Vector3<f64>>)],
        go_on: &mut dyn FnMut(&StepOutcome) -> bool,
    ) -> Result<(), CalibrationError> {
        for (until, probes) in other {
            let seen = distance(&self.advance(*until, go_on)?, probes);
            self.apart.push(if seen.is_nan() { f64::INFINITY } else { self.worst().max(seen) });
        }
        Ok(())
    }

    /// The probes at `until`, where a step ends, so that no interpolation error is taken for an error of the run.
    fn advance(
        &mut self,
        until: f64,
        go_on: &mut dyn FnMut(&StepOutcome) -> bool,
    ) -> Result<Vec<Vector3<f64>>, CalibrationError> {
        while self.state.time < until {
            let outcome = self.lobatto.advance(self.mechanism, &mut self.state, until)?;
            if !go_on(&outcome) {
                return Err(CalibrationError::Interrupted);
            }
        }
        Ok(probes(self.mechanism, &self.state))
    }
}
