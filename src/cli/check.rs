//! `--check`: the same run with half the step, on another core, and how far its end is from that of the run.

use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::distance::{distance, probes};
use catena::mechanism::motion::state::State;
use catena::simulation::{Simulation, SimulationOptions};

/// Where a run with half the step ends; nothing if it ends early.
pub fn end_with_half_the_step(mechanism: &Mechanism, start: State, options: SimulationOptions) -> Option<State> {
    let options = SimulationOptions { steps: options.steps.with_half_the_step(), ..options };
    let mut simulation = Simulation::new(mechanism, start, options).ok()?;
    simulation.run().ok()?;
    Some(simulation.finish().state)
}

/// How far two ends are apart (m): any point of a body, with turns at a metre's distance.
pub fn apart(mechanism: &Mechanism, one: &State, other: &State) -> f64 {
    distance(&probes(mechanism, one), &probes(mechanism, other))
}
