//! The command line: the verb, the output, and the exit code.
//!
//! | exit code | meaning                                                                  |
//! |-----------|--------------------------------------------------------------------------|
//! | 0         | done                                                                     |
//! | 1         | failed part-way; what was written up to there is complete and readable   |
//! | 2         | bad usage or bad input; nothing was written                              |
//! | 130       | interrupted; what was written is complete                                |
//!
//! Errors are one line on standard error, `catena: error: …`, so that scripts can show them as they are.

mod arguments;
mod chart;
mod examples;
mod film;
mod inspect;
mod inspect_files;
mod inspect_follow;
mod linearize;
mod linearize_asked;
mod linearize_of_log;
mod linearize_orbit;
mod linearize_told;
mod logged_state;
mod model;
mod page_files;
mod recorded;
mod replay;
mod report;
mod sensitivity;
mod shell;
mod simulate;
mod stress;
mod sweep;
mod tables;
mod terminal;

pub use film::film_of_log;
pub use logged_state::state_in_log;
pub use report::page_of_log;

use crate::cli::arguments::contact_args::with_values;
use crate::cli::terminal::printing::complain;
use crate::cli::terminal::signals::outlive_large_files;
use catena::session::Origin;
use clap::error::ErrorKind;
use clap::{CommandFactory, Parser, Subcommand};
use std::ffi::OsString;
use std::process::ExitCode;
use std::sync::OnceLock;

/// Simulates mechanisms of rigid bodies, given as URDF or scene files, without drift and at any order of accuracy.
#[derive(Parser)]
#[command(name = "catena", version = shell::version(), arg_required_else_help = true)]
struct CommandLine {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand)]
enum Verb {
    /// Run a robot or scene and write the motion as a ROS 2 bag (MCAP)
    #[command(after_help = examples::SIMULATE)]
    Simulate(Box<simulate::Arguments>),
    #[command(after_help = examples::MODEL)]
    /// Show the links and joints that were read, the parts left out and why, and the mechanism that will be simulated
    Model(Box<model::ModelArgs>),
    #[command(after_help = examples::LINEARIZE)]
    /// Linear equations of motion about an equilibrium or an instant: matrices, and modes with frequency and damping
    Linearize(Box<linearize::LinearizeArgs>),
    #[command(after_help = examples::SENSITIVITY)]
    /// Derivatives of a run by its start, efforts and numbers, exact through impacts and friction
    Sensitivity(Box<sensitivity::SensitivityArgs>),
    #[command(after_help = examples::INSPECT)]
    /// Look at a log: a summary, one instant, curves, a table; or compare two logs
    Inspect(Box<inspect::InspectArgs>),
    #[command(after_help = examples::REPORT)]
    /// Show the run of a log as a page in 3-D with curves and report, in one file that any browser opens
    Report(Box<report::ReportArgs>),
    #[command(after_help = examples::FILM)]
    /// Show the run of a log as a film (GIF, MP4), or as a picture of some instants (PNG)
    Film(Box<film::FilmArgs>),
    #[command(after_help = examples::REPLAY)]
    /// Re-run a log and check that the result is bit-identical
    Replay(Box<replay::ReplayArgs>),
    #[command(after_help = examples::CHART)]
    /// Draw CPU time against error, beside RK4 and DOP853 in joint coordinates
    Chart(Box<chart::ChartArgs>),
    #[command(after_help = examples::STRESS)]
    /// Draw stability maps: which step sizes work as a problem gets harder
    Stress(stress::StressArgs),
    #[command(after_help = examples::SWEEP)]
    /// Run a scene many times with varied numbers, on all cores; each run is a row of a table
    Sweep(Box<sweep::SweepArgs>),
    /// Print what a shell needs to complete command lines of catena
    #[command(after_help = examples::COMPLETIONS)]
    Completions(shell::CompletionsArgs),
    /// Write manual pages, one of the program and one of each command
    #[command(after_help = examples::MANUAL)]
    Manual(shell::ManualArgs),
}

/// The words of the command line, from the name of the program on.
static WORDS: OnceLock<Vec<OsString>> = OnceLock::new();

/// The origin of a run of this command line, as its log has it.
fn origin() -> Origin {
    let said = WORDS.get().map_or(&[][..], Vec::as_slice);
    let words: Vec<String> = said.iter().map(|word| word.to_string_lossy().into_owned()).collect();
    let arguments = words.get(1..).unwrap_or_default().to_vec();
    Origin { command_line: words.join(" "), arguments, driven: None, from_log: None }
}

/// Does what the command line of this process says.
pub fn main() -> ExitCode {
    ExitCode::from(main_of(std::env::args_os().collect()))
}

/// Does what a command line says, which begins with the name of the program; returns the exit code. Once in a process.
pub fn main_of(words: Vec<OsString>) -> u8 {
    let words = WORDS.get_or_init(|| words);
    let command_line = match CommandLine::try_parse_from(with_values(words.iter().cloned())) {
        Ok(command_line) => command_line,
        Err(error) => return usage(&error),
    };
    outlive_large_files();
    let ended = match command_line.verb {
        Verb::Simulate(arguments) => report::simulate_and_report(&arguments),
        Verb::Model(arguments) => model::run(&arguments),
        Verb::Linearize(arguments) => linearize::run(&arguments),
        Verb::Sensitivity(arguments) => sensitivity::run(&arguments),
        Verb::Inspect(arguments) => inspect::run(&arguments),
        Verb::Report(arguments) => report::run(&arguments),
        Verb::Film(arguments) => film::run(&arguments),
        Verb::Replay(arguments) => replay::run(&arguments),
        Verb::Chart(arguments) => chart::run(&arguments),
        Verb::Stress(arguments) => stress::run(&arguments),
        Verb::Sweep(arguments) => sweep::run(&arguments),
        Verb::Completions(arguments) => shell::complete(&arguments, CommandLine::command()),
        Verb::Manual(arguments) => shell::write_manual(&arguments, CommandLine::command()),
    };
    match ended {
        Ok(()) => 0,
        Err(failure) => failure.complain(),
    }
}

/// Help and version go to standard output; everything else is an error of one line.
fn usage(error: &clap::Error) -> u8 {
    match error.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => {
            // A reader that has gone away does not want the rest.
            let _ = error.print();
            0
        }
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            let _ = error.print();
            2
        }
        _ => {
            complain(&in_one_line(error));
            2
        }
    }
}

/// The defect of a command line, without the general usage.
fn in_one_line(error: &clap::Error) -> String {
    let rendered = error.render().to_string();
    let told = rendered.lines().take_while(|line| !line.starts_with("Usage:") && !line.starts_with("For more"));
    let paragraphs: Vec<&str> = told.map(str::trim).filter(|line| !line.is_empty()).collect();
    paragraphs.join(" ").trim_start_matches("error: ").replace(" tip:", ";")
}

/// The options of a `catena simulate` with these arguments.
///
/// # Errors
/// The defect of the arguments.
pub fn simulate_arguments(arguments: &[String]) -> anyhow::Result<simulate::Arguments> {
    let words = std::iter::once("catena").chain(arguments.iter().map(String::as_str));
    let parsed = CommandLine::try_parse_from(with_values(words.map(OsString::from)))
        .map_err(|error| anyhow::anyhow!(in_one_line(&error)))?;
    match parsed.verb {
        Verb::Simulate(arguments) => Ok(*arguments),
        _ => anyhow::bail!("it was not written by catena simulate"),
    }
}
