//! Impacts on limits: the momentum of the whole mechanism, with all its closures, several limits at once.
//!
//! With the rows W of the limits that are met (their rates γ = W v, positive into the allowed range) and `D = W Y Wᵀ`:
//!
//! ```text
//!     0 ≤ P ⊥ D P + γ⁻ + e min(γ⁻, 0) ≥ 0,      v⁺ = v⁻ + Y Wᵀ P          one round, on the rows that approach or rest
//!     lost = −½ (γ⁻ + γ⁺)ᵀ P ≥ 0  (J)
//! ```
//!
//! Rounds follow each other until no row approaches; after fifty all rows are taken without restitution. Where numbers e differ and a round would
//! gain energy, it goes from the plastic solution `v_C` as far towards it as no energy is gained. Efforts that are finite, of friction and
//! motors, give no impulse.
//!
//! Sources: J. J. Moreau, "Unilateral contact and dry friction in finite freedom dynamics" (1988); rounds: B. Smith et al., "Reflections on
//! simultaneous impact", ACM Trans. Graphics 31 (2012).

use crate::instant::bounded::minimise;
use crate::instant::response::Response;
use crate::mechanism::motion::state::State;
use nalgebra::{DMatrix, DVector};

/// Rounds before all rows are plastic.
const ROUNDS: usize = 50;

/// A limit that is met.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row {
    /// Which joint it is of, among the elements.
    pub joint: usize,
    /// Its degree of freedom, and the direction into the allowed range along it.
    pub freedom: usize,
    pub inward: f64,
    /// e.
    pub restitution: f64,
    /// Rates towards the limit below this are rest [rad/s or m/s].
    pub rest: f64,
}

/// What impacts did.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Impact {
    /// Impulse of each row [N m s or N s].
    pub impulses: Vec<f64>,
    /// Kinetic energy that was lost (J).
    pub lost: f64,
}

/// Changes the velocities of a state so that no row approaches its limit; rates of rows that end at rest are exactly zero.
pub(crate) fn collide(response: &mut Response, state: &mut State, rows: &[Row]) -> Impact {
    let mut done = Impact { impulses: vec![0.0; rows.len()], lost: 0.0 };
    let approaches = |state: &State, row: &Row| row.inward * state.velocity[row.freedom] < -row.rest;
    if !rows.iter().any(|row| approaches(state, row)) {
        return done;
    }
    let freedoms: Vec<usize> = rows.iter().map(|row| row.freedom).collect();
    let (columns, square) = response.matrix(state, &freedoms);
    let square = DMatrix::from_fn(rows.len(), rows.len(), |a, b| rows[a].inward * rows[b].inward * square[(a, b)]);
    for round in 0..=ROUNDS {
        let last = round == ROUNDS;
        let rates: Vec<f64> = rows.iter().map(|row| row.inward * state.velocity[row.freedom]).collect();
        let taken: Vec<usize> = (0..rows.len())
            .filter(|&index| last || rates[index] < -rows[index].rest || rates[index].abs() <= rows[index].rest)
            .collect();
        if !rows.iter().any(|row| approaches(state, row)) {
            break;
        }
        let part = DMatrix::from_fn(taken.len(), taken.len(), |a, b| square[(taken[a], taken[b])]);
        let before: Vec<f64> = taken.iter().map(|&index| rates[index]).collect();
        let bounds = vec![(0.0, f64::INFINITY); taken.len()];
        let plastic = minimise(&part, &before, &bounds).efforts;
        let impulses = if last || taken.iter().all(|&index| rows[index].restitution == 0.0) {
            plastic
        } else {
            let given = taken.iter().zip(&before).map(|(&index, &rate)| rate + rows[index].restitution * rate.min(0.0));
            let given: Vec<f64> = given.collect();
            without_gain(&part, &before, &plastic, &minimise(&part, &given, &bounds).efforts)
        };
        let after = &part * DVector::from_column_slice(&impulses) + DVector::from_column_slice(&before);
        for (index, (&row, &impulse)) in taken.iter().zip(&impulses).enumerate() {
            done.impulses[row] += impulse;
            done.lost -= 0.5 * (before[index] + after[index]) * impulse;
            for (freedom, rate) in state.velocity.iter_mut().enumerate() {
                *rate += rows[row].inward * columns[(freedom, row)] * impulse;
            }
        }
        for (index, &row) in taken.iter().enumerate() {
            // What an impulse has stopped stands.
            let stopped = impulses[index] > 0.0 && (last || rows[row].restitution == 0.0);
            if stopped && after[index].abs() <= 1e-9 * before[index].abs().max(rows[row].rest) {
                state.velocity[rows[row].freedom] = 0.0;
            }
        }
    }
    done
}

/// From the plastic impulses as far towards others as no energy is gained: `E(σ) − E⁻ = Pᵀ (γ + ½ D P)`, a quadratic of σ.
fn without_gain(square: &DMatrix<f64>, rates: &[f64], plastic: &[f64], wanted: &[f64]) -> Vec<f64> {
    let gain = |impulses: &DVector<f64>| impulses.dot(&(DVector::from_column_slice(rates) + 0.5 * square * impulses));
    let (from, to) = (DVector::from_column_slice(plastic), DVector::from_column_slice(wanted));
    let kinetic = rates.iter().zip(wanted).map(|(rate, impulse)| (rate * impulse).abs()).sum::<f64>();
    if gain(&to) <= 1e-14 * kinetic {
        return wanted.to_vec();
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if gain(&(&from + (&to - &from) * middle)) <= 0.0 { low = middle } else { high = middle }
    }
    (&from + (&to - &from) * low).iter().copied().collect()
}
