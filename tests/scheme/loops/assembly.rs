//! Loops are closed with the least motion and within limits, one that cannot close is named, and redundant equations are
//! counted.

use crate::closed;
use catena::instant::start::assembly::{AssemblyError, assemble, redundancy};
use catena::mechanism::description::closure::{Coordinate, JointLimit};
use catena::mechanism::motion::gaps::loop_gaps;
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;

#[test]
fn a_planar_loop_in_space_has_three_redundant_equations_and_one_degree_of_freedom() {
    for count in [1, 2, 5] {
        let (mechanism, state) = closed::four_bars(count, 5);
        let found = redundancy(&mechanism, &state);
        assert_eq!(found.count(), 3 * count, "{found:?}");
        assert_eq!(found.degrees_of_freedom(&mechanism), 1);
        assert_eq!(found.redundant[0], ("closure0".to_string(), 3));
    }
}

#[test]
fn a_start_that_is_only_near_is_closed_with_the_least_motion() {
    let (mechanism, exact) = closed::four_bars(2, 5);
    let mut state = exact.clone();
    for (index, position) in state.position.iter_mut().enumerate() {
        *position += 0.03 * (index as f64 - 2.0);
    }
    state.velocity[0] += 0.5;
    let correction = assemble(&mechanism, &mut state).unwrap();
    assert!(correction.position > 1e-3 && correction.velocity > 1e-3);
    let bodies = body_states(&mechanism, &state);
    for joint in &mechanism.loops {
        let (gap, rate) = loop_gaps(joint, &bodies).largest();
        assert!(gap < 1e-14 && rate < 1e-13, "{gap:e} {rate:e}");
    }
    // What is consistent already stays.
    let closed_state = state.clone();
    assemble(&mechanism, &mut state).unwrap();
    for (before, after) in closed_state.position.iter().zip(&state.position) {
        assert!((before - after).abs() < 1e-14);
    }
}

#[test]
fn a_loop_that_cannot_close_is_named_with_its_gap() {
    let (mut mechanism, mut state) = closed::four_bars(1, 5);
    // The ground is 1 m, the three bars 1 m each: 4.5 m apart never closes.
    mechanism.bodies[2].joint.on_parent.translation.vector.x = 4.5;
    let error = assemble(&mechanism, &mut state).unwrap_err();
    let AssemblyError::Open { closure, gap } = &error else { panic!("{error}") };
    assert_eq!(closure, "closure0");
    assert!((0.5..5.0).contains(gap), "{gap}");
    assert!(error.to_string().contains("closure0"));
}

#[test]
fn loops_are_closed_within_the_limits_of_joints() {
    let mut mechanism = closed::arch(2.0);
    let mut wanted = State::zero(&mechanism);
    wanted.position.copy_from_slice(&[0.9, -0.3, -0.3]);
    let mut free = wanted.clone();
    assemble(&mechanism, &mut free).unwrap();
    assert!(free.position[1] < -0.5, "without limits the second hinge turns further: {:?}", free.position);
    let limit = |freedom, lower, upper| JointLimit {
        coordinate: Coordinate { body: freedom, position: freedom, freedom },
        lower,
        upper,
        restitution: 0.0,
    };
    mechanism.limits.push(limit(1, -0.4, 1.0));
    let mut held = wanted.clone();
    assemble(&mechanism, &mut held).unwrap();
    assert!((-0.4..1.0).contains(&held.position[1]), "{:?}", held.position);
    let gap = loop_gaps(&mechanism.loops[0], &body_states(&mechanism, &held)).largest().0;
    assert!(gap < 1e-12, "{gap:e}");
    // Nearly straight, three rods of 1 m cannot end 2 m away.
    mechanism.limits = vec![limit(1, -0.35, 0.1), limit(2, -0.35, 0.1)];
    let error = assemble(&mechanism, &mut wanted).unwrap_err();
    assert!(matches!(&error, AssemblyError::Limited { closure, .. } if closure == "foot"), "{error}");
}
