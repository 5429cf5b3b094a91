//! A run of any of the methods, one step at a time, with names for the ways in which it can fail.

use crate::chart::{Method as ChartMethod, Setting};
use crate::instant::start::assembly::{AssemblyError, assemble};
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::description::rules::Rule;
use crate::mechanism::forces::total::Exchange;
use crate::mechanism::motion::energy::energy_with_forces;
use crate::mechanism::motion::integrator::{Integrator, StepError};
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use crate::output::report::{AccuracyReport, energy_warning};
use crate::simulation::method::run_integrator::RunIntegrator;
use crate::simulation::{
    Accuracy, Observer, ObserverError, RunError, Sample, Simulation, SimulationOptions, StepChoice, StepEnd,
};
use crate::stepping::recipe::Steps;
use crate::stress::baumgarte::{Baumgarte, BaumgarteError};
use crate::stress::method::Method;
use crate::stress::problem::Case;
use std::sync::atomic::{AtomicBool, Ordering};

/// How a run failed.
#[derive(Clone, Debug, PartialEq)]
pub struct Failure {
    /// The kind of error.
    pub name: &'static str,
    /// When (s); where the run began if it never did.
    pub time: f64,
    /// The message for the user.
    pub message: String,
}

/// Why there is no run.
#[derive(Clone, Debug, PartialEq)]
pub enum Refused {
    /// The method does not know such a mechanism.
    NotApplicable(&'static str),
    /// The start was refused.
    Failed(Failure),
    /// The steps of a tolerance cost too much.
    TooSlow,
    /// The user asked to stop.
    Interrupted,
}

/// A method at work.
pub struct Runner<'m> {
    mechanism: &'m Mechanism,
    work: Work<'m>,
    /// The time of a unit of the method's work, very roughly (s).
    unit: f64,
    /// The warning before the run.
    foretold: Option<String>,
}

/// Most cost of the run that finds the steps of a tolerance, restarts included, as a multiple of the budget of a run.
const SEARCH: f64 = 2.5;

enum Work<'m> {
    Joint { integrator: Box<dyn Integrator>, state: State, lost: Exchange },
    Maximal { integrator: Box<Baumgarte<'m>>, position: Vec<f64> },
}

impl<'m> Runner<'m> {
    /// Sets up a method; ours close all loops first, and find the steps of a tolerance, as `catena simulate` does.
    ///
    /// # Errors
    /// [`Refused`].
    pub fn new(case: &'m Case, method: Method, setting: Setting, interrupt: &AtomicBool) -> Result<Self, Refused> {
        let mut runner = Self::with_first_steps(&case.mechanism, &case.start, method, setting)?;
        if let (
            Method::Chart(ChartMethod::LobattoTolerance),
            Setting::Tolerance(tolerance),
            Work::Joint { integrator, state, .. },
        ) = (method, setting, &mut runner.work)
            && let Some(found) = accuracy(case, state, tolerance, runner.unit, interrupt)?
        {
            let steps = Steps::Chosen { tolerance, stop: found.stop, stages: found.stages };
            if let Ok(own) = RunIntegrator::new(&case.mechanism, steps, &[]) {
                *integrator = own.into_integrator();
            }
            runner.foretold = AccuracyReport::new(tolerance, &found).warning();
        }
        Ok(runner)
    }

    /// Sets up a method with the steps that a run begins with.
    ///
    /// # Errors
    /// [`Refused`].
    pub fn with_first_steps(
        mechanism: &'m Mechanism,
        start: &State,
        method: Method,
        setting: Setting,
    ) -> Result<Self, Refused> {
        let bodies = mechanism.bodies.len() as f64;
        let smooth = mechanism.nonsmooth.is_empty();
        let method = match (method, setting) {
            (Method::Chart(method), _) if !method.knows(mechanism) => {
                return Err(Refused::NotApplicable("it knows no contacts between shapes"));
            }
            (Method::Chart(method), _) => method,
            (Method::Baumgarte, _) if !smooth => {
                return Err(Refused::NotApplicable("it knows neither limits nor friction nor motors"));
            }
            (Method::Baumgarte, Setting::Step(step)) => {
                let integrator = Baumgarte::new(mechanism, start, step).map_err(Refused::NotApplicable)?;
                let rows = integrator.rows() as f64;
                let unit = 4.0 * (2e-6 * bodies + 1e-9 * rows * rows * (rows + 6.0 * bodies));
                let work = Work::Maximal { integrator: Box::new(integrator), position: start.position.clone() };
                return Ok(Runner { mechanism, work, unit, foretold: None });
            }
            (Method::Baumgarte, Setting::Tolerance(_)) => {
                return Err(Refused::NotApplicable("it has fixed steps only"));
            }
        };
        if !method.is_ours() && mechanism.has_closures() {
            return Err(Refused::NotApplicable("joint coordinates of a tree know no closed loops"));
        }
        let mut state = start.clone();
        assemble(mechanism, &mut state)
            .map_err(|error| Refused::Failed(Failure { time: start.time, ..Failure::of_start(&error) }))?;
        let Some(integrator) = method.integrator(mechanism, &state, setting) else {
            return Err(Refused::NotApplicable("the method does not know such a setting"));
        };
        // The unit is an iteration or evaluation. Forces or loops couple the stages, which costs ten times as much.
        let equations: usize = mechanism.loops.iter().map(|joint| joint.kind.rows()).sum();
        let coupled = method.is_ours() && !mechanism.is_plain_tree();
        let unit = 1e-6 + if coupled { 4e-6 * (bodies + equations as f64) } else { 2.5e-7 * bodies };
        let work = Work::Joint { integrator, state, lost: Exchange::default() };
        Ok(Runner { mechanism, work, unit, foretold: None })
    }

    /// One step towards `until` (s); returns a rough measure of its work (s), the same on every machine.
    ///
    /// # Errors
    /// [`Failure`].
    pub fn advance(&mut self, until: f64) -> Result<f64, Failure> {
        match &mut self.work {
            Work::Joint { integrator, state, lost } => {
                let outcome = integrator.advance(self.mechanism, state, until).map_err(|error| Failure::of(&error))?;
                *lost += outcome.exchange;
                Ok(self.unit * outcome.cost.iterations.max(1) as f64)
            }
            Work::Maximal { integrator, .. } => {
                integrator.advance(until).map_err(|error| Failure::of_textbook(&error))?;
                Ok(self.unit)
            }
        }
    }

    /// The time reached (s).
    pub fn time(&self) -> f64 {
        match &self.work {
            Work::Joint { state, .. } => state.time,
            Work::Maximal { integrator, .. } => integrator.time(),
        }
    }

    /// The bodies there.
    pub fn bodies(&self) -> Vec<BodyState> {
        match &self.work {
            Work::Joint { state, .. } => body_states(self.mechanism, state),
            Work::Maximal { integrator, .. } => integrator.bodies(),
        }
    }

    /// Kinetic energy, and what should be constant: all energy with what went out and without what came in (J).
    pub fn energy(&self) -> (f64, f64) {
        let (position, lost) = match &self.work {
            Work::Joint { state, lost, .. } => (&state.position, *lost),
            Work::Maximal { integrator, position } => (position, integrator.exchange()),
        };
        let energy = energy_with_forces(self.mechanism, position, &self.bodies());
        (energy.kinetic, energy.total() + lost.lost())
    }

    /// The warning that a user would get.
    pub fn warning(&self) -> Option<String> {
        let Work::Joint { integrator, .. } = &self.work else { return None };
        let unstable = integrator.description().frequency_step.filter(|seen| seen.is_unstable()).map(|seen| {
            let (product, limit, time) = (seen.product, seen.limit, seen.time);
            format!("unstable: step times frequency {product:.1} at t = {time} s, limit {limit:.2}")
        });
        unstable.or_else(|| self.foretold.clone())
    }

    /// The warning of our method for an energy error relative to the largest kinetic energy.
    pub fn energy_warning(&self, relative_error: f64) -> Option<String> {
        let Work::Joint { integrator, .. } = &self.work else { return None };
        let description = integrator.description();
        (description.name == "lobatto").then(|| energy_warning(&description, relative_error)).flatten()
    }
}

/// Ends a run that costs too much.
struct Watch<'w> {
    /// The time of an iteration, and what is left for them, very roughly (s).
    unit: f64,
    left: f64,
    /// Set by the user.
    interrupt: &'w AtomicBool,
    /// Ends the run.
    ends: &'w AtomicBool,
}

impl Observer for Watch<'_> {
    fn sample(&mut self, _: &Sample) -> Result<(), ObserverError> {
        Ok(())
    }

    fn step(&mut self, end: &StepEnd) {
        self.left -= self.unit * end.outcome.cost.iterations.max(1) as f64;
        if self.left < 0.0 || self.interrupt.load(Ordering::Relaxed) {
            self.ends.store(true, Ordering::Relaxed);
        }
    }
}

/// The accuracy of a run of a case from a state with this tolerance (m), restarts included; `None` if it fails, and so will the run.
fn accuracy(
    case: &Case,
    state: &State,
    tolerance: f64,
    unit: f64,
    interrupt: &AtomicBool,
) -> Result<Option<Accuracy>, Refused> {
    let ends = AtomicBool::new(false);
    let mut watch = Watch { unit, left: SEARCH * case.budget, interrupt, ends: &ends };
    let options = SimulationOptions {
        switched_off: &[Rule::Islands, Rule::Sleep],
        interrupt: Some(&ends),
        ..SimulationOptions::new(case.duration, StepChoice::Tolerance(tolerance))
    };
    let Ok(mut simulation) = Simulation::new(&case.mechanism, state.clone(), options) else { return Ok(None) };
    simulation.observe(&mut watch);
    match simulation.run() {
        Ok(()) => Ok(simulation.accuracies().into_iter().next().and_then(Result::ok)),
        Err(RunError::Interrupted { .. }) if interrupt.load(Ordering::Relaxed) => Err(Refused::Interrupted),
        Err(RunError::Interrupted { .. }) => Err(Refused::TooSlow),
        Err(_) => Ok(None),
    }
}

impl Failure {
    fn of(error: &StepError) -> Self {
        let (name, time) = match *error {
            StepError::NotConverged { time, .. } => ("NotConverged", time),
            StepError::Unstable { time, .. } => ("Unstable", time),
            StepError::TurnedTooFar { time, .. } => ("TurnedTooFar", time),
            StepError::NotAccurate { time, .. } => ("NotAccurate", time),
            StepError::NotFinite { time, .. } => ("NotFinite", time),
            StepError::OutsideLimit { time, .. } => ("OutsideLimit", time),
            StepError::NotPlain { time, .. } => ("NotPlain", time),
            StepError::Effort { time, .. } => ("Effort", time),
            StepError::Blocked { time, .. } => ("Blocked", time),
        };
        Failure { name, time, message: error.to_string() }
    }

    fn of_textbook(error: &BaumgarteError) -> Self {
        let (name, time) = match *error {
            BaumgarteError::Singular { time } => ("Singular", time),
            BaumgarteError::NotFinite { time, .. } => ("NotFinite", time),
        };
        Failure { name, time, message: error.to_string() }
    }

    fn of_start(error: &AssemblyError) -> Self {
        let name = match error {
            AssemblyError::Open { .. } => "Open",
            AssemblyError::Undecided { .. } => "Undecided",
            AssemblyError::Contradiction { .. } => "Contradiction",
            AssemblyError::Limited { .. } => "Limited",
            AssemblyError::Outside { .. } => "Outside",
            AssemblyError::Overlap { .. } => "Overlap",
        };
        Failure { name, time: 0.0, message: error.to_string() }
    }
}
