//! The command line as scripts see it: exit codes, what is printed where, and what happens to files.

use foxglove::Decode;
use foxglove::messages::Log;
use serde_json::Value;
use std::path::Path;
use std::process::Command;

use crate::common::command::{
    ENDLESS, PENDULUM, assert_one_error, catena, folder, run, salvaged, salvaged_samples, text, wait_for,
};

#[test]
fn bad_input_and_bad_usage_exit_with_2_and_one_line_and_touch_no_file() {
    let folder = folder("bad_input");
    std::fs::write(folder.join("empty.urdf"), "").expect("written");
    let junk: Vec<u8> = (0..4096_u32).map(|index| (index.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
    std::fs::write(folder.join("junk.urdf"), junk).expect("written");
    let old_log = b"an old log, which is dear to its owner";
    std::fs::write(folder.join("out.mcap"), old_log).expect("written");
    let before = std::fs::read_dir(&folder).expect("readable").count();
    let cases: &[&[&str]] = &[
        &["missing.urdf"],
        &["empty.urdf"],
        &["junk.urdf"],
        &["."],
        &["pendulum.urdf", "--unknown"],
        &["pendulum.urdf", "--durration", "3"],
        &["pendulum.urdf", "--duration", "0"],
        &["pendulum.urdf", "--duration", "-1"],
        &["pendulum.urdf", "--duration", "inf"],
        &["pendulum.urdf", "--duration", "ten"],
        &["pendulum.urdf", "--rate", "0"],
        &["pendulum.urdf", "--rate", "1e300"],
        &["pendulum.urdf", "--tolerance", "NaN"],
        &["pendulum.urdf", "--tolerance", "-1e-6"],
        &["pendulum.urdf", "--stages", "1", "--step", "0.01"],
        &["pendulum.urdf", "--stages", "17", "--step", "0.01"],
        &["pendulum.urdf", "--stages", "3", "--step", "0"],
        &["pendulum.urdf", "--stages", "3"],
        &["pendulum.urdf", "--step", "0.01"],
        &["pendulum.urdf", "--stages", "3", "--step", "0.01", "--tolerance", "1e-6"],
        &["pendulum.urdf", "--base", "flying"],
        &["pendulum.urdf", "--base-pose", "1,2,3"],
        &["pendulum.urdf", "--base-velocity", "1,2,3,4,5,6"],
        &["pendulum.urdf", "--base", "floating", "--base-velocity", "1,2,3,4,5,6", "--velocity", "base=0,0,0,0,0,0"],
        &["pendulum.urdf", "--gravity", "0,0"],
        &["pendulum.urdf", "--gravity", "0,0,nan"],
        &["pendulum.urdf", "--position", "hinge"],
        &["pendulum.urdf", "--position", "hinge=1,2"],
        &["pendulum.urdf", "--position", "knee=1"],
        &["pendulum.urdf", "--velocity", "weld=1"],
        &["pendulum.urdf", "--package", "name"],
        &["pendulum.urdf", "--package", "name=no/such/folder"],
        &["pendulum.urdf", "--position", "hinge=1", "--position", "hinge=2"],
        &["pendulum.urdf", "--velocity", "hinge=1", "--velocity", "hinge=1"],
        &["pendulum.urdf", "--velocity", "hinge=1e300"],
        &["pendulum.urdf", "pendulum.urdf"],
        &[],
    ];
    for case in cases {
        let arguments = [&["simulate", "-o", "out.mcap"], *case].concat();
        assert_one_error(&run(&folder, &arguments), 2, &format!("{case:?}"));
        assert_eq!(std::fs::read(folder.join("out.mcap")).expect("still there"), old_log, "{case:?}");
    }
    assert_eq!(std::fs::read_dir(&folder).expect("readable").count(), before, "no file was added");
}

#[test]
fn an_output_that_cannot_be_is_refused_before_the_run() {
    let folder = folder("bad_output");
    for output in ["no/such/folder/out.mcap", ".", "-", "pendulum.urdf"] {
        let output = run(&folder, &["simulate", "pendulum.urdf", "-o", output, "--duration", "1e9"]);
        assert_one_error(&output, 2, "output");
    }
    for verb in [&["chart", "pendulum.urdf"][..], &["stress"]] {
        assert_one_error(&run(&folder, &[verb, &["-o", "-"]].concat()), 2, verb[0]);
        assert!(!folder.join("-").exists(), "{}", verb[0]);
    }
    let both = run(&folder, &["simulate", "pendulum.urdf", "-o", "out.mcap", "--no-log"]);
    assert_one_error(&both, 2, "-o and --no-log");
    let input = std::fs::read_to_string(folder.join("pendulum.urdf")).expect("still there");
    assert_eq!(input, PENDULUM, "the input is not replaced by its own log");
}

#[test]
fn a_log_replaces_no_file_that_the_run_is_made_from() {
    let folder = folder("made_from");
    let with_mesh = PENDULUM.replace("<box size=\"0.1 0.1 1\"/>", "<mesh filename=\"rod.stl\"/>");
    let scene = "[[robot]]\nurdf = \"rod.unfinished.urdf\"\n";
    let files = [("rod.unfinished.urdf", with_mesh.as_str()), ("rod.stl", "solid rod\nendsolid"), ("rod.toml", scene)];
    for (name, text) in files {
        std::fs::write(folder.join(name), text).expect("written");
    }
    // While it is written, the last one would be in the file of the URDF.
    for output in ["rod.unfinished.urdf", "rod.stl", "rod.toml", "../made_from/rod.stl", "rod.urdf"] {
        let refused = run(&folder, &["simulate", "rod.toml", "-o", output, "--duration", "0.1"]);
        assert_one_error(&refused, 2, output);
        assert!(text(&refused.stderr).contains("is made from"), "{}", text(&refused.stderr));
        for (name, before) in files {
            assert_eq!(std::fs::read_to_string(folder.join(name)).expect("still there"), before, "-o {output}");
        }
    }
    assert!(!folder.join("rod.urdf").exists());
}

#[test]
fn an_error_names_what_is_wrong() {
    let folder = folder("naming");
    std::fs::write(folder.join("far.urdf"), PENDULUM.replace("xyz=\"0 0 -0.5\"", "xyz=\"1e200 0 0\""))
        .expect("written");
    for (arguments, names) in [
        (["missing.urdf", "--rate", "1"], "missing.urdf"),
        (["pendulum.urdf", "--position", "knee=1"], "\"hinge\""),
        (["pendulum.urdf", "--durration", "1"], "'--duration'"),
        (["pendulum.urdf", "--step", "1"], "--stages"),
        (["pendulum.urdf", "--package", "name=no/such/folder"], "there is no folder \"no/such/folder\""),
        (["pendulum.urdf", "--velocity", "hinge=1e300"], "joint \"hinge\" starts so fast"),
        (["far.urdf", "--rate", "1"], "link \"rod\" is 1e200 m away"),
    ] {
        let output = run(&folder, &[&["simulate"], &arguments[..]].concat());
        assert!(text(&output.stderr).contains(names), "{arguments:?}: {}", text(&output.stderr));
    }
}

#[test]
fn a_joint_that_is_given_twice_is_named() {
    let folder = folder("twice");
    for option in ["--position", "--velocity"] {
        let output = run(&folder, &["simulate", "pendulum.urdf", option, "hinge=1", option, "hinge=2"]);
        let expected = format!("{option} is given twice for joint \"hinge\"");
        assert!(text(&output.stderr).contains(&expected), "{}", text(&output.stderr));
    }
}

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
fn a_full_disk_is_an_error_that_names_the_file() {
    if !Path::new("/dev/full").exists() {
        println!("skipped: this system has no /dev/full");
        return;
    }
    let folder = folder("full");
    let output = run(&folder, &["simulate", "pendulum.urdf", "-o", "/dev/full", "--duration", "1"]);
    assert_one_error(&output, 1, "full disk");
    assert!(text(&output.stderr).contains("/dev/full"), "{}", text(&output.stderr));
}

#[test]
fn a_standard_output_that_is_full_is_no_fault_of_the_input_for_any_verb() {
    let Ok(full) = std::fs::OpenOptions::new().write(true).open("/dev/full") else {
        println!("skipped: this system has no /dev/full");
        return;
    };
    let folder = folder("full_output");
    assert_eq!(run(&folder, &["simulate", "pendulum.urdf", "--duration", "0.1"]).status.code(), Some(0));
    let verbs: [&[&str]; 7] = [
        &["simulate", "pendulum.urdf", "--duration", "0.1", "--no-log"],
        &["model", "pendulum.urdf"],
        &["model", "pendulum.urdf", "--json"],
        &["inspect", "pendulum.mcap"],
        &["inspect", "pendulum.mcap", "pendulum.mcap"],
        &["inspect", "pendulum.mcap", "--at", "0.1", "--json"],
        &["replay", "pendulum.mcap"],
    ];
    for verb in verbs {
        let output = catena(&folder, verb).stdout(full.try_clone().expect("opened")).output().expect("runs");
        assert_one_error(&output, 1, verb[0]);
        assert!(text(&output.stderr).contains("cannot write to standard output"), "{}", text(&output.stderr));
    }
}

#[test]
fn a_warning_that_nobody_can_see_does_not_end_the_program() {
    let Ok(full) = std::fs::OpenOptions::new().write(true).open("/dev/full") else {
        println!("skipped: this system has no /dev/full");
        return;
    };
    let folder = folder("full_error");
    assert_eq!(run(&folder, &["simulate", "pendulum.urdf", "--duration", "0.1"]).status.code(), Some(0));
    let log = std::fs::read(folder.join("pendulum.mcap")).expect("a log");
    std::fs::write(folder.join("cut.mcap"), &log[..log.len() * 2 / 3]).expect("written");
    let output = catena(&folder, &["inspect", "cut.mcap", "--csv", "cut.csv"]).stderr(full).output().expect("runs");
    assert_eq!(output.status.code(), Some(0));
    assert!(folder.join("cut.csv").exists());
}

#[test]
fn json_has_every_key_of_the_interface_and_is_alone_on_standard_output() {
    let folder = folder("json");
    let output = run(&folder, &["simulate", "pendulum.urdf", "--json", "--duration", "0.5"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(output.stderr.is_empty(), "{}", text(&output.stderr));
    let report: Value = serde_json::from_slice(&output.stdout).expect("one JSON object");
    let expected: Value = serde_json::from_str(
        r#"{
        "catena": "", "input": "", "scene": "", "duration": 0,
        "method": {"stages": 0, "order": 0, "step": 0, "adaptive": true, "tolerance": 0,
            "max_frequency_step": null, "digits": 16, "reversible_resets": null},
        "model": {"links": 0, "bodies": 0, "joints": 0, "degrees_of_freedom": 0, "loops": 0, "redundant_constraints": 0,
            "islands": 0, "sleeping_islands": 0},
        "steps": 0, "iterations": 0, "kept_factor_iterations": 0, "rejected_steps": 0, "exact_newton_steps": 0,
        "wall_seconds": 0, "cpu_seconds": 0, "solve_cpu_seconds": 0,
        "energy": {"initial": 0, "final": 0, "max_relative_error": 0,
            "parts": {"kinetic": 0, "gravity": 0, "spring": 0, "load": 0}, "dissipated": 0, "work": 0},
        "constraint": {"max_position": 0, "max_velocity": 0},
        "links": {
            "base": {"position": [0,0,0], "orientation": [0,0,0,0], "center_of_mass": [0,0,0],
                     "linear_velocity": [0,0,0], "angular_velocity": [0,0,0]},
            "rod": {"position": [0,0,0], "orientation": [0,0,0,0], "center_of_mass": [0,0,0],
                    "linear_velocity": [0,0,0], "angular_velocity": [0,0,0]},
            "tip": {"position": [0,0,0], "orientation": [0,0,0,0], "center_of_mass": [0,0,0],
                    "linear_velocity": [0,0,0], "angular_velocity": [0,0,0]}},
        "joints": {
            "hinge": {"position": 0, "velocity": 0, "reaction_force": [0,0,0], "reaction_torque": [0,0,0]}},
        "accuracy": {"wanted": 0, "estimated": 0, "holds_until": 0, "reached": true, "pilots": 0},
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
        assert_eq!(text(&lines.stdout).contains(" % with kept factors)"), some, "{input}: {}", text(&lines.stdout));
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
    for (input, words) in [("pendulum.urdf", " rejected\n"), (loops, " rejected, by the exact Newton method\n")] {
        let arguments = ["simulate", input, "--no-log", "--duration", "0.5"];
        let report = run(&folder, &[&arguments[..], &["--json"]].concat());
        let report: Value = serde_json::from_slice(&report.stdout).expect("one JSON object");
        let all = if input == loops { report["steps"].as_u64() } else { Some(0) };
        assert_eq!(report["exact_newton_steps"].as_u64(), all, "{input}");
        let lines = run(&folder, &arguments);
        assert!(text(&lines.stdout).contains(words), "{input}: {}", text(&lines.stdout));
    }
}

#[test]
fn the_help_names_every_rule_that_can_be_switched_off() {
    let folder = folder("rules");
    let help = run(&folder, &["simulate", "--help"]);
    for rule in catena::model::Rule::ALL {
        assert!(text(&help.stdout).contains(rule.name()), "{} is missing: {}", rule.name(), text(&help.stdout));
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
    let lines = salvaged(&log, "/log");
    let last = Log::decode(&*lines.last().expect("a line").data).expect("a log line");
    assert_eq!(error.trim_end(), format!("catena: error: {}", last.message));
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
fn joints_that_do_not_start_as_the_user_said_are_named_with_both_values() {
    let folder = folder("moved");
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/robots/four_bar_1.toml");
    let output =
        run(&folder, &["simulate", scene, "--no-log", "--json", "--duration", "1e-9", "--position", "crank0=1.2"]);
    let report: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let starts = report["joints"]["crank0"]["position"].as_f64().expect("a number");
    assert!((starts - 1.2).abs() > 0.01, "{starts}");
    let warnings = report["warnings"].as_array().expect("warnings");
    let warning = warnings.iter().filter_map(Value::as_str).find(|said| said.contains("moved onto the loops"));
    let warning = warning.expect("a warning");
    assert!(warning.contains(&format!("; crank0 starts at {starts:.6} rad, not at 1.2")), "{warning}");
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

#[test]
fn what_acts_along_a_joint_has_the_units_of_the_joint() {
    let folder = folder("units");
    let damped = PENDULUM.replace("<axis xyz=\"0 1 0\"/>", "<axis xyz=\"0 1 0\"/><dynamics damping=\"0.5\"/>");
    for (kind, unit) in [("continuous", "0.5000 N m s/rad"), ("prismatic", "0.5000 N s/m")] {
        std::fs::write(folder.join("damped.urdf"), damped.replace("continuous", kind)).expect("written");
        let output = run(&folder, &["model", "damped.urdf"]);
        let line = text(&output.stdout).lines().find(|line| line.contains("damper")).map(str::trim_end);
        assert!(line.is_some_and(|line| line.ends_with(unit)), "{kind}: {}", text(&output.stdout));
    }
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
