//! A body on a hinge that the world holds: one equation a row, where a body in space has six.
//!
//! It turns about an axis `a` that never moves, by `N_i = s_i â + v_i â²` with the sine `s = sin φ` and the versine `v = 1 − cos φ`. Of its
//! residual ([`crate::equations::residual`]) nothing but the torque about `a` is asked for, and two numbers are mixed instead of twelve:
//!
//! ```text
//!     S_k = Σ_i B_ki (s_i − h c_i ω),   V_k = Σ_i B_ki v_i
//!     e_k = I (S_k cos φ_k + V_k sin φ_k) − h² m (g·(a × c) cos φ_k + g·(a × (a × c)) sin φ_k)        [kg m²]
//!     I   = aᵀ J a + m |a × c|²                                                                       [kg m²]
//! ```
//!
//! with the arm `c` from the axis to the centre of mass and the rate `ω`, both at the start of the step. That is `a·(e_k + c_k × f_k)` of the
//! general terms, because `â³ = −â` and `tr(â² Σ) = −aᵀ J a`. At the end of the step the same with the momentum weights `w_i`:
//!
//! ```text
//!     π = I ((ω + h⁻¹ Σ_i w_i (s_i − h c_i ω)) cos φ_s + h⁻¹ Σ_i w_i v_i sin φ_s) + h b_s m (…)       [kg m²/s]
//! ```

use crate::numbers::algebra::Vector;
use crate::numbers::arithmetic::Arithmetic;
use crate::stages::pose::StagePose;
use crate::stages::rows::Rows;
use crate::stages::start::Pivot;

/// Sine and versine of the turn of a body about an axis.
#[inline(always)]
pub fn turned_about<V: Arithmetic>(pose: &StagePose<V>, axis: &[V::Real; 3]) -> [V; 2] {
    let half = pose.u.dot(Vector::splat(axis));
    let twice = half + half;
    [pose.w * twice, half * twice]
}

/// `e` of a body about its axis; for momenta `−π`.
#[inline(always)]
pub fn pivot_torque<V: Arithmetic, R: Rows<V>>(
    rows: &R,
    body: usize,
    known: &Pivot<V::Real>,
    axis: &[V::Real; 3],
    rate: V::Real,
) -> V {
    let turned = turned_about(&rows.pose(body), axis);
    let [sines, versines] = rows.swing(body, axis, rate, turned);
    // From here on: the geometry of the rows.
    let [sine, versine] = [turned[0] * rows.moved(), turned[1] * rows.moved()];
    let cosine = V::splat(1.0) - versine;
    let moment = V::whole(known.inertia) * versines.mul_add(sine, sines * cosine);
    let [now, later] = known.weights.map(V::whole);
    let weight = later.mul_add(sine, now * cosine);
    weight.neg_mul_add(rows.forces(), if R::MOMENTA { -moment } else { moment })
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

    /// Two bodies on the world, one of which carries another, on frames that are aligned with nothing.
    fn two_trees() -> Mechanism {
        let body = |name: &str, parent, askew: f64| {
            let frame = |at: f64| {
                let turn = Rotation3::from_euler_angles(at, askew - 0.4 * at, 0.5 - askew);
                Pose::from_parts(Translation3::new(0.3 * at, -0.1, 0.4 * askew), turn)
            };
            let joint = Joint::new(name, JointKind::Revolute, frame(0.7), frame(-0.5));
            Body { name: name.into(), parent, mass: 1.0 + askew, inertia: Vector3::new(0.05, 0.08, 0.1), joint }
        };
        let bodies = vec![body("held", None, 0.9), body("carried", Some(0), 0.2), body("also held", None, 0.5)];
        Mechanism::new("two trees", Vector3::new(1.0, -2.0, -9.0), bodies).unwrap()
    }

    /// Increments of an iteration with new factors and of the next, which keeps them, and the velocities after both.
    fn step<V: Lanes>(mechanism: &Mechanism, plan: &Plan) -> Vec<f64> {
        let tableau = Tableau::of(V::COUNT.min(8) + 1).unwrap();
        let mut state = State::zero(mechanism);
        state.position.copy_from_slice(&[0.4, -0.9, 2.0]);
        state.velocity.copy_from_slice(&[3.0, -2.0, 5.0]);
        let mut stages = Stages::<V>::planned(plan.clone(), mechanism, tableau);
        stages.start.set(mechanism, &state);
        stages.step = 0.05;
        let gravity = mechanism.gravity.into();
        let mut velocities = vec![0.0; 3];
        let mut ending = Ending::new(plan, 3, tableau);
        V::run(|| {
            stages.sweep_poses();
            stages.sweep_residual(&gravity);
            stages.sweep_increments();
            stages.advance();
            let first = stages.increment.clone();
            stages.sweep_poses();
            stages.sweep_wrenches::<false>(&gravity);
            stages.sweep_increments();
            ending.velocities::<V, true, false>(&stages, &gravity, &mut velocities);
            let lanes = |own: &V| own.to_array().as_ref().to_vec();
            let increments = first.iter().chain(&stages.increment).flat_map(lanes);
            increments.chain(velocities.iter().copied()).collect()
        })
    }

    fn one_equation_is_as_good_as_six<V: Lanes>() {
        let mechanism = two_trees();
        let [one, six] = [&[][..], &[Rule::Pivots]].map(|kept| Plan::lean(&mechanism, kept));
        assert_eq!(one.bodies.iter().map(|body| body.pivot).collect::<Vec<_>>(), [Some(0), None, Some(1)]);
        let (one, six) = (step::<V>(&mechanism, &one), step::<V>(&mechanism, &six));
        for (index, (one, six)) in one.iter().zip(&six).enumerate() {
            // Some roundings of displacements of a quarter, which the mixing of stages magnifies by up to a hundred.
            assert!((one - six).abs() < 1e-13, "number {index}: {one} and {six}");
        }
        // What there is to be told apart.
        assert!(one.iter().all(|&one| one == 0.0 || one.abs() > 1e-8), "{one:?}");
    }

    #[test]
    fn a_body_that_the_world_holds_takes_the_step_of_its_six_equations_in_every_vector() {
        in_every_vector!(one_equation_is_as_good_as_six);
    }
}
