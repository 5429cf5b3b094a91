//! The scripts of doc/many_machines run as they stand, each as its engine starts it, and make the rows of the whole.

use super::{MIXED, files, folder, sweep};
use crate::common::command::{run, text};
use std::path::{Path, PathBuf};
use std::process::Command;

fn script(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("doc/many_machines").join(name)
}

fn succeeds(command: &mut Command) {
    let output = command.output().expect("it starts");
    assert!(output.status.success(), "{command:?}: {}", text(&output.stderr));
}

fn merges(folder: &Path, shards: usize) {
    let given: Vec<String> = (1..=shards).map(|number| format!("out/shard-{number}")).collect();
    let given: Vec<&str> = given.iter().map(String::as_str).collect();
    let output = run(folder, &[&["sweep", "-o", "out/all", "--merge"], &given[..]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    sweep(folder, &["-o", "whole"]);
    assert!(files(&folder.join("out/all")) == files(&folder.join("whole")));
}

/// The sweep in the format that all builds write.
fn prepared(name: &str) -> PathBuf {
    let folder = folder(name, MIXED);
    // What the scripts call; those who install it have a `catena` on their path.
    let program = format!(
        "#!/bin/sh\nif [ \"$2\" = --merge ]; then exec {0} \"$@\"; fi\nexec {0} \"$@\" --format csv\n",
        env!("CARGO_BIN_EXE_catena")
    );
    std::fs::create_dir(folder.join("bin")).unwrap();
    std::fs::write(folder.join("bin/catena"), program).unwrap();
    succeeds(Command::new("chmod").arg("+x").arg(folder.join("bin/catena")));
    folder
}

fn path(folder: &Path) -> String {
    format!("{}:{}", folder.join("bin").display(), std::env::var("PATH").unwrap_or_default())
}

#[test]
fn a_slurm_array_makes_the_shards_of_a_sweep() {
    let folder = prepared("sweep_slurm");
    for task in 1..=4 {
        let mut job = Command::new("bash");
        job.current_dir(&folder).arg(script("slurm.sh")).args(["sweep.toml", "out"]).env("PATH", path(&folder));
        // What Slurm says to each task of `sbatch --array=1-4`.
        succeeds(
            job.env("SLURM_ARRAY_TASK_ID", task.to_string())
                .env("SLURM_ARRAY_TASK_MAX", "4")
                .env("SLURM_CPUS_PER_TASK", "2"),
        );
    }
    merges(&folder, 4);
}

#[test]
fn an_indexed_job_makes_the_shards_of_a_sweep() {
    let folder = prepared("sweep_kubernetes");
    let job = std::fs::read_to_string(script("kubernetes.yaml")).unwrap();
    let command =
        job.lines().find_map(|line| line.trim().strip_prefix("- exec ")).expect("the command of the container");
    // The volumes of the container.
    let command = command.replace("/sweep/", "").replace("/rows/", "out/");
    for index in 0..3 {
        let mut pod = Command::new("sh");
        pod.current_dir(&folder).args(["-c", &command]).env("PATH", path(&folder));
        succeeds(pod.env("JOB_COMPLETION_INDEX", index.to_string()).env("SHARDS", "3"));
    }
    merges(&folder, 3);
}

#[test]
fn gnu_parallel_makes_and_merges_the_shards_of_a_sweep() {
    if !Command::new("parallel")
        .arg("--version")
        .output()
        .is_ok_and(|output| text(&output.stdout).starts_with("GNU parallel"))
    {
        println!("skipped: there is no GNU parallel here");
        return;
    }
    let folder = prepared("sweep_parallel");
    let mut all = Command::new("bash");
    all.current_dir(&folder)
        .arg(script("parallel.sh"))
        .args(["sweep.toml", "out", "3"])
        .env("PATH", path(&folder))
        .env("HOME", &folder);
    succeeds(&mut all);
    sweep(&folder, &["-o", "whole"]);
    assert!(files(&folder.join("out/all")) == files(&folder.join("whole")));
}
