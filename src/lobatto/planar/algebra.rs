//! Vectors in a plane whose entries are lanes: one number for each stage.
//!
//! `J` is the quarter turn, `J (x, y) = (−y, x)`: `a × b = J a · b`.

use crate::numbers::euclidean::{Euclidean, own_methods};
use crate::numbers::lanes::Lanes;

/// A vector in the plane, one for each lane.
#[derive(Clone, Copy)]
pub(crate) struct Vector2<V>(pub [V; 2]);

impl<V: Lanes> Vector2<V> {
    /// The zero vector.
    #[inline(always)]
    pub fn zero() -> Self {
        Vector2([V::zero(); 2])
    }
    /// The same vector in every lane.
    #[inline(always)]
    pub fn splat(v: &[f64; 2]) -> Self {
        Vector2([V::splat(v[0]), V::splat(v[1])])
    }
    /// `self + other`.
    #[inline(always)]
    pub fn plus(self, other: Self) -> Self {
        Vector2([self.0[0] + other.0[0], self.0[1] + other.0[1]])
    }
    /// `self − other`.
    #[inline(always)]
    pub fn minus(self, other: Self) -> Self {
        Vector2([self.0[0] - other.0[0], self.0[1] - other.0[1]])
    }
    /// `self · factor`.
    #[inline(always)]
    pub fn times(self, factor: V) -> Self {
        Vector2([self.0[0] * factor, self.0[1] * factor])
    }
    /// `self · factor + start`.
    #[inline(always)]
    pub fn times_plus(self, factor: V, start: Self) -> Self {
        Vector2([self.0[0].mul_add(factor, start.0[0]), self.0[1].mul_add(factor, start.0[1])])
    }
    /// `start − self · factor`.
    #[inline(always)]
    pub fn times_minus(self, factor: V, start: Self) -> Self {
        Vector2([self.0[0].neg_mul_add(factor, start.0[0]), self.0[1].neg_mul_add(factor, start.0[1])])
    }
    /// `J self`.
    #[inline(always)]
    pub fn quarter_turn(self) -> Self {
        Vector2([-self.0[1], self.0[0]])
    }
    /// `(along + across J) self`: a turn, a stretch, or an increment of either.
    #[inline(always)]
    pub fn turned(self, along: V, across: V) -> Self {
        let [x, y] = self.0;
        Vector2([across.neg_mul_add(y, along * x), across.mul_add(x, along * y)])
    }
    /// `start + (along + across J) self`.
    #[inline(always)]
    pub fn turned_plus(self, along: V, across: V, start: Self) -> Self {
        let [x, y] = self.0;
        Vector2([across.neg_mul_add(y, along.mul_add(x, start.0[0])), across.mul_add(x, along.mul_add(y, start.0[1]))])
    }
    /// `start + self · other`.
    #[inline(always)]
    pub fn dot_plus(self, other: Self, start: V) -> V {
        self.0[1].mul_add(other.0[1], self.0[0].mul_add(other.0[0], start))
    }
    /// `self · other`.
    #[inline(always)]
    pub fn dot(self, other: Self) -> V {
        self.0[1].mul_add(other.0[1], self.0[0] * other.0[0])
    }
    /// `start − self · other`.
    #[inline(always)]
    pub fn dot_from(self, other: Self, start: V) -> V {
        self.0[1].neg_mul_add(other.0[1], self.0[0].neg_mul_add(other.0[0], start))
    }
    /// `start + self × other`.
    #[inline(always)]
    pub fn cross_plus(self, other: Self, start: V) -> V {
        self.0[1].neg_mul_add(other.0[0], self.0[0].mul_add(other.0[1], start))
    }
}

impl<V: Lanes> Euclidean<V> for Vector2<V> {
    type Components = [f64; 2];
    type Axial = V;
    own_methods!(Vector2);

    #[inline(always)]
    fn cross(self, other: Self) -> V {
        Vector2::cross_plus(self, other, V::zero())
    }

    #[inline(always)]
    fn mixed(self, columns: &[V]) -> Self {
        let [x, y] = self.0;
        Vector2([x.mix(columns), y.mix(columns)])
    }

    #[inline(always)]
    fn joined(self, axial: V) -> [V; 6] {
        let ([x, y], zero) = (self.0, V::zero());
        [x, y, axial, zero, zero, zero]
    }
}
