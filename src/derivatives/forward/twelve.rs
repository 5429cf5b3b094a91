//! Coordinates of R¹² of a body: a place or a rate, the origin of its frame and the columns of its rotation matrix.
//!
//! ```text
//!     q = (x, R)        q̇ = (ẋ, Ṙ)
//! ```

use crate::derivatives::equations::figures::Frame;
use crate::derivatives::equations::placed::Placed;
use crate::derivatives::numbers::jet::Jet;
use crate::derivatives::numbers::number::Number;
use crate::derivatives::numbers::vector::{Matrix, Vector};

/// Place or rate of a body in R¹².
#[derive(Clone, Copy, Debug)]
pub(in crate::derivatives) struct Twelve<T> {
    pub origin: Vector<T>,
    pub axes: Matrix<T>,
}

/// The place of a body.
pub(super) fn place_of<T: Number>(placed: &Placed<Jet<T>>) -> Twelve<T> {
    of_frame(&placed.frame, |jet| jet.value)
}

/// The rate of a body.
pub(in crate::derivatives) fn rate_of<T: Number>(placed: &Placed<Jet<T>>) -> Twelve<T> {
    of_frame(&placed.frame, |jet| jet.rate)
}

fn of_frame<T: Number>(frame: &Frame<Jet<T>>, part: impl Fn(Jet<T>) -> T + Copy) -> Twelve<T> {
    Twelve { origin: frame.origin.map(part), axes: frame.axes.map(|column| column.map(part)) }
}

impl<T: Number> Twelve<T> {
    #[inline]
    pub(super) fn zero() -> Self {
        Twelve { origin: Vector::zero(), axes: Matrix([Vector::zero(); 3]) }
    }

    #[inline]
    pub(super) fn plus(&self, other: &Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.axes.0, other.axes.0);
        Twelve { origin: self.origin + other.origin, axes: Matrix([a + x, b + y, c + z]) }
    }

    #[inline]
    pub(in crate::derivatives) fn minus(&self, other: &Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.axes.0, other.axes.0);
        Twelve { origin: self.origin - other.origin, axes: Matrix([a - x, b - y, c - z]) }
    }

    #[inline]
    pub(super) fn scaled(&self, factor: T) -> Self {
        let [x, y, z] = self.axes.0;
        let axes = Matrix([x.scaled(factor), y.scaled(factor), z.scaled(factor)]);
        Twelve { origin: self.origin.scaled(factor), axes }
    }
}
