//! `catena linearize`: its keys, and instants and orbits of logs as of robots.

use crate::common::command::{folder, run, text};
use serde_json::Value;
use std::path::Path;

fn json(folder: &Path, words: &[&str]) -> Value {
    let output = run(folder, words);
    assert_eq!(output.status.code(), Some(0), "{words:?}: {}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("one JSON object")
}

/// The numbers of a list, or of a list of lists.
fn numbers(of: &Value) -> Vec<f64> {
    match of.as_array() {
        Some(all) => all.iter().flat_map(numbers).collect(),
        None => vec![of.as_f64().expect("a number")],
    }
}

#[test]
fn linearize_has_the_derivatives_of_its_eigenvalues_and_multipliers_in_json() {
    let folder = folder("linearize_json");
    let report = |more: &[&str]| -> Value {
        let words = [&["linearize", "pendulum.urdf", "--json"], more].concat();
        let output = run(&folder, &words);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        serde_json::from_slice(&output.stdout).expect("one JSON object")
    };
    let linear = report(&["--by", "gravity.z", "--discrete", "0.1"]);
    let by = &linear["by"][0];
    assert_eq!(by["key"], "gravity.z");
    assert_eq!(linear["velocities"], linear["coordinates"]);
    for kind in ["sticking_contacts", "rolling_contacts", "sliding_contacts"] {
        assert_eq!(linear[kind], 0, "{kind}");
    }
    let (frequency, slope) = (&linear["modes"][0]["frequency"], &by["modes"][0]["frequency"]);
    // f goes with the root of g.
    let ratio = slope.as_f64().expect("a slope") / frequency.as_f64().expect("a frequency");
    assert!((ratio - 1.0 / (2.0 * -9.81)).abs() < 1e-10, "{ratio}");
    let orbit = report(&["--orbit", "0.5"]);
    assert!(orbit["period"] == 0.5 && orbit["apart"].is_number() && orbit["warnings"].is_array(), "{orbit}");
    for key in ["multiplier", "size", "turn", "growth"] {
        assert!(orbit["multipliers"][0].get(key).is_some(), "{key}: {orbit}");
    }
    let both = run(&folder, &["linearize", "pendulum.urdf", "--orbit", "1", "--at", "rest"]);
    assert_eq!(both.status.code(), Some(2));
}

/// A rod on a hinge, and motors that hold it.
const HELD: [&str; 4] = ["--hold=kp=30,kd=1", "--position=hinge=1", "--velocity=hinge=3", "--json"];

fn held<'w>(words: &[&'w str]) -> Vec<&'w str> {
    words.iter().copied().chain(HELD).collect()
}

#[test]
fn orbits_go_on_from_an_instant_of_a_log_as_from_one_of_a_run() {
    let folder = folder("linearize_orbit");
    json(&folder, &held(&["simulate", "pendulum.urdf", "--duration=1", "--tolerance=1e-10", "-o", "held.mcap"]));
    let of_log = json(&folder, &["linearize", "held.mcap", "--at", "0.5", "--orbit", "0.4", "--json"]);
    let of_run = json(&folder, &held(&["linearize", "pendulum.urdf", "--at", "0.5", "--orbit", "0.4"]));
    for report in [&of_log, &of_run] {
        assert!((report["time"].as_f64().expect("a time") - 0.5).abs() < 1e-9, "{report}");
    }
    let [of_log, of_run] = [of_log, of_run].map(|report| {
        let values = report["multipliers"].as_array().expect("multipliers").iter();
        values.flat_map(|value| numbers(&value["multiplier"])).collect::<Vec<f64>>()
    });
    assert_eq!(of_log.len(), 4);
    for (one, other) in of_log.iter().zip(&of_run) {
        // The instants are apart by the tolerance of the run to 0.5 s, 1e-6 m.
        assert!((one - other).abs() < 1e-5, "{of_log:?} {of_run:?}");
    }
    let at_rest = run(&folder, &["linearize", "held.mcap", "--orbit", "1", "--at", "rest"]);
    assert_eq!(at_rest.status.code(), Some(2), "{}", text(&at_rest.stderr));
}

#[test]
fn frequencies_have_derivatives_at_an_instant_of_a_log() {
    let folder = folder("linearize_by");
    let free = ["--position=hinge=1", "--velocity=hinge=0.5", "--json"];
    json(&folder, &[&["simulate", "pendulum.urdf", "--duration=1", "-o", "free.mcap"][..], &free].concat());
    let of_log = |at: &str, log: &str| json(&folder, &["linearize", log, "--at", at, "--by", "gravity.z", "--json"]);
    let slope = |report: &Value| report["by"][0]["modes"][0]["frequency"].as_f64().expect("a slope");
    let frequency = |report: &Value| report["modes"][0]["frequency"].as_f64().expect("a frequency");
    for at in ["0.3", "end", "rest"] {
        let report = of_log(at, "free.mcap");
        // ω² = m g l cos(q)/I at a given angle: f goes with the root of g.
        let ratio = slope(&report) / frequency(&report);
        assert!((ratio - 1.0 / (2.0 * -9.81)).abs() < 1e-9, "{at}: {ratio}");
    }
    // Motors that hold the rod where the run has started keep their targets: the equilibrium moves with gravity.
    json(&folder, &[&["simulate", "pendulum.urdf", "--duration=1", "-o", "held.mcap"][..], &HELD].concat());
    let held = of_log("rest", "held.mcap");
    let at = |gravity: &str| {
        let words = ["linearize", "pendulum.urdf", "--set", gravity];
        json(&folder, &[&words[..], &HELD].concat())
    };
    let ends = [at("gravity.z=-9.82"), at("gravity.z=-9.80")].map(|report| frequency(&report));
    let difference = (ends[1] - ends[0]) / 0.02;
    // Differences over 0.02 m/s²: the third derivative of a frequency near 1 Hz, and 1e-4 of it.
    assert!((slope(&held) - difference).abs() < 1e-6, "{} and {difference}", slope(&held));
}
