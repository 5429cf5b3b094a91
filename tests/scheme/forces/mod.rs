//! Forces besides gravity: the order stays, the energy is accounted for, and analytic, published and independent answers
//! are met.

mod answers;
mod order;
mod stiff;

use crate::common::run_until;
use crate::models::{self, Model};
use catena::mechanism::description::forces::{Forces, JointDamper};
use catena::mechanism::description::joint::{Joint, JointKind};
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::integrator::Integrator;
use catena::mechanism::motion::state::State;
use catena::simulation::Summary;
use catena::stepping::integrator::Lobatto;
use nalgebra::Vector3;

/// A box on one joint whose axis is y and whose centre of mass is `below` under the joint.
fn one_body(kind: JointKind, below: f64, gravity: f64, forces: Forces) -> Model {
    let axis = if kind == JointKind::Spherical { Vector3::z() } else { Vector3::y() };
    let on_child = models::frame(Vector3::new(0.0, 0.0, below), axis);
    let joint = Joint::new("joint", kind, models::frame(Vector3::zeros(), axis), on_child);
    let inertia = models::box_inertia(1.0, Vector3::new(0.1, 0.1, 1.0));
    let bodies = vec![models::body("box", None, 1.0, inertia, joint)];
    let mut mechanism = Mechanism::new("one_body", Vector3::new(0.0, 0.0, -gravity), bodies).unwrap();
    mechanism.forces = forces;
    let state = State::zero(&mechanism);
    Model { mechanism, state }
}

fn damper(coefficient: f64) -> Vec<JointDamper> {
    vec![JointDamper { freedom: 0, coefficient }]
}

fn run(model: &Model, integrator: &mut dyn Integrator, until: f64) -> (State, Summary) {
    let mut state = model.state.clone();
    let summary = run_until(&model.mechanism, &mut state, integrator, until);
    (state, summary)
}

fn fixed(model: &Model, stages: usize, step: f64) -> Lobatto {
    Lobatto::fixed(&model.mechanism, stages, step).unwrap()
}
