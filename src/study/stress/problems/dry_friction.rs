//! Dry friction nearly as large as the load: sticking just below the limit, sliding just above it.

use crate::mechanism::description::mechanism::{Mechanism, MechanismError};
use crate::mechanism::description::nonsmooth::DryFriction;
use crate::mechanism::motion::state::State;
use crate::stress::problem::{Case, Problem, steps};
use crate::stress::problems::{GRAVITY, chain, only_coordinate};
use nalgebra::Vector3;

/// Friction over load at the start.
const RATIOS: [f64; 7] = [0.1, 0.5, 0.9, 0.99, 0.999, 1.001, 1.01];

/// The problem.
pub fn problem() -> Problem {
    Problem {
        name: "dry_friction",
        title: "Dry friction near the load",
        scene: "A double pendulum (0.5 m, 1 kg each), released level with dry friction in both joints: at first it slides in both, then one of them \
                sticks, and lets go again; with more friction than load it does not move at all. Euler and RK4 have τ tanh(v/v₀); DOP853 locates events as ours does, or has that, too.",
        axis: "friction over load",
        difficulties: vec!["0.1", "0.5", "0.9", "0.99", "0.999", "1.001", "1.01"],
        steps: steps(0.1, 2e-4, 9),
        build,
    }
}

fn build(place: usize) -> Result<Case, MechanismError> {
    let bodies = chain(2, 0.5, 0.05, 1.0, Vector3::x(), [Vector3::y(), Vector3::y()]);
    let mut mechanism = Mechanism::new("dry_friction", GRAVITY, bodies)?;
    // The loads of the joints at the start: weight times lever arms.
    let weight = -GRAVITY.z;
    for (body, load) in [(0, weight * (0.25 + 0.75)), (1, weight * 0.25)] {
        let coordinate = only_coordinate(&mechanism, body);
        mechanism.nonsmooth.friction.push(DryFriction { coordinate, effort: RATIOS[place] * load });
    }
    let start = State::zero(&mechanism);
    Ok(Case::new(mechanism, start, 2.0))
}
