//! Loops and mimic relations that say the same twice, lock a mechanism, or tie light and massless links: small inputs that once failed, with the
//! truth from computations of another kind (index-1 equations, singular values).

use crate::common::command::{run, text};
use crate::common::{scratch, shared};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Where the inputs are; `None`, and why is printed, where they are not.
fn inputs() -> Option<PathBuf> {
    shared("repro")
}

/// The report of a run that ends well.
fn report(folder: &Path, input: &Path, arguments: &[&str]) -> Value {
    let mut all = vec!["simulate", input.to_str().expect("UTF-8"), "--no-log", "--json"];
    all.extend(arguments);
    let output = run(folder, &all);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("a report")
}

fn number(report: &Value, path: &str) -> f64 {
    report.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path}: {report}"))
}

fn joint(report: &Value, joint: &str) -> f64 {
    number(report, &format!("/joints/{joint}/position"))
}

#[test]
fn one_mechanism_has_one_count_and_one_motion_in_both_orders_of_its_loops() {
    let Some(inputs) = inputs() else { return };
    let folder = scratch("lock");
    let ends = ["lock_sph_pri.toml", "lock_pri_sph.toml"].map(|input| {
        let report = report(&folder, &inputs.join(input), &[]);
        // Rank 4 of 8 equations on 5 freedoms.
        assert_eq!(report["model"]["degrees_of_freedom"], 1, "{input}");
        assert_eq!(report["model"]["redundant_constraints"], 4, "{input}");
        // It swings on the only hinge that the loops leave.
        assert!(number(&report, "/joints/ja/velocity").abs() > 0.1, "{input}");
        joint(&report, "ja")
    });
    assert!((ends[0] - ends[1]).abs() < 1e-9, "the tolerance: {ends:?}");
}

#[test]
fn a_mechanism_that_cannot_move_rests_whatever_velocities_and_tolerance_are_asked_for() {
    let Some(inputs) = inputs() else { return };
    let folder = scratch("locked");
    let steps: [&[&str]; 6] = [
        &["--tolerance", "1e-3"],
        &["--tolerance", "1e-9"],
        &["--tolerance", "1e-13"],
        &["--tolerance", "1e-6", "--keep", "sleep"],
        &["--stages", "4", "--step", "0.01", "--keep", "sleep"],
        &["--stages", "9", "--step", "0.1"],
    ];
    for arguments in steps {
        let report = report(&folder, &inputs.join("locked191.toml"), &[&["--duration", "0.5"], arguments].concat());
        assert_eq!(report["model"]["degrees_of_freedom"], 0, "{arguments:?}");
        assert_eq!(report["model"]["redundant_constraints"], 10, "{arguments:?}");
        for name in ["j1", "j2"] {
            assert_eq!(number(&report, &format!("/joints/{name}/velocity")), 0.0, "{arguments:?}: {name}");
        }
        assert_eq!(number(&report, "/energy/parts/kinetic"), 0.0, "{arguments:?}");
    }
}

#[test]
fn two_loops_that_lock_what_each_other_locks_cost_no_digits() {
    let Some(inputs) = inputs() else { return };
    let folder = scratch("twice");
    let run = |arguments: &[&str]| {
        report(&folder, &inputs.join("twice_redundant.toml"), &[&["--duration", "0.4"], arguments].concat())
    };
    let [coarse, fine, fixed] =
        [run(&["--tolerance", "1e-9"]), run(&["--tolerance", "1e-10"]), run(&["--stages", "9", "--step", "0.002"])];
    for (report, name) in [(&coarse, "1e-9"), (&fine, "1e-10"), (&fixed, "fixed")] {
        assert_eq!(report["model"]["degrees_of_freedom"], 7, "{name}");
        // Welded instead of closed, gaps are 1e-13 m; a run of 200 steps rounds its energy to 1e-12.
        assert!(number(report, "/constraint/max_position") < 1e-13, "{name}: {report}");
        assert!(number(report, "/energy/max_relative_error") < 1e-11, "{name}: {}", report["energy"]);
    }
    for (report, wanted) in [(&coarse, 1e-9), (&fine, 1e-10)] {
        assert_eq!(report["accuracy"]["reached"], true, "{wanted:e}: {}", report["accuracy"]);
        let apart = |joint: &str, at: usize| {
            let of = |report: &Value| {
                report["joints"][joint]["position"][at]
                    .as_f64()
                    .unwrap_or_else(|| number(report, &format!("/joints/{joint}/position")))
            };
            (of(report) - of(&fixed)).abs()
        };
        let worst = ["j1", "j2", "j3", "j4", "j7"].iter().map(|joint| apart(joint, 0)).fold(0.0, f64::max);
        assert!(worst < wanted, "{wanted:e}: {worst:e}");
    }
}

#[test]
fn light_leaders_of_heavy_followers_cost_neither_steps_nor_digits_at_any_ratio() {
    let Some(inputs) = inputs() else { return };
    let folder = scratch("light");
    let source = std::fs::read_to_string(inputs.join("light_leader.urdf")).expect("an input");
    let start = ["--position", "lead=0.5", "--position", "l=0.5", "--position", "r=-0.5", "--duration", "0.5"];
    let mut counts = Vec::new();
    for power in [0, 3, 6, 9, 12, 15] {
        // The followers have 0.1 kg m² or so about their hinges.
        let inertia = format!("1e-{power}");
        let urdf = source.replace("1e-10", &inertia).replace("1e-6", &format!("{:e}", 1e2 * 10.0_f64.powi(-power)));
        let input = folder.join(format!("light{power}.urdf"));
        std::fs::write(&input, urdf).expect("written");
        for steps in [&["--tolerance", "1e-9"][..], &["--stages", "5", "--step", "0.01"]] {
            let report = report(&folder, &input, &[&start, steps].concat());
            assert_eq!(report["model"]["degrees_of_freedom"], 1, "{inertia}");
            assert!((joint(&report, "lead") - joint(&report, "l")).abs() < 1e-13, "{inertia}");
            assert!((joint(&report, "lead") + joint(&report, "r")).abs() < 1e-13, "{inertia}");
            if power >= 9 {
                // The light link adds 1e-9 and less to the inertia of the others.
                let expected = 0.53477177;
                assert!((joint(&report, "lead") - expected).abs() < 1e-8, "{inertia}: {}", joint(&report, "lead"));
                counts.push(report["steps"].as_u64().expect("a count"));
            }
        }
    }
    for pair in counts.windows(3) {
        assert_eq!(pair[0], pair[2], "as many steps at every ratio: {counts:?}");
    }
}

#[test]
fn massless_leaders_couple_their_followers_and_massless_followers_turn_with_their_leader() {
    let Some(inputs) = inputs() else { return };
    let folder = scratch("massless");
    let leader = report(
        &folder,
        &inputs.join("massless_leader.urdf"),
        &["--position", "l=0.5", "--position", "r=-0.5", "--position", "lead=0.5", "--duration", "0.5"],
    );
    assert_eq!(leader["model"]["degrees_of_freedom"], 1);
    for (name, sign) in [("lead", 1.0), ("l", 1.0), ("r", -1.0)] {
        assert!((joint(&leader, name) - sign * 0.53477177).abs() < 1e-8, "{name}: {}", joint(&leader, name));
    }
    let follower = report(
        &folder,
        &inputs.join("mimic_massless.urdf"),
        &["--position", "lead=1", "--position", "follow=-1", "--duration", "0.5"],
    );
    assert_eq!(follower["model"]["degrees_of_freedom"], 1);
    let lead = joint(&follower, "lead");
    assert!((lead - 1.0).abs() > 0.1, "it falls");
    assert!((lead + joint(&follower, "follow")).abs() < 1e-13);
    // The pad turns about y by the negative angle.
    let turn: Vec<f64> =
        follower["links"]["pad"]["orientation"].as_array().expect("four").iter().filter_map(Value::as_f64).collect();
    assert!(
        (2.0 * turn[2].atan2(turn[0]) + lead).abs() < 1e-12 || (2.0 * turn[1].atan2(turn[3]) + lead).abs() < 1e-12,
        "{turn:?}"
    );
    // Nothing hangs on it.
    for axis in 0..3 {
        let force = follower["joints"]["follow"]["reaction_force"][axis].as_f64().expect("a number");
        assert!(force.abs() < 1e-12, "{force:e}");
    }
}

#[test]
fn a_massless_start_at_another_place_is_moved_and_the_heavy_links_are_not() {
    let Some(inputs) = inputs() else { return };
    let folder = scratch("moved");
    let report = report(
        &folder,
        &inputs.join("massless_leader.urdf"),
        &["--position", "l=0.5", "--position", "r=-0.5", "--duration", "1e-9"],
    );
    assert!((joint(&report, "l") - 0.5).abs() < 1e-9 && (joint(&report, "lead") - 0.5).abs() < 1e-9, "{report}");
}
