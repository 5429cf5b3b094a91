//! Closed loops and mimic relations: order, gaps, redundancy, singular positions, assembly.

mod algebra;
mod assembly;
mod kinds;
mod motion;
mod pinned;
mod singular;

use catena::mechanism::description::joint::Pose;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::description::rules::Rule;
use catena::mechanism::motion::energy::energy;
use catena::mechanism::motion::gaps::loop_gaps;
use catena::mechanism::motion::integrator::Integrator;
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use catena::stepping::integrator::Lobatto;
use nalgebra::{Rotation3, Translation3, Vector3};

/// Runs to a time with fixed steps; returns iterations a step and the largest gap of any loop at the end of any step.
fn run(mechanism: &Mechanism, state: &mut State, stages: usize, step: f64, until: f64) -> (f64, f64) {
    run_keeping(&[], mechanism, state, stages, step, until)
}

/// The same without some rules.
fn run_keeping(
    kept: &[Rule],
    mechanism: &Mechanism,
    state: &mut State,
    stages: usize,
    step: f64,
    until: f64,
) -> (f64, f64) {
    let mut lobatto = Lobatto::fixed(mechanism, stages, step).unwrap().keeping(mechanism, kept);
    let (mut iterations, mut steps, mut gap) = (0, 0, 0.0_f64);
    while state.time < until {
        let outcome = lobatto.advance(mechanism, state, until).unwrap();
        (iterations, steps) = (iterations + outcome.cost.iterations, steps + 1);
        let bodies = body_states(mechanism, state);
        for joint in &mechanism.loops {
            gap = gap.max(loop_gaps(joint, &bodies).largest().0);
        }
    }
    (iterations as f64 / steps as f64, gap)
}

fn total_energy(mechanism: &Mechanism, state: &State) -> f64 {
    energy(mechanism, &body_states(mechanism, state)).total()
}

fn frame(place: Vector3<f64>, turn: Vector3<f64>) -> Pose {
    Pose::from_parts(Translation3::from(place), Rotation3::new(turn))
}
