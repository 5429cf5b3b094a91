//! Steps with 32 digits: the same motion as with 16, without what rounding adds to it in the longest runs.

use crate::models::Model;
use crate::{closed, models};
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::description::rules::Rule;
use catena::mechanism::motion::energy::energy;
use catena::mechanism::motion::integrator::Integrator;
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use catena::stepping::integrator::{Lobatto, MethodError};

/// The largest deviation of the energy from that at the start, and the mean of the last tenth less that of the first; over the largest
/// kinetic energy.
fn energy_errors(model: &Model, mut lobatto: Lobatto, steps: usize) -> (f64, f64) {
    let mechanism = &model.mechanism;
    let mut state = model.state.clone();
    let initial = energy(mechanism, &model.bodies()).total();
    let (mut largest, mut kinetic, mut means) = (0.0_f64, 0.0_f64, [0.0; 10]);
    for index in 0..steps {
        lobatto.advance(mechanism, &mut state, f64::INFINITY).unwrap();
        let now = energy(mechanism, &body_states(mechanism, &state));
        let deviation = now.total() - initial;
        (largest, kinetic) = (largest.max(deviation.abs()), kinetic.max(now.kinetic));
        means[10 * index / steps] += deviation / (steps / 10) as f64;
    }
    (largest / kinetic, (means[9] - means[0]) / kinetic)
}

#[test]
fn energy_keeps_to_the_rounding_of_one_state_over_twenty_thousand_steps() {
    let model = models::double_pendulum();
    let steps = 20_000;
    let (precise, moved) = energy_errors(&model, Lobatto::precise(&model.mechanism, 9, 0.0625).unwrap(), steps);
    let (ordinary, _) = energy_errors(&model, Lobatto::fixed(&model.mechanism, 9, 0.0625).unwrap(), steps);
    // What an energy is worked out with: some twenty roundings of 1.1e-16. Their mean over 2000 steps is a hundredth of that.
    assert!(precise < 5e-15, "{precise:.1e} of the kinetic energy");
    assert!(moved.abs() < 1e-16, "the mean moves by {moved:.1e}");
    // Or else this would say nothing.
    assert!(ordinary > 1e-13, "with 16 digits {ordinary:.1e}");
}

#[test]
#[ignore = "six minutes: cargo test --release --test scheme precise:: -- --ignored"]
fn energy_keeps_to_the_rounding_of_one_state_over_ten_million_steps() {
    let model = models::double_pendulum();
    let steps = 10_000_000;
    let (largest, moved) = energy_errors(&model, Lobatto::precise(&model.mechanism, 9, 0.0625).unwrap(), steps);
    println!("largest error {largest:.1e} of the kinetic energy, the mean moved by {moved:.1e}");
    // Measured: 3.5e-14, where once in a while the motion is so violent that the scheme itself is off for a moment, and 4.8e-18.
    assert!(largest < 1e-12 && moved.abs() < 1e-16, "{largest:.1e}, {moved:.1e}");
}

#[test]
fn every_joint_moves_as_with_sixteen_digits() {
    let mut all: Vec<Model> = models::JOINT_KINDS.into_iter().map(models::one_joint).collect();
    all.extend([models::double_pendulum(), models::floating_tree(), models::slow_heavy_top(), models::free_body()]);
    all.push(models::planar_chain(4));
    for model in all {
        let mechanism = &model.mechanism;
        for (stages, step) in [(2, 0.001), (5, 0.01), (9, 0.02)] {
            let end = |mut lobatto: Lobatto| {
                let mut state = model.state.clone();
                for _ in 0..50 {
                    lobatto.advance(mechanism, &mut state, f64::INFINITY).unwrap();
                }
                body_states(mechanism, &state)
            };
            let precise = end(Lobatto::precise(mechanism, stages, step).unwrap());
            let whole = end(Lobatto::precise(mechanism, stages, step).unwrap().keeping(mechanism, &Rule::ALL));
            let ordinary = end(Lobatto::fixed(mechanism, stages, step).unwrap());
            let (name, velocity) = (&mechanism.name, models::velocity_distance(&precise, &ordinary));
            let position = models::pose_distance(&precise, &ordinary);
            // Fifty steps that round by 1e-16 over h with weights of up to 36, and no motion here amplifies that tenfold.
            assert!(position < 1e-12 && velocity < 1e-11, "{name}, {stages}: {position:.1e} m, {velocity:.1e} m/s");
            // With nothing left out nothing changes but the last digit of the joint positions.
            let position = models::pose_distance(&precise, &whole);
            assert!(position < 1e-14, "{name}, {stages}: {position:.1e} m without the rules that leave something out");
        }
    }
}

#[test]
fn what_is_more_than_a_tree_under_gravity_or_has_more_than_nine_stages_is_refused() {
    let refused = |mechanism: &Mechanism, stages| Lobatto::precise(mechanism, stages, 0.01).err();
    let tree = models::double_pendulum();
    let sprung = models::joint_springs(&tree.mechanism);
    let (bricard, _): (Mechanism, State) = closed::bricard();
    assert_eq!(refused(&bricard, 5), Some(MethodError::NotPlain));
    assert_eq!(
        refused(&models::with_forces(models::double_pendulum(), sprung).mechanism, 5),
        Some(MethodError::NotPlain)
    );
    assert_eq!(refused(&tree.mechanism, 10), Some(MethodError::TooManyStages { stages: 10 }));
    assert!(matches!(refused(&tree.mechanism, 1), Some(MethodError::Tableau(_))));
    assert!(refused(&tree.mechanism, 9).is_none());
}
