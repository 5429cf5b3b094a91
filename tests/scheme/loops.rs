//! Closed loops and mimic relations: order, gaps, redundancy, singular positions, assembly.

#![allow(clippy::excessive_precision, reason = "reference values stand as their source prints them")]

use crate::{closed, common};
use catena::closures::{loop_gaps, mimic_gap};
use catena::invariants::{energy, violation};
use catena::kinematics::body_states;
use catena::lobatto::Lobatto;
use catena::lobatto::assembly::{AssemblyError, assemble, redundancy};
use catena::lobatto::elimination::Elimination;
use catena::lobatto::projection::Projection;
use catena::lobatto::start::Start;
use catena::model::{
    Attachment, Body, Coordinate, Joint, JointKind, JointLimit, LoopJoint, LoopKind, Mechanism, Mimic, Pose, Rule,
};
use catena::reactions::Reactions;
use catena::simulation::Integrator;
use catena::state::State;
use nalgebra::{DMatrix, DVector, Rotation3, Translation3, Vector3};

/// Runs to a time with fixed steps; returns iterations a step and the largest gap of any loop at the end of any step.
fn run(mechanism: &Mechanism, state: &mut State, stages: usize, step: f64, until: f64) -> (f64, f64) {
    run_keeping(&[], mechanism, state, stages, step, until)
}

/// The same without some rules.
fn run_keeping(
    kept: &[Rule],
    mechanism: &Mechanism,
    state: &mut State,
    stages: usize,
    step: f64,
    until: f64,
) -> (f64, f64) {
    let mut lobatto = Lobatto::fixed(mechanism, stages, step).unwrap().keeping(mechanism, kept);
    let (mut iterations, mut steps, mut gap) = (0, 0, 0.0_f64);
    while state.time < until {
        let outcome = lobatto.advance(mechanism, state, until).unwrap();
        (iterations, steps) = (iterations + outcome.iterations, steps + 1);
        let bodies = body_states(mechanism, state);
        for joint in &mechanism.loops {
            gap = gap.max(loop_gaps(joint, &bodies).largest().0);
        }
    }
    (iterations as f64 / steps as f64, gap)
}

fn total_energy(mechanism: &Mechanism, state: &State) -> f64 {
    energy(mechanism, &body_states(mechanism, state)).total()
}

/// Where the end of the first crank is.
fn tip(mechanism: &Mechanism, state: &State) -> Vector3<f64> {
    let crank = &body_states(mechanism, state)[0];
    crank.position + crank.rotation * Vector3::new(0.5, 0.0, 0.0)
}

/// Error of the tip of a four-bar at t = 1 s; the exact value is that of benchmarks.md, A02, N = 1.
fn four_bar_error(kept: &[Rule], rows: usize, stages: usize, step: f64) -> f64 {
    let (mechanism, mut state) = closed::four_bars(1, rows);
    run_keeping(kept, &mechanism, &mut state, stages, step, 1.0);
    (tip(&mechanism, &state) - Vector3::new(-0.26071267518365038, 0.0, -0.96541643915907316)).norm()
}

#[test]
fn a_four_bar_keeps_the_order_of_the_scheme_however_many_of_its_equations_are_redundant() {
    // The coarse errors are those of a dense prototype of the scheme; 1.2 allows for its two digits.
    for (stages, coarse_error) in [(2, 1.4e-1), (3, 8.0e-4), (4, 5.8e-6), (5, 3.0e-8)] {
        let errors = |kept: &[Rule], rows| [0.1, 0.05].map(|step| four_bar_error(kept, rows, stages, step));
        let [few, many] = [3, 5].map(|rows| errors(&[Rule::Planar], rows));
        assert!(many[0] < 1.2 * coarse_error, "s = {stages}: {:e}", many[0]);
        // 4, 16, 64, 256, but for the next order's share.
        let ratio = many[0] / many[1];
        let expected = 4.0_f64.powi(stages as i32 - 1);
        assert!((0.7 * expected..1.5 * expected).contains(&ratio), "s = {stages}: ratio {ratio}");
        // One motion: what differs is rounding, amplified by the passage through the singular position.
        assert!((few[1] - many[1]).abs() < 1e-11, "s = {stages}: {:e} and {:e}", few[1], many[1]);
        // In the plane, where all are independent.
        for (flat, full) in errors(&[], 5).into_iter().zip(many) {
            assert!((flat - full).abs() < 1e-11, "s = {stages}: {flat:e} and {full:e}");
        }
    }
}

#[test]
fn bricard_moves_as_published_with_its_redundant_equation() {
    let (mechanism, start) = closed::bricard();
    let found = redundancy(&mechanism, &start);
    assert_eq!((found.count(), found.degrees_of_freedom(&mechanism)), (1, 1), "{found:?}");
    // The prototype's 5.2e-10 at s = 4, and a converged step.
    for (stages, step, bound) in [(4, 0.08, 6e-10), (9, 0.16, 1e-12)] {
        let mut state = start.clone();
        let (iterations, gap) = run(&mechanism, &mut state, stages, step, 2.4);
        let rod = &body_states(&mechanism, &state)[1];
        let corner = rod.position + rod.rotation * Vector3::new(0.0, -0.5, 0.0);
        let published = Vector3::new(-0.9910312231896985, -0.99996013963756425, -0.0089285573315649579);
        let error = (corner - published).norm();
        println!("s = {stages}: error {error:.2e}, {iterations:.1} iterations a step, gap {gap:.1e}");
        assert!(error < bound, "s = {stages}: {error:e}");
        assert!(gap < 3e-15, "{gap:e}");
    }
}

/// Runs N four-bars with many step sizes through their singular positions (all bars in line, twice a revolution).
fn pass_singular_positions(kept: &[Rule], count: usize, stages: usize, sizes: usize, until: f64) {
    for size in 0..sizes {
        let step = 0.005 * 10.0_f64.powf((size as f64 + 0.37) / sizes as f64);
        let (mechanism, mut state) = closed::four_bars(count, 5);
        let start = total_energy(&mechanism, &state);
        let (_, gap) = run_keeping(kept, &mechanism, &mut state, stages, step, until);
        assert!(gap < 1e-13, "step {step}: gap {gap:e}");
        let bodies = body_states(&mechanism, &state);
        for crank in 1..=count {
            // On the branch that inertia dictates all cranks stay parallel; on another one they are radians apart.
            let apart = (bodies[2 * crank].rotation - bodies[0].rotation).norm();
            assert!(apart < 1e-4, "step {step}: crank {crank} has left by {apart:e}");
        }
        // 2e-4 J of 40 J is the truncation error of the largest step with s = 4; a blip at the position would be of the
        // order of the kinetic energy.
        let drift = (total_energy(&mechanism, &state) - start).abs();
        assert!(drift < 2e-4 * (count as f64 + 1.0), "step {step}: energy off by {drift:e}");
    }
}

#[test]
fn singular_positions_are_passed_on_the_right_branch_at_any_step_size() {
    for (count, stages) in [(1, 4), (1, 9), (2, 5)] {
        // In the plane, and with its redundant equations in space.
        pass_singular_positions(&[], count, stages, 25, 1.3);
        pass_singular_positions(&[Rule::Planar], count, stages, 25, 1.3);
    }
}

#[test]
fn no_step_jumps_to_another_branch_of_a_singular_position() {
    // With this step the equations of one step have a second solution, more than a metre off.
    let (mechanism, start) = closed::four_bars(5, 5);
    for kept in [&[][..], &[Rule::Planar]] {
        let mut state = start.clone();
        run_keeping(kept, &mechanism, &mut state, 9, 0.032570206556597835, 5.0);
        let energy = total_energy(&mechanism, &start);
        let drift = (total_energy(&mechanism, &state) - energy).abs();
        assert!(drift < 1e-4 * energy, "energy off by {drift:e} J");
        let bodies = body_states(&mechanism, &state);
        for crank in 1..=5 {
            assert!((bodies[2 * crank].rotation - bodies[0].rotation).norm() < 1e-4, "crank {crank} has left");
        }
    }
}

#[test]
#[ignore = "minutes; cargo test --release --test scheme loops:: -- --ignored"]
fn singular_positions_are_passed_at_two_hundred_step_sizes() {
    for count in [1, 2] {
        for stages in [4, 5, 9] {
            pass_singular_positions(&[], count, stages, 200, 5.0);
            pass_singular_positions(&[Rule::Planar], count, stages, 200, 5.0);
        }
    }
    pass_singular_positions(&[], 10, 5, 40, 5.0);
    pass_singular_positions(&[Rule::Planar], 10, 5, 40, 5.0);
}

#[test]
fn forty_four_bars_reach_the_published_motion_in_long_steps() {
    // N = 40 is symmetric: the motion is that of one angle; (N+1)/3 + N = 53.67, (N+1)/2 + N = 60.5 (benchmarks.md, A02).
    let (mechanism, mut state) = closed::four_bars(40, 5);
    let (_, gap) = run(&mechanism, &mut state, 5, 0.04, 2.0);
    let (mut angle, mut rate) = (std::f64::consts::FRAC_PI_2, -1.0_f64);
    let acceleration = |angle: f64| -9.81 * 60.5 * angle.cos() / (41.0 / 3.0 + 40.0);
    let steps = 20_000;
    let step = 2.0 / steps as f64;
    for _ in 0..steps {
        // Classical Runge–Kutta: 1e-4 s leaves 1e-13.
        let (k1, l1) = (rate, acceleration(angle));
        let (k2, l2) = (rate + 0.5 * step * l1, acceleration(angle + 0.5 * step * k1));
        let (k3, l3) = (rate + 0.5 * step * l2, acceleration(angle + 0.5 * step * k2));
        let (k4, l4) = (rate + step * l3, acceleration(angle + step * k3));
        angle += step / 6.0 * (k1 + 2.0 * (k2 + k3) + k4);
        rate += step / 6.0 * (l1 + 2.0 * (l2 + l3) + l4);
    }
    let error = (tip(&mechanism, &state) - Vector3::new(angle.cos(), 0.0, angle.sin())).norm();
    println!("error {error:.2e}, gap {gap:.1e}");
    assert!(error < 1e-10, "{error:e}");
    // The row is 41 m long, and a double resolves 7e-15 m there.
    assert!(gap < 1e-13, "{gap:e}");
}

fn frame(place: Vector3<f64>, turn: Vector3<f64>) -> Pose {
    Pose::from_parts(Translation3::from(place), Rotation3::new(turn))
}

fn lump(joint: Joint) -> Body {
    Body { name: "lump".into(), parent: None, mass: 2.0, inertia: Vector3::new(0.05, 0.08, 0.1), joint }
}

#[test]
fn a_loop_joint_moves_like_the_tree_joint_of_its_kind() {
    let on_world = frame(Vector3::new(0.3, -0.2, 0.5), Vector3::new(0.4, 1.1, -0.3));
    let on_body = frame(Vector3::new(-0.3, 0.1, 0.2), Vector3::new(-0.2, 0.5, 0.9));
    let gravity = Vector3::new(1.0, -2.0, -9.81);
    let kinds = [
        (JointKind::Revolute, LoopKind::Revolute, vec![3.0]),
        (JointKind::Prismatic, LoopKind::Prismatic, vec![0.7]),
        (JointKind::Spherical, LoopKind::Spherical, vec![1.0, -2.0, 3.0]),
        (JointKind::Planar, LoopKind::Planar, vec![0.5, -0.6, 2.0]),
    ];
    for (tree_kind, loop_kind, velocity) in kinds {
        let joint = Joint::new("joint", tree_kind, on_world, on_body);
        let tree = Mechanism::new("tree", gravity, vec![lump(joint)]).unwrap();
        let mut tree_state = State::zero(&tree);
        tree_state.velocity.copy_from_slice(&velocity);
        let start = body_states(&tree, &tree_state)[0];

        let free = Joint::new("free", JointKind::Floating, Pose::identity(), Pose::identity());
        let mut closed = Mechanism::new("closed", gravity, vec![lump(free)]).unwrap();
        let (a, b) = (Attachment { body: None, frame: on_world }, Attachment { body: Some(0), frame: on_body });
        closed.loops.push(LoopJoint { name: "closure".into(), kind: loop_kind, a, b });
        let mut state = State::zero(&closed);
        state.position[..3].copy_from_slice(start.position.as_slice());
        state.position[3..].copy_from_slice(&catena::model::wxyz_from_rotation(&start.rotation));
        state.velocity[..3].copy_from_slice(start.velocity.as_slice());
        state.velocity[3..].copy_from_slice((start.rotation.transpose() * start.angular_velocity).as_slice());
        assemble(&closed, &mut state).unwrap();

        run(&tree, &mut tree_state, 5, 0.02, 0.4);
        let (_, gap) = run(&closed, &mut state, 5, 0.02, 0.4);
        let (expected, got) = (body_states(&tree, &tree_state)[0], body_states(&closed, &state)[0]);
        let apart = (expected.position - got.position).norm() + (expected.rotation - got.rotation).norm();
        let rates = (expected.velocity - got.velocity).norm();
        let carried = Reactions::new(&tree).at(&tree_state.position, &tree_state.velocity).0[0];
        let mut of_closed = Reactions::new(&closed);
        let loops = of_closed.at(&state.position, &state.velocity).1;
        // On a plane or a line the carried torque is taken about the point of the body, which is the anchor.
        let wrench = (loops[0].force - carried.force).norm() + (loops[0].torque - carried.torque).norm();
        assert!(wrench < 1e-9 * (1.0 + carried.force.norm()), "{tree_kind:?}: {wrench:e} of {carried:?}");
        // The same discrete motion: the multipliers of a joint do what its reduced coordinates do.
        assert!(apart < 1e-12 && rates < 1e-11, "{tree_kind:?}: {apart:e} {rates:e}");
        assert!(gap < 1e-14, "{tree_kind:?}: {gap:e}");
    }
}

#[test]
fn loops_without_a_tree_joint_of_their_kind_stay_closed_and_conserve_energy() {
    let on_world = frame(Vector3::new(0.0, 0.0, 0.5), Vector3::new(0.1, 0.2, 0.3));
    let kinds = [
        (LoopKind::Cylindrical, on_world, 4),
        (
            LoopKind::Universal,
            on_world * frame(Vector3::zeros(), Vector3::new(std::f64::consts::FRAC_PI_2, 0.0, 0.0)),
            4,
        ),
        (LoopKind::Distance(0.5), frame(Vector3::new(0.5, 0.0, 0.5), Vector3::zeros()), 1),
        (LoopKind::Fixed, on_world, 6),
    ];
    for (kind, on_world, rows) in kinds {
        let place = frame(Vector3::new(0.0, 0.0, 0.5), Vector3::new(0.1, 0.2, 0.3));
        let arm = frame(Vector3::new(0.2, 0.0, 0.1), Vector3::zeros());
        let free = Joint::new("free", JointKind::Floating, place, arm);
        let mut closed = Mechanism::new("closed", Vector3::new(0.0, 0.0, -9.81), vec![lump(free)]).unwrap();
        let (a, b) = (Attachment { body: None, frame: on_world }, Attachment { body: Some(0), frame: arm });
        closed.loops.push(LoopJoint { name: "closure".into(), kind, a, b });
        assert_eq!(kind.rows(), rows);
        let mut state = State::zero(&closed);
        state.velocity.copy_from_slice(&[0.3, -0.2, 0.4, 1.0, 2.0, -1.5]);
        assemble(&closed, &mut state).unwrap();
        let start = total_energy(&closed, &state);
        let kinetic = energy(&closed, &body_states(&closed, &state)).kinetic;
        let (_, gap) = run(&closed, &mut state, 6, 0.01, 0.5);
        assert!(gap < 1e-14, "{kind:?}: {gap:e}");
        // Order 10 at h = 0.01 and rates of a few rad/s: below rounding.
        let drift = (total_energy(&closed, &state) - start).abs();
        assert!(drift < 1e-11, "{kind:?}: {drift:e}");
        if kind == LoopKind::Fixed {
            assert!(kinetic < 1e-25, "{kinetic:e}");
        }
    }
}

/// Two pendulums side by side whose angles are geared: the second turns `ratio` times as far, plus an offset.
fn geared(ratio: f64, offset: f64) -> (Mechanism, State) {
    let hinge = |name: &str| {
        let on_world = frame(Vector3::zeros(), Vector3::x() * std::f64::consts::FRAC_PI_2);
        let on_body = frame(Vector3::new(-0.5, 0.0, 0.0), Vector3::x() * std::f64::consts::FRAC_PI_2);
        Joint::new(name, JointKind::Revolute, on_world, on_body)
    };
    let bodies = ["first", "second"].map(|name| lump(hinge(name)));
    let mut mechanism = Mechanism::new("geared", Vector3::new(0.0, 0.0, -9.81), bodies.to_vec()).unwrap();
    let coordinate = |body| Coordinate { body, position: body, freedom: body };
    mechanism.mimics.push(Mimic {
        name: "second".into(),
        follower: coordinate(1),
        leader: coordinate(0),
        multiplier: ratio,
        offset,
    });
    let mut state = State::zero(&mechanism);
    state.position.copy_from_slice(&[0.2, ratio * 0.2 + offset]);
    (mechanism, state)
}

#[test]
fn a_mimic_joint_follows_exactly_and_its_pair_moves_as_one_angle() {
    let (ratio, offset) = (-1.7, 0.4);
    let (mechanism, mut state) = geared(ratio, offset);
    let (mut angle, mut rate) = (0.2, 0.0);
    run(&mechanism, &mut state, 6, 0.02, 2.0);
    // Lagrange's equation of one angle: J (1 + r²) q̈ = −m g l (cos q + r cos(r q + o)).
    let inertia = 0.08 + 2.0 * 0.25;
    let pull =
        |q: f64| -2.0 * 9.81 * 0.5 * (q.cos() + ratio * (ratio * q + offset).cos()) / (inertia * (1.0 + ratio * ratio));
    let step = 1e-4;
    for _ in 0..20_000 {
        let (k1, l1) = (rate, pull(angle));
        let (k2, l2) = (rate + 0.5 * step * l1, pull(angle + 0.5 * step * k1));
        let (k3, l3) = (rate + 0.5 * step * l2, pull(angle + 0.5 * step * k2));
        let (k4, l4) = (rate + step * l3, pull(angle + step * k3));
        angle += step / 6.0 * (k1 + 2.0 * (k2 + k3) + k4);
        rate += step / 6.0 * (l1 + 2.0 * (l2 + l3) + l4);
    }
    let (gap, gap_rate) = mimic_gap(&mechanism.mimics[0], &state);
    assert!(gap.abs() < 1e-14 && gap_rate.abs() < 1e-13, "{gap:e} {gap_rate:e}");
    assert!((state.position[0] - angle).abs() < 1e-10, "{} {angle}", state.position[0]);
    assert!((state.velocity[0] - rate).abs() < 1e-9, "{} {rate}", state.velocity[0]);
}

#[test]
fn the_violation_of_a_run_counts_mimic_relations() {
    let (mechanism, mut state) = geared(-1.7, 0.4);
    state.position[1] += 1e-3;
    state.compensation[1] = 1e-17;
    state.velocity[1] += 0.5;
    let found = violation(&mechanism, &state, &body_states(&mechanism, &state));
    assert!((found.position - 1e-3).abs() < 1e-15 && found.velocity == 0.5, "{found:?}");
}

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
fn dense_output_stays_on_the_loops() {
    let (mechanism, mut state) = closed::bricard();
    let mut lobatto = Lobatto::fixed(&mechanism, 4, 0.1).unwrap();
    let mut inside = state.clone();
    while state.time < 0.5 {
        let start = state.time;
        lobatto.advance(&mechanism, &mut state, 0.5).unwrap();
        for part in [0.1, 0.37, 0.81] {
            let time = start + part * (state.time - start);
            lobatto.dense(&mechanism, time, &mut inside.position, &mut inside.velocity);
            let (gap, rate) = loop_gaps(&mechanism.loops[0], &body_states(&mechanism, &inside)).largest();
            assert!(gap < 1e-14 && rate < 1e-13, "{gap:e} {rate:e}");
        }
    }
}

#[test]
#[ignore = "a minute; cargo test --release --test scheme loops:: -- --ignored"]
fn the_gap_of_bricard_is_rounding_after_a_million_steps() {
    let (mechanism, mut state) = closed::bricard();
    let (_, gap) = run(&mechanism, &mut state, 4, 0.01, 1e4);
    assert!(gap < 1e-14, "{gap:e}");
}

#[test]
fn a_loop_that_is_closed_sixteen_times_over_moves_as_if_closed_once() {
    let (mechanism, mut state) = closed::four_bars(1, 5);
    let mut crowded = (mechanism.clone(), state.clone());
    for copy in 1..16 {
        let name = format!("copy{copy}");
        crowded.0.loops.push(LoopJoint { name, ..mechanism.loops[0].clone() });
    }
    run(&mechanism, &mut state, 5, 0.02, 0.6);
    run(&crowded.0, &mut crowded.1, 5, 0.02, 0.6);
    let largest = state.position.iter().zip(&crowded.1.position).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
    // Thirty steps, each iterated to rounding.
    assert!(largest < 1e-13, "{largest:e}");
    let redundant = redundancy(&crowded.0, &crowded.1).redundant;
    assert_eq!(redundant.iter().map(|(_, count)| count).sum::<usize>(), 78, "{redundant:?}");
}

#[test]
fn the_gap_is_rounding_however_often_the_joints_have_turned() {
    // After ten thousand turns a double knows an angle to 7e-12 rad only; what its roundings leave out is kept too.
    let (mechanism, mut state) = closed::four_bars(1, 5);
    let turns = 1e4 * std::f64::consts::TAU;
    state.position[0] += turns;
    state.position[1] -= turns;
    state.position[2] += turns;
    assemble(&mechanism, &mut state).unwrap();
    let (_, gap) = run(&mechanism, &mut state, 4, 0.01, 5.0);
    assert!(gap < 1e-14, "{gap:e}");
}

#[test]
fn the_feet_of_a_closed_frame_carry_its_weight_and_its_momentum() {
    // Bricard's mechanism hangs on the world by its first hinge and by its loop: together they change its momentum.
    let (mechanism, mut state) = closed::bricard();
    run(&mechanism, &mut state, 5, 0.05, 0.7);
    let mut reactions = Reactions::new(&mechanism);
    let (joints, loops) = reactions.at(&state.position, &state.velocity);
    let momentum = |state: &State| catena::invariants::momentum(&mechanism, &body_states(&mechanism, state)).0;
    let rate = {
        // Central difference over 2e-4 s: 1e-7 of an acceleration's change.
        let step = 1e-4;
        let mut after = state.clone();
        run(&mechanism, &mut after, 5, step, state.time + step);
        let mut before = state.clone();
        before.velocity.iter_mut().for_each(|rate| *rate = -*rate);
        run(&mechanism, &mut before, 5, step, state.time + step);
        // Backwards in time momenta are opposite.
        (momentum(&after) + momentum(&before)) / (2.0 * step)
    };
    let weight = mechanism.gravity * mechanism.total_mass();
    // The loop's first end is on the rod, the second is the world's: what the world gives is the opposite.
    let carried = joints[0].force - loops[0].force;
    assert!((carried + weight - rate).norm() < 1e-4, "{carried} {weight} {rate}");
}

#[test]
fn a_start_at_rest_in_a_singular_position_is_undecided_and_said_to_be() {
    for count in [1, 2] {
        let (mechanism, mut state) = closed::four_bars(count, 5);
        // All bars in line: cranks and couplers point along x.
        state.position.fill(0.0);
        state.velocity.fill(0.0);
        let error = assemble(&mechanism, &mut state.clone()).unwrap_err();
        assert_eq!(error, AssemblyError::Undecided { extra: count });
        // Inertia decides.
        let (_, moving) = closed::four_bars(count, 5);
        state.velocity.copy_from_slice(&moving.velocity);
        assemble(&mechanism, &mut state).unwrap();
        let start = total_energy(&mechanism, &state);
        run(&mechanism, &mut state, 5, 0.02, 0.3);
        let bodies = body_states(&mechanism, &state);
        assert!((bodies[2].rotation - bodies[0].rotation).norm() < 1e-6, "the cranks stay parallel");
        // One loop: no trace. Two: where the first stage lies exactly on the position its multipliers have no lever, and
        // the step leaves some 1e-5 J of 30 J behind, once; 1e-10 rad beside it nothing of it is left.
        let left_behind = (total_energy(&mechanism, &state) - start).abs();
        assert!(left_behind < [1e-12, 2e-5][count - 1], "{count}: {left_behind:e}");
        // A milliradian beside it at rest is decided.
        let mut beside = State::zero(&mechanism);
        for crank in 0..=count {
            beside.position[2 * crank] = 1e-3;
            if crank < count {
                beside.position[2 * crank + 1] = -1e-3;
            }
        }
        assemble(&mechanism, &mut beside).unwrap();
    }
}

#[test]
fn a_linkage_that_begins_to_move_has_not_passed_a_singular_position() {
    for kept in [&[][..], &[Rule::Planar]] {
        let (mut mechanism, start) = closed::four_bars(1, 5);
        mechanism.gravity = Vector3::zeros();
        let mut state = State { velocity: vec![0.0; mechanism.velocity_count], ..start.clone() };
        let mut lobatto = Lobatto::fixed(&mechanism, 5, 0.01).unwrap().keeping(&mechanism, kept);
        // At rest nothing has to be projected, so that nothing is known of the loop.
        for _ in 0..3 {
            lobatto.advance(&mechanism, &mut state, f64::INFINITY).unwrap();
        }
        state.velocity.copy_from_slice(&start.velocity);
        for _ in 0..3 {
            lobatto.advance(&mechanism, &mut state, f64::INFINITY).unwrap();
        }
        assert_eq!(lobatto.description().singular, None, "without {kept:?}");
    }
}

#[test]
fn the_fronts_of_ladders_do_not_grow_with_their_length() {
    let slots =
        |count, width, rows| Elimination::new(&closed::four_bars(count, 5).0, width, &vec![rows; count], false).slots;
    // The twist, and the equations of two neighbouring loops.
    assert_eq!([10, 100, 1000].map(|count| slots(count, 6, 5)), [16; 3]);
    assert_eq!([10, 100, 1000].map(|count| slots(count, 3, 2)), [7; 3], "in the plane");
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

/// Two arms of ball and planar joints on a floating body, joined at their hands by a universal joint.
fn floating_ring() -> (Mechanism, State) {
    let mut numbers = common::Numbers::new(11);
    let mut place = || Vector3::new(numbers.next(-0.6, 0.6), numbers.next(-0.6, 0.6), numbers.next(-0.6, 0.6));
    let kinds = [
        (None, JointKind::Floating),
        (Some(0), JointKind::Spherical),
        (Some(1), JointKind::Planar),
        (Some(0), JointKind::Revolute),
        (Some(3), JointKind::Prismatic),
    ];
    let bodies = kinds.map(|(parent, kind)| {
        let (on_parent, on_child) = (frame(place(), place()), frame(place(), place()));
        let joint = Joint::new("joint", kind, on_parent, on_child);
        Body { name: "body".into(), parent, mass: 1.3, inertia: Vector3::new(0.05, 0.08, 0.1), joint }
    });
    let mut mechanism = Mechanism::new("ring", Vector3::zeros(), bodies.to_vec()).unwrap();
    for (name, kind, a, b) in [("hands", LoopKind::Universal, 2, Some(4)), ("rope", LoopKind::Distance(1.1), 1, None)] {
        let (a, b) = (
            Attachment { body: Some(a), frame: frame(place(), place()) },
            Attachment { body: b, frame: frame(place(), place()) },
        );
        mechanism.loops.push(LoopJoint { name: name.into(), kind, a, b });
    }
    let mut state = State::zero(&mechanism);
    let push: Vec<f64> = (0..mechanism.velocity_count).map(|freedom| 0.3 * (freedom as f64 + 0.5).sin()).collect();
    state.displace(&mechanism, &push);
    state.velocity.copy_from_slice(&push);
    (mechanism, state)
}

#[test]
fn the_sparse_projection_of_velocities_equals_the_dense_one() {
    for (mechanism, state) in [closed::four_bars(3, 5), closed::bricard(), floating_ring()] {
        let count = mechanism.velocity_count;
        let wanted: Vec<f64> = (0..count).map(|freedom| (2.3 * freedom as f64 + 0.7).cos()).collect();
        let mut unit = state.clone();
        let mut of_unit = |freedom: usize| {
            unit.velocity.fill(0.0);
            unit.velocity[freedom] = 1.0;
            body_states(&mechanism, &unit)
        };
        let moved: Vec<_> = (0..count).map(&mut of_unit).collect();
        let mass = DMatrix::from_fn(count, count, |i, j| {
            let pairs = moved[i].iter().zip(&moved[j]);
            mechanism.bodies.iter().zip(pairs).fold(0.0, |sum, (body, (one, other))| {
                let turn = one.rotation.transpose();
                let spins =
                    (turn * one.angular_velocity).dot(&(turn * other.angular_velocity).component_mul(&body.inertia));
                sum + body.mass * one.velocity.dot(&other.velocity) + spins
            })
        });
        let rates = |bodies: &[catena::state::BodyState]| -> Vec<f64> {
            let gaps = mechanism.loops.iter().map(|joint| loop_gaps(joint, bodies));
            gaps.flat_map(|gaps| gaps.velocity[..gaps.count].to_vec()).collect()
        };
        let columns: Vec<Vec<f64>> = moved.iter().map(|bodies| rates(bodies)).collect();
        let gradient = DMatrix::from_fn(columns[0].len(), count, |row, freedom| columns[freedom][row]);
        let inverse = mass.cholesky().unwrap().inverse();
        let mobility = &gradient * &inverse * gradient.transpose();
        let start_velocity = DVector::from_column_slice(&wanted);
        let multipliers = mobility.pseudo_inverse(1e-9).unwrap() * (&gradient * &start_velocity);
        let dense = &start_velocity - &inverse * gradient.transpose() * multipliers;

        let mut projection = Projection::new(&mechanism);
        let mut start = Start::new(&mechanism);
        start.set(&mechanism, &state);
        let mut sparse = wanted.clone();
        projection.velocities(&mechanism, &start, &mut sparse);
        let apart = sparse.iter().zip(dense.iter()).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
        // The condition of the mass matrices is below 1e4.
        assert!(apart < 1e-11, "{}: {apart:e}", mechanism.name);
    }
}
