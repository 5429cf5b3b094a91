//! Fronts: dense blocks of the linear system, eliminated scalar unknown by scalar unknown, all stages of each at once.
//!
//! A front couples the twist of one body (6 slots, 3 in a plane) and some multipliers (a slot each). The entry of a row slot `m` and a
//! column slot `c` is an n × n matrix over the stages: row k, and the columns i as lanes. The last column is the right-hand
//! side, whose number for row k is in lane 0. Eliminating the unknown x with pivot `P`, row `r` and column `l`,
//!
//! ```text
//!     x = P⁻¹ (rhs − Σ_c r_c x_c) = z − Σ_c Y_c x_c,         F_mc ← F_mc − l_m Y_c
//! ```
//!
//! A joint axis has screws `s_i` (`(p × z, z)` in space) about the common origin, and `P = s_kᵀ F s_i` and so on. After its elimination the twist of
//! the body is the twist of its parent, `η_body = η_parent + s x`.

use crate::numbers::lanes::Lanes;
use crate::plan::elimination::{Column, Elimination, TWIST};

/// A stack of fronts of one size.
#[derive(Clone)]
pub struct Fronts<V: Lanes> {
    /// Number of stages coupled.
    active: usize,
    /// Slots of the twist.
    width: usize,
    /// Slots of a front, without the right-hand side.
    slots: usize,
    data: Vec<V>,
    /// Columns of the pivot, by slot: `[slot][k]`, lanes i.
    left: Vec<V>,
    /// Rows of the pivot, by slot, the right-hand side last: `COUNT` vectors each, with zeros above the stages in use.
    right: Vec<V>,
    /// The inverse of the pivot.
    inverse: [V; MAX],
}

/// Number of stages coupled, of so many: a constant for one lane.
#[inline(always)]
pub(crate) fn active<V: Lanes>(count: usize) -> usize {
    if V::COUNT == 1 { 1 } else { count }
}

/// The same where a caller knows that all lanes of the vectors are `FULL`: a constant then as well.
#[inline(always)]
fn stages<V: Lanes, const FULL: bool>(count: usize) -> usize {
    if FULL { V::COUNT } else { active::<V>(count) }
}

/// Vectors of more lanes have loops over stages, full or not: they are too long to be without.
const SHORT: usize = 4;

/// Largest number of stages.
const MAX: usize = crate::numbers::lanes::MAX_LANES;

/// A screw at the rows' and at the columns' stages: linear part at the common origin, then direction, in the first components.
#[derive(Clone, Copy, Debug)]
pub struct Screws<V> {
    /// At the rows' stages.
    pub rows: [V; TWIST],
    /// At the columns' stages.
    pub columns: [V; TWIST],
}

impl<V: Lanes> Fronts<V> {
    /// Room for the fronts of an elimination with `active` stages.
    pub fn new(active: usize, elimination: &Elimination) -> Self {
        let Elimination { width, slots, levels, .. } = *elimination;
        Fronts {
            active,
            width,
            slots,
            data: vec![V::zero(); levels * slots * (slots + 1) * active],
            left: vec![V::zero(); slots * active],
            right: vec![V::zero(); (slots + 1) * V::COUNT],
            inverse: [V::zero(); MAX],
        }
    }

    /// Number of stages coupled: a constant for one lane, so that no loop over stages is left.
    #[inline(always)]
    fn active(&self) -> usize {
        active::<V>(self.active)
    }

    /// The slot of the right-hand side.
    pub fn right_hand_side(&self) -> usize {
        self.slots
    }

    /// Start of the block of a row slot and a column slot.
    #[inline(always)]
    fn at(&self, level: usize, row: usize, column: usize) -> usize {
        ((level * self.slots + row) * (self.slots + 1) + column) * self.active()
    }

    /// The block of a row slot and a column slot: one vector a stage of the row.
    #[inline(always)]
    pub fn block(&mut self, level: usize, row: usize, column: usize) -> &mut [V] {
        let start = self.at(level, row, column);
        let active = self.active();
        &mut self.data[start..start + active]
    }

    /// Adds to the entry of a row slot, its stage k, and a column slot.
    #[inline(always)]
    pub fn add(&mut self, level: usize, row: usize, column: usize, k: usize, value: V) {
        let index = self.at(level, row, column) + k;
        self.data[index] = self.data[index] + value;
    }

    /// Empties the twist part of a front.
    #[inline(always)]
    pub fn open(&mut self, level: usize) {
        for row in 0..self.width {
            for column in (0..self.width).chain([self.slots]) {
                self.block(level, row, column).fill(V::zero());
            }
        }
    }

    /// Clears the rows and columns of slots that come into a front beside the `present` ones.
    #[inline(always)]
    pub fn enter(&mut self, level: usize, entering: &[usize], present: &[usize]) {
        let right = self.slots;
        for &slot in entering {
            for other in (0..self.width).chain(present.iter().copied()).chain(entering.iter().copied()) {
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
        let same = if twist { self.width } else { 0 };
        let all = || (0..same).map(|slot| (slot, slot)).chain(slots.iter().copied());
        for (row_from, row_to) in all() {
            for (from, to) in all().chain([right]) {
                let (source, target) = (self.at(level, row_from, from), self.at(level - 1, row_to, to));
                for k in 0..self.active() {
                    self.data[target + k] = self.data[target + k] + self.data[source + k];
                }
            }
        }
    }

    /// Gathers the pivot's column, row and block for a joint axis; `right` and `left` keep them.
    #[inline(always)]
    pub fn take_freedom(&mut self, level: usize, screws: &Screws<V>, columns: &[Column]) {
        match (self.width, self.is_full()) {
            (3, false) => self.take_screw::<3, false>(level, screws, columns),
            (3, true) => self.take_screw::<3, true>(level, screws, columns),
            (_, false) => self.take_screw::<TWIST, false>(level, screws, columns),
            (_, true) => self.take_screw::<TWIST, true>(level, screws, columns),
        }
    }

    /// Whether short vectors are full of stages.
    #[inline(always)]
    fn is_full(&self) -> bool {
        V::COUNT <= SHORT && self.active == V::COUNT
    }

    /// [`Fronts::take_freedom`] with twists of `W` components.
    #[inline(always)]
    fn take_screw<const W: usize, const FULL: bool>(&mut self, level: usize, screws: &Screws<V>, columns: &[Column]) {
        let active = stages::<V, FULL>(self.active);
        let mut row_screw = [V::zero_array(); W];
        for component in 0..W {
            row_screw[component] = screws.rows[component].to_array();
        }
        let mut pivot = [V::zero(); MAX];
        for slot in 0..W {
            self.take_row::<W, FULL>(level, &row_screw, slot);
            for k in 0..active {
                pivot[k] = self.right[slot * V::COUNT + k].mul_add(screws.columns[slot], pivot[k]);
            }
        }
        self.take_row::<W, FULL>(level, &row_screw, self.slots);
        for column in columns {
            if column.slot >= W {
                self.take_row::<W, FULL>(level, &row_screw, column.slot);
            }
            let start = self.at(level, column.slot, 0);
            let row = &self.data[start..start + W * active];
            let left = &mut self.left[column.slot * active..(column.slot + 1) * active];
            for k in 0..active {
                let mut sum = row[k] * screws.columns[0];
                for component in 1..W {
                    sum = row[component * active + k].mul_add(screws.columns[component], sum);
                }
                left[k] = sum;
            }
        }
        self.inverse[..active].copy_from_slice(&pivot[..active]);
    }

    /// One column of the pivot's row: the twist's rows of that column, projected on the joint axis.
    #[inline(always)]
    fn take_row<const W: usize, const FULL: bool>(&mut self, level: usize, screw: &[V::Array; W], slot: usize) {
        let active = stages::<V, FULL>(self.active);
        let right = &mut self.right[slot * V::COUNT..slot * V::COUNT + active];
        right.fill(V::zero());
        for component in 0..W {
            let start = ((level * self.slots + component) * (self.slots + 1) + slot) * active;
            let block = &self.data[start..start + active];
            let factors = screw[component].as_ref();
            for k in 0..active {
                right[k] = block[k].mul_add(V::splat(factors[k]), right[k]);
            }
        }
    }

    /// The pivot's row before the elimination: a stage's entry of a column slot.
    #[inline(always)]
    pub fn right_block(&mut self, slot: usize) -> &mut [V] {
        let active = self.active();
        &mut self.right[slot * V::COUNT..slot * V::COUNT + active]
    }

    /// The pivot's column before the elimination: a stage's entry of a row slot.
    #[inline(always)]
    pub fn left_block(&mut self, slot: usize) -> &mut [V] {
        let active = self.active();
        &mut self.left[slot * active..(slot + 1) * active]
    }

    /// The pivot itself; its inverse once it is eliminated.
    #[inline(always)]
    pub fn pivot(&mut self) -> &mut [V] {
        let active = self.active();
        &mut self.inverse[..active]
    }

    /// Gathers the pivot's column, row and block for the multiplier in a slot.
    #[inline(always)]
    pub fn take_multiplier(&mut self, level: usize, slot: usize, columns: &[Column]) {
        let active = self.active();
        for other in columns.iter().map(|column| column.slot).chain([self.slots]) {
            let source = self.at(level, slot, other);
            self.right[other * V::COUNT..other * V::COUNT + active]
                .copy_from_slice(&self.data[source..source + active]);
        }
        for row in columns {
            let source = self.at(level, row.slot, slot);
            self.left[row.slot * active..(row.slot + 1) * active].copy_from_slice(&self.data[source..source + active]);
        }
        let source = self.at(level, slot, slot);
        self.inverse[..active].copy_from_slice(&self.data[source..source + active]);
    }

    /// Eliminates the gathered pivot from the front; writes `Y_c` of the columns and then `z` to `kept`, `COUNT` vectors each, which keep zeros above
    /// the stages in use.
    #[inline(always)]
    pub fn eliminate(&mut self, level: usize, columns: &[Column], kept: &mut [V]) {
        if self.is_full() {
            self.eliminate_stages::<true>(level, columns, kept);
        } else {
            self.eliminate_stages::<false>(level, columns, kept);
        }
    }

    /// [`Fronts::eliminate`] for all stages of a full vector, or for those in use.
    #[inline(always)]
    fn eliminate_stages<const FULL: bool>(&mut self, level: usize, columns: &[Column], kept: &mut [V]) {
        let active = stages::<V, FULL>(self.active);
        invert(&mut self.inverse, active);
        let mut inverse = [V::zero_array(); MAX];
        for k in 0..active {
            inverse[k] = self.inverse[k].to_array();
        }
        for number in 0..=columns.len() {
            let slot = columns.get(number).map_or(self.slots, |column| column.slot);
            let right = &self.right[slot * V::COUNT..(slot + 1) * V::COUNT];
            let target = &mut kept[number * V::COUNT..(number + 1) * V::COUNT];
            for k in 0..active {
                let factors = inverse[k].as_ref();
                let mut sum = right[0] * V::splat(factors[0]);
                for i in 1..V::COUNT {
                    sum = right[i].mul_add(V::splat(factors[i]), sum);
                }
                target[k] = sum;
            }
        }
        let mut left = [V::zero_array(); MAX];
        for row in columns {
            for k in 0..active {
                left[k] = self.left[row.slot * active + k].to_array();
            }
            let row_start = self.at(level, row.slot, 0);
            for number in 0..=columns.len() {
                let slot = columns.get(number).map_or(self.slots, |column| column.slot);
                let start = row_start + slot * active;
                let block = &mut self.data[start..start + active];
                let solved = &kept[number * V::COUNT..(number + 1) * V::COUNT];
                for k in 0..active {
                    let factors = left[k].as_ref();
                    let mut sum = block[k];
                    for i in 0..V::COUNT {
                        sum = solved[i].neg_mul_add(V::splat(factors[i]), sum);
                    }
                    block[k] = sum;
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
        let (mut best, mut largest) = (pivot, matrix[pivot].to_array().as_ref()[pivot].abs());
        for row in pivot + 1..active {
            let size = matrix[row].to_array().as_ref()[pivot].abs();
            if size > largest {
                (best, largest) = (row, size);
            }
        }
        matrix.swap(pivot, best);
        inverse.swap(pivot, best);
        let factor = V::splat(1.0 / matrix[pivot].to_array().as_ref()[pivot]);
        matrix[pivot] = matrix[pivot] * factor;
        inverse[pivot] = inverse[pivot] * factor;
        for row in 0..active {
            if row == pivot {
                continue;
            }
            let factor = V::splat(matrix[row].to_array().as_ref()[pivot]);
            matrix[row] = matrix[pivot].neg_mul_add(factor, matrix[row]);
            inverse[row] = inverse[pivot].neg_mul_add(factor, inverse[row]);
        }
    }
    matrix[..active].copy_from_slice(&inverse[..active]);
}
