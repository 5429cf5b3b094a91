//! Trees in a plane: fixed and chosen steps, long ones and hard ones, and energies are those in space.

use super::apart;
use crate::in_plane::random_tree;
use crate::literal::scheme::Literal;
use crate::models::{self, Model};
use catena::kernels::step_for;
use catena::lobatto::numbers::lanes::Isa;
use catena::lobatto::stages::attempt::StopRule;
use catena::lobatto::tableau::butcher::Tableau;
use catena::mechanism::description::joint::JointKind;
use catena::mechanism::description::rules::Rule;
use catena::mechanism::motion::energy::energy_with_forces;
use catena::mechanism::motion::integrator::{Integrator, StepOutcome};
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use catena::mechanism::structure::plane::Plane;
use catena::stepping::integrator::Lobatto;
use nalgebra::Vector3;

/// Two rods on parallel hinges.
fn double_pendulum() -> Model {
    let mut model = models::planar_chain(2);
    model.state.position = vec![1.2, -0.7];
    model
}

/// With every kind of force: in the joints, between points at different heights, and on the bodies.
fn forced(model: Model) -> Model {
    let all = models::every_force(&model.mechanism).pop().expect("all forces").1;
    models::with_forces(model, all)
}

fn everything() -> Vec<(&'static str, Model)> {
    vec![
        ("double pendulum", double_pendulum()),
        ("chain", models::planar_chain(6)),
        ("level tree", random_tree(1, 9, Vector3::y())),
        ("inclined tree", random_tree(2, 12, Vector3::new(0.3, -0.5, 0.7))),
        ("two slides", models::one_joint(JointKind::Prismatic)),
        ("tree with forces", forced(random_tree(3, 12, Vector3::new(-0.2, 0.4, 0.6)))),
        ("slides with forces", forced(models::one_joint(JointKind::Prismatic))),
    ]
}

/// What became of a run: the state at its end, and what each step did.
fn run(model: &Model, mut lobatto: Lobatto, until: f64) -> (State, Vec<StepOutcome>) {
    let (mut state, mut outcomes) = (model.state.clone(), Vec::new());
    while state.time < until {
        outcomes.push(lobatto.advance(&model.mechanism, &mut state, until).expect("a step"));
    }
    (state, outcomes)
}

/// Iterations and rejected attempts of each step.
fn counts(outcomes: &[StepOutcome]) -> Vec<(usize, usize)> {
    outcomes.iter().map(|outcome| (outcome.cost.iterations, outcome.cost.rejected.total())).collect()
}

/// The run in the plane, and that of the full model.
fn both(model: &Model, make: impl Fn() -> Lobatto, until: f64) -> [(State, Vec<StepOutcome>); 2] {
    assert!(Plane::of(&model.mechanism).is_some(), "no plane");
    [run(model, make(), until), run(model, make().keeping(&model.mechanism, &[Rule::Planar]), until)]
}

#[test]
fn fixed_steps_in_the_plane_are_those_in_space() {
    for (name, model) in everything() {
        for stages in 2..=9 {
            let step = if stages < 4 { 0.005 } else { 0.02 };
            let make = || Lobatto::fixed(&model.mechanism, stages, step).expect("stages");
            for steps in [1.0, 25.0] {
                let [(flat, ours), (full, theirs)] = both(&model, make, steps * step);
                let gap = apart(&flat, &full);
                // Both round, at sums of up to 2000 terms of order one, and motions of this length amplify it tenfold.
                assert!(gap < 1e-12, "{name}, {stages} stages, {steps} steps: {gap:e}");
                let exchanged =
                    |outcomes: &[StepOutcome]| outcomes.iter().map(|one| one.exchange.dissipated).sum::<f64>();
                let (lost, expected) = (exchanged(&ours), exchanged(&theirs));
                assert!((lost - expected).abs() <= 1e-12 * expected, "{name}: dissipated {lost} J, not {expected} J");
                assert_eq!(expected > 0.0, name.ends_with("with forces"), "{name}");
                let put_in = |outcomes: &[StepOutcome]| outcomes.iter().map(|one| one.exchange.work).sum::<f64>();
                let (work, expected) = (put_in(&ours), put_in(&theirs));
                assert!((work - expected).abs() <= 1e-12, "{name}: work of {work} J, not {expected} J");
                assert_eq!(expected != 0.0, name == "tree with forces", "{name}");
            }
        }
    }
}

#[test]
fn random_forests_in_the_plane_move_as_in_space() {
    let (mut roots, mut branches, mut kinds) = (0, 0, [0; 3]);
    for seed in 100..160 {
        let normal = Vector3::new(0.1 * (seed % 7) as f64, 0.2 * (seed % 5) as f64 - 0.3, 0.6);
        let mut model = random_tree(seed, 2 + (seed as usize % 17), normal);
        let bodies = &mut model.mechanism.bodies;
        roots += bodies.iter().filter(|body| body.parent.is_none()).count() - 1;
        let children = |index| bodies.iter().filter(|body| body.parent == Some(index)).count();
        branches += (0..bodies.len()).filter(|&index| children(index) > 1).count();
        for body in bodies.iter() {
            kinds[body.joint.kind.translation_axes().len()] += 1;
        }
        // A link without mass has to be carried by what hangs on it.
        if let Some(massless) = (0..bodies.len()).find(|&index| children(index) == 1 && index % 7 < 3) {
            (bodies[massless].mass, bodies[massless].inertia) = (0.0, Vector3::zeros());
        }
        let make = || Lobatto::fixed(&model.mechanism, 5, 0.01).expect("stages");
        let [(flat, ours), (full, theirs)] = both(&model, make, 0.1);
        let gap = apart(&flat, &full);
        assert!(gap < 1e-11, "forest {seed}: {gap:e}");
        assert_eq!(ours.len(), theirs.len(), "forest {seed}");
    }
    assert!(roots > 10 && branches > 10 && kinds.iter().all(|&count| count > 10), "{roots} {branches} {kinds:?}");
}

#[test]
fn one_step_in_the_plane_is_that_of_the_literal_scheme() {
    for (seed, with_forces) in [(11, false), (12, true), (13, false)] {
        let tree = random_tree(seed, 4, Vector3::new(0.4, 0.2, 0.9));
        let model = if with_forces { forced(tree) } else { tree };
        for stages in 2..=4 {
            let tableau = Tableau::of(stages).expect("stages");
            let step = 0.02;
            let literal = Literal::new(&model.mechanism, tableau).expect("second moments that can be inverted");
            let expected = literal.step(&model.bodies(), step).expect("a step").bodies;
            let (state, _) = run(&model, Lobatto::fixed(&model.mechanism, stages, step).expect("stages"), step);
            let bodies = body_states(&model.mechanism, &state);
            // As in `tests/scheme/literal_equality.rs`: the dense oracle rounds at entries of size one to ten.
            let (position, velocity) =
                (models::pose_distance(&bodies, &expected), models::velocity_distance(&bodies, &expected));
            assert!(position < 1e-12, "tree {seed}, {stages} stages: poses differ by {position:.1e}");
            assert!(velocity < 1e-11, "tree {seed}, {stages} stages: velocities differ by {velocity:.1e}");
        }
    }
}

#[test]
fn chosen_steps_in_the_plane_are_those_in_space() {
    for (name, model) in everything() {
        for (tolerance, stop) in [(1e-3, 1e-7), (1e-6, 1e-10), (1e-9, 1e-13)] {
            let make = || Lobatto::adaptive_with_stop(&model.mechanism, tolerance, stop);
            let [(flat, ours), (full, theirs)] = both(&model, make, 1.0);
            assert_eq!(ours.len(), theirs.len(), "{name}, {tolerance:e}");
            for (here, there) in counts(&ours).into_iter().zip(counts(&theirs)) {
                // Where the guess is right to rounding, as of bodies that only slide, rounding ends the iteration.
                assert!(
                    here.0.abs_diff(there.0) <= 1 && here.1 == there.1,
                    "{name}, {tolerance:e}: {here:?} {there:?}"
                );
            }
            // The change of the energy, of which the last digits are rounding, has a say in the length of a step: the motions differ by
            // a share of their errors. Where the stop is coarse, first iterations are in single precision, in space alone: what is left of
            // their roundings is less than the stop in each of some ten steps, and a tree amplifies it a few times. (Of 48 starts the worst
            // is 1.7e-6.)
            let gap = apart(&flat, &full);
            let share = if stop > 1e-9 { 4e-3 } else { 1e-5 };
            assert!(gap < (share * tolerance).max(1e-11), "{name}, {tolerance:e}: {gap:e}");
        }
    }
}

#[test]
fn steps_with_the_pace_of_the_motion_are_those_in_space() {
    for (name, model) in everything() {
        if !model.mechanism.is_plain_tree() {
            continue;
        }
        let make = || Lobatto::reversible(&model.mechanism, 5, 0.01).expect("a tree under gravity");
        let [(flat, ours), (full, theirs)] = both(&model, make, 0.5);
        assert_eq!(ours.len(), theirs.len(), "{name}");
        let gap = apart(&flat, &full);
        assert!(gap < 1e-11, "{name}: {gap:e}");
    }
}

#[test]
fn steps_that_need_the_exact_newton_method_or_are_too_long_are_those_in_space() {
    let mut damped = forced(random_tree(5, 6, Vector3::new(0.2, 0.1, 1.0)));
    damped.mechanism.forces.joint_dampers.iter_mut().for_each(|damper| damper.coefficient = 1e3);
    let make = || Lobatto::fixed(&damped.mechanism, 9, 0.02).expect("stages");
    let [(flat, ours), (full, theirs)] = both(&damped, make, 0.1);
    assert_eq!(counts(&ours), counts(&theirs));
    // The first step tries the simplified iteration twice, which hard dampers do not let converge; all others do without it.
    assert!(
        ours[0].cost.iterations > 20 && ours[1..].iter().all(|one| one.cost.iterations < 10),
        "{:?}",
        counts(&ours)
    );
    assert!(ours.iter().chain(&theirs).all(|one| one.exact), "the outcomes do not say so");
    let gap = apart(&flat, &full);
    assert!(gap < 1e-12, "{gap:e}");

    let mut heavy = models::planar_chain(5);
    for (index, body) in heavy.mechanism.bodies.iter_mut().enumerate() {
        let scale = 10_f64.powi(index as i32);
        (body.mass, body.inertia) = (body.mass * scale, body.inertia * scale);
    }
    heavy.state.velocity[4] = 3.0;
    let make = || Lobatto::fixed(&heavy.mechanism, 9, 0.1).expect("stages");
    let [(flat, ours), (full, theirs)] = both(&heavy, make, 0.3);
    let rejected = |outcomes: &[StepOutcome]| outcomes.iter().map(|one| one.cost.rejected.total()).collect::<Vec<_>>();
    assert_eq!(rejected(&ours), rejected(&theirs));
    assert!(rejected(&ours).iter().sum::<usize>() > 0, "no step was too long");
    // Rounding, amplified by masses of one to ten thousand.
    let gap = apart(&flat, &full);
    assert!(gap < 1e-10, "{gap:e}");
}

#[test]
fn bodies_that_turn_far_within_a_step_do_so_as_in_space() {
    // The rods turn by 1.1 and 1.7 rad a step.
    let mut model = double_pendulum();
    model.state.velocity = vec![55.0, 30.0];
    let make = || Lobatto::fixed(&model.mechanism, 9, 0.02).expect("stages");
    let [(flat, ours), (full, _)] = both(&model, make, 0.1);
    assert!(ours.iter().all(|one| one.cost.rejected.total() == 0 && !one.exact), "{:?}", counts(&ours));
    // Rounding of velocities of a hundred. (Of 96 starts the middle one is 1.4e-12, the worst 1.0e-11.)
    let gap = apart(&flat, &full);
    assert!(gap < 2e-11, "{gap:e}");
}

#[test]
fn every_vector_type_makes_the_same_steps_in_the_plane() {
    for (name, model) in everything() {
        for stages in [2, 3, 4, 5, 6, 9, 10, 16] {
            let ends = [Isa::Portable, Isa::Avx2, Isa::Avx512].map(|isa| {
                let fixed = Lobatto::fixed_with(&model.mechanism, stages, 0.005, StopRule::ROUNDING, isa);
                run(&model, fixed.expect("stages"), 0.05).0
            });
            // They differ in fused products; more stages have larger coefficients.
            assert!(apart(&ends[0], &ends[1]) < 1e-12, "{name}, {stages} stages: {:e}", apart(&ends[0], &ends[1]));
            assert!(apart(&ends[0], &ends[2]) < 1e-12, "{name}, {stages} stages: {:e}", apart(&ends[0], &ends[2]));
        }
    }
}

#[test]
fn the_energy_of_a_step_in_the_plane_is_that_of_the_bodies() {
    for (name, model) in everything() {
        let Model { mechanism, state } = &model;
        let mut kernel = step_for(mechanism, Tableau::of(5).expect("stages"), Isa::detect(), &[]);
        kernel.begin(mechanism, state);
        let ours = kernel.energy();
        let expected = energy_with_forces(mechanism, &state.position, &body_states(mechanism, state));
        let parts = [
            (ours.kinetic, expected.kinetic),
            (ours.potential, expected.potential),
            (ours.spring, expected.spring),
            (ours.load, expected.load),
        ];
        for (part, expected) in parts {
            // A dozen bodies of some joules, of either sign, in another order.
            assert!((part - expected).abs() < 1e-12, "{name}: {part} J, not {expected} J");
        }
    }
}

#[test]
fn joints_that_have_turned_ten_thousand_times_are_placed_as_well_as_in_space() {
    // A double knows such an angle to 7e-12 rad only: both kernels take what its rounding leaves out.
    let mut model = double_pendulum();
    model.state.position[0] += 1e4 * std::f64::consts::TAU;
    model.state.compensation[0] = 3e-12;
    let [flat, full] = both(&model, || Lobatto::fixed(&model.mechanism, 5, 0.01).unwrap(), 0.5);
    let places = |state: &State| body_states(&model.mechanism, state);
    let difference = models::pose_distance(&places(&flat.0), &places(&full.0));
    assert!(difference < 1e-13, "{difference:e}");
}
