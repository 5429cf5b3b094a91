//! A heavy ball that drops on a light box: the harder the box is squeezed, the stiffer it is for those who have springs as contacts.

use crate::mechanism::description::contact::Shape;
use crate::mechanism::description::mechanism::MechanismError;
use crate::mechanism::motion::state::State;
use crate::stress::problem::{Case, Problem, steps};
use crate::stress::problems::{GRAVITY, box_inertia, on_floor, put};
use nalgebra::Vector3;

/// Mass of the ball over the mass of the box.
const RATIOS: [f64; 5] = [1.0, 1e2, 1e4, 1e6, 1e8];
/// Edge lengths of the box, and the radius of the ball (m).
const SIZE: Vector3<f64> = Vector3::new(2.0, 1.0, 0.2);
const RADIUS: f64 = 0.1;

/// The problem.
pub fn problem() -> Problem {
    Problem {
        name: "contact_masses",
        title: "A heavy ball on a light box",
        scene: "A ball, moving sideways at 1 m/s, drops 0.1 m onto a box of 1 kg, which it drags along the floor until it rolls (friction 0.5). The comparators know \
                no contacts.",
        axis: "mass of the ball over that of the box",
        difficulties: vec!["1", "10²", "10⁴", "10⁶", "10⁸"],
        steps: steps(0.1, 1e-3, 7),
        build,
    }
}

fn build(place: usize) -> Result<Case, MechanismError> {
    let mass = RATIOS[place];
    let ball = Vector3::repeat(0.4 * mass * RADIUS * RADIUS);
    let bodies = [
        (1.0, box_inertia(1.0, SIZE), Shape::Box { half: SIZE / 2.0 }),
        (mass, ball, Shape::Sphere { radius: RADIUS }),
    ];
    let mechanism = on_floor(GRAVITY, &bodies, 0.5)?;
    let mut start = State::zero(&mechanism);
    put(&mechanism, &mut start, 0, Vector3::z() * (0.5 * SIZE.z), 0.0, Vector3::zeros());
    put(&mechanism, &mut start, 1, Vector3::new(-0.5, 0.1, SIZE.z + RADIUS + 0.1), 0.0, Vector3::x());
    Ok(Case::new(mechanism, start, 1.0))
}
