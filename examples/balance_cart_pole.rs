//! A cart that balances a pole: a controller that is asked a hundred times a second.
//!
//! `cargo run --release --example balance_cart_pole`

use catena::mechanism::description::closure::{Coordinate, JointLimit};
use catena::mechanism::description::joint::{Joint, JointKind, Pose};
use catena::mechanism::description::mechanism::{Body, Mechanism};
use catena::mechanism::description::nonsmooth::DryFriction;
use catena::mechanism::motion::event::EventKind;
use catena::mechanism::motion::state::State;
use catena::simulation::{Controller, Simulation, SimulationOptions, StepChoice};
use nalgebra::{Matrix3, Rotation3, Translation3, Vector3};

/// Feedback of position, speed, angle and rate that puts all four poles of the linearised motion at −2 per second.
struct Balance;

impl Controller for Balance {
    fn period(&self) -> f64 {
        0.01
    }

    fn efforts(&mut self, _: &Mechanism, state: &State, efforts: &mut [f64]) {
        let (place, angle) = (state.position[0], state.position[1]);
        let (speed, rate) = (state.velocity[0], state.velocity[1]);
        efforts[0] = 1.143 * place + 2.286 * speed + 29.33 * angle + 7.123 * rate;
    }
}

/// A cart of 1 kg on a rail along x between stops, with a pole of 0.2 kg whose centre of mass is 0.5 m above its hinge.
fn cart_pole() -> Result<Mechanism, Box<dyn std::error::Error>> {
    // z of a prismatic joint along x of the world, z of a hinge along its y.
    let along_x = Rotation3::from_matrix_unchecked(Matrix3::new(0.0, 0.0, 1.0, 0.0, 1.0, 0.0, -1.0, 0.0, 0.0));
    let along_y = Rotation3::from_matrix_unchecked(Matrix3::new(1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0));
    let rail = Pose::from_parts(Translation3::identity(), along_x);
    let at = |height: f64| Pose::from_parts(Translation3::new(0.0, 0.0, height), along_y);
    let cart = Body {
        name: "cart".into(),
        parent: None,
        mass: 1.0,
        inertia: Vector3::repeat(0.01),
        joint: Joint::new("rail", JointKind::Prismatic, rail, rail),
    };
    let pole = Body {
        name: "pole".into(),
        parent: Some(0),
        mass: 0.2,
        inertia: Vector3::new(0.2 / 12.0, 0.2 / 12.0, 1e-5),
        joint: Joint::new("hinge", JointKind::Revolute, at(0.0), at(-0.5)),
    };
    let mut mechanism = Mechanism::new("cart_pole", Vector3::new(0.0, 0.0, -9.81), vec![cart, pole])?;
    let coordinate = Coordinate { body: 0, position: 0, freedom: 0 };
    mechanism.nonsmooth.limits.push(JointLimit { coordinate, lower: -2.0, upper: 2.0, restitution: 0.5 });
    mechanism.nonsmooth.friction.push(DryFriction { coordinate, effort: 0.05 });
    Ok(mechanism)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mechanism = cart_pole()?;
    let mut start = State::zero(&mechanism);
    start.position[1] = 0.2;
    let options = SimulationOptions::new(10.0, StepChoice::Tolerance(1e-8));
    let mut simulation = Simulation::new(&mechanism, start, options)?;
    simulation.run_under(&mut Balance)?;
    let done = simulation.finish();
    let state = &done.state;
    println!("after 10 s: cart at {:.4} m, pole at {:.5} rad", state.position[0], state.position[1]);
    let events = &done.summary.events;
    println!("sticks: {}, slips: {}", events.of(EventKind::Stick), events.of(EventKind::Slip));
    if state.position[1].abs() > 0.05 {
        return Err("the pole has fallen".into());
    }
    Ok(())
}
