//! Starts that do not satisfy the loops.

use crate::mechanism::description::joint::Pose;
use crate::mechanism::description::mechanism::MechanismError;
use crate::stress::problem::{Case, Problem, Truth, steps};
use crate::stress::problems::four_bars;

/// How far a crank is turned out of its place (rad); the last is a rod that is too short to close the loop at all.
const ANGLES: [f64; 7] = [1e-12, 1e-9, 1e-6, 1e-3, 0.03, 0.3, f64::INFINITY];

/// The problem.
pub fn problem() -> Problem {
    Problem {
        name: "inconsistent_start",
        title: "A start that does not close",
        scene: "A parallelogram of rods whose second crank stands askew, so that the loop is open at the start. The answer is the motion from the \
                nearest position that closes. In the last row no position does.",
        axis: "angle of the crank [rad]",
        difficulties: vec!["10⁻¹²", "10⁻⁹", "10⁻⁶", "10⁻³", "0.03", "0.3", "cannot close"],
        steps: steps(0.1, 2e-4, 9),
        build,
    }
}

fn build(place: usize) -> Result<Case, MechanismError> {
    let (mut mechanism, mut start) = four_bars(1)?;
    if ANGLES[place].is_finite() {
        start.position[2] += ANGLES[place];
        return Ok(Case::new(mechanism, start, 0.6));
    }
    // The foot of the second crank is moved further away than all rods together reach.
    mechanism.bodies[2].joint.on_parent = Pose::translation(5.0, 0.0, 0.0) * mechanism.bodies[2].joint.on_parent;
    let mut case = Case::new(mechanism, start, 0.6);
    case.truth = Truth::None("the loop cannot be closed");
    Ok(case)
}
