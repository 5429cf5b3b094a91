//! A pendulum between two limits: the faster it is, the more impacts there are.

use crate::mechanism::description::closure::JointLimit;
use crate::mechanism::description::mechanism::{Mechanism, MechanismError};
use crate::mechanism::motion::state::State;
use crate::stress::problem::{Case, Problem, steps};
use crate::stress::problems::{GRAVITY, chain, only_coordinate};
use nalgebra::Vector3;

/// Impacts a second, about.
const RATES: [f64; 5] = [3.0, 10.0, 100.0, 1e3, 1e4];
/// Rough work after which the runs are too slow (s): an impact takes a few steps.
const BUDGETS: [f64; 5] = [0.2, 0.2, 0.2, 0.4, 2.0];
/// Between the limits (rad).
const RANGE: f64 = 1.0;

/// The problem.
pub fn problem() -> Problem {
    Problem {
        name: "joint_limits",
        title: "Impacts on joint limits",
        scene: "A box of 1 m and 1 kg swings between two limits 1 rad apart, which give back all of its speed. Euler and RK4 have springs as \
                limits, so stiff that an impact takes four steps; DOP853 locates impacts as ours does, or has springs into which an impact goes as deep as the tolerance.",
        axis: "impacts a second",
        difficulties: vec!["3", "10", "10²", "10³", "10⁴"],
        steps: steps(0.1, 2e-4, 9),
        build,
    }
}

fn build(place: usize) -> Result<Case, MechanismError> {
    let bodies = chain(1, 1.0, 0.1, 1.0, -Vector3::z(), [Vector3::y(), Vector3::y()]);
    let mut mechanism = Mechanism::new("joint_limits", GRAVITY, bodies)?;
    let coordinate = only_coordinate(&mechanism, 0);
    let (lower, upper) = (-0.3 * RANGE, 0.7 * RANGE);
    mechanism.nonsmooth.limits.push(JointLimit { coordinate, lower, upper, restitution: 1.0 });
    let mut start = State::zero(&mechanism);
    start.velocity[0] = RATES[place] * RANGE;
    let mut case = Case::new(mechanism, start, 1.0);
    case.budget = BUDGETS[place];
    Ok(case)
}
