//! Starts are as they were given: joints that were not given follow those that were by their mimic relations.

use crate::common::shared;
use catena::prelude::*;
use std::path::Path;

/// The positions of joints with one coordinate at the start.
fn positions(file: &Path, given: &[(&str, f64)], names: &[&str]) -> Vec<f64> {
    let model = Model::load(file).unwrap_or_else(|error| panic!("{error}"));
    let mut loaded = model.loaded().clone();
    let given: Vec<(String, Vec<f64>)> = given.iter().map(|&(name, value)| (name.to_string(), vec![value])).collect();
    let state = loaded.initial_state(&given, &[], None).unwrap_or_else(|error| panic!("{error}"));
    let model = &loaded.model;
    let of = |name: &&str| {
        let joint = model.joint(name).expect("a joint");
        model.joint_user_coordinates(joint, &state.position, &state.velocity).0[0]
    };
    names.iter().map(of).collect()
}

#[test]
fn followers_follow_a_leader_that_was_given_and_leaders_a_follower() {
    let Some(folder) = shared("repro/events") else { return };
    // jb = 0.5 ja + 0.1, jc = 2 jb − 0.3.
    let chain = folder.join("20_chain.urdf");
    for given in [[("ja", 0.3)], [("jb", 0.25)], [("jc", 0.2)]] {
        let found = positions(&chain, &given, &["ja", "jb", "jc"]);
        for (found, wanted) in found.iter().zip([0.3, 0.25, 0.2]) {
            // Some roundings of numbers below one.
            assert!((found - wanted).abs() < 1e-15, "{given:?}: {found}, not {wanted}");
        }
    }
    // A light rotor that turns a hundred times as fast.
    let found = positions(&folder.join("16_rotor.urdf"), &[("hinge", 0.1)], &["hinge", "shaft"]);
    assert!((found[0] - 0.1).abs() < 1e-15 && (found[1] - 10.0).abs() < 1e-13, "{found:?}");
}

#[test]
fn given_positions_are_moved_if_they_contradict_a_mimic_relation() {
    let Some(folder) = shared("repro/events") else { return };
    let found = positions(&folder.join("20_chain.urdf"), &[("ja", 0.3), ("jb", 0.9)], &["ja", "jb", "jc"]);
    assert!((found[0] - 0.3).abs() > 1e-2 && (found[1] - 0.9).abs() > 1e-2, "{found:?}");
    // The relation holds to some roundings.
    assert!((found[1] - (0.5 * found[0] + 0.1)).abs() < 1e-14, "{found:?}");
}
