//! Scalars that forces depend on, at the stages and as they change: displacements of joints, and lengths of springs.
//!
//! ```text
//!     ẏ_j = ẏ₀ + h⁻¹ Σ_i (Ā B)_ji (y_i − y₀ − h c_i ẏ₀)        [m/s or rad/s],   why: [`crate::equations::forces`]
//!     ℓ_i − ℓ₀ = (2 d₀ + Δd_i)·Δd_i / (ℓ_i + ℓ₀)               (m), without cancellation
//! ```

use crate::numbers::lanes::{Lanes, MAX_LANES};
use crate::plan::forces::SpringLaw;
use crate::stages::coefficients::Coefficients;

/// The stage of each lane, and the weights that make velocities of displacements there.
#[derive(Clone, Copy)]
pub(crate) struct Place<V> {
    /// `Ā B` by columns.
    pub(crate) velocity: [V; MAX_LANES],
    /// One if a lane has the geometry of its stage, zero if it has the geometry of the start.
    pub(crate) moved: V,
    /// Weights b of the stages whose power this place has to account for.
    pub(crate) weights: V,
}

/// The scalar coordinates in a step, as far as forces see them.
pub(crate) struct Motion<'s, V> {
    pub(crate) displacement: &'s [V],
    pub(crate) rates: &'s [f64],
    /// Extensions of the joint springs at the start.
    pub(crate) extensions: &'s [f64],
    /// `h c_i` and `1/h`.
    pub(crate) times: V,
    pub(crate) inverse: V,
    /// Length of the step (s), and the coefficients of the scheme.
    pub(crate) step: f64,
    pub(crate) coefficients: &'s Coefficients<V>,
}

impl<V: Lanes> Motion<'_, V> {
    /// Rate of a scalar at the places, from its displacements at the stages.
    #[inline(always)]
    pub(crate) fn rate(&self, place: &Place<V>, displacement: V, start_rate: f64) -> V {
        let start_rate = V::splat(start_rate);
        start_rate.neg_mul_add(self.times, displacement).mix(&place.velocity).mul_add(self.inverse, start_rate)
    }
}

/// A spring with a damper on a line, at the places.
#[derive(Clone)]
pub(crate) struct Taut<V> {
    /// One over the length (1/m).
    pub(crate) per_length: V,
    /// `ℓ̇` [m/s].
    pub(crate) rate: V,
    /// The damper's part of the tension, and the whole (N).
    pub(crate) braking: V,
    pub(crate) tension: V,
}

impl SpringLaw {
    /// For `|d|²` at the stages, `(d + d₀)·(d − d₀)`, and length (m) and rate [m/s] at the start.
    #[inline(always)]
    pub(crate) fn stretched<V: Lanes>(
        &self,
        motion: &Motion<V>,
        place: &Place<V>,
        square: V,
        along: V,
        (start_length, start_rate): (f64, f64),
    ) -> Taut<V> {
        let length = square.square_root();
        let start = V::splat(start_length);
        let growth = along * (length + start).reciprocal();
        let rate = motion.rate(place, growth, start_rate);
        let per_length = (length - start).mul_add(place.moved, start).reciprocal();
        let extension = growth.mul_add(place.moved, V::splat(start_length - self.rest_length));
        let braking = rate * V::splat(self.damping);
        Taut { per_length, rate, braking, tension: extension.mul_add(V::splat(self.stiffness), braking) }
    }
}
