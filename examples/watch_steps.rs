//! An observer of one's own: it sees every step, event and sample of a run.
//!
//! `cargo run --release --example watch_steps`

use catena::mechanism::motion::event::Event;
use catena::prelude::*;
use catena::simulation::{Observer, ObserverError, Sample, StepEnd};

/// Counts steps, and prints events and samples.
#[derive(Default)]
struct Watch {
    steps: usize,
    shortest: f64,
}

impl Observer for Watch {
    fn sample(&mut self, sample: &Sample) -> Result<(), ObserverError> {
        println!("{:.2} s: {:+.4} rad after {} steps", sample.time, sample.position[0], self.steps);
        Ok(())
    }

    fn step(&mut self, end: &StepEnd) {
        self.steps += 1;
        self.shortest = if self.steps == 1 { end.outcome.step } else { self.shortest.min(end.outcome.step) };
    }

    fn event(&mut self, event: &Event) {
        println!("{:.6} s: {:?}", event.time, event.kind);
    }
}

fn main() -> Result<(), Error> {
    let model = Model::load("robots/bouncing_pendulum.toml")?;
    let mut simulation = Simulation::new(&model).duration(1.0).rate(10.0).observe(Watch::default());
    simulation.run()?;
    println!("{}", simulation.finish()?);
    Ok(())
}
