//! Logs as the readers of the mcap project see them (`tests/program/readback.py`), which share no line with ours.
//!
//! They are Python packages, which `.ci/run` puts into `target/python`; without them these tests say so and skip.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::common::command::{ENDLESS, catena, folder, run, salvaged, salvaged_samples, text, wait_for};

/// A Python that has the readers.
fn python() -> Option<PathBuf> {
    let python = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/python/bin/python3");
    let has_readers = Command::new(&python).args(["-c", "import mcap, mcap_ros2, rosbags"]).output();
    if has_readers.is_ok_and(|output| output.status.success()) {
        return Some(python);
    }
    println!("skipped: {} has no readers of logs; .ci/run installs them", python.display());
    None
}

/// Runs the script and returns the number of messages it has read.
fn readback(python: &Path, arguments: &[&Path]) -> usize {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/program/readback.py");
    let output = Command::new(python).arg(script).args(arguments).output().expect("Python runs");
    assert!(output.status.success(), "{arguments:?}: {}", text(&output.stderr));
    text(&output.stdout).trim().parse().expect("a count")
}

#[test]
fn a_log_has_schemas_monotonic_times_and_the_poses_of_report_and_urdf() {
    let Some(python) = python() else { return };
    let folder = folder("complete");
    for robot in ["arm7", "gantry", "double_pendulum"] {
        let urdf = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("robots/{robot}.urdf"));
        let output = run(&folder, &["simulate", &urdf.to_string_lossy(), "--duration", "1", "--json"]);
        assert_eq!(output.status.code(), Some(0), "{robot}: {}", text(&output.stderr));
        let report = folder.join(format!("{robot}.json"));
        std::fs::write(&report, &output.stdout).expect("written");
        assert!(readback(&python, &[&folder.join(format!("{robot}.mcap")), &report]) > 180, "{robot}");
    }
}

/// Python's `rosbags` refuses what is no ROS 2 bag, and decodes by nothing but the definitions in the log.
#[test]
fn logs_of_twelve_robots_are_bags_of_ros_2_and_convert_to_others() {
    let Some(python) = python() else { return };
    let folder = folder("bags");
    let robots = [
        "arm7",
        "gantry",
        "double_pendulum",
        "humanoid",
        "quadruped",
        "planar_slider",
        "spherical_chain",
        "four_bar_1",
        "slider_crank",
        "stewart_platform",
        // These touch something.
        "quadruped_dropped",
        "ball_in_bowl",
    ];
    for robot in robots {
        let urdf = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("robots/{robot}.urdf"));
        let input = if urdf.exists() { urdf } else { urdf.with_extension("toml") };
        let words = ["--duration", "0.2", "--quiet", "--start-time", "1700000000.5"];
        let output = run(&folder, &[&["simulate", &input.to_string_lossy()], &words[..]].concat());
        assert_eq!(output.status.code(), Some(0), "{robot}: {}", text(&output.stderr));
        let log = folder.join(format!("{robot}.mcap"));
        assert!(readback(&python, &[Path::new("--bag"), &log, &folder.join(robot)]) > 40, "{robot}");
    }
}

#[cfg(unix)]
#[test]
fn a_killed_run_is_read_up_to_its_end() {
    let Some(python) = python() else { return };
    let folder = folder("killed");
    let log = folder.join("pendulum.mcap");
    for step in ["0.01", "0.00001"] {
        let words = [&["simulate", "pendulum.urdf", "--velocity", "hinge=1"], &ENDLESS[..]].concat();
        let arguments: Vec<&str> = words.into_iter().map(|word| if word == "0.01" { step } else { word }).collect();
        let mut child = catena(&folder, &arguments).spawn().expect("runs");
        wait_for(&mut child, "a log with samples", || salvaged_samples(&log) > 3);
        child.kill().expect("killed");
        child.wait().expect("ends");
        let bytes = std::fs::read(&log).expect("a log");
        let ours = salvaged(&bytes, "/tf").len();
        assert!(readback(&python, &[&log]) >= 3 * ours, "{step}: every sample is three messages at least");
        std::fs::remove_file(&log).expect("removed");
    }
}
