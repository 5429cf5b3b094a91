//! The lengths from which the tolerances of a pair of shapes are made.
//!
//! ```text
//!     ℓ = max(ℓ_a, ℓ_b),    δ(c) = c ℓ + 1e-14 R
//! ```
//!
//! ℓ_i (m) of a link is its reach from the centre of mass of its body. ℓ_i of an obstacle is the distance of its farthest point from its middle, of a
//! mesh the same distance for its largest triangle; half spaces have none. R (m) is the reach of obstacles from the origin of the world: distant
//! coordinates are rounded by more, although the shapes are no larger.

use crate::shapes::convex::Convex;
use nalgebra::Vector3;

/// Gaps to an obstacle are rounded by some tens of ulps of its coordinates, up to this part of R.
const ROUNDING: f64 = 1e-14;

/// The lengths of one shape (m); infinite for a half space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lengths {
    /// For an obstacle the distance of its farthest point from the origin of the world.
    pub place: f64,
    /// How far it extends.
    pub whole: f64,
    /// ℓ_i: for a mesh the extent of a triangle.
    pub part: f64,
}

impl Lengths {
    /// Lengths of a shape that moves with its body, with the distance of its farthest point from the centre of mass (m).
    pub(crate) fn of_moving(reach: f64) -> Self {
        Lengths { place: 0.0, whole: reach, part: reach }
    }

    /// Lengths of a convex obstacle.
    pub(crate) fn of_convex(convex: &Convex) -> Self {
        Lengths { place: convex.reach(), whole: convex.size, part: convex.size }
    }

    /// Lengths of a half space with this point on its plane (m).
    pub(crate) fn of_plane(point: &Vector3<f64>) -> Self {
        Lengths { place: point.norm(), whole: f64::INFINITY, part: f64::INFINITY }
    }
}

/// The lengths of a pair (m).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extents {
    /// ℓ.
    pub larger: f64,
    /// The smaller of ℓ_a and ℓ_b.
    pub smaller: f64,
    /// How far the shapes extend, meshes as a whole.
    pub whole: f64,
    /// R.
    pub farthest: f64,
}

impl Extents {
    /// Extents of two shapes.
    pub(crate) fn new([a, b]: [Lengths; 2]) -> Self {
        let finite = |lengths: [f64; 2]| lengths.into_iter().filter(|length| length.is_finite());
        let larger = finite([a.part, b.part]).fold(0.0, f64::max);
        Extents {
            larger,
            smaller: finite([a.part, b.part]).fold(larger, f64::min),
            whole: finite([a.whole, b.whole]).fold(0.0, f64::max),
            farthest: a.place.max(b.place),
        }
    }

    /// The tolerance that is this part of the larger (m).
    pub fn within(&self, part: f64) -> f64 {
        part * self.larger + ROUNDING * self.farthest
    }
}
