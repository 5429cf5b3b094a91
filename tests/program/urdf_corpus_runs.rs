//! Real robots run: every URDF that works elsewhere simulates a second at the default tolerance without losing energy,
//! and damaged ones are refused, or run with a warning, as a user of the command line sees it.

use crate::common::{by_tolerance, models_of, run_until, scratch, shared, stem, urdf_files};
use catena::instant::start::assembly::assemble;
use serde_json::Value;
use std::process::Command;

/// The default of `catena simulate`.
const TOLERANCE: f64 = 1e-6;

#[test]
fn every_real_robot_runs_a_second_and_keeps_its_energy() {
    let Some(folder) = shared("urdf-corpus/loads") else { return };
    let (mut runs, mut losses) = (0, Vec::new());
    for file in urdf_files(&folder) {
        for (base, model) in models_of(&file) {
            let mechanism = &model.mechanism;
            for amplitude in [0.0, 0.3] {
                let mut state = model.zero_state();
                // A position in which nothing is aligned, and a motion of every joint, lest a floating robot only fall.
                let wave = |phase: f64| move |index: usize| amplitude * (index as f64 + phase).sin();
                let increment: Vec<f64> = (0..mechanism.velocity_count).map(wave(1.0)).collect();
                state.displace(mechanism, &increment);
                state.velocity = (0..mechanism.velocity_count).map(wave(2.5)).collect();
                // Joints that mimic others are put where those are.
                assemble(mechanism, &mut state).unwrap_or_else(|error| panic!("{}: {error}", stem(&file)));
                let mut lobatto = by_tolerance(mechanism, &state, 1.0, TOLERANCE);
                let summary = run_until(mechanism, &mut state, &mut lobatto, 1.0);
                runs += 1;
                let error = summary.max_relative_energy_error;
                println!("{} {base:?} {amplitude}: {error:.1e} in {} steps", stem(&file), summary.steps);
                // Not a number is a loss too.
                let kept = error < 1e-6;
                if !kept {
                    losses.push(format!("{} {base:?} {amplitude}: {error:.1e}", stem(&file)));
                }
            }
        }
    }
    assert!(runs >= 4 * 17, "only {runs} runs");
    assert!(losses.is_empty(), "{losses:#?}");
}

/// What becomes of each damaged file: `Ok` with a piece of the warning where the intent is plain, `Err` with a piece of
/// the error where it is not.
const REJECTS: [(&str, Result<&str, &str>); 11] = [
    ("bad_float", Err("bad_float.urdf:115: joint \"torso_to_rightleg\"")),
    ("bike_commas", Ok("bike_commas.urdf:103: joint \"handlebar_to_frontwheel\"")),
    ("cdf_geometry", Ok("cdf_geometry.urdf:22: link \"base_link\"")),
    ("duplicate_axis", Ok("duplicate_axis.urdf:550: joint \"RL_lower_joint\"")),
    ("four_numbers", Err("four_numbers.urdf:16: link \"chassis\"")),
    ("husky_xacro_leftover", Err("husky_xacro_leftover.urdf:97: joint \"imu_joint\"")),
    ("icub_mesh_without_filename", Ok("icub_mesh_without_filename.urdf:")),
    ("microtaur_rpy4", Err("microtaur_rpy4.urdf:300: joint \"dynamixel7_chassis_left\"")),
    ("plane_geometry", Ok("plane_geometry.urdf:21: link \"planeLink\"")),
    ("racecar_xacro", Ok("line 284: <material> of <geometry>")),
    ("spherical_limit_no_velocity", Ok("spherical_limit_no_velocity.urdf:30: joint \"neck\"")),
];

#[test]
fn damaged_files_run_with_a_warning_or_end_with_exit_code_two_and_one_line() {
    let Some(folder) = shared("urdf-corpus/rejects") else { return };
    assert_eq!(urdf_files(&folder).len(), REJECTS.len(), "every file is listed");
    let empty = scratch("empty");
    for (name, expected) in REJECTS {
        let output = Command::new(env!("CARGO_BIN_EXE_catena"))
            .current_dir(&empty)
            .args(["simulate", "--duration", "1", "--no-log", "--json"])
            .arg(folder.join(format!("{name}.urdf")))
            .output()
            .unwrap();
        let error = String::from_utf8(output.stderr).unwrap();
        match expected {
            Ok(part) => {
                assert_eq!(output.status.code(), Some(0), "{name}: {error}");
                let report: Value = serde_json::from_slice(&output.stdout).unwrap();
                let warnings: Vec<&str> =
                    report["warnings"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
                assert!(warnings.iter().any(|warning| warning.contains(part)), "{part:?} in {warnings:#?}");
                let loss = report["energy"]["max_relative_error"].as_f64().unwrap();
                assert!(loss < 1e-6, "{name}: {loss:.1e}");
            }
            Err(part) => {
                assert_eq!(output.status.code(), Some(2), "{name}: {error}");
                assert_eq!(error.lines().count(), 1, "{name}: {error}");
                assert!(error.starts_with("catena: error: ") && error.contains(part), "{part:?} in {error}");
                assert!(output.stdout.is_empty(), "{name}");
            }
        }
    }
    assert_eq!(std::fs::read_dir(&empty).unwrap().count(), 0, "a run without log leaves no file");
}
