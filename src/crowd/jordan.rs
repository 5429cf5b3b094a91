//! The second-order cone of dimension 3, `|v_T| ≤ v₀`: its product, the way to its border, and the scaling that makes two vectors equal.
//!
//! ```text
//!     v ∘ w = (v · w, v₀ w_T + w₀ v_T),     det v = v₀² − |v_T|²
//!     W z = W⁻¹ r,     W = η ((w₀, w_Tᵀ), (w_T, 1 + w_T w_Tᵀ/(1 + w₀)))        η = (det r/det z)^¼,   det w = 1
//! ```
//!
//! Source: F. Alizadeh, D. Goldfarb, Second-order cone programming, Mathematical Programming 95 (2003), section 4; Y. E. Nesterov, M. J. Todd,
//! Self-scaled barriers and interior-point methods for convex programming, Mathematics of Operations Research 22 (1997), for W.

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

/// W and W⁻¹ for two vectors inside the cone.
pub fn scaling(r: &Vector3<f64>, z: &Vector3<f64>) -> [Matrix3<f64>; 2] {
    let size = |v: &Vector3<f64>| {
        let across = v.y.hypot(v.z);
        ((v.x - across) * (v.x + across)).max(f64::MIN_POSITIVE).sqrt()
    };
    let sizes = [size(r), size(z)];
    let (r, z) = (r / sizes[0], z / sizes[1]);
    let middle = Vector3::new(r.x + z.x, r.y - z.y, r.z - z.z) / (2.0 * (1.0 + r.dot(&z))).sqrt();
    let of = |w: Vector3<f64>, factor: f64| {
        let bend = 1.0 / (1.0 + w.x);
        let (b, c, d) = (1.0 + bend * w.y * w.y, bend * w.y * w.z, 1.0 + bend * w.z * w.z);
        Matrix3::new(w.x, w.y, w.z, w.y, b, c, w.z, c, d) * factor
    };
    let factor = (sizes[0] / sizes[1]).sqrt();
    [of(middle, factor), of(Vector3::new(middle.x, -middle.y, -middle.z), 1.0 / factor)]
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

    #[test]
    fn the_scaling_makes_two_vectors_equal_and_has_its_inverse() {
        for (r, z) in [
            (Vector3::new(2.0, 1.0, -0.5), Vector3::new(3.0, -1.0, 2.0)),
            (Vector3::new(1.0, 0.0, 0.999), Vector3::new(1e-6, 0.0, -9e-7)),
            (Vector3::new(5.0, 3.0, 0.0), Vector3::new(5.0, 3.0, 0.0)),
        ] {
            let [scale, back] = scaling(&r, &z);
            // Roundings, times the condition of W: up to 1e3 in the second case.
            assert!((scale * z - back * r).amax() <= 1e-12 * (back * r).amax(), "{r} {z}");
            assert!((scale * back - Matrix3::identity()).amax() <= 1e-12, "{r} {z}");
        }
    }
}
