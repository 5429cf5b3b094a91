//! What changes between steps goes through the run.

use crate::robot;
use catena::prelude::*;

/// A pendulum whose weight is 0: `θ̈ = τ/J`.
fn free_pendulum() -> Model {
    Model::loader().gravity([0.0; 3]).load(robot("pendulum.urdf")).expect("a model")
}

fn joint(model: &Model) -> String {
    model.joint_names()[0].to_string()
}

#[test]
fn efforts_between_steps_move_the_motion_and_are_counted_as_work() {
    let model = free_pendulum();
    let name = joint(&model);
    let inertia = model.mass_matrix(&[0.0]).expect("a matrix")[(0, 0)];
    let mut simulation = Simulation::new(&model).duration(2.0).tolerance(1e-9);
    simulation.set_efforts(&[0.3]).expect("efforts");
    simulation.step_to(1.0).expect("it runs");
    simulation.set_efforts(&[0.0]).expect("efforts");
    simulation.step_to(2.0).expect("it runs");
    let rate = simulation.velocity(&name).expect("a joint")[0];
    // Polynomials of second degree are exact for the scheme: roundings alone.
    assert!((rate - 0.3 / inertia).abs() < 1e-11 * rate.abs(), "{rate}");
    let kinetic = simulation.energy().expect("an energy").kinetic;
    let report = simulation.finish().expect("a report");
    assert!((report.energy.work - kinetic).abs() < 1e-11 * kinetic);
    assert!(report.energy.max_relative_error < 1e-11);
}

#[test]
fn a_controller_is_asked_at_its_instants_and_never_between() {
    let model = free_pendulum();
    let inertia = model.mass_matrix(&[0.0]).expect("a matrix")[(0, 0)];
    let name = joint(&model);
    let (told, asked) = std::sync::mpsc::channel();
    let start = Simulation::new(&model).duration(1.0).tolerance(1e-9);
    let mut simulation = start.velocities([(name.clone(), 1.0)]).expect("a start");
    simulation
        .set_controller(0.01, move |now, efforts| {
            efforts[0] = -2.0 * inertia * now.v[0];
            told.send(now.time).expect("somebody listens");
        })
        .expect("a controller");
    simulation.step_to(0.005).expect("it runs");
    simulation.step_to(0.505).expect("it runs");
    simulation.run().expect("it runs");
    // Each period multiplies the rate by 1 − 2 T: a sampled law, not e^(−2 t).
    let rate = simulation.velocity(&name).expect("a joint")[0];
    assert!((rate - 0.98_f64.powi(100)).abs() < 1e-11, "{rate}");
    drop(simulation);
    let times: Vec<f64> = asked.iter().collect();
    assert_eq!(times, (0..100).map(|k| k as f64 * 0.01).collect::<Vec<_>>());
}

#[test]
fn the_report_counts_the_time_of_steps_between_the_instants_of_a_controller() {
    let model = free_pendulum();
    let start = Simulation::new(&model).fixed(3, 1e-3).duration(0.1);
    let mut simulation = start.velocities([(joint(&model), 1.0)]).expect("a start");
    simulation.set_controller(1e-3, |_, _| ()).expect("a controller");
    simulation.run().expect("it runs");
    let report = simulation.finish().expect("a report");
    assert_eq!(report.steps, 100);
    assert!(report.solve_cpu_seconds > 0.0);
}

#[test]
fn the_report_counts_the_efforts_among_what_joints_carry() {
    let model = Model::load(robot("arm7.urdf")).expect("a model");
    let (q, v) = model.start().expect("a start");
    let holding = model.gravity_efforts(&q).expect("efforts");
    let mut simulation = Simulation::new(&model).duration(0.1).start_from(&q, &v).expect("a start");
    simulation.set_efforts(holding.as_slice()).expect("efforts");
    simulation.run().expect("it runs");
    let report = simulation.finish().expect("a report");
    let weight = model.description().mechanism.total_mass() * 9.81;
    // It rests, so that the first joint carries the weight of all that moves.
    let (_, first) = &report.joints[0];
    assert!((first.reaction_force[2] - weight).abs() < 1e-6 * weight, "{:?} and {weight}", first.reaction_force);
}

#[test]
fn a_controller_that_fails_ends_the_run_with_its_reason_and_leaves_a_whole_log() {
    let folder = crate::folder("failing");
    let path = folder.join("failing.mcap");
    let mut simulation = Simulation::new(&free_pendulum()).duration(1.0).log(&path);
    simulation
        .set_fallible_controller(0.1, |now, _| if now.time > 0.35 { Err("it gave up".into()) } else { Ok(()) })
        .expect("a controller");
    let error = simulation.run().expect_err("it fails").to_string();
    assert_eq!(error, "the controller failed at t = 0.4 s: it gave up");
    assert!(matches!(simulation.step_to(1.0), Err(Error::Over(time)) if time == 0.4));
    assert_eq!(simulation.finish().expect("a report").duration, 0.4);
    let summary = catena::output::inspection::summary::Summary::read(&path).expect("a log");
    assert_eq!(summary.state(), "complete, the run failed");
    assert_eq!(summary.duration, 0.4);
    std::fs::remove_dir_all(folder).expect("removed");
}
