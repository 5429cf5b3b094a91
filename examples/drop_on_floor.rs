//! A robot is dropped on a floor that its file does not have, and its impacts are watched.
//!
//! `cargo run --release --example drop_on_floor`

use catena::mechanism::motion::event::Event;
use catena::prelude::*;
use catena::simulation::{ObserverError, Sample};

/// Prints every event as it happens.
struct Printer;

impl Observer for Printer {
    fn sample(&mut self, _: &Sample) -> Result<(), ObserverError> {
        Ok(())
    }

    fn event(&mut self, event: &Event) {
        println!("{:.4} s: {:?}", event.time, event.kind);
    }
}

fn main() -> Result<(), Error> {
    let loader = Model::loader().floating().base_pose([0.0, 0.0, 0.6, 0.1, 0.0, 0.0]).floor(0.0);
    let model = loader.load("robots/quadruped.urdf")?;
    let mut simulation = Simulation::new(&model).tolerance(1e-5).duration(0.5).observe(Printer);
    simulation.run()?;
    let report = simulation.finish()?;
    println!("{} contacts at the end, {:.2} J lost in impacts", report.contact.points.len(), report.energy.impacts);
    Ok(())
}
