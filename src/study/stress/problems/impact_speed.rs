//! A leaning rod thrown onto a floor: the faster it is, the further it goes in a step.

use crate::mechanism::description::contact::Shape;
use crate::mechanism::description::mechanism::MechanismError;
use crate::mechanism::motion::state::State;
use crate::stress::problem::{Case, Problem, steps};
use crate::stress::problems::{GRAVITY, on_floor, put};
use nalgebra::Vector3;

/// Speeds downwards at the start (m/s).
const SPEEDS: [f64; 6] = [0.0, 1.0, 10.0, 100.0, 1e3, 1e4];
/// Radius and half the length of its core (m), and its lean (rad).
const ROD: (f64, f64, f64) = (0.02, 0.18, 0.5);

/// The problem.
pub fn problem() -> Problem {
    Problem {
        name: "impact_speed",
        title: "Fast impacts",
        scene: "A rod of 0.4 m and 1 kg with round ends is thrown straight down from a height of 1 m, leaning by half a radian: it hits a floor with one \
                end, then with the other, and slides to its stop (friction 0.3). The comparators know no contacts.",
        axis: "speed downwards [m/s]",
        difficulties: vec!["0", "1", "10", "10²", "10³", "10⁴"],
        steps: steps(0.1, 1e-3, 7),
        build,
    }
}

fn build(place: usize) -> Result<Case, MechanismError> {
    let (radius, half, lean) = ROD;
    // A thin rod with the length of the core.
    let across = half * half / 3.0 + 0.25 * radius * radius;
    let inertia = Vector3::new(across, across, 0.5 * radius * radius);
    let mechanism = on_floor(GRAVITY, &[(1.0, inertia, Shape::Capsule { radius, half })], 0.3)?;
    let mut start = State::zero(&mechanism);
    put(&mechanism, &mut start, 0, Vector3::z(), lean, Vector3::z() * -SPEEDS[place]);
    Ok(Case::new(mechanism, start, 1.0))
}
