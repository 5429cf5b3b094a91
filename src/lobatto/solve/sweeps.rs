//! The Newton step of all stages at once: one sweep from the leaves to the root, one back.
//!
//! Row k is solved with the articulated inertia of its own stage, `H(q_k) α_k = −ρ_k`: for large mass ratios the convergence depends on the row
//! geometry. Leaf to root, the residuals ([`crate::equations::residual`]) and inertias of a subtree gather at its joint, whose axes are eliminated
//! ([`crate::stages::articulated`]), and move by the arm to the parent's anchor. Root to leaf, with the twist `η = (a, φ)`,
//!
//! ```text
//!     α = α₀ − (A s)ᵀ η / d,    η ← η + s α,         δ_i = Σ_k Â_ik α_k
//! ```
//!
//! Iterations that keep the factors of the one before are in [`crate::solve::kept_factors`].
//!
//! A body that never turns keeps three of the six rows: its children hand it their mass and force alone. A body on a hinge to the world keeps one
//! ([`crate::equations::pivot`]). One that floats freely needs no recursion at all ([`crate::solve::free_body`]).
//!
//! Forces in joints enter the row of their freedom, all others the wrench of their body ([`crate::equations::forces`]).
//!
//! The projection of the momentum at the end of the step (2.5.11h) is the same recursion at the last stage alone, with the momenta in place of the
//! residuals ([`crate::ending::velocities`]). [`Rows`] therefore supplies the right-hand side.

use crate::equations::pivot::pivot_torque;
use crate::equations::residual::{body_residual, force_residual};
use crate::numbers::algebra::Vector;
use crate::numbers::arithmetic::{Arithmetic, Numbers};
use crate::numbers::rotations::{rotate_increment, tilted_by};
use crate::plan::tree::{BodyPlan, Children, Plan};
use crate::stages::articulated::Articulated;
use crate::stages::factors::Factors;
use crate::stages::row_geometry::LookAhead;
use crate::stages::rows::{Rows, StageRows, Stored};
use crate::stages::start::{BodyStart, Start};
use crate::stages::workspace::Stages;
use catena_mechanism::description::joint::FreeRotation;

impl<V: Numbers> Stages<V> {
    /// Residual and articulated factorisation of all rows, leaf to root, after [`Stages::sweep_poses`].
    #[inline(always)]
    pub fn sweep_residual(&mut self, gravity: &[f64; 3]) {
        let (factors, rows, early) = self.rows::<false, false>(gravity);
        factors.eliminate(rows.plan, rows.start, &rows, early);
    }

    /// [`Stages::sweep_residual`] of a mechanism with forces, after [`Stages::sweep_applied`]; always refined, which costs less
    /// than one more copy of the sweep.
    #[inline(always)]
    pub fn sweep_forced_residual(&mut self, gravity: &[f64; 3]) {
        let (factors, rows, early) = self.rows::<true, true>(gravity);
        factors.eliminate(rows.plan, rows.start, &rows, early);
    }

    /// The rows of all stages, and where their factors go.
    #[inline(always)]
    pub(crate) fn rows<const REFINED: bool, const FORCED: bool>(
        &mut self,
        gravity: &[f64; 3],
    ) -> (&mut Factors<V>, StageRows<'_, V, REFINED, FORCED>, &mut LookAhead<V, Stored<V>>) {
        let Stages { factors, coefficients, plan, start, poses, displacement, applied, step, early, .. } = self;
        let (sweep, step) = (coefficients.residual_sweep(*step, gravity), *step);
        (factors, StageRows { sweep, plan, start, poses, displacement, applied: applied.as_deref(), step }, early)
    }

    /// Root to leaf: `α` of every degree of freedom, mixed into the increments; the largest increment in each lane.
    #[inline(always)]
    pub fn sweep_increments(&mut self) -> V {
        let Stages { factors, plan, increment, .. } = self;
        factors.solve(
            plan,
            #[inline(always)]
            |freedom, alpha| increment[freedom] = alpha,
        );
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
}

impl<V: Arithmetic> Factors<V> {
    /// Leaf to root. The kinds of joints are written out one after the other, because code after a branch has its 27 registers on the stack. So the
    /// children's inertias are added from their slots, and the most common joint goes straight through.
    #[inline(always)]
    pub fn eliminate<R: Rows<V>>(
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
            let below = plans.below(index);
            if let Some(pivot) = plan.pivot {
                let (own, freedom) = (&start.pivots[pivot], plan.first_axis);
                let torque = pivot_torque(rows, index, own, &start.axes[freedom], start.rates[freedom]);
                let (axis, inertia) = (Vector::splat(&start.axes[freedom]), V::whole(own.inertia));
                self.eliminated[freedom] = self.slots[below].solve_rotation(axis, inertia, torque, None);
                continue;
            }
            if plan.slides {
                let force = force_residual(rows, index, known, rows.pose(index).anchor);
                let mut own = Articulated::sliding(V::whole(known.mass), force);
                if let Some((force, _)) = rows.wrench(index) {
                    own.force = force.times_minus(rows.forces(), own.force);
                }
                let mut total = own.plus_mass(&self.slots[below]);
                for freedom in (plan.first_axis..plan.first_axis + plan.translations).rev() {
                    let axis = Vector::splat(&start.axes[freedom]);
                    self.eliminated[freedom] = total.eliminate_slide(axis, rows.push(freedom));
                }
                collect(plans, plan, &mut self.slots, &total);
                continue;
            }
            let residual = body_residual(rows, index, plan, known, early);
            let turn = residual.turn;
            let mut own = residual.with_inertia();
            if let Some((force, torque)) = rows.wrench(index) {
                own.force = force.times_minus(rows.forces(), own.force);
                own.torque = torque.times_minus(rows.forces(), own.torque);
            }
            let mut total = own.plus(&self.slots[below]);

            // Rotations first: they are the outermost axes of the joint.
            let rotations = plan.first_axis + plan.translations;
            if plan.rotation == FreeRotation::AboutZ {
                let axis = Vector::splat(&start.axes[rotations]);
                let axis = turn.apply_plus(axis, axis);
                if plan.translations == 0 {
                    if plan.parent.is_none() {
                        // The rest of a root is not used: its one axis needs only the solution.
                        let zero = V::zero();
                        self.eliminated[rotations] = total.solve_rotation(axis, zero, zero, rows.push(rotations));
                    } else {
                        self.eliminated[rotations] = total.eliminate_rotation(axis, rows.push(rotations));
                        self.hand_up(plans, index, known, rows, &total);
                    }
                    continue;
                }
                self.eliminated[rotations] = total.eliminate_rotation(axis, rows.push(rotations));
            } else if plan.rotation == FreeRotation::Ball {
                let tilt = rows.tilt(rotations);
                for freedom in (rotations..rotations + 3).rev() {
                    let axis = Vector::splat(&start.axes[freedom]);
                    let axis = tilted_by(tilt, axis);
                    let axis = turn.apply_plus(axis, axis);
                    self.eliminated[freedom] = total.eliminate_rotation(axis, rows.push(freedom));
                }
            }
            for freedom in (plan.first_axis..rotations).rev() {
                let turned = slide_axis(rows, plan, &start.axes[freedom]);
                self.eliminated[freedom] = total.eliminate_translation(turned, rows.push(freedom));
            }
            self.hand_up(plans, index, known, rows, &total);
        }
    }

    /// Moves a body's remaining inertia and wrench to its parent's anchor, and hands them over, if it has a parent.
    #[inline(always)]
    fn hand_up<R: Rows<V>>(
        &mut self,
        plans: &Plan,
        body: usize,
        known: &BodyStart<V::Real>,
        rows: &R,
        left: &Articulated<V>,
    ) {
        let plan = &plans.bodies[body];
        // A parent that never turns asks for forces alone.
        if let Some(parent) = plan.turning_parent() {
            let arm = self.reach(parent, body, known, rows);
            collect(plans, plan, &mut self.slots, &left.shifted(arm));
        } else {
            collect(plans, plan, &mut self.slots, left);
        }
    }

    /// The arm of a body from its parent's anchor, which the way back asks for, too.
    #[inline(always)]
    pub(crate) fn reach<R: Rows<V>>(
        &mut self,
        parent: usize,
        body: usize,
        known: &BodyStart<V::Real>,
        rows: &R,
    ) -> Vector<V> {
        let moved = rows.pose(body).anchor.minus(rows.pose(parent).anchor);
        let arm = moved.times_plus(rows.moved(), Vector::splat(&known.arm));
        self.arms[body] = arm;
        arm
    }

    /// Root to leaf: hands over `α` of every degree of freedom.
    #[inline(always)]
    pub fn solve(&mut self, plans: &Plan, mut take: impl FnMut(usize, V)) {
        let mut twist = (Vector::zero(), Vector::zero());
        for (index, plan) in plans.bodies.iter().enumerate() {
            let turning = plan.first_axis + plan.translations;
            match plan.parent_collects {
                Children::None => twist = (Vector::zero(), Vector::zero()),
                Children::Next => twist.0 = twist.1.cross_plus(self.arms[index], twist.0),
                Children::Slot(slot) => {
                    twist = self.twists[slot];
                    twist.0 = twist.1.cross_plus(self.arms[index], twist.0);
                }
            }
            for freedom in plan.freedoms() {
                let joint = &self.eliminated[freedom];
                // Two chains of three, because each body waits for its parent's.
                let alpha = joint.force_ratio.dot_from(twist.0, joint.bias) - joint.torque_ratio.dot(twist.1);
                if freedom < turning {
                    twist.0 = joint.axis.times_plus(alpha, twist.0);
                } else {
                    twist.1 = joint.axis.times_plus(alpha, twist.1);
                }
                take(freedom, alpha);
            }
            if let Children::Slot(slot) = plan.children {
                self.twists[slot] = twist;
            }
        }
    }
}

/// A free translation axis of a body at the rows' stages: it turns with the parent.
#[inline(always)]
pub(crate) fn slide_axis<V: Arithmetic, R: Rows<V>>(rows: &R, plan: &BodyPlan, axis: &[V::Real; 3]) -> Vector<V> {
    let axis = Vector::splat(axis);
    match plan.turning_parent() {
        Some(parent) => {
            let parent = rows.pose(parent);
            rotate_increment(parent.w, parent.u, axis).times_plus(rows.moved(), axis)
        }
        None => axis,
    }
}

/// Hands a body's remaining inertia and wrench to its parent, if it has one.
#[inline(always)]
pub fn collect<V: Arithmetic>(plans: &Plan, plan: &BodyPlan, slots: &mut [Articulated<V>], left: &Articulated<V>) {
    let Some(parent) = plan.parent else { return };
    let slot = &mut slots[plans.below(parent)];
    if plan.first_collected {
        *slot = *left;
    } else {
        *slot = slot.plus(left);
    }
}
