//! Inputs that never end and outputs that nobody reads: an error in plain words, and no waiting in silence.
#![cfg(unix)]

use crate::common::command::{ENDLESS, assert_one_error, catena, folder, run, text};
use std::fs::File;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

fn pipe(folder: &Path) -> bool {
    let made = Command::new("mkfifo").current_dir(folder).arg("pipe.mcap").status();
    let made = made.is_ok_and(|status| status.success());
    if !made {
        println!("skipped: this system has no mkfifo");
    }
    made
}

/// Sends one Ctrl-C after a while, and returns how the process ended, if it did within some seconds.
fn interrupted_once(mut child: Child) -> (Option<i32>, String) {
    std::thread::sleep(Duration::from_millis(1500));
    assert!(child.try_wait().expect("asked").is_none(), "it waits");
    let signalled = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill");
    assert!(signalled.success());
    let begun = Instant::now();
    while begun.elapsed() < Duration::from_secs(10) {
        if child.try_wait().expect("asked").is_some() {
            let output = child.wait_with_output().expect("ended");
            return (output.status.code(), text(&output.stderr).to_string());
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    child.kill().expect("killed");
    child.wait().expect("ended");
    (None, String::new())
}

#[test]
fn an_output_without_a_reader_ends_with_the_first_signal() {
    let folder = folder("unread");
    if !pipe(&folder) {
        return;
    }
    let child = catena(&folder, &["simulate", "pendulum.urdf", "-o", "pipe.mcap"]).spawn().expect("runs");
    let (code, error) = interrupted_once(child);
    assert_eq!(code, Some(130), "{error}");
    assert!(error.contains("waiting for a reader of pipe.mcap") && error.lines().count() == 1, "{error}");
}

#[test]
fn an_output_whose_reader_does_not_read_ends_with_the_first_signal() {
    let folder = folder("stalled");
    if !pipe(&folder) {
        return;
    }
    let arguments = [&["simulate", "pendulum.urdf", "-o", "pipe.mcap", "--quiet"], &ENDLESS[..]].concat();
    let child = catena(&folder, &arguments).spawn().expect("runs");
    // Opened, and never read.
    let reader = File::open(folder.join("pipe.mcap")).expect("opened");
    let (code, error) = interrupted_once(child);
    drop(reader);
    assert_eq!(code, Some(130), "{error}");
}

#[test]
fn a_pipe_that_is_read_gets_the_whole_log() {
    let folder = folder("read");
    if !pipe(&folder) {
        return;
    }
    let child =
        catena(&folder, &["simulate", "pendulum.urdf", "-o", "pipe.mcap", "--duration", "20"]).spawn().expect("runs");
    let log = std::fs::read(folder.join("pipe.mcap")).expect("read");
    assert!(child.wait_with_output().expect("ends").status.success());
    assert!(mcap::Summary::read(&log).is_ok_and(|summary| summary.is_some()), "a complete log");
}

#[test]
fn a_link_to_what_is_not_there_yet_stays_and_its_target_becomes_the_log() {
    let folder = folder("dangling");
    std::fs::create_dir(folder.join("logs")).expect("made");
    symlink("second.mcap", folder.join("first.mcap")).expect("linked");
    symlink("logs/target.mcap", folder.join("second.mcap")).expect("linked");
    let output = run(&folder, &["simulate", "pendulum.urdf", "-o", "first.mcap", "--duration", "0.1"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(folder.join("first.mcap").is_symlink() && folder.join("second.mcap").is_symlink());
    assert!(folder.join("logs/target.mcap").is_file() && !folder.join("logs/target.mcap").is_symlink());
}

#[test]
fn inputs_that_are_too_large_or_never_end_are_errors() {
    let folder = folder("endless");
    let large = File::create(folder.join("large.urdf")).expect("created");
    large.set_len(100_000_001).expect("a hole");
    assert_one_error(&run(&folder, &["model", "large.urdf"]), 2, "large");
    let output = run(&folder, &["simulate", "large.urdf"]);
    assert!(text(&output.stderr).contains("larger than 100 MB"), "{}", text(&output.stderr));
    for device in ["/dev/zero", "/dev/null"] {
        let output = run(&folder, &["model", device]);
        assert_one_error(&output, 2, device);
        assert!(text(&output.stderr).contains("device"), "{device}: {}", text(&output.stderr));
    }
    let command = format!("yes | {} model /dev/stdin", env!("CARGO_BIN_EXE_catena"));
    let output = Command::new("sh").args(["-c", &command]).stdin(Stdio::null()).output().expect("runs");
    assert_one_error(&output, 2, "a pipe without end");
    assert!(text(&output.stderr).contains("larger than 100 MB"), "{}", text(&output.stderr));
    // A pipe that ends is an input like any other.
    let command = format!("cat pendulum.urdf | {} model /dev/stdin", env!("CARGO_BIN_EXE_catena"));
    let output = Command::new("sh").current_dir(&folder).args(["-c", &command]).output().expect("runs");
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
}
