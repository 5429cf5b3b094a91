//! Three-vectors and 3×3 matrices whose entries are lanes: one number for each stage.

use crate::numbers::arithmetic::Arithmetic;

/// A vector in space, one for each lane.
#[derive(Clone, Copy)]
pub struct Vector<V>(pub [V; 3]);

/// A symmetric 3×3 matrix: xx, xy, xz, yy, yz, zz.
#[derive(Clone, Copy)]
pub struct Symmetric<V>(pub [V; 6]);

/// A 3×3 matrix by rows.
#[derive(Clone, Copy)]
pub struct Matrix<V>(pub [[V; 3]; 3]);

impl<V: Arithmetic> Vector<V> {
    /// The zero vector.
    #[inline(always)]
    pub fn zero() -> Self {
        Vector([V::zero(); 3])
    }
    /// The same vector in every lane.
    #[inline(always)]
    pub fn splat(v: &[V::Real; 3]) -> Self {
        Vector([V::whole(v[0]), V::whole(v[1]), V::whole(v[2])])
    }
    /// `self + other`.
    #[inline(always)]
    pub fn plus(self, other: Self) -> Self {
        Vector([self.0[0] + other.0[0], self.0[1] + other.0[1], self.0[2] + other.0[2]])
    }
    /// `self − other`.
    #[inline(always)]
    pub fn minus(self, other: Self) -> Self {
        Vector([self.0[0] - other.0[0], self.0[1] - other.0[1], self.0[2] - other.0[2]])
    }
    /// `self · factor`.
    #[inline(always)]
    pub fn times(self, factor: V) -> Self {
        Vector([self.0[0] * factor, self.0[1] * factor, self.0[2] * factor])
    }
    /// `self · factor + other`.
    #[inline(always)]
    pub fn times_plus(self, factor: V, other: Self) -> Self {
        Vector([
            self.0[0].mul_add(factor, other.0[0]),
            self.0[1].mul_add(factor, other.0[1]),
            self.0[2].mul_add(factor, other.0[2]),
        ])
    }
    /// `self · other`.
    #[inline(always)]
    pub fn dot(self, other: Self) -> V {
        let first = self.0[0] * other.0[0];
        self.0[2].mul_add(other.0[2], self.0[1].mul_add(other.0[1], first))
    }
    /// `start + self · other`.
    #[inline(always)]
    pub fn dot_plus(self, other: Self, start: V) -> V {
        self.0[2].mul_add(other.0[2], self.0[1].mul_add(other.0[1], self.0[0].mul_add(other.0[0], start)))
    }
    /// `start − self · factor`.
    #[inline(always)]
    pub fn times_minus(self, factor: V, start: Self) -> Self {
        Vector([
            self.0[0].neg_mul_add(factor, start.0[0]),
            self.0[1].neg_mul_add(factor, start.0[1]),
            self.0[2].neg_mul_add(factor, start.0[2]),
        ])
    }
    /// `start − self · other`.
    #[inline(always)]
    pub fn dot_from(self, other: Self, start: V) -> V {
        self.0[2].neg_mul_add(other.0[2], self.0[1].neg_mul_add(other.0[1], self.0[0].neg_mul_add(other.0[0], start)))
    }
    /// `self × other`.
    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Vector([c.neg_mul_add(y, b * z), a.neg_mul_add(z, c * x), b.neg_mul_add(x, a * y)])
    }
    /// `self × other + start`.
    #[inline(always)]
    pub fn cross_plus(self, other: Self, start: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Vector([
            c.neg_mul_add(y, b.mul_add(z, start.0[0])),
            a.neg_mul_add(z, c.mul_add(x, start.0[1])),
            b.neg_mul_add(x, a.mul_add(y, start.0[2])),
        ])
    }
}

impl<V: Arithmetic> Symmetric<V> {
    /// The zero matrix.
    #[inline(always)]
    pub fn zero() -> Self {
        Symmetric([V::zero(); 6])
    }
    /// Matrix times vector.
    #[inline(always)]
    pub fn apply(&self, v: Vector<V>) -> Vector<V> {
        let [xx, xy, xz, yy, yz, zz] = self.0;
        let [a, b, c] = v.0;
        Vector([
            xz.mul_add(c, xy.mul_add(b, xx * a)),
            yz.mul_add(c, yy.mul_add(b, xy * a)),
            zz.mul_add(c, yz.mul_add(b, xz * a)),
        ])
    }
    /// `self + other`.
    #[inline(always)]
    pub fn plus(&self, other: &Self) -> Self {
        let (a, b) = (&self.0, &other.0);
        Symmetric([a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3], a[4] + b[4], a[5] + b[5]])
    }
    /// `self − a aᵀ'`, where `a'` is `a` times a scalar.
    #[inline(always)]
    pub fn minus_outer(&self, a: Vector<V>, scaled: Vector<V>) -> Self {
        let ([x, y, z], [p, q, r]) = (a.0, scaled.0);
        let [xx, xy, xz, yy, yz, zz] = self.0;
        Symmetric([
            x.neg_mul_add(p, xx),
            x.neg_mul_add(q, xy),
            x.neg_mul_add(r, xz),
            y.neg_mul_add(q, yy),
            y.neg_mul_add(r, yz),
            z.neg_mul_add(r, zz),
        ])
    }
}

impl<V: Arithmetic> Matrix<V> {
    /// The zero matrix.
    #[inline(always)]
    pub fn zero() -> Self {
        Matrix([[V::zero(); 3]; 3])
    }
    /// The rows of the matrix.
    #[inline(always)]
    pub fn rows(&self) -> [Vector<V>; 3] {
        [Vector(self.0[0]), Vector(self.0[1]), Vector(self.0[2])]
    }
    /// The columns of the matrix.
    #[inline(always)]
    pub fn columns(&self) -> [Vector<V>; 3] {
        let [[a, b, c], [d, e, f], [g, h, i]] = self.0;
        [Vector([a, d, g]), Vector([b, e, h]), Vector([c, f, i])]
    }
    /// Matrix times vector.
    #[inline(always)]
    pub fn apply(&self, v: Vector<V>) -> Vector<V> {
        let [first, second, third] = self.rows();
        Vector([first.dot(v), second.dot(v), third.dot(v)])
    }
    /// Matrix times vector, plus `start`.
    #[inline(always)]
    pub fn apply_plus(&self, v: Vector<V>, start: Vector<V>) -> Vector<V> {
        let [first, second, third] = self.rows();
        Vector([first.dot_plus(v, start.0[0]), second.dot_plus(v, start.0[1]), third.dot_plus(v, start.0[2])])
    }
    /// Transposed matrix times vector.
    #[inline(always)]
    pub fn apply_transposed(&self, v: Vector<V>) -> Vector<V> {
        let [first, second, third] = self.columns();
        Vector([first.dot(v), second.dot(v), third.dot(v)])
    }
    /// `self + other`.
    #[inline(always)]
    pub fn plus(&self, other: &Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.rows(), other.rows());
        Matrix([a.plus(x).0, b.plus(y).0, c.plus(z).0])
    }
    /// `self − a bᵀ`.
    #[inline(always)]
    pub fn minus_outer(&self, a: Vector<V>, b: Vector<V>) -> Self {
        let [first, second, third] = self.rows();
        Matrix([b.times_minus(a.0[0], first).0, b.times_minus(a.0[1], second).0, b.times_minus(a.0[2], third).0])
    }
    /// Every entry times `factor`.
    #[inline(always)]
    pub fn times(&self, factor: V) -> Self {
        let [first, second, third] = self.rows();
        Matrix([first.times(factor).0, second.times(factor).0, third.times(factor).0])
    }
}
