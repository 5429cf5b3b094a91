//! Velocities, accelerations and Jacobians of points, centre of mass, momentum, and dynamics with loops, against differences along runs and against
//! each other.

use crate::robot;
use catena::prelude::*;
use catena::session::Left;
use nalgebra::{DVector, Vector3, Vector6};

fn numbers(count: usize, seed: f64) -> Vec<f64> {
    (0..count).map(|index| (seed + 1.7 * index as f64).sin()).collect()
}

/// A model, its start with some velocities, and efforts; loops take what velocities they allow.
fn moving(name: &str, floating: bool) -> (Model, Vec<f64>, Vec<f64>, Vec<f64>) {
    let mut loader = if floating { Model::loader().floating() } else { Model::loader() };
    // The equations of motion have smooth forces alone.
    for left in [Left::Motors, Left::Friction, Left::Limits] {
        loader = loader.without(left);
    }
    let model = loader.load(robot(name)).expect("a model");
    let (q, v) = model.start().expect("a start");
    let (wanted, efforts) = (numbers(v.len(), 0.8), numbers(v.len(), 2.1));
    let simulation = Simulation::new(&model).start_from(&q, &wanted);
    let (q, v) = match simulation {
        Ok(simulation) => simulation.coordinates().expect("coordinates"),
        // Velocities that contradict the loops.
        Err(_) => (q, v),
    };
    (model, q, v, efforts)
}

/// q and v after a time (s), under efforts.
fn after(model: &Model, q: &[f64], v: &[f64], efforts: &[f64], time: f64) -> (Vec<f64>, Vec<f64>) {
    let mut simulation = Simulation::new(model).duration(time).fixed(4, time).start_from(q, v).expect("a start");
    simulation.set_efforts(efforts).expect("efforts");
    simulation.run().expect("it runs");
    simulation.coordinates().expect("coordinates")
}

const POINT: [f64; 3] = [0.2, -0.1, 0.3];
/// A time over which differences are taken (s).
const SHORT: f64 = 1e-5;

#[test]
fn points_of_links_move_and_accelerate_as_runs_say() {
    for (name, floating, link) in [
        ("arm7.urdf", false, "flange"),
        ("humanoid.urdf", true, "left_shank"),
        ("spherical_chain.urdf", false, "link_3"),
        ("four_bar_2.toml", false, "coupler_1"),
    ] {
        let (model, q, v, efforts) = moving(name, floating);
        let names = model.link_names();
        let link = if names.contains(&link) { link } else { names[names.len() - 1] };
        let a = model.forward_dynamics(&q, &v, &efforts).expect("accelerations");
        let (later_q, later_v) = after(&model, &q, &v, &efforts, SHORT);
        let velocity = |q: &[f64], v: &[f64]| model.point_velocity(link, POINT, q, v).expect("a velocity");
        let place = |q: &[f64]| {
            let pose = model.pose(link, q).expect("a pose");
            pose.transform_point(&nalgebra::Point3::from(POINT)).coords
        };
        let (before, later) = (velocity(&q, &v), velocity(&later_q, &later_v));
        // Over 1e-5 s the mean of both velocities is the way over the time to h² times the third derivative, some 1e4 at most, and to the rounding of
        // positions over h.
        let way = (place(&later_q) - place(&q)) / SHORT;
        let mean = 0.5 * (before + later).fixed_rows::<3>(0);
        assert!((way - mean).amax() < 1e-5, "{name}: {way} {mean}");
        let jacobian = model.point_jacobian(link, POINT, &q).expect("a Jacobian");
        assert!((&jacobian * DVector::from_column_slice(&v) - before).amax() < 1e-12, "{name}");
        // A one-sided difference: h times the derivative of the acceleration, some 1e3.
        let acceleration = model.point_acceleration(link, POINT, &q, &v, a.as_slice()).expect("an acceleration");
        let difference = (later - before) / SHORT;
        let scale = 1.0 + acceleration.amax();
        assert!((difference - acceleration).amax() < 1e-2 * scale, "{name}: {difference} {acceleration}");
        // J a + J̇ v, to roundings.
        let bias = model.point_bias(link, POINT, &q, &v).expect("a bias");
        assert!((&jacobian * &a + bias - acceleration).amax() < 1e-11 * scale, "{name}");
    }
}

#[test]
fn momentum_is_that_of_the_centre_of_mass_and_is_kept_in_free_flight() {
    let model = Model::loader().floating().gravity([0.0; 3]).load(robot("humanoid.urdf")).expect("a model");
    let (q, _) = model.start().expect("a start");
    let v = numbers(model.coordinates().v_count(), 0.8);
    let mass = model.description().mechanism.total_mass();
    let before = model.momentum(&q, &v).expect("a momentum");
    let jacobian = model.center_of_mass_jacobian(&q).expect("a Jacobian");
    let of_center = mass * (jacobian * DVector::from_column_slice(&v));
    assert!((before.fixed_rows::<3>(0) - of_center).amax() < 1e-12 * before.amax());
    let mut simulation = Simulation::new(&model).tolerance(1e-9).start_from(&q, &v).expect("a start");
    simulation.step_to(0.2).expect("it flies");
    let (later_q, later_v) = simulation.coordinates().expect("coordinates");
    let later = model.momentum(&later_q, &later_v).expect("a momentum");
    // Dampers and springs are inside: the scheme keeps both momenta to roundings of some steps, and the tolerance is 1e-9.
    assert!((later - before).amax() < 1e-9 * before.amax(), "{before} {later}");
    let centers = [&q, &later_q].map(|q| model.center_of_mass(q).expect("a centre"));
    let way: Vector3<f64> = 0.2 / mass * before.fixed_rows::<3>(0);
    assert!((centers[1] - centers[0] - way).amax() < 1e-9, "a straight line: {centers:?} {way}");
}

#[test]
fn forward_dynamics_have_loops_and_joints_that_mimic_others_and_inverse_ones_undo_them() {
    for name in ["four_bar_2.toml", "stewart_platform.toml", "gripper.toml", "slider_crank.toml"] {
        let (model, q, v, efforts) = moving(name, false);
        assert!(model.description().mechanism.has_closures(), "{name}");
        let a = model.forward_dynamics(&q, &v, &efforts).expect("accelerations");
        let (_, later) = after(&model, &q, &v, &efforts, SHORT);
        let difference = (DVector::from_vec(later) - DVector::from_column_slice(&v)) / SHORT;
        // One-sided, as above.
        let scale = 1.0 + a.amax();
        assert!((&difference - &a).amax() < 1e-2 * scale, "{name}: {difference} {a}");
        let found = model.inverse_dynamics(&q, &v, a.as_slice()).expect("efforts");
        let again = model.forward_dynamics(&q, &v, found.as_slice()).expect("accelerations");
        assert!((again - &a).amax() < 1e-8 * scale, "{name}");
        // Of least norm: no other efforts with these accelerations are smaller.
        assert!(found.norm() <= DVector::from_vec(efforts).norm() * (1.0 + 1e-9), "{name}");
        let mut wrong = a.clone();
        wrong[a.len() - 1] += 1.0;
        let refused = model.inverse_dynamics(&q, &v, wrong.as_slice()).expect_err("the loops").to_string();
        assert!(refused.contains("away from any that the loops"), "{name}: {refused}");
    }
}

#[test]
fn one_motor_of_a_four_bar_gives_the_accelerations_that_all_efforts_gave() {
    let (model, q, v, efforts) = moving("four_bar_2.toml", false);
    let a = model.forward_dynamics(&q, &v, &efforts).expect("accelerations");
    let crank = model.joint_names()[0].to_string();
    let found = model.inverse_dynamics_by(&[&crank], &q, &v, a.as_slice()).expect("efforts");
    assert!(found.iter().filter(|effort| **effort != 0.0).count() == 1, "{found}");
    let again = model.forward_dynamics(&q, &v, found.as_slice()).expect("accelerations");
    assert!((again - &a).amax() < 1e-8 * (1.0 + a.amax()));
    assert!(model.inverse_dynamics_by(&["elbow"], &q, &v, a.as_slice()).is_err());
    let none: Vector6<f64> = model.point_velocity(model.link_names()[0], [0.0; 3], &q, &v).expect("a velocity");
    assert_eq!(none, Vector6::zeros(), "the base is fixed");
}
