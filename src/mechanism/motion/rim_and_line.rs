//! The nearest place of a circle to a line that it does not touch.
//!
//! The circle is about the unit axis k through the origin, with the radius ρ (m); the line is d + t f, and w its point nearest to the centre. The
//! point w + σ f is at the distance R(σ) from the axis:
//!
//! ```text
//!     R² = |q|² + 2 η₀ σ + β² σ²      q = w − (w·k) k,   η₀ = −(w·k)(f·k),   β² = 1 − (f·k)²
//!     F(σ) = σ − ρ (η₀ + β² σ)/R = 0                       the slope of half the squared distance from the circle (m)
//!     F'(σ) = 1 − ρ (β²/R − (η₀ + β² σ)²/R³)
//! ```
//!
//! F is convex where the line goes outwards, concave where it goes inwards. No root is further from zero than ρβ; the one of the least distance has
//! the sign of η₀, because that side is nearer to the centre. Newton's method starts at ±ρβ and comes down on it without passing it. Two more
//! iterations have exact first and second derivatives in time.
//!
//! A line that lies across the disc of the circle has two such places, one on either side. There the line is told to go outwards.
//!
//! Source: derived; for the convergence of Newton's method on a convex function, J. M. Ortega, W. C. Rheinboldt, Iterative Solution of Nonlinear
//! Equations (1970), section 13.3.

use crate::forces::point_spring::NO_LENGTH;
use crate::ground::smooth::{Smooth, Triple};

/// The iteration ends at a step below this part of ρ: the next step is below rounding.
const FOUND: f64 = 1e-9;
/// More than Newton's method has needed: 17 at most in 60 000 random places.
const ITERATIONS: usize = 24;
/// After the value is found: one iteration for the first derivative in time, one for the second.
const FOR_DERIVATIVES: usize = 2;

/// How a line is beside a circle about the origin.
#[derive(Clone, Copy, Debug)]
pub struct Beside<S> {
    /// The vector from the circle to the line (m).
    pub between: Triple<S>,
    /// The point of the line (m).
    pub foot: Triple<S>,
}

/// The nearest points of a circle of a radius (m) about an axis through the origin, and of the line through a point (m) along a unit vector; if
/// `outwards` is 1, where the line goes outwards, and if it is 0 wherever they are.
#[inline(always)]
pub fn nearest<S: Smooth>(
    radius: f64,
    outwards: f64,
    point: Triple<S>,
    axis: Triple<S>,
    along: Triple<S>,
) -> Beside<S> {
    let (rho, one) = (S::constant(radius), S::constant(1.0));
    let middle = point.minus(along.times(point.dot(along)));
    let (slope, height) = (along.dot(axis), middle.dot(axis));
    let level = along.minus(axis.times(slope));
    let square = level.dot(level);
    let off = middle.minus(axis.times(height));
    let base = off.dot(off);
    let turning = S::constant(0.0) - height * slope;
    let per_turning = (turning * turning + S::constant(NO_LENGTH)).square_root().reciprocal();
    let sign = S::constant(outwards) + S::constant(1.0 - outwards) * turning * per_turning;
    let mut along_by = (sign * rho * (square + S::constant(NO_LENGTH)).square_root()).held();
    let step = |at: S| {
        let outward = turning + square * at;
        let reciprocal = (base + (turning + outward) * at + S::constant(NO_LENGTH)).square_root().reciprocal();
        let sine = outward * reciprocal;
        let bend = one - rho * reciprocal * (square - sine * sine);
        (at - rho * sine) * bend.reciprocal()
    };
    for _ in 0..ITERATIONS {
        let by = step(along_by);
        along_by = along_by - by;
        if by.is_within(FOUND * radius) {
            break;
        }
    }
    for _ in 0..FOR_DERIVATIVES {
        along_by = along_by - step(along_by);
    }
    let foot = middle.plus(along.times(along_by));
    let out = foot.minus(axis.times(foot.dot(axis)));
    let out = out.times(rho * (out.dot(out) + S::constant(NO_LENGTH)).square_root().reciprocal());
    Beside { between: foot.minus(out), foot }
}
