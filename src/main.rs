//! The command line; the work is done by the library.

mod cli;

use clap::Parser;
use std::process::ExitCode;

/// Rigid multibody simulator
#[derive(Parser)]
#[command(version)]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(clap::Subcommand)]
enum Verb {
    Model(cli::model::ModelArgs),
}

fn main() -> ExitCode {
    let Verb::Model(args) = Cli::parse().verb;
    match cli::model::run(&args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("catena: {error:#}");
            ExitCode::from(2)
        }
    }
}
