//! Logs that are whole or still being written: instants, summaries, tables, curves, comparisons, and usage that is refused.

use super::{inspect, json, simulate};
use crate::common;
use crate::common::command::{
    ENDLESS, assert_one_error, catena, folder, run, salvaged, salvaged_samples, text, wait_for,
};
use serde_json::Value;
use std::process::Stdio;

fn assert_near(a: &Value, b: &Value, bound: f64, place: &str) {
    match (a, b) {
        (Value::Object(a), Value::Object(b)) => {
            assert_eq!(a.keys().collect::<Vec<_>>(), b.keys().collect::<Vec<_>>(), "{place}");
            a.iter().for_each(|(key, value)| assert_near(value, &b[key], bound, &format!("{place}.{key}")));
        }
        (Value::Array(a), Value::Array(b)) => {
            assert_eq!(a.len(), b.len(), "{place}");
            a.iter().zip(b).for_each(|(a, b)| assert_near(a, b, bound, place));
        }
        (Value::Null, Value::Null) => {}
        _ => {
            let (a, b) = (a.as_f64().expect("a number"), b.as_f64().expect("a number"));
            assert!((a - b).abs() <= bound, "{place}: {a} {b}");
        }
    }
}

#[test]
fn the_end_of_a_log_is_what_the_report_says_of_it() {
    let folder = folder("end");
    let turning = ["--velocity", "hinge=1"];
    let report = simulate(&folder, &turning);
    for (at, nearest) in [("1e300", 1.5), ("-1e300", 0.0), ("0.51", 0.516666667), ("0.508", 0.5)] {
        assert_eq!(inspect(&folder, &["pendulum.mcap", "--at", at])["time"], nearest, "{at}");
    }
    let instant = inspect(&folder, &["pendulum.mcap", "--at", "1e9"]);
    assert_eq!(instant["time"], 1.5);
    for what in ["links", "joints"] {
        // Some roundings of numbers of one metre and some newtons: the log is written by other code, which turns by quaternions, and
        // link velocities are worked out again.
        assert_near(&instant[what], &report[what], 1e-14, what);
    }
    let floating = ["--base", "floating", "--base-velocity", "1,2,3,0.4,0.5,0.6", "--velocity", "hinge=1"];
    let report = simulate(&folder, &floating);
    let instant = inspect(&folder, &["pendulum.mcap", "--at", "1.5"]);
    for what in ["links", "joints"] {
        // The base is logged by its link and simulated by its body: two products of rotations, at lengths of some 10 m.
        assert_near(&instant[what], &report[what], 1e-12, what);
    }
}

#[test]
fn an_instant_of_a_closed_mechanism_has_its_loops_as_the_report_has_them() {
    let folder = folder("loops");
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/robots/slider_crank.toml");
    let report = json(&run(&folder, &["simulate", scene, "--duration", "0.5", "--json", "-o", "closed.mcap"]));
    let instant = inspect(&folder, &["closed.mcap", "--at", "0.5"]);
    let loops = report["loops"].as_object().expect("loops");
    assert!(!loops.is_empty());
    // The report knows the digits of the angles that their roundings leave out, logs do not; on forces of some 30 N.
    assert_near(&instant["loops"], &report["loops"], 1e-12, "loops");
    // The log has what the run found; nothing was worked out in its stead.
    assert!(loops.values().any(|one| one["reaction_force"][0] != 0.0), "{loops:?}");
    assert_eq!(instant["constraint"]["time"], 0.5);
    assert!(instant["constraint"]["position"].as_f64().expect("a number") <= 1e-12, "{}", instant["constraint"]);
    let output = run(&folder, &["inspect", "closed.mcap", "--at", "0.5"]);
    let words = text(&output.stdout);
    for name in loops.keys() {
        let line =
            words.split("  loops: ").nth(1).and_then(|loops| loops.lines().find(|line| line.contains(name.as_str())));
        assert!(line.is_some_and(|line| line.split_whitespace().count() == 8), "{words}");
    }
}

#[test]
fn an_instant_is_the_nearest_that_was_logged() {
    let folder = folder("instant");
    simulate(&folder, &["--rate", "10"]);
    for (asked, found) in [("0.349", 0.3), ("0.351", 0.4), ("-5", 0.0), ("0.7", 0.7)] {
        let instant = inspect(&folder, &["pendulum.mcap", "--at", asked]);
        assert!((instant["time"].as_f64().expect("a time") - found).abs() < 1e-9, "{asked}: {}", instant["time"]);
    }
}

#[test]
fn the_summary_has_the_figures_of_the_report() {
    let folder = folder("summary");
    let report = simulate(&folder, &["--velocity", "hinge=1"]);
    let summary = inspect(&folder, &["pendulum.mcap"]);
    assert_eq!(summary["complete"], true);
    assert_eq!(summary["outcome"], "finished");
    assert_eq!(summary["duration"], 1.5);
    assert_eq!(summary["samples"], 91);
    for figure in ["initial", "final", "dissipated", "friction", "impacts", "work", "max_relative_error"] {
        assert_eq!(summary["energy"][figure], report["energy"][figure], "{figure}");
    }
    assert_eq!(summary["constraint"], report["constraint"]);
    for count in ["steps", "iterations", "rejected_steps"] {
        assert_eq!(summary["solver"][count].as_f64(), report[count].as_f64(), "{count}");
    }
    assert_eq!(summary["warnings"], report["warnings"]);
    assert_eq!(summary["attachments"]["pendulum.urdf"], common::command::PENDULUM.len());
    let words = run(&folder, &["inspect", "pendulum.mcap"]);
    for said in ["complete", "/joint_states", "91 samples", " links, 1 moving joint\n", "energy", "constraint"] {
        assert!(text(&words.stdout).contains(said), "{said}: {}", text(&words.stdout));
    }
}

#[test]
fn the_contacts_of_a_summary_and_of_a_page_are_those_of_the_report() {
    let folder = folder("contacts");
    for (scene, duration) in [("quadruped_dropped", "0.3"), ("block_on_incline", "0.5")] {
        let input = format!("{}/robots/{scene}.toml", env!("CARGO_MANIFEST_DIR"));
        let arguments =
            ["simulate", &input, "--duration", duration, "-o", "log.mcap", "--report", "page.html", "--json"];
        let report = json(&run(&folder, &arguments));
        let (contact, said) = (&report["contact"], inspect(&folder, &["log.mcap"])["contact"].take());
        let points = contact["points"].as_array().expect("contacts");
        assert_eq!(said["at_end"], points.len(), "{said}");
        assert_eq!(said["slipping"], points.iter().filter(|point| point["state"] == "slip").count(), "{said}");
        for figure in ["max_penetration", "max_cone_violation"] {
            assert_eq!(said[figure], contact[figure], "{figure}");
        }
        let words = text(&run(&folder, &["inspect", "log.mcap"]).stdout).to_string();
        let line = words.lines().find_map(|line| line.strip_prefix("  contact     ")).expect("a line of contacts");
        assert!(line.starts_with("4 contacts at the end") && line.contains("cones"), "{line}");
        assert_eq!(line.contains("4 of them slip"), scene == "block_on_incline", "{line}");
        let page = std::fs::read_to_string(folder.join("page.html")).expect("a page");
        assert!(page.contains(line), "{line}");
    }
    simulate(&folder, &[]);
    assert!(inspect(&folder, &["pendulum.mcap"]).get("contact").is_none());
}

#[test]
fn the_table_has_a_row_for_every_sample_and_units_in_its_head() {
    let folder = folder("table");
    let report = simulate(&folder, &["--velocity", "hinge=1"]);
    let output = run(&folder, &["inspect", "pendulum.mcap", "--csv", "out.csv"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let table = std::fs::read_to_string(folder.join("out.csv")).expect("a table");
    let rows: Vec<Vec<&str>> = table.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 1 + 91);
    assert!(rows.iter().all(|row| row.len() == rows[0].len()));
    let last = |column: &str| -> f64 {
        let place =
            rows[0].iter().position(|name| *name == column).unwrap_or_else(|| panic!("{column}: {:?}", rows[0]));
        rows[91][place].parse().expect("a number")
    };
    assert_eq!(last("time [s]"), 1.5);
    assert_eq!(last("hinge.position [rad]"), report["joints"]["hinge"]["position"].as_f64().expect("a number"));
    assert_eq!(last("hinge.velocity [rad/s]"), report["joints"]["hinge"]["velocity"].as_f64().expect("a number"));
    // The log takes frames from quaternions, the report from matrices: roundings of a metre.
    assert_near(&last("tip.z [m]").into(), &report["links"]["tip"]["position"][2], 1e-15, "tip.z");
    assert_eq!(last("energy.total [J]"), report["energy"]["final"].as_f64().expect("a number"));
}

#[test]
fn curves_are_drawn_with_units_and_names() {
    let folder = folder("plot");
    simulate(&folder, &["--velocity", "hinge=1"]);
    let output = run(&folder, &["inspect", "pendulum.mcap", "--plot", "out.svg"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let svg = std::fs::read_to_string(folder.join("out.svg")).expect("a picture");
    for said in ["hinge", "rad/s", "Energy error", "Constraint violation", "Reaction forces", "simulated time [s]"] {
        assert!(svg.contains(said), "{said}");
    }
    assert_eq!(run(&folder, &["inspect", "pendulum.mcap", "--plot", "out.png"]).status.code(), Some(0));
    let png = std::fs::read(folder.join("out.png")).expect("a picture");
    assert!(png.starts_with(b"\x89PNG") && png.len() > 10_000);
}

#[test]
fn curves_are_chosen_by_words_of_their_titles_and_names() {
    let folder = folder("chosen");
    simulate(&folder, &["--velocity", "hinge=1"]);
    let draw = |words: &str| run(&folder, &["inspect", "pendulum.mcap", "--plot", "some.svg", "--curves", words]);
    assert_eq!(draw("velocities,ENERGY").status.code(), Some(0));
    let svg = std::fs::read_to_string(folder.join("some.svg")).expect("a picture");
    let has = |words: &[&str]| words.iter().filter(|said| svg.contains(**said)).count();
    assert_eq!(has(&["Joint velocities", "Energy error"]), 2);
    assert_eq!(has(&["Joint positions", "Reaction forces", "Constraint violation"]), 0);
    let unknown = draw("energy,knee");
    assert_eq!(unknown.status.code(), Some(2));
    let said = text(&unknown.stderr);
    assert!(said.contains("no curve has \"knee\"") && said.contains("hinge"), "{said}");
}

#[test]
fn two_logs_are_compared_link_by_link() {
    let folder = folder("compare");
    simulate(&folder, &["-o", "a.mcap"]);
    simulate(&folder, &["-o", "same.mcap"]);
    simulate(&folder, &["-o", "turned.mcap", "--base-pose", "0.3,0.4,0,0,0,0.5"]);
    let same = inspect(&folder, &["a.mcap", "same.mcap"]);
    assert_eq!((&same["identical"], &same["instants"]), (&Value::Bool(true), &91.into()));
    let turned = inspect(&folder, &["a.mcap", "turned.mcap"]);
    assert_eq!(turned["identical"], false);
    let base = &turned["links"][0];
    // By construction half a metre and half a radian, at all times.
    assert!((base["distance"].as_f64().expect("a number") - 0.5).abs() < 1e-12, "{base}");
    assert!((base["angle"].as_f64().expect("a number") - 0.5).abs() < 1e-12, "{base}");
    assert_eq!(base["first_difference"], 0.0);
    let words = run(&folder, &["inspect", "a.mcap", "turned.mcap"]);
    assert!(text(&words.stdout).contains("different"), "{}", text(&words.stdout));
}

#[test]
fn logs_of_which_nothing_can_be_compared_are_not_identical() {
    let folder = folder("apart");
    simulate(&folder, &["-o", "a.mcap"]);
    let renamed = common::command::PENDULUM
        .replace("\"base\"", "\"foot\"")
        .replace("\"rod\"", "\"leg\"")
        .replace("\"tip\"", "\"toe\"");
    std::fs::write(folder.join("pendulum.urdf"), renamed).expect("written");
    simulate(&folder, &["-o", "b.mcap"]);
    let comparison = inspect(&folder, &["a.mcap", "b.mcap"]);
    assert_eq!((&comparison["instants"], &comparison["identical"]), (&91.into(), &Value::Bool(false)), "{comparison}");
    let words = run(&folder, &["inspect", "a.mcap", "b.mcap"]);
    assert!(text(&words.stdout).contains("a.mcap and b.mcap: no link in common\n"), "{}", text(&words.stdout));
}

#[cfg(unix)]
#[test]
fn a_log_is_followed_until_its_run_ends() {
    let folder = folder("follow");
    let log = folder.join("pendulum.mcap");
    let arguments = [&["simulate", "pendulum.urdf", "--velocity", "hinge=1"], &ENDLESS[..]].concat();
    let mut child = catena(&folder, &arguments).spawn().expect("runs");
    wait_for(&mut child, "a log with samples", || salvaged_samples(&log) > 10);
    let mut follower = catena(&folder, &["inspect", "pendulum.mcap", "--follow", "--json"])
        .stdout(Stdio::from(std::fs::File::create(folder.join("followed")).expect("made")))
        .spawn()
        .expect("runs");
    let lines = || std::fs::read_to_string(folder.join("followed")).expect("there").lines().count();
    wait_for(&mut follower, "three looks", || lines() >= 3);
    child.kill().expect("killed");
    child.wait().expect("ends");
    assert!(follower.wait().expect("ends").success());
    let followed = std::fs::read_to_string(folder.join("followed")).expect("there");
    let samples: Vec<u64> = followed
        .lines()
        .map(|line| serde_json::from_str::<Value>(line).expect("JSON")["samples"].as_u64().expect("a count"))
        .collect();
    assert!(samples.is_sorted(), "{samples:?}");
    // The last sample may have been saved in part, which is no sample.
    let bytes = std::fs::read(&log).expect("a log");
    let whole = ["/tf", "/joint_states", "/reactions"].map(|topic| salvaged(&bytes, topic).len());
    assert_eq!(*samples.last().expect("a look") as usize, *whole.iter().min().expect("three"));
}

#[test]
fn bad_usage_is_one_line_and_touches_no_file() {
    let folder = folder("bad");
    simulate(&folder, &[]);
    let before = std::fs::read(folder.join("pendulum.mcap")).expect("a log");
    std::fs::write(folder.join("words.mcap"), "not a log at all").expect("written");
    let cases: &[&[&str]] = &[
        &["missing.mcap"],
        &["words.mcap"],
        &["."],
        &["pendulum.urdf"],
        &["pendulum.mcap", "words.mcap"],
        &["pendulum.mcap", "--at", "soon"],
        &["pendulum.mcap", "--plot", "picture.gif"],
        &["pendulum.mcap", "--plot", "-"],
        &["pendulum.mcap", "--csv", "-"],
        &["pendulum.mcap", "--recover", "-"],
        &["pendulum.mcap", "--csv", "pendulum.mcap"],
        &["pendulum.mcap", "--follow", "--csv", "a.csv"],
        &["pendulum.mcap", "pendulum.mcap", "--at", "1"],
        &[],
    ];
    for case in cases {
        assert_one_error(&run(&folder, &[&["inspect"], *case].concat()), 2, &format!("{case:?}"));
    }
    let output = run(&folder, &["inspect", "pendulum.mcap", "--csv", "-"]);
    assert!(text(&output.stderr).contains("standard output is not supported"), "{}", text(&output.stderr));
    assert!(!folder.join("-").exists());
    assert_eq!(run(&folder, &["inspect", "pendulum.mcap", "--csv", "./-"]).status.code(), Some(0));
    assert_one_error(&run(&folder, &["inspect", "pendulum.mcap", "--csv", "no/such/a.csv"]), 2, "no folder");
    assert!(std::fs::read(folder.join("pendulum.mcap")).expect("a log") == before);
}
