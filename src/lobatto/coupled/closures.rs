//! The closures' side of the coupled system: gaps and gradients, what the multipliers push with, and rates.

use super::Coupled;
use crate::lobatto::algebra::Vector;
use crate::lobatto::closure::{EquationValue, evaluate};
use crate::lobatto::elimination::TWIST;
use crate::lobatto::lanes::Lanes;
use crate::lobatto::start::{Plan, Start};

impl<V: Lanes> Coupled<V> {
    /// Gaps and gradients of all loops.
    #[inline(always)]
    pub fn evaluate_closures(&mut self) {
        for (ends, rows) in self.ends.iter().zip(&self.rows_of_loop) {
            let mut out = [EquationValue::zero(); 6];
            for side in 0..2 {
                let moved = [0, 1].map(|end: usize| ends[end].body.map(|body| &self.moved[body][side]));
                evaluate(&self.equations[rows.clone()], ends, moved, &mut out[..rows.len()]);
                for (value, out) in self.values[rows.clone()].iter_mut().zip(&out) {
                    value[side] = *out;
                }
            }
            for (gap, value) in self.gaps[rows.clone()].iter_mut().zip(&self.values[rows.clone()]) {
                *gap = value[0].gap;
            }
        }
    }

    /// The rows of the mimics.
    pub fn mimic_rows(&self) -> std::ops::Range<usize> {
        let first = self.rows_of_loop[..self.loops].last().map_or(0, |rows| rows.end);
        first..self.equations.len() - self.resistances.len()
    }

    /// Lets the multipliers push on the bodies: `bias ← bias − Jᵀ λ`.
    #[inline(always)]
    pub fn push(&mut self) {
        for (ends, rows) in self.ends.iter().zip(&self.rows_of_loop[..self.loops]) {
            for row in rows.clone() {
                let value = &self.values[row][1];
                for (end, sign) in ends.iter().zip([1.0, -1.0]) {
                    if let Some(body) = end.body {
                        let factor = self.multipliers[row] * V::splat(sign);
                        let (force, torque) = self.bias[body];
                        self.bias[body] =
                            (value.force.times_plus(factor, force), value.torque.times_plus(factor, torque));
                    }
                }
            }
        }
    }

    /// For every equation the closure it belongs to.
    pub fn closure_of_row(&self) -> &[usize] {
        &self.elimination.closure_of_row
    }

    /// The latest increments of the multipliers.
    pub fn multiplier_increments(&self) -> &[V] {
        &self.multiplier_increments
    }

    /// The direction in which a multiplier pushes on the second end of its loop: force, and torque about the common origin;
    /// the first lane.
    pub fn direction(&self, row: usize) -> ([f64; 3], [f64; 3]) {
        let value = &self.values[row][0];
        let first = |vector: Vector<V>| vector.0.map(|lanes| lanes.to_array().as_ref()[0]);
        (first(value.force), first(value.torque))
    }

    /// Where the second end of a loop is at the start, from the common origin (m).
    pub fn end_point(&self, closure: usize) -> [f64; 3] {
        self.ends[closure][1].point
    }

    /// The twists of all bodies for rates of the freedoms, where the step starts.
    pub fn twists_of(&mut self, plan: &Plan, start: &Start, rates: &[f64]) {
        for body in 0..plan.bodies.len() {
            let parent = plan.bodies[body].parent;
            let mut twist = parent.map_or([V::zero(); TWIST], |parent| self.twists[parent]);
            for freedom in plan.bodies[body].freedoms() {
                let screw = self.screws_of(plan, start, &[], body, freedom).columns;
                for (twist, screw) in twist.iter_mut().zip(screw) {
                    *twist = screw.mul_add(V::splat(rates[freedom]), *twist);
                }
            }
            self.twists[body] = twist;
        }
    }

    /// The rates of the gaps of all loops for the present twists, in place of the gaps.
    pub fn rates(&mut self) {
        for (ends, rows) in self.ends.iter().zip(&self.rows_of_loop) {
            for row in rows.clone() {
                let value = &self.values[row][0];
                let mut rate = V::zero();
                for (end, sign) in ends.iter().zip([-1.0, 1.0]) {
                    if let Some(body) = end.body {
                        let directions = value.force.0.into_iter().chain(value.torque.0);
                        for (direction, twist) in directions.zip(self.twists[body]) {
                            rate = (direction * V::splat(sign)).mul_add(twist, rate);
                        }
                    }
                }
                self.gaps[row] = rate;
            }
        }
    }

    /// Adds the latest increments to the multipliers.
    #[inline(always)]
    pub fn advance_multipliers(&mut self) {
        for (multiplier, increment) in self.multipliers.iter_mut().zip(&self.multiplier_increments) {
            *multiplier = *multiplier + *increment;
        }
    }
}
