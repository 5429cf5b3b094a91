//! How the eigenvalues of linear equations of motion change with numbers of the scene.
//!
//! ```text
//!     A x = λ x,    yᴴ A = λ yᴴ                 ∂λ/∂θ = yᴴ (∂A/∂θ) x / (yᴴ x)
//!     ∂A/∂θ = Σ_k w_k A(θ + k δ)/δ              k = −4 … 4, without 0; each with its own equilibrium
//! ```
//!
//! Differences of order eight over a part in 250 of a number have errors of 1e-10 of the derivative. Eigenvalues that are equal have no derivative of
//! their own, nor have eigenvalues whose vectors meet, as of free motions.
//!
//! Source: P. Lancaster, On eigenvalues of matrices dependent on a parameter, Numerische Mathematik 6 (1964).

use crate::derivatives::events::parameter::{WEIGHTS, WIDTH};
use crate::derivatives::forward::failure::SensitivityError;
use crate::session::error::Error;
use crate::session::linear::Linear;
use crate::session::model::{Model, number_of};
use nalgebra::{Complex, DMatrix};

/// Singular values of A − λ below this part of the largest are zero: matrices of poorly scaled mechanisms have roundings of 1e-12.
const SMALL: f64 = 1e-9;
/// Left and right vectors with a smaller product meet.
const MEET: f64 = 1e-8;

/// The derivatives of the eigenvalues of all modes by a number [1/s per unit]; the frequency in Hz has the imaginary part over 2π.
#[derive(Clone, Debug)]
pub struct EigenvalueSlopes {
    /// The key path of the number.
    pub key: String,
    /// For each mode; `None` where eigenvalues are equal.
    pub by: Vec<Option<Complex<f64>>>,
}

impl Model {
    /// The derivatives of the eigenvalues of linear equations by numbers of the scene, where `of` gives the equations of a model with other numbers.
    ///
    /// # Errors
    /// Unknown numbers, and numbers with which the structure changes; and errors of `of`.
    pub fn eigenvalues_by(
        &self,
        linear: &Linear,
        keys: &[&str],
        of: impl Fn(&Model) -> Result<Linear, Error>,
    ) -> Result<Vec<EigenvalueSlopes>, Error> {
        let scene = self.scene_with_numbers()?;
        let all = scene.parameters();
        let vectors: Vec<_> = linear.modes.iter().map(|mode| vectors(&linear.a, mode.eigenvalue)).collect();
        let slopes = |key: &&str| {
            let own = || (*key).to_string();
            let (number, value) = number_of(&scene, &all, key)?;
            let width = if value == 0.0 { WIDTH } else { WIDTH * value.abs() };
            let at = |count: f64| -> Result<DMatrix<f64>, Error> {
                let other = value + count * width;
                let edge =
                    |error: Error| SensitivityError::Edge { key: own(), value, other, reason: error.to_string() };
                let model = self.of_numbers(&scene, number, other).map_err(edge)?;
                let found = of(&model).map_err(edge)?;
                if found.names != linear.names {
                    return Err(SensitivityError::Structure { key: own(), value }.into());
                }
                Ok(found.a)
            };
            let mut change = DMatrix::zeros(linear.a.nrows(), linear.a.ncols());
            for (index, weight) in WEIGHTS.iter().enumerate() {
                let count = (index + 1) as f64;
                change += (at(count)? - at(-count)?) * (weight / width);
            }
            let change = change.map(|entry| Complex::new(entry, 0.0));
            let by = vectors.iter().map(|pair| {
                let (left, right) = pair.as_ref()?;
                Some(left.dotc(&(&change * right)) / left.dotc(right))
            });
            Ok(EigenvalueSlopes { key: own(), by: by.collect() })
        };
        keys.iter().map(slopes).collect()
    }
}

type Vectors = nalgebra::DVector<Complex<f64>>;

/// The left and the right vector of an eigenvalue; `None` if there are more of them, or if they meet.
fn vectors(matrix: &DMatrix<f64>, eigenvalue: Complex<f64>) -> Option<(Vectors, Vectors)> {
    let count = matrix.nrows();
    let mut shifted = matrix.map(|entry| Complex::new(entry, 0.0));
    (0..count).for_each(|row| shifted[(row, row)] -= eigenvalue);
    let found = shifted.svd(true, true);
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|&one, &other| found.singular_values[one].total_cmp(&found.singular_values[other]));
    let least = SMALL * found.singular_values.max();
    if order.get(1).is_some_and(|&second| found.singular_values[second] <= least) {
        return None;
    }
    let &own = order.first()?;
    let left = found.u?.column(own).into_owned();
    let right = found.v_t?.row(own).adjoint();
    (left.dotc(&right).norm() > MEET).then_some((left, right))
}
