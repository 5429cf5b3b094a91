//! `catena chart`: read, measure scene after scene, write pictures, numbers and the page.
//!
//! All defects of the input are found before the folder is made. After every scene all files are written anew, each whole; Ctrl-C ends with the
//! measurements up to then.

use crate::cli::arguments::input::WorldArgs;
use crate::cli::arguments::numbers::{Assignment, Coordinates, numbers, pairs, positive};
use crate::cli::arguments::outputs::{check_folder, make_folder};
use crate::cli::terminal::printing::{Failure, print, warn};
use anyhow::{Context, anyhow};
use catena::drawing::error::ChartError;
use catena::mechanism::ground::words::counted;
use catena::model::Model;
use catena::session::Loaded;
use catena::study::chart::measure::Plan;
use catena::study::chart::report::{ENERGY, Report};
use catena::study::chart::{Measurement, Scene, measure, read_csv};
use clap::Args;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

const DEFAULT_DURATION: f64 = 2.0;
const DEFAULT_BUDGET: f64 = 120.0;
const QUICK_BUDGET: f64 = 15.0;

/// The options of `catena chart`.
#[derive(Args, Debug)]
pub struct ChartArgs {
    /// The robots and scenes: .urdf and .toml files
    #[arg(required = true, value_name = "INPUT")]
    inputs: Vec<PathBuf>,

    /// Folder for the pictures, measurements.csv and index.html; created if missing
    #[arg(short, long, value_name = "DIR", value_parser = crate::cli::arguments::outputs::output_folder())]
    output: PathBuf,

    #[command(flatten)]
    world: WorldArgs,

    /// Velocity of the origin of a floating root link, in the world [m/s, rad/s]
    #[arg(long, value_name = "VX,VY,VZ,WX,WY,WZ", value_parser = numbers::<6>, allow_hyphen_values = true)]
    base_velocity: Option<[f64; 6]>,

    /// Initial position of a joint [rad, m], in every input that has such a joint (repeatable)
    #[arg(long, value_name = "JOINT=VALUE")]
    position: Vec<Assignment>,

    /// Initial velocity of a joint [rad/s, m/s], in every input that has such a joint (repeatable)
    #[arg(long, value_name = "JOINT=VALUE")]
    velocity: Vec<Assignment>,

    /// Simulated time of each scene [s] [default: as its file says, or 2]
    #[arg(long, value_name = "S", allow_hyphen_values = true, value_parser = positive)]
    duration: Option<f64>,

    /// CPU time for the measurements of each scene [s], reference not counted [default: 120, with --quick 15]
    #[arg(long, value_name = "SECONDS", allow_hyphen_values = true, value_parser = positive)]
    budget: Option<f64>,

    /// Fewer settings and repetitions
    #[arg(long)]
    quick: bool,

    /// Measurements of other programs, drawn into the same pictures (repeatable): columns scene, method, error [m],
    /// cpu_seconds_per_simulated_second, named in the first line; scene is the input's file name without its ending
    #[arg(long, value_name = "FILE.csv")]
    csv: Vec<PathBuf>,

    /// Print errors only
    #[arg(long)]
    quiet: bool,
}

/// Does what the arguments say.
///
/// # Errors
/// [`Failure`] with the exit code the interface promises.
pub fn run(arguments: &ChartArgs) -> Result<(), Failure> {
    let scenes = scenes(arguments).map_err(Failure::input)?;
    let foreign = foreign(&arguments.csv, &scenes).map_err(Failure::input)?;
    let folder = &arguments.output;
    check_folder(folder).map_err(Failure::input)?;
    let plan = Plan {
        quick: arguments.quick,
        budget: arguments.budget.unwrap_or(if arguments.quick { QUICK_BUDGET } else { DEFAULT_BUDGET }),
    };
    make_folder(folder).map_err(Failure::input)?;
    for scene in scenes.iter().filter(|scene| !scene.mechanism.nonsmooth.pairs.is_empty()) {
        let pairs = counted(scene.mechanism.nonsmooth.pairs.len(), "pair of shapes", "pairs of shapes");
        let name = &scene.name;
        warn(format_args!(
            "{name}: {pairs} may touch; RK4, DOP853 and Euler know no contacts and are left out (--without contact keeps them)"
        ));
    }
    // The chart ends after the step it is in.
    let interrupted = crate::cli::terminal::signals::watch_for_signals().map_err(Failure::run)?;

    let bar = progress_bar(!arguments.quiet && std::io::stderr().is_terminal(), scenes.len());
    let mut report = Report { foreign, machine: processor(), ..Report::default() };
    // One scene that cannot be measured does not take the others with it.
    let mut failures = Vec::new();
    for (number, scene) in scenes.iter().enumerate() {
        let told = &mut |what: &str, fraction: f64| {
            bar.set_position((1000.0 * (number as f64 + fraction)) as u64);
            bar.set_message(format!("{}: {what}", scene.name));
        };
        match measure(scene, &plan, &interrupted, told) {
            Ok(chart) => {
                report.scenes.push(chart);
                report.write(folder).map_err(Failure::run)?;
            }
            Err(ChartError::Interrupted { .. }) => {}
            Err(error) => failures.push(error.to_string()),
        }
        if interrupted.load(Ordering::Relaxed) {
            break;
        }
    }
    bar.finish_and_clear();
    if !arguments.quiet && !report.scenes.is_empty() {
        print(report.summary())?;
    }
    if interrupted.load(Ordering::Relaxed) {
        let measured = report.scenes.len();
        return Err(Failure::interrupted(anyhow!("interrupted; {measured} of {} scenes are drawn", scenes.len())));
    }
    if failures.is_empty() { Ok(()) } else { Err(Failure::run(anyhow!(failures.join("; ")))) }
}

/// Reads every input and settles where it starts.
fn scenes(arguments: &ChartArgs) -> anyhow::Result<Vec<Scene>> {
    let inputs: Vec<Loaded> =
        arguments.inputs.iter().map(|input| arguments.world.load(input)).collect::<anyhow::Result<_>>()?;
    for assignment in arguments.position.iter().chain(&arguments.velocity) {
        // The message of the model itself is better for a single input.
        if inputs.len() > 1 && inputs.iter().all(|one| one.model.joint(&assignment.name).is_none()) {
            return Err(anyhow!("no input has a joint {:?}", assignment.name));
        }
    }
    let mut scenes: Vec<Scene> = Vec::new();
    for (mut loaded, input) in inputs.into_iter().zip(&arguments.inputs) {
        refuse_what_has_no_rival(&loaded.model)?;
        let alone = arguments.inputs.len() == 1;
        let here = |assignments: &[Assignment], are| {
            let here = assignments.iter().filter(|one| alone || loaded.model.joint(&one.name).is_some());
            pairs(here, &loaded.model, are)
        };
        let position = here(&arguments.position, Coordinates::Positions)?;
        let velocity = here(&arguments.velocity, Coordinates::Velocities)?;
        let in_input = || input.display().to_string();
        let start = loaded.initial_state(&position, &velocity, arguments.base_velocity).with_context(in_input)?;
        let Loaded { model, simulation, .. } = loaded;
        if model.mechanism.velocity_count == 0 {
            return Err(anyhow!("{}: nothing in it moves", input.display()));
        }
        let name = scene_name(input, &scenes);
        let duration = arguments.duration.or(simulation.duration).unwrap_or(DEFAULT_DURATION);
        scenes.push(Scene { name, mechanism: model.mechanism, start, duration });
    }
    Ok(scenes)
}

/// Refuses what the methods in joint coordinates, against which the chart measures, cannot do.
fn refuse_what_has_no_rival(model: &Model) -> anyhow::Result<()> {
    if model.mechanism.loops.is_empty() && model.mechanism.mimics.is_empty() {
        return Ok(());
    }
    Err(anyhow!(
        "{}: a chart measures against methods in joint coordinates, which know neither closed loops nor mimic relations",
        model.path().display()
    ))
}

/// The file name without its ending, numbered if that or one of its pictures is another input's.
fn scene_name(input: &Path, others: &[Scene]) -> String {
    let stem = input.file_stem().map_or_else(|| "scene".to_string(), |stem| stem.to_string_lossy().into_owned());
    let energy = |name: &str| format!("{name}{ENERGY}");
    let taken = |name: &str| {
        let clash = |other: &str| other == name || energy(other) == name || energy(name) == other;
        others.iter().any(|scene| clash(&scene.name))
    };
    let numbered = (2..).map(|number| format!("{stem}_{number}"));
    std::iter::once(stem.clone()).chain(numbered).find(|name| !taken(name)).unwrap_or(stem)
}

/// Reads the measurements of other programs; warns of files whose measurements belong to no scene.
fn foreign(files: &[PathBuf], scenes: &[Scene]) -> anyhow::Result<Vec<Measurement>> {
    let mut all = Vec::new();
    for file in files {
        let measurements = read_csv(file)?;
        if !measurements.iter().any(|one| scenes.iter().any(|scene| scene.name == one.scene)) {
            warn(format_args!("{}: no measurement of any of the scenes", file.display()));
        }
        all.extend(measurements);
    }
    Ok(all)
}

/// A bar for this number of scenes, a thousand ticks each.
pub fn progress_bar(visible: bool, scenes: usize) -> ProgressBar {
    let target = if visible { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    let bar = ProgressBar::with_draw_target(Some(1000 * scenes as u64), target);
    if let Ok(style) = ProgressStyle::with_template("{bar:30} {percent:>3} %  {elapsed}  {wide_msg}") {
        bar.set_style(style);
    }
    bar
}

/// The processor's name, as far as the system tells it.
pub fn processor() -> String {
    let cpuinfo = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = cpuinfo.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    name.map_or_else(|| std::env::consts::ARCH.to_string(), |(_, name)| name.trim().to_string())
}
