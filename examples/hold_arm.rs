//! An arm that holds itself: motors at every joint of `robots/arm7.urdf`, with both gains in the equations of the steps.
//!
//! `cargo run --release --example hold_arm`

use catena::mechanism::description::closure::Coordinate;
use catena::mechanism::description::nonsmooth::{Motor, MotorLaw};
use catena::mechanism::description::target::Target;
use catena::mechanism::motion::state::State;
use catena::model::{Model, ModelOptions};
use catena::scene::{PackagePath, read_urdf};
use catena::simulation::{Simulation, SimulationOptions, StepChoice};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let robot = read_urdf("robots/arm7.urdf".as_ref(), &PackagePath::default())?;
    let mut model = Model::new(robot, &ModelOptions::default())?;
    let coordinates = model.mechanism.bodies.iter().enumerate().map(|(body, link)| Coordinate {
        body,
        position: link.joint.position_index,
        freedom: link.joint.velocity_index,
    });
    model.mechanism.nonsmooth.motors = coordinates
        .map(|coordinate| Motor {
            coordinate,
            law: MotorLaw::Position { kp: 1000.0, kd: 50.0 },
            target: Target::constant(0.3),
            max_effort: 200.0,
            period: 0.0,
            held: None,
        })
        .collect();
    let start = State::zero(&model.mechanism);
    let options = SimulationOptions::new(3.0, StepChoice::Tolerance(1e-6));
    let mut simulation = Simulation::new(&model.mechanism, start, options)?;
    simulation.run()?;
    let done = simulation.finish();
    for (body, status) in model.mechanism.bodies.iter().zip(&done.joints) {
        let position = done.state.position[body.joint.position_index];
        println!("{}: {position:.5} rad, held by {:.3} N m", body.joint.name, status.effort.unwrap_or_default());
    }
    println!("{} steps for 3 s, {:.3} J put in by the motors", done.summary.steps, done.summary.exchange.work);
    Ok(())
}
