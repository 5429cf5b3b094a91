//! A body that floats freely under gravity alone: three equations a row instead of six.
//!
//! Its centre of mass follows a parabola, which the scheme meets at every stage, so it needs no solve. Translation and rotation are not coupled. The
//! rotation vector since the start is `θ_k`; `N_k` and `e_k` are as in [`crate::equations::residual`], and `J₀` is the inertia about the centre of
//! mass at the start. The Newton step needs no elimination:
//!
//! ```text
//!     Δx_i = h c_i v + ½ (h c_i)² g                                                                          [m]
//!     J_k = (1 + N_k) J₀ (1 + N_k)ᵀ,   φ = (1 + N_k) T(θ_k) α   (the spin of a change α of θ_k)
//!     α_k = −T(θ_k)⁻¹ J₀⁻¹ (1 + N_k)ᵀ e_k,   T⁻¹ ≈ 1 + ½ θ̂ + κ θ̂²                                           [rad]
//! ```
//!
//! At the end of the step the rates of the joint are the components of `y` along the axes of the start, and the velocity of the centre of mass, from
//! which the joint's anchor is `−(1 + N) c`, is `v + h g`:
//!
//! ```text
//!     J_s (1 + N_s) y = π:     y₀ = J₀⁻¹ (1 + N_s)ᵀ π,   y = y₀ + J₀⁻¹ (1 + N_s)ᵀ (π − J_s (1 + N_s) y₀)           [rad/s]
//! ```

use crate::equations::residual::spin_residual;
use crate::numbers::algebra::{Matrix, Symmetric, Vector};
use crate::numbers::arithmetic::{Arithmetic, Numbers};
use crate::numbers::reductions::largest;
use crate::numbers::rotations::{EACH, rotate_increment, untilted};
use crate::numbers::series::FEW;
use crate::plan::tree::TRANSLATIONS;
use crate::stages::pose::StagePose;
use crate::stages::start::Start;
use crate::stages::workspace::Stages;
use std::ops::Range;

pub(crate) const ROTATIONS: Range<usize> = 3..6;
/// Up to this displacement [`FEW`] terms are enough.
const FEW_EACH: f64 = EACH * FEW;

/// `J₀⁻¹ (1 + N)ᵀ e`.
#[inline(always)]
pub(crate) fn turned_back<V: Arithmetic>(inverse: &[V::Real; 6], turn: &Matrix<V>, torque: Vector<V>) -> Vector<V> {
    Symmetric(inverse.map(V::whole)).apply(turn.apply_transposed(torque).plus(torque))
}

impl<V: Numbers> Stages<V> {
    /// An iteration of a tumbler, from the poses to the increments; the largest increment in each lane.
    #[inline(always)]
    pub fn tumble<const REFINED: bool>(&mut self, gravity: &[f64; 3]) -> V {
        self.turn_tumbler();
        let (_, rows, _) = self.rows::<REFINED, false>(gravity);
        let Some(inverse) = &rows.start.inverse else { return V::zero() };
        let (turn, (_, torque)) = spin_residual(&rows, 0, &rows.plan.bodies[0], &rows.start.bodies[0]);
        let alpha = untilted(rows.rotation(ROTATIONS.start), turned_back(inverse, &turn, torque));
        let Vector([x, y, z]) = axes_of(rows.start, ROTATIONS).apply(alpha);
        let [x, y, z] = V::mix_all([-x, -y, -z], &self.coefficients.solve);
        self.increment[ROTATIONS].copy_from_slice(&[x, y, z]);
        z.max_abs(y.max_abs(x.max_abs(V::zero())))
    }

    /// The rotations of all stages.
    #[inline(always)]
    fn turn_tumbler(&mut self) {
        let few = largest(&self.displacement[ROTATIONS]) <= FEW_EACH;
        let turn = self.rotation_vector(ROTATIONS.start);
        let (w, sine) = V::half_angle(turn.dot(turn), few);
        self.poses[0] = StagePose { w, u: turn.times(sine), anchor: Vector::zero() };
    }

    /// The poses of all stages, and the displacement of the joint, which the iteration of a step does not use.
    #[inline(always)]
    pub fn place_tumbler(&mut self, gravity: &[f64; 3]) {
        self.turn_tumbler();
        let (pose, known) = (&mut self.poses[0], &self.start.bodies[0]);
        let time = self.coefficients.nodes * V::splat(self.step);
        let fall = Vector(gravity.map(V::splat)).times(time * V::splat(0.5));
        let path = fall.plus(Vector::splat(&known.velocity)).times(time);
        pose.anchor = path.minus(rotate_increment(pose.w, pose.u, Vector::splat(&known.com)));
        let Vector(moved) = axes_of(&self.start, TRANSLATIONS).apply(pose.anchor);
        self.displacement[TRANSLATIONS].copy_from_slice(&moved);
    }
}

/// The axes of some degrees of freedom, as rows.
#[inline(always)]
pub(crate) fn axes_of<V: Arithmetic>(start: &Start<V::Real>, freedoms: Range<usize>) -> Matrix<V> {
    let axis = |index: usize| Vector::splat(&start.axes[freedoms.start + index]).0;
    Matrix([axis(0), axis(1), axis(2)])
}
