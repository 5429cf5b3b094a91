//! Another right-hand side for a system of one configuration that has been factored: only the closures' gaps differ.
//!
//! The matrix of one stage is `[H −Jᵀ; J ε]`, which the elimination keeps symmetric but for the signs between twists and multipliers: the column `l`
//! of a pivot is `±` its row, `l_m = ± P Y_m`, so that the factors `Y` and `1/P` suffice,
//!
//! ```text
//!     z = rhs / P,        RHS_m ← RHS_m ∓ Y_m rhs
//! ```
//!
//! on the way in, with efforts along the freedoms if there are any, and on the way back the same as before.

use crate::coupled::system::{Coupled, One};
use crate::numbers::lanes::Lanes;
use crate::plan::elimination::{Column, Operation};
use crate::plan::tree::Plan;

impl Coupled<One> {
    /// Solves the system that was factored last with the present gaps, and with zero residuals of the bodies. Does not allocate.
    pub fn solve_again(&mut self, tree: &Plan, increment: &mut [One]) {
        let operations = std::mem::take(&mut self.elimination.operations);
        let (width, slots) = (self.elimination.width, self.elimination.slots);
        let (mut level, mut opened) = (0, false);
        for (index, operation) in operations.iter().enumerate() {
            let front = level * slots;
            match operation {
                Operation::Open => {
                    level += usize::from(opened);
                    opened = true;
                    self.right[level * slots..level * slots + width].fill(0.0);
                }
                Operation::Enter { slots, gaps, .. } => {
                    for &slot in slots {
                        self.right[front + slot] = 0.0;
                    }
                    for &(row, slot) in gaps {
                        self.right[front + slot] = -self.gaps[row].to_array()[0];
                    }
                }
                Operation::Own { .. } => {}
                Operation::Freedom { freedom, columns, .. } => {
                    let twist = self.right[front..front + width].iter().zip(&self.screws[*freedom]);
                    let right: f64 = twist.map(|(entry, screw)| entry * screw.to_array()[0]).sum();
                    let right = right + self.efforts[*freedom].to_array()[0];
                    self.forward(index, front, columns, right, |slot| slot < width);
                }
                Operation::Multiplier { slot, columns, .. } => {
                    let right = self.right[front + slot];
                    self.forward(index, front, columns, right, |slot| slot >= width);
                }
                Operation::Merge { slots: moved, enter, twist, .. } => {
                    let below = front - slots;
                    for &slot in enter {
                        self.right[below + slot] = 0.0;
                    }
                    let same = if *twist { width } else { 0 };
                    for (from, to) in (0..same).map(|slot| (slot, slot)).chain(moved.iter().copied()) {
                        self.right[below + to] += self.right[front + from];
                    }
                    level -= 1;
                }
            }
        }
        self.substitute_back(&operations, tree, increment);
        self.elimination.operations = operations;
    }

    /// Takes the right-hand side of a pivot to the columns that are left; `alike` are the slots of its own kind.
    fn forward(
        &mut self,
        operation: usize,
        front: usize,
        columns: &[Column],
        right: f64,
        alike: impl Fn(usize) -> bool,
    ) {
        let kept = &mut self.kept[self.kept_at[operation]..];
        for (column, factor) in columns.iter().zip(&*kept) {
            let change = factor.to_array()[0] * right;
            self.right[front + column.slot] -= if alike(column.slot) { change } else { -change };
        }
        kept[columns.len()] = self.pivots[operation] * One::splat(right);
    }
}
