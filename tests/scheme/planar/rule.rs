//! The rule of the plane: what it puts together, and that it is named, counted and switched off on the command line.

use crate::common::command;
use crate::models::Model;
use crate::{closed, models};
use catena::mechanism::description::mechanism::{Body, Mechanism};
use catena::mechanism::description::rules::Rule;
use catena::mechanism::motion::state::State;
use catena::mechanism::structure::plane::Plane;
use catena::simulation::parallel::partition::Plan as IslandPlan;
use nalgebra::{Rotation3, Vector3};

#[test]
fn islands_in_parallel_planes_are_run_together_and_stay_in_their_plane() {
    // Four swings in one plane, two in another, and arms that have none, in turns.
    let turned = |mut model: Model, about: Vector3<f64>| {
        let joint = &mut model.mechanism.bodies[0].joint;
        joint.on_parent.rotation = Rotation3::new(about) * joint.on_parent.rotation;
        model
    };
    let across = Vector3::new(0.0, 0.0, 1.2);
    let parts = [
        models::planar_chain(3),
        models::chain(3),
        turned(models::planar_chain(3), across),
        models::planar_chain(3),
        models::chain(3),
        models::planar_chain(3),
        turned(models::planar_chain(3), across),
        models::planar_chain(3),
    ];
    let bodies = parts.iter().enumerate().flat_map(|(part, model)| {
        model
            .mechanism
            .bodies
            .iter()
            .map(move |body| Body { parent: body.parent.map(|body| body + 3 * part), ..body.clone() })
    });
    let mechanism = Mechanism::new("swings", models::gravity(), bodies.collect()).expect("depth first");
    let mut state = State::zero(&mechanism);
    state.velocity.fill(0.3);
    let group = |smallest: usize, kept: &[Rule]| -> Vec<(usize, bool)> {
        let plan = IslandPlan::new(&mechanism, &state, kept).grouped(&mechanism, smallest);
        let sizes = plan.islands.iter().map(|(island, _)| &island.mechanism);
        sizes.map(|part| (part.bodies.len(), Plane::of(part).is_some())).collect()
    };
    assert_eq!(group(12, &[]), [(12, true), (12, false)], "two swings are too few to be worth a group");
    assert_eq!(group(6, &[]), [(6, true), (6, false), (6, true), (6, true)]);
    assert_eq!(group(12, &[Rule::Planar]), [(12, false), (12, false)]);
    assert_eq!(group(2, &[]).len(), 8);
}

#[test]
fn the_rule_is_named_counted_and_switched_off_by_name() {
    // Where it hangs in equilibrium it would sleep.
    const SIDEWAYS: [&str; 4] = ["model", "pendulum.urdf", "--gravity", "3,0,-9"];
    let folder = command::folder("planar");
    let rule = |arguments: &[&str]| -> serde_json::Value {
        let output = command::run(&folder, &[&SIDEWAYS[..], &["--json"], arguments].concat());
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
        let rules = json["rules"].as_array().expect("an array").clone();
        rules.into_iter().find(|rule| rule["name"] == "planar").expect("the rule is named")
    };
    assert_eq!((&rule(&[])["count"], &rule(&[])["kept"]), (&1.into(), &false.into()));
    assert_eq!(rule(&["--keep", "planar"])["kept"], true);
    let table = command::run(&folder, &SIDEWAYS);
    assert!(command::text(&table.stdout).contains("1 body, three coordinates each instead of six"));

    let report = |arguments: &[&str]| -> serde_json::Value {
        let always = ["simulate", "pendulum.urdf", "--no-log", "--json", "--position", "hinge=1", "--duration", "2"];
        let output = command::run(&folder, &[&always[..], arguments].concat());
        serde_json::from_slice(&output.stdout).expect("JSON")
    };
    for method in [&["--tolerance", "1e-8"][..], &["--stages", "6", "--step", "0.02"]] {
        let (flat, full) = (report(method), report(&[method, &["--keep", "planar"]].concat()));
        let ends = [&flat, &full].map(|report| report["joints"]["hinge"]["position"].as_f64().expect("an angle"));
        // Both round; with a tolerance their steps differ by a share of the error.
        assert!((ends[0] - ends[1]).abs() < 1e-11, "{ends:?}");
        assert_eq!(flat["steps"], full["steps"]);
    }
}

#[test]
fn closed_loops_are_put_together_with_each_other_and_not_with_trees() {
    // Four-bars and swings in the same plane, in turns; three bodies each.
    let (mut bodies, mut loops) = (Vec::new(), Vec::new());
    for part in 0..8 {
        let (mechanism, _) = closed::four_bars(1, 5);
        let first = bodies.len();
        let shifted = |body: Option<usize>| body.map(|body| body + first);
        loops.extend(mechanism.loops.into_iter().filter(|_| part % 2 == 0).map(|mut joint| {
            (joint.a.body, joint.b.body) = (shifted(joint.a.body), shifted(joint.b.body));
            joint
        }));
        let moved = mechanism.bodies.into_iter().map(|mut body| {
            body.parent = shifted(body.parent);
            body
        });
        bodies.extend(moved.collect::<Vec<_>>());
    }
    let mut mechanism = Mechanism::new("bars and swings", models::gravity(), bodies).expect("depth first");
    mechanism.loops = loops;
    let mut state = State::zero(&mechanism);
    state.velocity.fill(0.3);
    let plan = IslandPlan::new(&mechanism, &state, &[]).grouped(&mechanism, 6);
    let groups: Vec<_> = plan.islands.iter().map(|(island, _)| &island.mechanism).collect();
    for group in &groups {
        assert!(Plane::of(group).is_some());
        assert!(group.loops.is_empty() || group.loops.len() * 3 == group.bodies.len(), "trees and loops in one group");
    }
    assert_eq!(groups.iter().map(|group| group.loops.len()).sum::<usize>(), 4);
    assert!(groups.len() < 8, "nothing was put together");
}

#[test]
fn the_rule_covers_closed_loops_and_is_switched_off_by_name() {
    let folder = command::folder("planar_loops");
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/robots/four_bar_2.toml");
    let count = |arguments: &[&str]| -> serde_json::Value {
        let output = command::run(&folder, &[&["model", scene, "--json"], arguments].concat());
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
        let rules = json["rules"].as_array().expect("an array").clone();
        rules.into_iter().find(|rule| rule["name"] == "planar").expect("the rule is named")
    };
    assert_eq!((&count(&[])["count"], &count(&[])["kept"]), (&5.into(), &false.into()));
    assert_eq!(count(&["--keep", "planar"])["kept"], true);
    let report = |arguments: &[&str]| -> serde_json::Value {
        let always = ["simulate", scene, "--no-log", "--json", "--duration", "1", "--stages", "5", "--step", "0.01"];
        let output = command::run(&folder, &[&always[..], arguments].concat());
        serde_json::from_slice(&output.stdout).expect("JSON")
    };
    let (flat, full) = (report(&[]), report(&["--keep", "planar"]));
    // What joints and loops carry is worked out in space for both; of some 90 N, rounded.
    for part in ["joints", "loops"] {
        let (flat, full) = (numbers(&flat[part]), numbers(&full[part]));
        assert!(flat.len() > 10 && flat.len() == full.len(), "{part}");
        for (flat, full) in flat.into_iter().zip(full) {
            assert!((flat - full).abs() < 1e-10, "{part}: {flat} {full}");
        }
    }
}

/// All numbers of a report, in its order.
fn numbers(report: &serde_json::Value) -> Vec<f64> {
    match report {
        serde_json::Value::Object(entries) => entries.values().flat_map(numbers).collect(),
        serde_json::Value::Array(entries) => entries.iter().flat_map(numbers).collect(),
        number => number.as_f64().into_iter().collect(),
    }
}
