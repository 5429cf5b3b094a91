//! Where the scheme becomes unstable, and that it is known how near a step is to it.

mod fastest;
mod limits;
mod modes;

use crate::models::{self, Model};
use catena::lobatto::plan::tree::Plan;
use catena::lobatto::stages::start::Start;
use catena::mechanism::description::closure::Coordinate;
use catena::mechanism::description::forces::{JointDamper, JointSpring};
use catena::mechanism::description::joint::{Joint, JointKind, Pose};
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::state::State;
use nalgebra::Vector3;

fn start_of(mechanism: &Mechanism, state: &State) -> (Plan, Start) {
    let mut start = Start::new(mechanism);
    start.set(mechanism, state);
    (Plan::new(mechanism), start)
}

/// Three light links with a heavy tip, turning at 20 rad/s, the joints slightly bent.
fn taut_chain() -> Model {
    let mut bodies = Vec::new();
    for index in 0..3 {
        let on_parent = if index == 0 { Vector3::zeros() } else { Vector3::new(0.0, 0.0, -0.1) };
        let joint = Joint::new(
            &format!("joint{index}"),
            JointKind::Revolute,
            models::frame(on_parent, Vector3::y()),
            models::frame(Vector3::new(0.0, 0.0, 0.1), Vector3::y()),
        );
        let mass = if index == 2 { 10.0 } else { 0.01 };
        let inertia = models::box_inertia(mass, Vector3::new(0.04, 0.04, 0.2));
        bodies.push(models::body(&format!("link{index}"), (index > 0).then(|| index - 1), mass, inertia, joint));
    }
    let mechanism = Mechanism::new("taut_chain", models::gravity(), bodies).unwrap();
    let mut state = State::zero(&mechanism);
    state.position.copy_from_slice(&[0.4, 0.02, -0.03]);
    state.velocity[0] = 20.0;
    Model { mechanism, state }
}

/// A hinge with a rod of 1 m and 1 kg, and what acts in it.
fn rod_on_a_hinge(stiffness: f64, damping: f64) -> Model {
    let joint = Joint::new("hinge", JointKind::Revolute, Pose::identity(), Pose::translation(-0.5, 0.0, 0.0));
    let rod = models::body("rod", None, 1.0, Vector3::new(0.0, 1.0 / 12.0, 1.0 / 12.0), joint);
    let mut mechanism = Mechanism::new("rod", Vector3::zeros(), vec![rod]).unwrap();
    let coordinate = Coordinate { body: 0, position: 0, freedom: 0 };
    mechanism.forces.joint_springs.push(JointSpring { coordinate, stiffness, rest: 0.0 });
    mechanism.forces.joint_dampers.push(JointDamper { freedom: 0, coefficient: damping });
    let mut state = State::zero(&mechanism);
    state.position[0] = 0.3;
    Model { mechanism, state }
}
