//! Motions of bodies and forces on them, about one point of the world.
//!
//! ```text
//!     motion (ω, ν)       a material point q moves by ω × q + ν
//!     forces (F, Z, T)    F = ∫ f       Z = ∫ q fᵀ       torque  N = ∫ q × f + T
//! ```
//!
//! The forces on a body are `f = (w + Ω u) dm` at its points `q = x + R u`, from a vector w and a matrix Ω:
//!
//! ```text
//!     F = m w + Ω p        Z = x Fᵀ + R (p wᵀ + P Ωᵀ)        m, p, P: inertial numbers ([`crate::derivatives::equations::figures`])
//! ```

use crate::derivatives::equations::figures::BodyFigures;
use crate::derivatives::forward::twelve::Twelve;
use crate::derivatives::numbers::vector::{Matrix, Vector};

/// The zero vector.
pub(super) const NOUGHT: Vector<f64> = Vector([0.0; 3]);

/// A motion, or a rate of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Twist {
    /// ω.
    pub turn: Vector<f64>,
    /// ν.
    pub shift: Vector<f64>,
}

/// Forces on points.
#[derive(Clone, Copy, Debug)]
pub(super) struct Forces {
    pub force: Vector<f64>,
    /// Z, by its columns.
    pub moments: Matrix<f64>,
    /// T.
    pub torque: Vector<f64>,
}

impl Twist {
    pub const NONE: Twist = Twist { turn: NOUGHT, shift: NOUGHT };

    #[inline]
    pub fn plus(&self, other: &Twist) -> Twist {
        Twist { turn: self.turn + other.turn, shift: self.shift + other.shift }
    }

    #[inline]
    pub fn scaled(&self, factor: f64) -> Twist {
        Twist { turn: self.turn.scaled(factor), shift: self.shift.scaled(factor) }
    }

    /// How another motion changes that is carried along.
    #[inline]
    pub fn carries(&self, other: &Twist) -> Twist {
        let shift = self.turn.cross(other.shift) + self.shift.cross(other.turn);
        Twist { turn: self.turn.cross(other.turn), shift }
    }

    /// How a place changes.
    #[inline]
    pub fn moves(&self, place: &Twelve<f64>) -> Twelve<f64> {
        let turned = self.turns(place);
        Twelve { origin: turned.origin + self.shift, axes: turned.axes }
    }

    /// How a rate changes.
    #[inline]
    pub fn turns(&self, rate: &Twelve<f64>) -> Twelve<f64> {
        let [x, y, z] = rate.axes.0;
        let turn = self.turn;
        Twelve { origin: turn.cross(rate.origin), axes: Matrix([turn.cross(x), turn.cross(y), turn.cross(z)]) }
    }

    /// The sum of the products of all entries.
    #[inline]
    pub fn dot(&self, other: &Twist) -> f64 {
        self.turn.dot(other.turn) + self.shift.dot(other.shift)
    }

    /// The power of a force and a torque.
    #[inline]
    pub fn power(&self, force: Vector<f64>, torque: Vector<f64>) -> f64 {
        self.shift.dot(force) + self.turn.dot(torque)
    }
}

impl Forces {
    /// The forces on a body at a place, from (w, Ω).
    #[inline]
    pub fn on(body: &BodyFigures<f64>, at: &Twelve<f64>, of: &Twelve<f64>) -> Forces {
        let force = of.origin.scaled(body.mass) + of.axes.apply(body.moment);
        let moments = shifted(at, &inner(body, of), force);
        Forces { force, moments, torque: NOUGHT }
    }

    #[inline]
    pub fn plus(&self, other: &Forces) -> Forces {
        Forces {
            force: self.force + other.force,
            moments: sum(&self.moments, &other.moments),
            torque: self.torque + other.torque,
        }
    }

    /// N.
    #[inline]
    pub fn about(&self) -> Vector<f64> {
        let [x, y, z] = self.moments.0;
        self.torque + Vector([z.0[1] - y.0[2], x.0[2] - z.0[0], y.0[0] - x.0[1]])
    }

    /// The change of N where the points move and the forces do not.
    #[inline]
    pub fn carried(&self, motion: &Twist) -> Vector<f64> {
        motion.shift.cross(self.force) + self.moments.apply(motion.turn) - motion.turn.scaled(trace(&self.moments))
    }
}

/// `p wᵀ + P Ωᵀ`, by its columns.
#[inline]
pub(super) fn inner(body: &BodyFigures<f64>, of: &Twelve<f64>) -> Matrix<f64> {
    let [x, y, z] = of.axes.0;
    let column = |row: usize| {
        body.moment.scaled(of.origin.0[row]) + body.second_moments.apply(Vector([x.0[row], y.0[row], z.0[row]]))
    };
    Matrix([column(0), column(1), column(2)])
}

/// `x Fᵀ + R (…)`, by its columns.
#[inline]
pub(super) fn shifted(at: &Twelve<f64>, inner: &Matrix<f64>, force: Vector<f64>) -> Matrix<f64> {
    let [x, y, z] = inner.0;
    let column = |row: usize, own: Vector<f64>| at.origin.scaled(force.0[row]) + at.axes.apply(own);
    Matrix([column(0, x), column(1, y), column(2, z)])
}

#[inline]
pub(super) fn sum(one: &Matrix<f64>, other: &Matrix<f64>) -> Matrix<f64> {
    let ([a, b, c], [x, y, z]) = (one.0, other.0);
    Matrix([a + x, b + y, c + z])
}

#[inline]
pub(super) fn trace(of: &Matrix<f64>) -> f64 {
    of.0[0].0[0] + of.0[1].0[1] + of.0[2].0[2]
}

/// `Mᵀ v`.
#[inline]
pub(super) fn transposed(of: &Matrix<f64>, vector: Vector<f64>) -> Vector<f64> {
    Vector([of.0[0].dot(vector), of.0[1].dot(vector), of.0[2].dot(vector)])
}
