//! Iterations that keep the factors of an earlier one.
//!
//! A chord method: the residual `ρ_k` has the geometry of the iterate, and so have the axes `s` and arms along which it gathers; a joint's part of it
//! is divided by the inertia of an earlier iterate `q⁰`,
//!
//! ```text
//!     H(q⁰_k) α_k = −ρ_k(q):     α₀ = (τ − sᵀ p)/d⁰,   p ← p + (A s)⁰ α₀,      d⁰ = s⁰ᵀ A⁰ s⁰ + κ
//! ```
//!
//! (symbols as in [`crate::stages::articulated`]), so that a solution is a solution, and the work on the articulated inertias, a third of an
//! iteration, is left out. The inertia changes by the increments: where these are small the iteration converges as before. If the masses of a tree
//! differ by thousands, increments that look small change `H` along the heavy directions by more than its light ones are; [`Chord`] finds out and
//! keeps factors later. Source: C. T. Kelley, Iterative Methods for Linear and Nonlinear Equations (1995), section 5.4.

use crate::equations::pivot::pivot_torque;
use crate::equations::residual::{body_residual, force_residual};
use crate::numbers::algebra::Vector;
use crate::numbers::arithmetic::{Arithmetic, Numbers};
use crate::numbers::rotations::tilted_by;
use crate::plan::tree::Plan;
use crate::solve::sweeps::slide_axis;
use crate::stages::articulated::{Eliminated, Push};
use crate::stages::factors::Factors;
use crate::stages::row_geometry::LookAhead;
use crate::stages::rows::Rows;
use crate::stages::start::{BodyStart, Start};
use crate::stages::workspace::Stages;
use catena_mechanism::description::joint::FreeRotation;

/// When to keep the factors.
#[derive(Clone, Copy, Debug)]
pub struct Chord {
    /// Factors are kept where the last increment is below this (rad, m).
    below: f64,
    /// The last increment of this step.
    last: f64,
    /// Whether the last iteration kept its factors.
    kept: bool,
    /// Whether keeping them was seen to be a loss in this step.
    lost: bool,
    /// Iterations that kept theirs since somebody asked.
    count: usize,
}

impl Chord {
    /// Before the first step.
    pub const NEW: Chord = Chord { below: SMALL, last: f64::INFINITY, kept: false, lost: false, count: 0 };

    /// A new step, or another guess: no factors.
    pub fn restart(&mut self) {
        (self.last, self.kept, self.lost) = (f64::INFINITY, false, false);
        self.below = (self.below * SOONER).min(SMALL);
    }

    /// Another solution of a step that has just been solved, and whose factors may be kept if there are any.
    pub fn begin_with(&mut self, factors: bool) {
        *self = Chord { last: if factors { 0.5 * SMALL } else { f64::INFINITY }, ..Chord::NEW };
    }

    /// Whether the next iteration keeps the factors of the last one.
    pub fn keeps(&mut self) -> bool {
        self.kept = !self.lost && self.last < self.below;
        self.count += usize::from(self.kept);
        self.kept
    }

    /// How many iterations have kept their factors since this was asked last.
    pub fn take_count(&mut self) -> usize {
        std::mem::take(&mut self.count)
    }

    /// Takes note of an increment.
    pub fn see(&mut self, increment: f64) {
        if self.kept && increment > SLOW * self.last && increment > SETTLED {
            self.lost = true;
            self.below *= LATER;
        }
        self.last = increment;
    }
}

/// Below this (rad, m) increments change an inertia little.
const SMALL: f64 = 0.1;
/// An increment that is a larger part of the one before, with kept factors, shows that they were kept too early.
const SLOW: f64 = 0.5;
/// Increments below this are rounding, and do not show that.
const SETTLED: f64 = 1e-11;
/// The bound for keeping factors falls by this factor then.
const LATER: f64 = 0.1;
/// The bound grows by this factor in every later step.
const SOONER: f64 = 1.2;

/// The wrench that a body hands to its parent, about the parent's anchor.
#[derive(Clone, Copy)]
struct Wrench<V> {
    force: Vector<V>,
    torque: Vector<V>,
}

impl<V: Arithmetic> Wrench<V> {
    /// Removes a joint's part along an axis of which the wrench is `load` (minus the push).
    #[inline(always)]
    fn relieve(&mut self, axis: Vector<V>, load: V, joint: &mut Eliminated<V>) {
        joint.axis = axis;
        joint.bias = -(load * joint.inverse);
        self.force = joint.force_ratio.times_minus(load, self.force);
        self.torque = joint.torque_ratio.times_minus(load, self.torque);
    }
}

impl<V: Numbers> Stages<V> {
    /// Residual of all rows, leaf to root, after [`Stages::sweep_poses`], with the factors of the last [`Stages::sweep_residual`];
    /// `REFINED` with twice the digits of the coefficients, for the last iterations of a step that is iterated to rounding.
    #[inline(always)]
    pub fn sweep_wrenches<const REFINED: bool>(&mut self, gravity: &[f64; 3]) {
        let (factors, rows, early) = self.rows::<REFINED, false>(gravity);
        factors.gather(rows.plan, rows.start, &rows, early);
    }

    /// [`Stages::sweep_wrenches`] of a mechanism with forces, after [`Stages::sweep_applied`].
    #[inline(always)]
    pub fn sweep_forced_wrenches(&mut self, gravity: &[f64; 3]) {
        let (factors, rows, early) = self.rows::<true, true>(gravity);
        factors.gather(rows.plan, rows.start, &rows, early);
    }
}

impl<V: Arithmetic> Factors<V> {
    /// Leaf to root, in the order of [`Factors::eliminate`].
    #[inline(always)]
    pub(crate) fn gather<R: Rows<V>>(
        &mut self,
        plans: &Plan,
        start: &Start<V::Real>,
        rows: &R,
        early: &mut LookAhead<V, R::Ahead>,
    ) {
        early.prepare(plans, start, rows, plans.bodies.len());
        for index in (0..plans.bodies.len()).rev() {
            early.prepare(plans, start, rows, index);
            let plan = &plans.bodies[index];
            let known = &start.bodies[index];
            let rotations = plan.first_axis + plan.translations;
            if let Some(pivot) = plan.pivot {
                let axis = Vector::splat(&start.axes[rotations]);
                let torque =
                    pivot_torque(rows, index, &start.pivots[pivot], &start.axes[rotations], start.rates[rotations]);
                let mut load = axis.dot_plus(self.slots[plans.below(index)].torque, torque);
                if let Some((_, carried)) = rows.carried(index) {
                    load = axis.dot_plus(carried, load);
                }
                let joint = &mut self.eliminated[rotations];
                joint.axis = axis;
                joint.bias = -(load * joint.inverse);
                continue;
            }
            let mut total = if plan.slides {
                let force = force_residual(rows, index, known, rows.pose(index).anchor);
                self.with_rest(plans, index, rows, Wrench { force, torque: Vector::zero() })
            } else {
                let own = body_residual(rows, index, plan, known, early);
                let mut total = self.with_rest(plans, index, rows, Wrench { force: own.force, torque: own.torque });
                if plan.rotation == FreeRotation::AboutZ {
                    let axis = Vector::splat(&start.axes[rotations]);
                    let axis = own.turn.apply_plus(axis, axis);
                    let load = less_push(axis.dot(total.torque), rows.push(rotations));
                    total.relieve(axis, load, &mut self.eliminated[rotations]);
                    if plan.translations == 0 {
                        self.pass_up(plans, index, known, rows, total);
                        continue;
                    }
                } else if plan.rotation == FreeRotation::Ball {
                    let tilt = rows.tilt(rotations);
                    for freedom in (rotations..rotations + 3).rev() {
                        let axis = Vector::splat(&start.axes[freedom]);
                        let axis = tilted_by(tilt, axis);
                        let axis = own.turn.apply_plus(axis, axis);
                        let load = less_push(axis.dot(total.torque), rows.push(freedom));
                        total.relieve(axis, load, &mut self.eliminated[freedom]);
                    }
                }
                total
            };
            for freedom in (plan.first_axis..rotations).rev() {
                let axis = slide_axis(rows, plan, &start.axes[freedom]);
                let load = less_push(axis.dot(total.force), rows.push(freedom));
                total.relieve(axis, load, &mut self.eliminated[freedom]);
            }
            self.pass_up(plans, index, known, rows, total);
        }
    }

    /// The wrench of a body with the forces besides gravity, its own part, and the parts of its children.
    #[inline(always)]
    fn with_rest<R: Rows<V>>(&self, plans: &Plan, body: usize, rows: &R, mut own: Wrench<V>) -> Wrench<V> {
        if let Some((force, torque)) = rows.wrench(body) {
            own.force = force.times_minus(rows.forces(), own.force);
            own.torque = torque.times_minus(rows.forces(), own.torque);
        }
        if let Some((momentum, moment)) = rows.carried(body) {
            own.force = own.force.plus(momentum);
            own.torque = own.torque.plus(moment);
        }
        let below = &self.slots[plans.below(body)];
        Wrench { force: own.force.plus(below.force), torque: own.torque.plus(below.torque) }
    }

    /// Moves a body's remaining wrench to its parent's anchor, and hands it over, if it has a parent.
    #[inline(always)]
    fn pass_up<R: Rows<V>>(
        &mut self,
        plans: &Plan,
        body: usize,
        known: &BodyStart<V::Real>,
        rows: &R,
        mut left: Wrench<V>,
    ) {
        let plan = &plans.bodies[body];
        if let Some(parent) = plan.turning_parent() {
            let arm = self.reach(parent, body, known, rows);
            left.torque = arm.cross_plus(left.force, left.torque);
        }
        let Some(parent) = plan.parent else { return };
        let slot = &mut self.slots[plans.below(parent)];
        if !plan.first_collected {
            left = Wrench { force: slot.force.plus(left.force), torque: slot.torque.plus(left.torque) };
        }
        (slot.force, slot.torque) = (left.force, left.torque);
    }
}

/// The load of an axis, less the forces in the joint, if there are any. Written out, because closures over vectors are not inlined.
#[inline(always)]
pub(crate) fn less_push<V: Arithmetic>(load: V, push: Option<Push<V>>) -> V {
    match push {
        None => load,
        Some(push) => load - push.effort,
    }
}
