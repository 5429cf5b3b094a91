//! Light bodies in couplings: a coupler and loop members of negligible mass, and a light leader of heavy followers.

use crate::mechanism::description::closure::{Coordinate, Mimic};
use crate::mechanism::description::joint::{Joint, JointKind};
use crate::mechanism::description::mechanism::{Body, Mechanism, MechanismError};
use crate::mechanism::motion::state::State;
use crate::stress::problem::{Case, Problem, steps};
use crate::stress::problems::{GRAVITY, four_bars, frame};
use nalgebra::Vector3;

/// Powers of ten.
const RATIOS: [i32; 7] = [0, 2, 4, 6, 8, 10, 12];

/// The problem.
pub fn problem() -> Problem {
    Problem {
        name: "light_couplings",
        title: "Light bodies in couplings",
        scene: "Two parallelograms in a row, of which the coupler of the first and two rods of the second are light; and two pendulums that mimic a \
                light knob.",
        axis: "mass of the others / mass of the light bodies",
        difficulties: vec!["1", "10²", "10⁴", "10⁶", "10⁸", "10¹⁰", "10¹²"],
        steps: steps(0.1, 2e-4, 9),
        build,
    }
}

fn build(place: usize) -> Result<Case, MechanismError> {
    let light = 10.0_f64.powi(-RATIOS[place]);
    let (bars, start) = four_bars(2)?;
    let mut bodies = bars.bodies.clone();
    for body in bodies.iter_mut().filter(|body| ["coupler0", "coupler1", "crank2"].contains(&body.name.as_str())) {
        body.mass *= light;
        body.inertia *= light;
    }
    let first = bodies.len();
    for (name, mass) in [("knob", light), ("left", 1.0), ("right", 2.0)] {
        let hinge = |z: f64| frame(Vector3::new(0.0, 1.0, z), Vector3::x());
        let on_child = frame(Vector3::new(0.0, 0.0, 0.3), Vector3::x());
        let joint = Joint::new(name, JointKind::Revolute, hinge(0.0), on_child);
        let inertia = Vector3::repeat(0.02 * mass);
        bodies.push(Body { name: name.to_string(), parent: None, mass, inertia, joint });
    }
    let mut mechanism = Mechanism::new("light_couplings", GRAVITY, bodies)?;
    mechanism.loops = bars.loops;
    let coordinate = |body: usize| {
        let joint = &mechanism.bodies[body].joint;
        Coordinate { body, position: joint.position_index, freedom: joint.velocity_index }
    };
    let mimics = [(1, 1.0), (2, -1.0)].map(|(follower, multiplier)| Mimic {
        name: mechanism.bodies[first + follower].name.clone(),
        follower: coordinate(first + follower),
        leader: coordinate(first),
        multiplier,
        offset: 0.0,
        more: Vec::new(),
        over_time: None,
    });
    mechanism.mimics = mimics.into();
    let mut state = State::zero(&mechanism);
    state.position[..start.position.len()].copy_from_slice(&start.position);
    state.velocity[..start.velocity.len()].copy_from_slice(&start.velocity);
    state.position[start.position.len()..].copy_from_slice(&[0.5, 0.5, -0.5]);
    // Shorter than the fall to the singular position, which is a problem of its own.
    Ok(Case::new(mechanism, state, 0.6))
}
