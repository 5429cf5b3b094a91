//! Sensors read what mechanics says, in motions that are known.

use crate::robot;
use catena::prelude::*;
use catena::session::Noise;
use nalgebra::Vector3;

const GRAVITY: f64 = 9.81;

#[test]
fn a_unit_in_free_fall_reads_no_weight_and_one_at_rest_reads_all_of_it() {
    let model = Model::loader().floating().load(robot("tumbling_body.urdf")).expect("a model");
    let (q, _) = model.start().expect("a start");
    let link = model.link_names()[0].to_string();
    let mut simulation = Simulation::new(&model).start_from(&q, &[0.0, 0.0, 0.0, 0.0, 0.0, 2.0]).expect("a start");
    simulation.step_to(0.1).expect("it falls");
    let felt = simulation.sense().expect("readings").imu(&link, [0.0; 3]).expect("a link");
    // The frame is at the centre of mass.
    assert!(felt.fixed_rows::<3>(0).amax() < 1e-10, "{felt}");
    assert!((felt.fixed_rows::<3>(3).norm() - 2.0).abs() < 0.2, "it turns: {felt}");

    let model = Model::load(robot("quadruped_dropped.toml")).expect("a model");
    let mut simulation = Simulation::new(&model).tolerance(1e-6);
    simulation.step_to(3.0).expect("it stands");
    let sensed = simulation.sense().expect("readings");
    let felt = sensed.imu("trunk", [0.1, 0.0, 0.0]).expect("a link");
    // It still sinks into its knees by a micrometre a second.
    assert!((felt.fixed_rows::<3>(0).norm() - GRAVITY).abs() < 1e-3, "{felt}");
    let feet: Vec<&str> = model.link_names().into_iter().filter(|name| name.ends_with("foot")).collect();
    let forces = feet.iter().map(|foot| sensed.contact_force(foot).expect("a link"));
    let weight = model.description().mechanism.total_mass() * GRAVITY;
    let sum: Vector3<f64> = forces.sum();
    assert!((sum - weight * Vector3::z()).amax() < 1e-2, "{sum} {weight}");
    assert!(feet.iter().all(|foot| sensed.touches(foot).expect("a link")) && !sensed.touches("trunk").expect("a link"));
    assert!(sensed.imu("tail", [0.0; 3]).is_err() && sensed.joint_effort("tail").is_err());
}

#[test]
fn joints_of_an_arm_that_is_held_pass_on_what_holds_it() {
    let model = Model::load(robot("arm7.urdf")).expect("a model");
    let q = [0.0, 0.4, 0.2, -0.8, 0.1, 0.5, 0.0];
    let holding = model.gravity_efforts(&q).expect("efforts");
    let mut simulation = Simulation::new(&model).start_from(&q, &[0.0; 7]).expect("a start");
    simulation.set_efforts(holding.as_slice()).expect("efforts");
    simulation.step_to(0.01).expect("it rests");
    let sensed = simulation.sense().expect("readings");
    for (joint, effort) in model.joint_names().into_iter().zip(holding.iter()) {
        let read = sensed.joint_effort(joint).expect("a joint");
        assert!((read - effort).abs() < 1e-8 * (1.0 + holding.amax()), "{joint}: {read} {effort}");
    }
    // The first joint carries the weight of all that moves, upwards; its axis is vertical.
    let wrench = sensed.wrench("joint1").expect("a joint");
    let weight = model.description().mechanism.total_mass() * GRAVITY;
    assert!((wrench.fixed_rows::<3>(0).norm() - weight).abs() < 1e-8 * weight, "{wrench}");
}

#[test]
fn noise_has_its_bias_and_deviation_and_is_the_same_from_the_same_seed() {
    let mut readings = vec![0.0; 40_000];
    Noise::new(0.5, 2.0, 7).add(&mut readings);
    let mut again = vec![0.0; 40_000];
    Noise::new(0.5, 2.0, 7).add(&mut again);
    assert_eq!(readings, again);
    let mean = readings.iter().sum::<f64>() / 4e4;
    let variance = readings.iter().map(|reading| (reading - mean).powi(2)).sum::<f64>() / 4e4;
    // Five standard errors: 2/√40000 of the mean, 4 √(2/40000) of the variance.
    assert!((mean - 0.5).abs() < 0.05 && (variance - 4.0).abs() < 0.15, "{mean} {variance}");
    Noise::new(0.0, 1.0, 8).add(&mut again);
    assert_ne!(readings, again);
}
