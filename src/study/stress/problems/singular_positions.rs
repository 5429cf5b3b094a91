//! Mechanisms that pass positions in which they could go another way.

use crate::mechanism::description::mechanism::MechanismError;
use crate::stress::problem::{Case, Problem, steps};
use crate::stress::problems::{bricard, four_bars};

/// Numbers of parallelograms; zero is Bricard's mechanism.
const COUNTS: [usize; 6] = [0, 1, 2, 5, 10, 20];

/// The problem.
pub fn problem() -> Problem {
    Problem {
        name: "singular_positions",
        title: "Through singular positions",
        scene: "N parallelograms of rods of 1 m fall through the position in which all rods lie in one line, where each of them could leave \
                the parallelogram; and Bricard's mechanism, one of whose equations is redundant everywhere.",
        axis: "parallelograms",
        difficulties: vec!["Bricard", "1", "2", "5", "10", "20"],
        steps: steps(0.1, 0.01, 200),
        build,
    }
}

fn build(place: usize) -> Result<Case, MechanismError> {
    let (mechanism, start) = match COUNTS[place] {
        0 => bricard()?,
        count => four_bars(count)?,
    };
    Ok(Case::new(mechanism, start, 2.0))
}
