//! The velocities at the end of a step of a body that floats freely under gravity alone; stages and symbols: [`crate::solve::free_body`].
//!
//! ```text
//!     J_s (1 + N_s) y = π:     y₀ = J₀⁻¹ (1 + N_s)ᵀ π,   y = y₀ + J₀⁻¹ (1 + N_s)ᵀ (π − J_s (1 + N_s) y₀)           [rad/s]
//! ```

use crate::ending::velocities::Ending;
use crate::equations::residual::spin_residual;
use crate::numbers::algebra::Vector;
use crate::numbers::arithmetic::{Arithmetic, Numbers};
use crate::plan::tree::TRANSLATIONS;
use crate::solve::free_body::{ROTATIONS, axes_of, turned_back};
use crate::stages::workspace::Stages;
impl<E: Arithmetic> Ending<E> {
    /// The velocities at the end of a step, after [`Stages::place_tumbler`]; always with twice the digits of the coefficients.
    #[inline(always)]
    pub fn tumbler_velocities<V: Numbers<One = E, Real = E::Real>>(
        &self,
        stages: &Stages<V>,
        gravity: &[f64; 3],
        velocity: &mut [V::Real],
    ) {
        let rows = self.rows::<V, true, false>(stages, gravity);
        let (plan, start) = (&stages.plan, &stages.start);
        let Some(inverse) = &start.inverse else { return };
        let known = &start.bodies[0];
        let (turn, (inertia, momentum)) = spin_residual(&rows, 0, &plan.bodies[0], known);
        let axes = axes_of(start, ROTATIONS);
        let first = axes.apply(turned_back(inverse, &turn, momentum));
        // One round of refinement: `J₀⁻¹`, turn and axes are rounded, and in the same way in every step. The momentum that the rates leave over
        // measures their error.
        let spin = axes.apply_transposed(first);
        let left = momentum.minus(inertia.apply(turn.apply_plus(spin, spin)));
        let rates = axes.apply(turned_back(inverse, &turn, left)).plus(first);
        let spin = axes.apply_transposed(rates);
        let (spin, com) = (turn.apply_plus(spin, spin), Vector::splat(&known.com));
        let com = turn.apply_plus(com, com);
        let gained = Vector(gravity.map(E::splat)).times(E::splat(stages.step));
        let of_anchor = gained.plus(Vector::splat(&known.velocity)).minus(spin.cross(com));
        // The same for the axes of the translations.
        let axes = axes_of(start, TRANSLATIONS);
        let first = axes.apply(of_anchor);
        let speeds = axes.apply(of_anchor.minus(axes.apply_transposed(first))).plus(first);
        for (own, rate) in velocity.iter_mut().zip(speeds.0.into_iter().chain(rates.0)) {
            *own = rate.lane(0);
        }
    }
}
