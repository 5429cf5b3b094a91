//! The articulated inertia of a subtree in a plane, and how the axes of a joint are eliminated from it.
//!
//! About the anchor of a body, with acceleration `a`, angular acceleration `φ` and bias wrench `(f, τ)`,
//!
//! ```text
//!     force  = M a + c φ + f              [N]         M: 2 × 2, symmetric
//!     torque = c · a + I φ + τ            [N m]
//! ```
//!
//! which is [`crate::stages::articulated`] for motions in a plane: six numbers instead of 21. A hinge without forces in it does not resist turning:
//! `c`, `I` and `τ` are zero behind it, and `α = −τ/I − (c/I)·a − φ`.
//!
//! Because of these zeros, and because the product `×` is a number, the elimination is not the one of space over other vectors. The sweeps that use
//! it take the time that the table of [`crate::planar`] has.

use crate::numbers::lanes::Lanes;
use crate::planar::algebra::Vector2;
use crate::stages::articulated::Push;

/// An articulated inertia and bias wrench about the anchor of a body.
#[derive(Clone, Copy)]
pub(crate) struct Articulated2<V> {
    /// M: xx, xy, yy (kg).
    pub mass: [V; 3],
    /// c [kg m].
    pub coupling: Vector2<V>,
    /// I [kg m²].
    pub inertia: V,
    /// f.
    pub force: Vector2<V>,
    /// τ.
    pub torque: V,
}

/// Factors of the elimination of one degree of freedom for the way back: `α = bias − force_ratio · a − torque_ratio φ`.
#[derive(Clone, Copy)]
pub(crate) struct Eliminated2<V> {
    pub force_ratio: Vector2<V>,
    pub torque_ratio: V,
    pub bias: V,
    /// `1/d`.
    pub inverse: V,
}

impl<V: Lanes> Eliminated2<V> {
    /// Nothing.
    pub fn zero() -> Self {
        Eliminated2 { force_ratio: Vector2::zero(), torque_ratio: V::zero(), bias: V::zero(), inverse: V::zero() }
    }
}

impl<V: Lanes> Articulated2<V> {
    /// Nothing.
    #[inline(always)]
    pub fn zero() -> Self {
        Articulated2 {
            mass: [V::zero(); 3],
            coupling: Vector2::zero(),
            inertia: V::zero(),
            force: Vector2::zero(),
            torque: V::zero(),
        }
    }

    /// The sum of two about the same point.
    #[inline(always)]
    pub fn plus(&self, other: &Self) -> Self {
        let ([a, b, c], [d, e, f]) = (self.mass, other.mass);
        Articulated2 {
            mass: [a + d, b + e, c + f],
            coupling: self.coupling.plus(other.coupling),
            inertia: self.inertia + other.inertia,
            force: self.force.plus(other.force),
            torque: self.torque + other.torque,
        }
    }

    /// The solution for a rotation of a body on a joint to the world: the remaining inertia is not needed.
    #[inline(always)]
    pub fn solve_rotation(&self, push: Option<Push<V>>) -> Eliminated2<V> {
        let (inverse, bias) = self.turning(push);
        Eliminated2 { force_ratio: Vector2::zero(), torque_ratio: self.inertia * inverse, bias, inverse }
    }

    /// Eliminates the rotation about the anchor.
    #[inline(always)]
    pub fn eliminate_rotation(&mut self, push: Option<Push<V>>) -> Eliminated2<V> {
        let (inverse, bias) = self.turning(push);
        let force_ratio = self.coupling.times(inverse);
        self.minus_outer(self.coupling, force_ratio);
        self.force = self.coupling.times_plus(bias, self.force);
        let torque_ratio = match push {
            None => {
                (self.coupling, self.inertia, self.torque) = (Vector2::zero(), V::zero(), V::zero());
                V::splat(1.0)
            }
            Some(_) => {
                let ratio = self.inertia * inverse;
                self.coupling = self.coupling.times_minus(ratio, self.coupling);
                self.torque = self.inertia.mul_add(bias, self.torque);
                self.inertia = self.inertia.neg_mul_add(ratio, self.inertia);
                ratio
            }
        };
        Eliminated2 { force_ratio, torque_ratio, bias, inverse }
    }

    /// `1/d` and the bias of a rotation.
    #[inline(always)]
    fn turning(&self, push: Option<Push<V>>) -> (V, V) {
        match push {
            None => {
                let inverse = self.inertia.reciprocal();
                (inverse, -(self.torque * inverse))
            }
            Some(push) => {
                let inverse = (self.inertia + push.inertia).reciprocal();
                (inverse, (push.effort - self.torque) * inverse)
            }
        }
    }

    /// Eliminates a translation along `axis`.
    #[inline(always)]
    pub fn eliminate_translation(&mut self, axis: Vector2<V>, push: Option<Push<V>>) -> Eliminated2<V> {
        let [xx, xy, yy] = self.mass;
        let [x, y] = axis.0;
        let force = Vector2([xy.mul_add(y, xx * x), yy.mul_add(y, xy * x)]);
        let torque = self.coupling.dot(axis);
        let carried = axis.dot(self.force);
        let (inverse, bias) = match push {
            None => {
                let inverse = axis.dot(force).reciprocal();
                (inverse, -(carried * inverse))
            }
            Some(push) => {
                let inverse = (axis.dot(force) + push.inertia).reciprocal();
                (inverse, (push.effort - carried) * inverse)
            }
        };
        let (force_ratio, torque_ratio) = (force.times(inverse), torque * inverse);
        self.minus_outer(force, force_ratio);
        self.coupling = force.times_minus(torque_ratio, self.coupling);
        self.inertia = torque.neg_mul_add(torque_ratio, self.inertia);
        self.force = force.times_plus(bias, self.force);
        self.torque = torque.mul_add(bias, self.torque);
        Eliminated2 { force_ratio, torque_ratio, bias, inverse }
    }

    #[inline(always)]
    fn minus_outer(&mut self, a: Vector2<V>, scaled: Vector2<V>) {
        let ([x, y], [p, q]) = (a.0, scaled.0);
        let [xx, xy, yy] = self.mass;
        self.mass = [x.neg_mul_add(p, xx), x.neg_mul_add(q, xy), y.neg_mul_add(q, yy)];
    }

    /// The same about a point `arm` back: `a_here = a_there + φ J arm`.
    #[inline(always)]
    pub fn shifted(&self, arm: Vector2<V>) -> Self {
        let across = arm.quarter_turn();
        let [xx, xy, yy] = self.mass;
        let [x, y] = across.0;
        let coupling = Vector2([
            xy.mul_add(y, xx.mul_add(x, self.coupling.0[0])),
            yy.mul_add(y, xy.mul_add(x, self.coupling.0[1])),
        ]);
        Articulated2 {
            mass: self.mass,
            coupling,
            inertia: across.dot_plus(coupling, across.dot_plus(self.coupling, self.inertia)),
            force: self.force,
            torque: across.dot_plus(self.force, self.torque),
        }
    }
}
