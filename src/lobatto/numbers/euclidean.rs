//! The operations that vectors in space and in a plane share, for equations that read the same in both.
//!
//! ```text
//!     space:  v = (x, y, z),   a × b a vector                        R³
//!     plane:  v = (x, y),      a × b = a_x b_y − a_y b_x a number    R²
//! ```
//!
//! A force (N) with its torque [N m], or a velocity [m/s] with its angular velocity [rad/s], fills the first 6 or 3 components of a screw.

use crate::numbers::algebra::Vector;
use crate::numbers::lanes::Lanes;

/// A vector in space or in a plane, one for each lane.
pub(crate) trait Euclidean<V: Lanes>: Copy {
    /// Its components where it is the same in all lanes.
    type Components: Copy + Default;
    /// Type of a product `×`: a torque or an angular velocity.
    type Axial: Copy;
    /// The zero vector.
    fn zero() -> Self;
    /// The same vector in every lane.
    fn splat(components: &Self::Components) -> Self;
    /// `self + other`.
    fn plus(self, other: Self) -> Self;
    /// `self − other`.
    fn minus(self, other: Self) -> Self;
    /// `self · factor`.
    fn times(self, factor: V) -> Self;
    /// `self · factor + start`.
    fn times_plus(self, factor: V, start: Self) -> Self;
    /// `self · other`.
    fn dot(self, other: Self) -> V;
    /// `start + self · other`.
    fn dot_plus(self, other: Self, start: V) -> V;
    /// `self × other`.
    fn cross(self, other: Self) -> Self::Axial;
    /// `self × other + start`.
    fn cross_plus(self, other: Self, start: Self::Axial) -> Self::Axial;
    /// Its lanes mixed by a matrix, by columns.
    fn mixed(self, columns: &[V]) -> Self;
    /// The screw of a vector and an axial one.
    fn joined(self, axial: Self::Axial) -> [V; 6];
}

/// The methods that a vector type has under the same names.
macro_rules! own_methods {
    ($vector:ident) => {
        #[inline(always)]
        fn zero() -> Self {
            $vector::zero()
        }
        #[inline(always)]
        fn splat(components: &Self::Components) -> Self {
            $vector::splat(components)
        }
        #[inline(always)]
        fn plus(self, other: Self) -> Self {
            $vector::plus(self, other)
        }
        #[inline(always)]
        fn minus(self, other: Self) -> Self {
            $vector::minus(self, other)
        }
        #[inline(always)]
        fn times(self, factor: V) -> Self {
            $vector::times(self, factor)
        }
        #[inline(always)]
        fn times_plus(self, factor: V, start: Self) -> Self {
            $vector::times_plus(self, factor, start)
        }
        #[inline(always)]
        fn dot(self, other: Self) -> V {
            $vector::dot(self, other)
        }
        #[inline(always)]
        fn dot_plus(self, other: Self, start: V) -> V {
            $vector::dot_plus(self, other, start)
        }
        #[inline(always)]
        fn cross_plus(self, other: Self, start: Self::Axial) -> Self::Axial {
            $vector::cross_plus(self, other, start)
        }
    };
}
pub(crate) use own_methods;

impl<V: Lanes> Euclidean<V> for Vector<V> {
    type Components = [f64; 3];
    type Axial = Self;
    own_methods!(Vector);

    #[inline(always)]
    fn cross(self, other: Self) -> Self {
        Vector::cross(self, other)
    }

    #[inline(always)]
    fn mixed(self, columns: &[V]) -> Self {
        let [x, y, z] = self.0;
        Vector([x.mix(columns), y.mix(columns), z.mix(columns)])
    }

    #[inline(always)]
    fn joined(self, axial: Self) -> [V; 6] {
        let ([a, b, c], [x, y, z]) = (self.0, axial.0);
        [a, b, c, x, y, z]
    }
}
