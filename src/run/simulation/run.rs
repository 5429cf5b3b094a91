//! A run: one object that the command line, tests and other programs use.
//!
//! ```text
//!     Mechanism (constant) ─┐
//!     State, Inputs ────────┼→ Simulation ──step_to──▶ islands, each with its steps ──▶ observers (log, progress bar)
//!     StepChoice ───────────┘                └─finish─▶ Finished: the state, the figures, how the steps were made
//! ```

use crate::lobatto::coupled::counted::Counted;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::description::rules::Rule;
use crate::mechanism::motion::inputs::{Feedback, Inputs};
use crate::mechanism::motion::state::State;
use crate::simulation::integrators::{Accuracies, Integrators, SimulationError, Wanted};
use crate::simulation::known_start::KnownStart;
use crate::simulation::method::held::{Held, Owner};
use crate::simulation::method::step_choice::StepChoice;
use crate::simulation::parallel::merged::MergedRun;
use crate::simulation::parallel::partition::Plan;
use crate::simulation::steps::clock::Clock;
use crate::simulation::steps::course::{Aim, Course, RunError, RunOptions};
use crate::simulation::steps::observer::Observer;
use crate::stepping::integrator::MethodError;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// How a run is to be made.
#[derive(Clone, Copy, Debug)]
pub struct SimulationOptions<'o> {
    /// Simulated time (s).
    pub duration: f64,
    /// How steps are chosen.
    pub steps: StepChoice,
    /// Simplification rules that are switched off.
    pub switched_off: &'o [Rule],
    /// Set from outside to end the run after its current step.
    pub interrupt: Option<&'o AtomicBool>,
    /// The ranks of the closures at the start, where they were counted already.
    #[doc(hidden)]
    pub counted: Option<&'o Arc<Counted>>,
    /// Whether a program makes the run step by step: without an estimate of its error, so that it costs what its steps cost. Each step keeps to its
    /// share of the tolerance.
    pub stepped: bool,
    /// Whether energies, constraint errors and times of steps are computed. The steps are the same without. Unconnected parts have their figures all
    /// the same.
    pub figures: bool,
}

impl SimulationOptions<'_> {
    /// A run of so many seconds with these steps, all rules, an estimate of its error where there is a tolerance, and figures.
    pub fn new(duration: f64, steps: StepChoice) -> Self {
        SimulationOptions {
            duration,
            steps,
            switched_off: &[],
            interrupt: None,
            counted: None,
            stepped: false,
            figures: true,
        }
    }
}

/// A run: a mechanism, its state, the efforts from outside, the integrators of its islands, the accuracy to expect, and its observers.
///
/// ```
/// use catena::mechanism::description::joint::{Joint, JointKind, Pose};
/// use catena::mechanism::description::mechanism::{Body, Mechanism};
/// use catena::mechanism::motion::state::State;
/// use catena::simulation::{Simulation, SimulationOptions, StepChoice};
/// use nalgebra::Vector3;
///
/// // A trolley of 2 kg on a rail, pushed with 3 N for one second.
/// let joint = Joint::new("rail", JointKind::Prismatic, Pose::identity(), Pose::identity());
/// let body = Body { name: "trolley".into(), parent: None, mass: 2.0, inertia: Vector3::repeat(0.1), joint };
/// let mechanism = Mechanism::new("rail", Vector3::zeros(), vec![body])?;
/// let options = SimulationOptions::new(2.0, StepChoice::Tolerance(1e-9));
/// let mut simulation = Simulation::new(&mechanism, State::zero(&mechanism), options)?;
/// simulation.set_efforts(&[3.0])?;
/// simulation.step_to(1.0)?;
/// simulation.set_efforts(&[0.0])?;
/// simulation.step_to(2.0)?;
/// assert!((simulation.state().velocity[0] - 1.5).abs() < 1e-12);
/// assert!((simulation.state().position[0] - 2.25).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Simulation<'s> {
    pub(super) mechanism: Held<'s, Mechanism>,
    pub(super) state: State,
    /// The state at the beginning of the run, if it may restart.
    pub(super) start: Option<State>,
    /// CPU time of discarded parts of the run (s).
    pub(super) spent: f64,
    pub(super) efforts: Vec<f64>,
    pub(super) integrators: Integrators<'s>,
    pub(super) choice: StepChoice,
    /// Why the accuracy is not known before the first step: one entry per integrator.
    pub(super) unknown: Accuracies,
    /// Islands, and how many of them sleep, before small ones were put together.
    pub(super) parts: (usize, usize),
    /// Simulated time (s), and samples per simulated second.
    pub(super) duration: f64,
    rate: Option<f64>,
    /// Set from outside to end the run after its current step.
    interrupt: Option<Held<'s, AtomicBool>>,
    /// Rules that leave nothing out.
    pub(super) switched_off: Vec<Rule>,
    pub(super) end: f64,
    observers: Vec<&'s mut dyn Observer>,
    /// Whether figures are wanted.
    figures: bool,
    /// Whether the CPU time of steps is counted for many calls together.
    together: bool,
    pub(super) progress: Option<Progress>,
    /// The start of the run before, which may be the start of the next one.
    pub(super) known_start: KnownStart,
}

impl Simulation<'static> {
    /// The same of a mechanism that the run holds a share of, so that it borrows nothing; `interrupt` replaces the flag of the options.
    ///
    /// # Errors
    /// As of [`Simulation::new`].
    pub(crate) fn owning(
        mechanism: Owner<Mechanism>,
        state: State,
        options: SimulationOptions,
        interrupt: Arc<AtomicBool>,
    ) -> Result<Self, SimulationError> {
        Self::of(Held::Shared(mechanism), state, options, Some(Held::Shared(interrupt)))
    }
}

/// How far a run has come.
pub(super) enum Progress {
    Whole(Box<Course>),
    Islands(Box<MergedRun>),
}

impl<'s> Simulation<'s> {
    /// Sets up a run from a state, whose loops are closed. One with a tolerance estimates its accuracy as it goes along, from the first step on:
    /// [`Simulation::run`] restarts it with finer steps if the accuracy falls short, and observers are told ([`Observer::begin_again`]). Under efforts
    /// from outside, and up to a time of [`Simulation::step_to`], it goes on without a restart, and the accuracy may fall short.
    ///
    /// # Errors
    /// [`SimulationError`] for stages and steps that cannot be.
    pub fn new(
        mechanism: &'s Mechanism,
        state: State,
        options: SimulationOptions<'s>,
    ) -> Result<Self, SimulationError> {
        Self::of(Held::Lent(mechanism), state, options, options.interrupt.map(Held::Lent))
    }

    fn of(
        mechanism: Held<'s, Mechanism>,
        state: State,
        options: SimulationOptions,
        interrupt: Option<Held<'s, AtomicBool>>,
    ) -> Result<Self, SimulationError> {
        let SimulationOptions { duration, steps, switched_off, counted, stepped, figures, .. } = options;
        let plan = Plan::from_counted(&mechanism, &state, switched_off, counted);
        let parts = (plan.islands.len(), plan.sleeping());
        let start = (!stepped && steps.tolerance().is_some()).then(|| state.clone());
        let wanted =
            Wanted { choice: steps, duration, interrupt: interrupt.clone(), counted: counted.cloned(), stepped };
        let (integrators, unknown) = Integrators::new(&mechanism, &state, plan, &wanted)?;
        Ok(Simulation {
            mechanism,
            end: state.time + duration,
            state,
            start,
            spent: 0.0,
            efforts: Vec::new(),
            integrators,
            choice: steps,
            unknown,
            parts,
            duration,
            rate: None,
            interrupt,
            switched_off: switched_off.to_vec(),
            observers: Vec::new(),
            figures,
            together: false,
            progress: None,
            known_start: KnownStart::default(),
        })
    }

    /// Adds an observer, from the next step on.
    pub fn observe(&mut self, observer: &'s mut dyn Observer) {
        self.observers.push(observer);
    }

    /// Sets the samples that observers see per simulated second; without this they see only the first and the last instant. Call it before the first
    /// step.
    pub fn sample_at(&mut self, rate: f64) {
        self.rate = Some(rate);
    }

    /// Makes steps until `time` (s), exactly; not beyond the end of the run.
    ///
    /// # Errors
    /// [`RunError`]: a step fails, an observer fails, or the run is interrupted.
    pub fn step_to(&mut self, time: f64) -> Result<(), RunError> {
        self.observed(|run, observers| run.step_before(time, observers))
    }

    /// The same before observers that the run does not hold.
    pub(crate) fn step_before(&mut self, time: f64, observers: &mut [&mut dyn Observer]) -> Result<(), RunError> {
        self.settle();
        self.proceed(time, None, observers)
    }

    /// Makes steps to the end of the run.
    ///
    /// # Errors
    /// [`RunError`]: a step fails, an observer fails, or the run is interrupted.
    pub fn run(&mut self) -> Result<(), RunError> {
        self.observed(|run, observers| run.run_before(observers))
    }

    /// The same before observers that the run does not hold.
    pub(crate) fn run_before(&mut self, observers: &mut [&mut dyn Observer]) -> Result<(), RunError> {
        if !self.efforts.is_empty() || self.progress.is_some() {
            self.settle();
        }
        loop {
            match self.proceed(f64::INFINITY, None, observers) {
                Err(RunError::BeginsAgain { .. }) => self.begin_again(observers)?,
                ended => return ended,
            }
        }
    }

    /// Decisions of a program in the meantime cannot be repeated.
    pub(super) fn settle(&mut self) {
        if self.start.take().is_some() {
            if self.progress.is_none() {
                self.integrators.join_groups(&self.mechanism);
            }
            self.integrators.settle(&self.mechanism, &self.state);
        }
    }

    /// Goes back to the start, with finer steps where they were too coarse.
    fn begin_again(&mut self, observers: &mut [&mut dyn Observer]) -> Result<(), RunError> {
        let Some(start) = &self.start else { return Ok(()) };
        self.spent = self.summary().solve_cpu_seconds;
        self.state.copy_from(start);
        self.progress = None;
        self.integrators.begin_again(&self.mechanism, &self.state).map_err(|error| RunError::Observer(error.into()))?;
        let method = self.description();
        observers.iter_mut().try_for_each(|observer| observer.begin_again(&method)).map_err(RunError::Observer)
    }

    /// Makes the steps of all islands together from now on; `false` if they have begun apart.
    ///
    /// # Errors
    /// [`MethodError`]: steps that the whole does not know.
    pub(crate) fn join_islands(&mut self) -> Result<bool, MethodError> {
        if matches!(self.integrators, Integrators::Islands { .. }) {
            if self.progress.is_some() {
                return Ok(false);
            }
            self.integrators = Integrators::Whole(self.choice.integrator(&self.mechanism, &[])?.into());
        }
        Ok(true)
    }

    /// Makes steps to the end of the run under efforts that follow the state.
    pub(crate) fn run_with_feedback(&mut self, feedback: &dyn Feedback) -> Result<(), RunError> {
        self.settle();
        self.observed(|run, observers| run.proceed(f64::INFINITY, Some(feedback), observers))
    }

    /// Does work before the observers that the run holds.
    fn observed<R>(&mut self, work: impl FnOnce(&mut Self, &mut [&mut dyn Observer]) -> R) -> R {
        let mut observers = std::mem::take(&mut self.observers);
        let done = work(self, &mut observers);
        self.observers = observers;
        done
    }

    /// Does work that makes many short calls of [`Simulation::step_to`], whose CPU time is asked for once.
    pub(crate) fn together<R>(&mut self, work: impl FnOnce(&mut Self) -> R) -> R {
        let clock = Clock::start();
        self.together = true;
        let done = work(self);
        self.together = false;
        if let Some(Progress::Whole(course)) = &mut self.progress {
            course.count_time(&clock);
        }
        done
    }

    fn proceed(
        &mut self,
        until: f64,
        feedback: Option<&dyn Feedback>,
        watching: &mut [&mut dyn Observer],
    ) -> Result<(), RunError> {
        let Simulation {
            mechanism,
            state,
            efforts,
            integrators,
            duration,
            rate,
            interrupt,
            figures,
            together,
            progress,
            choice,
            known_start,
            ..
        } = self;
        let inputs = Inputs { feedback, ..Inputs::constant(efforts) };
        let mechanism: &Mechanism = mechanism;
        let options = &RunOptions { duration: *duration, rate: *rate, interrupt: interrupt.as_deref() };
        match integrators {
            Integrators::Whole(integrator) => {
                if progress.is_none() {
                    let course = Course::new(mechanism, state, options.duration, options.rate);
                    let mut course = if *figures { course } else { course.without_figures() };
                    course.begin(mechanism, watching)?;
                    *progress = Some(Progress::Whole(Box::new(course)));
                }
                let Some(Progress::Whole(course)) = progress else { return Ok(()) };
                known_start.begin(mechanism, inputs, state, integrator);
                let aim = Aim { horizon: f64::INFINITY, until };
                if *together {
                    return course.steps(mechanism, inputs, state, integrator, aim, options.interrupt, watching);
                }
                course.proceed(mechanism, inputs, state, integrator, aim, options.interrupt, watching)
            }
            Integrators::Islands { islands, .. } => {
                if progress.is_none() {
                    *progress = Some(Progress::Islands(Box::new(islands.begin(mechanism, state, options, watching)?)));
                }
                let Some(Progress::Islands(whole)) = progress else { return Ok(()) };
                let ended = islands
                    .wake(inputs, *choice, whole, options)
                    .and_then(|()| islands.proceed(mechanism, until, options, watching, whole));
                islands.settle(mechanism, state, whole, ended.is_ok());
                ended
            }
        }
    }
}
