//! Warnings in the log during a run, and the report at its end.
//!
//! ```text
//!     open ─▶ begun (sizes, accuracy) ─▶ log ─▶ the run ─▶ close: the log completed, the report
//! ```

use crate::instant::start::assembly::redundancy_counted;
use crate::lobatto::coupled::counted::Counted;
use crate::mechanism::motion::distance::{distance, probes};
use crate::mechanism::motion::integrator::MethodDescription;
use crate::mechanism::motion::state::State;
use crate::model::Model;
use crate::output::log::{Ending, LogError, LogOptions, Outcome, Recorder, Severity};
use crate::output::report::{
    AccuracyReport, ConstraintReport, ContactsReport, EnergyReport, EventReport, FarSpring, IslandReport, MethodReport,
    ModelReport, NoAccuracyReport, RejectedReport, Report, SpeedWatch, StepErrorReport, balance_warning,
    carried_reports, link_reports, ringing_warning, singular_warning, unsolved_warning,
};
use crate::session::asked::{DEFAULT_TOLERANCE, Settled};
use crate::session::between_ticks::between_ticks;
use crate::session::description::{Origin, WENT_ON, description, figures};
use crate::session::error::Error;
use crate::session::other_steps::Length;
use crate::session::recording::Recording;
use crate::session::special_output::open_special;
use crate::simulation::{Finished, RunError, Simulation};
use cpu_time::ProcessTime;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// A run and its warnings before the integrators are made.
pub(crate) struct Account {
    settled: Settled,
    /// The time at which the run begins (s).
    since: f64,
    clock: Instant,
    processor: ProcessTime,
    far: Option<FarSpring>,
    between: Vec<String>,
}

/// A run that has made its first step.
pub(crate) struct Begun {
    account: Account,
    course: Described,
    model: ModelReport,
    /// Warnings about accuracies that no step size can reach.
    warnings: Vec<String>,
    /// Warnings about efforts that are worked out anew at the start.
    between: Vec<String>,
}

/// What a log says of a run before its first step. It is put into words for logs alone.
#[derive(Clone, Debug)]
struct Described {
    settled: Settled,
    method: MethodDescription,
    /// Whether the run may restart with finer steps.
    may_restart: bool,
}

/// The report and the outcome of a finished run.
pub(crate) struct Closed {
    /// The report.
    pub report: Report,
    /// How the run ended, and whether its log was written.
    pub ended: Result<(), Error>,
    /// The entries of its log besides the samples.
    pub told: Told,
}

/// The entries of a run's log besides its samples.
#[derive(Clone, Debug)]
pub struct Told {
    course: Described,
    origin: Origin,
    before: Vec<String>,
    after: Vec<String>,
    /// The figures of the whole run.
    figures: BTreeMap<String, String>,
    /// The kind and the message of the failure that ended the run early, if any.
    failure: Option<(Outcome, String)>,
}

/// The results of a run.
pub(crate) struct Ended<'e> {
    /// The simulation.
    pub finished: Finished,
    /// The outcome of the run.
    pub ended: Result<(), Error>,
    /// The end of the same run in other steps, with their length, if it was made.
    pub checked: Option<&'e (State, Length)>,
    /// The observer of joint speeds.
    pub speeds: Option<&'e SpeedWatch>,
    /// The log.
    pub recorder: Option<Recorder>,
    /// The path of the log.
    pub output: Option<&'e Path>,
}

impl Account {
    /// Opens the account before the integrators are made.
    pub fn open(model: &Model, state: &State, settled: Settled) -> Self {
        let far = FarSpring::of(&model.mechanism, state);
        let between = between_ticks(&model.mechanism, state.time);
        Account { settled, since: state.time, clock: Instant::now(), processor: ProcessTime::now(), far, between }
    }

    /// Goes on before the first step; `counted` are the ranks of the closures at the start.
    pub fn begun(mut self, model: &Model, counted: Option<&Counted>, simulation: &Simulation) -> Begun {
        let redundancy = counted.map(|counted| redundancy_counted(&model.mechanism, counted)).unwrap_or_default();
        let tolerance = self.settled.choice.tolerance().unwrap_or(DEFAULT_TOLERANCE);
        let warnings = self.far.iter().filter_map(|far| far.warning(tolerance)).collect();
        let model = ModelReport::new(model, &redundancy, simulation.parts());
        let (method, may_restart) = (simulation.description(), simulation.tells_at_once());
        let course = Described { settled: self.settled, method, may_restart };
        let between = std::mem::take(&mut self.between);
        Begun { course, account: self, model, warnings, between }
    }
}

impl Described {
    fn in_words(&self, model: &Model, origin: &Origin) -> BTreeMap<String, String> {
        let Settled { duration, rate, choice } = self.settled;
        description(model, duration, rate, choice, self.method.clone(), origin)
    }
}

impl Begun {
    /// The run goes on from a state that knows the efforts of all motors.
    pub fn knows_efforts(&mut self) {
        self.between.clear();
    }

    /// Creates the log of the run, with the entries known before the first step. Stops waiting for a pipe once `interrupted` is set.
    ///
    /// # Errors
    /// [`Error::Log`] if it cannot be created; [`Error::Unread`] if the run is interrupted before a pipe has a reader.
    pub fn log(
        &self,
        path: &Path,
        model: &Model,
        origin: &Origin,
        options: &LogOptions,
        interrupted: &Arc<AtomicBool>,
    ) -> Result<Recorder, Error> {
        // Whoever holds a pipe has a reader, so that the log opens it again without waiting.
        let held = open_special(path, interrupted)?;
        let create = if self.course.may_restart { Recorder::create_for_restarts } else { Recorder::create };
        let mut recorder = create(path, model, self.course.in_words(model, origin), options)?;
        drop(held);
        recorder.heed(interrupted);
        let warnings = self.warnings.iter().chain(&self.between);
        warnings.for_each(|warning| recorder.say(Severity::Warning, warning));
        Ok(recorder)
    }

    /// Completes the log, however the run ended, and returns the outcome, the report and the warnings. `input` is the user's name of the model.
    pub fn close(self, model: &Model, input: String, origin: &Origin, run: Ended) -> Closed {
        let Begun { account, course, model: model_report, warnings: unreached, between } = self;
        let Ended { finished, ended, checked, speeds, recorder, output } = run;
        let Settled { duration, choice, .. } = account.settled;
        let mechanism = &model.mechanism;
        let (mut accuracy, no_accuracy) = match AccuracyReport::of(choice, &finished) {
            Ok(accuracy) => (Some(accuracy), None),
            Err(reason) => (None, Some(NoAccuracyReport::new(choice, &reason))),
        };
        let of_accuracy: Vec<String> = accuracy.as_ref().and_then(AccuracyReport::warning).into_iter().collect();
        if let (Some(accuracy), Some(far)) = (&mut accuracy, &account.far) {
            accuracy.see_rounding(far);
        }
        let (events, contact) = (EventReport::new(model, &finished), ContactsReport::new(model, &finished));
        let Finished { state, summary, method, islands, joints: statuses, .. } = finished;
        let step_error = choice.step().and_then(|_| match checked {
            Some((other, length)) => {
                let apart = distance(&probes(mechanism, &state), &probes(mechanism, other));
                Some(match length {
                    Length::Half => StepErrorReport::by_half_the_step(apart, method.order),
                    Length::Twice => StepErrorReport::by_twice_the_step(apart),
                })
            }
            None => StepErrorReport::by_energy(mechanism, &method, &summary, duration),
        });
        if let Some(accuracy) = &mut accuracy {
            accuracy.see_energy(&summary);
        }
        let of_method: Vec<String> = of_accuracy
            .into_iter()
            .chain(MethodReport::warning(&method))
            .chain(balance_warning(&method, &summary, account.far.as_ref()))
            .chain(step_error.and_then(|error| error.warning(&method)))
            .chain(accuracy.as_ref().and_then(AccuracyReport::energy_warning))
            .chain(ringing_warning(&method))
            .chain(singular_warning(&method))
            .chain(unsolved_warning(&method, duration, accuracy.as_ref().is_some_and(|accuracy| accuracy.reached)))
            .chain(contact.outside.clone())
            .chain(contact.overlapping.clone())
            .chain(speeds.iter().flat_map(|speeds| speeds.warning()))
            .collect();
        let estimated_error =
            accuracy.as_ref().map(|accuracy| accuracy.estimated).or(step_error.map(|error| error.estimated));
        let failure = ended.as_ref().err().map(|error| (outcome(error), error.to_string()));
        let (origin, before, after) = (origin.clone(), unreached.clone(), of_method.clone());
        let from_log = origin.from_log.clone();
        let figures = figures(&summary, &method, estimated_error, origin.from_log.as_ref());
        let told = Told { course, origin, before, after, figures: figures.clone(), failure };
        let (ended, log) = match (recorder, output) {
            (Some(mut recorder), Some(output)) => {
                of_method.iter().for_each(|warning| recorder.say(Severity::Warning, warning));
                complete(recorder, ended, figures, output)
            }
            _ => (ended, None),
        };
        let (wall_seconds, cpu_seconds) =
            (account.clock.elapsed().as_secs_f64(), account.processor.elapsed().as_secs_f64());
        let (joints, loops) = carried_reports(model, &state, &statuses);
        let report = Report {
            catena: env!("CARGO_PKG_VERSION"),
            input,
            scene: mechanism.name.clone(),
            start: account.since,
            // The time reached: less than was requested if the run ended early.
            duration: state.time,
            method: MethodReport::new(&method, state.time - account.since),
            model: model_report,
            steps: summary.steps,
            iterations: summary.cost.iterations,
            rejected_steps: summary.cost.rejected.total(),
            rejected: RejectedReport(summary.cost.rejected),
            located_attempts: summary.cost.located,
            kept_factor_iterations: summary.cost.kept,
            exact_newton_steps: summary.exact_steps,
            wall_seconds,
            cpu_seconds,
            solve_cpu_seconds: summary.solve_cpu_seconds,
            events,
            contact,
            energy: EnergyReport::new(&summary),
            constraint: ConstraintReport::new(&summary),
            links: link_reports(model, &state),
            joints,
            loops,
            islands: islands.iter().map(IslandReport::new).collect(),
            warnings: model.warning_lines().chain(unreached).chain(between).chain(of_method).collect(),
            accuracy,
            no_accuracy,
            step_error,
            from_log,
            log,
        };
        Closed { report, ended, told }
    }
}

impl Told {
    /// Who controlled the run, if its files alone do not say.
    pub fn driven(&self) -> Option<&str> {
        self.origin.driven.as_deref()
    }

    /// The program that decided on efforts, if there was one: reactions do not follow from the states of such a run.
    pub fn controlled(&self) -> Option<&str> {
        self.driven().filter(|by| *by != WENT_ON)
    }

    /// Writes the log of a recorded run: the same bytes as a log written during the run.
    ///
    /// # Errors
    /// [`Error::Log`] if it cannot be written.
    pub fn write(&self, path: &Path, model: &Model, recording: &Recording, options: &LogOptions) -> Result<(), Error> {
        let mut recorder = Recorder::create(path, model, self.course.in_words(model, &self.origin), options)?;
        self.before.iter().for_each(|warning| recorder.say(Severity::Warning, warning));
        let shown = recording.show_to(&mut recorder);
        self.after.iter().for_each(|warning| recorder.say(Severity::Warning, warning));
        let ended = shown.map_err(|error| Error::Run(RunError::Observer(error)));
        let outcome = match (&self.failure, &ended) {
            (_, Err(_)) => Outcome::Failed,
            (Some((outcome, _)), _) => *outcome,
            (None, _) => Outcome::Finished,
        };
        match &self.failure {
            Some((_, why)) => recorder.say(Severity::Error, why),
            None => recorder.say(Severity::Info, AT_END),
        }
        let figures = self.figures.clone();
        let written = recorder.finish(Ending { outcome, figures }).map_err(Error::from);
        ended.and(written)
    }
}

/// The entry of the log at the end of a run.
const AT_END: &str = "the run has reached its end";

/// The outcome of a run in the words of the log.
fn outcome(error: &Error) -> Outcome {
    match error {
        Error::Run(RunError::Interrupted { .. }) => Outcome::Interrupted,
        _ => Outcome::Failed,
    }
}

/// Completes a log, and returns the outcome of the run and the place of the log, unless it could not be written.
fn complete(
    mut recorder: Recorder,
    ended: Result<(), Error>,
    figures: BTreeMap<String, String>,
    output: &Path,
) -> (Result<(), Error>, Option<PathBuf>) {
    let outcome = ended.as_ref().err().map_or(Outcome::Finished, outcome);
    match &ended {
        Err(error) => recorder.say(Severity::Error, &error.to_string()),
        Ok(()) => recorder.say(Severity::Info, AT_END),
    }
    let beside = recorder.beside().map(Path::to_path_buf);
    let written = recorder.finish(Ending { outcome, figures }).map_err(|error: LogError| Error::from(error));
    let is_written = written.is_ok();
    match ended.and(written) {
        Ok(()) => (Ok(()), Some(output.to_path_buf())),
        // The first of two errors is the cause, so it is the one reported.
        Err(problem) => {
            let error = match &beside {
                Some(beside) => {
                    let (output, beside) = (output.to_path_buf(), beside.clone());
                    Error::Beside { problem: Box::new(problem), output, beside }
                }
                None => problem,
            };
            (Err(error), is_written.then(|| beside.unwrap_or_else(|| output.to_path_buf())))
        }
    }
}
