//! `catena simulate`: read, reduce, run, log, report.
//!
//! The output is opened last, after every check of the input: a bad input leaves an existing log as it was. Every way out of the run completes the
//! log.

use crate::cli::arguments::input::InputArgs;
use crate::cli::arguments::log_options::LogArgs;
use crate::cli::arguments::numbers::{Assignment, Coordinates, numbers, pairs, positive, rate};
use crate::cli::logged_state::{LogInstant, LoggedStart, start_of};
use crate::cli::origin;
use crate::cli::page_files::{check_page, is_same};
use crate::cli::sensitivity::{By, RunSettings, as_text, deviations, differentiate, end_as_json};
use crate::cli::terminal::printing::{Failure, print, print_json};
use crate::cli::terminal::progress::Progress;
use anyhow::{Context, anyhow};
use catena::drawing::files::is_special;
use catena::mechanism::motion::state::State;
use catena::output::inspection::summary::Summary;
use catena::output::log::{Derivatives, DerivativesRow, LogOptions};
use catena::output::page::MESH_LIMIT;
use catena::output::report::FromLog;
use catena::scene::Warning;
use catena::session::{Asked, Course, Finish, Loaded, Model, Running, Sensitivity, Settled, check_log, check_place};
use clap::{Args, value_parser};
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Groups of options.
const START: &str = "Start";
const STEPS: &str = "Duration, accuracy and steps";
const LOG: &str = "Log";
const REPORT: &str = "Report";

/// The options of `catena simulate`.
#[derive(Args, Debug)]
pub struct Arguments {
    #[command(flatten)]
    pub input: InputArgs,

    /// Velocity of the origin of a floating root link, in the world [m/s, rad/s]
    #[arg(long, help_heading = START, value_name = "VX,VY,VZ,WX,WY,WZ", value_parser = numbers::<6>, allow_hyphen_values = true)]
    base_velocity: Option<[f64; 6]>,

    /// Initial position of a joint [rad, or "30 deg"; m]; as many numbers as the joint has degrees of freedom (repeatable)
    #[arg(long, help_heading = START, value_name = "JOINT=VALUE")]
    position: Vec<Assignment>,

    /// Initial velocity of a joint [rad/s, m/s]; as many numbers as the joint has degrees of freedom (repeatable)
    #[arg(long, help_heading = START, value_name = "JOINT=VALUE")]
    velocity: Vec<Assignment>,

    /// Start from the sample of a log that is nearest to the time T [s] of its run, and go on at that time; LOG@end is its last
    #[arg(long, help_heading = START, value_name = "LOG@T", conflicts_with_all = ["position", "velocity", "base_velocity"])]
    from: Option<LogInstant>,

    /// Simulated time [s] [default: 10]
    #[arg(long, help_heading = STEPS, value_name = "S", allow_hyphen_values = true, value_parser = positive)]
    duration: Option<f64>,

    /// Wanted accuracy of positions [m]; stages and step are chosen from it [default: 1e-6]
    #[arg(long, help_heading = STEPS, value_name = "E", allow_hyphen_values = true, value_parser = positive)]
    tolerance: Option<f64>,

    /// Leave out the estimate of the error at the end, which takes about half of the time: each step keeps to its share of the tolerance
    #[arg(long, help_heading = STEPS, conflicts_with = "stages")]
    no_estimate: bool,

    /// Stages of the scheme, of order 2S-2, with a fixed --step; 1 steps over events: impacts, sticking and limits within a step are solved together,
    /// of order 1
    #[arg(long, help_heading = STEPS, value_name = "S", allow_hyphen_values = true, value_parser = value_parser!(u8).range(1..=16),
          requires = "step", conflicts_with = "tolerance")]
    stages: Option<u8>,

    /// Fixed step [s], with --stages
    #[arg(long, help_heading = STEPS, value_name = "H", allow_hyphen_values = true, value_parser = positive, requires = "stages", conflicts_with = "tolerance")]
    step: Option<f64>,

    /// Vary the step with the pace of the motion, starting from --step, without drift over very long runs; only for trees under gravity
    #[arg(long, help_heading = STEPS, requires = "step")]
    reversible: bool,

    /// Solve the steps to 32 digits instead of 16, some ten times slower: rounding does not drift, however long the run; trees under
    /// gravity alone, with up to 9 stages
    #[arg(long, help_heading = STEPS, requires = "step", conflicts_with = "reversible")]
    precise: bool,

    /// Derivatives of the run by a parameter, as `catena sensitivity --by` takes it, with its standard deviation S if the report is to have that of
    /// the motion and the page is to draw it: in the log, its tables and the report (repeatable)
    #[arg(long, help_heading = REPORT, value_name = "KEY[=S]", conflicts_with_all = ["from", "base_velocity", "reversible", "precise"])]
    sensitivity: Vec<By>,

    /// Make the same run with half the --step, on another core, and estimate the error from the difference
    #[arg(long, help_heading = STEPS, requires = "step")]
    check: bool,

    /// The log [default: the name of the input with .mcap, in the current folder]
    #[arg(short, long, help_heading = LOG, value_name = "FILE.mcap", value_parser = crate::cli::arguments::outputs::output_file())]
    output: Option<PathBuf>,

    /// Write no log
    #[arg(long, help_heading = LOG, conflicts_with = "output")]
    no_log: bool,

    /// Write a page of the run, too: 3-D, curves and report in one file that any browser opens
    #[arg(long, help_heading = REPORT, value_name = "FILE.html", value_parser = crate::cli::arguments::outputs::output_file(), conflicts_with = "no_log")]
    pub report: Option<PathBuf>,

    /// Most triangles of all meshes of the page together; larger meshes are simplified, 0 leaves meshes out
    #[arg(long, help_heading = REPORT, value_name = "TRIANGLES", default_value_t = MESH_LIMIT, requires = "report")]
    pub mesh_limit: usize,

    /// Samples in the log per simulated second [default: 60]
    #[arg(long, help_heading = LOG, value_name = "HZ", allow_hyphen_values = true, value_parser = rate)]
    rate: Option<f64>,

    #[command(flatten)]
    log: LogArgs,

    /// Print the report as one JSON object
    #[arg(long, help_heading = REPORT)]
    pub json: bool,

    /// Print errors only
    #[arg(long, help_heading = REPORT)]
    pub quiet: bool,
}

/// A run before its first step.
pub struct Setup {
    pub state: State,
    pub settled: Settled,
    /// The options of the log.
    pub log: LogOptions,
}

impl Setup {
    /// The setup from the command line, or else from the file, or else from the defaults.
    ///
    /// # Errors
    /// The defect of the start or of the settings.
    pub fn new(arguments: &Arguments, loaded: &mut Loaded) -> anyhow::Result<Self> {
        let positions = pairs(&arguments.position, &loaded.model, Coordinates::Positions)?;
        let velocities = pairs(&arguments.velocity, &loaded.model, Coordinates::Velocities)?;
        let state = match &arguments.from {
            None => loaded.initial_state(&positions, &velocities, arguments.base_velocity)?,
            Some(from) => {
                let LoggedStart { state, motors, held, is_there } = start_of(from, &loaded.model)?;
                loaded.hold(&motors, state.time);
                if !is_there {
                    let message =
                        format!("the log has no sample at {} s; the run starts at {} s", from.time, state.time);
                    loaded.model.warnings.push(Warning::odd(&from.log, None, None, message));
                }
                loaded.settled_from(state, &held)?
            }
        };
        arguments.input.refuse_warnings(&loaded.model)?;
        let settled = arguments.asked().settle(&loaded.simulation)?;
        Ok(Setup { state, settled, log: arguments.log.options() })
    }
}

impl Arguments {
    /// The settings that they ask for.
    fn asked(&self) -> Asked {
        Asked {
            duration: self.duration,
            tolerance: self.tolerance,
            no_estimate: self.no_estimate,
            fixed: self.stages.zip(self.step).map(|(stages, step)| (stages.into(), step)),
            reversible: self.reversible,
            precise: self.precise,
            rate: self.rate,
        }
    }
}

/// The result of a run that has begun.
pub struct Ran {
    /// The path of the log, if the run has one.
    pub log: Option<PathBuf>,
    /// How the run ended.
    pub ended: Result<(), Failure>,
}

/// Does what the arguments say, but for the page.
///
/// # Errors
/// [`Failure`] of runs that did not begin, with the exit code the interface promises.
pub fn run(arguments: &Arguments) -> Result<Ran, Failure> {
    let output = output(arguments).map_err(Failure::input)?;
    let mut loaded = arguments.input.load().map_err(Failure::input)?;
    let Setup { state, settled, mut log } = Setup::new(arguments, &mut loaded).map_err(Failure::input)?;
    let Settled { duration, rate, .. } = settled;
    let model = Model::of_loaded(loaded, arguments.input.input.clone(), arguments.input.world.world());
    let derived = derivatives(arguments, &model, (duration, rate))?;
    log.derivatives = derived.as_ref().map(|found| Arc::new(logged(found, deviations(&arguments.sensitivity, found))));
    let description = model.description();
    output.iter().try_for_each(|output| check_log(output, description, duration, &log)).map_err(Failure::input)?;
    if let (Some(page), Some(log)) = (&arguments.report, &output) {
        check_report(page, log, description).map_err(Failure::input)?;
    }

    // The run ends after the step it is in.
    let interrupt = crate::cli::terminal::signals::watch_for_signals().map_err(Failure::run)?;
    let shows = !arguments.quiet && std::io::stderr().is_terminal();
    let progress = shows.then(|| Progress::new(duration));
    let mut origin = origin();
    if let Some(from) = &arguments.from {
        origin.driven = Some(format!("it went on from the log {}", from.log.display()));
        // A log that has been read before can be read again.
        let estimated_error = Summary::read(&from.log).ok().and_then(|summary| summary.error_of_samples());
        origin.from_log = Some(FromLog { log: from.log.display().to_string(), time: state.time, estimated_error });
    }
    let mut run = Running::begin(Course {
        kept: arguments.input.keep.clone(),
        interrupt,
        others: progress.iter().map(Progress::boxed).collect(),
        checked: arguments.check,
        log: output.map(|path| (path, log)),
        origin,
        ..Course::new(model.clone(), settled, state, model.loaded().counted.clone())
    })?;
    let ended = run.run();
    let (Finish { report, .. }, ended) = run.close(ended, None);
    progress.iter().for_each(Progress::clear);
    let found = derived.as_ref().map(|found| (found, deviations(&arguments.sensitivity, found)));
    let printed = match (arguments.json, arguments.quiet, found) {
        (true, _, None) => print_json(&report),
        (true, _, Some((found, deviations))) => {
            let mut whole = serde_json::to_value(&report).map_err(Failure::run)?;
            whole["sensitivity"] = end_as_json(found, &deviations);
            print_json(&whole)
        }
        (false, true, _) => Ok(()),
        (false, false, None) => print(&report),
        (false, false, Some((found, deviations))) => print(format_args!("{report}\n{}", as_text(found, &deviations))),
    };
    let before = description.warning_lines().count();
    let strict = arguments.input.refuse(report.warnings.iter().skip(before).cloned()).map_err(Failure::run);
    // The outcome of the run matters more than the outcome of its report.
    Ok(Ran { log: report.log, ended: ended.map_err(Failure::from).and(printed).and(strict) })
}

/// The derivatives that are asked for, before the run: a scene without them is refused, and no log is touched.
/// Samples have derivatives of their own if a standard deviation is to be drawn.
fn derivatives(
    arguments: &Arguments,
    model: &Model,
    (duration, rate): (f64, f64),
) -> Result<Option<Sensitivity>, Failure> {
    if arguments.sensitivity.is_empty() {
        return Ok(None);
    }
    let settings = RunSettings {
        keep: &arguments.input.keep,
        duration: arguments.duration,
        tolerance: arguments.tolerance,
        fixed: arguments.stages.zip(arguments.step),
        start: [&arguments.position, &arguments.velocity],
    };
    let run = settings.run(model)?;
    let run = if arguments.no_estimate { run.without_estimate() } else { run };
    let is_drawn = !arguments.no_log && arguments.sensitivity.iter().any(|by| by.deviation.is_some());
    let samples = (1..).map(|sample| f64::from(sample) / rate).take_while(|time| is_drawn && *time < duration);
    let times: Vec<f64> = samples.collect();
    Ok(Some(differentiate(run, &arguments.sensitivity, &times)?))
}

/// Derivatives as a log has them.
fn logged(found: &Sensitivity, deviations: Vec<Option<f64>>) -> Derivatives {
    let column = |of: &nalgebra::DMatrix<f64>, key: usize| of.column(key).iter().copied().collect::<Vec<f64>>();
    let rows = found.times.iter().enumerate().map(|(index, &time)| DerivativesRow {
        time,
        slopes: (0..found.keys.len())
            .map(|key| [column(&found.dq[index], key), column(&found.dv[index], key)])
            .collect(),
    });
    let (keys, freedoms) = (found.keys.clone(), found.freedoms.clone());
    Derivatives { keys, deviations, freedoms, rows: rows.collect() }
}

/// The page of a run is made from its log: that must be a file, and another one.
fn check_report(page: &Path, log: &Path, model: &catena::model::Model) -> anyhow::Result<()> {
    check_page(page, model.files())?;
    if is_same(page, log) {
        return Err(anyhow!("the log and the page are the same file {}; choose another --report", page.display()));
    }
    if is_special(log) {
        return Err(anyhow!("--report reads the log, and {} is no file; choose another --output", log.display()));
    }
    Ok(())
}

/// The path of the log, refused early if it cannot be written.
fn output(arguments: &Arguments) -> anyhow::Result<Option<PathBuf>> {
    if arguments.no_log {
        return Ok(None);
    }
    let input = &arguments.input.input;
    let output = match &arguments.output {
        Some(output) => output.clone(),
        None => {
            let stem =
                input.file_stem().with_context(|| format!("{} is not a file", input.display()))?.to_string_lossy();
            PathBuf::from(format!("{}.mcap", if stem == "-" { "stdin" } else { &stem }))
        }
    };
    check_place(&output)?;
    if let Some(from) = arguments.from.as_ref().filter(|from| is_same(&from.log, &output)) {
        return Err(anyhow!(
            "the run goes on from the log {}, which it would replace; choose another --output",
            from.log.display()
        ));
    }
    Ok(Some(output))
}
