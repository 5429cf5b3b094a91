//! The lines of the README, with the features that it names.
//!
//! `cargo run --release --no-default-features --features log --example readme_lines`

use catena::prelude::*;

fn main() -> Result<(), Error> {
    let log = std::env::temp_dir().join("catena_readme.mcap");
    let model = Model::load("robots/double_pendulum.urdf")?;
    let mut simulation = Simulation::new(&model).tolerance(1e-6).start([("shoulder", 0.5)])?.log(&log);
    simulation.step_to(2.0)?; // also set_efforts, set_target(joint, r), set_controller(period, |now, efforts| ...), state(), run()
    let report = simulation.finish()?;
    println!("{report}");
    Ok(())
}
