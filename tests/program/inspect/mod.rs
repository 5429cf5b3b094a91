//! `catena inspect`: what it says of a log is what the run reported.

mod another_encoding;
mod damaged;
mod whole;

use crate::common::command::{run, text};
use serde_json::Value;
use std::path::Path;

fn json(output: &std::process::Output) -> Value {
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("one JSON object")
}

/// Simulates and returns the report.
fn simulate(folder: &Path, arguments: &[&str]) -> Value {
    json(&run(folder, &[&["simulate", "pendulum.urdf", "--json", "--duration", "1.5"], arguments].concat()))
}

fn inspect(folder: &Path, arguments: &[&str]) -> Value {
    json(&run(folder, &[&["inspect", "--json"], arguments].concat()))
}
