//! `catena report`: a page that shows the run of a log, in one file.
//!
//! The model is the one that the log carries, and so are the meshes; those that it only names are read from their files, where they are.

use crate::cli::inspect_files::check_outputs;
use crate::cli::model::page_tables;
use crate::cli::page_files::write_page;
use crate::cli::recorded::Recorded;
use crate::cli::simulate::{self, Setup};
use crate::cli::terminal::printing::{Failure, print, warn};
use catena::mechanism::motion::state::State;
use catena::output::inspection::summary::Summary;
use catena::output::page::{LoggedRun, MESH_LIMIT, PageOptions, run_page};
use clap::Args;
use std::path::{Path, PathBuf};

/// The options of `catena report`.
#[derive(Args, Debug)]
pub struct ReportArgs {
    /// The log
    #[arg(value_name = "LOG.mcap")]
    log: PathBuf,

    /// Another log, which is shown beside it, with its curves dashed
    #[arg(value_name = "LOG.mcap")]
    second: Option<PathBuf>,

    /// The page [default: the name of the log with .html, in the current folder]
    #[arg(short, long, value_name = "FILE.html", value_parser = crate::cli::arguments::outputs::output_file())]
    output: Option<PathBuf>,

    /// Most triangles of all meshes together; larger meshes are simplified, 0 leaves meshes out
    #[arg(long, value_name = "TRIANGLES", default_value_t = MESH_LIMIT)]
    mesh_limit: usize,

    /// Print errors only
    #[arg(long)]
    quiet: bool,
}

/// Does what the arguments say.
///
/// # Errors
/// [`Failure`]: 2 if the log cannot be read, 1 if the page cannot be written.
pub fn run(arguments: &ReportArgs) -> Result<(), Failure> {
    let log = &arguments.log;
    let page = match &arguments.output {
        Some(page) => page.clone(),
        None => PathBuf::from(log.with_extension("html").file_name().unwrap_or_default()),
    };
    for log in [Some(log), arguments.second.as_ref()].into_iter().flatten() {
        check_outputs(log, &[&page]).map_err(Failure::input)?;
        let summary = Summary::read(log).map_err(Failure::input)?;
        if !summary.complete {
            warn(format_args!("{}: {}", log.display(), summary.state()));
        }
    }
    let summary = Summary::read(log).map_err(Failure::input)?;
    let text = page_of_logs(log, arguments.second.as_deref(), arguments.mesh_limit).map_err(Failure::input)?;
    write_page(&page, &text)?;
    if arguments.quiet {
        return Ok(());
    }
    let beside = arguments.second.as_ref().map_or(String::new(), |second| format!(" beside {}", second.display()));
    print(format_args!("{}: {} s of {}{beside}\n", page.display(), summary.duration, log.display()))
}

/// Runs `catena simulate`, and then writes the page that `--report` asks for from the log of the run, however that ended.
///
/// # Errors
/// [`Failure`] of the run, else of the page.
pub fn simulate_and_report(arguments: &simulate::Arguments) -> Result<(), Failure> {
    let ran = simulate::run(arguments)?;
    let (Some(page), Some(log)) = (&arguments.report, &ran.log) else { return ran.ended };
    let written = page_of_log(log, arguments.mesh_limit).map_err(Failure::run).and_then(|text| write_page(page, &text));
    let said = match (&written, arguments.json || arguments.quiet) {
        (Ok(()), false) => print(format_args!("  page        {}\n", page.display())),
        _ => Ok(()),
    };
    // The first of several errors is the cause.
    ran.ended.and(written).and(said)
}

/// The page of a log.
///
/// # Errors
/// The defect of the log.
pub fn page_of_log(log: &Path, mesh_limit: usize) -> anyhow::Result<String> {
    page_of_logs(log, None, mesh_limit)
}

/// The page of a log, with another one beside it.
///
/// # Errors
/// The defect of a log.
pub fn page_of_logs(log: &Path, second: Option<&Path>, mesh_limit: usize) -> anyhow::Result<String> {
    let mut recorded = Recorded::open(log)?;
    let start = start_of(&mut recorded)?;
    let kept = &recorded.arguments.input.keep[..];
    let tables = page_tables(&recorded.loaded, &start, kept);
    let options = PageOptions { mesh_limit, tables };
    let run = LoggedRun { log, model: &recorded.loaded.model, start: &start };
    let Some(log) = second else { return Ok(run_page(run, None, &options)?) };
    let mut recorded = Recorded::open(log)?;
    let start = start_of(&mut recorded)?;
    let second = LoggedRun { log, model: &recorded.loaded.model, start: &start };
    Ok(run_page(run, Some(second), &options)?)
}

/// The start of the run of a log.
fn start_of(recorded: &mut Recorded) -> anyhow::Result<State> {
    match Setup::new(&recorded.arguments, &mut recorded.loaded) {
        Ok(setup) => Ok(setup.state),
        // A log of another version may have started otherwise: its samples count, not the start.
        Err(_) => Ok(recorded.loaded.unassembled_state()?),
    }
}
