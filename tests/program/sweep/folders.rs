//! What is on the disk: whatever ends a sweep, and in how many parts it is made.

use super::{MIXED, files, folder, sweep, table};
use crate::common::command::{assert_one_error, catena, run, text, wait_for};
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

/// Runs of a few milliseconds each: 300 of them.
const LONG: &str = "[sweep]\nscene = \"pendulum.urdf\"\nsamples = 300\nrows_per_file = 64\n\
    [simulation]\nduration = 10\nstages = 2\nstep = 0.002\n\
    [[vary]]\nkey = \"positions.hinge\"\nuniform = [-1.0, 1.0]\n[[vary]]\nkey = \"rod.mass\"\nuniform = [1.0, 2.0]\n";

fn has_journal(folder: &Path) -> bool {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    entries.into_iter().any(|entry| entry.file_name().to_string_lossy().ends_with(".journal"))
}

/// What a sweep says of rows that were there before.
fn there(folder: &Path, options: &[&str]) -> u64 {
    let arguments = [&["sweep", "sweep.toml", "--format", "csv", "--json", "-o"], options].concat();
    let output = run(folder, &arguments);
    let said: serde_json::Value =
        serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{}", text(&output.stderr)));
    assert_eq!(said["done"], said["runs"]);
    said["done"].as_u64().unwrap() - said["made"].as_u64().unwrap()
}

#[test]
fn a_row_that_was_reported_survives_a_kill_and_the_rest_is_made_to_the_same_bytes() {
    let folder = folder("sweep_kill", LONG);
    sweep(&folder, &["-o", "whole"]);
    let mut kills = 0;
    for number in 0..6 {
        let out = format!("killed{number}");
        // Killed again and again, each time a little after other reports.
        let mut reported = 0;
        for _ in 0..2 {
            let arguments = ["sweep", "sweep.toml", "--format", "csv", "-o", &out, "--progress", "0"];
            let mut child = catena(&folder, &arguments).stderr(Stdio::piped()).spawn().expect("catena runs");
            let lines = BufReader::new(child.stderr.take().expect("piped")).lines();
            for (count, line) in lines.map_while(Result::ok).enumerate() {
                let Some(done) =
                    line.strip_prefix("catena: ").and_then(|line| line.split(' ').next()?.parse::<u64>().ok())
                else {
                    continue;
                };
                assert!(done >= reported, "{line}: {reported} were reported before");
                reported = done;
                // The first report is what was there before.
                if count > 0 && done < 300 {
                    std::thread::sleep(Duration::from_millis(83 * number));
                    break;
                }
            }
            child.kill().expect("killed");
            kills += usize::from(!child.wait().expect("ended").success());
        }
        let before = there(&folder, &[&out]);
        assert!(before >= reported, "{before} of {reported} rows that were reported are there");
        assert!(files(&folder.join(&out)) == files(&folder.join("whole")), "byte for byte, and no journal is left");
    }
    // On a machine where all runs are over before the first report nothing was tried.
    assert!(kills > 0, "no kill came before the end");
}

#[test]
fn an_interrupted_sweep_says_how_far_it_came_and_goes_on() {
    let folder = folder("sweep_interrupted", &LONG.replace("samples = 300", "samples = 100000"));
    let mut child =
        catena(&folder, &["sweep", "sweep.toml", "--format", "csv", "-o", "out"]).spawn().expect("catena runs");
    wait_for(&mut child, "a journal", || has_journal(&folder.join("out")));
    std::thread::sleep(Duration::from_millis(700));
    let killed =
        std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill runs");
    assert!(killed.success());
    let output = child.wait_with_output().expect("ended");
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{said}");
    assert!(
        said.starts_with("catena: error: interrupted; ")
            && said.contains(" of 100000 runs are done: the same command goes on"),
        "{said}"
    );
    let done: u64 = said.split([' ']).nth(3).and_then(|word| word.parse().ok()).unwrap_or_else(|| panic!("{said}"));
    assert!(done > 0, "{said}");
    // Another process that is let go on says the same before it makes any.
    let mut child = catena(&folder, &["sweep", "sweep.toml", "--format", "csv", "-o", "out", "--progress", "0"])
        .spawn()
        .expect("catena runs");
    let mut lines = BufReader::new(child.stderr.take().expect("piped")).lines();
    assert_eq!(lines.next().unwrap().unwrap(), format!("catena: {done} of 100000 runs are done"));
    child.kill().expect("killed");
    child.wait().expect("ended");
}

#[test]
fn shards_merged_are_the_whole_byte_for_byte() {
    let folder = folder("sweep_shards", MIXED);
    sweep(&folder, &["-o", "whole"]);
    for count in [1, 3, 5, 40] {
        let shards: Vec<String> = (1..=count).map(|number| format!("of{count}_{number}")).collect();
        for (number, out) in shards.iter().enumerate() {
            sweep(&folder, &["-o", out, "--shard", &format!("{}/{count}", number + 1)]);
        }
        let rows: usize = shards.iter().map(|shard| table(&folder.join(shard)).len()).sum();
        assert_eq!(rows, 24, "each in one shard");
        let merged = format!("merged{count}");
        let given: Vec<&str> = shards.iter().rev().map(String::as_str).collect();
        let output = run(&folder, &[&["sweep", "-o", &merged, "--merge"], &given[..]].concat());
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        assert!(files(&folder.join(&merged)) == files(&folder.join("whole")), "{count} shards");
        // What was merged is the sweep, with nothing left to do.
        assert_eq!(there(&folder, &[&merged]), 24);
    }
}

#[test]
fn what_does_not_belong_together_is_not_merged() {
    let folder = folder("sweep_unmerged", MIXED);
    for (out, shard) in [("a", "1/3"), ("b", "2/3"), ("c", "3/3"), ("d", "1/2")] {
        sweep(&folder, &["-o", out, "--shard", shard]);
    }
    std::fs::write(folder.join("sweep.toml"), MIXED.replace("seed = 3", "seed = 4")).unwrap();
    sweep(&folder, &["-o", "other", "--shard", "3/3"]);
    let incomplete = folder.join("c/rows-0000000000000016-0000000000000019.csv");
    let refused = |given: &[&str], said: &str| {
        let output = run(&folder, &[&["sweep", "-o", "merged", "--merge"], given].concat());
        assert_one_error(&output, 2, said);
        assert!(text(&output.stderr).contains(said), "{said}: {}", text(&output.stderr));
        assert!(!folder.join("merged").exists());
    };
    refused(&["a", "b"], "shard 3/3 is missing");
    refused(&["a", "b", "c", "b"], "shard 2/3 is given twice");
    refused(&["a", "d"], "one of 2 shards");
    refused(&["a", "b", "other"], "of another sweep");
    refused(&["a", "nothing"], "there is no sweep.json");
    std::fs::remove_file(&incomplete).unwrap();
    refused(&["a", "b", "c"], "shard 3/3 is not complete");
}

#[test]
fn a_folder_of_something_else_is_refused_with_what_to_do() {
    let folder = folder("sweep_refused", MIXED);
    sweep(&folder, &["-o", "out"]);
    let before = files(&folder.join("out"));
    let refused = |options: &[&str], said: &str| {
        let output = run(&folder, &[&["sweep", "sweep.toml"], options].concat());
        assert_one_error(&output, 2, said);
        assert!(text(&output.stderr).contains(said), "{said}: {}", text(&output.stderr));
    };
    refused(
        &["-o", "out", "--format", "csv", "--shard", "1/2"],
        "it holds shard 1/1 of this sweep, and 1/2 is wanted; remove it, or give another folder",
    );
    refused(&["-o", "pendulum.urdf"], "it is not a folder");
    std::fs::create_dir(folder.join("mine")).unwrap();
    std::fs::write(folder.join("mine/notes"), "").unwrap();
    refused(&["-o", "mine"], "it holds \"notes\" and is of no sweep; give a new or empty folder");
    refused(&["-o", "pendulum.urdf/below"], "cannot use pendulum.urdf/below");
    std::fs::write(folder.join("sweep.toml"), MIXED.replace("to = 3.0", "to = 4.0")).unwrap();
    refused(&["-o", "out", "--format", "csv"], "it holds the sweep \"sweep\" of other numbers");
    // A robot that has changed is another sweep, too.
    std::fs::write(folder.join("sweep.toml"), MIXED).unwrap();
    let robot = std::fs::read_to_string(folder.join("pendulum.urdf")).unwrap();
    std::fs::write(folder.join("pendulum.urdf"), robot.replace("izz=\"0.01\"", "izz=\"0.02\"")).unwrap();
    refused(&["-o", "out", "--format", "csv"], "of other numbers, another scene");
    assert!(files(&folder.join("out")) == before);
    let entries = std::fs::read_dir(folder.join("mine")).unwrap().count();
    assert_eq!(entries, 1, "nothing was put into a folder of somebody else");
}

#[test]
fn two_processes_do_not_write_into_one_folder() {
    let folder = folder("sweep_locked", &LONG.replace("samples = 300", "samples = 100000"));
    let mut child =
        catena(&folder, &["sweep", "sweep.toml", "--format", "csv", "-o", "out"]).spawn().expect("catena runs");
    wait_for(&mut child, "a journal", || has_journal(&folder.join("out")));
    let output = run(&folder, &["sweep", "sweep.toml", "--format", "csv", "-o", "out"]);
    child.kill().expect("killed");
    child.wait().expect("ended");
    assert_one_error(&output, 2, "locked");
    assert!(text(&output.stderr).contains("another process writes to it"), "{}", text(&output.stderr));
}

#[cfg(unix)]
#[test]
fn a_full_disk_ends_the_sweep_by_name_and_what_was_there_is_gone_on_with() {
    let folder = folder(
        "sweep_full",
        &LONG.replace("duration = 10", "duration = 0.02").replace("samples = 300", "samples = 3000"),
    );
    sweep(&folder, &["-o", "whole"]);
    // Files of at most 8 kB, of which those of rows have some 12.
    let program = env!("CARGO_BIN_EXE_catena");
    let limited = format!("ulimit -f 8; exec {program} sweep sweep.toml --format csv -o out");
    let output =
        std::process::Command::new("bash").current_dir(&folder).args(["-c", &limited]).output().expect("bash runs");
    assert_one_error(&output, 1, "full");
    let said = text(&output.stderr);
    assert!(said.contains("cannot write out/rows-") && said.contains("File too large"), "{said}");
    let whole = files(&folder.join("whole"));
    let complete = files(&folder.join("out")).into_iter().filter(|(name, _)| name.ends_with(".csv"));
    assert!(
        complete.into_iter().all(|(name, bytes)| whole[&name] == bytes),
        "what has the name of a whole file is whole"
    );
    sweep(&folder, &["-o", "out"]);
    assert!(files(&folder.join("out")) == whole);
}
