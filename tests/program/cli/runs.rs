//! Runs as they are asked for and as they end: where the log is, steps of every kind, failure and interruption.

use crate::common::command::{ENDLESS, catena, folder, run, salvaged, salvaged_samples, text, wait_for};
use catena::output::log::reading::decode::log_line;
use serde_json::Value;
use std::process::Command;

#[test]
fn the_log_is_named_after_the_input_and_lies_in_the_current_folder() {
    let folder = folder("name");
    let input = folder.join("pendulum.urdf");
    let elsewhere = folder.join("elsewhere");
    std::fs::create_dir(&elsewhere).expect("created");
    let output = run(&elsewhere, &["simulate", &input.to_string_lossy(), "--duration", "0.5", "--quiet"]);
    assert_eq!(output.status.code(), Some(0));
    assert!(output.stdout.is_empty() && output.stderr.is_empty(), "--quiet says nothing");
    let log = std::fs::read(elsewhere.join("pendulum.mcap")).expect("a log");
    let summary = mcap::Summary::read(&log).expect("complete").expect("with a summary");
    let metadata = mcap::read::metadata(&log, &summary.metadata_indexes[0]).expect("metadata").metadata;
    for key in [
        "robot",
        "base",
        "base_pose",
        "gravity",
        "version",
        "method",
        "stages",
        "order",
        "step",
        "tolerance",
        "duration",
        "rate",
    ] {
        assert!(metadata.contains_key(key), "{key}");
    }
    assert!(metadata["command_line"].contains("--duration 0.5"));
}

#[test]
fn the_same_command_gives_the_same_bytes() {
    let folder = folder("same");
    let log = || {
        let output = run(&folder, &["simulate", "pendulum.urdf", "--duration", "20", "--velocity", "hinge=1"]);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        std::fs::read(folder.join("pendulum.mcap")).expect("a log")
    };
    assert!(log() == log());
}

/// A spin whose kinetic energy is beyond the range of doubles.
#[test]
fn a_run_that_fails_leaves_a_complete_log_that_says_why() {
    let folder = folder("failing");
    let output = run(&folder, &["simulate", "pendulum.urdf", "--velocity", "hinge=1e100", "--json"]);
    let error = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{error}");
    assert!(error.starts_with("catena: error: ") && error.lines().count() == 1, "{error}");
    serde_json::from_slice::<Value>(&output.stdout).expect("the report up to there");
    let log = std::fs::read(folder.join("pendulum.mcap")).expect("a log");
    mcap::Summary::read(&log).expect("complete").expect("with a summary");
    let lines = salvaged(&log, "/rosout");
    let last = log_line(&lines.last().expect("a line").data).expect("a line of text");
    assert_eq!(error.trim_end(), format!("catena: error: {}", last.text));
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_the_run_with_130_and_a_complete_log() {
    let folder = folder("interrupt");
    let log = folder.join("pendulum.mcap");
    let arguments = [&["simulate", "pendulum.urdf", "--velocity", "hinge=1"], &ENDLESS[..]].concat();
    let mut child = catena(&folder, &arguments).spawn().expect("runs");
    wait_for(&mut child, "a log with samples", || salvaged_samples(&log) > 10);
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill runs");
    assert!(sent.success());
    let output = child.wait_with_output().expect("ends");
    assert_eq!(output.status.code(), Some(130), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("interrupted"), "{}", text(&output.stderr));
    let bytes = std::fs::read(&log).expect("a log");
    let summary = mcap::Summary::read(&bytes).expect("complete").expect("with a summary");
    let messages = mcap::MessageStream::new(&bytes).expect("complete");
    let messages: Vec<_> = messages.collect::<Result<_, _>>().expect("every message is readable");
    assert_eq!(summary.stats.expect("statistics").message_count, messages.len() as u64);
}

#[test]
fn steps_with_32_digits_are_asked_for_with_a_step_and_named_in_the_report() {
    let folder = folder("precise");
    let arguments = ["simulate", "pendulum.urdf", "--no-log", "--precise", "--position", "hinge=2"];
    assert_eq!(run(&folder, &arguments).status.code(), Some(2));
    let fixed = [&arguments[..], &["--stages", "9", "--step", "0.02"]].concat();
    let text = String::from_utf8(run(&folder, &fixed).stdout).unwrap();
    assert!(text.contains("step 20.0 ms, 32 digits"), "{text}");
    let report: Value = serde_json::from_slice(&run(&folder, &[&fixed[..], &["--json"]].concat()).stdout).unwrap();
    assert_eq!(report["method"]["digits"], 32);
    // A scheme of order 16 is exact here but for rounding, and that of the energy at a sample is some 1e-16.
    let error = report["energy"]["max_relative_error"].as_f64().unwrap();
    assert!(error < 3e-15, "{error:.1e}");
    let refused = run(&folder, &[&arguments[..], &["--stages", "12", "--step", "0.02"]].concat());
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("at most 9 stages"));
}

#[test]
fn reversible_steps_start_from_the_given_one_and_are_refused_without_it() {
    let folder = folder("reversible");
    let arguments = ["simulate", "pendulum.urdf", "--no-log", "--reversible", "--json", "--position", "hinge=2"];
    assert_eq!(run(&folder, &arguments).status.code(), Some(2));
    let output = run(&folder, &[&arguments[..], &["--stages", "5", "--step", "0.05"]].concat());
    let report: Value = serde_json::from_slice(&output.stdout).expect("one JSON object");
    assert_eq!(report["method"]["reversible_resets"], 0);
    assert_eq!(report["method"]["adaptive"], false);
    assert_eq!(report["warnings"].as_array().unwrap().len(), 0);
}
