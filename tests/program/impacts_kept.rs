//! Impacts keep their law: bodies that touch pass a blow on, and accumulating impacts end within the tolerance.

use crate::common::command::{run, text};
use crate::common::shared;
use serde_json::Value;
use std::path::PathBuf;

/// The folder of the inputs, if it is there.
fn inputs() -> Option<PathBuf> {
    let folder = shared("repro").map(|folder| folder.join("events")).filter(|folder| folder.is_dir());
    if folder.is_none() {
        println!("skipped: there is no ../shared/repro/events");
    }
    folder
}

/// The report of a run.
fn report(arguments: &[&str]) -> Option<Value> {
    let output = run(&inputs()?, &[&["simulate", "--no-log", "--json"], arguments].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    Some(serde_json::from_slice(&output.stdout).expect("a report"))
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

fn count(report: &Value, kind: &str) -> u64 {
    report["events"]["counts"][kind].as_u64().expect("a count")
}

fn place(report: &Value, link: &str) -> [f64; 3] {
    let place = report["links"][link]["center_of_mass"].as_array().unwrap_or_else(|| panic!("no link {link}"));
    [0, 1, 2].map(|axis| number(&place[axis]))
}

fn apart(one: [f64; 3], other: [f64; 3]) -> f64 {
    one.iter().zip(other).map(|(one, other)| (one - other).powi(2)).sum::<f64>().sqrt()
}

/// A run whose link ends at a place (m) within its tolerance, and that says so.
fn ends_within(arguments: &[&str], link: &str, wanted: [f64; 3], tolerance: f64) -> Option<Value> {
    let asked = format!("{tolerance:e}");
    let report = report(&[arguments, &["--tolerance", &asked]].concat())?;
    let off = apart(place(&report, link), wanted);
    println!("{arguments:?}: {off:e} m off, told {}", report["accuracy"]["estimated"]);
    assert!(off <= tolerance && report["accuracy"]["reached"] == true, "{off:e} m off: {}", report["accuracy"]);
    Some(report)
}

#[test]
fn a_cradle_whose_balls_touch_passes_each_blow_on_without_events_of_balls_that_hang_still() {
    // Blows of a pendulum that is let go at 0.4 rad: at a quarter of its period, 0.2777 s, and then each half.
    let Some(report) = report(&["14_cradle_touching.toml", "--duration", "45"]) else { return };
    let blows = ((45.0 - 0.277_710_9) / (2.0 * 0.277_710_9)) as u64 + 1;
    // One comes in and rests beside its neighbour, and one goes out.
    let counts = ["contact_impact", "rest", "release"].map(|kind| count(&report, kind));
    // A blow may be told of each pair that it passes through; it has one instant.
    let list = report["events"]["list"].as_array().expect("a list");
    let mut instants: Vec<f64> = list.iter().map(|event| number(&event["time"])).collect();
    instants.dedup();
    println!("{counts:?} of {blows} blows at {} instants, {} steps", instants.len(), report["steps"]);
    assert!(instants.len().abs_diff(blows as usize) <= 1 && counts[1] <= blows && counts[2] <= blows, "{counts:?}");
    assert!(number(&report["energy"]["max_relative_error"]) < 1e-9, "{}", report["energy"]);
    // Each impact is elastic but for roundings of the velocities.
    assert!(number(&report["energy"]["impacts"]).abs() < 1e-12, "{}", report["energy"]);
    assert_eq!(report["method"]["crowd"]["steps"], 0);
    // Those in the middle hang still.
    for middle in ["p1/ball", "p2/ball", "p3/ball"] {
        let moves = report["links"][middle]["linear_velocity"].as_array().expect("a velocity");
        assert!(moves.iter().all(|part| number(part).abs() < 1e-9), "{middle}: {moves:?}");
    }
}

#[test]
fn a_second_blow_on_a_cradle_is_as_elastic_as_the_first() {
    let Some(report) = report(&["cradle_second_blow.toml"]) else { return };
    let energy = &report["energy"];
    assert!(number(&energy["impacts"]).abs() < 1e-12 && number(&energy["max_relative_error"]) < 1e-9, "{energy}");
    assert_eq!(report["method"]["crowd"]["steps"], 0);
    assert_eq!(count(&report, "contact_impact"), 3);
    assert_eq!(report["accuracy"]["reached"], true);
}

#[test]
fn impacts_that_accumulate_between_a_heavy_ball_and_a_floor_end_within_the_tolerance() {
    // Runs of the tolerances 1e-9 to 1e-12 agree to 1e-12 m.
    ends_within(&["balls_b.toml"], "s/ball", [-0.084_207_065_591, 0.0, 0.05], 1e-6);
    ends_within(&["balls_a.toml"], "s/ball", [-0.094_129_898_720, 0.0, 0.05], 1e-8);
}

#[test]
fn a_contact_that_closes_sooner_than_a_step_can_be_solved_lets_no_body_into_another() {
    // Runs of the tolerances 1e-9 to 1e-12 agree to 1e-14 m.
    let Some(report) = report(&["two212.toml", "--tolerance", "1e-12"]) else { return };
    let wanted = place(&report, "r1/l2");
    ends_within(&["two212.toml"], "r1/l2", wanted, 1e-6);
    // The place of the floating base, by runs that took a hundred times as many steps.
    let base = &report["joints"]["r1/base"]["position"];
    assert!((number(&base[0]) + 0.203_423_932_781_7).abs() < 1e-10, "{base}");
}

#[test]
fn a_slip_that_passes_near_its_stop_is_no_reversal_and_is_followed() {
    let Some(report) = report(&["floor237.toml", "--tolerance", "1e-6"]) else { return };
    assert_eq!(count(&report, "reversal"), 0, "{}", report["events"]["counts"]);
    // Steps of 5 stages of 5e-5 s.
    let base = &report["joints"]["base"]["position"];
    let wanted = [-0.102_891_05, 0.157_609_71, -0.098_426_75];
    let off = apart([0, 1, 2].map(|axis| number(&base[axis])), wanted);
    // Within the tolerance: a load of 540 N for 6 ms at 0.267 s amplifies what steps leave, 1e-9 to 3e-7 m by their places.
    assert!(off < 1e-6 && report["accuracy"]["reached"] == true, "{off:e} m off: {}", report["accuracy"]);
}

#[test]
fn a_joint_that_falls_onto_its_limit_from_next_to_nothing_meets_it_in_given_and_in_chosen_steps() {
    let Some(given) = report(&["limits216.toml", "--stages", "9", "--step", "1e-3"]) else { return };
    let Some(chosen) = report(&["limits216.toml", "--tolerance", "1e-6"]) else { return };
    // One missed impact of j7 at 0.41888 s was 2e-4 m.
    for (link, _) in given["links"].as_object().expect("links") {
        let off = apart(place(&given, link), place(&chosen, link));
        assert!(off <= 1e-6, "{link}: {off:e} m");
    }
    // What was told is no less than a tenth of what it is off by.
    let off = |link: &str| apart(place(&given, link), place(&chosen, link));
    let told = number(&chosen["accuracy"]["estimated"]);
    let most = ["l7", "l8", "l11", "l12"].map(off).into_iter().fold(0.0, f64::max);
    println!("{most:e} m off, told {told:e}");
    assert!(told >= 0.1 * most, "{most:e} m off, told {told:e}");
}
