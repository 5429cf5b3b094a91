//! Loads that change in time or turn with their body, and drag, at all stages, in space or in a plane.
//!
//! A load acts at the point P with the arm r from the anchor, which has moved by `y = P − P₀` since the start of the step. The velocity of the point
//! is the one of the scheme ([`crate::equations::forces`]), and so is the angular velocity ω:
//!
//! ```text
//!     f = c(t_k) (1 + N_k) F₀,   n = c(t_k) (1 + N_k) M₀ + r × f      F₀, M₀: at the start; without N_k if they keep their direction
//!     f = −(c₁ + c₂ |v|) v,      n = −(d₁ + d₂ |ω|) ω + r × f         drag
//!     v = v₀ + h⁻¹ Σ_i (Ā B)_ji (y_i − h c_i v₀)                       [m/s]
//! ```
//!
//! with f in N and n in N m about the anchor. Loads put in the work `f·v + n₀·ω`, which drag turns into heat. Newton's matrix leaves them out.

use crate::equations::springs::{BodiesAtStages, Wrench};
use crate::numbers::euclidean::Euclidean;
use crate::numbers::lanes::Lanes;
use crate::plan::forces::{LoadLaw, LoadStart};
use crate::stages::force_motion::{Motion, Place};

/// Bodies on which loads act.
pub(crate) trait LoadedBodies<V: Lanes>: BodiesAtStages<V> {
    /// A torque that is the same in all lanes.
    type Torque: Copy;
    /// A torque on a body in one place, which may turn with it.
    fn torque(&self, body: usize, torque: &Self::Torque, turns: bool, place: &Place<V>) -> Axial<V, Self>;
    /// Angular velocity of a body in one place [rad/s].
    fn spin(&self, body: usize, motion: &Motion<V>, place: &Place<V>) -> Axial<V, Self>;
    /// `axial · factor`.
    fn scaled(axial: Axial<V, Self>, factor: V) -> Axial<V, Self>;
    /// `a + b`.
    fn sum(a: Axial<V, Self>, b: Axial<V, Self>) -> Axial<V, Self>;
    /// `start + a · b`.
    fn along(a: Axial<V, Self>, b: Axial<V, Self>, start: V) -> V;
}

type Axial<V, B> = <<B as BodiesAtStages<V>>::Vector as Euclidean<V>>::Axial;
type Components<V, B> = <<B as BodiesAtStages<V>>::Vector as Euclidean<V>>::Components;
/// The start of the load of a body.
pub(crate) type StartOf<V, B> = LoadStart<Components<V, B>, <B as LoadedBodies<V>>::Torque>;

/// Adds the loads in one place to `wrenches` on all bodies; returns the powers that they dissipate and put in (W), added to these.
#[inline(always)]
pub(crate) fn add_loads<'l, V: Lanes, B: LoadedBodies<V>>(
    bodies: &B,
    loads: impl Iterator<Item = (&'l (usize, LoadLaw), &'l StartOf<V, B>)>,
    motion: &Motion<V>,
    place: &Place<V>,
    wrenches: &mut [Wrench<V, B::Vector>],
    (mut dissipated, mut work): (V, V),
) -> (V, V)
where
    StartOf<V, B>: 'l,
{
    for (&(body, ref law), known) in loads {
        let swing = bodies.swing(body, &known.arm);
        let lever = swing.times_plus(place.moved, B::Vector::splat(&known.arm));
        let start = B::Vector::splat(&known.velocity);
        let moved = swing.plus(bodies.anchor(body));
        let ahead = start.times_plus(-motion.times, moved).mixed(&place.velocity);
        let velocity = ahead.times_plus(motion.inverse, start);
        let spin = bodies.spin(body, motion, place);
        let (force, torque) = match law {
            LoadLaw::Given { turns, course } => {
                let factor = motion.factor(place, course);
                let mut force = B::Vector::splat(&known.force);
                if *turns {
                    force = bodies.swing(body, &known.force).times_plus(place.moved, force);
                }
                let force = force.times(factor);
                let torque = B::scaled(bodies.torque(body, &known.torque, *turns, place), factor);
                work = B::along(torque, spin, force.dot_plus(velocity, work));
                (force, torque)
            }
            LoadLaw::Drag { linear, quadratic, angular_linear, angular_quadratic } => {
                let speed = velocity.dot(velocity).square_root();
                let turning = B::along(spin, spin, V::zero()).square_root();
                let resistance = speed.mul_add(V::splat(*quadratic), V::splat(*linear));
                let angular = turning.mul_add(V::splat(*angular_quadratic), V::splat(*angular_linear));
                let (force, torque) = (velocity.times(-resistance), B::scaled(spin, -angular));
                dissipated = dissipated - B::along(torque, spin, force.dot(velocity));
                (force, torque)
            }
        };
        let sum = &mut wrenches[body];
        sum.0 = sum.0.plus(force);
        sum.1 = lever.cross_plus(force, B::sum(sum.1, torque));
    }
    (dissipated, work)
}
