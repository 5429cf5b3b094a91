//! `catena sweep`: many runs of one scene, in which numbers vary; a row of a table for each.
//!
//! All defects of the sweep file are found before the folder is made. Rows are on the disk before they are counted; Ctrl-C, a kill or a full disk end
//! with the rows up to then, and the same command continues there.

use crate::cli::arguments::numbers::finite;
use crate::cli::terminal::printing::{Failure, print, print_json, warn};
use anyhow::anyhow;
use catena::mechanism::ground::words::rounded;
use catena::scene::PackagePath;
use catena::study::sweep::trial::Trial;
use catena::study::sweep::{Done, Folder, Format, Shard, SweepError, Work, merge, read_sweep};
use clap::{Args, value_parser};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde_json::json;
use std::io::{IsTerminal, Write as _};
use std::path::{Path, PathBuf};
use std::time::Instant;

const EXAMPLES: &str = "\
Examples:
  catena sweep robots/pendulum_sweep.toml --dry-run          what it will take: runs, columns, seconds, bytes
  catena sweep robots/pendulum_sweep.toml -o out             all runs on all cores; the same command again continues where it stopped
  catena sweep robots/pendulum_sweep.toml -o out3 --shard 3/8   the third of eight parts, as one job of a cluster
  catena sweep --merge out1 out2 out3 -o out                 the rows of all parts in one folder

The sweep file is described in doc/sweeps.md, clusters in doc/many_machines.md; `catena model INPUT --parameters` lists what can vary.";

/// The options of `catena sweep`.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct SweepArgs {
    /// The sweep file: the scene, what varies, what is kept
    #[arg(value_name = "FILE.toml", required_unless_present = "merge", conflicts_with = "merge")]
    file: Option<PathBuf>,

    /// Folder for the rows; created if missing; a folder of the same sweep is continued
    #[arg(short, long, value_name = "DIR", value_parser = crate::cli::arguments::outputs::output_folder(), required_unless_present = "dry_run")]
    output: Option<PathBuf>,

    /// Make a few runs, estimate what the whole sweep takes, and write no files, also with --output
    #[arg(long, conflicts_with = "merge")]
    dry_run: bool,

    /// How rows are written: csv, or parquet if it was compiled in [default: parquet if it was]
    #[arg(long, value_name = "FORMAT", conflicts_with = "merge", help_heading = "Rows")]
    format: Option<Format>,

    /// Print what was done as one JSON object
    #[arg(long, help_heading = "Rows")]
    json: bool,

    /// Print on standard error every S seconds how many rows are written, for the logs of clusters
    #[arg(long, value_name = "S", value_parser = not_negative, allow_hyphen_values = true, conflicts_with = "merge", help_heading = "Rows")]
    progress: Option<f64>,

    /// Print errors and warnings only
    #[arg(long, help_heading = "Rows")]
    quiet: bool,

    /// Threads, one run on each [default: one for each core]
    #[arg(long, value_name = "J", value_parser = value_parser!(u16).range(1..), conflicts_with = "merge", help_heading = "Cores and machines")]
    jobs: Option<u16>,

    /// The K-th of N parts, counted from 1, into a folder of its own
    #[arg(long, value_name = "K/N", conflicts_with = "merge", help_heading = "Cores and machines")]
    shard: Option<Shard>,

    /// Join the rows of all N parts into the files of the whole sweep
    #[arg(long, value_name = "DIR", num_args = 1.., help_heading = "Cores and machines")]
    merge: Vec<PathBuf>,

    /// Folder of a ROS package, as of `catena simulate` (repeatable)
    #[arg(long, value_name = "NAME=DIR", value_parser = crate::cli::arguments::input::package, help_heading = "Scene")]
    package: Vec<(String, PathBuf)>,
}

/// Does what the arguments say.
///
/// # Errors
/// [`Failure`] with the exit code the interface promises.
pub fn run(arguments: &SweepArgs) -> Result<(), Failure> {
    let output = || arguments.output.as_deref().ok_or_else(|| Failure::input(anyhow!("give a folder: --output DIR")));
    match &arguments.file {
        None => merge_all(arguments, output()?),
        Some(file) if arguments.dry_run => dry_run(arguments, file),
        Some(file) => sweep(arguments, file, output()?),
    }
}

/// The cause of a failure: the input, the disk, or neither.
fn failure(error: SweepError) -> Failure {
    match error {
        SweepError::Interrupted { .. } => Failure::interrupted(error),
        error if error.is_input() => Failure::input(error),
        error => Failure::run(error),
    }
}

fn read(arguments: &SweepArgs, file: &Path) -> Result<catena::study::sweep::Sweep, Failure> {
    let sweep = read_sweep(file, &PackagePath::from_environment(arguments.package.clone())).map_err(failure)?;
    sweep.warnings.iter().filter(|_| !arguments.quiet).for_each(warn);
    Ok(sweep)
}

fn sweep(arguments: &SweepArgs, file: &Path, output: &Path) -> Result<(), Failure> {
    let sweep = read(arguments, file)?;
    let shard = arguments.shard.unwrap_or(Shard::WHOLE);
    // No run has been made yet: a folder that cannot be written is bad input.
    let opened = Folder::open(output, &sweep, shard, arguments.format.unwrap_or(Format::DEFAULT));
    let mut folder = opened.map_err(|error| match error {
        SweepError::Disk { .. } => Failure::input(error),
        other => failure(other),
    })?;
    let interrupted = crate::cli::terminal::signals::watch_for_signals().map_err(Failure::run)?;
    let cores = || std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let jobs = arguments.jobs.map_or_else(cores, usize::from);
    let bar = progress_bar(!arguments.quiet && std::io::stderr().is_terminal(), folder.runs());
    let before = folder.done();
    let mut said: Option<Instant> = None;
    let mut told = |done: &Done| {
        if arguments.progress.is_some_and(|every| said.is_none_or(|last| last.elapsed().as_secs_f64() >= every)) {
            said = Some(Instant::now());
            // If standard error is closed, the line is lost.
            let _ = writeln!(std::io::stderr(), "catena: {} of {} runs are done", done.done, done.runs);
        }
        if done.done > before {
            bar.set_position(done.done);
        } else {
            // Rows of earlier runs do not count for the speed.
            bar.reset_eta();
            bar.set_position(done.done);
        }
        if done.failed > 0 {
            bar.set_message(format!("{} failed", done.failed));
        }
    };
    let clock = Instant::now();
    let ended = Work { jobs, interrupt: &interrupted, told: &mut told }.finish(&sweep, &mut folder);
    bar.finish_and_clear();
    let done = ended.map_err(failure)?;
    let seconds = clock.elapsed().as_secs_f64();
    if let Some((index, reason)) = &done.first_failure {
        warn(format_args!(
            "{} of {} runs failed; the first is that of index {index}: {reason}",
            done.failed, done.made
        ));
    }
    if arguments.json {
        let (number, of) = shard.numbers();
        return print_json(&json!({
            "catena": env!("CARGO_PKG_VERSION"),
            "sweep": sweep.name,
            "runs": done.runs,
            "done": done.done,
            "made": done.made,
            "failed": done.failed,
            "shard": [number, of],
            "wall_seconds": seconds,
            "rows": folder.files(),
        }));
    }
    if arguments.quiet {
        return Ok(());
    }
    let there = if before > 0 { format!(", {before} were there") } else { String::new() };
    let rate = if done.made > 0 {
        format!(" ({} µs of a core each)", rounded(1e6 * seconds * jobs as f64 / done.made as f64))
    } else {
        String::new()
    };
    print(format_args!(
        "{}: {} runs made in {} s{rate}{there}, {} failed\n{}\n",
        sweep.name,
        done.made,
        rounded(seconds),
        done.failed,
        folder.files()
    ))
}

fn dry_run(arguments: &SweepArgs, file: &Path) -> Result<(), Failure> {
    let sweep = read(arguments, file)?;
    let interrupted = crate::cli::terminal::signals::watch_for_signals().map_err(Failure::run)?;
    let (shard, format) = (arguments.shard.unwrap_or(Shard::WHOLE), arguments.format.unwrap_or(Format::DEFAULT));
    let trial = Trial::new(&sweep, shard, format, &interrupted).map_err(failure)?;
    if arguments.json {
        return print_json(&trial);
    }
    let (number, of) = shard.numbers();
    let part = if of > 1 { format!(", {} in shard {number}/{of}", trial.runs) } else { String::new() };
    print(format_args!(
        "{}: {} runs{part}\n{} s of one core a run, {} bytes a row ({} runs tried, {} failed)\n{} core hours, {} MB in {} {} files\ncolumns: {}\n",
        sweep.name,
        trial.sweep_runs,
        rounded(trial.seconds_per_run),
        rounded(trial.bytes_per_row),
        trial.tried,
        trial.failed,
        rounded(trial.seconds_per_run * trial.runs as f64 / 3600.0),
        rounded(trial.bytes_per_row * trial.runs as f64 / 1e6),
        trial.files,
        format.name(),
        trial.columns.join(" ")
    ))
}

fn merge_all(arguments: &SweepArgs, output: &Path) -> Result<(), Failure> {
    let (rows, files) = merge(&arguments.merge, output).map_err(failure)?;
    if arguments.json {
        return print_json(&json!({ "rows": rows, "files": files, "folder": output.display().to_string() }));
    }
    if arguments.quiet { Ok(()) } else { print(format_args!("{rows} rows in {files} files in {}\n", output.display())) }
}

/// Seconds.
fn not_negative(text: &str) -> Result<f64, String> {
    match finite(text)? {
        number if number >= 0.0 => Ok(number),
        _ => Err("must not be negative".to_string()),
    }
}

/// A bar of runs.
fn progress_bar(visible: bool, runs: u64) -> ProgressBar {
    let target = if visible { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    let bar = ProgressBar::with_draw_target(Some(runs), target);
    if let Ok(style) = ProgressStyle::with_template("{wide_bar} {pos} of {len} runs, {per_sec}, {eta} left {msg}") {
        bar.set_style(style);
    }
    bar
}
