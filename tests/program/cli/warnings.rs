//! A start or a step that the user may not have meant is a warning that says what it is, and what would be better.

use crate::common::command::{PENDULUM, folder, run, text};
use serde_json::Value;

#[test]
fn a_start_outside_the_limits_is_one_warning_with_joint_value_and_limits() {
    let folder = folder("limits");
    let limited = "type=\"revolute\"><limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/>";
    std::fs::write(folder.join("limited.urdf"), PENDULUM.replace("type=\"continuous\">", limited)).expect("written");
    let warnings = |position: &str| {
        let output = run(
            &folder,
            &["simulate", "limited.urdf", "--no-log", "--json", "--duration", "0.1", "--position", position],
        );
        let report: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        report["warnings"].to_string()
    };
    let outside = "limited.urdf: joint \\\"hinge\\\": it starts at 3 rad, outside its limits -1 to 1 rad";
    assert!(warnings("hinge=3").contains(outside), "{}", warnings("hinge=3"));
    assert!(!warnings("hinge=1").contains("outside its limits"), "{}", warnings("hinge=1"));
}

#[test]
fn a_body_on_a_fixed_base_is_a_warning_that_says_how_to_let_it_move() {
    let folder = folder("nothing_moves");
    let body = "<robot name=\"body\"><link name=\"body\"><inertial><mass value=\"1\"/>\
                <inertia ixx=\"1\" iyy=\"1\" izz=\"1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link></robot>";
    std::fs::write(folder.join("body.urdf"), body).expect("written");
    let warnings = |base: &str| {
        let output =
            run(&folder, &["simulate", "body.urdf", "--no-log", "--json", "--duration", "0.1", "--base", base]);
        let report: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        report["warnings"].clone()
    };
    let expected =
        "body.urdf: nothing moves, because the root link is fixed in the world; --base floating lets it move";
    assert_eq!(warnings("fixed"), serde_json::json!([expected]));
    assert_eq!(warnings("floating"), serde_json::json!([]));
}

#[test]
fn joints_that_do_not_start_as_the_user_said_are_named_with_both_values() {
    let folder = folder("moved");
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/robots/four_bar_1.toml");
    let output =
        run(&folder, &["simulate", scene, "--no-log", "--json", "--duration", "1e-9", "--position", "crank0=1.2"]);
    let report: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let starts = report["joints"]["crank0"]["position"].as_f64().expect("a number");
    assert!((starts - 1.2).abs() > 0.01, "{starts}");
    let warnings = report["warnings"].as_array().expect("warnings");
    let warning = warnings.iter().filter_map(Value::as_str).find(|said| said.contains("adjusted to close the loops"));
    let warning = warning.expect("a warning");
    assert!(warning.contains(&format!("; crank0 starts at {starts:.6} rad, not at 1.2")), "{warning}");
}

#[test]
fn a_step_beyond_the_stability_limit_is_a_warning_that_names_a_shorter_one() {
    let folder = folder("beyond");
    // The rod swings with some 4 rad/s; two stages are stable up to 2 rad a step.
    let swing = ["simulate", "pendulum.urdf", "--json", "--no-log", "--position", "hinge=1e-9", "--stages", "2"];
    let report = |step: &str| -> Value {
        let output = run(&folder, &[&swing[..], &["--step", step, "--duration", "8"]].concat());
        serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {}", text(&output.stderr)))
    };
    let warned = |report: &Value| {
        report["warnings"].as_array().unwrap().iter().any(|warning| {
            let warning = warning.as_str().unwrap();
            warning.contains("stability limit of 2 stages") && warning.contains("use --step below")
        })
    };
    let (short, long) = (report("0.1"), report("0.8"));
    assert!(!warned(&short), "{}", short["warnings"]);
    assert!(warned(&long), "{}", long["warnings"]);
    for (report, beyond) in [(short, false), (long, true)] {
        let seen = &report["method"]["max_frequency_step"];
        let (value, limit) = (seen["value"].as_f64().unwrap(), seen["limit"].as_f64().unwrap());
        assert!((limit - 2.0).abs() < 1e-9 && (value > limit) == beyond, "{seen}");
    }
}
