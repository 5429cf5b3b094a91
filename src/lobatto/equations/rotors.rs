//! Rotors that are geared to joints: the inertia `A` of one along the coordinate q of its joint ("armature"), besides the inertia of the bodies.
//!
//! A rotor is one more coordinate y = q of the scheme, with the mass A and the kinetic energy `½ A q̇²`. In (2.5.11) it has the residual and the
//! momentum of a mass point on a line ([`crate::equations::residual`]):
//!
//! ```text
//!     row k:            A Σ_i B_ki (Δq_i − h c_i q̇₀)                    [kg m² rad or kg m]
//!     end of the step:  A ( q̇₀ + h⁻¹ Σ_i w_i (Δq_i − h c_i q̇₀) )         [kg m²/s or kg m/s]
//! ```
//!
//! The gear ties y to q, so that both enter the row of the joint, whose pivot `d = sᵀ A s` grows by A. So it costs no body and no equation, and A may
//! be as large as it likes. Source: R. Featherstone, Rigid Body Dynamics Algorithms, Springer 2008, section 9.6.

use crate::numbers::arithmetic::Numbers;
use crate::numbers::lanes::Lanes;
use crate::stages::force_motion::Motion;
use crate::stages::rotors::Rotors;
use crate::stages::rows::sums;

impl<V: Lanes> Rotors<V> {
    /// Takes the motion of the joints, in the rows or at the `end` of the step; with all digits of the coefficients.
    #[inline(always)]
    pub(crate) fn evaluate(&mut self, motion: &Motion<V>, end: bool) {
        let (coefficients, step) = (motion.coefficients, motion.step);
        let steady = coefficients.steady(step);
        // 1/h may not be rounded to the same side in every step.
        let inverse = 1.0 / step;
        let lost = V::splat(inverse.mul_add(-step, 1.0) * inverse);
        for &(freedom, inertia) in &self.rotors {
            let rate = V::splat(motion.rates[freedom]);
            let ahead = [steady.ahead::<true>(rate, motion.displacement[freedom])];
            let of_joint = if end {
                let [mixed] = sums(V::mix_all(ahead, &self.weights), V::mix_all(ahead, &self.rest));
                mixed.mul_add(V::splat(inverse), mixed.mul_add(lost, rate))
            } else {
                let [mixed] =
                    sums(V::mix_all(ahead, &coefficients.residual), V::mix_all(ahead, &coefficients.residual_rest));
                -mixed
            };
            self.carried[freedom] = of_joint * V::splat(inertia);
        }
    }
}
