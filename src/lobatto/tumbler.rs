//! A body that floats freely under gravity alone: three equations a row instead of six.
//!
//! Its centre of mass follows a parabola, which the scheme meets at every stage, so that nothing is left to be solved for there; and nothing
//! couples it to the rotation. With the rotation vector `θ_k` since the start, `N_k` and `e_k` as in [`super::residual`], and the inertia `J₀`
//! about the centre of mass at the start, the Newton step needs no elimination:
//!
//! ```text
//!     Δx_i = h c_i v + ½ (h c_i)² g                                                                          [m]
//!     J_k = (1 + N_k) J₀ (1 + N_k)ᵀ,   φ = (1 + N_k) T(θ_k) α   (the spin of a change α of θ_k)
//!     α_k = −T(θ_k)⁻¹ J₀⁻¹ (1 + N_k)ᵀ e_k,   T⁻¹ ≈ 1 + ½ θ̂ + κ θ̂²                                           [rad]
//! ```
//!
//! At the end of the step the rates of the joint are what `y` has along the axes of the start, and the velocity of the centre of mass, from which
//! the joint's anchor is `−(1 + N) c`, is `v + h g`:
//!
//! ```text
//!     J_s (1 + N_s) y = π:     y₀ = J₀⁻¹ (1 + N_s)ᵀ π,   y = y₀ + J₀⁻¹ (1 + N_s)ᵀ (π − J_s (1 + N_s) y₀)           [rad/s]
//! ```

use super::algebra::{Matrix, Symmetric, Vector};
use super::ending::Ending;
use super::numbers::{Arithmetic, Numbers};
use super::residual::spin_residual;
use super::stage::{StagePose, Stages, largest};
use super::start::Start;
use super::turns::{EACH, FEW, rotate_increment, untilted};
use std::ops::Range;

/// Its translations, and its rotations.
pub(super) const TRANSLATIONS: Range<usize> = 0..3;
const ROTATIONS: Range<usize> = 3..6;
/// Up to this displacement [`FEW`] terms are enough.
const FEW_EACH: f64 = EACH * FEW;

/// `J₀⁻¹ (1 + N)ᵀ e`.
#[inline(always)]
fn turned_back<V: Arithmetic>(inverse: &[V::Real; 6], turn: &Matrix<V>, torque: Vector<V>) -> Vector<V> {
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

    /// The poses of all stages, and how far the joint has moved, which nobody asks for while a step is iterated.
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
        // One round of refinement: `J₀⁻¹`, turn and axes are rounded, and in the same way in every step. What the rates leave of the momentum
        // says how far they are off for it.
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

/// The axes of some degrees of freedom, as rows.
#[inline(always)]
fn axes_of<V: Arithmetic>(start: &Start<V::Real>, freedoms: Range<usize>) -> Matrix<V> {
    let axis = |index: usize| Vector::splat(&start.axes[freedoms.start + index]).0;
    Matrix([axis(0), axis(1), axis(2)])
}

#[cfg(test)]
mod tests {
    use crate::lobatto::ending::Ending;
    use crate::lobatto::lanes::{Lanes, in_every_vector};
    use crate::lobatto::plan::Plan;
    use crate::lobatto::stage::Stages;
    use crate::lobatto::tableau::Tableau;
    use crate::model::{Body, Joint, JointKind, Mechanism, Pose, Rule};
    use crate::state::State;
    use nalgebra::{Rotation3, Translation3, Vector3};

    /// A body held by a frame that is neither at its centre of mass nor along its axes.
    fn thrown() -> Mechanism {
        let frame = |at: f64| {
            let turn = Rotation3::from_euler_angles(at, 0.9 - 0.4 * at, -0.4);
            Pose::from_parts(Translation3::new(0.3 * at, -0.1, 0.4), turn)
        };
        let joint = Joint::new("thrown", JointKind::Floating, frame(0.7), frame(-0.5));
        let inertia = Vector3::new(0.05, 0.08, 0.1);
        let body = Body { name: "body".into(), parent: None, mass: 1.4, inertia, joint };
        Mechanism::new("thrown", Vector3::new(1.0, -2.0, -9.0), vec![body]).unwrap()
    }

    /// Displacements at all stages of a solved step, and the velocities at its end.
    fn step<V: Lanes>(mechanism: &Mechanism, plan: &Plan) -> Vec<f64> {
        let tableau = Tableau::of(V::COUNT.min(8) + 1).unwrap();
        let mut state = State::zero(mechanism);
        state.velocity.copy_from_slice(&[1.0, -2.0, 3.0, 4.0, -5.0, 6.0]);
        let mut stages = Stages::<V>::planned(plan.clone(), mechanism, tableau);
        stages.start.set(mechanism, &state);
        stages.step = 0.05;
        let gravity = mechanism.gravity.into();
        let mut velocities = vec![0.0; 6];
        let mut ending = Ending::new(plan, 6, tableau);
        V::run(|| {
            // Each leaves a hundredth of the last increment, with six equations a tenth.
            for _ in 0..25 {
                if plan.tumbles {
                    stages.tumble::<false>(&gravity);
                } else {
                    stages.sweep_poses();
                    stages.sweep_residual(&gravity);
                    stages.sweep_increments();
                }
                stages.advance();
            }
            if plan.tumbles {
                stages.place_tumbler(&gravity);
                ending.tumbler_velocities(&stages, &gravity, &mut velocities);
            } else {
                stages.sweep_poses();
                ending.velocities::<V, true, false>(&stages, &gravity, &mut velocities);
            }
            let lanes = |own: &V| own.to_array().as_ref()[..tableau.stages - 1].to_vec();
            stages.displacement.iter().flat_map(lanes).chain(velocities.iter().copied()).collect()
        })
    }

    fn three_equations_are_as_good_as_six<V: Lanes>() {
        let mechanism = thrown();
        let [three, six] = [&[][..], &[Rule::Tumblers]].map(|kept| Plan::lean(&mechanism, kept));
        assert!(three.tumbles && !six.tumbles);
        let (three, six) = (step::<V>(&mechanism, &three), step::<V>(&mechanism, &six));
        for (index, (three, six)) in three.iter().zip(&six).enumerate() {
            // Roundings of velocities of some metres a second, magnified by the mixing of stages.
            assert!((three - six).abs() < 1e-13, "number {index}: {three} and {six}");
        }
        // What there is to be told apart: within a step the body turns by 25 degrees, and gravity moves it by a centimetre.
        assert!(three.iter().any(|number| number.abs() > 0.2), "{three:?}");
    }

    #[test]
    fn a_body_that_floats_freely_takes_the_step_of_its_six_equations_in_every_vector() {
        in_every_vector!(three_equations_are_as_good_as_six);
    }
}
