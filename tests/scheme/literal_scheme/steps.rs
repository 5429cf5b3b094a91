//! Steps of the literal scheme meet benchmark answers at its order, keep joints and energy, and can be undone; what has no
//! step is refused.

use super::moving_double_pendulum;
use crate::literal::coordinates::coordinates;
use crate::literal::scheme::{Literal, LiteralError};
use crate::models::{self, Model, pose_distance, velocity_distance};
use catena::lobatto::tableau::butcher::Tableau;
use catena::mechanism::description::body_state::BodyState;
use catena::mechanism::motion::energy::{energy, violation};
use catena::mechanism::motion::kinematics::body_states;
use nalgebra::Vector3;

/// The state after `count` equal steps over `duration` seconds.
fn run(model: &Model, stages: usize, duration: f64, count: usize) -> Vec<BodyState> {
    let tableau = Tableau::of(stages).unwrap();
    let literal = Literal::new(&model.mechanism, tableau).unwrap();
    let step = duration / count as f64;
    (0..count).fold(model.bodies(), |bodies, _| literal.step(&bodies, step).unwrap().bodies)
}

#[test]
fn planar_chains_reach_the_benchmark_positions() {
    for (links, answers) in models::PLANAR_CHAIN.into_iter().filter(|(links, _)| *links <= 2) {
        for (time, [x, z, ..]) in answers.into_iter().filter(|(time, _)| *time <= 5.0) {
            let (tip_x, tip_z) =
                models::planar_chain_tip(&run(&models::planar_chain(links), 7, time, (time * 20.0) as usize));
            // Order 12 at h = 0.05 leaves less than rounding, which is 1e-16/h a step, 100 steps, grown up to sevenfold.
            let error = (tip_x - x).abs().max((tip_z - z).abs());
            assert!(error < 2e-12, "{links} links at {time} s: {error:e}");
        }
    }
}

#[test]
fn thrown_box_follows_the_benchmark_rotation_and_the_parabola() {
    let model = models::free_body();
    for (time, quaternion, body_spin) in models::FREE_BODY.into_iter().filter(|answer| answer.0 <= 2.0) {
        let body = run(&model, 7, time, (time * 40.0) as usize)[0];
        let rotation = catena::mechanism::description::joint::rotation_from_wxyz(&quaternion);
        let start = model.bodies()[0];
        let parabola = start.velocity * time + 0.5 * time * time * model.mechanism.gravity;
        // Rounding near the intermediate axis grows e^(3 t): 1e-14 · e^6 at 2 s.
        assert!((body.rotation - rotation).amax() < 1e-11, "{:e}", (body.rotation - rotation).amax());
        let spin = body.rotation.transpose() * body.angular_velocity - Vector3::from(body_spin);
        assert!(spin.amax() < 1e-10, "{:e}", spin.amax());
        // A quadratic polynomial is integrated exactly; 80 roundings of lengths up to 3 m.
        assert!((body.position - parabola).amax() < 1e-13, "{:e}", (body.position - parabola).amax());
    }
}

#[test]
fn order_is_2s_minus_2() {
    for (name, model) in
        [("spatial pendulum", models::spatial_pendulum()), ("double pendulum", models::double_pendulum())]
    {
        let duration = 0.8;
        // Order 12 with steps of 0.02: its error is far below those measured (they end at 1e-10).
        let exact = run(&model, 7, duration, 40);
        for (stages, coarse) in [(2, 80), (3, 20), (4, 10)] {
            let [first, second] =
                [coarse, 2 * coarse].map(|count| pose_distance(&run(&model, stages, duration, count), &exact));
            let order = (first / second).log2();
            println!("{name}, s = {stages}: {first:.2e} {second:.2e} order {order:.3}");
            // The next term of the error expansion is h² smaller: h = 0.08 and rates of order 5 give a few per cent.
            assert!((order - (2 * stages - 2) as f64).abs() < 0.15, "{name}, s = {stages}: order {order}");
        }
    }
}

#[test]
fn every_joint_holds_to_rounding_at_position_and_velocity_level() {
    let mut all: Vec<Model> = models::JOINT_KINDS.into_iter().map(models::one_joint).collect();
    all.extend([models::floating_tree(), models::double_pendulum(), models::chain(4)]);
    for model in all {
        for stages in [2, 3, 5] {
            let tableau = Tableau::of(stages).unwrap();
            let literal = Literal::new(&model.mechanism, tableau).unwrap();
            let mut bodies = model.bodies();
            for _ in 0..5 {
                bodies = literal.step(&bodies, 0.01).unwrap().bodies;
                let worst = violation(&model.mechanism, &model.state, &bodies);
                // A rounding of coordinates of order one each, ten terms; no step adds to the next.
                assert!(worst.position < 4e-15, "{}, s = {stages}: {worst:?}", model.mechanism.name);
                // The same for velocities, which reach 10 m/s and rad/s here.
                assert!(worst.velocity < 1e-13, "{}, s = {stages}: {worst:?}", model.mechanism.name);
                // Also for Ṙ itself: RᵀṘ must be skew, or the angular velocity would not represent it.
                let (q, velocity) = coordinates(&bodies);
                assert!((literal.constraint_jacobian(&q) * velocity).amax() < 1e-13);
            }
        }
    }
}

#[test]
fn step_back_undoes_a_step() {
    for model in [
        moving_double_pendulum(),
        models::floating_tree(),
        models::one_joint(catena::mechanism::description::joint::JointKind::Planar),
    ] {
        for stages in [2, 3, 4, 6] {
            let tableau = Tableau::of(stages).unwrap();
            let literal = Literal::new(&model.mechanism, tableau).unwrap();
            let (start, step) = (model.bodies(), 0.02);
            let there = literal.step(&start, step).unwrap().bodies;
            let back = literal.step(&there, -step).unwrap().bodies;
            let (poses, velocities) = (pose_distance(&start, &back), velocity_distance(&start, &back));
            println!("{} s = {stages}: {poses:.1e} {velocities:.1e}", model.mechanism.name);
            // Positions to rounding; velocities to the rounding of positions divided by the step (5e-15), some ten times.
            assert!(poses < 1e-14, "{}, s = {stages}: {poses:e}", model.mechanism.name);
            assert!(velocities < 1e-13, "{}, s = {stages}: {velocities:e}", model.mechanism.name);
            // The claim is about h, −h, not about small steps: the motion was a thousand times larger.
            assert!(pose_distance(&start, &there) > 1e-3);
        }
    }
}

#[test]
fn energy_error_does_not_grow_with_time() {
    // The order-2 scheme at a coarse step: a method that is not symplectic would drift. Second half against first half.
    let model = models::double_pendulum();
    let tableau = Tableau::of(2).unwrap();
    let literal = Literal::new(&model.mechanism, tableau).unwrap();
    let mut bodies = model.bodies();
    let start = energy(&model.mechanism, &bodies).total();
    let mut worst = [0.0f64; 2];
    for step in 0..2000 {
        bodies = literal.step(&bodies, 0.02).unwrap().bodies;
        let error = (energy(&model.mechanism, &bodies).total() - start).abs();
        worst[step / 1000] = worst[step / 1000].max(error);
    }
    println!("energy error {:.2e} J in the first half, {:.2e} J in the second", worst[0], worst[1]);
    assert!(worst[1] < 1.5 * worst[0]);
    // Rounding defects of the constraints add up like a random walk: 1e-16 · √2000, and some for ten terms each.
    let drift = violation(&model.mechanism, &model.state, &bodies).position;
    println!("constraint defect after 2000 steps {drift:.1e}");
    assert!(drift < 3e-14, "{drift:e}");
}

#[test]
fn singular_second_moments_are_refused_by_name() {
    let model = models::heavy_top();
    let tableau = Tableau::of(3).unwrap();
    match Literal::new(&model.mechanism, tableau) {
        Err(LiteralError::Mass { body, moments, .. }) => {
            assert_eq!(body, "top");
            assert_eq!(moments[1], 0.0);
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn step_beyond_the_embedding_is_an_error() {
    // A body turned by one s = 2 step obeys sin θ = hω: no solution beyond hω = 1.
    let model = models::free_body();
    let tableau = Tableau::of(2).unwrap();
    let literal = Literal::new(&model.mechanism, tableau).unwrap();
    assert!(literal.step(&model.bodies(), 0.3).is_err());
    assert!(literal.step(&model.bodies(), 0.1).is_ok());
}

#[test]
fn coordinates_and_body_states_are_inverse() {
    let model = models::floating_tree();
    let bodies = body_states(&model.mechanism, &model.state);
    let (q, velocity) = coordinates(&bodies);
    let again = crate::literal::coordinates::body_states(&q, &velocity);
    assert_eq!(pose_distance(&bodies, &again), 0.0);
    // The angular velocity goes through Ṙ = ω̂R and back, a dozen roundings of numbers of order one.
    assert!(velocity_distance(&bodies, &again) < 1e-14);
}
