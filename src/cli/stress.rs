//! `catena stress`: run problem after problem, write pictures, numbers and the page.
//!
//! The arguments are checked before the folder is made. After every problem all files are written anew, each whole; Ctrl-C ends with the problems
//! that have been mapped up to then.

use crate::cli::arguments::outputs::make_folder;
use crate::cli::chart::{processor, progress_bar};
use crate::cli::terminal::printing::{Failure, print};
use anyhow::anyhow;
use catena::study::stress::table::summary;
use catena::study::stress::{Map, Problem, StressError, ThinnedProblem, report};
use clap::Args;
use std::io::IsTerminal;
use std::path::PathBuf;
use std::sync::atomic::Ordering;

/// The options of `catena stress`.
#[derive(Args, Debug)]
pub struct StressArgs {
    /// Folder for the pictures, cells.csv and index.html; created if missing
    #[arg(short, long, value_name = "DIR", value_parser = crate::cli::arguments::outputs::output_folder())]
    output: PathBuf,

    #[arg(long, value_name = "NAME", help = only_help())]
    only: Vec<String>,

    /// Every second difficulty and every third step
    #[arg(long)]
    quick: bool,

    /// Print errors only
    #[arg(long)]
    quiet: bool,
}

/// The help of `--only`, with the names of all problems.
fn only_help() -> String {
    let names: Vec<&str> = Problem::all().iter().map(|problem| problem.name).collect();
    format!("Only the problem of this name (repeatable): {}", names.join(", "))
}

/// Does what the arguments say.
///
/// # Errors
/// [`Failure`] with the exit code the interface promises.
pub fn run(arguments: &StressArgs) -> Result<(), Failure> {
    let problems = problems(arguments).map_err(Failure::input)?;
    let folder = &arguments.output;
    make_folder(folder).map_err(Failure::input)?;
    // Set by the first Ctrl-C; the map ends after the steps it is in.
    let interrupted = crate::cli::terminal::signals::watch_for_signals().map_err(Failure::run)?;

    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let count = problems.len();
    let bar = progress_bar(!arguments.quiet && std::io::stderr().is_terminal(), count);
    let mut maps: Vec<Map> = Vec::new();
    for (number, problem) in problems.into_iter().enumerate() {
        bar.set_message(problem.problem.title);
        let told = |fraction: f64| bar.set_position((1000.0 * (number as f64 + fraction)) as u64);
        match Map::run(problem, threads, &interrupted, &told) {
            Ok(map) => maps.push(map),
            Err(StressError::Interrupted) => break,
            Err(error) => return Err(Failure::run(error)),
        }
        report::write(&maps, &processor(), folder).map_err(Failure::run)?;
    }
    bar.finish_and_clear();
    if !arguments.quiet && !maps.is_empty() {
        print(summary(&maps))?;
    }
    if interrupted.load(Ordering::Relaxed) {
        return Err(Failure::interrupted(anyhow!("interrupted; {} of {count} problems are drawn", maps.len())));
    }
    Ok(())
}

/// The problems that are asked for.
fn problems(arguments: &StressArgs) -> anyhow::Result<Vec<ThinnedProblem>> {
    let all = Problem::all();
    if let Some(unknown) = arguments.only.iter().find(|name| !all.iter().any(|one| one.name == **name)) {
        let names: Vec<&str> = all.iter().map(|one| one.name).collect();
        return Err(anyhow!("there is no problem {unknown:?}; there are {}", names.join(", ")));
    }
    let wanted = |one: &Problem| arguments.only.is_empty() || arguments.only.iter().any(|name| one.name == name);
    let (rows, columns) = if arguments.quick { (2, 3) } else { (1, 1) };
    Ok(all.into_iter().filter(wanted).map(|one| one.thinned(rows, columns)).collect())
}
