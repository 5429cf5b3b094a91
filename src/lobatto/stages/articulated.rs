//! The articulated inertia of a subtree, and how a joint's free axes are eliminated from it.
//!
//! In world axes about the anchor of a body, with acceleration `a`, angular acceleration `φ` and bias wrench `p`,
//!
//! ```text
//!     [ force  ]   [ mass       coupling ] [ a ]
//!     [ torque ] = [ couplingᵀ  inertia  ] [ φ ] + p,          A: the 6 × 6 matrix, symmetric
//!
//!     d = sᵀ A s + κ,   α₀ = (τ − sᵀ p) / d,   p ← p + A s α₀,   A ← A − A s sᵀ A / d        for every free axis s
//! ```
//!
//! with the effort τ of forces in the joint along the axis, and the damper's addition to the inertia, κ. The axes of a joint of several degrees of
//! freedom are eliminated one after the other, which is the exact block elimination. Source: R. Featherstone, Rigid Body Dynamics Algorithms (2008),
//! chapter 7; here lane by lane.

use crate::numbers::algebra::{Matrix, Symmetric, Vector};
use crate::numbers::arithmetic::Arithmetic;

/// An articulated inertia and bias wrench about the anchor of a body, in world axes:
/// `[force; torque] = [mass coupling; couplingᵀ inertia] [acceleration; angular acceleration] + [force; torque]`.
#[derive(Clone, Copy)]
pub struct Articulated<V> {
    /// Force by acceleration (kg).
    pub mass: Symmetric<V>,
    /// Force by angular acceleration [kg m].
    pub coupling: Matrix<V>,
    /// Torque by angular acceleration [kg m²].
    pub inertia: Symmetric<V>,
    /// Bias force.
    pub force: Vector<V>,
    /// Bias torque.
    pub torque: Vector<V>,
}

/// Effect of forces in a joint along an axis, in the units of the residuals and of the inertia.
#[derive(Clone, Copy)]
pub struct Push<V> {
    /// The effort τ.
    pub effort: V,
    /// Derivative of a damper's effort and the inertia of a rotor, κ, as an inertia.
    pub inertia: V,
}

impl<V: Arithmetic> Push<V> {
    /// With an effort and an inertia besides.
    #[inline(always)]
    pub fn plus(self, effort: V, inertia: V) -> Self {
        Push { effort: self.effort + effort, inertia: self.inertia + inertia }
    }
}

/// Factors of the elimination of one degree of freedom for the forward solve.
#[derive(Clone, Copy)]
pub struct Eliminated<V> {
    /// The axis in the world at each row's stage.
    pub axis: Vector<V>,
    /// `A s / d`, force part, with `d = sᵀ A s + κ`.
    pub force_ratio: Vector<V>,
    /// `A s / d`, torque part.
    pub torque_ratio: Vector<V>,
    /// `(τ − sᵀ p) / d`.
    pub bias: V,
    /// `1 / d`.
    pub inverse: V,
}

impl<V: Arithmetic> Eliminated<V> {
    /// Nothing.
    pub fn zero() -> Self {
        let (axis, zero) = (Vector::zero(), V::zero());
        Eliminated { axis, force_ratio: axis, torque_ratio: axis, bias: zero, inverse: zero }
    }
}

impl<V: Arithmetic> Articulated<V> {
    /// Nothing.
    #[inline(always)]
    pub fn zero() -> Self {
        Articulated {
            mass: Symmetric::zero(),
            coupling: Matrix::zero(),
            inertia: Symmetric::zero(),
            force: Vector::zero(),
            torque: Vector::zero(),
        }
    }

    /// A body that never turns: mass and force only.
    #[inline(always)]
    pub fn sliding(mass: V, force: Vector<V>) -> Self {
        let zero = V::zero();
        Articulated { mass: Symmetric([mass, zero, zero, mass, zero, mass]), force, ..Articulated::zero() }
    }

    /// The sum of two inertias and wrenches about the same point.
    #[inline(always)]
    pub fn plus(&self, other: &Self) -> Self {
        Articulated {
            mass: self.mass.plus(&other.mass),
            coupling: self.coupling.plus(&other.coupling),
            inertia: self.inertia.plus(&other.inertia),
            force: self.force.plus(other.force),
            torque: self.torque.plus(other.torque),
        }
    }

    /// The sum where only masses and forces count: of bodies that never turn.
    #[inline(always)]
    pub fn plus_mass(&self, other: &Self) -> Self {
        Articulated { mass: self.mass.plus(&other.mass), force: self.force.plus(other.force), ..*self }
    }

    /// Eliminates a translation along `axis` where only mass and force count.
    #[inline(always)]
    pub fn eliminate_slide(&mut self, axis: Vector<V>, push: Option<Push<V>>) -> Eliminated<V> {
        let force = self.mass.apply(axis);
        let inverse = resisting(axis.dot(force), push).reciprocal();
        let bias = unbalanced(axis.dot(self.force), push, inverse);
        let force_ratio = force.times(inverse);
        self.mass = self.mass.minus_outer(force, force_ratio);
        self.force = force.times_plus(bias, self.force);
        Eliminated { axis, force_ratio, torque_ratio: Vector::zero(), bias, inverse }
    }

    /// Eliminates a rotation about `axis` through the anchor, with the push of forces in the joint, if there are any.
    #[inline(always)]
    pub fn eliminate_rotation(&mut self, axis: Vector<V>, push: Option<Push<V>>) -> Eliminated<V> {
        let force = self.coupling.apply(axis);
        let torque = self.inertia.apply(axis);
        let inverse = resisting(axis.dot(torque), push).reciprocal();
        let bias = unbalanced(axis.dot(self.torque), push, inverse);
        self.eliminate(axis, force, torque, inverse, bias)
    }

    /// The solution for a rotation about `axis` of a body that hangs on the world, with inertia and bias torque about that axis besides
    /// these.
    #[inline(always)]
    pub fn solve_rotation(&self, axis: Vector<V>, inertia: V, torque: V, push: Option<Push<V>>) -> Eliminated<V> {
        let inverse = resisting(axis.dot_plus(self.inertia.apply(axis), inertia), push).reciprocal();
        let bias = unbalanced(axis.dot_plus(self.torque, torque), push, inverse);
        Eliminated { axis, force_ratio: Vector::zero(), torque_ratio: Vector::zero(), bias, inverse }
    }

    /// Eliminates a translation along `axis`.
    #[inline(always)]
    pub fn eliminate_translation(&mut self, axis: Vector<V>, push: Option<Push<V>>) -> Eliminated<V> {
        let force = self.mass.apply(axis);
        let torque = self.coupling.apply_transposed(axis);
        let inverse = resisting(axis.dot(force), push).reciprocal();
        let bias = unbalanced(axis.dot(self.force), push, inverse);
        self.eliminate(axis, force, torque, inverse, bias)
    }

    #[inline(always)]
    fn eliminate(
        &mut self,
        axis: Vector<V>,
        force: Vector<V>,
        torque: Vector<V>,
        inverse: V,
        bias: V,
    ) -> Eliminated<V> {
        let (force_ratio, torque_ratio) = (force.times(inverse), torque.times(inverse));
        self.mass = self.mass.minus_outer(force, force_ratio);
        self.coupling = self.coupling.minus_outer(force, torque_ratio);
        self.inertia = self.inertia.minus_outer(torque, torque_ratio);
        self.force = force.times_plus(bias, self.force);
        self.torque = torque.times_plus(bias, self.torque);
        Eliminated { axis, force_ratio, torque_ratio, bias, inverse }
    }

    /// Momentum at a velocity of the anchor and an angular velocity, and the moment of it about the anchor.
    #[inline(always)]
    pub fn momentum(&self, linear: Vector<V>, angular: Vector<V>) -> (Vector<V>, Vector<V>) {
        (
            self.mass.apply(linear).plus(self.coupling.apply(angular)),
            self.coupling.apply_transposed(linear).plus(self.inertia.apply(angular)),
        )
    }

    /// The same about a point `arm` back: `v_here = v_there + φ × arm`.
    #[inline(always)]
    pub fn shifted(&self, arm: Vector<V>) -> Self {
        // G = H − M r̂: row i of M r̂ is M_i × r.
        let [mxx, mxy, mxz, myy, myz, mzz] = self.mass.0;
        let [h0, h1, h2] = self.coupling.rows();
        let g0 = cross_from(Vector([mxx, mxy, mxz]), arm, h0);
        let g1 = cross_from(Vector([mxy, myy, myz]), arm, h1);
        let g2 = cross_from(Vector([mxz, myz, mzz]), arm, h2);
        // I' = I + r̂ G − Hᵀ r̂, and row i of Hᵀ r̂ is (column i of H) × r.
        let [rx, ry, rz] = arm.0;
        let [k0, k1, k2] = self.coupling.columns();
        let [ixx, ixy, ixz, iyy, iyz, izz] = self.inertia.0;
        let (g0, g1, g2) = (g0.0, g1.0, g2.0);
        // (r̂ G)_0 = ry g2 − rz g1, (r̂ G)_1 = rz g0 − rx g2, (r̂ G)_2 = rx g1 − ry g0.
        let difference = |a: V, p: V, b: V, q: V, start: V| b.neg_mul_add(q, a.mul_add(p, start));
        // (k × r)_0 = ky rz − kz ry, and so on; subtracted.
        let ([a0, b0, c0], [a1, b1, c1], [a2, b2, _]) = (k0.0, k1.0, k2.0);
        let inertia = Symmetric([
            difference(c0, ry, b0, rz, difference(ry, g2[0], rz, g1[0], ixx)),
            difference(a0, rz, c0, rx, difference(ry, g2[1], rz, g1[1], ixy)),
            difference(b0, rx, a0, ry, difference(ry, g2[2], rz, g1[2], ixz)),
            difference(a1, rz, c1, rx, difference(rz, g0[1], rx, g2[1], iyy)),
            difference(b1, rx, a1, ry, difference(rz, g0[2], rx, g2[2], iyz)),
            difference(b2, rx, a2, ry, difference(rx, g1[2], ry, g0[2], izz)),
        ]);
        Articulated {
            mass: self.mass,
            coupling: Matrix([g0, g1, g2]),
            inertia,
            force: self.force,
            torque: arm.cross_plus(self.force, self.torque),
        }
    }
}

/// `d`; a literal `None` at the call is free of cost.
#[inline(always)]
fn resisting<V: Arithmetic>(inertia: V, push: Option<Push<V>>) -> V {
    match push {
        None => inertia,
        Some(push) => inertia + push.inertia,
    }
}

/// `(τ − sᵀ p) / d`.
#[inline(always)]
fn unbalanced<V: Arithmetic>(carried: V, push: Option<Push<V>>, inverse: V) -> V {
    match push {
        None => -(carried * inverse),
        Some(push) => (push.effort - carried) * inverse,
    }
}

/// `start − a × b`.
#[inline(always)]
fn cross_from<V: Arithmetic>(a: Vector<V>, b: Vector<V>, start: Vector<V>) -> Vector<V> {
    let ([ax, ay, az], [bx, by, bz]) = (a.0, b.0);
    Vector([
        az.mul_add(by, ay.neg_mul_add(bz, start.0[0])),
        ax.mul_add(bz, az.neg_mul_add(bx, start.0[1])),
        ay.mul_add(bx, ax.neg_mul_add(by, start.0[2])),
    ])
}
