//! What vanishes from the equations of a body may be left out: the full model says the same.

mod models;

use catena::lobatto::Lobatto;
use catena::model::{Joint, JointKind, Mechanism, Rule, point_bodies, sliding_bodies};
use catena::simulation::{Integrator, StepOutcome};
use catena::state::State;
use models::Model;
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
