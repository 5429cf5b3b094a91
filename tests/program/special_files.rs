//! Inputs that never end and outputs that nobody reads: an error in plain words, and no waiting in silence.
#![cfg(unix)]

use crate::common::command::{ENDLESS, assert_one_error, catena, folder, run, text};
use std::fs::File;
use std::io::Read;
use std::os::unix::fs::{FileTypeExt, symlink};
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
fn a_page_into_a_pipe_leaves_the_pipe_where_it_is() {
    let folder = folder("page_into_pipe");
    if !pipe(&folder) {
        return;
    }
    let page = folder.join("page.html");
    std::fs::rename(folder.join("pipe.mcap"), &page).expect("renamed");
    let child = catena(&folder, &["model", "pendulum.urdf", "-o", "page.html"]).spawn().expect("runs");
    let written = std::fs::read_to_string(&page).expect("read");
    assert!(child.wait_with_output().expect("ends").status.success());
    assert!(written.ends_with("</html>\n") || written.ends_with("</html>"), "a whole page");
    assert!(page.metadata().expect("there").file_type().is_fifo(), "it is a pipe still");
}

/// The time, the topic and the content of every message of a complete log.
fn complete(log: &[u8]) -> Vec<(u64, String, Vec<u8>)> {
    assert!(mcap::Summary::read(log).is_ok_and(|summary| summary.is_some()), "a complete log");
    let messages = mcap::MessageStream::new(log).expect("a log").map(|message| message.expect("readable"));
    messages.map(|message| (message.log_time, message.channel.topic.clone(), message.data.to_vec())).collect()
}

/// How a log says that its run ended.
fn outcome(log: &[u8]) -> String {
    let summary = mcap::Summary::read(log).expect("a log").expect("a complete one");
    let last = summary.metadata_indexes.iter().rfind(|index| index.name == "end").expect("an end");
    mcap::read::metadata(log, last).expect("readable").metadata["outcome"].clone()
}

/// What a child writes into the pipe, until it closes it.
fn read_pipe(folder: &Path) -> std::thread::JoinHandle<Vec<u8>> {
    let pipe = folder.join("pipe.mcap");
    std::thread::spawn(move || std::fs::read(pipe).expect("read"))
}

#[test]
fn a_pipe_gets_the_messages_of_the_file_also_of_a_run_that_restarted() {
    let folder = folder("restarted");
    if !pipe(&folder) {
        return;
    }
    let mut restarted = 0;
    for (robot, tolerance) in [("arm7.urdf", "1e-6"), ("heavy_top_fast.toml", "1e-9"), ("chain_10.urdf", "1e-3")] {
        let input = format!("{}/robots/{robot}", env!("CARGO_MANIFEST_DIR"));
        let words = ["simulate", &input, "--duration", "5", "--tolerance", tolerance, "--quiet", "-o"];
        let output = run(&folder, &[&words[..], &["file.mcap"]].concat());
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        let reader = read_pipe(&folder);
        let child = catena(&folder, &[&words[..], &["pipe.mcap"]].concat()).spawn().expect("runs");
        let piped = reader.join().expect("read");
        assert!(child.wait_with_output().expect("ends").status.success());
        let (file, piped) = (complete(&std::fs::read(folder.join("file.mcap")).expect("a log")), complete(&piped));
        assert!(file == piped, "{robot}: {} and {} messages", file.len(), piped.len());
        let says = |(_, topic, data): &(u64, String, Vec<u8>)| {
            topic == "/rosout" && data.windows(15).any(|part| part == b"restarted after")
        };
        restarted += file.iter().filter(|message| says(message)).count();
    }
    assert!(restarted > 0, "none of them restarted, so that nothing was shown");
}

/// With a tolerance nothing of it is in the pipe when the signal comes; its reader is slow.
#[test]
fn a_run_into_a_pipe_that_is_interrupted_leaves_a_complete_log_of_what_it_had_reached() {
    let folder = folder("interrupted");
    if !pipe(&folder) {
        return;
    }
    let words =
        ["simulate", "pendulum.urdf", "--velocity", "hinge=1", "--duration", "1e7", "--quiet", "-o", "pipe.mcap"];
    let mut child = catena(&folder, &words).spawn().expect("runs");
    let mut pipe = File::open(folder.join("pipe.mcap")).expect("opened");
    let reader = std::thread::spawn(move || {
        let (mut log, mut piece) = (Vec::new(), vec![0; 1 << 16]);
        loop {
            match pipe.read(&mut piece).expect("read") {
                0 => return log,
                count => log.extend_from_slice(&piece[..count]),
            }
            if log.len() < 1 << 20 {
                std::thread::sleep(Duration::from_millis(20));
            }
        }
    });
    std::thread::sleep(Duration::from_millis(1500));
    assert!(child.try_wait().expect("asked").is_none(), "it goes on");
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill").success());
    let log = reader.join().expect("read");
    assert_eq!(child.wait_with_output().expect("ends").status.code(), Some(130));
    assert_eq!(outcome(&log), "interrupted");
    assert!(complete(&log).iter().filter(|(_, topic, _)| topic == "/tf").count() > 100);
}

#[test]
fn an_output_whose_reader_does_not_read_ends_with_the_first_signal_also_where_the_log_is_held_back() {
    let folder = folder("stalled_at_the_end");
    if !pipe(&folder) {
        return;
    }
    let words =
        ["simulate", "pendulum.urdf", "--velocity", "hinge=1", "--duration", "1e7", "--quiet", "-o", "pipe.mcap"];
    let child = catena(&folder, &words).spawn().expect("runs");
    let reader = File::open(folder.join("pipe.mcap")).expect("opened");
    let (code, error) = interrupted_once(child);
    drop(reader);
    assert_eq!(code, Some(130), "{error}");
}

/// Without a folder for temporary files a run has the memory that it may use, and no more.
#[test]
fn a_log_that_cannot_be_held_back_is_an_error_that_says_so_and_the_pipe_gets_what_there_is() {
    let folder = folder("no_room");
    if !pipe(&folder) {
        return;
    }
    let words =
        ["simulate", "pendulum.urdf", "--velocity", "hinge=1", "--duration", "1e4", "--rate", "100", "-o", "pipe.mcap"];
    let reader = read_pipe(&folder);
    let missing = folder.join("nowhere");
    let child = catena(&folder, &words).env("TMPDIR", &missing).spawn().expect("runs");
    let log = reader.join().expect("read");
    let output = child.wait_with_output().expect("ends");
    let error = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{error}");
    assert!(error.contains("held back in") && error.contains("nowhere"), "{error}");
    // Closed without a summary; the 8 MiB that fit into memory are there.
    let messages: Result<Vec<_>, _> = mcap::MessageStream::new(&log).expect("an end").collect();
    assert!(log.len() > 7 << 20 && messages.expect("every message is readable").len() > 1000, "{} bytes", log.len());
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
