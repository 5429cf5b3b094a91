//! The operations of the elimination, one function each, compiled for the vectors on its own.

use crate::coupled::front::{Fronts, Screws, active};
use crate::coupled::mixing::Mixing;
use crate::coupled::system::{Coupled, Geometry, IMPLIED, PROXIMAL, Resistance, first_lane};
use crate::numbers::lanes::{Lanes, MAX_LANES, in_lanes};
use crate::plan::elimination::{Column, Operation, TWIST, Unknown};
use crate::plan::tree::Plan;

/// Beside a body that is lighter by 1e15, the rounding of a gradient leaves a mobility of 1e-32; this bound is above that.
const NOTHING: f64 = 1e-30;

impl<V: Lanes> Coupled<V> {
    /// Empties a front for a twist.
    pub(crate) fn open(&mut self, level: usize) {
        let fronts = &mut self.fronts;
        in_lanes!(V, fronts.open(level));
    }

    /// Clears the slots of multipliers that come in, and brings their right-hand sides.
    pub(crate) fn enter(&mut self, level: usize, slots: &[usize], present: &[usize], gaps: &[(usize, usize)]) {
        in_lanes!(V, {
            self.fronts.enter(level, slots, present);
            let right = self.fronts.right_hand_side();
            for &(row, slot) in gaps {
                let gap = self.gaps[row].to_array();
                for k in 0..active::<V>(self.mixing.active) {
                    self.fronts.block(level, slot, right)[k] = first_lane::<V>(-gap.as_ref()[k]);
                    if row >= self.mimic_rows.end {
                        self.fronts.add(level, slot, slot, k, self.unit[k]);
                    }
                }
            }
        });
    }

    /// Adds the mass block and the residual of a body, and its ends of loops: (row, slot, sign).
    pub(crate) fn own(&mut self, level: usize, body: usize, ends: &[(usize, usize, f64)]) {
        in_lanes!(V, {
            let right = self.fronts.right_hand_side();
            for component in 0..self.elimination.width {
                let bias = self.bias[body][component].to_array();
                let block = self.fronts.block(level, component, right);
                for (k, entry) in block.iter_mut().enumerate() {
                    *entry = *entry + first_lane::<V>(-bias.as_ref()[k]);
                }
            }
            for &end in ends {
                self.end(level, end);
            }
        });
    }

    /// One equation at one end of its loop: (row, slot, sign), or of a rope through several points (gradient, slot, sign).
    #[inline(always)]
    fn end(&mut self, level: usize, (row, slot, sign): (usize, usize, f64)) {
        let active = active::<V>(self.mixing.active);
        let mut by_gap = self.unit;
        if row >= self.mimic_rows.end && row < self.gaps.len() {
            let row = row - self.mimic_rows.end;
            match self.resistances.get(row) {
                Some(resistance) => (0..active).for_each(|k| by_gap[k] = self.resistance(resistance, k)),
                None => {
                    let friction = self.turning_friction[row - self.resistances.len()].to_array();
                    (0..active).for_each(|k| by_gap[k] = self.mixing.velocity[k] * V::splat(friction.as_ref()[k]));
                }
            }
        }
        let gradients = [0, 1].map(|side: usize| &self.gradients[row][side][..self.elimination.width]);
        couple(&mut self.fronts, level, [&by_gap[..active], &self.unit[..active]], slot, sign, gradients);
        if let Some(Some(rolling)) = self.rolling.get(row) {
            let step = V::splat(self.step);
            for (component, &change) in rolling[usize::from(sign > 0.0)].iter().enumerate() {
                let change = change * step;
                for (k, integral) in self.mixing.integral[..active].iter().enumerate() {
                    self.fronts.add(level, slot, component, k, change * *integral);
                }
            }
        }
    }

    /// Finds the mobilities of the equations that go at a body, among its ends of closures ([`crate::coupled::given`]): (row, slot, sign).
    pub(crate) fn scale_given<G: Geometry<V>>(
        &mut self,
        geometry: &G,
        start: &G::Start,
        body: usize,
        ends: &[(usize, usize, f64)],
    ) {
        for &(row, ..) in ends {
            if row < self.mimic_rows.end && self.elimination.given[row] {
                let leverage = geometry.leverage(start, body, &self.direction(row));
                self.scales[row] = (1.0 + leverage) * self.weights[body];
            }
        }
    }

    /// The pivot of a freedom.
    pub(crate) fn take_freedom(
        &mut self,
        level: usize,
        screws: &Screws<V>,
        freedom: usize,
        columns: &[Column],
        direct: &[(usize, usize, f64)],
    ) {
        self.screws[freedom] = screws.columns;
        in_lanes!(V, {
            self.fronts.take_freedom(level, screws, columns);
            self.take_efforts(freedom, direct);
        });
    }

    /// The pivot of a multiplier, with its proximal term.
    pub(crate) fn take_multiplier(
        &mut self,
        level: usize,
        row: usize,
        slot: usize,
        columns: &[Column],
        measure: &[(usize, usize)],
    ) {
        in_lanes!(V, {
            let (mut largest, mut of_all) = (0.0_f64, 0.0_f64);
            for &(row, slot) in measure {
                self.scales[row] = mobility(&mut self.fronts, level, slot, &self.mixing);
                of_all = of_all.max(self.scales[row]);
                if !self.known.is_empty(row) {
                    largest = largest.max(self.scales[row]);
                }
            }
            for &(row, _) in measure {
                let small = self.scales[row] <= PROXIMAL * of_all;
                self.references[row] = if small && of_all > 0.0 { of_all } else { self.scales[row] };
                if self.references[row] == 0.0 {
                    self.references[row] = 1.0;
                }
                // The equation is empty, so any scale except zero will do. A small mobility alone is no proof of that: a heavy body has one, beside a
                // light one.
                let empty = self.known.is_empty(row) && self.scales[row] <= PROXIMAL * largest;
                if empty || self.scales[row] <= NOTHING * largest {
                    self.scales[row] = if largest > 0.0 { largest } else { 1.0 };
                }
            }
            self.left_over[row] = mobility(&mut self.fronts, level, slot, &self.mixing) / self.references[row];
            self.fronts.take_multiplier(level, slot, columns);
            if row < self.mimic_rows.end {
                let proximal = match self.even[row] {
                    Some(even) => even,
                    None if self.known.is_borne(row) => IMPLIED * self.scales[row].max(self.adhering[row]),
                    None if self.known.is_implied(row) => IMPLIED * self.scales[row],
                    None => self.proximal * self.scales[row],
                };
                let proximal = V::splat(proximal);
                for k in 0..active::<V>(self.mixing.active) {
                    let pivot = self.fronts.pivot();
                    pivot[k] = self.mixing.solve[k].mul_add(proximal, pivot[k]);
                }
            }
        });
    }

    /// Adds the front of a level to the one below it, after clearing the slots that enter there.
    pub(crate) fn merge(
        &mut self,
        level: usize,
        slots: &[(usize, usize)],
        enter: &[usize],
        present: &[usize],
        twist: bool,
    ) {
        let fronts = &mut self.fronts;
        in_lanes!(V, {
            fronts.enter(level - 1, enter, present);
            fronts.merge(level, slots, twist);
        });
    }

    /// Eliminates the pivot of an operation.
    pub(crate) fn eliminate(&mut self, level: usize, operation: usize, columns: &[Column]) {
        let kept_at = self.kept_at[operation];
        let kept = &mut self.kept[kept_at..kept_at + (columns.len() + 1) * V::COUNT];
        let (fronts, inverse) = (&mut self.fronts, &mut self.pivots[operation]);
        in_lanes!(V, {
            fronts.eliminate(level, columns, kept);
            *inverse = fronts.pivot()[0];
        });
    }

    /// Adds the forces along the freedom itself: efforts, the resistance of joint springs and dampers, rotors, and mimics: (row, slot, coefficient).
    #[inline(always)]
    fn take_efforts(&mut self, freedom: usize, direct: &[(usize, usize, f64)]) {
        let active = active::<V>(self.mixing.active);
        let right = self.fronts.right_hand_side();
        let mut effort = self.efforts[freedom];
        for &(row, slot, coefficient) in direct {
            let coefficient = V::splat(coefficient);
            effort = self.multipliers[row].mul_add(coefficient, effort);
            for k in 0..active {
                let entry = self.unit[k] * coefficient;
                let left = self.fronts.left_block(slot);
                left[k] = left[k] + entry;
                let right = self.fronts.right_block(slot);
                right[k] = right[k] - entry;
            }
        }
        let effort = effort.to_array();
        for k in 0..active {
            let block = self.fronts.right_block(right);
            block[k] = block[k] + first_lane::<V>(effort.as_ref()[k]);
        }
        let besides = self.known.lent_to(freedom) + self.rotors[freedom];
        if besides != 0.0 {
            let besides = V::splat(besides);
            for k in 0..active {
                let entry = self.mixing.mass[k] * besides;
                let pivot = self.fronts.pivot();
                pivot[k] = pivot[k] + entry;
            }
        }
        let resistance = self.in_joints[freedom];
        if resistance != Resistance::default() {
            for k in 0..active {
                let entry = self.resistance(&resistance, k);
                let pivot = self.fronts.pivot();
                pivot[k] = pivot[k] + entry;
            }
        }
    }

    /// `−h² ∂F_k/∂y_i` of a row k, for a scalar y.
    #[inline(always)]
    fn resistance(&self, resistance: &Resistance, k: usize) -> V {
        let stiffness = V::splat(self.step * self.step * resistance.stiffness) * self.mixing.moved * self.unit[k];
        self.mixing.velocity[k].mul_add(V::splat(self.step * resistance.damping), stiffness)
    }

    /// The value of an eliminated unknown from the later ones; a freedom moves on the twist of its body.
    pub(crate) fn back_substitute(
        &mut self,
        tree: &Plan,
        operation: &Operation,
        kept_at: usize,
        columns: &[Column],
        increment: &mut [V],
    ) {
        in_lanes!(V, {
            if let Operation::Freedom { body, freedom, .. } = operation
                && *freedom == tree.bodies[*body].first_axis
            {
                self.twists[*body] = match tree.bodies[*body].parent {
                    Some(parent) => self.twists[parent],
                    None => [V::zero(); TWIST],
                };
            }
            let solution = self.substitute(kept_at, columns);
            match operation {
                Operation::Freedom { body, freedom, .. } => {
                    increment[*freedom] = solution;
                    let (twist, screw) = (&mut self.twists[*body], &self.screws[*freedom]);
                    for (twist, screw) in twist.iter_mut().zip(screw).take(self.elimination.width) {
                        *twist = screw.mul_add(solution, *twist);
                    }
                }
                Operation::Multiplier { row, .. } => self.multiplier_increments[*row] = solution,
                _ => {}
            }
        });
    }

    /// The value of an eliminated unknown from the later ones.
    #[inline(always)]
    fn substitute(&self, kept_at: usize, columns: &[Column]) -> V {
        let active = active::<V>(self.mixing.active);
        let mut sums = [V::zero(); MAX_LANES];
        for (number, column) in columns.iter().enumerate() {
            let value = match column.unknown {
                Unknown::Twist { body, component } => self.twists[body][component],
                Unknown::Multiplier(row) => self.multiplier_increments[row],
            };
            let kept = &self.kept[kept_at + number * V::COUNT..kept_at + (number + 1) * V::COUNT];
            for k in 0..active {
                sums[k] = kept[k].mul_add(value, sums[k]);
            }
        }
        let right = &self.kept[kept_at + columns.len() * V::COUNT..kept_at + (columns.len() + 1) * V::COUNT];
        let mut solution = V::zero_array();
        for k in 0..active {
            solution.as_mut()[k] = right[k].to_array().as_ref()[0] - sums[k].sum();
        }
        V::from_array(solution)
    }
}

/// Couples the multiplier in a slot to the twist of a body at one end of its loop. A closure's row is its gap alone; the row of a spring's tension is
/// the derivative by its length, `by_gap`.
#[inline(always)]
fn couple<V: Lanes>(
    fronts: &mut Fronts<V>,
    level: usize,
    [by_gap, unit]: [&[V]; 2],
    slot: usize,
    sign: f64,
    [columns, rows]: [&[V]; 2],
) {
    let sign = V::splat(sign);
    for (component, (&column, &row)) in columns.iter().zip(rows).enumerate() {
        let (column, row) = (column * sign, row * sign);
        for (k, (by_gap, unit)) in by_gap.iter().zip(unit).enumerate() {
            fronts.add(level, slot, component, k, column * *by_gap);
            fronts.add(level, component, slot, k, -(row * *unit));
        }
    }
}

/// The mobility of the equation in a slot under its own multiplier: the size of its block, over the size of Â.
#[inline(always)]
fn mobility<V: Lanes>(fronts: &mut Fronts<V>, level: usize, slot: usize, mixing: &Mixing<V>) -> f64 {
    let mut size = (V::zero(), V::zero());
    for (entry, solve) in fronts.block(level, slot, slot).iter().zip(&mixing.solve) {
        size = (size.0 + entry.max_abs(V::zero()), size.1 + solve.max_abs(V::zero()));
    }
    size.0.sum() / size.1.sum()
}
