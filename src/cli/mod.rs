//! The command line: which verb, what it prints, and the exit code.
//!
//! | exit code | meaning                                                                  |
//! |-----------|--------------------------------------------------------------------------|
//! | 0         | done                                                                     |
//! | 1         | failed part-way; what was written up to there is complete and readable   |
//! | 2         | bad usage or bad input; nothing was written                              |
//! | 130       | interrupted; what was written is complete                                |
//!
//! Errors are one line on standard error, `catena: error: …`, so that scripts can show them as they are.

mod chart;
mod check;
mod contact_args;
mod contact_tables;
mod couplings;
mod examples;
mod input;
mod inspect;
mod inspect_files;
mod inspect_follow;
mod joint_tables;
mod log_options;
mod model;
mod numbers;
mod page_files;
mod progress;
mod recorded;
mod replay;
mod report;
mod rules;
mod shell;
mod simulate;
mod special_output;
mod stress;
mod sweep;
mod table;

pub use report::page_of_log;

use crate::cli::contact_args::with_heights;
use anstyle::{AnsiColor, Effects, Style};
use anyhow::Context;
use catena::session::{Error, Origin};
use clap::builder::{PathBufValueParser, TypedValueParser};
use clap::error::ErrorKind;
use clap::{CommandFactory, Parser, Subcommand};
use serde::Serialize;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use std::ffi::OsString;
use std::fmt::Display;
use std::io::{self, Write};
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

/// What asks a process to end.
const ENDING_SIGNALS: &[i32] = &[
    SIGINT,
    SIGTERM,
    #[cfg(unix)]
    signal_hook::consts::SIGHUP,
];

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
    /// Show what was read, what was left out and why, and what will be simulated
    Model(Box<model::ModelArgs>),
    #[command(after_help = examples::INSPECT)]
    /// Look at a log: a summary, one instant, curves, a table; or compare two logs
    Inspect(Box<inspect::InspectArgs>),
    #[command(after_help = examples::REPORT)]
    /// Show the run of a log as a page in 3-D with curves and report, in one file that any browser opens
    Report(Box<report::ReportArgs>),
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

/// Why a verb did not do what it was asked for.
#[derive(Debug)]
pub struct Failure {
    exit_code: u8,
    error: anyhow::Error,
}

impl Failure {
    /// Bad usage or bad input: nothing was written.
    pub fn input(error: impl Into<anyhow::Error>) -> Self {
        Failure { exit_code: 2, error: error.into() }
    }

    /// Failed part-way.
    pub fn run(error: impl Into<anyhow::Error>) -> Self {
        Failure { exit_code: 1, error: error.into() }
    }

    /// Interrupted by the user.
    pub fn interrupted(error: impl Into<anyhow::Error>) -> Self {
        Failure { exit_code: 130, error: error.into() }
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        let exit_code = match &error {
            error if error.is_interruption() => 130,
            error if error.is_input() => 2,
            _ => 1,
        };
        Failure { exit_code, error: error.into() }
    }
}

/// The words of the command line, from the name of the program on.
static WORDS: OnceLock<Vec<OsString>> = OnceLock::new();

/// What a log says of its run on this command line.
fn origin() -> Origin {
    let said = WORDS.get().map_or(&[][..], Vec::as_slice);
    let words: Vec<String> = said.iter().map(|word| word.to_string_lossy().into_owned()).collect();
    let arguments = words.get(1..).unwrap_or_default().to_vec();
    Origin { command_line: words.join(" "), arguments, driven: None }
}

/// Does what the command line of this process says.
pub fn main() -> ExitCode {
    ExitCode::from(main_of(std::env::args_os().collect()))
}

/// Does what a command line says, which begins with the name of the program; returns the exit code. Once in a process.
pub fn main_of(words: Vec<OsString>) -> u8 {
    let words = WORDS.get_or_init(|| words);
    let command_line = match CommandLine::try_parse_from(with_heights(words.iter().cloned())) {
        Ok(command_line) => command_line,
        Err(error) => return usage(&error),
    };
    outlive_large_files();
    let ended = match command_line.verb {
        Verb::Simulate(arguments) => report::simulate_and_report(&arguments),
        Verb::Model(arguments) => model::run(&arguments),
        Verb::Inspect(arguments) => inspect::run(&arguments),
        Verb::Report(arguments) => report::run(&arguments),
        Verb::Replay(arguments) => replay::run(&arguments),
        Verb::Chart(arguments) => chart::run(&arguments),
        Verb::Stress(arguments) => stress::run(&arguments),
        Verb::Sweep(arguments) => sweep::run(&arguments),
        Verb::Completions(arguments) => shell::complete(&arguments, CommandLine::command()),
        Verb::Manual(arguments) => shell::write_manual(&arguments, CommandLine::command()),
    };
    match ended {
        Ok(()) => 0,
        Err(failure) => {
            complain(&format!("{:#}", failure.error));
            failure.exit_code
        }
    }
}

/// Help and version go to standard output; everything else is an error of one line.
fn usage(error: &clap::Error) -> u8 {
    match error.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => {
            // A reader that has gone away has seen what it wanted.
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

/// What is wrong with a command line, without how it should look in general.
fn in_one_line(error: &clap::Error) -> String {
    let rendered = error.render().to_string();
    let told = rendered.lines().take_while(|line| !line.starts_with("Usage:") && !line.starts_with("For more"));
    let paragraphs: Vec<&str> = told.map(str::trim).filter(|line| !line.is_empty()).collect();
    paragraphs.join(" ").trim_start_matches("error: ").replace(" tip:", ";")
}

/// The options of a `catena simulate` with these arguments.
///
/// # Errors
/// What is wrong with them.
pub fn simulate_arguments(arguments: &[String]) -> anyhow::Result<simulate::Arguments> {
    let words = std::iter::once("catena").chain(arguments.iter().map(String::as_str));
    let parsed = CommandLine::try_parse_from(with_heights(words.map(OsString::from)))
        .map_err(|error| anyhow::anyhow!(in_one_line(&error)))?;
    match parsed.verb {
        Verb::Simulate(arguments) => Ok(*arguments),
        _ => anyhow::bail!("it was not written by catena simulate"),
    }
}

/// A file to write.
///
/// # Errors
/// For `-`, by which users mean standard output, where nothing can be renamed to or sought in.
pub fn output_file() -> impl TypedValueParser<Value = PathBuf> {
    not_standard_output("standard output is not supported; give a file, ./- if it shall have this name")
}

/// A folder to write into.
///
/// # Errors
/// As [`output_file`]: several files go nowhere else.
pub fn output_folder() -> impl TypedValueParser<Value = PathBuf> {
    not_standard_output("several files cannot go to standard output; give a folder, ./- if it shall have this name")
}

fn not_standard_output(otherwise: &'static str) -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(move |path| if path.as_os_str() == "-" { Err(otherwise) } else { Ok(path) })
}

/// Colours on terminals, those that clap's own messages have; none where NO_COLOR is set, or nobody looks.
const ERROR: Style = AnsiColor::Red.on_default().effects(Effects::BOLD);
const WARNING: Style = AnsiColor::Yellow.on_default().effects(Effects::BOLD);

/// Prints an error on one line.
fn complain(message: &str) {
    let line = message.split_whitespace().collect::<Vec<_>>().join(" ");
    // If standard error is closed there is nobody left to tell.
    let _ = writeln!(anstream::stderr(), "catena: {ERROR}error:{ERROR:#} {line}");
}

/// Prints a warning.
pub fn warn(message: impl Display) {
    // As for errors.
    let _ = writeln!(anstream::stderr(), "catena: {WARNING}warning:{WARNING:#} {message}");
}

/// Writes to standard output; a reader that has gone away is no error.
///
/// # Errors
/// Whatever else keeps standard output from being written.
pub fn print(text: impl Display) -> Result<(), Failure> {
    print_while_read(text).map(drop)
}

/// Writes to standard output; breaks off if the reader has gone away.
///
/// # Errors
/// As [`print`].
pub fn print_while_read(text: impl Display) -> Result<ControlFlow<()>, Failure> {
    let mut out = io::stdout().lock();
    match write!(out, "{text}").and_then(|()| out.flush()) {
        Ok(()) => Ok(ControlFlow::Continue(())),
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(ControlFlow::Break(())),
        Err(error) => Err(Failure::run(anyhow::Error::new(error).context("cannot write to standard output"))),
    }
}

/// Writes a value to standard output as JSON, for people too.
///
/// # Errors
/// As [`print`].
pub fn print_json(value: &impl Serialize) -> Result<(), Failure> {
    let json = serde_json::to_string_pretty(value).map_err(Failure::run)?;
    print(format_args!("{json}\n"))
}

/// Makes a file that has reached the size the system allows an error of the write, like a full disk, not the end of the process.
#[cfg(unix)]
fn outlive_large_files() {
    // Where the system does not let us, the process ends as it would anyway.
    let _ = flag::register(signal_hook::consts::SIGXFSZ, Arc::default());
}

#[cfg(not(unix))]
fn outlive_large_files() {}

/// After the first Ctrl-C a second one ends the process, but not at once: `timeout` sends its signal to the process and to its group.
const PATIENCE: Duration = Duration::from_millis(500);

/// A flag that the first Ctrl-C (or request to end) sets; a second one, half a second later, ends the process.
///
/// # Errors
/// If the system does not let us watch.
pub fn watch_for_signals() -> anyhow::Result<Arc<AtomicBool>> {
    let [interrupted, impatient] = [(); 2].map(|()| Arc::new(AtomicBool::new(false)));
    let watch = || -> io::Result<()> {
        for &signal in ENDING_SIGNALS {
            flag::register_conditional_shutdown(signal, 130, impatient.clone())?;
            flag::register(signal, interrupted.clone())?;
        }
        let seen = interrupted.clone();
        std::thread::Builder::new().name("signals".to_string()).spawn(move || {
            while !seen.load(Ordering::Relaxed) {
                std::thread::sleep(PATIENCE / 5);
            }
            std::thread::sleep(PATIENCE);
            impatient.store(true, Ordering::Relaxed);
        })?;
        Ok(())
    };
    watch().context("cannot watch for Ctrl-C")?;
    Ok(interrupted)
}
