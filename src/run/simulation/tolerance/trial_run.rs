//! Trial runs: made before a run only to be compared with each other, which shows how the motion amplifies errors.

use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::distance::{distance, probes};
use crate::mechanism::motion::event::Event;
use crate::mechanism::motion::integrator::{Integrator, StepError, StepOutcome};
use crate::mechanism::motion::state::State;
use crate::simulation::method::run_integrator::RunIntegrator;
use crate::stepping::integrator::MethodError;
use crate::stepping::length::stage_choice::StageChoice;
use nalgebra::Vector3;

/// Why there is no calibration.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CalibrationError {
    /// A trial run failed, and so will the run.
    #[error(transparent)]
    Step(#[from] StepError),
    /// The stages or the steps.
    #[error(transparent)]
    Method(#[from] MethodError),
    /// The caller did not want to go on.
    #[error("interrupted during the trial runs that calibrate the tolerance")]
    Interrupted,
}

/// Most instants at which two trial runs are compared, evenly spread.
const INSTANTS: f64 = 32.0;
/// Steps of the coarser run between two comparisons, if that is later: the finer run has to end a step there, too.
const STRIDE: usize = 4;
/// In this first part of the run stability decides on the stages: stiff parts are stiff from the start, and a later restart is expensive.
const EARLY: f64 = 1.0 / 16.0;

/// Decides after every step of a trial run whether to go on, from the time that the trial run has reached (s) and the step.
pub(crate) type GoOn<'g> = &'g mut dyn FnMut(f64, &StepOutcome) -> bool;

/// The course of trial runs.
#[derive(Clone, Copy)]
pub(crate) struct Course {
    /// When the run begins and ends (s).
    pub start: f64,
    pub end: f64,
    /// Trial runs that are further apart have parted (m).
    pub apart: f64,
}

/// How a pair of trial runs went.
pub(crate) enum Pair {
    /// To the end.
    Together,
    /// Until they had parted.
    Parted,
    /// Until stability, and not accuracy, was seen to limit the steps of few stages.
    HeldBack,
}

/// A run that is made only to be compared.
pub(crate) struct TrialRun<'m> {
    pub mechanism: &'m Mechanism,
    pub integrator: RunIntegrator,
    /// Its iteration stop and its stages.
    pub stop: f64,
    pub stages: StageChoice,
    pub state: State,
    /// Its probes at the instants up to now.
    pub trail: Vec<(f64, Vec<Vector3<f64>>)>,
    /// Whether stability, and not accuracy, has limited its steps early.
    pub held_back: bool,
    /// The events so far.
    pub events: Vec<Event>,
    /// How far it was from another at every instant, the worst so far: an error that has been made does not heal (m).
    pub apart: Vec<f64>,
}

impl TrialRun<'_> {
    /// The furthest that it has been from another (m).
    pub fn worst(&self) -> f64 {
        self.apart.last().copied().unwrap_or(0.0)
    }

    /// Goes on with a finer trial run by its side, from the start of both trails to the end of the run if they do not part.
    pub fn accompany(&mut self, finer: &mut Self, course: Course, go_on: GoOn) -> Result<Pair, CalibrationError> {
        let few = self.stages == StageChoice::Few;
        self.apart.clear();
        loop {
            if self.apart.len() == self.trail.len() {
                if self.state.time >= course.end {
                    return Ok(Pair::Together);
                }
                self.stride(course, go_on)?;
            }
            let index = self.apart.len();
            finer.advance(self.trail[index].0, go_on)?;
            self.compare(&finer.trail[index].1);
            if self.worst() > course.apart {
                return Ok(Pair::Parted);
            }
            if self.held_back && few {
                return Ok(Pair::HeldBack);
            }
        }
    }

    /// Goes to all instants of another and sees how far it is from where that was there.
    pub fn follow(&mut self, other: &TrialRun, go_on: GoOn) -> Result<(), CalibrationError> {
        for (time, there) in &other.trail {
            self.advance(*time, go_on)?;
            self.compare(there);
        }
        Ok(())
    }

    /// Sees how far it was from another at the first instant that has not been looked at.
    fn compare(&mut self, other: &[Vector3<f64>]) {
        let seen = distance(&self.trail[self.apart.len()].1, other);
        self.apart.push(if seen.is_nan() { f64::INFINITY } else { self.worst().max(seen) });
    }

    /// To an instant of its own choice, where a step ends.
    fn stride(&mut self, course: Course, go_on: GoOn) -> Result<(), CalibrationError> {
        let due = self.state.time + (course.end - course.start) / INSTANTS;
        let mut steps = 0;
        while self.state.time < course.end && (self.state.time < due || steps < STRIDE) {
            self.step(course.end, go_on)?;
            steps += 1;
            let early = self.state.time - course.start <= EARLY * (course.end - course.start);
            self.held_back |= early && self.integrator.was_held_by_stability();
        }
        self.trail.push((self.state.time, probes(self.mechanism, &self.state)));
        Ok(())
    }

    /// To an instant, where a step ends, so that no interpolation error is taken for an error of the run.
    fn advance(&mut self, until: f64, go_on: GoOn) -> Result<(), CalibrationError> {
        while self.state.time < until {
            self.step(until, go_on)?;
        }
        self.trail.push((until, probes(self.mechanism, &self.state)));
        Ok(())
    }

    fn step(&mut self, until: f64, go_on: GoOn) -> Result<(), CalibrationError> {
        let outcome = self.integrator.advance(self.mechanism, &mut self.state, until)?;
        self.integrator.take_events(&mut self.events);
        if go_on(self.state.time, &outcome) { Ok(()) } else { Err(CalibrationError::Interrupted) }
    }
}
