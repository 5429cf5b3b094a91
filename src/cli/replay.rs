//! `catena replay`: repeats the run of a log from the content of the log, and compares.
//!
//! A log that was cut off or whose run was interrupted is compared up to its end; one that is damaged is not the same as any run.

use crate::cli::recorded::Recorded;
use crate::cli::simulate::Setup;
use crate::cli::terminal::printing::{Failure, print};
use crate::cli::terminal::progress::Progress;
use anyhow::anyhow;
use catena::output::log::Difference;
use catena::session::{Course, DRIVEN, Model, Running};
use clap::Args;
use std::io::IsTerminal;
use std::path::PathBuf;

/// The options of `catena replay`.
#[derive(Args, Debug)]
pub struct ReplayArgs {
    /// The log
    #[arg(value_name = "LOG.mcap")]
    log: PathBuf,

    /// Print errors only
    #[arg(long)]
    quiet: bool,
}

/// Does what the arguments say.
///
/// # Errors
/// [`Failure`]: 1 if the run comes out differently or the log is damaged, 2 if the log does not tell how it was made.
pub fn run(arguments: &ReplayArgs) -> Result<(), Failure> {
    let log = &arguments.log;
    let mut recorded = Recorded::open(log).map_err(Failure::input)?;
    if let Some(by) = recorded.simulation.get(DRIVEN) {
        let error = anyhow!("{}: it cannot be made again from the log alone: {by}", log.display());
        return Err(Failure::input(error));
    }
    let setup = Setup::new(&recorded.arguments, &mut recorded.loaded).map_err(Failure::input)?;
    let Setup { state, settled, log: mut options } = setup;
    // The time of the clock at the recorded run.
    options.start = recorded.start();
    let Recorded { arguments: made_with, loaded, simulation, .. } = recorded;
    let made_by = simulation.get("version").map_or("?", String::as_str);
    let interrupt = crate::cli::terminal::signals::watch_for_signals().map_err(Failure::run)?;
    let shows = !arguments.quiet && std::io::stderr().is_terminal();
    let progress = shows.then(|| Progress::new(settled.duration));
    let counted = loaded.counted.clone();
    let model = Model::of_loaded(loaded, log.clone(), made_with.input.world.world());
    let mut run = Running::begin(Course {
        kept: made_with.input.keep,
        interrupt,
        others: progress.iter().map(Progress::boxed).collect(),
        ..Course::new(model, settled, state, counted)
    })?;
    run.compare(log, &options).map_err(Failure::run)?;
    let ended = run.run();
    progress.iter().for_each(Progress::clear);
    // A run that failed does so again, and has the same log up to there.
    if let Err(error) = ended
        && error.is_interruption()
    {
        return Err(Failure::interrupted(error));
    }
    let (compared, result) = run.compared();
    let version = env!("CARGO_PKG_VERSION");
    let (messages, time) = (compared.messages, compared.time);
    let upto = match result {
        Ok(()) => "to the end".to_string(),
        Err(Difference::LogEnded { .. }) if messages > 0 => "up to where the log ends".to_string(),
        Err(difference @ Difference::Unreadable { .. }) => {
            let before = format!("the {messages} messages before are the same");
            return Err(Failure::run(anyhow!("{}: {difference}; {before}", log.display())));
        }
        Err(difference) => {
            let versions = if made_by == version {
                String::new()
            } else {
                format!("; it was made by version {made_by}, this is {version}")
            };
            return Err(Failure::run(anyhow!("{}: different: {difference}{versions}", log.display())));
        }
    };
    if !arguments.quiet {
        print(format_args!(
            "{}: identical: {messages} messages, t = 0 to {time} s, {upto}, bit for bit\n",
            log.display()
        ))?;
    }
    Ok(())
}
