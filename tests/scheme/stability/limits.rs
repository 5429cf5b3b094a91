//! The limits of the pair: where they are, that a step beyond one is named, and that chosen steps stay below.

use super::{rod_on_a_hinge, taut_chain};
use catena::lobatto::tableau::butcher::Tableau;
use catena::lobatto::tableau::stability::{damped_limit, limit};
use catena::mechanism::motion::integrator::{Integrator, StepError};
use catena::stepping::integrator::Lobatto;

#[test]
fn the_stability_limits_are_those_of_the_pair() {
    // Known in closed form: 2 for Störmer and Verlet, √8 for three stages; the others by independent computation
    // (a scan of the 2 x 2 propagation with the tableau from another program), to the digits given.
    let known = [(2, 2.0), (3, 8f64.sqrt()), (4, 5.477), (5, 6.054), (6, 8.841), (7, 9.267), (8, 12.15), (9, 12.46)];
    for (stages, expected) in known {
        let found = limit(Tableau::of(stages).unwrap());
        assert!((found - expected).abs() < 1e-3 * expected, "{stages} stages: {found}, expected {expected}");
    }
}

#[test]
fn a_fixed_step_beyond_the_limit_is_named_and_a_chosen_one_stays_below() {
    // A heavy mass at the end of three light links, turning about the hinge as fast as 20 rad/s: the links' own motion
    // across the string is some hundred times faster than what is seen.
    let model = taut_chain();
    let mechanism = &model.mechanism;
    let nearest = |mut lobatto: Lobatto, end: f64| {
        let mut state = model.state.clone();
        let ended = std::iter::from_fn(|| (state.time < end).then(|| lobatto.advance(mechanism, &mut state, end)))
            .find_map(Result::err);
        (lobatto.description().frequency_step.unwrap(), ended)
    };
    let fixed = |stages, step| nearest(Lobatto::fixed(mechanism, stages, step).unwrap(), 0.3);
    let (short, ended) = fixed(9, 1e-3);
    println!("{short:?}");
    assert!(ended.is_none() && !short.is_unstable(), "{short:?}");
    let (long, _) = fixed(3, 0.5 * short.step * 9.0);
    println!("{long:?}");
    assert!(long.is_unstable(), "{long:?}");
    for tolerance in [1e-2, 1e-4, 1e-6] {
        let (chosen, ended) = nearest(Lobatto::adaptive(mechanism, tolerance), 1.0);
        println!("{chosen:?}");
        assert!(ended.is_none() && chosen.product < 0.9 * chosen.limit, "tolerance {tolerance}: {chosen:?}");
    }
}

#[test]
fn a_spring_beyond_the_limit_is_named_from_the_first_step_and_chosen_steps_stay_below_it() {
    // 30 rad at a step of 0.1 s without a damper, and 45 with a light one: beyond the limit of 9 stages in both cases.
    for (stiffness, damping) in [(3e4, 0.0), (6.8e4, 3.0)] {
        let model = rod_on_a_hinge(stiffness, damping);
        let mut state = model.state.clone();
        let mut lobatto = Lobatto::fixed(&model.mechanism, 9, 0.1).unwrap();
        let ended = lobatto.advance(&model.mechanism, &mut state, 0.1);
        let seen = lobatto.description().frequency_step;
        assert!(
            seen.is_some_and(|seen| seen.is_unstable()) || matches!(ended, Err(StepError::Unstable { .. })),
            "{seen:?} {ended:?}"
        );
        for tolerance in [1e-2, 1e-6] {
            let mut state = model.state.clone();
            let mut lobatto = Lobatto::adaptive(&model.mechanism, tolerance);
            while state.time < 1.0 {
                lobatto.advance(&model.mechanism, &mut state, 1.0).unwrap();
            }
            let seen = lobatto.description().frequency_step.unwrap();
            assert!(!seen.is_unstable(), "tolerance {tolerance}: {seen:?}");
        }
    }
}

#[test]
fn a_damped_spring_is_stable_just_below_its_limit_and_grows_just_above() {
    for stages in [3, 5, 9] {
        let tableau = Tableau::of(stages).unwrap();
        for ratio in [0.02, 0.1, 0.5] {
            let limit = damped_limit(tableau, ratio);
            let growth = |product: f64| {
                let frequency = 100.0;
                let inertia = 1.0 / 3.0;
                let mut model = rod_on_a_hinge(inertia * frequency * frequency, 2.0 * ratio * frequency * inertia);
                model.state.position[0] = 1e-6;
                let step = product / frequency;
                let mut lobatto = Lobatto::fixed(&model.mechanism, stages, step).unwrap();
                let mut largest = [0.0_f64; 2];
                for index in 0..600 {
                    let until = model.state.time + step;
                    if lobatto.advance(&model.mechanism, &mut model.state, until).is_err() {
                        return f64::INFINITY;
                    }
                    let half = &mut largest[index / 300];
                    *half = half.max(model.state.position[0].abs());
                }
                largest[1] / largest[0]
            };
            // Found in strides of 0.05; for ½ and more the least limit of all such ratios stands for them, and the true one of ½ lies higher.
            assert!(growth(0.99 * limit) < 1.0, "{stages} stages, ratio {ratio}: grows below {limit}");
            if ratio < 0.5 {
                let grows = (1..=6).any(|hundredths| growth(limit + 0.01 * f64::from(hundredths)) > 1.0);
                assert!(grows, "{stages} stages, ratio {ratio}: stable above {limit}");
            }
        }
    }
}
