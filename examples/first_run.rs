//! A first run: a robot from a file, a start, a log that viewers show, and a report.
//!
//! `cargo run --release --example first_run`

use catena::prelude::*;

fn main() -> Result<(), Error> {
    let model = Model::load("robots/double_pendulum.urdf")?;
    let log = std::env::temp_dir().join("catena_first_run.mcap");
    let mut simulation = Simulation::new(&model).tolerance(1e-8).duration(2.0).start([("shoulder", 1.5)])?.log(&log);
    for tenth in 1..=20 {
        simulation.step_to(0.1 * f64::from(tenth))?;
        let tip = simulation.pose("lower_arm")?.translation;
        println!("{:.1} s: x = {:+.4} m, z = {:+.4} m", simulation.time(), tip.x, tip.z);
    }
    let report = simulation.finish()?;
    println!("{report}");
    println!("{}", log.display());
    Ok(())
}
