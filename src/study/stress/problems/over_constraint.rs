//! The same loop closed again and again: redundant equations.

use crate::mechanism::description::mechanism::MechanismError;
use crate::stress::problem::{Case, Problem, steps};
use crate::stress::problems::four_bars;

const COPIES: [usize; 5] = [1, 2, 4, 8, 16];

/// The problem.
pub fn problem() -> Problem {
    Problem {
        name: "over_constraint",
        title: "Redundant equations",
        scene: "One parallelogram of rods, whose loop is closed by the same hinge several times over. Two of the equations \
                say all there is to say.",
        axis: "equations of the loop",
        difficulties: vec!["5", "10", "20", "40", "80"],
        steps: steps(0.1, 2e-4, 9),
        build,
    }
}

fn build(place: usize) -> Result<Case, MechanismError> {
    let (mut mechanism, start) = four_bars(1)?;
    if let Some(closure) = mechanism.loops.pop() {
        for copy in 0..COPIES[place] {
            let mut again = closure.clone();
            again.name = format!("closure{copy}");
            mechanism.loops.push(again);
        }
    }
    // Shorter than the fall to the singular position, which is a problem of its own.
    Ok(Case::new(mechanism, start, 0.6))
}
