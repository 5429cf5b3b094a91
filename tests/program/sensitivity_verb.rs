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
    // Time, seven positions and six velocities of the floating ball, and six derivatives of q and of v by two parameters.
    assert!(table.lines().all(|line| line.split(',').count() == 1 + 7 + 6 + 24), "{:?}", table.lines().next());
    assert!(table.lines().next().is_some_and(|head| head.contains(",v.base.z,")), "{:?}", table.lines().next());
}

#[test]
fn unknown_parameters_and_events_without_derivatives_are_refused_with_the_reason() {
    let folder = folder("sensitivity_verb_refused");
    for (scene, key, reason) in [
        ("ball_dropped.toml", "nonsense", "no parameter"),
        ("woodpecker.toml", "gravity.z", "derivatives through this kind of event are not offered"),
        ("ball_dropped.toml", "floor.restitution=-1", "greater than zero"),
    ] {
        let output = run(&folder, &["sensitivity", &robot(scene), "--by", key]);
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains(reason), "{message}");
    }
}

#[test]
fn a_log_has_the_derivatives_of_its_run_at_the_ends_of_steps_and_its_table_and_report_have_the_same_numbers() {
    let folder = folder("sensitivity_log");
    let ball = robot("ball_dropped.toml");
    let words = ["simulate", &ball, "--duration", "1.5", "--json"];
    let asked =
        ["--sensitivity", "floor.restitution=0.01", "--sensitivity", "robot.ball.pose.position.z", "-o", "b.mcap"];
    let with = run(&folder, &[&words[..], &asked[..]].concat());
    assert_eq!(with.status.code(), Some(0), "{}", String::from_utf8_lossy(&with.stderr));
    let with: Value = serde_json::from_slice(&with.stdout).expect("JSON");
    let plain = run(&folder, &[&words[..], &["-o", "plain.mcap"]].concat());
    let plain: Value = serde_json::from_slice(&plain.stdout).expect("JSON");
    assert_eq!(with["links"], plain["links"], "derivatives change nothing of the motion");
    let found = &with["sensitivity"];
    assert_eq!(found["keys"].as_array().map(Vec::len), Some(2));
    assert!(found["valid_within"][0].as_f64().expect("a bound of an impact") > 0.0);
    let table = run(&folder, &["inspect", "b.mcap", "--csv", "b.csv"]);
    assert_eq!(table.status.code(), Some(0), "{}", String::from_utf8_lossy(&table.stderr));
    let table = std::fs::read_to_string(folder.join("b.csv")).expect("a table");
    let rows: Vec<Vec<&str>> = table.lines().map(|line| line.split(',').collect()).collect();
    let freedom = found["freedoms"]
        .as_array()
        .and_then(|all| all.iter().position(|name| name.as_str().is_some_and(|name| name.ends_with(".z"))));
    let freedom = freedom.expect("a height");
    let name = found["freedoms"][freedom].as_str().expect("a name");
    for (key, place) in [("floor.restitution", 0), ("robot.ball.pose.position.z", 1)] {
        let column = rows[0].iter().position(|head| *head == format!("d{name}.position/d{key}")).expect("a column");
        let last: f64 = rows.last().expect("rows")[column].parse().expect("a number");
        // The same double, in both.
        assert_eq!(Some(last), found["dq"][freedom][place].as_f64(), "{key}");
        // A lower ball starts lower.
        let first: f64 = rows[1][column].parse().expect("a number");
        assert!((first - place as f64).abs() < 1e-9, "{key}: {first}");
    }
    let replayed = run(&folder, &["replay", "b.mcap"]);
    assert_eq!(replayed.status.code(), Some(0), "{}", String::from_utf8_lossy(&replayed.stderr));
}

#[test]
fn a_run_without_derivatives_is_refused_before_it_touches_its_log() {
    let folder = folder("sensitivity_log_refused");
    std::fs::write(folder.join("kept.mcap"), "kept").expect("a file");
    let words = ["simulate", &robot("woodpecker.toml"), "--sensitivity", "gravity.z", "-o", "kept.mcap"];
    let output = run(&folder, &words);
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains("held joints are let go") && message.contains("end the run before it"), "{message}");
    assert_eq!(message.lines().count(), 1, "{message}");
    assert_eq!(std::fs::read_to_string(folder.join("kept.mcap")).expect("a file"), "kept");
}
