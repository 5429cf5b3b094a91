//! What vanishes from the equations of a body may be left out: the full model says the same.

use crate::models::{self, Model};
use catena::mechanism::description::body_state::BodyState;
use catena::mechanism::description::joint::{Joint, JointKind};
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::description::rules::Rule;
use catena::mechanism::motion::energy::{energy, momentum};
use catena::mechanism::motion::integrator::{Integrator, StepOutcome};
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use catena::mechanism::structure::special_bodies::{
    pivoted_bodies, point_bodies, sliding_bodies, spherical_bodies, tumbles,
};
use catena::stepping::integrator::Lobatto;
use nalgebra::Vector3;

/// A cart that slides along three axes in turn, the first with a second cart beside it, a spatial pendulum of two hinges on each end,
/// and a slide on the last of these, which turns with it.
fn gantry() -> Model {
    let slide = |name: &str, parent, along| {
        let (on_parent, on_child) =
            (models::frame(Vector3::new(0.1, 0.2, -0.1), along), models::frame(Vector3::new(0.05, -0.1, 0.2), along));
        models::body(
            name,
            parent,
            2.0,
            models::box_inertia(2.0, Vector3::new(0.3, 0.2, 0.4)),
            Joint::new(name, JointKind::Prismatic, on_parent, on_child),
        )
    };
    let hinge = |name: &str, parent, about| {
        let (on_parent, on_child) =
            (models::frame(Vector3::new(0.0, 0.1, -0.3), about), models::frame(Vector3::new(0.1, 0.0, 0.3), about));
        models::body(
            name,
            Some(parent),
            1.0,
            models::box_inertia(1.0, Vector3::new(0.1, 0.2, 0.6)),
            Joint::new(name, JointKind::Revolute, on_parent, on_child),
        )
    };
    let bodies = vec![
        slide("along", None, Vector3::x()),
        slide("across", Some(0), Vector3::new(0.2, 1.0, 0.1)),
        slide("lift", Some(1), Vector3::z()),
        hinge("shoulder", 2, Vector3::y()),
        hinge("elbow", 3, Vector3::x()),
        slide("finger", Some(4), Vector3::z()),
        slide("beside", Some(0), Vector3::y()),
        hinge("pendulum", 6, Vector3::new(1.0, 0.5, 0.0)),
    ];
    let mut mechanism = Mechanism::new("gantry", models::gravity(), bodies).expect("depth first");
    // What slides along z would fall freely.
    mechanism.forces = models::joint_springs(&mechanism);
    let mut state = State::zero(&mechanism);
    for (index, (position, rate)) in state.position.iter_mut().zip(&mut state.velocity).enumerate() {
        (*position, *rate) = (0.3 - 0.1 * index as f64, 0.5 + 0.2 * index as f64);
    }
    Model { mechanism, state }
}

/// The same without forces.
fn free_gantry() -> Model {
    let mut model = gantry();
    model.mechanism.forces = Default::default();
    model
}

/// Four links on hinges about y and x in turn; the second is a point, the third nothing but a frame.
fn points() -> Model {
    let link = |index: usize| {
        let about = if index.is_multiple_of(2) { Vector3::y() } else { Vector3::x() };
        let end = Vector3::new(0.0, 0.0, if index == 0 { 0.0 } else { -0.3 });
        let joint = Joint::new(
            &format!("hinge{index}"),
            JointKind::Revolute,
            models::frame(end, about),
            models::frame(Vector3::new(0.0, 0.0, 0.3), about),
        );
        let (mass, inertia) = match index {
            1 => (1.0, Vector3::zeros()),
            2 => (0.0, Vector3::zeros()),
            _ => (1.0, models::box_inertia(1.0, Vector3::new(0.1, 0.2, 0.6))),
        };
        models::body(&format!("link{index}"), index.checked_sub(1), mass, inertia, joint)
    };
    let mechanism = Mechanism::new("points", models::gravity(), (0..4).map(link).collect()).expect("a chain");
    let mut state = State::zero(&mechanism);
    state.position.copy_from_slice(&[0.5, -0.4, 0.3, 0.6]);
    Model { mechanism, state }
}

fn run(model: &Model, mut lobatto: Lobatto) -> (State, Vec<StepOutcome>) {
    let (mut state, mut outcomes) = (model.state.clone(), Vec::new());
    while state.time < 1.0 {
        outcomes.push(lobatto.advance(&model.mechanism, &mut state, 1.0).expect("a step"));
    }
    (state, outcomes)
}

#[test]
fn what_is_left_out_is_zero_to_the_last_bit() {
    for (name, model, rule) in [
        ("gantry", gantry(), Rule::Translation),
        ("gantry without forces", free_gantry(), Rule::Translation),
        ("points", points(), Rule::Points),
    ] {
        for stages in [Some(2), Some(3), Some(5), Some(9), None] {
            let lobatto = || match stages {
                Some(stages) => Lobatto::fixed(&model.mechanism, stages, 0.01).expect("stages"),
                None => Lobatto::adaptive(&model.mechanism, 1e-6),
            };
            let lean = run(&model, lobatto());
            let full = run(&model, lobatto().keeping(&model.mechanism, &[rule]));
            assert!(lean == full, "{name}, {stages:?} stages: {:?} {:?}", lean.0, full.0);
        }
    }
}

#[test]
fn only_bodies_with_nothing_but_slides_below_them_never_turn() {
    let mechanism = gantry().mechanism;
    assert_eq!(sliding_bodies(&mechanism), [true, true, true, false, false, false, true, false]);
    assert_eq!(point_bodies(&points().mechanism), [false, true, true, false]);
}

/// A floating body, one on a ball joint and one on a hinge, with centres of mass beside the joints and the same inertia about all
/// axes; the last has a box's.
fn spheres() -> Model {
    let link = |index: usize| {
        let kind = [JointKind::Floating, JointKind::Spherical, JointKind::Revolute, JointKind::Revolute][index];
        let about = [Vector3::z(), Vector3::x(), Vector3::new(1.0, 2.0, 0.5), Vector3::y()][index];
        let joint = Joint::new(
            &format!("joint{index}"),
            kind,
            models::frame(Vector3::new(0.1, 0.0, -0.3), about),
            models::frame(Vector3::new(0.0, 0.1, 0.3), about),
        );
        let box_shaped = models::box_inertia(1.0, Vector3::new(0.1, 0.2, 0.6));
        let inertia = if index == 3 { box_shaped } else { Vector3::repeat(0.02 + 0.013 * index as f64) };
        models::body(&format!("link{index}"), index.checked_sub(1), 1.0, inertia, joint)
    };
    let mechanism = Mechanism::new("spheres", models::gravity(), (0..4).map(link).collect()).expect("a chain");
    let mut state = State::zero(&mechanism);
    state.velocity.iter_mut().enumerate().for_each(|(index, rate)| *rate = 1.0 - 0.4 * index as f64);
    Model { mechanism, state }
}

/// Holds runs with a rule against runs without it, with fixed steps and with a tolerance.
fn ends_as_without(model: &Model, rule: Rule) {
    for stages in [Some(2), Some(3), Some(5), Some(9), None] {
        let lobatto = || match stages {
            Some(stages) => Lobatto::fixed(&model.mechanism, stages, 0.01).expect("stages"),
            None => Lobatto::adaptive(&model.mechanism, 1e-9),
        };
        let (lean, steps) = run(model, lobatto());
        let (full, full_steps) = run(model, lobatto().keeping(&model.mechanism, &[rule]));
        let [lean, full] = [lean, full].map(|state| body_states(&model.mechanism, &state));
        // A hundred steps at most, each with roundings of 4e-15, of a motion that amplifies them by less than ten; with nine stages
        // the end velocity has weights of 36 instead of 10. (Of twelve starts of spheres the worst are 6e-13 up to five stages and 3e-12;
        // pivots 1e-13 and 1.4e-12.)
        let apart = models::pose_distance(&lean, &full).max(models::velocity_distance(&lean, &full));
        let bound = if stages.is_some_and(|stages| stages < 9) { 1e-12 } else { 6e-12 };
        assert!(apart < bound, "{stages:?} stages: {apart:.1e}");
        assert_eq!(steps.len(), full_steps.len(), "{stages:?} stages");
    }
}

#[test]
fn the_one_moment_of_a_sphere_says_what_six_say() {
    let model = spheres();
    assert_eq!(spherical_bodies(&model.mechanism), [true, true, true, false]);
    ends_as_without(&model, Rule::Spheres);
}

/// The angular momentum about the centre of mass: about the origin it would be rounded by as much as the centre has flown, 200 m.
fn turning_about_centre(mechanism: &Mechanism, bodies: &[BodyState]) -> Vector3<f64> {
    let masses = || mechanism.bodies.iter().map(|body| body.mass);
    let moment: Vector3<f64> = masses().zip(bodies).map(|(mass, body)| mass * body.position).sum();
    let centre = moment / masses().sum::<f64>();
    let about: Vec<BodyState> =
        bodies.iter().map(|body| BodyState { position: body.position - centre, ..*body }).collect();
    momentum(mechanism, &about).1
}

#[test]
fn spheres_neither_lose_energy_nor_turn_by_themselves() {
    let mut model = spheres();
    model.mechanism.gravity = Vector3::zeros();
    let start = body_states(&model.mechanism, &model.state);
    let (before, turning) = (energy(&model.mechanism, &start).total(), turning_about_centre(&model.mechanism, &start));
    let mut lobatto = Lobatto::fixed(&model.mechanism, 5, 0.01).expect("stages");
    let mut state = model.state.clone();
    for _ in 0..20_000 {
        lobatto.advance(&model.mechanism, &mut state, f64::INFINITY).expect("a step");
    }
    let end = body_states(&model.mechanism, &state);
    let (after, turned) = (energy(&model.mechanism, &end).total(), turning_about_centre(&model.mechanism, &end));
    // Roundings of 1e-15 a step make 1.4e-13 at random in 20 000 steps, and 2e-11 if they all are to one side. (Of twelve starts the worst
    // are 6e-13 of the energy and 3e-13 of the angular momentum.)
    assert!((after - before).abs() < 2e-12 * before, "energy {before} J, then off by {:.1e} J", after - before);
    assert!((turned - turning).norm() < 2e-12 * turning.norm(), "off by {:.1e}", (turned - turning).norm());
}

#[test]
fn spheres_count_under_gravity_alone() {
    let mut mechanism = spheres().mechanism;
    mechanism.forces = models::joint_springs(&mechanism);
    assert_eq!(spherical_bodies(&mechanism), [false; 4]);
}

/// Two links on hinges askew, and a third that hangs on the world beside them.
fn pivots() -> Model {
    let link = |index: usize| {
        let about = Vector3::new(0.3, 1.0, 0.2 * index as f64).normalize();
        let joint = Joint::new(
            &format!("hinge{index}"),
            JointKind::Revolute,
            models::frame(Vector3::new(0.1, 0.0, -0.3), about),
            models::frame(Vector3::new(0.05, -0.1, 0.3), about),
        );
        let inertia = models::box_inertia(1.0, Vector3::new(0.1, 0.2, 0.6));
        models::body(&format!("link{index}"), (index == 1).then_some(0), 1.0, inertia, joint)
    };
    let mechanism = Mechanism::new("pivots", models::gravity(), (0..3).map(link).collect()).expect("two trees");
    let mut state = State::zero(&mechanism);
    state.position.copy_from_slice(&[1.2, -0.7, 2.0]);
    state.velocity.copy_from_slice(&[1.0, 2.0, -3.0]);
    Model { mechanism, state }
}

#[test]
fn the_one_equation_of_a_pivot_says_what_six_say() {
    ends_as_without(&pivots(), Rule::Pivots);
}

#[test]
fn pivots_are_hinges_on_the_world_and_count_under_gravity_alone() {
    let mut mechanism = pivots().mechanism;
    assert_eq!(pivoted_bodies(&mechanism), [true, false, true]);
    assert_eq!(pivoted_bodies(&spheres().mechanism), [false; 4]);
    mechanism.forces = models::joint_springs(&mechanism);
    assert_eq!(pivoted_bodies(&mechanism), [false; 3]);
}

/// A box that is thrown, held by a frame that is neither at its centre of mass nor along its axes.
fn tumbler() -> Model {
    let joint = Joint::new(
        "thrown",
        JointKind::Floating,
        models::frame(Vector3::new(0.2, -0.1, 0.3), Vector3::new(0.5, -0.4, 0.3)),
        models::frame(Vector3::new(0.1, 0.2, 0.4), Vector3::new(-0.3, 0.6, 0.7)),
    );
    let inertia = models::box_inertia(2.0, Vector3::new(0.3, 0.5, 0.9));
    let body = models::body("box", None, 2.0, inertia, joint);
    let mechanism = Mechanism::new("tumbler", models::gravity(), vec![body]).expect("one body");
    let mut state = State::zero(&mechanism);
    state.velocity.copy_from_slice(&[1.0, -0.5, 3.0, 2.0, -3.0, 0.5]);
    Model { mechanism, state }
}

#[test]
fn the_three_equations_of_a_tumbler_say_what_six_say() {
    ends_as_without(&tumbler(), Rule::Tumblers);
}

#[test]
fn a_tumbler_neither_loses_energy_nor_turns_by_itself_and_falls_as_galileo_says() {
    let model = tumbler();
    let mechanism = &model.mechanism;
    let start = body_states(mechanism, &model.state);
    let mut lobatto = Lobatto::fixed(mechanism, 5, 0.01).expect("stages");
    let mut state = model.state.clone();
    for _ in 0..20_000 {
        lobatto.advance(mechanism, &mut state, f64::INFINITY).expect("a step");
    }
    let end = body_states(mechanism, &state);
    // In its own frame it has the energy of its rotation alone.
    let spinning = |bodies: &[BodyState]| {
        let at_rest = BodyState { position: Vector3::zeros(), velocity: Vector3::zeros(), ..bodies[0] };
        energy(mechanism, &[at_rest]).kinetic
    };
    let (before, after) = (spinning(&start), spinning(&end));
    let [turning, turned] = [&start, &end].map(|bodies| turning_about_centre(mechanism, bodies));
    // As of spheres, above. (Of twelve starts the worst are 9e-13 and 4e-13.)
    assert!((after - before).abs() < 2e-12 * before, "energy {before} J, then off by {:.1e} J", after - before);
    assert!((turned - turning).norm() < 2e-12 * turning.norm(), "off by {:.1e}", (turned - turning).norm());
    let time = state.time;
    let fallen = start[0].position + start[0].velocity * time + mechanism.gravity * (0.5 * time * time);
    // Velocities of 2000 m/s, rounded 20 000 times to 2e-13 m/s, are 2e-11 m/s off at random, which makes 5e-9 m. (Of twelve starts the worst
    // is 8e-9; with six equations it is 1.1e-7.)
    let off = (end[0].position - fallen).norm();
    assert!(off < 3e-8, "{off:.1e} m of {} m", fallen.norm());
}

#[test]
fn a_tumbler_is_one_body_with_moments_about_all_axes_under_gravity_alone() {
    let whole = tumbler().mechanism;
    assert!(tumbles(&whole));
    let mut sprung = whole.clone();
    sprung.forces = models::joint_springs(&sprung);
    let mut thin = whole.clone();
    thin.bodies[0].inertia.z = 0.0;
    let mut twice = whole.bodies.clone();
    twice.push(whole.bodies[0].clone());
    let two = Mechanism::new("two", models::gravity(), twice).expect("two bodies");
    for other in [sprung, thin, two, pivots().mechanism] {
        assert!(!tumbles(&other), "{}", other.name);
    }
}
