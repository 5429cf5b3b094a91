//! The steps of a walk: begun where the run began them, solved, and carried over.
//!
//! ```text
//!     start, stages of the run ─▶ solved to rounding with the factors of R_u ─▶ ∂q̄/∂θ, ∂v̄/∂θ
//! ```
//!
//! Between events that follow each other at once a step is so short that its stages are hardly ahead of a straight line. Their differences have
//! roundings of places times the weights of the scheme over h: of seven stages 4e-13 m/h, of two 4e-16 m/h. The order of such a step is of no account,
//! so it is made with two. Its end moves with its length at the velocities and accelerations there.

use crate::derivatives::equations::closed::ClosedContacts;
use crate::derivatives::events::efforts::Efforts;
use crate::derivatives::events::walk::{Subject, Walk, fastest};
use crate::derivatives::forward::failure::SensitivityError;
use crate::derivatives::forward::step::{Part, SolvedStep, StepMode, StepProblem};
use crate::derivatives::forward::tangent::InputSlopes;
use crate::events::trace::TracedStep;
use crate::lobatto::tableau::butcher::Tableau;
use nalgebra::DVector;

/// Solved steps end this close to the steps of the run (rad or m, per s, and s): roundings of both, and where an event is found.
const SAME: f64 = 1e-11;
/// Solved steps that end this far from the steps of the run have drifted away from them.
const DRIFTED: f64 = 1e-9;

/// Steps of the run that are shorter have two stages here (s): their truncation is h³ of an acceleration's change, below 1e-9 of most.
const BRIEF: f64 = 1e-6;

impl<'w> Walk<'w> {
    /// The tableau with this number of stages.
    pub(super) fn tableau(&self, stages: usize) -> &'w Tableau {
        let Subject { tableau, brief, .. } = *self.subject;
        if stages == brief.stages { brief } else { tableau }
    }

    /// Whether a step of the run is brief, and no slip in it is slow: that turns as fast as a step is short.
    pub(super) fn is_brief(&self, traced: &TracedStep) -> bool {
        let slides = traced.mode.contacts.iter().any(|closed| closed.slides.is_some());
        !slides && traced.end.time - traced.start.time < BRIEF
    }

    /// The tableau for a step of the run.
    fn tableau_for(&self, traced: &TracedStep) -> &'w Tableau {
        let Subject { tableau, brief, .. } = *self.subject;
        if self.is_brief(traced) { brief } else { tableau }
    }

    /// Goes to the start of a step of a run, if roundings lie between, or if both have drifted apart: motions that amplify errors would part for
    /// good. Stops the joints that are held. The stages of the run are solved then.
    pub(super) fn begin(&mut self, traced: &TracedStep) {
        let (own, start) = (&self.state, &traced.start);
        let apart = |one: &[f64], other: &[f64]| {
            let each = one.iter().zip(other).map(|(one, other)| (one - other).abs() / other.abs().max(1.0));
            each.fold(0.0, f64::max)
        };
        let places = apart(&own.position, &start.position);
        let apart = places.max(apart(&own.velocity, &start.velocity)).max(apart(&[own.time], &[start.time]));
        if apart <= SAME || apart > DRIFTED {
            self.state = start.clone();
        }
        self.drift = self.drift.max(places);
        for (body, _) in self.subject.mechanism.bodies.iter().zip(&traced.held).filter(|(_, held)| **held) {
            body.joint.velocity_range().for_each(|freedom| self.state.velocity[freedom] = 0.0);
        }
    }

    /// The efforts at all stages of a step of some length (s).
    pub(super) fn efforts_over(&self, traced: &TracedStep, step: f64) -> Vec<Efforts> {
        let since = self.state.time;
        let times: Vec<f64> = self.tableau_for(traced).nodes.iter().map(|node| since + step * node).collect();
        self.efforts_at(&traced.mode, since, &times)
    }

    /// A step of some length (s), solved, and its efforts at all stages; `known` is the same with another length, and the part of it that differs.
    pub(super) fn solved(
        &self,
        traced: &TracedStep,
        mode: &StepMode,
        step: f64,
        known: Option<(SolvedStep, f64)>,
    ) -> Result<(SolvedStep, Vec<Efforts>), SensitivityError> {
        let efforts = self.efforts_over(traced, step);
        let values: Vec<DVector<f64>> = efforts.iter().map(|efforts| efforts.values.clone()).collect();
        let (begun, toward, inside) = (&traced.start, &traced.end, &traced.inside[..]);
        let problem = StepProblem { begun, toward, inside, ..self.problem(mode, step, &values) };
        let solved = problem.solve(known).ok_or_else(|| self.failed())?;
        Ok((solved, efforts))
    }

    pub(super) fn problem<'p>(&'p self, mode: &'p StepMode, step: f64, efforts: &'p [DVector<f64>]) -> StepProblem<'p> {
        StepProblem {
            mechanism: self.subject.mechanism,
            figures: &self.figures,
            constant: &self.constant,
            tableau: self.tableau(efforts.len()),
            mode,
            start: &self.state,
            step,
            begun: &self.state,
            toward: &self.state,
            inside: &[],
            efforts,
        }
    }

    /// Carries the derivatives over a solved step.
    pub(super) fn carry(
        &mut self,
        mode: &StepMode,
        step: f64,
        solved: &SolvedStep,
        efforts: Vec<Efforts>,
        closed: &[ClosedContacts<Part>],
        longer: &DVector<f64>,
    ) -> Result<(), SensitivityError> {
        let (mut values, mut slopes, mut rates) = (Vec::new(), Vec::new(), Vec::new());
        for Efforts { values: own, slopes: by_parameters, rates: by_time } in efforts {
            values.push(own);
            slopes.push(by_parameters);
            rates.push(by_time);
        }
        let inputs = InputSlopes { efforts: &slopes, rates: &rates, closed };
        let mut tangent = self.tangent.clone();
        let problem = self.problem(mode, step, &values);
        tangent.carry(&problem, solved, &self.varied, &inputs, longer).ok_or_else(|| self.failed())?;
        self.tangent = tangent;
        Ok(())
    }

    /// Goes to the end of a solved step.
    pub(super) fn take_end(&mut self, solved: &SolvedStep, time: f64) {
        if let Some(end) = solved.stages.last() {
            self.state = end.clone();
        }
        self.state.time = time;
        self.fastest = self.fastest.max(fastest(&self.state.velocity));
    }
}
