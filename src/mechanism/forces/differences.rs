//! Central differences, for the tests of the derivatives.

use nalgebra::{Matrix3, Vector3};

/// A step that balances the error of the third derivative with rounding.
const STEP: f64 = 1e-5;

/// The slope of a function.
pub fn central(function: impl Fn(f64) -> f64, at: f64) -> f64 {
    (function(at + STEP) - function(at - STEP)) / (2.0 * STEP)
}

/// The derivative of a vector by a vector: one column for each component of the argument.
pub fn central_vector(function: impl Fn(Vector3<f64>) -> Vector3<f64>, at: Vector3<f64>) -> Matrix3<f64> {
    let column = |axis: usize| {
        let step = Vector3::ith(axis, STEP);
        (function(at + step) - function(at - step)) / (2.0 * STEP)
    };
    Matrix3::from_columns(&[column(0), column(1), column(2)])
}
