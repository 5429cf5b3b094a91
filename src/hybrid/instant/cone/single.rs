//! One contact: Coulomb's law in closed form but for one root.
//!
//! ```text
//!     b_N ≥ 0:  r = 0.      r = −W⁻¹ b, if that is in the cone.      Else it slips, u_T = −s r_T with s > 0:
//!     r_T(s) = −(A + s)⁻¹ c,   A = W_TT − W_TN W_NT / W_NN,   c = b_T − W_TN b_N / W_NN,   r_N(s) = −(b_N + W_NT r_T) / W_NN
//!     |r_T(s)| = μ r_N(s)
//! ```
//!
//! W (3 × 3) is the mobility of the contact and b (3) its rate without force. A root exists whenever b_N < 0: with s → ∞ the friction vanishes.

use crate::instant::cone::problem::outside_cone;
use nalgebra::{Matrix3, Vector2, Vector3};

/// Most halvings of the interval of the root.
const HALVINGS: usize = 60;

/// The force of one contact.
pub(super) fn single_contact(mobility: &Matrix3<f64>, free: &Vector3<f64>, friction: f64) -> Vector3<f64> {
    let normal = mobility[(0, 0)];
    if free.x >= 0.0 || normal <= 0.0 {
        return Vector3::zeros();
    }
    let without_friction = -free.x / normal;
    if friction == 0.0 {
        return Vector3::new(without_friction, 0.0, 0.0);
    }
    let coupling = Vector2::new(mobility[(1, 0)], mobility[(2, 0)]) / normal;
    let slip = Vector2::new(free.y, free.z) - coupling * free.x;
    let (xx, yy) = (mobility[(1, 1)] - coupling.x * mobility[(0, 1)], mobility[(2, 2)] - coupling.y * mobility[(0, 2)]);
    let xy = mobility[(1, 2)] - coupling.x * mobility[(0, 2)];
    // Own directions of A: tan 2φ = 2 xy / (xx − yy).
    let (sine, cosine) = (0.5 * (2.0 * xy).atan2(xx - yy)).sin_cos();
    let axes = [Vector2::new(cosine, sine), Vector2::new(-sine, cosine)];
    let least = 1e-14 * mobility.trace();
    let own = axes.map(|axis| {
        let stretched = Vector2::new(xx * axis.x + xy * axis.y, xy * axis.x + yy * axis.y);
        axis.dot(&stretched).max(least)
    });
    let parts = axes.map(|axis| axis.dot(&slip));
    let force = |s: f64| {
        let tangential = axes[0] * (-parts[0] / (own[0] + s)) + axes[1] * (-parts[1] / (own[1] + s));
        Vector3::new(without_friction - coupling.dot(&tangential), tangential.x, tangential.y)
    };
    // The force is outside the cone if this is positive.
    let beyond = |force: &Vector3<f64>| outside_cone(friction, [force.x, force.y, force.z]);
    let sticks = force(0.0);
    let (mut low, mut at_low) = (0.0, beyond(&sticks));
    if at_low <= 0.0 {
        return sticks;
    }
    let mut high = mobility.trace();
    let mut at_high = beyond(&force(high));
    while at_high > 0.0 && high < f64::MAX / 4.0 {
        (low, at_low) = (high, at_high);
        high *= 4.0;
        at_high = beyond(&force(high));
    }
    // The secant of both ends, with the weight of an end that stays halved (the Illinois rule).
    for _ in 0..HALVINGS {
        let middle = (low * at_high - high * at_low) / (at_high - at_low);
        let found = force(middle);
        let at_middle = beyond(&found);
        if at_middle.abs() <= 1e-14 * found.amax() || !(low < middle && middle < high) {
            return found;
        }
        if at_middle > 0.0 {
            (low, at_low) = (middle, at_middle);
            at_high *= 0.5;
        } else {
            (high, at_high) = (middle, at_middle);
            at_low *= 0.5;
        }
    }
    force(high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instant::cone::laws::natural_map;
    use crate::instant::cone::problem::Law;
    use crate::instant::cone::scenes::Random;

    #[test]
    fn one_contact_fulfils_coulombs_law() {
        let mut random = Random::new(3);
        for round in 0..2000 {
            let factor = Matrix3::from_fn(|_, _| random.signed());
            let mobility = factor * factor.transpose();
            let free = Vector3::from_fn(|_, _| random.signed());
            let friction = random.between(0.05, 1.5);
            let force = single_contact(&mobility, &free, friction);
            let rate = mobility * force + free;
            let scaled = rate / mobility.trace();
            let off = natural_map(&Law::Contact { friction }, scaled.as_slice(), force.as_slice()).amax();
            // The forces are as large as 1/least eigenvalue, and the rates lose that many digits.
            let scale = 1.0 + force.amax();
            assert!(off <= 1e-12 * scale, "round {round}: off by {off:e} of {scale}");
        }
    }
}
