//! Steps that begin in single precision end where others do. That their first iterations are those of double precision to the digits of
//! single is tested where these are made, in `src/lobatto/solve/single_precision.rs`. And guesses from attempts that were too long.

use crate::models::{self, Model};
use catena::kernels::step_for;
use catena::lobatto::numbers::lanes::Isa;
use catena::lobatto::stages::attempt::{Attempt, Guess, StopRule};
use catena::lobatto::tableau::butcher::Tableau;
use catena::mechanism::description::body_state::BodyState;
use catena::mechanism::description::joint::{Joint, JointKind, Pose};
use catena::mechanism::description::mechanism::{Body, Mechanism};
use catena::mechanism::description::rules::Rule;
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use nalgebra::{Translation3, UnitQuaternion, Vector3};

const STAGES: usize = 9;
const STEP: f64 = 0.05;

/// The end of a step that was iterated as far as `stop`, in single precision at first if it may be `rough`, and the iterations.
fn end(model: &Model, isa: Isa, stop: f64, rough: bool) -> (Vec<BodyState>, usize) {
    let mechanism = &model.mechanism;
    let mut kernel = step_for(mechanism, Tableau::of(STAGES).unwrap(), isa, &[Rule::Planar]);
    kernel.expect(mechanism, stop);
    let mut state = model.state.clone();
    kernel.begin(mechanism, &state);
    let rule = StopRule { increment: stop, rough, ..StopRule::ROUNDING };
    let attempt = kernel.attempt(mechanism, STEP, &rule, Guess::Plain);
    assert!(matches!(attempt, Attempt::Converged { .. }), "{} to {stop:e}: {attempt:?}", mechanism.name);
    kernel.finish(mechanism, &mut state);
    (body_states(mechanism, &state), attempt.iterations())
}

#[test]
fn steps_that_begin_in_single_precision_end_where_others_do() {
    for model in models::every_model() {
        let (exact, _) = end(&model, Isa::detect(), 2e-16, false);
        for stop in [1e-2, 1e-3, 1e-4, 1e-6, 1e-7] {
            let (double, in_double) = end(&model, Isa::detect(), stop, false);
            let (single, in_single) = end(&model, Isa::detect(), stop, true);
            let [double, single] = [double, single].map(|end| models::pose_distance(&end, &exact));
            let name = &model.mechanism.name;
            println!("{name} to {stop:e}: {double:.1e} after {in_double}, {single:.1e} after {in_single} iterations");
            // What the last increment leaves is below it, whatever the digits; bodies are within two metres of the joints that move them.
            assert!(single < 2.0 * stop, "{name} to {stop:e}: {single:.1e} off, {double:.1e} in double precision");
            // Where one iteration in double precision is exact, as of sliders, the roundings of the first take one or two more.
            assert!(in_single <= in_double + 2, "{name} to {stop:e}: {in_single} iterations instead of {in_double}");
        }
    }
}

#[test]
fn masses_beyond_the_range_of_single_numbers_are_left_to_double_precision() {
    let mut model = models::spatial_pendulum();
    let (ordinary, _) = end(&model, Isa::detect(), 1e-3, false);
    for body in &mut model.mechanism.bodies {
        body.mass *= 1e-44;
        body.inertia *= 1e-44;
    }
    let (light, _) = end(&model, Isa::detect(), 1e-3, true);
    // The same motion: nothing depends on the unit of mass.
    let apart = models::pose_distance(&ordinary, &light);
    assert!(apart < 1e-9, "{apart:.1e} apart");
}

/// Rounding of the moments across a link, 6e-8 of them, is what it has about its own axis: factors that are ten times too large make
/// increments look converged that are not, and others never converge.
#[test]
fn links_that_hardly_resist_to_be_twisted_are_left_to_double_precision() {
    let ends = |share: f64| {
        let mut model = models::chain(4);
        for body in &mut model.mechanism.bodies {
            body.inertia.x = share * body.inertia.y;
        }
        [false, true].map(|rough| end(&model, Isa::detect(), 1e-3, rough))
    };
    for share in [1e-6, 1e-7, 1e-8] {
        let [(double, in_double), (single, in_single)] = ends(share);
        // Where single precision fails the exact method has the last word, so that ends say little.
        assert!(double == single, "{share:e} of the moments across it");
        assert_eq!(in_double, in_single, "{share:e} of the moments across it: iterations");
    }
    let [(double, _), (single, _)] = ends(1e-2);
    assert!(Isa::detect() == Isa::Portable || double != single, "not even ordinary links are in single precision");
}

#[test]
fn a_shorter_step_is_solved_sooner_from_the_attempt_that_was_too_long() {
    let hinge = |name: &str, parent, on_parent| {
        let on_child = Translation3::new(-0.5, 0.0, 0.0).into();
        let joint = Joint::new(name, JointKind::Revolute, on_parent, on_child);
        Body { name: name.into(), parent, mass: 1.0, inertia: Vector3::new(0.0, 0.1, 0.1), joint }
    };
    let tilt = UnitQuaternion::from_euler_angles(0.6, 0.0, 0.0).to_rotation_matrix();
    let outer = Pose::from_parts(Translation3::new(0.5, 0.0, 0.0), tilt);
    let bodies = vec![hinge("inner", None, Pose::identity()), hinge("outer", Some(0), outer)];
    let mechanism = Mechanism::new("arm", Vector3::new(0.0, -9.81, 0.0), bodies).unwrap();
    let mut state = State::zero(&mechanism);
    state.velocity.copy_from_slice(&[1.0, -2.0]);
    let mut kernel = step_for(&mechanism, Tableau::of(STAGES).unwrap(), Isa::detect(), &[Rule::Planar]);
    kernel.begin(&mechanism, &state);
    let rule = StopRule { increment: 1e-9, ..StopRule::ROUNDING };
    let mut iterations = |step, guess| match kernel.attempt(&mechanism, step, &rule, guess) {
        Attempt::Converged { iterations, .. } => iterations,
        other => panic!("{other:?}"),
    };
    let [_, from_longer, from_rates] =
        [(0.2, Guess::Plain), (0.17, Guess::Longer(0.2)), (0.17, Guess::Plain)].map(|(h, guess)| iterations(h, guess));
    // The longer one is off by its truncation alone, some 1e-8.
    assert!(from_longer <= 2 && from_rates >= 5, "{from_longer} and {from_rates}");
}
