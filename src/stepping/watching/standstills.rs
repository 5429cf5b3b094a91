//! Where quadratic drag is not smooth: an instant at which the speed that it feels passes through zero, or nearly so.
//!
//! ```text
//!     f = −c |v| v,    v(t) ≈ a (t − t*) + δ_v,  δ_v ⊥ a        |v| = |a| √((t − t*)² + δ²),   δ = |δ_v|/|a| (s)
//! ```
//!
//! The force has branch points at `t* ± i δ`. Polynomials through the stages do not see them if δ is small beside a step, and neither does the top
//! Legendre coefficient, whose square is the error of smooth steps alone. So
//!
//! ```text
//!     δ ≤ 10⁻⁴ h:    t* ends the step: the force is a polynomial on each side, but for c |a|² δ³
//!     otherwise      h ≤ 2 min_t √((t − t*)² + δ²)  over the step: its error is the square of E again
//! ```
//!
//! v is the velocity of the point of a drag [m/s], or the angular velocity of its body [rad/s]. It is looked at at 9 points of the dense output, and t*
//! is refined there. Drag that moves its body by less than a thousand stops of the iteration in the step is left out. Source of the rate of convergence:
//! L. N. Trefethen, Approximation Theory and Approximation Practice, SIAM 2013, chapter 8 (ellipses free of singularities).

use catena_mechanism::description::body_state::{BodyState, WORLD};
use catena_mechanism::description::forces::Drag;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::motion::kinematics::forward_kinematics;
use catena_mechanism::motion::state::State;
use nalgebra::Vector3;

/// Pieces of a step, at whose ends velocities are looked at.
const PIECES: usize = 8;
/// Below this part of the step, δ is zero.
const KINK: f64 = 1e-4;
/// The longest step over its distance from the branch points.
const FROM_BRANCH: f64 = 2.0;
/// A step that is too long by less than this part is kept.
const SLACK: f64 = 0.05;
/// The part of the displacement by a drag that a kink may change at most.
const OF_DISPLACEMENT: f64 = 1e-3;
/// Corrections of t*.
const REFINED: usize = 2;

/// Room for the velocities that drags feel inside a step.
#[derive(Clone, Default)]
pub(crate) struct Standstills {
    position: Vec<f64>,
    velocity: Vec<f64>,
    bodies: Vec<BodyState>,
    /// For each drag, linear and angular, the velocities at the ends of the pieces.
    felt: Vec<[Vector3<f64>; PIECES + 1]>,
}

/// Whether a drag has a quadratic part.
fn is_quadratic(drag: &Drag) -> bool {
    drag.quadratic != 0.0 || drag.angular_quadratic != 0.0
}

/// The velocity of the point of a drag, or the angular velocity of its body.
fn felt_by(drag: &Drag, angular: bool, bodies: &[BodyState]) -> Vector3<f64> {
    let body = &bodies[drag.body];
    if angular {
        return body.angular_velocity;
    }
    body.velocity + body.angular_velocity.cross(&(body.rotation * drag.point))
}

/// Displacement per effort and squared second: of the point by a force [1/kg], or of the body by a torque [1/(kg m²)].
fn mobility(mechanism: &Mechanism, drag: &Drag, angular: bool) -> f64 {
    let body = &mechanism.bodies[drag.body];
    let inertia = body.inertia.min();
    if angular { 1.0 / inertia } else { 1.0 / body.mass + drag.point.norm_squared() / inertia }
}

/// The longest step from zero, no longer than `length`, beside a standstill after `instant` with this δ (s).
fn longest(instant: f64, delta: f64, length: f64) -> f64 {
    if delta <= KINK * length {
        let inside = instant > KINK * length && instant < (1.0 - KINK) * length;
        return if inside { instant } else { length };
    }
    let allowed = if instant <= 0.0 {
        FROM_BRANCH * instant.hypot(delta)
    } else if FROM_BRANCH * delta >= instant {
        FROM_BRANCH * delta
    } else {
        // h = 2 √((t* − h)² + δ²), the smaller root.
        (4.0 * instant - (4.0 * instant * instant - 12.0 * delta * delta).sqrt()) / 3.0
    };
    if allowed < (1.0 - SLACK) * length { allowed } else { length }
}

/// The instant from the first of two at which a velocity that changes evenly is least, in units of their distance, and the change.
fn nearest(first: &Vector3<f64>, second: &Vector3<f64>) -> Option<(f64, Vector3<f64>)> {
    let change = second - first;
    let square = change.norm_squared();
    (square > 0.0).then(|| (-first.dot(&change) / square, change))
}

impl Standstills {
    /// The longest step from `start` beside all standstills, if the solved one of `length` seconds to `end` is too long; `sample` is its dense output
    /// at a part of it, and the iteration stops at increments of `stop` (rad, m).
    pub fn shorter(
        &mut self,
        mechanism: &Mechanism,
        [start, end]: [&State; 2],
        length: f64,
        stop: f64,
        mut sample: impl FnMut(f64, &mut [f64], &mut [f64]),
    ) -> Option<f64> {
        let drags = &mechanism.forces.drags;
        if !drags.iter().any(is_quadratic) {
            return None;
        }
        let Standstills { position, velocity, bodies, felt } = self;
        position.resize(start.position.len(), 0.0);
        velocity.resize(start.velocity.len(), 0.0);
        bodies.resize(mechanism.bodies.len(), WORLD);
        felt.resize(2 * drags.len(), [Vector3::zeros(); PIECES + 1]);
        for point in 0..=PIECES {
            match point {
                0 => forward_kinematics(mechanism, &start.position, &start.velocity, bodies),
                PIECES => forward_kinematics(mechanism, &end.position, &end.velocity, bodies),
                _ => {
                    sample(point as f64 / PIECES as f64, position, velocity);
                    forward_kinematics(mechanism, position, velocity, bodies);
                }
            }
            for (index, drag) in drags.iter().enumerate() {
                for angular in [false, true] {
                    felt[2 * index + usize::from(angular)][point] = felt_by(drag, angular, bodies);
                }
            }
        }
        let mut allowed = length;
        for (index, drag) in drags.iter().enumerate() {
            for (angular, coefficient) in [(false, drag.quadratic), (true, drag.angular_quadratic)] {
                let speeds = felt[2 * index + usize::from(angular)];
                let largest = speeds.iter().map(Vector3::norm).fold(0.0, f64::max);
                let moved = coefficient * (largest * length).powi(2) * mobility(mechanism, drag, angular);
                if coefficient == 0.0 || OF_DISPLACEMENT * moved < stop {
                    continue;
                }
                let mut speed_at = |part: f64| {
                    sample(part, position, velocity);
                    forward_kinematics(mechanism, position, velocity, bodies);
                    felt_by(drag, angular, bodies)
                };
                for piece in 0..PIECES {
                    let Some((instant, delta)) = standstill(&speeds, piece, &mut speed_at) else { continue };
                    allowed = allowed.min(longest(instant * length, delta * length, length));
                }
            }
        }
        (allowed < length).then_some(allowed)
    }
}

/// The standstill of a piece of a step of length one, with its δ: inside the piece, or before the first one or after the last.
fn standstill(
    speeds: &[Vector3<f64>; PIECES + 1],
    piece: usize,
    speed_at: &mut impl FnMut(f64) -> Vector3<f64>,
) -> Option<(f64, f64)> {
    let (first, second) = (&speeds[piece], &speeds[piece + 1]);
    let (along, mut change) = nearest(first, second)?;
    let (mut since, mut width) = (piece as f64 / PIECES as f64, 1.0 / PIECES as f64);
    let mut instant = since + along * width;
    let (before, after) = (along < 0.0, along > 1.0);
    if before || after {
        // A standstill outside the step is where the velocity at its end would lead.
        let outside = before && piece == 0 || after && piece + 1 == PIECES;
        return outside.then(|| (instant, (first + change * along).norm() / change.norm() * width));
    }
    let mut speed = *first;
    for _ in 0..REFINED {
        let there = speed_at(instant);
        if instant != since {
            (change, width) = (there - speed, instant - since);
        }
        (since, speed) = (instant, there);
        let square = change.norm_squared();
        if square == 0.0 {
            break;
        }
        instant -= width * there.dot(&change) / square;
    }
    let slope = change.norm() / width.abs();
    let across = speed + change * ((instant - since) / width);
    Some((instant, across.norm() / slope))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_ends_at_a_standstill_and_shrinks_towards_a_near_one_and_grows_behind() {
        assert_eq!(longest(0.3, 0.0, 1.0), 0.3);
        assert_eq!(longest(1.2, 0.0, 1.0), 1.0);
        assert_eq!(longest(1e-5, 0.0, 1.0), 1.0);
        // Towards δ = 0.01 after 0.6 s: two thirds of the way, since h = 2 (t* − h).
        let towards = longest(0.6, 0.01, 1.0);
        assert!((towards - 2.0 * (0.6_f64 - towards).hypot(0.01)).abs() < 1e-15 && (towards - 0.4).abs() < 1e-3);
        assert_eq!(longest(0.0, 0.01, 1.0), 0.02);
        assert_eq!(longest(-0.3, 0.4, 1.0), 1.0);
    }

    #[test]
    fn the_standstill_of_a_velocity_that_curves_is_found_to_a_part_of_the_step_that_counts_as_none() {
        // v = (t − 0.37) (1 + t) along x, and 0.02 along y: δ = 0.02/1.37.
        let speed = |part: f64| Vector3::new((part - 0.37) * (1.0 + part), 0.02, 0.0);
        let speeds = std::array::from_fn(|point| speed(point as f64 / PIECES as f64));
        let found: Vec<_> = (0..PIECES).filter_map(|piece| standstill(&speeds, piece, &mut { speed })).collect();
        let inside: Vec<_> = found.iter().filter(|(instant, _)| (0.0..1.0).contains(instant)).collect();
        let [&(instant, delta)] = inside[..] else { panic!("{found:?}") };
        // The slope is a secant of the last correction, less than a hundredth of the step long.
        assert!((instant - 0.37).abs() < KINK && (delta - 0.02 / 1.37).abs() < 1e-3, "{instant} {delta}");
    }
}
