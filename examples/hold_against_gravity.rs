//! A controller: an arm that carries its own weight and comes to rest, asked a thousand times a second.
//!
//! `cargo run --release --example hold_against_gravity`

use catena::nalgebra::DVector;
use catena::prelude::*;

fn main() -> Result<(), Error> {
    let model = Model::load("robots/arm7.urdf")?;
    let mut simulation = Simulation::new(&model)
        .duration(2.0)
        .start([("joint2", 0.8), ("joint4", -1.2)])?
        .velocities([("joint1", 1.0)])?;
    let arm = model.clone();
    simulation.set_fallible_controller(0.001, move |now, efforts| {
        let weight = arm.gravity_efforts(&now.q)?;
        // Every joint slows down to a half in 0.17 s, whatever its inertia.
        let brake = arm.mass_matrix(&now.q)? * DVector::from_column_slice(&now.v) * 4.0;
        efforts.copy_from_slice((weight - brake).as_slice());
        Ok(())
    })?;
    simulation.run()?;
    for joint in model.joint_names() {
        println!("{joint}: {:+.5} rad, {:+.1e} rad/s", simulation.position(joint)?[0], simulation.velocity(joint)?[0]);
    }
    let report = simulation.finish()?;
    println!(
        "{:.3} J put in by the controller, energy balanced to {:.1e}",
        report.energy.work, report.energy.max_relative_error
    );
    Ok(())
}
