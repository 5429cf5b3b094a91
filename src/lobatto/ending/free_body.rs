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

#[cfg(test)]
mod tests {
    use crate::ending::velocities::Ending;
    use crate::numbers::lanes::Lanes;
    use crate::plan::tree::Plan;
    use crate::stages::workspace::Stages;
    use crate::tableau::butcher::Tableau;
    use crate::vectors::in_every_vector;
    use catena_mechanism::description::joint::{Joint, JointKind, Pose};
    use catena_mechanism::description::mechanism::{Body, Mechanism};
    use catena_mechanism::description::rules::Rule;
    use catena_mechanism::motion::state::State;
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
