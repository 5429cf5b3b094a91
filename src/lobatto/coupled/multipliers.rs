//! The closures' side of the coupled system: forces of the multipliers, and rates.

use crate::coupled::system::{Coupled, Geometry, ReevedEnd};
use crate::coupled::touching::Touching;
use crate::numbers::lanes::Lanes;
use crate::plan::elimination::TWIST;
use crate::stages::coefficients::row_stage;
use std::ops::Range;

impl<V: Lanes> Coupled<V> {
    /// Starts a step: all multipliers from zero.
    pub fn begin(&mut self) {
        self.multipliers.fill(V::zero());
    }

    /// Gaps and gradients of all loops.
    #[inline(always)]
    pub fn evaluate<G: Geometry<V>>(&mut self, geometry: &G) {
        geometry.evaluate(&self.rows_of_loop, &mut self.gaps, &mut self.gradients);
    }

    /// Reduces the gaps of contacts, or their rates, and slips that friction holds beside contacts that slide, to the part that motions can change, for these
    /// displacements since the start of the step.
    pub(crate) fn keep_gaps_of_motions<G: Geometry<V>>(
        &mut self,
        geometry: &G,
        plan: &G::Plan,
        start: &G::Start,
        displacement: &[V],
    ) {
        let Coupled { held, dependent, even, gradients, gaps, mixing, .. } = self;
        let gradient = |row: usize| gradients[row][0];
        let screw = |body, freedom| geometry.screws(plan, start, displacement, body, freedom).columns;
        held.iter_mut().for_each(|rows| rows.keep(mixing.active, gradient, gaps, screw));
        for (rows, weight) in dependent {
            rows.keep(mixing.active, gradient, gaps, screw);
            rows.rows().for_each(|row| even[row] = rows.is_implied().then_some(*weight));
        }
    }

    /// Shares the multipliers of contacts that imply each other as equal springs do, at every stage where they push.
    pub(crate) fn share_multipliers<G: Geometry<V>>(
        &mut self,
        geometry: &G,
        plan: &G::Plan,
        start: &G::Start,
        displacement: &[V],
    ) {
        let Coupled { dependent, gradients, multipliers, mixing, loops, elimination, .. } = self;
        let touching = geometry.touching();
        let first = *loops - touching.map_or(0, Touching::len);
        for (rows, _) in dependent {
            // Friction pushes beside the gradient of a gap.
            let gradient = |row: usize| match touching.zip(elimination.closure_of_row[row].checked_sub(first)) {
                Some((touching, number)) => touching.gradient_of_rows(number),
                None => gradients[row][1],
            };
            rows.share(mixing.active, gradient, multipliers, |body, freedom| {
                geometry.screws(plan, start, displacement, body, freedom).rows
            });
        }
    }

    /// The rows of the contacts, which come after the loops.
    pub(crate) fn rows_of_touches(&self, touching: &Touching<V>) -> &[Range<usize>] {
        &self.rows_of_loop[self.loops - touching.len()..self.loops]
    }

    /// How friction and rolling change as contacts move on, after [`Coupled::evaluate`]; whether a direction of friction lags behind its slip.
    pub(crate) fn turn(&mut self, touching: &mut Touching<V>) -> bool {
        let Coupled { loops, rows_of_loop, multipliers, turning_friction, rolling, gaps, .. } = self;
        let rows = &rows_of_loop[*loops - touching.len()..*loops];
        let rubbing = gaps.len() - turning_friction.len();
        touching.turn(rows, multipliers, [turning_friction, &mut gaps[rubbing..]], rolling)
    }

    /// The rows of the mimics.
    pub fn mimic_rows(&self) -> Range<usize> {
        self.mimic_rows.clone()
    }

    /// Lets the multipliers push on the bodies: `bias ← bias − Jᵀ λ`.
    #[inline(always)]
    pub fn push(&mut self) {
        for (ends, rows) in self.ends.iter().zip(&self.rows_of_loop[..self.loops]) {
            for row in rows.clone() {
                for (end, sign) in ends.iter().zip([1.0, -1.0]) {
                    if let Some(body) = *end {
                        let factor = self.multipliers[row] * V::splat(sign);
                        let gradient = &self.gradients[row][1][..self.elimination.width];
                        for (bias, direction) in self.bias[body].iter_mut().zip(gradient) {
                            *bias = direction.mul_add(factor, *bias);
                        }
                    }
                }
            }
        }
        for &ReevedEnd { row, gradient, body } in &self.reeved {
            let directions = &self.gradients[gradient][1][..self.elimination.width];
            for (bias, direction) in self.bias[body].iter_mut().zip(directions) {
                *bias = direction.neg_mul_add(self.multipliers[row], *bias);
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

    /// Adds the forces of a loop or contact on its second end at the rows' stages, in the order of their times, for a step of this length (s):
    /// `Σ_rows λ_k f_k h⁻²` (N), f the direction of a row.
    pub(crate) fn closure_forces(&self, closure: usize, step: f64, forces: &mut Vec<[f64; 3]>) {
        let (first, active) = (forces.len(), self.mixing.active);
        forces.resize(first + active, [0.0; 3]);
        for row in self.rows_of_loop[closure].clone() {
            let scaled = self.multipliers[row] * V::splat((step * step).recip());
            for axis in 0..3 {
                let along = (scaled * self.gradients[row][1][axis]).to_array();
                for (lane, along) in along.as_ref()[..active].iter().enumerate() {
                    forces[first + row_stage(lane, active)][axis] += along;
                }
            }
        }
    }

    /// The direction in which a multiplier pushes on the second end of its loop, in the first lane.
    pub fn direction(&self, row: usize) -> [f64; TWIST] {
        self.gradients[row][0].map(|lanes| lanes.to_array().as_ref()[0])
    }

    /// The twists of all bodies for rates of the freedoms, where the step starts.
    pub fn twists_of<G: Geometry<V>>(&mut self, geometry: &G, plan: &G::Plan, start: &G::Start, rates: &[f64]) {
        for (index, body) in G::tree(plan).bodies.iter().enumerate() {
            let mut twist = body.parent.map_or([V::zero(); TWIST], |parent| self.twists[parent]);
            for freedom in body.freedoms() {
                let screw = geometry.screws(plan, start, &[], index, freedom).columns;
                for (twist, screw) in twist.iter_mut().zip(screw).take(G::WIDTH) {
                    *twist = screw.mul_add(V::splat(rates[freedom]), *twist);
                }
            }
            self.twists[index] = twist;
        }
    }

    /// The rates of the gaps of all loops for the present twists, in place of the gaps.
    pub fn rates(&mut self) {
        for (ends, rows) in self.ends.iter().zip(&self.rows_of_loop) {
            for row in rows.clone() {
                let mut rate = V::zero();
                for (end, sign) in ends.iter().zip([-1.0, 1.0]) {
                    if let Some(body) = *end {
                        let directions = &self.gradients[row][0][..self.elimination.width];
                        for (direction, twist) in directions.iter().zip(&self.twists[body]) {
                            rate = (*direction * V::splat(sign)).mul_add(*twist, rate);
                        }
                    }
                }
                self.gaps[row] = rate;
            }
        }
        for &ReevedEnd { row, gradient, body } in &self.reeved {
            let directions = &self.gradients[gradient][0][..self.elimination.width];
            for (direction, twist) in directions.iter().zip(&self.twists[body]) {
                self.gaps[row] = direction.mul_add(*twist, self.gaps[row]);
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
