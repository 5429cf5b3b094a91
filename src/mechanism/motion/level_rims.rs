//! The place at which two circles pass each other that lie nearly in one plane, as the rims of two cylinders that stand on each other.
//!
//! The circles are about the unit axes k and l, k·l > 0, with the radii ρ and τ (m); d (m) goes from the centre of the first to the centre of the
//! second. The view is along the middle of both axes. There each is an ellipse, and both are shortened by the same factor in the same direction:
//! stretched back, they are circles of ρ and τ again, which cross in closed form.
//!
//! ```text
//!     2 c = |k + l|,   z = (k + l)/2c,   δ = l − k
//!     e = d − (d·z) z + δ (d·δ)/(4 c (1 + c))            from centre to centre, stretched (m)
//!     w = α e + β z × e,   α = (e² + ρ² − τ²)/(2 e²),   β = √(ρ²/e² − α²)
//!     m = R_k w/ρ,   u = R_l (w − e)/τ,                  R_k v = v − (v·k)/(1 + c) (k + z): turns what is square to z to what is square to k
//!     q = d + τ u − ρ m  ∥  z                            from the first circle to the second (m)
//!     n = side (k × m) × (l × u)/|…|                     φ = n·q         p = τ u + d, from the centre of the first
//! ```
//!
//! φ is zero where the two touch, and has the gradient of the distance there. All of it is smooth where the planes are parallel; it is not where the
//! circles are tangent (β = 0). Which of the two places it is follows from the direction of z.
//!
//! Source: derived.

use crate::forces::point_spring::NO_LENGTH;
use crate::ground::smooth::{Smooth, Triple};

/// How two circles pass each other.
#[derive(Clone, Copy, Debug)]
pub struct LevelRims<S> {
    /// φ (m).
    pub gap: S,
    /// n, from the first to the second.
    pub normal: Triple<S>,
    /// p (m), from the centre of the first.
    pub point: Triple<S>,
}

/// The place of two circles of these radii (m), the second of which is `apart` (m) from the first, about these axes; n has the sign of `side`.
#[inline(always)]
pub fn level_rims<S: Smooth>(
    [rim, other]: [f64; 2],
    side: f64,
    apart: Triple<S>,
    [k, l]: [Triple<S>; 2],
) -> LevelRims<S> {
    let (one, half) = (S::constant(1.0), S::constant(0.5));
    let sum = k.plus(l);
    let double = (sum.dot(sum) + S::constant(NO_LENGTH)).square_root();
    let middle = sum.times(double.reciprocal());
    let cosine = double * half;
    let between = l.minus(k);
    let stretch = apart.dot(between) * (double * (one + cosine) * S::constant(2.0)).reciprocal();
    let level = apart.minus(middle.times(apart.dot(middle))).plus(between.times(stretch));
    let per_square = (level.dot(level) + S::constant(NO_LENGTH)).reciprocal();
    let along = half + S::constant(0.5 * (rim * rim - other * other)) * per_square;
    let across = (S::constant(rim * rim) * per_square - along * along).square_root();
    let arm = level.times(along).plus(middle.cross(level).times(across));
    let turned = |arm: Triple<S>, axis: Triple<S>, radius: f64| {
        let out = arm.times(S::constant(1.0 / radius));
        out.minus(axis.plus(middle).times(out.dot(axis) * (one + cosine).reciprocal()))
    };
    let (m, u) = (turned(arm, k, rim), turned(arm.minus(level), l, other));
    let normal = k.cross(m).cross(l.cross(u));
    let per_length = (normal.dot(normal) + S::constant(NO_LENGTH)).square_root().reciprocal();
    let normal = normal.times(per_length * S::constant(side));
    let point = apart.plus(u.times(S::constant(other)));
    LevelRims { gap: normal.dot(point.minus(m.times(S::constant(rim)))), normal, point }
}
