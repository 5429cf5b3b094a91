//! From a wanted accuracy to the local accuracy that gives it: pilot runs.
//!
//! An error made at a step is amplified by the motion until the end of the run, by 10² for a pendulum over seconds,
//! by 10⁶ for a falling arm, without bound for chaos. Two pilot runs, with iteration stops `ε` and `ε/30`, show it: where they
//! are `d` apart, the coarser is wrong by about `d`, and because errors are proportional to the stop (step-control.md,
//! section 4) the stop that keeps every error below a third of the wanted accuracy `E` is
//!
//! ```text
//!     ε_run = ε E / (3 max_t d(t))
//! ```
//!
//! with the distance of [`crate::distance`], seen at 32 instants. Pilots that are apart by more than a hundredth of the mechanism's size have saturated and
//! say nothing; the next pair is 10³ times finer. If the finest pair cannot hold the accuracy to the end, the
//! calibration says until when it is held.

use crate::distance::{distance, probes};
use crate::lobatto::Lobatto;
use crate::model::Mechanism;
use crate::simulation::{Integrator, StepError};
use crate::state::State;
use nalgebra::Vector3;
use std::sync::atomic::{AtomicBool, Ordering};

/// Instants at which two pilots are compared.
const INSTANTS: usize = 32;
/// Ratio of the stops of the two pilots of a pair.
const RATIO: f64 = 30.0;
/// The finest stop: rounding.
const FINEST: f64 = 1e-16;
/// The coarsest stop worth running.
const COARSEST: f64 = 1e-4;
/// Ratio of the stops of successive pairs.
const REFINEMENT: f64 = 1e-3;

/// What the pilot runs found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibration {
    /// The iteration stop to run with.
    pub stop: f64,
    /// The error to expect at the worst instant of the run [m].
    pub estimate: f64,
    /// The last instant up to which the wanted accuracy is expected to hold [s]; the end of the run if it is reached.
    pub holds_until: f64,
    /// Number of pilot runs.
    pub pilots: usize,
}

/// Why there is no calibration.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CalibrationError {
    /// A pilot failed, and so will the run.
    #[error(transparent)]
    Step(#[from] StepError),
    /// The interrupt flag was set.
    #[error("interrupted during the pilot runs that calibrate the tolerance")]
    Interrupted,
}

/// Finds the iteration stop with which a run of `duration` from `state` is accurate to `tolerance` [m].
///
/// # Errors
/// [`CalibrationError`] if a pilot fails or the flag is set.
pub fn calibrate(
    mechanism: &Mechanism,
    state: &State,
    duration: f64,
    tolerance: f64,
    interrupt: Option<&AtomicBool>,
) -> Result<Calibration, CalibrationError> {
    let run = |stop: f64| pilot(mechanism, state, duration, tolerance, stop, interrupt);
    let size = size(mechanism, state);
    let instant = |index: usize| state.time + duration * (index + 1) as f64 / INSTANTS as f64;
    let mut stop = (1e-3 * tolerance).clamp(FINEST * RATIO, COARSEST);
    let mut pilots = 0;
    loop {
        let (coarse, fine) = (run(stop)?, run(stop / RATIO)?);
        pilots += 2;
        let apart: Vec<f64> = coarse.iter().zip(&fine).map(|(coarse, fine)| distance(coarse, fine)).collect();
        // The worst so far at every instant: an error that has been made does not heal.
        let worst: Vec<f64> = apart
            .iter()
            .scan(0.0_f64, |worst, &apart| {
                *worst = if apart.is_nan() { f64::INFINITY } else { worst.max(apart) };
                Some(*worst)
            })
            .collect();
        let last = worst[INSTANTS - 1];
        let finest = stop <= FINEST * RATIO * (1.0 + 1e-9);
        if last > 1e-2 * size && !finest {
            stop = (stop * REFINEMENT).max(FINEST * RATIO);
            continue;
        }
        // Errors below rounding cannot be seen and need not be.
        let amplification = last.max(1e-16 * size) / stop;
        let wanted = tolerance / (3.0 * amplification);
        let run_stop = wanted.clamp(FINEST, COARSEST);
        let estimate = amplification * run_stop;
        let held = worst.iter().take_while(|&&apart| apart * run_stop / stop <= tolerance).count();
        let holds_until = if held == 0 { state.time } else { instant(held - 1) };
        return Ok(Calibration { stop: run_stop, estimate, holds_until, pilots });
    }
}

/// The probes of a pilot run at all instants.
fn pilot(
    mechanism: &Mechanism,
    start: &State,
    duration: f64,
    tolerance: f64,
    stop: f64,
    interrupt: Option<&AtomicBool>,
) -> Result<Vec<Vec<Vector3<f64>>>, CalibrationError> {
    let mut state = start.clone();
    let mut lobatto = Lobatto::adaptive_with_stop(mechanism, tolerance, stop);
    let mut seen = Vec::with_capacity(INSTANTS);
    for index in 1..=INSTANTS {
        // Every pilot ends a step at each instant, so that no interpolation error is taken for an error of the run.
        let until = start.time + duration * index as f64 / INSTANTS as f64;
        while state.time < until {
            if interrupt.is_some_and(|flag| flag.load(Ordering::Relaxed)) {
                return Err(CalibrationError::Interrupted);
            }
            lobatto.advance(mechanism, &mut state, until)?;
        }
        seen.push(probes(mechanism, &state));
    }
    Ok(seen)
}

/// The largest distance between any body's probe and the mean of all probes at the start, at least 1 mm [m].
fn size(mechanism: &Mechanism, state: &State) -> f64 {
    let probes = probes(mechanism, state);
    let mean: Vector3<f64> = probes.iter().sum::<Vector3<f64>>() / probes.len().max(1) as f64;
    probes.iter().map(|probe| (probe - mean).norm()).fold(1e-3, f64::max)
}
