//! Whatever happens to a run, its log is there, and so is the log of the last run that finished.
#![cfg(unix)]

use catena::output::log::reading::decode::log_line;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use crate::common::Numbers;
use crate::common::command::{
    ENDLESS, assert_one_error, catena, folder, run, salvaged, salvaged_samples, text, wait_for,
};

const SIMULATE: [&str; 4] = ["simulate", "pendulum.urdf", "--velocity", "hinge=1"];

fn endless() -> Vec<&'static str> {
    [&SIMULATE[..], &ENDLESS].concat()
}

/// Every sample from the first to the last, once, and what viewers need to show them.
fn assert_whole_up_to_its_end(log: &[u8], least: usize) {
    let samples = salvaged(log, "/tf");
    assert!(samples.len() >= least, "{} samples of {least} are left", samples.len());
    for (index, sample) in samples.iter().enumerate() {
        assert_eq!(sample.log_time, index as u64 * 1_000_000_000, "no sample is missing before the last");
    }
    assert_eq!(salvaged(log, "/robot_description").len(), 1);
}

#[test]
fn a_run_killed_at_any_moment_leaves_what_was_readable_before() {
    let folder = folder("kill");
    let log = folder.join("pendulum.mcap");
    let mut numbers = Numbers::new(5);
    // With a step of 0.01 s chunks fill many times a second; with 1e-5 s in minutes only, which nobody here waits for.
    for step in ["0.01", "0.01", "0.00001", "0.00001"] {
        let arguments = endless().into_iter().map(|word| if word == "0.01" { step } else { word }).collect::<Vec<_>>();
        let mut child = catena(&folder, &arguments).spawn().expect("runs");
        wait_for(&mut child, "a log with samples", || salvaged_samples(&log) > 3);
        std::thread::sleep(Duration::from_millis(numbers.next(0.0, 1500.0) as u64));
        let seen = salvaged_samples(&log);
        child.kill().expect("killed");
        child.wait().expect("ends");
        assert_whole_up_to_its_end(&std::fs::read(&log).expect("a log"), seen);
        std::fs::remove_file(&log).expect("removed");
    }
}

#[test]
fn a_finished_log_outlives_the_runs_that_do_not_finish() {
    let folder = folder("precious");
    let (log, beside) = (folder.join("pendulum.mcap"), folder.join("pendulum.unfinished.mcap"));
    let finished = [&SIMULATE[..], &["--duration", "0.5"]].concat();
    assert_eq!(run(&folder, &finished).status.code(), Some(0));
    let bytes = std::fs::read(&log).expect("a log");
    // Killed.
    let mut child = catena(&folder, &endless()).spawn().expect("runs");
    wait_for(&mut child, "a log with samples", || salvaged_samples(&beside) > 10);
    child.kill().expect("killed");
    child.wait().expect("ends");
    assert!(std::fs::read(&log).expect("a log") == bytes);
    assert_whole_up_to_its_end(&std::fs::read(&beside).expect("a log"), 11);
    // Interrupted: the message says where the log is.
    std::fs::remove_file(&beside).expect("removed");
    let mut child = catena(&folder, &endless()).spawn().expect("runs");
    wait_for(&mut child, "a new log", || salvaged_samples(&beside) > 10);
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill runs").success());
    let output = child.wait_with_output().expect("ends");
    assert_eq!(output.status.code(), Some(130));
    assert!(text(&output.stderr).contains("pendulum.unfinished.mcap"), "{}", text(&output.stderr));
    assert!(std::fs::read(&log).expect("a log") == bytes);
    // Failed: a spin whose kinetic energy is beyond the range of doubles.
    let output = run(&folder, &["simulate", "pendulum.urdf", "--velocity", "hinge=1e100", "--quiet"]);
    assert_one_error(&output, 1, "failed");
    assert!(std::fs::read(&log).expect("a log") == bytes);
    let failed = std::fs::read(&beside).expect("a log");
    let lines = salvaged(&failed, "/rosout");
    let last = log_line(&lines.last().expect("a line").data).expect("a line of text");
    assert!(text(&output.stderr).contains(&last.text), "{} {}", last.text, text(&output.stderr));
    // Finished: the output is replaced, and nothing is left beside it.
    assert_eq!(run(&folder, &[&finished[..], &["--rate", "10"]].concat()).status.code(), Some(0));
    assert!(std::fs::read(&log).expect("a log") != bytes);
    assert!(!beside.exists());
}

#[test]
fn a_finished_log_whose_index_is_damaged_outlives_them_too() {
    let folder = folder("damaged_index");
    let log = folder.join("pendulum.mcap");
    assert_eq!(run(&folder, &[&SIMULATE[..], &["--duration", "0.5"]].concat()).status.code(), Some(0));
    let mut bytes = std::fs::read(&log).expect("a log");
    // Where the summary begins, as the footer has it: before the end magic, the checksum and another such number.
    let place = bytes.len() - 8 - 4 - 8 - 8;
    bytes[place] ^= 1;
    std::fs::write(&log, &bytes).expect("written");
    let output = run(&folder, &["simulate", "pendulum.urdf", "--velocity", "hinge=1e100", "--quiet"]);
    assert_one_error(&output, 1, "failed");
    assert!(std::fs::read(&log).expect("a log") == bytes);
}

#[test]
fn any_other_file_is_replaced_by_a_finished_run_only() {
    let folder = folder("foreign");
    let log = folder.join("pendulum.mcap");
    std::fs::write(&log, b"not a log at all").expect("written");
    let output = run(&folder, &["simulate", "pendulum.urdf", "--velocity", "hinge=1e100", "--quiet"]);
    assert_one_error(&output, 1, "failed");
    assert_eq!(std::fs::read(&log).expect("still there"), b"not a log at all");
    assert_eq!(run(&folder, &[&SIMULATE[..], &["--duration", "0.5"]].concat()).status.code(), Some(0));
    assert!(mcap::Summary::read(&std::fs::read(&log).expect("a log")).is_ok());
}

#[test]
fn two_runs_do_not_write_one_log() {
    let folder = folder("two");
    let log = folder.join("pendulum.mcap");
    let mut child = catena(&folder, &endless()).spawn().expect("runs");
    wait_for(&mut child, "a log with samples", || salvaged_samples(&log) > 10);
    let output = run(&folder, &endless());
    child.kill().expect("killed");
    child.wait().expect("ends");
    assert_one_error(&output, 2, "second run");
    assert!(text(&output.stderr).contains("another run"), "{}", text(&output.stderr));
}

/// The system ends a process that writes more than it may, unless it says otherwise.
#[test]
fn a_disk_that_fills_up_is_an_error_with_the_path_and_the_log_is_complete_up_to_there() {
    let folder = folder("limit");
    let command = format!("ulimit -f 2000; exec {} {}", env!("CARGO_BIN_EXE_catena"), endless().join(" "));
    let output =
        Command::new("sh").current_dir(&folder).args(["-c", &command]).stdin(Stdio::null()).output().expect("runs");
    assert_ended_by_disk(&output, "pendulum.mcap");
    let log = std::fs::read(folder.join("pendulum.mcap")).expect("a log");
    let messages: Result<Vec<_>, _> = mcap::MessageStream::new(&log).expect("a complete log").collect();
    assert!(messages.expect("every message is readable").len() > 100);
    assert_whole_up_to_its_end(&log, 100);
    // 2000 blocks of 512 bytes, of which the last chunk that did not fit is missing.
    assert!(log.len() > 2000 * 512 - 100_000, "{} bytes", log.len());
}

#[test]
fn a_disk_that_fills_up_leaves_the_finished_log_and_any_other_file_is_reported_as_well() {
    let folder = folder("limit_twice");
    assert!(run(&folder, &["simulate", "pendulum.urdf", "--duration", "20", "--rate", "1000"]).status.success());
    let finished = std::fs::read(folder.join("pendulum.mcap")).expect("a log");
    let limited = |arguments: &[&str]| {
        let command = format!("ulimit -f 1500; exec {} {}", env!("CARGO_BIN_EXE_catena"), arguments.join(" "));
        let mut shell = Command::new("sh");
        shell.current_dir(&folder).args(["-c", &command]).stdin(Stdio::null()).output().expect("runs")
    };
    let output = limited(&endless());
    assert_ended_by_disk(&output, "pendulum.mcap");
    assert!(std::fs::read(folder.join("pendulum.mcap")).expect("a log") == finished);
    let beside = std::fs::read(folder.join("pendulum.unfinished.mcap")).expect("what there is of the second run");
    assert_whole_up_to_its_end(&beside, 100);

    let output = limited(&["inspect", "pendulum.mcap", "--csv", "table.csv"]);
    assert_eq!(output.status.code(), Some(1), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("table.csv"), "{}", text(&output.stderr));
}

fn assert_ended_by_disk(output: &Output, path: &str) {
    let error = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{error}");
    assert!(error.starts_with("catena: error: cannot write") && error.contains(path), "{error}");
    assert_eq!(error.lines().count(), 1, "{error}");
}

#[test]
fn a_pipe_that_is_closed_is_an_error_with_the_path() {
    if !Path::new("/dev/stdout").exists() {
        println!("skipped: this system has no /dev/stdout");
        return;
    }
    let folder = folder("pipe");
    let mut child =
        catena(&folder, &[&endless()[..], &["-o", "/dev/stdout", "--quiet"]].concat()).spawn().expect("runs");
    drop(child.stdout.take());
    assert_ended_by_disk(&child.wait_with_output().expect("ends"), "/dev/stdout");
}

#[test]
fn links_stay_links_and_what_stands_beside_a_log_is_not_written_through_one() {
    let folder = folder("links");
    assert_eq!(run(&folder, &[&SIMULATE[..], &["--duration", "0.5"]].concat()).status.code(), Some(0));
    std::fs::write(folder.join("old.csv"), "old").expect("written");
    for (link, target) in [("table.csv", "old.csv"), ("new.csv", "later.csv")] {
        std::os::unix::fs::symlink(target, folder.join(link)).expect("linked");
        let output = run(&folder, &["inspect", "pendulum.mcap", "--csv", link]);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        assert!(folder.join(link).is_symlink());
        assert!(std::fs::read_to_string(folder.join(target)).expect("a table").starts_with("time [s]"), "{target}");
    }
    // The place of a log that is being written, in a folder where others may write.
    std::os::unix::fs::symlink("old.csv", folder.join("pendulum.unfinished.mcap")).expect("linked");
    let table = std::fs::read(folder.join("old.csv")).expect("a table");
    let output = run(&folder, &SIMULATE);
    assert_one_error(&output, 2, "a link");
    assert!(std::fs::read(folder.join("old.csv")).expect("a table") == table);
}

#[test]
fn a_signal_that_comes_twice_at_once_is_one() {
    let folder = folder("twice");
    let log = folder.join("pendulum.mcap");
    let mut child = catena(&folder, &endless()).spawn().expect("runs");
    wait_for(&mut child, "a log with samples", || salvaged_samples(&log) > 10);
    // As `timeout` does, to the process and to its group; two kinds, because two of one kind may become one on the way.
    let twice = format!("kill -TERM {0}; kill -INT {0}", child.id());
    assert!(Command::new("sh").args(["-c", &twice]).status().expect("kill runs").success());
    assert_eq!(child.wait_with_output().expect("ends").status.code(), Some(130));
    assert!(mcap::Summary::read(&std::fs::read(&log).expect("a log")).expect("a whole log").is_some());
}

#[test]
fn following_a_log_ends_when_nobody_reads_what_is_said_of_it() {
    let folder = folder("follow_pipe");
    let log = folder.join("pendulum.mcap");
    let mut child = catena(&folder, &endless()).spawn().expect("runs");
    wait_for(&mut child, "a log with samples", || salvaged_samples(&log) > 10);
    let mut follower = catena(&folder, &["inspect", "pendulum.mcap", "--follow"]).spawn().expect("runs");
    drop(follower.stdout.take());
    let mut left = 200;
    while follower.try_wait().expect("asked").is_none() && left > 0 {
        std::thread::sleep(Duration::from_millis(50));
        left -= 1;
    }
    let ended = follower.try_wait().expect("asked");
    follower.kill().ok();
    child.kill().expect("killed");
    child.wait().expect("ends");
    assert!(ended.is_some_and(|status| status.success()), "{ended:?}");
}
