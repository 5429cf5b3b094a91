//! A box pushed across a slope near its angle of friction: sticking just below it, sliding just above it.

use crate::mechanism::description::contact::Shape;
use crate::mechanism::description::mechanism::MechanismError;
use crate::mechanism::motion::state::State;
use crate::stress::problem::{Case, Problem, steps};
use crate::stress::problems::{GRAVITY, box_inertia, on_floor, put};
use nalgebra::Vector3;

/// Slope over friction.
const RATIOS: [f64; 8] = [0.5, 0.9, 0.99, 0.999, 0.9999, 1.0001, 1.001, 1.01];
const FRICTION: f64 = 0.5;
/// Edge lengths (m).
const SIZE: Vector3<f64> = Vector3::new(0.4, 0.4, 0.1);

/// The problem.
pub fn problem() -> Problem {
    Problem {
        name: "friction_cone",
        title: "Friction near the slope",
        scene: "A box of 1 kg on four corners is pushed with 0.5 m/s across a slope (friction 0.5): its path turns downhill. On a gentle slope it stops and \
                stays; near the angle of friction it creeps; beyond, it slides away. The slope lies level and gravity leans. The comparators know no contacts.",
        axis: "slope over friction",
        difficulties: vec!["0.5", "0.9", "0.99", "0.999", "0.9999", "1.0001", "1.001", "1.01"],
        steps: steps(0.1, 1e-3, 7),
        build,
    }
}

fn build(place: usize) -> Result<Case, MechanismError> {
    let slope = (RATIOS[place] * FRICTION).atan();
    let gravity = Vector3::new(slope.sin(), 0.0, -slope.cos()) * -GRAVITY.z;
    let shape = Shape::Box { half: SIZE / 2.0 };
    let mechanism = on_floor(gravity, &[(1.0, box_inertia(1.0, SIZE), shape)], FRICTION)?;
    let mut start = State::zero(&mechanism);
    put(&mechanism, &mut start, 0, Vector3::z() * (0.5 * SIZE.z), 0.0, Vector3::y() * 0.5);
    Ok(Case::new(mechanism, start, 1.0))
}
