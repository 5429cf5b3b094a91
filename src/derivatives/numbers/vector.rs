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
    pub fn zero() -> Self {
        Vector([T::zero(); 3])
    }

    /// A constant.
    pub fn of(vector: &Vector3<f64>) -> Self {
        Vector([0, 1, 2].map(|row| T::of(vector[row])))
    }

    /// Entry by entry.
    pub fn map<U>(self, of: impl FnMut(T) -> U) -> Vector<U> {
        Vector(self.0.map(of))
    }

    /// Times a number.
    pub fn scaled(self, factor: T) -> Self {
        self.map(|entry| entry * factor)
    }

    /// The scalar product.
    pub fn dot(self, other: Self) -> T {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        a * x + b * y + c * z
    }

    /// The vector product.
    pub fn cross(self, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Vector([b * z - c * y, c * x - a * z, a * y - b * x])
    }
}

impl<T: Number> Add for Vector<T> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Vector(std::array::from_fn(|row| self.0[row] + other.0[row]))
    }
}

impl<T: Number> Sub for Vector<T> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Vector(std::array::from_fn(|row| self.0[row] - other.0[row]))
    }
}

impl<T: Number> Neg for Vector<T> {
    type Output = Self;
    fn neg(self) -> Self {
        self.map(|entry| -entry)
    }
}

impl<T: Number> Matrix<T> {
    /// A constant.
    pub fn of(matrix: &Matrix3<f64>) -> Self {
        Matrix([0, 1, 2].map(|column| Vector::of(&matrix.column(column).into_owned())))
    }

    /// One.
    pub fn identity() -> Self {
        Matrix::of(&Matrix3::identity())
    }

    /// Column by column.
    pub fn map<U>(self, of: impl FnMut(Vector<T>) -> Vector<U>) -> Matrix<U> {
        Matrix(self.0.map(of))
    }

    /// Times a vector.
    pub fn apply(&self, vector: Vector<T>) -> Vector<T> {
        let [a, b, c] = vector.0;
        self.0[0].scaled(a) + self.0[1].scaled(b) + self.0[2].scaled(c)
    }

    /// Times a matrix.
    pub fn product(&self, other: &Self) -> Self {
        other.map(|column| self.apply(column))
    }

    /// Its transpose.
    pub fn transpose(&self) -> Self {
        Matrix([0, 1, 2].map(|row| Vector(self.0.map(|column| column.0[row]))))
    }

    /// `1 + θ̂ + θ̂²/2`: the rotation by a vector that is zero but for its derivatives, exact to the second one.
    pub fn turned_slightly(theta: Vector<T>) -> Self {
        let identity: Matrix<T> = Matrix::identity();
        identity.map(|axis| {
            let first = theta.cross(axis);
            axis + first + theta.cross(first).scaled(T::of(0.5))
        })
    }
}
