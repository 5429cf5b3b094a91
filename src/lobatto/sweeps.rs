//! The Newton step of all stages at once: one sweep from the leaves to the root, one back.
//!
//! Row k is solved with the articulated inertia of its own stage, `H(q_k) α_k = −ρ_k`: the row geometry is what the
//! convergence hangs on where mass ratios are large. Leaf to root, the residuals ([`super::residual`]) and inertias of
//! a subtree gather at its joint, whose axes are eliminated ([`super::articulated`]), and move by the arm to the parent's
//! anchor. Root to leaf, with the twist `η = (a, φ)`,
//!
//! ```text
//!     α = α₀ − (A s)ᵀ η / d,    η ← η + s α,         δ_i = Σ_k Â_ik α_k
//! ```
//!
//! What an iteration needs that keeps the factors of the one before is in [`super::chord`].
//!
//! Of a body that never turns, three of the six rows are left: its children hand it their mass and force alone.
//!
//! Forces in joints enter the row of their freedom, all others the wrench of their body ([`super::applied`]).
//!
//! The projection of the momentum at the end of the step (2.5.11h) is the same recursion at the last stage with the
//! momenta in place of the residuals: `H(q̄) v̄ = Sᵀ p̄` gives the new joint velocities.

use super::algebra::Vector;
use super::articulated::{Articulated, Push};
use super::numbers::Numbers;
use super::residual::{Sweep, body_residual, sliding_residual};
use super::stage::Stages;
use super::start::{BodyPlan, Children};
use super::turns::{horner, rotate_increment};
use crate::model::FreeRotation;

impl<V: Numbers> Stages<V> {
    /// Residual and articulated factorisation of all rows, leaf to root, after [`Stages::sweep_poses`].
    #[inline(always)]
    pub fn sweep_residual(&mut self, gravity: &[f64; 3]) {
        let columns = self.coefficients.residual;
        let rest = self.coefficients.residual_rest;
        let sweep = Sweep::of_residual(&self.coefficients, &columns, &rest, self.step, gravity);
        self.backward::<false, false, false>(&sweep);
    }

    /// [`Stages::sweep_residual`] of a mechanism with forces, after [`Stages::sweep_applied`]; always refined, which costs less
    /// than one more copy of the sweep.
    #[inline(always)]
    pub fn sweep_forced_residual(&mut self, gravity: &[f64; 3]) {
        let columns = self.coefficients.residual;
        let rest = self.coefficients.residual_rest;
        let sweep = Sweep::of_residual(&self.coefficients, &columns, &rest, self.step, gravity);
        self.backward::<false, true, true>(&sweep);
    }

    /// Momenta and articulated factorisation at the end of the step (in the last active lane), leaf to root, after
    /// [`Stages::sweep_poses`]; with forces (`FORCED`) after [`Stages::sweep_applied`].
    #[inline(always)]
    pub fn sweep_momentum<const REFINED: bool, const FORCED: bool>(&mut self, gravity: &[f64; 3]) {
        let (columns, rest) = self.coefficients.momentum_columns(self.step);
        let sweep = self.coefficients.momentum_sweep(&columns, &rest, self.step, gravity);
        self.backward::<true, REFINED, FORCED>(&sweep);
    }

    #[inline(always)]
    fn backward<const MOMENTUM: bool, const REFINED: bool, const FORCED: bool>(&mut self, sweep: &Sweep<V>) {
        let applied = if FORCED { self.applied.take() } else { None };
        let scale = sweep.forces;
        let step = self.step;
        let push = |freedom: usize| {
            if !FORCED {
                return None;
            }
            applied.as_ref().map(|applied| Push {
                effort: applied.efforts[freedom] * scale,
                inertia: V::splat(if MOMENTUM { 0.0 } else { step * applied.resistance[freedom] }),
            })
        };
        let mut carried = Articulated::zero();
        for index in (0..self.plan.bodies.len()).rev() {
            let plan = &self.plan.bodies[index];
            let known = &self.start.bodies[index];
            let pose = self.poses[index];
            if plan.slides {
                let (mass, force) = sliding_residual::<V, MOMENTUM, REFINED>(sweep, known, &pose);
                let mut own = Articulated { mass, force, ..Articulated::zero() };
                if FORCED && let Some(applied) = &applied {
                    own.force = applied.wrenches[index].0.times_minus(scale, own.force);
                }
                let mut total = match plan.children {
                    Children::None => own,
                    Children::Next => own.plus_mass(&carried),
                    Children::Slot(slot) => own.plus_mass(&self.slots[slot]),
                };
                for freedom in (plan.first_axis..plan.first_axis + plan.translations).rev() {
                    let axis = Vector::splat(&self.start.axes[freedom]);
                    self.eliminated[freedom] = total.eliminate_slide(axis, push(freedom));
                }
                if plan.parent.is_some() {
                    collect(plan, &mut self.slots, &mut carried, &total);
                }
                continue;
            }
            let residual = body_residual::<V, MOMENTUM, REFINED>(sweep, plan, known, &pose);
            let turn = residual.turn;
            let mut own = residual.with_inertia();
            if FORCED && let Some(applied) = &applied {
                let (force, torque) = applied.wrenches[index];
                own.force = force.times_minus(scale, own.force);
                own.torque = torque.times_minus(scale, own.torque);
            }
            let mut total = with_children(plan, own, &self.slots, &carried);

            // Rotations first: they are the outermost axes of the joint.
            let rotations = plan.first_axis + plan.translations;
            match plan.rotation {
                FreeRotation::None => {}
                FreeRotation::AboutZ => {
                    let axis = Vector::splat(&self.start.axes[rotations]);
                    let axis = turn.apply_plus(axis, axis);
                    // Nobody asks for what is left of a root: its one axis needs no more than the solution.
                    self.eliminated[rotations] = if plan.parent.is_none() && plan.translations == 0 {
                        total.solve_rotation(axis, push(rotations))
                    } else {
                        total.eliminate_rotation(axis, push(rotations))
                    };
                }
                FreeRotation::Ball => {
                    let vector = self.rotation_vector(rotations).times(sweep.moved);
                    let coefficients = tangent(vector.dot(vector));
                    for freedom in (rotations..rotations + 3).rev() {
                        let axis = Vector::splat(&self.start.axes[freedom]);
                        let tilt = if MOMENTUM { axis } else { tilted(vector, axis, coefficients) };
                        let axis = turn.apply_plus(tilt, tilt);
                        self.eliminated[freedom] = if plan.alone {
                            total.eliminate_spin(axis, push(freedom))
                        } else {
                            total.eliminate_rotation(axis, push(freedom))
                        };
                    }
                }
            }
            if plan.translations > 0 {
                for freedom in (plan.first_axis..rotations).rev() {
                    let turned = self.slide_axis(plan, freedom, sweep.moved);
                    self.eliminated[freedom] = if plan.alone {
                        total.solve_translation(turned, push(freedom))
                    } else {
                        total.eliminate_translation(turned, push(freedom))
                    };
                }
            }

            if let Some(parent) = plan.parent {
                let moved = pose.anchor.minus(self.poses[parent].anchor);
                let arm = moved.times_plus(sweep.moved, Vector::splat(&known.arm));
                self.arms[index] = arm;
                let slots = &mut self.slots;
                // A parent that never turns asks for forces alone.
                if plan.parent_slides {
                    collect(plan, slots, &mut carried, &total);
                } else {
                    collect(plan, slots, &mut carried, &total.shifted(arm));
                }
            }
        }
        if FORCED {
            self.applied = applied;
        }
    }

    /// A free translation axis of a body at the rows' stages: it turns with the parent.
    #[inline(always)]
    pub(super) fn slide_axis(&self, plan: &BodyPlan, freedom: usize, moved: V) -> Vector<V> {
        let axis = Vector::splat(&self.start.axes[freedom]);
        match plan.parent.filter(|_| !plan.parent_slides) {
            Some(parent) => {
                let parent = self.poses[parent];
                rotate_increment(parent.w, parent.u, axis).times_plus(moved, axis)
            }
            None => axis,
        }
    }

    /// Root to leaf: `α` of every degree of freedom, mixed into the increments; the largest increment in each lane.
    #[inline(always)]
    pub fn sweep_increments(&mut self) -> V {
        self.forward(|stages, freedom, alpha| stages.increment[freedom] = alpha);
        let columns = &self.coefficients.solve;
        let mut largest = V::zero();
        let (fours, rest) = self.increment.as_chunks_mut::<4>();
        for four in fours {
            *four = V::mix_all(*four, columns);
            let [a, b, c, d] = *four;
            largest = d.max_abs(c.max_abs(b.max_abs(a.max_abs(largest))));
        }
        for increment in rest {
            *increment = increment.mix(columns);
            largest = increment.max_abs(largest);
        }
        largest
    }

    /// Root to leaf after [`Stages::sweep_momentum`]: the new velocities, from the last active lane.
    #[inline(always)]
    pub fn sweep_velocities(&mut self, velocity: &mut [V::Real]) {
        let last = self.coefficients.active - 1;
        self.forward(|_, freedom, rate| velocity[freedom] = rate.lane(last));
    }

    #[inline(always)]
    fn forward(&mut self, mut take: impl FnMut(&mut Self, usize, V)) {
        let mut twist = (Vector::zero(), Vector::zero());
        for index in 0..self.plan.bodies.len() {
            let plan = &self.plan.bodies[index];
            let (freedoms, children) = (plan.freedoms(), plan.children);
            let turning = plan.first_axis + plan.translations;
            match plan.parent_collects {
                Children::None => twist = (Vector::zero(), Vector::zero()),
                Children::Next => twist.0 = twist.1.cross_plus(self.arms[index], twist.0),
                Children::Slot(slot) => {
                    twist = self.twists[slot];
                    twist.0 = twist.1.cross_plus(self.arms[index], twist.0);
                }
            }
            for freedom in freedoms {
                let joint = self.eliminated[freedom];
                // Two chains of three, because each body waits for its parent's.
                let alpha = joint.force_ratio.dot_from(twist.0, joint.bias) - joint.torque_ratio.dot(twist.1);
                if freedom < turning {
                    twist.0 = joint.axis.times_plus(alpha, twist.0);
                } else {
                    twist.1 = joint.axis.times_plus(alpha, twist.1);
                }
                take(self, freedom, alpha);
            }
            if let Children::Slot(slot) = children {
                self.twists[slot] = twist;
            }
        }
    }
}

/// What is a body's own, and what its children have left.
#[inline(always)]
pub(super) fn with_children<V: Numbers>(
    plan: &BodyPlan,
    own: Articulated<V>,
    slots: &[Articulated<V>],
    carried: &Articulated<V>,
) -> Articulated<V> {
    match plan.children {
        Children::None => own,
        Children::Next => own.plus(carried),
        Children::Slot(slot) => own.plus(&slots[slot]),
    }
}

/// Hands what a body leaves to its parent.
#[inline(always)]
pub(super) fn collect<V: Numbers>(
    plan: &BodyPlan,
    slots: &mut [Articulated<V>],
    carried: &mut Articulated<V>,
    left: &Articulated<V>,
) {
    match plan.parent_collects {
        Children::Slot(slot) if !plan.first_collected => slots[slot] = slots[slot].plus(left),
        Children::Slot(slot) => slots[slot] = *left,
        _ => *carried = *left,
    }
}

/// A free axis of a ball joint turned by a rotation vector, in the axes of the start: `(1 − k₁ θ̂ + k₂ θ̂²) axis`.
#[inline(always)]
pub fn tilted<V: Numbers>(vector: Vector<V>, axis: Vector<V>, (first, second): (V, V)) -> Vector<V> {
    let once = vector.cross(axis);
    vector.cross(once).times_plus(second, once.times_minus(first, axis))
}

/// [`tilted`] for one axis alone.
#[inline(always)]
pub fn tilt<V: Numbers>(vector: Vector<V>, axis: Vector<V>) -> Vector<V> {
    tilted(vector, axis, tangent(vector.dot(vector)))
}

/// `(1 − cos φ)/φ²` and `(φ − sin φ)/φ³` from `φ²`: the coefficients of the tangent of the exponential map. They span the projection, steer
/// the Newton step, and give ball joints with forces their spin; at 3.1 rad the first term left out is below 2e-17.
#[inline(always)]
pub fn tangent<V: Numbers>(square: V) -> (V, V) {
    const FIRST: [f64; 13] = tangent_series(2);
    const SECOND: [f64; 13] = tangent_series(3);
    (horner(&FIRST, square), horner(&SECOND, square))
}

/// `(−1)ⁿ / (2n + first)!`.
const fn tangent_series(first: usize) -> [f64; 13] {
    let mut terms = [if first == 2 { 0.5 } else { 1.0 / 6.0 }; 13];
    let mut n = 1;
    while n < terms.len() {
        terms[n] = -terms[n - 1] / (((2 * n + first) * (2 * n + first - 1)) as f64);
        n += 1;
    }
    terms
}
