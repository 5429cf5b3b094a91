//! Output on the terminal: results on standard output, errors and warnings on standard error, and the reasons of failures.

use anstyle::{AnsiColor, Effects, Style};
use catena::session::Error;
use serde::Serialize;
use std::fmt::Display;
use std::io::{self, Write};
use std::ops::ControlFlow;

/// The failure of a verb.
#[derive(Debug)]
pub struct Failure {
    exit_code: u8,
    error: anyhow::Error,
}

impl Failure {
    /// Bad usage or bad input: no file was written.
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

    /// Says why, on standard error; the exit code.
    pub fn complain(&self) -> u8 {
        complain(&format!("{:#}", self.error));
        self.exit_code
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

/// Colours on terminals, as in clap's own messages; output has no colours with NO_COLOR or without a terminal.
const ERROR: Style = AnsiColor::Red.on_default().effects(Effects::BOLD);
const WARNING: Style = AnsiColor::Yellow.on_default().effects(Effects::BOLD);

/// Prints an error on one line.
pub fn complain(message: &str) {
    let line = message.split_whitespace().collect::<Vec<_>>().join(" ");
    // If standard error is closed, the message is lost.
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
