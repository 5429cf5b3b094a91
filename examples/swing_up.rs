//! A cart that swings a pole up by its energy: a law that acts at every instant, with its derivatives.
//!
//! `cargo run --release --example swing_up`
//!
//! ```text
//!     u = −k (E − m g l) θ̇ cos θ − kx x − kv ẋ         E = ½ J θ̇² − m g l cos θ: energy of the pole about its hinge (J)
//! ```
//!
//! Source: K. J. Åström, K. Furuta, "Swinging up a pendulum by energy control", Automatica 36 (2000).

use catena::mechanism::description::joint::{Joint, JointKind, Pose};
use catena::mechanism::description::mechanism::{Body, Mechanism};
use catena::mechanism::motion::state::State;
use catena::simulation::{ContinuousController, Simulation, SimulationOptions, StepChoice};
use nalgebra::{DMatrix, Matrix3, Rotation3, Translation3, Vector3};

/// m g l (J) and J (kg m²) of the pole, 0.2 kg with its centre 0.5 m from the hinge.
const WEIGHT: f64 = 0.2 * 9.81 * 0.5;
const INERTIA: f64 = 0.2 * 0.25 + 0.2 / 12.0;
/// k, kx and kv.
const GAINS: [f64; 3] = [20.0, 0.2, 0.2];

/// The law.
struct SwingUp;

impl SwingUp {
    /// E − m g l (J).
    fn missing(state: &State) -> f64 {
        0.5 * INERTIA * state.velocity[1].powi(2) - WEIGHT * (state.position[1].cos() + 1.0)
    }
}

impl ContinuousController for SwingUp {
    fn freedoms(&self, _: &Mechanism) -> Vec<usize> {
        vec![0]
    }

    fn efforts(&self, _: &Mechanism, state: &State, efforts: &mut [f64]) {
        let [energy, place, speed] = GAINS;
        let swing = SwingUp::missing(state) * state.velocity[1] * state.position[1].cos();
        efforts[0] = -energy * swing - place * state.position[0] - speed * state.velocity[0];
    }

    fn derivatives(&self, _: &Mechanism, state: &State, positions: &mut DMatrix<f64>, velocities: &mut DMatrix<f64>) {
        let [energy, place, speed] = GAINS;
        let ((sin, cos), rate, missing) = (state.position[1].sin_cos(), state.velocity[1], SwingUp::missing(state));
        positions[(0, 0)] = -place;
        positions[(0, 1)] = -energy * rate * sin * (WEIGHT * cos - missing);
        velocities[(0, 0)] = -speed;
        velocities[(0, 1)] = -energy * cos * (INERTIA * rate * rate + missing);
    }
}

/// A cart of 1 kg on a rail along x, with the pole hanging from it.
fn cart_pole() -> Result<Mechanism, Box<dyn std::error::Error>> {
    // z of a prismatic joint along x of the world, z of a hinge along its y.
    let along_x = Rotation3::from_matrix_unchecked(Matrix3::new(0.0, 0.0, 1.0, 0.0, 1.0, 0.0, -1.0, 0.0, 0.0));
    let along_y = Rotation3::from_matrix_unchecked(Matrix3::new(1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0));
    let rail = Pose::from_parts(Translation3::identity(), along_x);
    let at = |height: f64| Pose::from_parts(Translation3::new(0.0, 0.0, height), along_y);
    let joint = Joint::new("rail", JointKind::Prismatic, rail, rail);
    let cart = Body { name: "cart".into(), parent: None, mass: 1.0, inertia: Vector3::repeat(0.01), joint };
    let joint = Joint::new("hinge", JointKind::Revolute, at(0.0), at(0.5));
    let inertia = Vector3::new(0.2 / 12.0, 0.2 / 12.0, 1e-5);
    let pole = Body { name: "pole".into(), parent: Some(0), mass: 0.2, inertia, joint };
    Ok(Mechanism::new("cart_pole", Vector3::new(0.0, 0.0, -9.81), vec![cart, pole])?)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mechanism = cart_pole()?;
    let mut start = State::zero(&mechanism);
    start.position[1] = 0.1;
    let options = SimulationOptions::new(20.0, StepChoice::Tolerance(1e-8));
    let mut simulation = Simulation::new(&mechanism, start, options)?;
    simulation.run_under_continuous(&SwingUp)?;
    let done = simulation.finish();
    let missing = -SwingUp::missing(&done.state) / (2.0 * WEIGHT);
    println!("after 20 s the pole lacks {:.2e} of the energy that takes it upright", missing);
    println!("{} steps, energy balanced to {:.1e}", done.summary.steps, done.summary.max_relative_energy_error);
    if missing.abs() > 0.05 { Err("the pole has not been swung up".into()) } else { Ok(()) }
}
