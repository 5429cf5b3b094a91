//! Fronts: dense blocks of the linear system, eliminated scalar unknown by scalar unknown, all stages of each at once.
//!
//! A front couples the twist of one body (6 slots) and some multipliers (a slot each). The entry of a row slot `m` and a
//! column slot `c` is an n × n matrix over the stages: row k, and the columns i as lanes. The last column is the right-hand
//! side, whose number for row k is in lane 0. Eliminating the unknown x with pivot `P`, row `r` and column `l`,
//!
//! ```text
//!     x = P⁻¹ (rhs − Σ_c r_c x_c) = z − Σ_c Y_c x_c,         F_mc ← F_mc − l_m Y_c
//! ```
//!
//! For a joint axis with screws `s_i = (p × z, z)` about the common origin, `P = s_kᵀ F s_i` and so on, and the twist of the body
//! is from then on that of its parent, `η_body = η_parent + s x` (method page of the project, newton.md §4c).

use super::elimination::{Column, TWIST};
use super::lanes::Lanes;

/// A stack of fronts of one size.
pub struct Fronts<V: Lanes> {
    /// Number of stages coupled.
    active: usize,
    /// Slots of a front, without the right-hand side.
    slots: usize,
    data: Vec<V>,
    /// Columns of the pivot, by slot: `[slot][k]`, lanes i.
    left: Vec<V>,
    /// Rows of the pivot, by slot, the right-hand side last.
    right: Vec<V>,
    /// The inverse of the pivot.
    inverse: [V; MAX],
}

/// Largest number of stages.
const MAX: usize = super::stage::MAX_LANES;

/// A screw at the rows' and at the columns' stages: linear part at the common origin, then direction.
#[derive(Clone, Copy)]
pub struct Screws<V> {
    /// At the rows' stages.
    pub rows: [V; TWIST],
    /// At the columns' stages.
    pub columns: [V; TWIST],
}

impl<V: Lanes> Fronts<V> {
    /// Room for `levels` fronts of `slots` slots with `active` stages.
    pub fn new(active: usize, slots: usize, levels: usize) -> Self {
        Fronts {
            active,
            slots,
            data: vec![V::zero(); levels * slots * (slots + 1) * active],
            left: vec![V::zero(); slots * active],
            right: vec![V::zero(); (slots + 1) * active],
            inverse: [V::zero(); MAX],
        }
    }

    /// The slot of the right-hand side.
    pub fn right_hand_side(&self) -> usize {
        self.slots
    }

    /// Where the block of a row slot and a column slot starts.
    #[inline(always)]
    fn at(&self, level: usize, row: usize, column: usize) -> usize {
        ((level * self.slots + row) * (self.slots + 1) + column) * self.active
    }

    /// The block of a row slot and a column slot: one vector a stage of the row.
    #[inline(always)]
    pub fn block(&mut self, level: usize, row: usize, column: usize) -> &mut [V] {
        let start = self.at(level, row, column);
        &mut self.data[start..start + self.active]
    }

    /// Empties the twist part of a front.
    #[inline(always)]
    pub fn open(&mut self, level: usize) {
        for row in 0..TWIST {
            for column in (0..TWIST).chain([self.slots]) {
                self.block(level, row, column).fill(V::zero());
            }
        }
    }

    /// Clears the rows and columns of slots that come into a front beside the `present` ones.
    #[inline(always)]
    pub fn enter(&mut self, level: usize, entering: &[usize], present: &[usize]) {
        let right = self.slots;
        for &slot in entering {
            for other in (0..TWIST).chain(present.iter().copied()).chain(entering.iter().copied()) {
                self.block(level, slot, other).fill(V::zero());
                self.block(level, other, slot).fill(V::zero());
            }
            self.block(level, slot, right).fill(V::zero());
        }
    }

    /// Adds the front of `level` to the one below it: the twist if `twist`, and the slots given as from and to.
    #[inline(always)]
    pub fn merge(&mut self, level: usize, slots: &[(usize, usize)], twist: bool) {
        let right = (self.slots, self.slots);
        let same = if twist { TWIST } else { 0 };
        let all = || (0..same).map(|slot| (slot, slot)).chain(slots.iter().copied());
        for (row_from, row_to) in all() {
            for (from, to) in all().chain([right]) {
                let (source, target) = (self.at(level, row_from, from), self.at(level - 1, row_to, to));
                for k in 0..self.active {
                    self.data[target + k] = self.data[target + k] + self.data[source + k];
                }
            }
        }
    }

    /// Gathers the pivot's column, row and block for a joint axis; `right` and `left` keep them.
    #[inline(always)]
    pub fn take_freedom(&mut self, level: usize, screws: &Screws<V>, columns: &[Column]) {
        let active = self.active;
        let row_screw: [V::Array; TWIST] = screws.rows.map(V::to_array);
        let mut pivot = [V::zero(); MAX];
        for column in (0..TWIST).chain([self.slots]) {
            for k in 0..active {
                let mut sum = V::zero();
                for (component, screw) in row_screw.iter().enumerate() {
                    sum = self.data[self.at(level, component, column) + k].mul_add(V::splat(screw.as_ref()[k]), sum);
                }
                self.right[column * active + k] = sum;
                if column < TWIST {
                    pivot[k] = sum.mul_add(screws.columns[column], pivot[k]);
                }
            }
        }
        for column in columns.iter().filter(|column| column.slot >= TWIST) {
            for k in 0..active {
                let mut sum = V::zero();
                for (component, screw) in row_screw.iter().enumerate() {
                    sum =
                        self.data[self.at(level, component, column.slot) + k].mul_add(V::splat(screw.as_ref()[k]), sum);
                }
                self.right[column.slot * active + k] = sum;
            }
        }
        for row in columns {
            for k in 0..active {
                let mut sum = V::zero();
                for component in 0..TWIST {
                    let entry = self.data[self.at(level, row.slot, component) + k];
                    sum = entry.mul_add(screws.columns[component], sum);
                }
                self.left[row.slot * active + k] = sum;
            }
        }
        self.inverse = pivot;
    }

    /// The pivot's row before the elimination: a stage's entry of a column slot.
    #[inline(always)]
    pub fn right_block(&mut self, slot: usize) -> &mut [V] {
        &mut self.right[slot * self.active..(slot + 1) * self.active]
    }

    /// The pivot's column before the elimination: a stage's entry of a row slot.
    #[inline(always)]
    pub fn left_block(&mut self, slot: usize) -> &mut [V] {
        &mut self.left[slot * self.active..(slot + 1) * self.active]
    }

    /// The pivot itself.
    #[inline(always)]
    pub fn pivot(&mut self) -> &mut [V] {
        &mut self.inverse[..self.active]
    }

    /// Gathers the pivot's column, row and block for the multiplier in a slot.
    #[inline(always)]
    pub fn take_multiplier(&mut self, level: usize, slot: usize, columns: &[Column]) {
        let active = self.active;
        for other in columns.iter().map(|column| column.slot).chain([self.slots]) {
            let source = self.at(level, slot, other);
            self.right[other * active..(other + 1) * active].copy_from_slice(&self.data[source..source + active]);
        }
        for row in columns {
            let source = self.at(level, row.slot, slot);
            self.left[row.slot * active..(row.slot + 1) * active].copy_from_slice(&self.data[source..source + active]);
        }
        let source = self.at(level, slot, slot);
        self.inverse[..active].copy_from_slice(&self.data[source..source + active]);
    }

    /// Eliminates the gathered pivot from the front; writes `Y_c` of the columns and then `z` to `kept`.
    #[inline(always)]
    pub fn eliminate(&mut self, level: usize, columns: &[Column], kept: &mut [V]) {
        let active = self.active;
        invert(&mut self.inverse, active);
        let mut inverse = [V::zero_array(); MAX];
        for (array, row) in inverse.iter_mut().zip(&self.inverse[..active]) {
            *array = row.to_array();
        }
        for (number, slot) in columns.iter().map(|column| column.slot).chain([self.slots]).enumerate() {
            let right = &self.right[slot * active..(slot + 1) * active];
            let target = &mut kept[number * active..(number + 1) * active];
            for (row, out) in inverse[..active].iter().zip(target) {
                let mut sum = V::zero();
                for (&factor, &entry) in row.as_ref()[..active].iter().zip(right) {
                    sum = entry.mul_add(V::splat(factor), sum);
                }
                *out = sum;
            }
        }
        for row in columns {
            let mut left = [V::zero_array(); MAX];
            for (array, entry) in left.iter_mut().zip(&self.left[row.slot * active..(row.slot + 1) * active]) {
                *array = entry.to_array();
            }
            for (number, slot) in columns.iter().map(|column| column.slot).chain([self.slots]).enumerate() {
                let start = self.at(level, row.slot, slot);
                let right = &kept[number * active..(number + 1) * active];
                for (entry, factors) in self.data[start..start + active].iter_mut().zip(&left) {
                    let mut sum = *entry;
                    for (&factor, &value) in factors.as_ref()[..active].iter().zip(right) {
                        sum = value.neg_mul_add(V::splat(factor), sum);
                    }
                    *entry = sum;
                }
            }
        }
    }
}

/// Replaces an n × n matrix (rows, columns as lanes) by its inverse: Gauss–Jordan with row exchanges.
#[inline(always)]
fn invert<V: Lanes>(matrix: &mut [V; MAX], active: usize) {
    let mut inverse = [V::zero(); MAX];
    for (k, row) in inverse[..active].iter_mut().enumerate() {
        let mut unit = V::zero_array();
        unit.as_mut()[k] = 1.0;
        *row = V::from_array(unit);
    }
    for pivot in 0..active {
        let size = |row: &V| row.to_array().as_ref()[pivot].abs();
        let mut best = pivot;
        for row in pivot + 1..active {
            if size(&matrix[row]) > size(&matrix[best]) {
                best = row;
            }
        }
        matrix.swap(pivot, best);
        inverse.swap(pivot, best);
        let factor = V::splat(1.0 / matrix[pivot].to_array().as_ref()[pivot]);
        matrix[pivot] = matrix[pivot] * factor;
        inverse[pivot] = inverse[pivot] * factor;
        for row in (0..active).filter(|&row| row != pivot) {
            let factor = V::splat(matrix[row].to_array().as_ref()[pivot]);
            matrix[row] = matrix[pivot].neg_mul_add(factor, matrix[row]);
            inverse[row] = inverse[pivot].neg_mul_add(factor, inverse[row]);
        }
    }
    *matrix = inverse;
}
