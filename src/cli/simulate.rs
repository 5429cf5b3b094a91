//! `catena simulate`: read, reduce, run, log, report.
//!
//! The output is opened last, when nothing in the input can be wrong any more: a bad input leaves an existing log as
//! it was. Every way out of the run completes the log.

use crate::cli::check::{apart, end_with_half_the_step};
use crate::cli::input::{InputArgs, Loaded};
use crate::cli::log_options::LogArgs;
use crate::cli::numbers::{Assignment, numbers, positive, rate};
use crate::cli::page_files::{check_page, is_same};
use crate::cli::progress::{PilotsShown, Progress};
use crate::cli::run_log::{description, finish, log_failure};
use crate::cli::special_output::open_special;
use crate::cli::{Failure, check_place, print, print_json};
use anyhow::{Context, anyhow};
use catena::instant::assembly::redundancy_counted;
use catena::mechanism::motion::state::State;
use catena::model::Model;
use catena::output::log::{LONGEST, LogOptions, Recorder, Severity, neighbour, seconds};
use catena::output::page::MESH_LIMIT;
use catena::output::report::{
    AccuracyReport, ConstraintReport, ContactsReport, EnergyReport, EventReport, FarSpring, IslandReport, MethodReport,
    ModelReport, Report, SpeedWatch, StepErrorReport, balance_warning, carried_reports, link_reports, ringing_warning,
    singular_warning, unsolved_warning,
};
use catena::scene::SimulationSettings;
use catena::simulation::{Finished, Simulation, SimulationError, SimulationOptions, StepChoice};
use clap::{Args, value_parser};
use cpu_time::ProcessTime;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::time::Instant;

const DEFAULT_DURATION: f64 = 10.0;
const DEFAULT_TOLERANCE: f64 = 1e-6;
const DEFAULT_RATE: f64 = 60.0;

/// The options of `catena simulate`.
#[derive(Args, Debug)]
pub struct Arguments {
    #[command(flatten)]
    pub input: InputArgs,

    /// Velocity of the origin of a floating root link, in the world [m/s, rad/s]
    #[arg(long, value_name = "VX,VY,VZ,WX,WY,WZ", value_parser = numbers::<6>, allow_hyphen_values = true)]
    base_velocity: Option<[f64; 6]>,

    /// Initial position of a joint [rad, m]; as many numbers as the joint has degrees of freedom (repeatable)
    #[arg(long, value_name = "JOINT=VALUE")]
    position: Vec<Assignment>,

    /// Initial velocity of a joint [rad/s, m/s]; as many numbers as the joint has degrees of freedom (repeatable)
    #[arg(long, value_name = "JOINT=VALUE")]
    velocity: Vec<Assignment>,

    /// The log [default: the name of the input with .mcap, in the current folder]
    #[arg(short, long, value_name = "FILE.mcap", value_parser = crate::cli::output_file())]
    output: Option<PathBuf>,

    /// Write no log
    #[arg(long, conflicts_with = "output")]
    no_log: bool,

    /// Write a page of the run, too: 3-D, curves and report in one file that any browser opens
    #[arg(long, value_name = "FILE.html", value_parser = crate::cli::output_file(), conflicts_with = "no_log")]
    pub report: Option<PathBuf>,

    /// Most triangles of all meshes of the page together; larger meshes are simplified, 0 leaves meshes out
    #[arg(long, value_name = "TRIANGLES", default_value_t = MESH_LIMIT, requires = "report")]
    pub mesh_limit: usize,

    /// Simulated time [s] [default: 10]
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = positive)]
    duration: Option<f64>,

    /// Wanted accuracy of positions [m]; stages and step are chosen from it [default: 1e-6]
    #[arg(long, value_name = "E", allow_negative_numbers = true, value_parser = positive)]
    tolerance: Option<f64>,

    /// Stages of the scheme, of order 2S-2, with a fixed --step
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = value_parser!(u8).range(2..=16),
          requires = "step", conflicts_with = "tolerance")]
    stages: Option<u8>,

    /// Fixed step [s], with --stages
    #[arg(long, value_name = "H", allow_negative_numbers = true, value_parser = positive, requires = "stages", conflicts_with = "tolerance")]
    step: Option<f64>,

    /// Vary the step with the pace of the motion, from --step on, so that very long runs do not drift; trees under gravity alone
    #[arg(long, requires = "step")]
    reversible: bool,

    /// Solve the steps to 32 digits instead of 16, some ten times slower: rounding does not drift, however long the run; trees under
    /// gravity alone, with up to 9 stages
    #[arg(long, requires = "step", conflicts_with = "reversible")]
    precise: bool,

    /// Run it once more with half the --step, on another core, and estimate the error of the steps by that
    #[arg(long, requires = "step")]
    check: bool,

    /// Samples in the log per simulated second [default: 60]
    #[arg(long, value_name = "HZ", allow_negative_numbers = true, value_parser = rate)]
    rate: Option<f64>,

    #[command(flatten)]
    log: LogArgs,

    /// Print the report as one JSON object
    #[arg(long)]
    pub json: bool,

    /// Print errors only
    #[arg(long)]
    pub quiet: bool,
}

/// A run before its first step.
pub struct Setup {
    pub state: State,
    pub choice: StepChoice,
    /// Simulated time [s].
    pub duration: f64,
    /// Samples per simulated second.
    pub rate: f64,
    /// What is in the log, and how.
    pub log: LogOptions,
}

impl Setup {
    /// What the command line says, or else the file, or else the defaults.
    ///
    /// # Errors
    /// What is wrong with the start, or cannot be simulated.
    pub fn new(arguments: &Arguments, loaded: &mut Loaded) -> anyhow::Result<Self> {
        let state = loaded.initial_state(&arguments.position, &arguments.velocity, arguments.base_velocity)?;
        let file = &loaded.simulation;
        let duration = arguments.duration.or(file.duration).unwrap_or(DEFAULT_DURATION);
        Ok(Setup {
            state,
            choice: step_choice(arguments, file).within(duration),
            duration,
            rate: arguments.rate.or(file.rate).unwrap_or(DEFAULT_RATE),
            log: arguments.log.options(),
        })
    }
}

/// How steps are chosen: what the command line says, or else the file.
fn step_choice(arguments: &Arguments, file: &SimulationSettings) -> StepChoice {
    let given = arguments.stages.zip(arguments.step).map(|(stages, step)| (stages.into(), step));
    let fixed = given.or(file.fixed.filter(|_| arguments.tolerance.is_none()));
    match fixed {
        Some((stages, step)) if arguments.reversible => StepChoice::Reversible { stages, step },
        Some((stages, step)) if arguments.precise => StepChoice::Precise { stages, step },
        Some((stages, step)) => StepChoice::Fixed { stages, step },
        None => StepChoice::Tolerance(arguments.tolerance.or(file.tolerance).unwrap_or(DEFAULT_TOLERANCE)),
    }
}

/// Who is to blame for a run that cannot begin: the command line, or nobody.
pub fn setup_failure(error: SimulationError) -> Failure {
    match error {
        SimulationError::Method(error) => Failure::input(error),
        SimulationError::Interrupted(error) => Failure::interrupted(error),
        SimulationError::Mechanism(error) => Failure::run(error),
    }
}

/// What became of a run that has begun.
pub struct Ran {
    /// Where the log is, if there is one.
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
    let Setup { state, choice, duration, rate, log } = Setup::new(arguments, &mut loaded).map_err(Failure::input)?;
    let model = &loaded.model;
    output.iter().try_for_each(|output| check_apart(output, model)).map_err(Failure::input)?;
    if let (Some(page), Some(log)) = (&arguments.report, &output) {
        check_report(page, log, model).map_err(Failure::input)?;
    }
    if output.is_some() && duration + seconds(log.start) > LONGEST {
        let error = anyhow!(
            "a log counts nanoseconds, up to {LONGEST:e} s after 1970; give a shorter --duration than {duration:e}, an earlier \
             --start-time or --no-log"
        );
        return Err(Failure::input(error));
    }
    let mechanism = &model.mechanism;
    let counted = loaded.counted.clone();
    let redundancy = counted.as_deref().map(|counted| redundancy_counted(mechanism, counted)).unwrap_or_default();

    // The run ends after the step it is in.
    let interrupted = crate::cli::watch_for_signals().map_err(Failure::run)?;
    let (clock, cpu_clock) = (Instant::now(), ProcessTime::now());
    let shows = !arguments.quiet && std::io::stderr().is_terminal();
    let pilots = (shows && choice.tolerance().is_some()).then(PilotsShown::new);
    let switched_off = &arguments.input.keep[..];
    let options = SimulationOptions { duration, steps: choice, switched_off, interrupt: Some(&interrupted) };
    // They outlive the run, which they watch.
    let (mut recorder, mut progress, mut speeds);
    let start = arguments.check.then(|| state.clone());
    let far = FarSpring::of(mechanism, &state);
    let mut simulation = Simulation::from_counted(mechanism, state, counted, options).map_err(setup_failure)?;
    drop(pilots);
    let model_report = ModelReport::new(model, &redundancy, simulation.parts());
    let (mut accuracy, accuracy_unknown) = match AccuracyReport::of(&simulation) {
        Ok(accuracy) => (Some(accuracy), None),
        Err(reason) => (None, Some(reason.to_string())),
    };
    let mut unreached: Vec<String> = accuracy.as_ref().and_then(AccuracyReport::warning).into_iter().collect();
    if let Some(far) = &far {
        unreached.extend(far.warning(choice.tolerance().unwrap_or(DEFAULT_TOLERANCE)));
        accuracy.iter_mut().for_each(|accuracy| accuracy.see_rounding(far));
    }
    recorder = match &output {
        Some(path) => {
            let simulation = description(model, duration, rate, choice, simulation.description());
            let held = open_special(path, &interrupted).map_err(Failure::interrupted)?;
            let mut recorder = Recorder::create(path, model, simulation, &log).map_err(log_failure)?;
            drop(held);
            recorder.heed(&interrupted);
            unreached.iter().for_each(|warning| recorder.say(Severity::Warning, warning));
            Some(recorder)
        }
        None => None,
    };
    progress = shows.then(|| Progress::new(duration));
    speeds = SpeedWatch::new(model);
    // Without a log, a bar and largest speeds nobody looks at samples.
    if recorder.is_some() || progress.is_some() || speeds.is_some() {
        simulation.sample_at(rate);
    }
    recorder.iter_mut().for_each(|recorder| simulation.observe(recorder));
    progress.iter_mut().for_each(|progress| simulation.observe(progress));
    speeds.iter_mut().for_each(|speeds| simulation.observe(speeds));
    let (ended, checked) = std::thread::scope(|scope| {
        let half = start.map(|start| scope.spawn(move || end_with_half_the_step(mechanism, start, options)));
        let ended = simulation.run();
        (ended, half.and_then(|half| half.join().ok().flatten()))
    });
    let finished = simulation.finish();
    let (events, contact) = (EventReport::new(model, &finished), ContactsReport::new(model, &finished));
    let Finished { state, summary, method, islands, joints: statuses, .. } = finished;
    if let Some(progress) = &progress {
        progress.clear();
    }
    let step_error = choice.step().and_then(|_| match &checked {
        Some(other) => Some(StepErrorReport::by_half_the_step(apart(mechanism, &state, other))),
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
        .chain(speeds.iter().flat_map(SpeedWatch::warning))
        .collect();
    if let Some(recorder) = &mut recorder {
        of_method.iter().for_each(|warning| recorder.say(Severity::Warning, warning));
    }
    let estimated_error =
        accuracy.as_ref().map(|accuracy| accuracy.estimated).or(step_error.map(|error| error.estimated));
    let (ended, log) = finish(recorder, ended, &summary, estimated_error, output.as_deref());
    let (wall_seconds, cpu_seconds) = (clock.elapsed().as_secs_f64(), cpu_clock.elapsed().as_secs_f64());

    let (joints, loops) = carried_reports(model, &state, &statuses);
    let report = Report {
        catena: env!("CARGO_PKG_VERSION"),
        input: arguments.input.input.display().to_string(),
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
        log: log.clone(),
    };
    let printed = match (arguments.json, arguments.quiet) {
        (true, _) => print_json(&report),
        (false, true) => Ok(()),
        (false, false) => print(&report),
    };
    // What became of the run is more than what became of its report.
    Ok(Ran { log, ended: ended.and(printed) })
}

/// The page of a run is made from its log: that must be a file, and another one.
fn check_report(page: &Path, log: &Path, model: &Model) -> anyhow::Result<()> {
    check_page(page, model.files())?;
    if is_same(page, log) {
        return Err(anyhow!("the log and the page are the same file {}; choose another --report", page.display()));
    }
    if log.metadata().is_ok_and(|metadata| !metadata.is_file()) {
        return Err(anyhow!("--report reads the log, and {} is no file; choose another --output", log.display()));
    }
    Ok(())
}

/// Where the log goes, refused early if it cannot go there.
fn output(arguments: &Arguments) -> anyhow::Result<Option<PathBuf>> {
    if arguments.no_log {
        return Ok(None);
    }
    let input = &arguments.input.input;
    let output = match &arguments.output {
        Some(output) => output.clone(),
        None => {
            let stem = input.file_stem().with_context(|| format!("{} is not a file", input.display()))?;
            PathBuf::from(format!("{}.mcap", stem.to_string_lossy()))
        }
    };
    if output.as_os_str().to_string_lossy().ends_with(std::path::is_separator) {
        return Err(anyhow!("cannot write {}: give a file, not a folder", output.display()));
    }
    check_place(&output)?;
    Ok(Some(output))
}

/// Neither the log nor its file while the run has not finished may replace what it is made from.
fn check_apart(output: &Path, model: &Model) -> anyhow::Result<()> {
    let wanted = output.canonicalize().unwrap_or_else(|_| output.to_path_buf());
    for written in [neighbour(&wanted), wanted].iter().filter_map(|path| path.canonicalize().ok()) {
        if model.files().any(|file| file.canonicalize().is_ok_and(|file| file == written)) {
            let (output, written) = (output.display(), written.display());
            return Err(anyhow!("cannot write {output}: the run is made from {written}; choose another --output"));
        }
    }
    Ok(())
}
