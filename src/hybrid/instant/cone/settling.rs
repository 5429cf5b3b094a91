//! The states that follow from a solution, and the rates and forces that are exactly zero or at a bound in each of them.
//!
//! ```text
//!     z = r − u:    contact   z_N ≤ 0: open, r = 0       |z_T| ≤ μ z_N: sticks, u = 0       else slips, u_N = 0, r_T = μ r_N z_T/|z_T|
//!                   interval  z at or beyond a bound: r is that bound, else u = 0
//! ```
//!
//! All of it is in scaled units, in which r and u compare. A contact within rounding of a border is open, or sticks.

use crate::instant::cone::laws::natural_map;
use crate::instant::cone::problem::{Answer, BlockState, Law, Problem};
use crate::instant::cone::scaled::{Scaled, block_of};

/// Rates below this part of the terms that they are the sum of are rounding.
const ROUNDING: f64 = 1e-13;

/// The answer that scaled forces are, with its states.
pub(super) fn settle(problem: &Problem, scaled: &Scaled, forces: &[f64]) -> Answer {
    let mut rates = vec![0.0; forces.len()];
    scaled.rates(forces, &mut rates);
    let mut forces = forces.to_vec();
    let sizes = sizes_of_terms(scaled, &forces);
    let mut states = Vec::with_capacity(scaled.laws.len());
    for (start, law) in scaled.blocks() {
        let rows = start..start + law.rows();
        let off = natural_map(&law, &rates[start..], &forces[start..]).norm();
        let size = sizes[rows.clone()].iter().fold(0.0_f64, |most, size| most.max(*size));
        let rounding = (4.0 * off).max(ROUNDING * size);
        states.push(settle_block(&law, &rates[rows.clone()], &mut forces[rows], rounding));
    }
    scaled.rates(&forces, &mut rates);
    let residual = scaled.residual(&forces, &rates);
    let forces = scaled.unscale(&forces);
    let mut rates = problem.rates(&forces);
    for ((start, law), state) in scaled.blocks().zip(&states) {
        clear(&law, *state, &mut rates[start..start + law.rows()]);
    }
    Answer { forces, rates, states, residual }
}

/// `|b| + Σ |D| |r|` of each row.
fn sizes_of_terms(scaled: &Scaled, forces: &[f64]) -> Vec<f64> {
    let mut sizes: Vec<f64> = scaled.free.iter().map(|free| free.abs()).collect();
    for (column, force) in scaled.mobility.column_iter().zip(forces).filter(|(_, force)| **force != 0.0) {
        for (size, mobility) in sizes.iter_mut().zip(column.iter()) {
            *size += (mobility * force).abs();
        }
    }
    sizes
}

/// The state of a block; sets the exact entries of its forces.
fn settle_block(law: &Law, rates: &[f64], forces: &mut [f64], rounding: f64) -> BlockState {
    let moved = block_of(law, forces) - block_of(law, rates);
    match *law {
        Law::Interval { lower, upper } => {
            // Free on one side only: touching without force is at the bound. Else rest is inside.
            let margin = if lower.is_finite() && upper.is_finite() { -rounding } else { rounding };
            let (force, state) = if moved.x <= lower + margin || lower == upper {
                (lower, BlockState::AtLower)
            } else if moved.x >= upper - margin {
                (upper, BlockState::AtUpper)
            } else {
                (forces[0].max(lower).min(upper), BlockState::Inside)
            };
            forces[0] = force;
            state
        }
        Law::Contact { .. } | Law::Sliding { .. } if moved.x <= rounding || forces[0] <= 0.0 => {
            forces.fill(0.0);
            BlockState::Open
        }
        Law::Sliding { friction, direction } => {
            (forces[1], forces[2]) = (-friction * forces[0] * direction[0], -friction * forces[0] * direction[1]);
            BlockState::Slips
        }
        Law::Contact { friction } => {
            let bound = friction * forces[0];
            let tangential = moved.y.hypot(moved.z);
            let slips = tangential > friction * moved.x + rounding || friction == 0.0;
            let carried = forces[1].hypot(forces[2]);
            if slips {
                let factor = if tangential > 0.0 { bound / tangential } else { 0.0 };
                (forces[1], forces[2]) = (factor * moved.y, factor * moved.z);
            } else if carried > bound {
                (forces[1], forces[2]) = (forces[1] * bound / carried, forces[2] * bound / carried);
            }
            if slips { BlockState::Slips } else { BlockState::Sticks }
        }
    }
}

/// Sets the exact entries of the rates of a block.
fn clear(law: &Law, state: BlockState, rates: &mut [f64]) {
    match state {
        BlockState::Sticks | BlockState::Inside => rates.fill(0.0),
        BlockState::Slips => rates[0] = 0.0,
        BlockState::Open => rates[0] = rates[0].max(0.0),
        // An interval without room does not hold its rate.
        BlockState::AtLower if matches!(*law, Law::Interval { lower, upper } if lower == upper) => {}
        BlockState::AtLower => rates[0] = rates[0].max(0.0),
        BlockState::AtUpper => rates[0] = rates[0].min(0.0),
    }
}
