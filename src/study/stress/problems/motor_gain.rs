//! Motors with ever higher gains: the fast decay that they cause should not be visible.

use crate::mechanism::description::mechanism::{Mechanism, MechanismError};
use crate::mechanism::description::nonsmooth::{Motor, MotorLaw};
use crate::mechanism::description::target::Target;
use crate::mechanism::motion::state::State;
use crate::stress::problem::{Case, Problem, steps};
use crate::stress::problems::{GRAVITY, chain, only_coordinate};
use nalgebra::Vector3;

/// kd [N m s/rad].
const GAINS: [f64; 7] = [1.0, 10.0, 1e2, 1e3, 1e4, 1e6, 1e8];
/// kp / kd: the slow rate of decay [1/s].
const SLOW: f64 = 4.0;

/// The problem.
pub fn problem() -> Problem {
    Problem {
        name: "motor_gain",
        title: "High gains of motors",
        scene: "Position motors in both joints move an arm (two links of 0.5 m, 1 kg each) from level to hanging and bent, kp = 4 kd. At steps of h the \
                gain is hard where kd h / J > 1; J is about 0.3 kg m² in the shoulder, 0.02 in the elbow. The comparators evaluate the motors at \
                every stage.",
        axis: "gain kd [N m s/rad]",
        difficulties: vec!["1", "10", "10²", "10³", "10⁴", "10⁶", "10⁸"],
        steps: steps(0.1, 2e-4, 9),
        build,
    }
}

fn build(place: usize) -> Result<Case, MechanismError> {
    let bodies = chain(2, 0.5, 0.05, 1.0, Vector3::x(), [Vector3::y(), Vector3::y()]);
    let mut mechanism = Mechanism::new("motor_gain", GRAVITY, bodies)?;
    let kd = GAINS[place];
    for (body, target) in [(0, 1.2), (1, -0.8)] {
        mechanism.nonsmooth.motors.push(Motor {
            coordinate: only_coordinate(&mechanism, body),
            law: MotorLaw::Position { kp: SLOW * kd, kd },
            target: Target::constant(target),
            max_effort: f64::INFINITY,
            period: 0.0,
            held: None,
        });
    }
    let start = State::zero(&mechanism);
    Ok(Case::new(mechanism, start, 0.5))
}
