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
    assert!(report["accuracy"]["estimated"].is_null() && report["accuracy"]["reason"].is_string(), "{report}");
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
    assert_eq!((&report["accuracy"]["wanted"], &report["accuracy"]["estimated"]), (&1e-6.into(), &Value::Null));
    let reason = report["accuracy"]["reason"].as_str().expect("a reason");
    assert_eq!(reason, "the run ended before its error could be estimated");
    let people = run(&folder, &["simulate", "pendulum.urdf", "--velocity", "hinge=1e100", "--no-log"]);
    assert!(text(&people.stdout).contains("accuracy    not known: the run ended"), "{}", text(&people.stdout));
}

/// A chain that falls, fast enough to begin again, with this log.
fn fall(folder: &Path, log: &str, arguments: &[&str]) -> Value {
    let chain = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/chain_10.urdf");
    let chain = chain.to_str().expect("a path in UTF-8");
    let all = ["simulate", chain, "--velocity", "joint3=2", "--tolerance", "1e-3", "--rate", "20", "--json", "-o", log];
    let output = run(folder, &[&all[..], arguments].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    json(&output.stdout)
}

#[test]
fn the_log_of_a_run_that_begins_again_is_that_of_the_last_beginning_alone_and_replays() {
    let folder = scratch("again");
    let report = fall(&folder, "log.mcap", &["--duration", "4"]);
    let begun = report["accuracy"]["begun"].as_u64().expect("a number");
    assert!(begun > 1, "{}", report["accuracy"]);
    let inspected = json(&run(&folder, &["inspect", "log.mcap", "--json"]).stdout);
    // 20 samples a second from t = 0 to 4 s, once.
    assert_eq!((&inspected["samples"], &inspected["duration"]), (&Value::from(81), &Value::from(4.0)), "{inspected}");
    let lines = text(&run(&folder, &["inspect", "log.mcap"]).stdout).to_string();
    assert!(lines.contains("complete, the run has finished"), "{lines}");
    let replayed = run(&folder, &["replay", "log.mcap"]);
    assert!(text(&replayed.stdout).contains("to the end, bit for bit"), "{}", text(&replayed.stderr));
}

#[cfg(unix)]
#[test]
fn the_log_of_a_run_into_a_pipe_replays() {
    use crate::common::command::catena;
    let folder = scratch("pipe");
    let pipe = folder.join("pipe");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    if !made.is_ok_and(|status| status.success()) {
        println!("skipped: there is no mkfifo");
        return;
    }
    let reader = std::thread::spawn({
        let pipe = pipe.clone();
        move || std::fs::read(pipe).expect("the log")
    });
    let chain = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/chain_10.urdf");
    let all =
        ["simulate", chain.to_str().expect("UTF-8"), "--tolerance", "1e-3", "--duration", "1", "--json", "-o", "pipe"];
    let output = catena(&folder, &all).output().expect("catena runs");
    assert_eq!(json(&output.stdout)["accuracy"]["reached"], true);
    std::fs::write(folder.join("log.mcap"), reader.join().expect("a reader")).expect("written");
    let replayed = run(&folder, &["replay", "log.mcap"]);
    assert!(text(&replayed.stdout).contains("to the end, bit for bit"), "{}", text(&replayed.stderr));
}

#[cfg(unix)]
#[test]
fn a_chaotic_run_says_in_its_log_until_when_its_accuracy_holds_and_its_report_up_to_when_that_is_known_if_it_is_interrupted()
 {
    use crate::common::command::{catena, wait_for};
    let folder = scratch("chaos");
    let chain = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/chain_10.urdf");
    let all =
        ["simulate", chain.to_str().expect("UTF-8"), "--tolerance", "1e-3", "--duration", "1e6", "-o", "log.mcap"];
    let so_far = || {
        let output = run(&folder, &["inspect", "log.mcap", "--json"]);
        let summary: Value = serde_json::from_slice(&output.stdout).unwrap_or_default();
        summary["accuracy_so_far"].as_str().unwrap_or_default().to_string()
    };
    let mut child = catena(&folder, &all).spawn().expect("catena runs");
    wait_for(&mut child, "the end of the accuracy", || so_far().starts_with("1e-3 m holds until t = "));
    let signalled = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(signalled.is_ok_and(|status| status.success()));
    let output = child.wait_with_output().expect("ended");
    assert_eq!(output.status.code(), Some(130), "{}", text(&output.stderr));
    let report = text(&output.stdout);
    assert!(report.contains(" up to t = ") && report.contains(" s; not known beyond"), "{report}");
    assert!(report.contains("1e-3 m holds until t = "), "{report}");
    let followed = run(&folder, &["inspect", "log.mcap", "--follow"]);
    assert!(text(&followed.stdout).contains(", 1e-3 m holds until t = "), "{}", text(&followed.stdout));
}

/// A report of a scene, whose warnings do not say that it is chaotic and whose accuracy is reached.
fn settled(folder: &Path, scene: &str, duration: &str) -> Value {
    let output = run(folder, &["simulate", scene, "--duration", duration, "--no-log", "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let report = json(&output.stdout);
    let words = report["warnings"].to_string();
    assert!(report["accuracy"]["reached"] == true && !words.contains("chaotic"), "{} {words}", report["accuracy"]);
    assert!(report["accuracy"]["estimated"].as_f64().is_some_and(|error| error < 1e-6), "{}", report["accuracy"]);
    report
}

#[test]
fn a_hinge_that_a_damper_stops_and_an_arm_that_motors_hold_settle_and_are_not_called_chaotic() {
    let Some(inputs) = shared("repro/events") else { return };
    let place = |report: &Value, joint: &str| report["joints"][joint]["position"].as_f64().expect("a number");
    // The spring of 1000 N m/rad against the weight of 3 kg at 0.25 m, to what an error of 1e-6 m makes of it.
    let hinge = place(&settled(&inputs, "09_settles.toml", "10"), "j");
    let torque: f64 = 1000.0 * (hinge - 0.5) + 3.0 * 9.81 * 0.25 * hinge.cos();
    assert!(torque.abs() < 1e-2, "{torque:e} N m at {hinge} rad");
    let report = settled(&inputs, "09_droop.toml", "30");
    // Both motors against the weights, worked out from the balance of torques.
    for (joint, right) in [("shoulder", 0.30273908), ("elbow", -0.85565518)] {
        let here = place(&report, joint);
        assert!((here - right).abs() < 2e-6, "{joint}: {here} rad");
    }
}

#[test]
fn an_effort_of_zero_in_a_file_is_said_to_be_read_as_no_bound_where_a_motor_would_have_it() {
    let folder = scratch("effort");
    let pendulum = |effort: &str| {
        format!(
            "<robot name=\"p\"><link name=\"base\"/><link name=\"rod\"><inertial><origin xyz=\"0.25 0 0\"/><mass value=\"3\"/>\
             <inertia ixx=\"0.1\" iyy=\"0.1\" izz=\"0.1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>\
             <joint name=\"j\" type=\"revolute\"><parent link=\"base\"/><child link=\"rod\"/><axis xyz=\"0 -1 0\"/>\
             <limit lower=\"-3\" upper=\"3\" effort=\"{effort}\" velocity=\"0\"/></joint></robot>"
        )
    };
    let says = |effort: &str, bound: &str| {
        std::fs::write(folder.join("p.urdf"), pendulum(effort)).expect("written");
        let scene = format!(
            "[[robot]]\nurdf=\"p.urdf\"\n[[motor]]\njoint=\"j\"\nkind=\"position\"\ntarget=0.0\nkp=50\nkd=5\n{bound}"
        );
        std::fs::write(folder.join("scene.toml"), scene).expect("written");
        let output = run(&folder, &["simulate", "scene.toml", "--duration", "0.1", "--no-log"]);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        [text(&output.stdout), text(&output.stderr)].concat().contains("is read as no bound")
    };
    assert!(says("0", ""));
    assert!(!says("30", "") && !says("0", "max_effort=30.0\n"));
}
