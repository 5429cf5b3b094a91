//! Derivatives of eigenvalues by numbers, and multipliers of motions that come back, against closed forms.

use crate::sensitivity_events::scene;
use crate::{folder, robot};
use catena::prelude::*;
use nalgebra::Complex;

#[test]
fn the_eigenvalues_of_an_oscillator_have_the_derivatives_of_their_closed_form() {
    let model = Model::load(robot("damped_oscillator.toml")).expect("a model");
    let at_rest = |model: &Model| model.linearize_at_rest(None);
    let linear = at_rest(&model).expect("linear equations");
    let keys = ["spring.spring.stiffness", "spring.spring.damping", "link.mass.mass"];
    let params = model.params().expect("numbers");
    let mass = params.iter().find(|(key, value)| key.ends_with(".mass") && value.is_some_and(|value| value != 0.0));
    let keys = [keys[0], keys[1], mass.map(|(key, _)| key.as_str()).expect("a mass")];
    let found = model.eigenvalues_by(&linear, &keys, at_rest).expect("derivatives");
    // m λ² + c λ + k = 0:  ∂λ/∂k = −1/(2 m λ + c),  ∂λ/∂c = −λ/(2 m λ + c),  ∂λ/∂m = −λ²/(2 m λ + c)
    let value = Complex::new(-2.0, 96.0_f64.sqrt());
    let below = -(value * 2.0 + 4.0);
    for (of, wanted) in found.iter().zip([below.inv(), value / below, value * value / below]) {
        let by = of.by[0].expect("a derivative");
        // Differences over 0.004 of a number have roundings of 1e-12 of the matrix.
        assert!((by - wanted).norm() < 1e-9 * wanted.norm(), "{}: {by} and {wanted}", of.key);
    }
}

#[test]
fn frequencies_of_a_pendulum_go_with_the_root_of_gravity_and_equal_ones_have_no_derivative() {
    let model = Model::load(robot("double_pendulum.urdf")).expect("a model");
    let at_rest = |model: &Model| model.linearize_at_rest(None);
    let linear = at_rest(&model).expect("linear equations");
    let found = model.eigenvalues_by(&linear, &["gravity.z"], at_rest).expect("derivatives");
    for (mode, by) in linear.modes.iter().zip(&found[0].by) {
        let by = by.expect("a derivative").im;
        let wanted = mode.eigenvalue.im / (2.0 * -9.81);
        // As for an oscillator.
        assert!((by - wanted).abs() < 1e-9 * wanted.abs(), "{by} and {wanted}");
    }
    // Two equal pendulums side by side.
    let pendulum = robot("pendulum.urdf");
    let one = |name: &str| format!("[[robot]]\nname = \"{name}\"\nurdf = {pendulum:?}\n");
    let twins = Model::load(scene("twins.toml", &format!("{}{}", one("a"), one("b")))).expect("a model");
    let linear = at_rest(&twins).expect("linear equations");
    let found = twins.eigenvalues_by(&linear, &["gravity.z"], at_rest).expect("derivatives");
    assert!(found[0].by.iter().all(Option::is_none), "{:?}", found[0].by);
    let refused = model.eigenvalues_by(&linear, &["nonsense"], at_rest).expect_err("no number").to_string();
    assert!(refused.contains("no parameter"), "{refused}");
    let _ = folder("linear_slopes");
}

#[test]
fn multipliers_of_an_equilibrium_are_the_exponentials_of_its_eigenvalues() {
    for (file, loops) in [("damped_oscillator.toml", false), ("double_pendulum.urdf", false), ("four_bar_1.toml", true)]
    {
        let model = Model::load(robot(file)).expect("a model");
        let linear = model.linearize_at_rest(None).expect("linear equations");
        let still = vec![0.0; linear.v.len()];
        let period = 0.3;
        let run = Simulation::new(&model).tolerance(1e-10).duration(period).start_from(&linear.q, &still);
        let found = run.expect("a start").multipliers().expect("multipliers");
        assert_eq!(found.values.len(), linear.a.nrows(), "{file}: {:?}", found.values);
        assert!(found.apart < 1e-7, "{file}: {}", found.apart);
        for mode in &linear.modes {
            let wanted = (mode.eigenvalue * period).exp();
            let off = found.values.iter().map(|value| (value - wanted).norm()).fold(f64::INFINITY, f64::min);
            // Equilibria are found to 1e-9; loops are closed to 1e-9.
            let bound = if loops { 1e-6 } else { 1e-8 };
            assert!(off < bound, "{file}: {wanted} is {off:e} from {:?}", found.values);
        }
    }
}

#[test]
fn a_swing_that_comes_back_has_two_multipliers_of_one_and_closes() {
    // A spring of 100 N/m on 1 kg without its damper: 2π/10 s.
    let model =
        Model::loader().set("spring.spring.damping", 0.0).load(robot("damped_oscillator.toml")).expect("a model");
    let period = std::f64::consts::TAU / 10.0;
    let found = Simulation::new(&model).tolerance(1e-10).duration(period).multipliers().expect("multipliers");
    assert!(found.apart < 1e-8, "{}", found.apart);
    for value in &found.values {
        // Both are one to the root of the error of the step.
        assert!((value - 1.0).norm() < 1e-4, "{value}");
    }
}
