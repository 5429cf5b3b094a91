//! The second-order cone of dimension 3, `|v_T| ≤ v₀`: its product and the way to its border.
//!
//! ```text
//!     v ∘ w = (v · w, v₀ w_T + w₀ v_T),     det v = v₀² − |v_T|²
//! ```
//!
//! Source: F. Alizadeh, D. Goldfarb, Second-order cone programming, Mathematical Programming 95 (2003), section 4.

use nalgebra::{Matrix3, Vector3};

/// The matrix of the product with a vector: `arrow(v) w = v ∘ w`.
pub fn arrow(v: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(v.x, v.y, v.z, v.y, v.x, 0.0, v.z, 0.0, v.x)
}

/// The largest α with `v + α d` in the cone |v_T| ≤ v₀; infinite without a bound.
pub fn to_border(v: &Vector3<f64>, d: &Vector3<f64>) -> f64 {
    // det(v + α d) = a α² + 2 b α + c.
    let pair = |one: &Vector3<f64>, other: &Vector3<f64>| one.x * other.x - one.y * other.y - one.z * other.z;
    let (a, b, c) = (pair(d, d), pair(v, d), pair(v, v).max(0.0));
    let discriminant = b * b - a * c;
    if a < 0.0 || (b < 0.0 && discriminant >= 0.0) {
        // The least positive root.
        c / (discriminant.max(0.0).sqrt() - b)
    } else {
        f64::INFINITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_border_is_reached_from_inside() {
        // (2, 1, 0) + α (−1, 1, 0): 2 − α = 1 + α.
        assert_eq!(to_border(&Vector3::new(2.0, 1.0, 0.0), &Vector3::new(-1.0, 1.0, 0.0)), 0.5);
        assert_eq!(to_border(&Vector3::new(2.0, 0.0, 1.0), &Vector3::new(1.0, 0.0, 0.5)), f64::INFINITY);
        assert_eq!(arrow(&Vector3::new(1.0, 2.0, 3.0)) * Vector3::x(), Vector3::new(1.0, 2.0, 3.0));
    }
}
