//! `--check`: the same run with half the step, on another core.

use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::state::State;
use catena::simulation::{Simulation, SimulationOptions};

/// The end of a run with half the step; `None` if it ends early.
pub fn end_with_half_the_step(mechanism: &Mechanism, start: State, options: SimulationOptions) -> Option<State> {
    let options = SimulationOptions { steps: options.steps.with_half_the_step(), ..options };
    let mut simulation = Simulation::new(mechanism, start, options).ok()?;
    simulation.run().ok()?;
    Some(simulation.finish().state)
}
