//! Vectors and matrices in space, of numbers with derivatives.

use crate::derivatives::numbers::number::Number;
use nalgebra::{Matrix3, Vector3};
use std::ops::{Add, Neg, Sub};

/// A vector in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vector<T>(pub [T; 3]);

/// A matrix in space, by its columns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Matrix<T>(pub [Vector<T>; 3]);

impl<T: Number> Vector<T> {
    /// Zero.
    #[inline]
    pub fn zero() -> Self {
        Vector([T::zero(); 3])
    }

    /// A constant.
    #[inline]
    pub fn of(vector: &Vector3<f64>) -> Self {
        Vector([0, 1, 2].map(|row| T::of(vector[row])))
    }

    /// Entry by entry.
    #[inline]
    pub fn map<U>(self, mut of: impl FnMut(T) -> U) -> Vector<U> {
        let [x, y, z] = self.0;
        Vector([of(x), of(y), of(z)])
    }

    /// Times a number.
    #[inline]
    pub fn scaled(self, factor: T) -> Self {
        let [x, y, z] = self.0;
        Vector([x * factor, y * factor, z * factor])
    }

    /// The scalar product.
    #[inline]
    pub fn dot(self, other: Self) -> T {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        a * x + b * y + c * z
    }

    /// The vector product.
    #[inline]
    pub fn cross(self, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Vector([b * z - c * y, c * x - a * z, a * y - b * x])
    }
}

impl<T: Number> Add for Vector<T> {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Vector([a + x, b + y, c + z])
    }
}

impl<T: Number> Sub for Vector<T> {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Vector([a - x, b - y, c - z])
    }
}

impl<T: Number> Neg for Vector<T> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        self.map(|entry| -entry)
    }
}

impl<T: Number> Matrix<T> {
    /// A constant.
    #[inline]
    pub fn of(matrix: &Matrix3<f64>) -> Self {
        Matrix([0, 1, 2].map(|column| Vector::of(&matrix.column(column).into_owned())))
    }

    /// One.
    #[inline]
    pub fn identity() -> Self {
        Matrix::of(&Matrix3::identity())
    }

    /// Column by column.
    #[inline]
    pub fn map<U>(self, mut of: impl FnMut(Vector<T>) -> Vector<U>) -> Matrix<U> {
        let [x, y, z] = self.0;
        Matrix([of(x), of(y), of(z)])
    }

    /// Times a vector.
    #[inline]
    pub fn apply(&self, vector: Vector<T>) -> Vector<T> {
        let [a, b, c] = vector.0;
        self.0[0].scaled(a) + self.0[1].scaled(b) + self.0[2].scaled(c)
    }

    /// Times a matrix.
    #[inline]
    pub fn product(&self, other: &Self) -> Self {
        let [x, y, z] = other.0;
        Matrix([self.apply(x), self.apply(y), self.apply(z)])
    }

    /// Its transpose.
    #[inline]
    pub fn transpose(&self) -> Self {
        let [x, y, z] = self.0;
        let row = |row: usize| Vector([x.0[row], y.0[row], z.0[row]]);
        Matrix([row(0), row(1), row(2)])
    }

    /// `1 + θ̂ + θ̂²/2`: the rotation by a vector that is zero but for its derivatives, exact to the second one.
    #[inline]
    pub fn turned_slightly(theta: Vector<T>) -> Self {
        let identity: Matrix<T> = Matrix::identity();
        identity.map(|axis| {
            let first = theta.cross(axis);
            axis + first + theta.cross(first).scaled(T::of(0.5))
        })
    }
}
