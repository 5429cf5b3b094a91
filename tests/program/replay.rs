//! `catena replay`: a log is enough to make its run again, and what differs is found.

use crate::common;
use std::path::Path;

use crate::common::command::{ENDLESS, assert_one_error, catena, folder, run, salvaged_samples, text, wait_for};
use crate::common::shared;

#[test]
fn a_log_alone_is_enough_to_make_the_run_again_bit_for_bit() {
    let folder = folder("alone");
    let motion = ["--velocity", "hinge=1", "--gravity", "0,1,-9", "--base-pose", "1,2,3,0.1,0.2,0.3"];
    for way in [&["--duration", "3"][..], &["--duration", "1", "--stages", "3", "--step", "0.013", "--rate", "100"]] {
        std::fs::write(folder.join("pendulum.urdf"), common::command::PENDULUM).expect("written");
        let arguments = [&["simulate", "pendulum.urdf", "-o", "log.mcap"], &motion[..], way].concat();
        assert_eq!(run(&folder, &arguments).status.code(), Some(0));
        std::fs::remove_file(folder.join("pendulum.urdf")).expect("removed");
        let output = run(&folder, &["replay", "log.mcap"]);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        assert!(text(&output.stdout).contains("identical"), "{}", text(&output.stdout));
    }
}

#[test]
fn bodies_and_copies_are_replayed_from_the_one_file_of_all_copies() {
    let folder = folder("copies");
    let scene = "[[robot]]\nname = \"arm\"\nurdf = \"pendulum.urdf\"\ncount = 3\nspacing = [0, 1, 0]\n\
        [[robot]]\nname = \"other\"\nurdf = \"pendulum.urdf\"\npose = { position = [2, 0, 0] }\n\
        [[body]]\nname = \"ball\"\nshape = { type = \"sphere\", radius = 0.1 }\nmass = 1\ncount = 2\nspacing = [0, 0, 0.5]\n\
        pose = { position = [9, 0, 1] }\n[[obstacle]]\nname = \"ground\"\nshape = { type = \"half_space\" }\n";
    std::fs::write(folder.join("copies.toml"), scene).expect("written");
    std::fs::write(folder.join("pendulum.urdf"), common::command::PENDULUM).expect("written");
    let output = run(&folder, &["simulate", "copies.toml", "--duration", "1"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    std::fs::remove_file(folder.join("pendulum.urdf")).expect("removed");
    let output = run(&folder, &["replay", "copies.mcap"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("identical"), "{}", text(&output.stdout));
}

#[test]
fn a_model_of_mujoco_is_replayed_without_its_file() {
    let folder = folder("mjcf");
    let model = "<mujoco><worldbody><geom type='plane' size='1 1 1'/><body name='cube' pos='0 0 1' euler='10 20 30'><freejoint/>\
        <geom type='box' size='.1 .1 .1'/></body><body name='arm' pos='2 0 1'><joint/><geom size='.1' pos='.5 0 0'/></body></worldbody>\
        <keyframe><key name='up' qpos='0 0 2 1 0 0 0 0.5'/></keyframe></mujoco>";
    std::fs::write(folder.join("cube.xml"), model).expect("written");
    let output = run(&folder, &["simulate", "cube.xml", "--keyframe", "up", "--duration", "1"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    std::fs::remove_file(folder.join("cube.xml")).expect("removed");
    let output = run(&folder, &["replay", "cube.mcap"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("identical"), "{}", text(&output.stdout));
}

#[test]
fn a_floating_robot_and_its_base_velocity_are_replayed() {
    let folder = folder("floating");
    let motion = ["--base", "floating", "--base-velocity", "1,0,2,0.1,0.2,0.3", "--duration", "1"];
    assert_eq!(run(&folder, &[&["simulate", "pendulum.urdf"], &motion[..]].concat()).status.code(), Some(0));
    assert_eq!(run(&folder, &["replay", "pendulum.mcap", "--quiet"]).status.code(), Some(0));
}

#[test]
fn a_log_that_says_something_else_is_different_from_that_instant_on() {
    let folder = folder("different");
    let log = folder.join("pendulum.mcap");
    let arguments = ["simulate", "pendulum.urdf", "--velocity", "hinge=1", "--duration", "2"];
    assert_eq!(run(&folder, &arguments).status.code(), Some(0));
    // The same messages with one bit of one pose changed in the middle of the run.
    let bytes = std::fs::read(&log).expect("a log");
    let changed = rewritten(&bytes, |topic, time, data| {
        if topic == "/tf" && time == 1_000_000_000 {
            let last = data.len() - 10;
            data[last] ^= 1;
        }
    });
    std::fs::write(&log, changed).expect("written");
    let output = run(&folder, &["replay", "pendulum.mcap"]);
    assert_one_error(&output, 1, "different");
    let error = text(&output.stderr);
    assert!(error.contains("different") && error.contains("/tf") && error.contains("t = 1 s"), "{error}");
}

#[test]
fn a_damaged_log_is_not_the_same_as_its_run() {
    let folder = folder("damaged");
    let log = folder.join("pendulum.mcap");
    let arguments = ["simulate", "pendulum.urdf", "--velocity", "hinge=1", "--duration", "4", "--rate", "500"];
    assert_eq!(run(&folder, &arguments).status.code(), Some(0));
    let whole = std::fs::read(&log).expect("a log");
    let mut damaged = whole.clone();
    damaged[whole.len() / 2] ^= 1;
    std::fs::write(&log, damaged).expect("written");
    let output = run(&folder, &["replay", "pendulum.mcap"]);
    assert_one_error(&output, 1, "damaged");
    let error = text(&output.stderr);
    assert!(error.contains("pendulum.mcap") && error.contains("cannot be read: "), "{error}");
    let before = error.split_once("; the ").and_then(|(_, said)| said.strip_suffix(" messages before are the same\n"));
    let before: usize = before.and_then(|count| count.parse().ok()).expect("a count");
    // Of 2001 samples with three messages each, and some figures.
    assert!((1000..6003).contains(&before), "{error}");
}

/// The log with its messages changed.
fn rewritten(bytes: &[u8], change: impl Fn(&str, u64, &mut Vec<u8>)) -> Vec<u8> {
    rewritten_with(bytes, |_| {}, |_| true, change)
}

/// The log with its metadata and messages changed, and with some of its attachments.
fn rewritten_with(
    bytes: &[u8],
    change_metadata: impl Fn(&mut mcap::records::Metadata),
    keep: impl Fn(&str) -> bool,
    change: impl Fn(&str, u64, &mut Vec<u8>),
) -> Vec<u8> {
    let summary = mcap::Summary::read(bytes).expect("complete").expect("with a summary");
    let options = mcap::WriteOptions::new().library("catena 0.1.0");
    let mut writer = options.create(std::io::Cursor::new(Vec::new())).expect("memory");
    for index in &summary.metadata_indexes {
        let mut record = mcap::read::metadata(bytes, index).expect("metadata");
        change_metadata(&mut record);
        writer.write_metadata(&record).expect("memory");
    }
    for index in summary.attachment_indexes.iter().filter(|index| keep(&index.name)) {
        writer.attach(&mcap::read::attachment(bytes, index).expect("an attachment")).expect("memory");
    }
    for message in mcap::MessageStream::new(bytes).expect("a log") {
        let mut message = message.expect("a message");
        let mut data = message.data.to_vec();
        change(&message.channel.topic, message.log_time, &mut data);
        message.data = data.into();
        writer.write(&message).expect("memory");
    }
    writer.finish().expect("memory");
    writer.into_inner().into_inner()
}

#[cfg(unix)]
#[test]
fn a_killed_run_is_replayed_up_to_where_its_log_ends() {
    let folder = folder("killed");
    let log = folder.join("pendulum.mcap");
    let arguments = [&["simulate", "pendulum.urdf", "--velocity", "hinge=1"], &ENDLESS[..]].concat();
    let mut child = catena(&folder, &arguments).spawn().expect("runs");
    wait_for(&mut child, "a log with samples", || salvaged_samples(&log) > 10);
    child.kill().expect("killed");
    child.wait().expect("ends");
    let output = run(&folder, &["replay", "pendulum.mcap"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("where the log ends"), "{}", text(&output.stdout));
}

#[test]
fn a_scene_with_its_robots_is_replayed_from_the_log() {
    let folder = folder("scene");
    std::fs::create_dir_all(folder.join("deep/scenes")).expect("made");
    let scene = "[[robot]]\nname = \"a\"\nurdf = \"../../pendulum.urdf\"\npositions = { hinge = 0.4 }\n\
                 [[robot]]\nname = \"b\"\nurdf = \"../../pendulum.urdf\"\npose = { position = [0, 3, 0], rpy = [0, 0, 1] }\n\
                 velocities = { hinge = 1.0 }\n[simulation]\nduration = 0.5\n";
    std::fs::write(folder.join("deep/scenes/two.toml"), scene).expect("written");
    let output = run(&folder, &["simulate", "deep/scenes/two.toml"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    std::fs::remove_dir_all(folder.join("deep")).expect("removed");
    std::fs::remove_file(folder.join("pendulum.urdf")).expect("removed");
    let output = run(&folder, &["replay", "two.mcap"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
}

/// Below the scene and elsewhere: the paths that are recorded differ.
#[test]
fn a_scene_whose_urdf_has_an_absolute_path_is_looked_at_and_replayed_from_the_log_alone() {
    for (name, place) in [("below", "scenes"), ("elsewhere", "robots")] {
        let folder = folder(name);
        for made in ["scenes", "robots"] {
            std::fs::create_dir_all(folder.join(made)).expect("made");
        }
        let urdf = folder.join(place).join("pendulum.urdf");
        std::fs::rename(folder.join("pendulum.urdf"), &urdf).expect("moved");
        let scene =
            format!("[[robot]]\nurdf = {urdf:?}\nvelocities = {{ hinge = 1.0 }}\n[simulation]\nduration = 0.5\n");
        std::fs::write(folder.join("scenes/one.toml"), scene).expect("written");
        let scene = folder.join("scenes/one.toml");
        let output = run(&folder, &["simulate", &scene.to_string_lossy()]);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        for made in ["scenes", "robots"] {
            std::fs::remove_dir_all(folder.join(made)).expect("removed");
        }
        for verb in [&["replay", "one.mcap"][..], &["inspect", "one.mcap", "--at", "0.2", "--csv", "one.csv"]] {
            let output = run(&folder, verb);
            assert_eq!(output.status.code(), Some(0), "{name}: {}", text(&output.stderr));
            assert_eq!(text(&output.stderr), "", "{name}");
        }
        let table = std::fs::read_to_string(folder.join("one.csv")).expect("a table");
        assert!(table.lines().next().is_some_and(|head| head.contains("hinge.position [rad]")), "{table}");
    }
}

/// Two links of 1 kg, the hinge of the second with friction that can hold it.
const DRIVEN: &str = r#"<robot name="arm"><link name="base"/>
    <link name="upper"><inertial><origin xyz="0 0 -0.2"/><mass value="1"/>
    <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <link name="lower"><inertial><origin xyz="0 0 -0.2"/><mass value="1"/>
    <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/></joint>
    <joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/><origin xyz="0 0 -0.4"/><axis xyz="0 1 0"/>
    <dynamics friction="0.5"/></joint></robot>"#;

#[test]
fn a_log_carries_the_tables_of_its_targets_also_those_of_one_name() {
    let folder = folder("tables");
    std::fs::write(folder.join("arm.urdf"), DRIVEN).expect("written");
    for (side, value) in [("left", 0.4), ("right", -0.7)] {
        std::fs::create_dir(folder.join(side)).expect("made");
        std::fs::write(folder.join(side).join("target.csv"), format!("0,0\n0.3,{value}\n")).expect("written");
    }
    let scene = "[[robot]]\nurdf = \"arm.urdf\"\n[simulation]\nduration = 1\n\
        [[motor]]\njoint = \"shoulder\"\nkind = \"position\"\nkp = 50\nkd = 5\ntarget = \"left/target.csv\"\n\
        [[motor]]\njoint = \"elbow\"\nkind = \"position\"\nkp = 50\nkd = 2\ntarget = \"right/target.csv\"\nperiod = 0.01\n";
    std::fs::write(folder.join("driven.toml"), scene).expect("written");
    let output = run(&folder, &["simulate", "driven.toml", "--quiet"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let log = std::fs::read(folder.join("driven.mcap")).expect("a log");
    let summary = mcap::Summary::read(&log).expect("complete").expect("with a summary");
    let names: Vec<&str> = summary.attachment_indexes.iter().map(|index| index.name.as_str()).collect();
    assert_eq!(names, ["driven.toml", "arm.urdf", "target.csv", "target.csv (2)"]);
    for made in ["left", "right"] {
        std::fs::remove_dir_all(folder.join(made)).expect("removed");
    }
    let output = run(&folder, &["replay", "driven.mcap"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let lacking = rewritten_with(&log, |_| {}, |name| name != "target.csv (2)", |_, _, _| {});
    std::fs::write(folder.join("lacking.mcap"), lacking).expect("written");
    let output = run(&folder, &["replay", "lacking.mcap"]);
    assert_one_error(&output, 2, "lacking");
    assert!(text(&output.stderr).contains("the log does not carry it"), "{}", text(&output.stderr));
}

#[test]
fn the_efforts_of_a_log_are_those_of_its_motors_and_friction() {
    let folder = folder("efforts");
    std::fs::write(folder.join("arm.urdf"), DRIVEN).expect("written");
    let scene = "[[robot]]\nurdf = \"arm.urdf\"\npositions = { elbow = 0.1 }\n[simulation]\nduration = 0.5\n\
        [[motor]]\njoint = \"shoulder\"\nkind = \"position\"\nkp = 20\nkd = 40\ntarget = 0.1\n";
    std::fs::write(folder.join("arm.toml"), scene).expect("written");
    let output = run(&folder, &["simulate", "arm.toml", "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).expect("one JSON object");
    let output = run(&folder, &["inspect", "arm.mcap", "--at", "0.5", "--json"]);
    let logged: serde_json::Value = serde_json::from_slice(&output.stdout).expect("one JSON object");
    for said in [&report, &logged] {
        let joints = &said["joints"];
        // The axes are the world's y.
        let along = |joint: &str| joints[joint]["reaction_torque"][1].as_f64().expect("a torque");
        let of = |joint: &str, what: &str| joints[joint][what].as_f64().expect("a number");
        let motor = 20.0 * (0.1 - of("shoulder", "position")) - 40.0 * of("shoulder", "velocity");
        assert!((along("shoulder") - motor).abs() < 1e-9, "{} and not {motor}", along("shoulder"));
        assert_eq!(of("elbow", "velocity"), 0.0, "held");
        assert!(along("elbow").abs() > 0.1 && along("elbow").abs() < 0.5, "{}", along("elbow"));
    }
}

/// A log may come from anybody, and says what it likes about paths.
#[test]
fn a_replay_reads_nothing_but_the_log_and_writes_nothing() {
    let folder = folder("closed");
    std::fs::write(folder.join("one.toml"), "[[robot]]\nurdf = \"pendulum.urdf\"\n").expect("written");
    assert_eq!(run(&folder, &["simulate", "one.toml", "--duration", "0.5"]).status.code(), Some(0));
    let log = std::fs::read(folder.join("one.mcap")).expect("a log");
    let planted = folder.join("planted.urdf");
    for path in [planted.to_string_lossy().into_owned(), "../planted.urdf".to_string(), "planted.urdf".to_string()] {
        let moved = rewritten_inputs(&log, |_| true, &path);
        std::fs::write(folder.join("moved.mcap"), moved).expect("written");
        let before = std::fs::read_dir(&folder).expect("readable").count();
        let output = catena(&folder, &["replay", "moved.mcap"]).env("TMPDIR", &folder).output().expect("runs");
        assert_eq!(output.status.code(), Some(0), "{path}: {}", text(&output.stderr));
        assert_eq!(std::fs::read_dir(&folder).expect("readable").count(), before, "{path}");
        assert!(!folder.join("../planted.urdf").exists());
    }
    // The URDF lies where the scene says, but that is not what was simulated.
    let lacking = rewritten_inputs(&log, |name| name != "pendulum.urdf", "pendulum.urdf");
    std::fs::write(folder.join("lacking.mcap"), lacking).expect("written");
    let output = run(&folder, &["replay", "lacking.mcap"]);
    assert_one_error(&output, 2, "lacking");
    assert!(text(&output.stderr).contains("the log does not carry it"), "{}", text(&output.stderr));
}

/// The log with some of its attachments, all of which were read from `path`.
fn rewritten_inputs(bytes: &[u8], keep: impl Fn(&str) -> bool, path: &str) -> Vec<u8> {
    let lead_to_path = |record: &mut mcap::records::Metadata| {
        for entry in record.metadata.values_mut().filter(|_| record.name == "inputs") {
            let hash = entry.split(' ').next().expect("a hash");
            *entry = format!("{hash} {path}");
        }
    };
    rewritten_with(bytes, lead_to_path, keep, |_, _, _| {})
}

#[test]
fn what_is_no_log_of_a_run_is_bad_input() {
    let folder = folder("bad");
    std::fs::write(folder.join("empty.mcap"), "").expect("written");
    std::fs::write(folder.join("words.mcap"), "not a log at all").expect("written");
    let writer = mcap::WriteOptions::new().create(std::io::Cursor::new(Vec::new()));
    let mut writer = writer.expect("memory");
    writer.finish().expect("memory");
    std::fs::write(folder.join("foreign.mcap"), writer.into_inner().into_inner()).expect("written");
    for log in ["missing.mcap", "empty.mcap", "words.mcap", "foreign.mcap", ".", "pendulum.urdf"] {
        let output = run(&folder, &["replay", log]);
        assert_one_error(&output, 2, log);
        assert!(text(&output.stderr).contains(log), "{log}: {}", text(&output.stderr));
    }
}

/// Robots as they are in the world: every kind of joint and base.
#[test]
fn real_robots_are_replayed_bit_for_bit() {
    let Some(corpus) = shared("urdf-corpus/loads") else { return };
    let folder = folder("corpus");
    for robot in ["panda", "minitaur", "romeo_small"] {
        let urdf = corpus.join(format!("{robot}.urdf"));
        let output = run(&folder, &["simulate", &urdf.to_string_lossy(), "--duration", "0.2", "--quiet"]);
        assert_eq!(output.status.code(), Some(0), "{robot}: {}", text(&output.stderr));
        let output = run(&folder, &["replay", &format!("{robot}.mcap")]);
        assert_eq!(output.status.code(), Some(0), "{robot}: {}", text(&output.stderr));
        assert!(Path::new(&folder).join(format!("{robot}.mcap")).exists());
    }
}

#[test]
fn a_run_that_goes_on_from_a_log_says_the_estimated_error_of_its_start() {
    use serde_json::Value;
    let folder = folder("went_on");
    std::fs::write(folder.join("pendulum.urdf"), common::command::PENDULUM).expect("written");
    let made = |arguments: &[&str]| -> Value {
        let output = run(&folder, &[&["simulate", "pendulum.urdf", "--json"], arguments].concat());
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        serde_json::from_slice(&output.stdout).expect("JSON")
    };
    let first = made(&["--velocity", "hinge=1", "--duration", "1", "-o", "a.mcap"]);
    assert_eq!(first.get("from_log"), None);
    let second = made(&["--from", "a.mcap@end", "--duration", "1", "-o", "b.mcap"]);
    let error = |report: &Value| report["accuracy"]["estimated"].as_f64().expect("an error");
    let at_start = |report: &Value| report["from_log"]["estimated_error"].as_f64();
    assert_eq!(second["from_log"]["time"].as_f64(), Some(1.0));
    assert_eq!(at_start(&second), Some(error(&first)));
    // The errors of a chain of runs add up.
    let third = made(&["--from", "b.mcap@1.5", "--duration", "1", "-o", "c.mcap"]);
    assert_eq!(at_start(&third), Some(error(&second) + error(&first)));
    // Without an estimate nothing is known of what follows either.
    made(&["--no-estimate", "--velocity", "hinge=1", "--duration", "1", "-o", "d.mcap"]);
    made(&["--from", "d.mcap@end", "--duration", "1", "-o", "e.mcap"]);
    let unknown = made(&["--from", "e.mcap@end", "--duration", "1", "-o", "f.mcap"]);
    assert!(unknown["from_log"]["estimated_error"].is_null(), "{unknown}");
    let said = run(&folder, &["simulate", "pendulum.urdf", "--from", "e.mcap@end", "--duration", "1", "--no-log"]);
    assert!(text(&said.stdout).contains("which does not say its error"), "{}", text(&said.stdout));
}

#[test]
fn an_instant_outside_a_log_is_said_to_be_there() {
    let folder = folder("outside");
    std::fs::write(folder.join("pendulum.urdf"), common::command::PENDULUM).expect("written");
    let output = run(&folder, &["simulate", "pendulum.urdf", "--duration", "1", "-o", "a.mcap"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let said = |at: &str| text(&run(&folder, &["inspect", "a.mcap", &format!("--at={at}")]).stderr).to_string();
    assert!(said("5").contains("t = 5 s is beyond its end; its last sample is at t = 1 s"), "{}", said("5"));
    assert!(said("-1").contains("t = -1 s is before its first sample, at t = 0 s"), "{}", said("-1"));
    // Between samples the nearest is shown, as the help says.
    assert_eq!([said("0"), said("0.501"), said("1")], [const { String::new() }; 3]);
}
