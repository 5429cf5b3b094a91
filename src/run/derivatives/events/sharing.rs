//! The pressures of sliding contacts whose normals imply each other.
//!
//! The motion leaves open how such contacts share a load, but their friction depends on it. Steps share as equal springs would
//! (`hybrid/events/forces/closed_forces.rs`): with the gradients W (k × n) of the normals,
//!
//! ```text
//!     zᵀ λ = 0  for all z with  zᵀ W = 0        λ_D = C λ_I,   W_D = C W_I,   C = W_D W_Iᵀ (W_I W_Iᵀ)⁻¹
//! ```
//!
//! for independent rows I and all others D. C is constant for contacts of one rigid body with a plane: pressures are affine in the place.

use crate::derivatives::equations::closed::{ClosedTouch, Friction, Share};
use crate::derivatives::events::instant::Instant;
use crate::derivatives::events::walk::Walk;
use crate::derivatives::forward::step::{Part, StepMode, WIDTH};
use crate::derivatives::forward::tangent::with;
use crate::derivatives::linear::independent::Independent;
use crate::derivatives::numbers::number::Number;
use nalgebra::DMatrix;

/// Entries of W_D − C W_I beyond this part of the largest of W, per unit of a parameter or of time, are changes of C.
const CHANGES: f64 = 1e-8;

impl StepMode {
    /// Finds the pressures that follow from others, if contacts slide with friction, and takes their rows out of the gradient of all closures.
    pub(super) fn take_shares(&mut self, gradient: &mut DMatrix<f64>) {
        let normals = self.normals();
        if normals.is_empty() {
            return;
        }
        let first = self.row_count - self.closed.touch_rows();
        let own: Vec<usize> = normals.iter().map(|row| first + row).collect();
        let whole = gradient.select_rows(&own);
        let mut known = Independent::of(&whole, &vec![1.0; whole.ncols()]).rows;
        known.sort_unstable();
        let others: Vec<usize> = (0..own.len()).filter(|row| !known.contains(row)).collect();
        let independent = whole.select_rows(&known);
        let Some(inverse) = (&independent * independent.transpose()).try_inverse() else { return };
        let parts = whole.select_rows(&others) * independent.transpose() * inverse;
        let share = |(row, &other): (usize, &usize)| {
            let of = known.iter().enumerate().map(|(column, &known)| (normals[known], parts[(row, column)]));
            Share { row: normals[other], of: of.collect() }
        };
        let shares: Vec<Share> = others.iter().enumerate().map(share).collect();
        shares.iter().for_each(|share| gradient.row_mut(first + share.row).fill(0.0));
        (self.closed.shares, self.constant.shares) = (shares.clone(), shares);
    }

    /// The rows of the normals among the rows of the touches; empty if no contact slides with friction.
    fn normals(&self) -> Vec<usize> {
        let touches = &self.closed.touches;
        let rubs = |closed: &ClosedTouch<f64>| matches!(closed.friction, Friction::Slides { coefficient, .. } if coefficient != 0.0);
        if !touches.iter().any(rubs) {
            return Vec::new();
        }
        let mut next = 0;
        let first = |closed: &ClosedTouch<f64>| {
            let own = next;
            next += closed.rows();
            own
        };
        touches.iter().map(first).collect()
    }
}

impl Walk<'_> {
    /// Tells where contacts share their load otherwise as the motion goes on or a parameter changes: derivatives leave this out.
    pub(super) fn see_shares(&mut self, mode: &StepMode) {
        if mode.closed.shares.is_empty() {
            return;
        }
        let n = self.state.velocity.len();
        let first = mode.row_count - mode.closed.touch_rows();
        let mut changes = false;
        for (chunk, figures) in self.varied.chunks().iter().enumerate() {
            let offsets: Vec<Part> = (0..n).map(|row| with(0.0, &self.tangent.positions, row, chunk * WIDTH)).collect();
            let at = Instant { figures, state: &self.state, offsets: &offsets, closed: &mode.constant };
            let mut largest = 0.0_f64;
            let mut worst = 0.0_f64;
            for &freedom in &mode.free {
                let mut unit = vec![Part::zero(); n];
                unit[freedom] = Part::of(1.0);
                let rates = at.closure_rates(&unit);
                for share in &mode.closed.shares {
                    let sum = |sum: Part, &(row, part): &(usize, f64)| sum - rates[first + row].times(part);
                    let off = share.of.iter().fold(rates[first + share.row], sum);
                    let size = |of: &Part| of.parts.iter().fold(of.value.abs(), |most, part| most.max(part.abs()));
                    largest = largest.max(size(&rates[first + share.row]));
                    worst = worst.max(size(&off));
                }
            }
            changes |= worst > CHANGES * largest.max(1.0);
        }
        let said = "contacts share their load otherwise";
        if changes && !self.warnings.iter().any(|known| known.contains(said)) {
            let time = self.state.time;
            self.warnings.push(format!(
                "{said} as the motion goes on or a parameter changes, from t = {time:.6} s on: derivatives keep the shares of each step, and \
                 are off by the change of friction that comes of it"
            ));
        }
    }
}
