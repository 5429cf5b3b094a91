//! Stiff dampers: stable at any step, limited under a spring where documented, and accurate in slow motion.

use super::{damper, fixed, one_body, run};
use catena::lobatto::tableau::butcher::Tableau;
use catena::mechanism::description::forces::Forces;
use catena::mechanism::description::joint::JointKind;
use catena::mechanism::motion::integrator::Integrator;
use catena::stepping::integrator::Lobatto;
use nalgebra::{DMatrix, DVector, Vector3};

#[test]
fn any_damper_alone_is_stable_for_any_step() {
    // y'' = −c y' with z = h c: v̄ = v₀ − z Σ b_k V_k, V = v₀ − z Ā V. The amplification is the diagonal Padé approximant of
    // exp(−z), which never exceeds one.
    for stages in 2..=16 {
        let tableau = Tableau::of(stages).unwrap();
        let a_bar = DMatrix::from_row_slice(stages, stages, &tableau.a_bar);
        let ones = DVector::from_element(stages, 1.0);
        for exponent in -20..=60 {
            let z = 10_f64.powf(0.1 * f64::from(exponent));
            let rates = (DMatrix::identity(stages, stages) + &a_bar * z).lu().solve(&ones).unwrap();
            let growth = 1.0 - z * rates.dot(&DVector::from_vec(tableau.weights.clone()));
            assert!(growth.abs() < 1.0, "s={stages}, h c = {z:.1e}: {growth}");
        }
    }
}

/// Growth of the solutions of `y'' = −ω² y − 2ζω y'` in one step with h = 1: spectral radius of the step.
fn growth(tableau: &Tableau, omega: f64, damping_ratio: f64) -> f64 {
    let s = tableau.stages;
    let (stiffness, damping) = (omega * omega, 2.0 * damping_ratio * omega);
    let a = DMatrix::from_row_slice(s, s, &tableau.a);
    let a_bar = DMatrix::from_row_slice(s, s, &tableau.a_bar);
    let weights = DVector::from_vec(tableau.weights.clone());
    let ones = DVector::from_element(s, 1.0);
    // F = −k Y − c V,  V = v₀ + Ā F,  Y = y₀ + A V.
    let system = (DMatrix::identity(s, s) + &a * &a_bar * stiffness + &a_bar * damping).lu();
    let by_position = system.solve(&(&ones * -stiffness)).unwrap();
    let by_velocity = system.solve(&(&a * &ones * -stiffness - &ones * damping)).unwrap();
    let step = nalgebra::Matrix2::new(
        1.0 + weights.dot(&(&a_bar * &by_position)),
        1.0 + weights.dot(&(&a_bar * &by_velocity)),
        weights.dot(&by_position),
        1.0 + weights.dot(&by_velocity),
    );
    step.complex_eigenvalues().iter().map(|value| value.norm()).fold(0.0, f64::max)
}

#[test]
fn spring_under_a_hard_damper_limits_the_step_at_the_documented_place() {
    // doc/decisions/007-stability-with-springs-and-dampers.md: h ω = (s − 1) √(2s) for any hard damper; a per mille to either side.
    for stages in 2..=9 {
        let tableau = Tableau::of(stages).unwrap();
        let limit = (stages as f64 - 1.0) * (2.0 * stages as f64).sqrt();
        assert!(growth(tableau, 0.999 * limit, 1e3) < 1.0, "s={stages}");
        assert!(growth(tableau, 1.001 * limit, 1e3) > 1.0, "s={stages}");
    }
}

#[test]
fn slow_motion_under_a_stiff_damper_keeps_its_accuracy_at_thousands_of_its_time_constants() {
    // A pendulum in honey: c θ' = −m g l sin θ but for the inertia, tan(θ/2) = tan(θ₀/2) exp(−t m g l / c). The damper's time
    // constant I/c is 3e-5 s; the steps are 3000 times longer.
    let coefficient = 1e4;
    let mut model =
        one_body(JointKind::Revolute, 0.5, 9.81, Forces { joint_dampers: damper(coefficient), ..Forces::default() });
    let fall = 9.81 * 0.5 / coefficient;
    model.state.position[0] = 2.0;
    model.state.velocity[0] = -fall * 2.0_f64.sin();
    for stages in [2, 3, 5, 9] {
        let (end, summary) = run(&model, &mut fixed(&model, stages, 0.1), 100.0);
        let expected = 2.0 * (1.0_f64.tan() * (-100.0 * fall).exp()).atan();
        let error = (end.position[0] - expected).abs();
        println!(
            "s={stages}: {error:.1e}, {} iterations, halved {}",
            summary.cost.iterations,
            summary.cost.rejected.total()
        );
        // The inertia left out of the formula changes the motion by (m g l / c)² I / (m g l) of itself: below 1e-8.
        assert!(error < 1e-7, "s={stages}: {error:.1e}");
        // No step is halved: with nine stages the simplified iteration gives up now and then before the exact one is asked.
        assert_eq!(summary.steps, 1000, "s={stages}");
    }
}

#[test]
fn a_motion_that_hard_dampers_stop_is_stopped_with_a_tolerance_and_said_to_ring_in_long_fixed_steps() {
    // A finger of 1e-6 kg m² behind a damper of 1 N m s: it stops within a microsecond, after v/γ.
    for (rate, hardness) in [(2.0, 1.0), (-1.0, 1e3), (3.0, 0.01)] {
        let mut model =
            one_body(JointKind::Revolute, 0.0, 0.0, Forces { joint_dampers: damper(hardness), ..Forces::default() });
        model.mechanism.bodies[0].inertia = Vector3::repeat(1e-6);
        model.state.position[0] = 0.0;
        model.state.velocity[0] = rate;
        let decay = hardness / 1e-6;
        let mut chosen = Lobatto::adaptive(&model.mechanism, 1e-6);
        let (end, summary) = run(&model, &mut chosen, 1.0);
        // Short steps are iterated as far as others, to 1e-10 rad, which is more of a velocity; what is left of it rings in long ones.
        assert!(end.velocity[0].abs() < 1e-6, "{hardness}: {} rad/s left", end.velocity[0]);
        // What the first step, too long, has left of the way.
        assert!((end.position[0] - rate / decay).abs() < 1e-6, "{hardness}: at {:e}", end.position[0]);
        assert!(summary.steps < 80, "{hardness}: {} steps", summary.steps);
        assert_eq!(chosen.description().ringing, None);

        let mut long = fixed(&model, 9, 0.1);
        let (rings, _) = run(&model, &mut long, 0.1);
        let seen = long.description().ringing.unwrap();
        assert!((seen.decay / decay - 1.0).abs() < 1e-6, "{hardness}: {seen:?}");
        assert!(rings.velocity[0].abs() > 0.5 * rate.abs(), "{hardness}: {} rad/s", rings.velocity[0]);
        let mut short = fixed(&model, 9, seen.longest);
        let (stopped, _) = run(&model, &mut short, 8.0 * seen.longest);
        // Nothing but what the iteration leaves, 1e-12 rad or less, times 36 over the step.
        assert!(stopped.velocity[0].abs() < 36e-12 / seen.longest, "{hardness}: {} rad/s", stopped.velocity[0]);
        assert_eq!(short.description().ringing, None);
    }
}
