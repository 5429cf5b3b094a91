//! Springs with dampers between points of bodies at all stages, in space or in a plane.
//!
//! The vector between the points is `d = P_b − P_a`, z its part along the normal of a plane (m, constant; zero in space), the stiffness k [N/m], the
//! damping c [N s/m] and the rest length `ℓ_r` (m):
//!
//! ```text
//!     ℓ² = d·d + z²,     T = k (ℓ − ℓ_r) + c ℓ̇           tension (N), with ℓ̇ of the scheme: [`crate::equations::forces`]
//!     force T d/ℓ on a and −T d/ℓ on b                   torque about an anchor: arm × force [N m]
//! ```
//!
//! If an arm is very long, both forces act at the other end: [`catena_mechanism::forces::line_of_action`].

use crate::numbers::euclidean::Euclidean;
use crate::numbers::lanes::Lanes;
use crate::plan::forces::{LineStart, SpringLaw};
use crate::stages::force_motion::{Motion, Place};
use catena_mechanism::forces::point_spring::NO_LENGTH;

/// Displacements of bodies at all stages since the start of a step.
pub(crate) trait BodiesAtStages<V: Lanes> {
    /// In space or in a plane.
    type Vector: Euclidean<V>;
    /// `N r`: the displacement by the turn of a body of the point at the arm r from its anchor (m).
    fn swing(&self, body: usize, arm: &<Self::Vector as Euclidean<V>>::Components) -> Self::Vector;
    /// Displacement of the anchor of a body (m).
    fn anchor(&self, body: usize) -> Self::Vector;
}

/// The components of the vectors of bodies.
type Components<V, B> = <<B as BodiesAtStages<V>>::Vector as Euclidean<V>>::Components;
/// A force on a body (N), and its torque about the anchor [N m].
pub(crate) type Wrench<V, E> = (E, <E as Euclidean<V>>::Axial);

/// A spring: the bodies at its ends (`None` is the world), its law, and its line at the start of the step.
pub(crate) type Spring<'s, C> = ([Option<usize>; 2], &'s SpringLaw, &'s LineStart<C>);

/// Adds the forces of springs in one place to `wrenches` on all bodies; returns the power that their dampers dissipate (W).
#[inline(always)]
pub(crate) fn add_springs<'s, V: Lanes, B: BodiesAtStages<V>>(
    bodies: &B,
    springs: impl Iterator<Item = Spring<'s, Components<V, B>>>,
    motion: &Motion<V>,
    place: &Place<V>,
    wrenches: &mut [Wrench<V, B::Vector>],
    mut dissipated: V,
) -> V
where
    Components<V, B>: 's,
{
    for (ends, law, known) in springs {
        let mut swings = [B::Vector::zero(); 2];
        let mut moves = [B::Vector::zero(); 2];
        for side in 0..2 {
            if let Some(body) = ends[side] {
                swings[side] = bodies.swing(body, &known.arms[side]);
                moves[side] = swings[side].plus(bodies.anchor(body));
            }
        }
        let change = moves[1].minus(moves[0]);
        let separation = B::Vector::splat(&known.separation);
        let stretched = separation.plus(change);
        let square = stretched.dot_plus(stretched, V::splat(known.square + NO_LENGTH));
        let along = separation.plus(stretched).dot(change);
        let taut = law.stretched(motion, place, square, along, (known.length, known.rate));
        dissipated = taut.braking.mul_add(taut.rate, dissipated);
        let pull = change.times_plus(place.moved, separation).times(taut.per_length).times(taut.tension);
        for side in 0..2 {
            if let Some(body) = ends[side] {
                let force = if side == 0 { pull } else { pull.times(V::splat(-1.0)) };
                let arm = match &known.common {
                    Some((common, arm)) if *common != side => {
                        moves[*common].minus(bodies.anchor(body)).times_plus(place.moved, B::Vector::splat(arm))
                    }
                    _ => swings[side].times_plus(place.moved, B::Vector::splat(&known.arms[side])),
                };
                let sum = &mut wrenches[body];
                sum.0 = sum.0.plus(force);
                sum.1 = arm.cross_plus(force, sum.1);
            }
        }
    }
    dissipated
}
