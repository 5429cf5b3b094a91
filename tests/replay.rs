//! `catena replay`: a log is enough to make its run again, and what differs is found.

use std::path::Path;

mod common;
use common::command::{ENDLESS, assert_one_error, catena, folder, run, salvaged_samples, text, wait_for};
use common::shared;

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
    let summary = mcap::Summary::read(bytes).expect("complete").expect("with a summary");
    let options = mcap::WriteOptions::new().library("catena 0.1.0");
    let mut writer = options.create(std::io::Cursor::new(Vec::new())).expect("memory");
    for index in &summary.metadata_indexes {
        writer.write_metadata(&mcap::read::metadata(bytes, index).expect("metadata")).expect("memory");
    }
    for index in &summary.attachment_indexes {
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
