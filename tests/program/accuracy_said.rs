//! What a run says of its accuracy: an estimate, or the reason why there is none.

use crate::common::command::{folder, run, text};
use crate::common::{scratch, shared};
use serde_json::Value;
use std::path::Path;

fn json(bytes: &[u8]) -> Value {
    serde_json::from_slice(bytes).expect("a report")
}

/// A wild motion of seven bodies in steps that are far too long, which nobody has chosen: 0.60 m off after 0.87 s.
fn fast(folder: &Path, arguments: &[&str]) -> Value {
    let given = std::fs::read_to_string(folder.join("fast.args")).expect("an input");
    let all = ["simulate", "fast.urdf", "--no-log", "--json"];
    let all: Vec<&str> = all.into_iter().chain(given.split_whitespace()).chain(arguments.iter().copied()).collect();
    let output = run(folder, &all);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    json(&output.stdout)
}

fn warns(report: &Value) -> bool {
    let warnings = report["warnings"].as_array().expect("a list");
    warnings
        .iter()
        .any(|warning| warning.as_str().is_some_and(|words| words.contains("are too long: the estimated error")))
}

#[test]
fn fixed_steps_that_leave_more_than_a_millimetre_are_warned_of() {
    let Some(inputs) = shared("repro") else { return };
    let report = fast(&inputs, &["--stages", "5", "--step", "0.01"]);
    assert_eq!(report["step_error"]["by"], "energy");
    assert!(warns(&report), "{report}");
    assert!(report["accuracy"].is_null() && report["accuracy_unknown"].is_string(), "{report}");
    // Steps of an eighth are good to 1e-7 m.
    let report = fast(&inputs, &["--stages", "9", "--step", "0.00125"]);
    assert!(!warns(&report), "{report}");
    assert!(report["step_error"]["estimated"].as_f64().is_some_and(|error| error < 1e-3), "{report}");
}

#[test]
fn half_the_step_tells_what_fixed_steps_have_left() {
    let Some(inputs) = shared("repro") else { return };
    let report = fast(&inputs, &["--stages", "5", "--step", "0.01", "--check"]);
    assert_eq!(report["step_error"]["by"], "half the step");
    let estimated = report["step_error"]["estimated"].as_f64().expect("a number");
    // 0.60 m from the truth; half the step is 5e-3 m from it.
    assert!((0.55..0.65).contains(&estimated), "{estimated}");
    assert!(warns(&report), "{report}");
    let folder = folder("calm");
    let arguments = ["simulate", "pendulum.urdf", "--no-log", "--json", "--duration", "2", "--velocity", "hinge=1"];
    let output = run(&folder, &[&arguments[..], &["--stages", "5", "--step", "0.05", "--check"]].concat());
    let report = json(&output.stdout);
    assert!(
        report["step_error"]["estimated"].as_f64().is_some_and(|error| error < 1e-6) && !warns(&report),
        "{report}"
    );
}

#[test]
fn an_accuracy_that_is_not_known_has_its_reason() {
    let folder = scratch("unknown");
    let pendulum = crate::common::command::PENDULUM;
    std::fs::write(folder.join("pendulum.urdf"), pendulum).expect("written");
    // A spin whose kinetic energy is beyond the range of doubles: no step gets anywhere.
    let output = run(&folder, &["simulate", "pendulum.urdf", "--velocity", "hinge=1e100", "--no-log", "--json"]);
    let report = json(&output.stdout);
    assert!(report["accuracy"].is_null());
    let reason = report["accuracy_unknown"].as_str().expect("a reason");
    assert_eq!(reason, "the run ended before anything was known of its error");
    let people = run(&folder, &["simulate", "pendulum.urdf", "--velocity", "hinge=1e100", "--no-log"]);
    assert!(text(&people.stdout).contains("accuracy    not known: the run ended"), "{}", text(&people.stdout));
}
