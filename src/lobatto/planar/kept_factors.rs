//! Iterations in a plane that keep the factors of an earlier one.
//!
//! ```text
//!     H(q⁰_k) α_k = −ρ_k(q):     α₀ = (τ − sᵀ p)/d⁰,   p ← p + (A s)⁰ α₀
//! ```
//!
//! The method is the one of [`crate::solve::kept_factors`], with wrenches p of three components. The sweep is another, because residuals come from
//! the mixed paths of [`crate::planar::sweeps`] and hinges have no axis to turn: the table of [`crate::planar`] has the time it takes.

use crate::numbers::lanes::Lanes;
use crate::plan::tree::Children;
use crate::planar::algebra::Vector2;
use crate::planar::articulated::Eliminated2;
use crate::planar::sweeps::{own_residual, row_turn};
use crate::planar::workspace::PlanarStages;
use crate::solve::kept_factors::less_push;
use crate::stages::rows::Sweep;
use catena_mechanism::description::joint::FreeRotation;

/// The wrench that a body hands to its parent, about the parent's anchor.
#[derive(Clone, Copy)]
struct Wrench2<V> {
    force: Vector2<V>,
    torque: V,
}

impl<V: Lanes> Wrench2<V> {
    /// The sum of two about the same point.
    #[inline(always)]
    fn plus(self, force: Vector2<V>, torque: V) -> Self {
        Wrench2 { force: self.force.plus(force), torque: self.torque + torque }
    }

    /// Removes a joint's part along an axis of which the wrench is `load` (minus the effort of forces in the joint).
    #[inline(always)]
    fn relieve(&mut self, load: V, joint: &mut Eliminated2<V>) {
        joint.bias = -(load * joint.inverse);
        self.force = joint.force_ratio.times_minus(load, self.force);
        self.torque = joint.torque_ratio.neg_mul_add(load, self.torque);
    }
}

impl<V: Lanes> PlanarStages<V> {
    /// Leaf to root, after [`PlanarStages::sweep_paths`] with the same sweep: residuals of all rows, with the factors that
    /// [`PlanarStages::sweep_back`] has left.
    #[inline(always)]
    pub(crate) fn sweep_wrenches<const FORCED: bool>(&mut self, sweep: &Sweep<V>) {
        let mut carried = Wrench2 { force: Vector2::zero(), torque: V::zero() };
        for index in (0..self.plan.bodies.len()).rev() {
            let (tree, flat) = (&self.plan.tree.bodies[index], &self.plan.bodies[index]);
            let known = &self.start.bodies[index];
            let turned = &self.turned[index];
            let (_, mut force, mut torque) = own_residual(known, turned, row_turn::<V, false>(sweep, turned));
            if FORCED {
                (force, torque) = self.less_acting(index, sweep, force, torque);
            }
            let own = Wrench2 { force, torque };
            let mut total = match tree.children {
                Children::None => own,
                Children::Next => own.plus(carried.force, carried.torque),
                Children::Slot(slot) => own.plus(self.slots[slot].force, self.slots[slot].torque),
            };

            let rotation = tree.first_axis + tree.translations;
            if tree.rotation != FreeRotation::None {
                let load = less_push(total.torque, self.push::<false, FORCED>(sweep, rotation, flat.sign));
                total.relieve(load, &mut self.eliminated[rotation]);
            }
            let parent = match tree.parent {
                Some(parent) => Some(row_turn::<V, false>(sweep, &self.turned[parent])),
                None => None,
            };
            for freedom in (tree.first_axis..rotation).rev() {
                let axis = Vector2::splat(&self.start.axes[freedom]);
                let axis = match parent {
                    Some((along, across)) => axis.turned(along, across),
                    None => axis,
                };
                self.axes[freedom] = axis;
                let load = less_push(axis.dot(total.force), self.push::<false, FORCED>(sweep, freedom, 1.0));
                total.relieve(load, &mut self.eliminated[freedom]);
            }
            if let Some((along, across)) = parent {
                let arm = Vector2::splat(&known.arm).turned(along, across);
                let arm = if tree.translations > 0 { self.arms[index].times_plus(sweep.moved, arm) } else { arm };
                self.arms[index] = arm;
                let left = Wrench2 { torque: arm.quarter_turn().dot_plus(total.force, total.torque), ..total };
                match tree.parent_collects {
                    Children::Slot(slot) => {
                        let slot = &mut self.slots[slot];
                        let sum = if tree.first_collected { left } else { left.plus(slot.force, slot.torque) };
                        (slot.force, slot.torque) = (sum.force, sum.torque);
                    }
                    _ => carried = left,
                }
            }
        }
    }
}
