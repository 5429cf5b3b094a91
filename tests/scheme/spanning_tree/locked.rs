//! Mechanisms whose loops lock joints, on any spanning tree.

use super::{apart, end, random_tree};
use crate::common;
use crate::ranks::random;
use catena::instant::start::assembly::assemble;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::gaps::loop_gaps;
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use catena::mechanism::structure::other_tree::OtherTree;
use catena::mechanism::structure::ranks::counting::Ranks;
use catena::model::Model;
use catena::scene::{PackagePath, read_scene};

/// How far the bodies end from where they end on the mechanism's own tree, on random trees, at worst (m, m/s).
fn furthest(mechanism: &Mechanism, start: &State, trees: usize, numbers: &mut common::Numbers) -> f64 {
    let expected = end(mechanism, start, 0.01, 0.15);
    let one = |numbers: &mut common::Numbers| {
        let tree = random_tree(mechanism, None, numbers);
        let mut other = OtherTree::new(mechanism, &tree, None, start).expect("depth first");
        let mut own = State::zero(&other.mechanism);
        other.take(mechanism, start, &mut own);
        // Not exactly at rest: roundings of places and rates.
        let locked = Ranks::at(&other.mechanism, &own).locked;
        assert!(locked.contains(&true), "still locked on {tree:?}");
        let own = end(&other.mechanism, &own, 0.01, 0.15);
        let bodies = body_states(&other.mechanism, &own);
        let gaps = other.mechanism.loops.iter().map(|joint| loop_gaps(joint, &bodies).largest().0);
        let gap = gaps.fold(0.0, f64::max);
        assert!(gap < 1e-13, "a gap of {gap:e} on {tree:?}");
        apart((mechanism, &expected), (&other.mechanism, &own))
    };
    (0..trees).map(|_| one(numbers)).fold(0.0, f64::max)
}

#[test]
fn joints_that_loops_lock_stay_where_they_are_on_random_spanning_trees() {
    let mut numbers = common::Numbers::new(2);
    let mut tried = 0;
    for seed in 0..60 {
        let (mechanism, mut start) = random::mechanism(seed);
        if assemble(&mechanism, &mut start).is_err() {
            continue;
        }
        let locked = Ranks::at(&mechanism, &start).locked;
        if !locked.contains(&true) || !locked.contains(&false) {
            continue;
        }
        tried += 1;
        let off = furthest(&mechanism, &start, 5, &mut numbers);
        // Fifteen steps solved to rounding of mechanisms that fold up in a second.
        assert!(off < 1e-10, "mechanism {seed}: {off:e} apart");
    }
    assert!(tried > 5, "{tried} mechanisms with joints that are locked");
}

#[test]
fn two_loops_that_lock_what_each_other_locks_cost_no_digits_on_random_spanning_trees() {
    let Some(folder) = common::shared("repro") else { return };
    let scene = read_scene(&folder.join("twice_redundant.toml"), &PackagePath::default()).expect("a scene");
    let (model, start) = Model::from_scene(&scene).expect("a model");
    let mut state = model.initial_state(&start.positions, &start.velocities, None).expect("a start");
    assemble(&model.mechanism, &mut state).expect("closed");
    let off = furthest(&model.mechanism, &state, 20, &mut common::Numbers::new(36));
    // Before, roundings of rates that are zero grew 300-fold a step, to 1e-1 m within ten.
    assert!(off < 1e-11, "{off:e} apart");
}
