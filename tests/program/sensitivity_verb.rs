//! `catena sensitivity`: derivatives of a run as JSON, as a table of comma-separated values, and refusals.

use crate::common::command::{folder, run};
use serde_json::Value;
use std::path::Path;

fn robot(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("robots").join(name).display().to_string()
}

#[test]
fn a_bouncing_ball_has_the_derivatives_of_its_first_impact_in_json_and_a_row_for_each_step_in_the_table() {
    let folder = folder("sensitivity_verb");
    let ball = robot("ball_dropped.toml");
    let words = ["sensitivity", &ball, "--by", "floor.restitution=0.01", "--by", "robot.ball.pose.position.z"];
    let output = run(&folder, &[&words[..], &["--duration", "1.5", "--json", "-o", "ball.csv"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let report: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let events = report["events"].as_array().expect("events");
    // t = √(2 h/g) with h = 1 m: ∂t/∂h = t/2h; both to the tolerance of 1e-6 m.
    let time = (2.0_f64 / 9.81).sqrt();
    assert_eq!(events.len(), 2);
    assert!((events[0]["time"].as_f64().expect("a time") - time).abs() < 1e-6);
    assert!((events[0]["dt"][1].as_f64().expect("a slope") - 0.5 * time).abs() < 1e-6);
    assert_eq!(report["deviations"][0], 0.01);
    assert_eq!(report["deviations"][1], Value::Null);
    let table = std::fs::read_to_string(folder.join("ball.csv")).expect("a table");
    let steps = report["times"].as_array().expect("times").len();
    assert_eq!(table.lines().count(), 1 + steps);
    // Time, seven positions of the floating ball, and six derivatives of q and of v by two parameters.
    assert!(table.lines().all(|line| line.split(',').count() == 1 + 7 + 24), "{:?}", table.lines().next());
}

#[test]
fn unknown_parameters_and_impacts_without_a_single_active_set_are_refused_with_the_reason() {
    let folder = folder("sensitivity_verb_refused");
    for (scene, key, reason) in [
        ("ball_dropped.toml", "nonsense", "no parameter"),
        ("gripper_holds_box.toml", "gravity.z", "single active set"),
        ("ball_dropped.toml", "floor.restitution=-1", "greater than zero"),
    ] {
        let output = run(&folder, &["sensitivity", &robot(scene), "--by", key]);
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains(reason), "{message}");
    }
}
