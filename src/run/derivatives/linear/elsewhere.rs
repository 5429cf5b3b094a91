//! Linear equations of motion in other coordinates.
//!
//! The slight changes q′, v′ of other coordinates, and their accelerations a′ under efforts τ′, belong to slight changes of the state:
//!
//! ```text
//!     δq′ = T δq        δv′ = T δu + V δq        δa′ = T δu̇ + P δq + U δu        δτ = Tᵀ δτ′ + E δq
//!     d/dt δq′ = δv′ + N δq′
//!
//!     ξ′ = S ξ,  S = (T M)_I        η′ = R η + F ξ,  R = (T Q)_E,  F = (T W + V M)_E        M′ = T M S⁻¹        Q′ = T Q R⁻¹        H′ = R⁻ᵀ H R⁻¹
//! ```
//!
//! with the motions M, Q and W of [`crate::derivatives::linear::linearised`] (T, V and W there) along the independent coordinates I and velocities E.
//! Efforts τ′ are held while the state varies. Joints whose coordinates belong together stay independent as they were, unless closures make some of
//! them depend on others: then the independent ones are chosen again.

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
        let (d, e) = (of.independent.len(), of.rates.len());
        if d == 0 {
            return Ok(of.clone());
        }
        let (moved, rolled) = (&self.along * &of.motions, &self.along * &of.rolling);
        let independent = chosen(&moved, of.independent.clone(), (0..moved.nrows()).collect());
        let inverse = moved.select_rows(&independent).try_inverse().filter(|_| independent.len() == d);
        let inverse = inverse.ok_or(LinearError::Singular)?;
        let known = of.rates.iter().all(|freedom| independent.contains(freedom));
        let known = if known { of.rates.clone() } else { Vec::new() };
        let rates = if d == e { independent.clone() } else { chosen(&rolled, known, independent.clone()) };
        let slower = rolled.select_rows(&rates).try_inverse().filter(|_| rates.len() == e);
        let slower = slower.ok_or(LinearError::Singular)?;
        let (motions, rolling) = (&moved * &inverse, &rolled * &slower);
        let followed = &self.along * &of.followed + &self.bent * &of.motions;
        let own = followed.select_rows(&rates);
        // δa′ by ξ and η, as the coordinates were.
        let by_state =
            &of.accelerated + &of.by_effort * (&self.of_efforts * &of.motions).resize_horizontally(d + e, 0.0);
        let mut changes = &self.along * by_state;
        let of_positions = &self.by_position * &of.motions + &self.by_velocity * &of.followed;
        let mut of_places = changes.columns_mut(0, d);
        of_places += of_positions;
        let mut of_rates = changes.columns_mut(d, e);
        of_rates += &self.by_velocity * &of.rolling;
        let changes = changes.select_rows(&rates);
        // ξ = S⁻¹ ξ′,  η = R⁻¹ (η′ − F S⁻¹ ξ′)
        let by_rate = changes.columns(d, e) * &slower;
        let by_place = (changes.columns(0, d) - &by_rate * &own) * &inverse;
        let mut turning = (&self.turning * &motions).select_rows(&independent);
        let mut sliding = rolling.select_rows(&independent);
        let bending = (followed.select_rows(&independent) - &sliding * &own) * &inverse;
        for (row, freedom) in independent.iter().enumerate() {
            // A velocity that is independent is the rate of its position.
            match rates.iter().position(|own| own == freedom) {
                Some(own) => (0..e).for_each(|column| sliding[(row, column)] = f64::from(column == own)),
                None => (0..d).for_each(|column| turning[(row, column)] += bending[(row, column)]),
            }
        }
        let mut state = DMatrix::zeros(d + e, d + e);
        state.view_mut((0, 0), (d, d)).copy_from(&turning);
        state.view_mut((0, d), (d, e)).copy_from(&sliding);
        state.view_mut((d, 0), (e, d)).copy_from(&by_place);
        state.view_mut((d, d), (e, e)).copy_from(&by_rate);
        let by_effort = &self.along * &of.by_effort * self.along.transpose();
        let mut input = DMatrix::zeros(d + e, by_effort.ncols());
        input.rows_mut(d, e).copy_from(&by_effort.select_rows(&rates));
        let inertia = slower.tr_mul(&of.inertia) * &slower;
        Ok(Linearised {
            stiffness: -(&inertia * &by_place),
            damping: -(&inertia * &by_rate),
            inertia,
            independent,
            rates,
            motions,
            rolling,
            state,
            input,
            accelerations: self.accelerations.clone(),
            // Of the coordinates of the state alone.
            followed: of.followed.clone(),
            accelerated: of.accelerated.clone(),
            by_effort: of.by_effort.clone(),
            pressed: of.pressed,
        })
    }
}

/// Independent rows of motions in columns, among some of them: the known ones if they stand alone.
fn chosen(motions: &DMatrix<f64>, known: Vec<usize>, among: Vec<usize>) -> Vec<usize> {
    if known.len() == motions.ncols() && stands_alone(&motions.select_rows(&known)) {
        return known;
    }
    let own = motions.select_rows(&among).transpose();
    let mut chosen: Vec<usize> =
        Independent::of(&own, &vec![1.0; among.len()]).dependent.into_iter().map(|row| among[row]).collect();
    chosen.sort_unstable();
    chosen
}

/// Whether the rows of a square matrix are far from depending on each other.
fn stands_alone(rows: &DMatrix<f64>) -> bool {
    let pivots = rows.clone().full_piv_lu();
    pivots.u().diagonal().iter().all(|pivot| pivot.abs() > APART * rows.amax())
}
