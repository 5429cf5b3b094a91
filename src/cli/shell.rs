//! Shell completions, manual pages and the version.

use crate::cli::terminal::printing::Failure;
use anyhow::Context;
use catena::kernels::instructions;
use clap::{Args, Command};
use std::path::PathBuf;
use std::sync::OnceLock;

/// The options of `catena completions`.
#[derive(Args, Debug)]
pub struct CompletionsArgs {
    /// The shell
    #[arg(value_enum)]
    shell: clap_complete::Shell,
}

/// The options of `catena manual`.
#[derive(Args, Debug)]
pub struct ManualArgs {
    /// The folder for the pages; it is made if it is not there
    #[arg(value_name = "DIR", value_parser = crate::cli::arguments::outputs::output_folder())]
    folder: PathBuf,
}

/// The version, with the commit where the build was told it (`CATENA_COMMIT`), and the vectors of this processor that are used.
pub fn version() -> &'static str {
    static VERSION: OnceLock<String> = OnceLock::new();
    VERSION.get_or_init(|| {
        let commit = option_env!("CATENA_COMMIT").map_or_else(String::new, |commit| format!("commit {commit}, "));
        format!("{} ({commit}{})", env!("CARGO_PKG_VERSION"), instructions())
    })
}

/// Prints the completions of a shell.
///
/// # Errors
/// An error if standard output cannot be written.
pub fn complete(arguments: &CompletionsArgs, mut command: Command) -> Result<(), Failure> {
    let mut text = Vec::new();
    clap_complete::generate(arguments.shell, &mut command, "catena", &mut text);
    crate::cli::terminal::printing::print(String::from_utf8_lossy(&text))
}

/// Writes the manual pages into a folder.
///
/// # Errors
/// [`Failure`] names the folder that cannot be written.
pub fn write_manual(arguments: &ManualArgs, command: Command) -> Result<(), Failure> {
    let folder = &arguments.folder;
    crate::cli::arguments::outputs::make_folder(folder).map_err(Failure::input)?;
    let written = clap_mangen::generate_to(command, folder);
    written.with_context(|| format!("cannot write manual pages into {}", folder.display())).map_err(Failure::run)
}
