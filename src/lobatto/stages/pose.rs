//! The pose of a body at all stages: its rotation and the displacement of its anchor since the start of the step.
//!
//! ```text
//!     q = (w, u)                                 unit quaternion of the rotation since the start, in world axes
//!     N = R R₀ᵀ − 1 = 2 (w û + u uᵀ − |u|² 1)    linear in the products 2 u uᵀ and the vector 2 w u
//! ```

use crate::numbers::algebra::{Matrix, Vector};
use crate::numbers::arithmetic::Arithmetic;
use crate::numbers::lanes::Lanes;
use crate::numbers::reductions::larger;
use crate::stages::start::Start;
/// The largest joint rotation within a step the kernel represents (rad).
pub const MAX_TURN: f64 = 3.1;

/// How far a joint has turned.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Turn {
    /// The largest angle at any stage (rad).
    pub angle: f64,
    /// Its first degree of freedom that turns.
    pub freedom: usize,
}

impl Turn {
    /// The larger of two, the first of equals.
    pub fn or(self, other: Turn) -> Turn {
        if other.angle > self.angle { other } else { self }
    }
}

/// Rotation and anchor displacement of a body at all stages, since the start of the step, in world axes.
#[derive(Clone, Copy)]
pub struct StagePose<V> {
    /// Real part of the quaternion.
    pub w: V,
    /// Vector part of the quaternion.
    pub u: Vector<V>,
    /// Displacement of the anchor (m).
    pub anchor: Vector<V>,
}

impl<V: Arithmetic> StagePose<V> {
    /// `N = R R₀ᵀ − 1 = 2 (w û + u uᵀ − |u|²)`, without cancellation.
    #[inline(always)]
    pub fn increment(&self) -> Matrix<V> {
        self.turned().matrix()
    }

    /// The vector in which N is linear.
    #[inline(always)]
    pub fn turned(&self) -> Turned<V> {
        let [x, y, z] = self.u.0;
        let (x2, y2, z2) = (x + x, y + y, z + z);
        let products = [x2 * x, x2 * y, x2 * z, y2 * y, y2 * z, z2 * z];
        Turned { products, vector: [self.w * x2, self.w * y2, self.w * z2] }
    }
}

/// A rotation by the quantities in which its matrix `N` is linear: the products `2 u uᵀ` (xx, xy, xz, yy, yz, zz) and `2 w u` of its quaternion.
#[derive(Clone, Copy)]
pub struct Turned<V> {
    /// `2 u uᵀ`.
    pub products: [V; 6],
    /// `2 w u`.
    pub vector: [V; 3],
}

impl<V: Arithmetic> Turned<V> {
    /// N of the vector and the products, one after the other.
    #[inline(always)]
    pub fn joined([x, y, z, products @ ..]: [V; 9]) -> Self {
        Turned { products, vector: [x, y, z] }
    }

    /// `N = 2 (w û + u uᵀ − |u|²)`.
    #[inline(always)]
    pub fn matrix(self) -> Matrix<V> {
        let Turned { products: [xx, xy, xz, yy, yz, zz], vector: [wx, wy, wz] } = self;
        Matrix([[-(yy + zz), xy - wz, xz + wy], [xy + wz, -(xx + zz), yz - wx], [xz - wy, yz + wx, -(xx + yy)]])
    }
}

/// The rotation vector of a ball joint since the start, in world axes, from the first of its degrees of freedom.
#[inline(always)]
pub fn rotation_vector<V: Arithmetic>(start: &Start<V::Real>, displacement: &[V], freedom: usize) -> Vector<V> {
    let axes = &start.axes[freedom..freedom + 3];
    let first = Vector::splat(&axes[0]).times(displacement[freedom]);
    let second = Vector::splat(&axes[1]).times_plus(displacement[freedom + 1], first);
    Vector::splat(&axes[2]).times_plus(displacement[freedom + 2], second)
}

/// The largest top Legendre coefficient of `sin φ` and `cos φ` of a body's rotation.
#[inline(always)]
pub(crate) fn largest_of_turn<V: Lanes>(pose: &StagePose<V>, top: V, start: f64) -> f64 {
    let weighted = pose.w * top;
    let twice = weighted + weighted;
    let [x, y, z] = pose.u.0;
    // w² − |u|² = 2w² − 1 for a unit quaternion, one at the start; the coefficient of a constant is zero.
    let cosine = (twice * pose.w).sum() + 2.0 * start;
    let (x, y, z) = ((twice * x).sum().abs(), (twice * y).sum().abs(), (twice * z).sum().abs());
    larger(larger(larger(cosine.abs(), x), y), z)
}
