//! Starts are put on their loops in the coordinates of the file, whichever joints are cut.

use crate::linkage::path;
use catena::instant::start::assembly::assemble;
use catena::mechanism::description::rules::Rule;
use catena::mechanism::motion::gaps::loop_gaps;
use catena::mechanism::motion::kinematics::body_states;
use catena::stepping::trees::other_tree::other_tree;

#[test]
fn starts_that_are_off_by_roundings_are_put_on_their_loops_where_they_are_with_every_turn() {
    let (mechanism, closed) = path(8, 3.0);
    let (tree, _) = other_tree(&mechanism, &[], &[Rule::Planar]).expect("another tree");
    let cut = tree.cut_joints().next().expect("a joint that is cut");
    for (off, moved) in [(3e-14, 1e-12), (1e-4, 1e-3)] {
        let mut start = closed.clone();
        start.position[cut] += 2.0 * std::f64::consts::TAU + off;
        let mut state = start.clone();
        let correction = assemble(&mechanism, &mut state).expect("closed");
        let bodies = body_states(&mechanism, &state);
        let gap = mechanism.loops.iter().map(|joint| loop_gaps(joint, &bodies).largest().0).fold(0.0, f64::max);
        // Nine bodies in a row, a metre each.
        assert!(gap < 1e-14, "off by {off:e}: a gap of {gap:e}");
        assert!(correction.position <= moved && correction.position > 0.0, "off by {off:e}: {correction:?}");
        let pairs = state.position.iter().zip(&start.position).chain(state.velocity.iter().zip(&start.velocity));
        let change = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(change <= 10.0 * moved, "off by {off:e}: {change:e}");
    }
}
