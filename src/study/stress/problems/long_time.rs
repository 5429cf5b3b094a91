//! A pendulum for a long time: whether energy and phase are kept.

use crate::mechanism::description::mechanism::{Mechanism, MechanismError};
use crate::mechanism::motion::state::State;
use crate::stress::problem::{Case, Problem, Truth, steps};
use crate::stress::problems::{GRAVITY, chain};
use nalgebra::Vector3;

const DURATIONS: [f64; 6] = [10.0, 100.0, 1e3, 1e4, 1e5, 1e6];
/// Rough work after which the runs are too slow (s): ten million steps of 0.1 s are some ten seconds.
const BUDGETS: [f64; 6] = [0.2, 0.2, 0.4, 2.0, 12.0, 120.0];

/// The problem.
pub fn problem() -> Problem {
    Problem {
        name: "long_time",
        title: "A long time",
        scene: "A box of 1 m and 1 kg swings from the level position, with a period of 1.93 s. The answer is the period, from elliptic \
                integrals.",
        axis: "simulated time [s]",
        difficulties: vec!["10", "10²", "10³", "10⁴", "10⁵", "10⁶"],
        steps: steps(0.3, 3e-3, 9),
        build,
    }
}

fn build(place: usize) -> Result<Case, MechanismError> {
    let mechanism =
        Mechanism::new("long_time", GRAVITY, chain(1, 1.0, 0.1, 1.0, Vector3::x(), [Vector3::y(), Vector3::y()]))?;
    let start = State::zero(&mechanism);
    let body = &mechanism.bodies[0];
    let arm = 0.5;
    // T = 2π √(I / m g a) / agm(1, cos(φ/2)) for the amplitude φ.
    let slow = ((body.inertia.y + body.mass * arm * arm) / (body.mass * 9.81 * arm)).sqrt();
    let period = std::f64::consts::TAU * slow / mean(1.0, std::f64::consts::FRAC_PI_4.cos());
    let mut case = Case::new(mechanism, start, DURATIONS[place]);
    case.truth = Truth::Periodic(period);
    case.budget = BUDGETS[place];
    Ok(case)
}

/// The arithmetic-geometric mean.
fn mean(mut a: f64, mut b: f64) -> f64 {
    // Each round doubles the number of right digits.
    for _ in 0..8 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_gives_the_lemniscate_constant() {
        // Gauss: agm(1, √2) = π / ϖ.
        assert!((mean(1.0, 2f64.sqrt()) - std::f64::consts::PI / 2.622_057_554_292_119).abs() < 1e-15);
    }
}
