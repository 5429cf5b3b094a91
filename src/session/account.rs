//! What is said of a run: warnings in its log while it goes on, and the report at its end.
//!
//! ```text
//!     open ─▶ begun (sizes, accuracy) ─▶ log ─▶ the run ─▶ close: the log completed, the report
//! ```

use crate::instant::assembly::redundancy_counted;
use crate::lobatto::coupled::counted::Counted;
use crate::mechanism::motion::distance::{distance, probes};
use crate::mechanism::motion::state::State;
use crate::model::Model;
use crate::output::log::{Ending, LogError, LogOptions, Outcome, Recorder, Severity};
use crate::output::report::{
    AccuracyReport, ConstraintReport, ContactsReport, EnergyReport, EventReport, FarSpring, IslandReport, MethodReport,
    ModelReport, Report, SpeedWatch, StepErrorReport, balance_warning, carried_reports, link_reports, ringing_warning,
    singular_warning, unsolved_warning,
};
use crate::session::asked::{DEFAULT_TOLERANCE, Settled};
use crate::session::description::{Origin, description, figures};
use crate::session::error::Error;
use crate::simulation::{Finished, RunError, Simulation};
use cpu_time::ProcessTime;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// A run that is being made.
pub struct Account {
    settled: Settled,
    clock: Instant,
    processor: ProcessTime,
    far: Option<FarSpring>,
}

/// A run that has begun.
pub struct Begun {
    account: Account,
    model: ModelReport,
    accuracy: Option<AccuracyReport>,
    accuracy_unknown: Option<String>,
    /// What cannot be reached.
    warnings: Vec<String>,
}

/// What a run has left.
pub struct Ended<'e> {
    /// The simulation.
    pub finished: Finished,
    /// How it ended.
    pub ended: Result<(), Error>,
    /// Where the same run with half the step has ended.
    pub checked: Option<&'e State>,
    /// Who watched the speeds of joints.
    pub speeds: Option<&'e SpeedWatch>,
    /// The log.
    pub recorder: Option<Recorder>,
    /// Where the log goes.
    pub output: Option<&'e Path>,
}

impl Account {
    /// Before the integrators are made.
    pub fn open(model: &Model, state: &State, settled: Settled) -> Self {
        let far = FarSpring::of(&model.mechanism, state);
        Account { settled, clock: Instant::now(), processor: ProcessTime::now(), far }
    }

    /// Before the first step; `counted` is what was counted of the closures at the start.
    pub fn begun(self, model: &Model, counted: Option<&Counted>, simulation: &Simulation) -> Begun {
        let redundancy = counted.map(|counted| redundancy_counted(&model.mechanism, counted)).unwrap_or_default();
        let (mut accuracy, accuracy_unknown) = match AccuracyReport::of(simulation) {
            Ok(accuracy) => (Some(accuracy), None),
            Err(reason) => (None, Some(reason.to_string())),
        };
        let mut warnings: Vec<String> = accuracy.as_ref().and_then(AccuracyReport::warning).into_iter().collect();
        if let Some(far) = &self.far {
            warnings.extend(far.warning(self.settled.choice.tolerance().unwrap_or(DEFAULT_TOLERANCE)));
            accuracy.iter_mut().for_each(|accuracy| accuracy.see_rounding(far));
        }
        let model = ModelReport::new(model, &redundancy, simulation.parts());
        Begun { account: self, model, accuracy, accuracy_unknown, warnings }
    }
}

impl Begun {
    /// The log of the run, with what is known before the first step; it waits no more for a pipe once `interrupted`.
    ///
    /// # Errors
    /// [`Error::Log`] if it cannot be created.
    pub fn log(
        &self,
        path: &Path,
        model: &Model,
        simulation: &Simulation,
        origin: &Origin,
        options: &LogOptions,
        interrupted: &Arc<AtomicBool>,
    ) -> Result<Recorder, Error> {
        let Settled { duration, rate, choice } = self.account.settled;
        let described = description(model, duration, rate, choice, simulation.description(), origin);
        let mut recorder = Recorder::create(path, model, described, options)?;
        recorder.heed(interrupted);
        self.warnings.iter().for_each(|warning| recorder.say(Severity::Warning, warning));
        Ok(recorder)
    }

    /// Completes the log, whatever ended the run, and says how the run ended and what there is to say of it. `input` is what the user called
    /// the model.
    pub fn close(self, model: &Model, input: String, run: Ended) -> (Report, Result<(), Error>) {
        let Begun { account, model: model_report, mut accuracy, accuracy_unknown, warnings: unreached } = self;
        let Ended { finished, ended, checked, speeds, recorder, output } = run;
        let Settled { duration, choice, .. } = account.settled;
        let mechanism = &model.mechanism;
        let (events, contact) = (EventReport::new(model, &finished), ContactsReport::new(model, &finished));
        let Finished { state, summary, method, islands, joints: statuses, .. } = finished;
        let step_error = choice.step().and_then(|_| match checked {
            Some(other) => {
                Some(StepErrorReport::by_half_the_step(distance(&probes(mechanism, &state), &probes(mechanism, other))))
            }
            None => StepErrorReport::by_energy(mechanism, &summary, duration),
        });
        if let Some(accuracy) = &mut accuracy {
            accuracy.see_energy(&summary);
        }
        let of_method: Vec<String> = MethodReport::warning(&method)
            .into_iter()
            .chain(balance_warning(&method, &summary))
            .chain(step_error.and_then(|error| error.warning(&method)))
            .chain(accuracy.as_ref().and_then(AccuracyReport::energy_warning))
            .chain(ringing_warning(&method))
            .chain(singular_warning(&method))
            .chain(unsolved_warning(&method))
            .chain(speeds.iter().flat_map(|speeds| speeds.warning()))
            .collect();
        let estimated_error =
            accuracy.as_ref().map(|accuracy| accuracy.estimated).or(step_error.map(|error| error.estimated));
        let (ended, log) = match (recorder, output) {
            (Some(mut recorder), Some(output)) => {
                of_method.iter().for_each(|warning| recorder.say(Severity::Warning, warning));
                complete(recorder, ended, figures(&summary, estimated_error), output)
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
            // The time that was reached, which is less than what was asked for if the run ended early.
            duration: state.time,
            method: MethodReport::new(&method),
            model: model_report,
            steps: summary.steps,
            iterations: summary.iterations,
            rejected_steps: summary.rejected_steps,
            kept_factor_iterations: summary.kept_iterations,
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
            warnings: model.warnings.iter().map(ToString::to_string).chain(unreached).chain(of_method).collect(),
            accuracy,
            accuracy_unknown,
            step_error,
            log,
        };
        (report, ended)
    }
}

/// Completes a log, and says how the run ended and where the log is.
fn complete(
    mut recorder: Recorder,
    ended: Result<(), Error>,
    figures: std::collections::BTreeMap<String, String>,
    output: &Path,
) -> (Result<(), Error>, Option<PathBuf>) {
    let outcome = match &ended {
        Ok(()) => Outcome::Finished,
        Err(Error::Run(RunError::Interrupted { .. })) => Outcome::Interrupted,
        Err(_) => Outcome::Failed,
    };
    match &ended {
        Err(error) => recorder.say(Severity::Error, &error.to_string()),
        Ok(()) => recorder.say(Severity::Info, "the run has reached its end"),
    }
    let beside = recorder.beside().map(Path::to_path_buf);
    let written = recorder.finish(Ending { outcome, figures }).map_err(|error: LogError| Error::from(error));
    match ended.and(written) {
        Ok(()) => (Ok(()), Some(output.to_path_buf())),
        // Of two errors the first is the cause.
        Err(problem) => {
            let error = match &beside {
                Some(beside) => {
                    let (output, beside) = (output.to_path_buf(), beside.clone());
                    Error::Beside { problem: Box::new(problem), output, beside }
                }
                None => problem,
            };
            (Err(error), Some(beside.unwrap_or_else(|| output.to_path_buf())))
        }
    }
}
