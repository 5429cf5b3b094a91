//! The report has the keys and the values of the run that was asked for, and is alone on standard output.

use crate::common::command::{catena, folder, run, text};
use serde_json::Value;

#[test]
fn json_has_every_key_of_the_interface_and_is_alone_on_standard_output() {
    let folder = folder("json");
    let output = run(&folder, &["simulate", "pendulum.urdf", "--json", "--duration", "0.5"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(output.stderr.is_empty(), "{}", text(&output.stderr));
    let report: Value = serde_json::from_slice(&output.stdout).expect("one JSON object");
    let expected: Value = serde_json::from_str(
        r#"{
        "catena": "", "input": "", "scene": "", "start": 0, "duration": 0,
        "method": {"stages": 0, "order": 0, "step": 0, "adaptive": true, "tolerance": 0,
            "max_frequency_step": null, "digits": 16, "reversible_resets": null,
            "crowd": {"steps": 0, "time_share": 0, "order": 0, "worst_residual": 0, "asleep_share": 0, "lift": 0},
            "over_slips": {"steps": 0, "time_share": 0, "order": 0}, "few_stage_steps": 0, "contact_solvers": {}},
        "model": {"links": 0, "bodies": 0, "joints": 0, "degrees_of_freedom": 0, "loops": 0, "redundant_constraints": 0,
            "islands": 0, "sleeping_islands": 0},
        "steps": 0, "iterations": 0, "kept_factor_iterations": 0, "rejected_steps": 0,
        "rejected": {"not_converged": 0, "turned_too_far": 0, "not_smooth": 0, "energy_jump": 0, "event_at_start": 0,
            "force_jump": 0, "slip_turned": 0, "overlap": 0, "unseen": 0, "off_balance": 0},
        "located_attempts": 0, "exact_newton_steps": 0,
        "wall_seconds": 0, "cpu_seconds": 0, "solve_cpu_seconds": 0,
        "events": {"counts": {"limit_impact": 0, "contact_impact": 0, "rest": 0, "release": 0, "stick": 0, "slip": 0,
            "reversal": 0, "saturation": 0, "unsaturation": 0}, "list": []},
        "contact": {"max_penetration": 0, "max_cone_violation": 0, "points": []},
        "energy": {"initial": 0, "final": 0, "max_relative_error": 0,
            "parts": {"kinetic": 0, "gravity": 0, "spring": 0, "load": 0}, "dissipated": 0, "friction": 0,
            "impacts": 0, "work": 0},
        "constraint": {"max_position": 0, "max_velocity": 0},
        "links": {
            "base": {"position": [0,0,0], "orientation": [0,0,0,0], "center_of_mass": [0,0,0],
                     "linear_velocity": [0,0,0], "angular_velocity": [0,0,0]},
            "rod": {"position": [0,0,0], "orientation": [0,0,0,0], "center_of_mass": [0,0,0],
                    "linear_velocity": [0,0,0], "angular_velocity": [0,0,0]},
            "tip": {"position": [0,0,0], "orientation": [0,0,0,0], "center_of_mass": [0,0,0],
                    "linear_velocity": [0,0,0], "angular_velocity": [0,0,0]}},
        "joints": {
            "hinge": {"position": 0, "velocity": 0, "reaction_force": [0,0,0], "reaction_torque": [0,0,0],
                "limit": null, "friction": null, "effort": null}},
        "accuracy": {"wanted": 0, "estimated": 0, "between_steps": 0, "holds_until": 0, "told_until": 0, "reached": true, "horizon": null, "begun": 0},
        "warnings": []}"#,
    )
    .expect("JSON");
    assert_same_shape(&expected, &report, "report");
}

/// Same keys, same kinds of values, arrays of the same length.
fn assert_same_shape(expected: &Value, got: &Value, place: &str) {
    match (expected, got) {
        (Value::Object(expected), Value::Object(got)) => {
            let keys = |object: &serde_json::Map<String, Value>| object.keys().cloned().collect::<Vec<_>>();
            assert_eq!(keys(expected), keys(got), "{place}");
            for (key, value) in expected {
                assert_same_shape(value, &got[key], &format!("{place}.{key}"));
            }
        }
        (Value::Array(expected), Value::Array(got)) => {
            assert_eq!(expected.len(), got.len(), "{place}");
            for (expected, got) in expected.iter().zip(got) {
                assert_same_shape(expected, got, place);
            }
        }
        _ => assert_eq!(std::mem::discriminant(expected), std::mem::discriminant(got), "{place}: {got}"),
    }
}

#[test]
fn the_report_says_how_many_iterations_kept_their_factors() {
    let folder = folder("kept");
    let robot = |name: &str| format!("{}/robots/{name}", env!("CARGO_MANIFEST_DIR"));
    for (input, some) in [(robot("arm7.urdf"), true), (robot("four_bar_1.toml"), false)] {
        let arguments = ["simulate", input.as_str(), "--no-log", "--duration", "0.5"];
        let report = run(&folder, &[&arguments[..], &["--json"]].concat());
        let report: Value = serde_json::from_slice(&report.stdout).expect("one JSON object");
        let [all, kept] = ["iterations", "kept_factor_iterations"].map(|key| report[key].as_u64().expect("a count"));
        // Every step begins with factors of its own; the exact Newton method of a loop keeps none.
        assert!(kept < all && (kept > 0) == some, "{input}: {kept} of {all}");
        let lines = run(&folder, &arguments);
        assert_eq!(text(&lines.stdout).contains(" % reuse a factorisation)"), some, "{input}: {}", text(&lines.stdout));
    }
}

/// A rod without gravity turns evenly: the fused tip goes with it, and the joint pulls it inwards.
#[test]
fn the_report_is_of_the_end_of_the_run_that_was_asked_for() {
    let folder = folder("values");
    let arguments = ["--no-log", "--json", "--duration", "0.25", "--stages", "4", "--step", "0.001"];
    let start = ["--position", "hinge=0.5", "--velocity", "hinge=-2", "--gravity", "0,0,0"];
    let output = run(&folder, &[&["simulate", "pendulum.urdf"], &arguments[..], &start[..]].concat());
    let report: Value = serde_json::from_slice(&output.stdout).expect("one JSON object");
    assert_eq!(report["duration"], 0.25);
    assert_eq!(report["steps"], 250);
    assert!(!folder.join("pendulum.mcap").exists(), "--no-log writes no log");
    let near = |value: &Value, expected: f64| {
        let value = value.as_f64().expect("a number");
        assert!((value - expected).abs() < 1e-9, "{value} is not {expected}");
    };
    // Without gravity the angle is 0.5 − 2 t, and the rod pulls inwards with m r ω².
    near(&report["joints"]["hinge"]["position"], 0.0);
    near(&report["joints"]["hinge"]["velocity"], -2.0);
    near(&report["joints"]["hinge"]["reaction_force"][2], 2.0);
    near(&report["links"]["tip"]["position"][2], -1.0);
    near(&report["links"]["rod"]["position"][2], 0.0);
    near(&report["links"]["rod"]["center_of_mass"][2], -0.5);
    near(&report["links"]["rod"]["linear_velocity"][0], 1.0);
    near(&report["links"]["tip"]["angular_velocity"][1], -2.0);
}

#[test]
fn the_report_counts_the_steps_that_the_exact_newton_method_solved() {
    let folder = folder("exact");
    let loops = concat!(env!("CARGO_MANIFEST_DIR"), "/robots/four_bar_1.toml");
    for (input, words) in [("pendulum.urdf", " rejected"), (loops, ", all STEPS by the exact Newton method\n")] {
        let arguments = ["simulate", input, "--no-log", "--duration", "0.5"];
        let report = run(&folder, &[&arguments[..], &["--json"]].concat());
        let report: Value = serde_json::from_slice(&report.stdout).expect("one JSON object");
        let all = if input == loops { report["steps"].as_u64() } else { Some(0) };
        assert_eq!(report["exact_newton_steps"].as_u64(), all, "{input}");
        let by_reason = report["rejected"].as_object().expect("a number for each reason");
        let sum: u64 = by_reason.values().filter_map(Value::as_u64).sum();
        assert_eq!(report["rejected_steps"].as_u64(), Some(sum), "{input}");
        let lines = run(&folder, &arguments);
        assert!(input == loops || !text(&lines.stdout).contains("exact Newton"), "{}", text(&lines.stdout));
        let words = words.replace("STEPS", &report["steps"].to_string());
        assert!(text(&lines.stdout).contains(&words), "{input}: {}", text(&lines.stdout));
    }
}

#[test]
fn a_floating_base_reports_seven_positions_and_six_velocities() {
    let folder = folder("floating");
    let motion = ["--base", "floating", "--base-velocity", "1,0,0,0,0,0", "--gravity", "0,0,0"];
    let arguments = ["simulate", "pendulum.urdf", "--no-log", "--json", "--duration", "1"];
    let output = run(&folder, &[&arguments[..], &motion[..]].concat());
    let report: Value = serde_json::from_slice(&output.stdout).expect("one JSON object");
    let joints = report["joints"].as_object().expect("an object");
    let (_, base) = joints.iter().find(|(name, _)| *name != "hinge").expect("the base is a joint");
    assert_eq!(base["position"].as_array().map(Vec::len), Some(7));
    assert_eq!(base["velocity"].as_array().map(Vec::len), Some(6));
    assert!((base["position"][0].as_f64().expect("a number") - 1.0).abs() < 1e-9, "{base}");
}

#[test]
fn a_reader_of_the_report_may_go_away() {
    let folder = folder("pipe");
    let mut child = catena(&folder, &["simulate", "pendulum.urdf", "--duration", "1", "--json"]).spawn().expect("runs");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("ends");
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(output.stderr.is_empty(), "{}", text(&output.stderr));
}

#[test]
fn help_and_version_go_to_standard_output() {
    let folder = folder("help");
    for arguments in [&["--help"][..], &["--version"], &["simulate", "--help"]] {
        let output = run(&folder, arguments);
        assert_eq!(output.status.code(), Some(0));
        assert!(output.stderr.is_empty() && !output.stdout.is_empty(), "{arguments:?}");
    }
}

#[test]
fn a_step_longer_than_the_run_is_reported_as_long_as_it_is_made() {
    let folder = folder("long_step");
    let way = ["--position", "hinge=0.1", "--duration", "0.01", "--stages", "4", "--step", "100"];
    let output = run(&folder, &[&["simulate", "pendulum.urdf", "--json"], &way[..]].concat());
    let report: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!((&report["method"]["step"], &report["steps"]), (&0.01.into(), &1.into()), "{}", report["method"]);
    let summary = run(&folder, &["inspect", "pendulum.mcap", "--json"]);
    let summary: Value = serde_json::from_slice(&summary.stdout).expect("JSON");
    assert_eq!(summary["simulation"]["step"], "0.01");
    assert_eq!(run(&folder, &["replay", "pendulum.mcap"]).status.code(), Some(0));
}
