//! `catena replay`: repeats the run of a log from the content of the log, and compares.
//!
//! A log that was cut off or whose run was interrupted is compared up to its end; one that is damaged is not the same as any run.

use crate::cli::recorded::Recorded;
use crate::cli::simulate::Setup;
use crate::cli::terminal::printing::{Failure, print};
use crate::cli::terminal::progress::Progress;
use anyhow::anyhow;
use catena::output::log::{Difference, Recorder};
use catena::session::{DRIVEN, Error, Settled};
use catena::simulation::{RunError, Simulation, SimulationOptions};
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
    let Settled { duration, choice, rate } = settled;
    // The time of the clock at the recorded run.
    options.start = recorded.start();
    let made_by = recorded.simulation.get("version").map_or("?", String::as_str);
    let model = &recorded.loaded.model;
    let interrupted = crate::cli::terminal::signals::watch_for_signals().map_err(Failure::run)?;
    let switched_off = &recorded.arguments.input.keep[..];
    let (mut recorder, mut progress);
    let (interrupt, counted) = (Some(&*interrupted), recorded.loaded.counted.as_ref());
    let options_of_run =
        SimulationOptions { switched_off, interrupt, counted, ..SimulationOptions::new(duration, choice) };
    let mut simulation = Simulation::new(&model.mechanism, state, options_of_run).map_err(Error::from)?;
    let stages = simulation.description().stages as f64;
    recorder = Recorder::compare(log, model, stages, &options).map_err(Failure::run)?;
    if simulation.tells_at_once() {
        recorder.wait_for_the_end();
    }
    simulation.sample_at(rate);
    simulation.observe(&mut recorder);
    progress = (!arguments.quiet && std::io::stderr().is_terminal()).then(|| Progress::new(duration));
    progress.iter_mut().for_each(|progress| simulation.observe(progress));
    let ended = simulation.run();
    drop(simulation);
    progress.iter().for_each(Progress::clear);
    let (compared, result) = recorder.compared();
    match ended {
        Err(error @ RunError::Interrupted { .. }) => return Err(Failure::interrupted(error)),
        // A run that failed does so again, and has the same log up to there.
        Ok(())
        | Err(
            RunError::Step(_)
            | RunError::Undefined { .. }
            | RunError::PaidOut { .. }
            | RunError::Observer(_)
            | RunError::BeginsAgain { .. },
        ) => {}
    }
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
