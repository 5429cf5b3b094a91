//! Linear equations of motion in other coordinates.
//!
//! The slight changes q′, v′ of other coordinates, and their accelerations a′ under efforts τ′, belong to slight changes of the state:
//!
//! ```text
//!     δq′ = T δq        δv′ = T δu + V δq        δa′ = T δu̇ + P δq + U δu        δτ = Tᵀ δτ′ + E δq
//!     d/dt δq′ = δv′ + N δq′
//!
//!     ξ′ = S ξ,  S = (T M)_I        η′ = S η + F ξ,  F = (T W + V M)_I        M′ = T M S⁻¹        H′ = S⁻ᵀ H S⁻¹
//! ```
//!
//! with the motions M and W of [`crate::derivatives::linear::linearised`] along the independent coordinates. Efforts τ′ are held while the state
//! varies. Joints whose coordinates belong together stay independent as they were, unless closures make some of them depend on others: then the
//! independent coordinates are chosen again.

use crate::derivatives::linear::independent::Independent;
use crate::derivatives::linear::linearised::{LinearError, Linearised};
use nalgebra::{DMatrix, DVector};

/// Pivots of S below this part of its largest entry ask for other independent coordinates.
const APART: f64 = 1e-6;

/// A change of coordinates at a state, along n degrees of freedom.
#[derive(Clone, Debug)]
pub(crate) struct Elsewhere {
    /// T.
    pub along: DMatrix<f64>,
    /// V.
    pub bent: DMatrix<f64>,
    /// P and U.
    pub by_position: DMatrix<f64>,
    pub by_velocity: DMatrix<f64>,
    /// E.
    pub of_efforts: DMatrix<f64>,
    /// N.
    pub turning: DMatrix<f64>,
    /// a′ of the state itself (n).
    pub accelerations: DVector<f64>,
}

impl Elsewhere {
    /// The same coordinates.
    pub fn identity(freedoms: usize) -> Self {
        let none = DMatrix::zeros(freedoms, freedoms);
        Elsewhere {
            along: DMatrix::identity(freedoms, freedoms),
            bent: none.clone(),
            by_position: none.clone(),
            by_velocity: none.clone(),
            of_efforts: none.clone(),
            turning: none,
            accelerations: DVector::zeros(freedoms),
        }
    }

    /// Of some of the degrees of freedom.
    pub fn of(&self, freedoms: &[usize]) -> Self {
        let part = |of: &DMatrix<f64>| of.select_rows(freedoms).select_columns(freedoms);
        Elsewhere {
            along: part(&self.along),
            bent: part(&self.bent),
            by_position: part(&self.by_position),
            by_velocity: part(&self.by_velocity),
            of_efforts: part(&self.of_efforts),
            turning: part(&self.turning),
            accelerations: self.accelerations.select_rows(freedoms),
        }
    }

    /// Linear equations in these coordinates.
    ///
    /// # Errors
    /// [`LinearError::Singular`] where independent coordinates cannot be chosen.
    pub fn told(&self, of: &Linearised) -> Result<Linearised, LinearError> {
        let d = of.independent.len();
        if d == 0 {
            return Ok(of.clone());
        }
        let moved = &self.along * &of.motions;
        let mut independent = of.independent.clone();
        if !stands_alone(&moved.select_rows(&independent)) {
            independent = Independent::of(&moved.transpose(), &vec![1.0; moved.nrows()]).dependent;
            independent.sort_unstable();
        }
        let inverse = moved.select_rows(&independent).try_inverse().filter(|_| independent.len() == d);
        let inverse = inverse.ok_or(LinearError::Singular)?;
        let motions = &moved * &inverse;
        let followed = (&self.along * &of.followed + &self.bent * &of.motions).select_rows(&independent);
        // δa′ by ξ and η, as the coordinates were.
        let by_state =
            &of.accelerated + &of.by_effort * (&self.of_efforts * &of.motions).resize_horizontally(2 * d, 0.0);
        let mut rates = &self.along * by_state;
        let of_positions = &self.by_position * &of.motions + &self.by_velocity * &of.followed;
        let mut own = rates.columns_mut(0, d);
        own += of_positions;
        let mut own = rates.columns_mut(d, d);
        own += &self.by_velocity * &of.motions;
        let rates = rates.select_rows(&independent);
        // ξ = S⁻¹ ξ′,  η = S⁻¹ (η′ − F S⁻¹ ξ′)
        let by_rate = rates.columns(d, d) * &inverse;
        let by_place = (rates.columns(0, d) - &by_rate * &followed) * &inverse;
        let mut state = DMatrix::zeros(2 * d, 2 * d);
        state.view_mut((0, 0), (d, d)).copy_from(&(&self.turning * &motions).select_rows(&independent));
        state.view_mut((0, d), (d, d)).fill_with_identity();
        state.view_mut((d, 0), (d, d)).copy_from(&by_place);
        state.view_mut((d, d), (d, d)).copy_from(&by_rate);
        let by_effort = &self.along * &of.by_effort * self.along.transpose();
        let mut input = DMatrix::zeros(2 * d, by_effort.ncols());
        input.rows_mut(d, d).copy_from(&by_effort.select_rows(&independent));
        let inertia = inverse.tr_mul(&of.inertia) * &inverse;
        Ok(Linearised {
            stiffness: -(&inertia * &by_place),
            damping: -(&inertia * &by_rate),
            inertia,
            independent,
            motions,
            state,
            input,
            accelerations: self.accelerations.clone(),
            // Of the coordinates of the state alone.
            followed: of.followed.clone(),
            accelerated: of.accelerated.clone(),
            by_effort: of.by_effort.clone(),
        })
    }
}

/// Whether the rows of a square matrix are far from depending on each other.
fn stands_alone(rows: &DMatrix<f64>) -> bool {
    let pivots = rows.clone().full_piv_lu();
    pivots.u().diagonal().iter().all(|pivot| pivot.abs() > APART * rows.amax())
}
