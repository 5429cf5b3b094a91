//! Efforts that hold the weight of all bodies beyond a joint, at all stages, in space or in a plane.
//!
//! The centres of mass x of the bodies beyond have moved by `Δx`, the anchor of the joint by `Δp`, and the axis a turns with the body of the joint:
//!
//! ```text
//!     S = S₀ + Σ_b m_b (Δx_b − Δp) [kg m],   M = Σ_b m_b [kg]
//!     τ = −f a · (S × g) [N m]  where the joint turns,   τ = −f M (a · g) [N]  where it slides
//! ```
//!
//! with the part f of the weight, and the work `τ q̇` [W] with the rate of the scheme ([`crate::equations::forces`]). It is minus the generalised force
//! of gravity on the joint ([`catena_mechanism::forces::gravity_compensation`]). Newton's matrix leaves it out, as it leaves out the change of gravity's
//! own efforts.

use crate::equations::loads::LoadedBodies;
use crate::equations::springs::BodiesAtStages;
use crate::numbers::euclidean::Euclidean;
use crate::numbers::lanes::Lanes;
use crate::plan::forces::{HoldingPlan, HoldingStart};
use crate::stages::force_motion::{Motion, Place};

type Components<V, B> = <<B as BodiesAtStages<V>>::Vector as Euclidean<V>>::Components;
/// The start of an effort that holds a weight.
pub(crate) type HoldingOf<V, B> = HoldingStart<Components<V, B>, <B as LoadedBodies<V>>::Torque>;

/// Adds the efforts in one place to `efforts`; returns the power that they put in (W), added to `work`.
#[inline(always)]
pub(crate) fn add_holding<'h, V: Lanes, B: LoadedBodies<V>>(
    bodies: &B,
    holding: impl Iterator<Item = (&'h HoldingPlan, &'h HoldingOf<V, B>)>,
    gravity: &Components<V, B>,
    motion: &Motion<V>,
    place: &Place<V>,
    efforts: &mut [V],
    mut work: V,
) -> V
where
    HoldingOf<V, B>: 'h,
{
    let gravity = B::Vector::splat(gravity);
    for (plan, known) in holding {
        let freedom = plan.freedom;
        let along = if plan.turns {
            let mut moved = bodies.anchor(plan.head).times(V::splat(-plan.mass));
            for (&(body, mass), arm) in plan.beyond.iter().zip(&known.arms) {
                moved = bodies.swing(body, arm).plus(bodies.anchor(body)).times_plus(V::splat(mass), moved);
            }
            let moment = moved.times_plus(place.moved, B::Vector::splat(&known.moment));
            B::along(bodies.torque(plan.head, &known.axis, true, place), moment.cross(gravity), V::zero())
        } else {
            let axis = bodies.swing(plan.head, &known.slide).times_plus(place.moved, B::Vector::splat(&known.slide));
            axis.dot(gravity) * V::splat(plan.mass)
        };
        let effort = along * V::splat(-plan.factor);
        efforts[freedom] = efforts[freedom] + effort;
        work = effort.mul_add(motion.rate(place, motion.displacement[freedom], motion.rates[freedom]), work);
    }
    work
}
