//! The scheme agrees with the comparator, which shares no formula with it: other coordinates, other equations, an
//! explicit method of order 8.

use crate::common::{models_of, run_until, stem, urdf_files};
use crate::models::{self, pose_distance, velocity_distance};
use catena::mechanism::description::joint::JointKind;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use catena::reduced::Dop853;
use catena::stepping::integrator::Lobatto;
use std::path::PathBuf;

/// The end of a run by steps of `step` with nine stages against its end by DOP853 at 1e-13: distance of the poses, and
/// of the velocities relative to the largest one.
fn distance(mechanism: &Mechanism, start: &State, step: f64, duration: f64) -> (f64, f64) {
    let mut ours = start.clone();
    let summary = run_until(mechanism, &mut ours, &mut Lobatto::fixed(mechanism, 9, step).unwrap(), duration);
    let mut theirs = start.clone();
    run_until(mechanism, &mut theirs, &mut Dop853::new(mechanism, 1e-13), duration);
    let (ours, theirs) = (body_states(mechanism, &ours), body_states(mechanism, &theirs));
    let speed = theirs.iter().map(|body| body.velocity.amax().max(body.angular_velocity.amax())).fold(1.0, f64::max);
    let (poses, velocities) = (pose_distance(&ours, &theirs), velocity_distance(&ours, &theirs) / speed);
    println!("{}: poses {poses:.1e}, velocities {velocities:.1e}, halved {}", mechanism.name, summary.rejected_steps);
    (poses, velocities)
}

#[test]
fn nine_stages_agree_with_dop853_on_every_test_model() {
    // A hundred and more roundings of each, and the tolerance of DOP853.
    let bound = 1e-11;
    let mut cases = vec![
        (models::double_pendulum(), 0.05, 2.0, bound),
        (models::spatial_pendulum(), 0.02, 2.0, bound),
        (models::floating_tree(), 0.02, 2.0, bound),
        (models::slow_heavy_top(), 0.02, 2.0, bound),
        // 150 rad, of which DOP853 controls every step to 1e-13 of the spin.
        (models::heavy_top(), 0.002, 1.0, 1e-10),
        (models::free_body(), 0.02, 2.0, bound),
        // Links that twist about their own axes with a thirteenth of the inertia, and magnify errors a thousandfold.
        (models::chain(10), 0.0025, 0.5, 1e-8),
        (models::planar_chain(1), 0.05, 2.0, bound),
        (models::planar_chain(10), 0.01, 2.0, bound),
    ];
    cases.extend(models::JOINT_KINDS.map(|kind| (models::one_joint(kind), 0.02, 2.0, bound)));
    for (model, step, duration, bound) in cases {
        let (poses, velocities) = distance(&model.mechanism, &model.state, step, duration);
        assert!(poses < bound, "{}: {poses:.1e}", model.mechanism.name);
        assert!(velocities < bound, "{}: {velocities:.1e}", model.mechanism.name);
    }
}

#[test]
fn nine_stages_agree_with_dop853_where_joints_turn_rotors() {
    let kinds = [JointKind::Revolute, JointKind::Prismatic].map(models::one_joint);
    let others = [models::double_pendulum(), models::floating_tree(), models::planar_chain(3)];
    for mut model in kinds.into_iter().chain(others) {
        let step = 0.02;
        let without = distance(&model.mechanism, &model.state, step, 2.0);
        let mut rotors = 0;
        for (index, body) in model.mechanism.bodies.iter_mut().enumerate() {
            if body.joint.kind.velocity_count() == 1 {
                body.joint.armature = 0.2 + 0.3 * index as f64;
                rotors += 1;
            }
        }
        assert!(rotors > 0, "{}", model.mechanism.name);
        let (poses, velocities) = distance(&model.mechanism, &model.state, step, 2.0);
        // As without rotors; DOP853 controls its steps to 1e-13.
        assert!(poses < 1e-11 && velocities < 1e-11, "{}: {without:?}", model.mechanism.name);
    }
}

/// A state in which nothing is special: every joint displaced and moving, each differently.
fn generic_state(mechanism: &Mechanism, mut state: State) -> State {
    let wave = |phase: f64| move |index: usize| 0.3 * (index as f64 + phase).sin();
    let increment: Vec<f64> = (0..mechanism.velocity_count).map(wave(1.0)).collect();
    state.displace(mechanism, &increment);
    state.velocity = (0..mechanism.velocity_count).map(wave(2.5)).collect();
    state
}

#[test]
fn nine_stages_agree_with_dop853_on_every_robot_of_this_repository() {
    let files = urdf_files(&PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("robots"));
    assert!(files.len() >= 12, "the robots are not found");
    for file in files {
        let (step, duration, bound) = match stem(&file) {
            // Five thousand times heavier at the tip than all else together: what is light turns at up to 100 rad/s and
            // magnifies errors a hundredfold in every tenth of a second.
            "chain_20_heavy_tip" => (0.0005, 0.1, 1e-9),
            "chain_10" => (0.0025, 0.5, 1e-9),
            _ => (0.0025, 0.5, 1e-11),
        };
        for (base, model) in models_of(&file) {
            let mechanism = &model.mechanism;
            let start = generic_state(mechanism, model.zero_state());
            let (poses, velocities) = distance(mechanism, &start, step, duration);
            assert!(poses < bound, "{} {base:?}: {poses:.1e}", stem(&file));
            assert!(velocities < bound, "{} {base:?}: {velocities:.1e}", stem(&file));
        }
    }
}
