//! The normal of the largest separation of a rim and another feature of shapes that overlap.
//!
//! If two shapes overlap deeper than a rim is curved, its nearest points to the other feature are no minimum of the distance. The normal is a maximum
//! of the separation, at any depth. The support points are p of a and q of b, for n and −n:
//!
//! ```text
//!     sep(n) = n · (q − p)         ∇ = q − p              p = c + ρ m,   m = (n − (n·k) k)/|…|     of a circle
//!     H = −Σ ρ (k × m)(k × m)ᵀ/|k × n| − sep 1            on the sphere, for both circles
//! ```
//!
//! Newton's method goes up on the sphere. Along a line f, sep is there for n · f = 0 alone, and n turns about f.
//!
//! Source: P.-A. Absil, R. Mahony, R. Sepulchre, Optimization Algorithms on Matrix Manifolds (2008), section 6.2 (Newton's method on the sphere).

use crate::features::feature::Part;
use crate::features::meet::Guess;
use crate::shapes::plane::across;
use nalgebra::{Matrix3, Vector3};

/// Newton's method has converged long before.
const ITERATIONS: usize = 30;
/// The longest step (rad).
const LONGEST: f64 = 0.3;

/// The support of a part along a normal (m), and how it bends; `None` for planes.
fn support(part: &Part, normal: &Vector3<f64>) -> Option<(Vector3<f64>, Matrix3<f64>)> {
    match part {
        Part::Point(at) => Some((*at, Matrix3::zeros())),
        Part::Line(ends, radius) => Some((ends[0] + normal * *radius, Matrix3::zeros())),
        Part::Circle(centre, axis, radius) => {
            let across = normal - axis * axis.dot(normal);
            let sine = across.norm();
            let out = across.try_normalize(0.0)?;
            let turn = axis.cross(&out);
            Some((centre + out * *radius, turn * turn.transpose() * (radius / sine)))
        }
        Part::Plane(..) | Part::Ellipsoid(_) | Part::Hollow(..) => None,
    }
}

/// The direction of a line.
fn along(part: &Part) -> Option<Vector3<f64>> {
    match part {
        Part::Line(ends, _) => (ends[1] - ends[0]).try_normalize(0.0),
        _ => None,
    }
}

/// Normal and points of a pair of features with a rim, from a guess of the normal; `None` for other pairs.
pub fn deepest(a: &Part, b: &Part, guess: &Guess) -> Option<(Vector3<f64>, [Vector3<f64>; 2])> {
    let is_rim = |part: &Part| matches!(part, Part::Circle(..));
    if !is_rim(a) && !is_rim(b) {
        return None;
    }
    let line = along(a).or(along(b));
    let level = |normal: Vector3<f64>| match line {
        Some(along) => (normal - along * along.dot(&normal)).try_normalize(1e-6),
        None => normal.try_normalize(0.0),
    };
    let mut normal = level(guess.normal)?;
    for _ in 0..ITERATIONS {
        let ((p, bends_a), (q, bends_b)) = (support(a, &normal)?, support(b, &-normal)?);
        let (gradient, bends) = (q - p, -(bends_a + bends_b));
        let separation = normal.dot(&gradient);
        // Upwards also where it bends up: by the size of the bend, not its sign.
        let turn = match line {
            Some(along) => {
                let turn = along.cross(&normal);
                let bend = turn.dot(&(bends * turn)) - separation;
                turn * (turn.dot(&gradient) / bend.abs().max(f64::MIN_POSITIVE))
            }
            None => {
                let (x, y) = across(&normal);
                let frame = nalgebra::Matrix3x2::from_columns(&[x, y]);
                let square = frame.transpose() * bends * frame - nalgebra::Matrix2::identity() * separation;
                let eigen = square.symmetric_eigen();
                let slopes = eigen.eigenvectors.tr_mul(&frame.tr_mul(&gradient));
                let scaled =
                    slopes.zip_map(&eigen.eigenvalues, |slope, bend| slope / bend.abs().max(f64::MIN_POSITIVE));
                frame * (eigen.eigenvectors * scaled)
            }
        };
        let step = turn * (LONGEST / turn.norm().max(LONGEST));
        normal = level(normal + step)?;
        if step.norm() <= 1e-16 {
            break;
        }
    }
    let ((p, _), (q, _)) = (support(a, &normal)?, support(b, &-normal)?);
    // On a line, the point that faces the other part.
    let facing = |line: &Part, at: Vector3<f64>, towards: &Vector3<f64>| {
        along(line).map_or(at, |along| at + along * along.dot(&(towards - at)))
    };
    let points = [facing(a, p, &q), facing(b, q, &p)];
    points.iter().flatten().all(|entry| entry.is_finite()).then_some((normal, points))
}
