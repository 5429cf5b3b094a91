//! The weights with which the displacements of a step make the momenta at its end, and the forces there.
//!
//! ```text
//!     p̄ = p₀ + h Σ_k b_k F_k = M ( v + h⁻¹ Σ_i w_i (Q_i − q₀ − h c_i v) ) + h b_s F_s,       w_i = Σ_k b_k B_ki
//! ```
//!
//! (2.5.11h); in all lanes in a plane, in one lane at the [end](crate::ending::velocities) of a step in space.

use crate::numbers::algebra::Vector;
use crate::numbers::arithmetic::{Arithmetic, Numbers};
use crate::numbers::lanes::MAX_LANES;
use crate::stages::coefficients::Coefficients;
use crate::stages::rows::Sweep;
use crate::tableau::butcher::Tableau;

/// The weights of a scheme.
#[derive(Clone)]
pub struct MomentumWeights<V> {
    /// `w_i`.
    weights: [V; MAX_LANES],
    /// Their rounding errors.
    rest: [V; MAX_LANES],
    /// `b_s`.
    last: V,
}

impl<V: Arithmetic> MomentumWeights<V> {
    /// The momentum weights of a tableau.
    pub fn new(tableau: &Tableau) -> Self {
        let (mut weights, mut rest) = ([V::zero(); MAX_LANES], [V::zero(); MAX_LANES]);
        let known = tableau.momentum_weights.iter().zip(&tableau.remainders.momentum_weights);
        for (stage, (&weight, &remainder)) in known.enumerate() {
            weights[stage] = V::splat(weight) + V::splat(remainder);
            rest[stage] = V::splat(remainder);
        }
        // b_s = 1/(s(s − 1))
        let last = V::splat((tableau.stages * (tableau.stages - 1)) as f64).reciprocal();
        MomentumWeights { weights, rest, last }
    }

    /// For a step of this length under gravity.
    #[inline(always)]
    pub fn over(&self, step: f64, gravity: &[f64; 3]) -> Momenta<V> {
        // Neither 1/h nor the product with it may be rounded.
        let whole = V::splat(step);
        let inverse = whole.reciprocal();
        let inverse_rest = -(inverse.lost(whole, V::splat(1.0)) * inverse);
        let (mut weights, mut rest) = (self.weights, self.rest);
        for (weight, rest) in weights.iter_mut().zip(&mut rest) {
            let rounded = *weight * inverse;
            let lost = weight.mul_add(inverse_rest, weight.lost(inverse, rounded));
            *rest = rest.mul_add(inverse, lost);
            *weight = rounded;
        }
        let impulse = whole * self.last;
        Momenta { weights, rest, impulse, gravity: Vector(gravity.map(V::splat)).times(impulse) }
    }
}

/// Coefficients that the momenta of all bodies at the end of a step share.
#[derive(Clone)]
pub struct Momenta<V> {
    /// `w_i / h` [1/s].
    pub weights: [V; MAX_LANES],
    /// Their rounding errors.
    pub rest: [V; MAX_LANES],
    /// The factor of forces: `h b_s` (s).
    pub impulse: V,
    /// The same times gravity [m/s].
    pub gravity: Vector<V>,
}

impl<V: Numbers> Momenta<V> {
    /// A sweep over all lanes.
    #[inline(always)]
    pub fn sweep(&self, coefficients: &Coefficients<V>, step: f64) -> Sweep<'_, V> {
        Sweep {
            columns: &self.weights,
            rest: &self.rest,
            steady: coefficients.steady(step),
            moved: V::splat(1.0),
            gravity: self.gravity,
            forces: self.impulse,
        }
    }
}
