//! Runs that begin between the ticks of sampled motors.

use crate::states::driven_pendulum;
use crate::{folder, robot};
use catena::prelude::*;

#[test]
fn a_run_that_begins_between_the_ticks_of_a_motor_says_so_unless_it_knows_the_effort() {
    let motor = "kind = \"velocity\"\ntarget = 1.0\nkd = 0.5\nperiod = 0.1";
    let (model, ..) = driven_pendulum("between_ticks", motor);
    let told = |simulation: Simulation| {
        let report = simulation.finish().expect("a report");
        report.warnings.iter().filter(|line| line.contains("between its ticks, at t = 0.25 s")).count()
    };
    let begins = |time: f64| {
        let mut simulation = Simulation::new(&model).begin_at(time).duration(0.1);
        simulation.run().expect("it runs");
        simulation
    };
    assert_eq!([0.0, 0.2, 0.25, 0.3].map(|time| told(begins(time))), [0, 0, 1, 0]);
    let mut simulation = Simulation::new(&model).tolerance(1e-9);
    simulation.step_to(0.25).expect("it runs");
    let (state, mut other) = (simulation.state().expect("a state"), Simulation::new(&model).tolerance(1e-9));
    other.set_state(&state).expect("the same model");
    other.step_to(0.3).expect("it runs");
    simulation.step_to(0.3).expect("it runs");
    assert_eq!(simulation.coordinates().expect("q, v"), other.coordinates().expect("q, v"));
    assert_eq!(told(other), 0);
}

/// Joint, rate and what its motor holds at the end of a run in these parts, each of a run of its own (s).
fn in_parts(model: &Model, parts: &[f64], holds: bool) -> (Vec<f64>, Vec<f64>) {
    let (mut time, mut at, mut held) = (0.0, model.start().expect("a start"), vec![None]);
    for part in parts {
        let run = Simulation::new(model).tolerance(1e-9).duration(*part).begin_at(time);
        let run = if holds { run.hold_efforts(&held).expect("one motor") } else { run };
        let mut run = run.start_from(&at.0, &at.1).expect("a start");
        run.run().expect("it runs");
        (time, at, held) = (run.time(), run.coordinates().expect("q, v"), run.held_efforts());
    }
    at
}

#[test]
fn a_run_in_parts_that_end_between_ticks_is_the_one_that_goes_through() {
    let motor = "kind = \"position\"\ntarget = 1.0\nkp = 8.0\nkd = 0.5\nperiod = 0.05";
    let (model, ..) = driven_pendulum("parts_between_ticks", motor);
    let (q, v) = in_parts(&model, &[0.7], true);
    let apart = |(other, rate): (Vec<f64>, Vec<f64>)| (q[0] - other[0]).abs().max((v[0] - rate[0]).abs());
    // Constant accelerations between ticks, which steps of any length follow to rounding.
    for parts in [&[0.33, 0.37][..], &[0.012, 0.013, 0.3, 0.375]] {
        let found = apart(in_parts(&model, parts, true));
        assert!(found < 1e-13, "{parts:?}: {found:e}");
    }
    let anew = apart(in_parts(&model, &[0.33, 0.37], false));
    assert!(anew > 1e-4, "efforts that are worked out anew make another run: {anew:e}");
    // A state knows them, too, as it is taken and before the first step after it.
    let mut run = Simulation::new(&model).tolerance(1e-9);
    run.step_to(0.33).expect("it runs");
    let state = run.state().expect("a state");
    assert_eq!(state.held_efforts(), run.held_efforts());
    let (q, v) = state.coordinates();
    let on = Simulation::new(&model).tolerance(1e-9).begin_at(0.33).hold_efforts(state.held_efforts());
    let mut on = on.expect("one motor").start_from(&q, &v).expect("a start");
    assert_eq!(on.held_efforts(), state.held_efforts());
    assert_eq!(on.state().expect("a state").held_efforts(), state.held_efforts());
    on.step_to(0.34).expect("it runs");
    assert_eq!(on.held_efforts(), state.held_efforts());
    // Placed, it is a new run, whose motor works out its effort.
    let anew = model.description().mechanism.nonsmooth.motors[0].effort(0.34, 0.5, 0.0);
    on.place(0.34, &[0.5], &[0.0]).expect("it is placed");
    on.step_to(0.341).expect("it runs");
    assert_eq!(on.held_efforts(), [Some(anew)]);
    let report = on.finish().expect("a report");
    assert!(report.warnings.iter().any(|line| line.contains("between its ticks")), "{:?}", report.warnings);
}

#[test]
fn held_efforts_of_the_wrong_number_and_without_end_are_refused() {
    let (model, ..) = driven_pendulum("refused_held", "kind = \"velocity\"\ntarget = 1.0\nkd = 0.5\nperiod = 0.1");
    let refused =
        |efforts: &[Option<f64>]| Simulation::new(&model).hold_efforts(efforts).err().map(|error| error.to_string());
    assert!(refused(&[]).is_some_and(|line| line.contains("held efforts, one a motor")));
    assert!(refused(&[Some(f64::NAN)]).is_some_and(|line| line.contains("a held effort")));
}

#[test]
fn motors_of_independent_robots_hold_their_own_efforts() {
    let folder = folder("held_of_two");
    let (urdf, scene) = (robot("chain_20_heavy_tip.urdf"), folder.join("scene.toml"));
    let mut text = String::new();
    for (name, x) in [("a", 0.0), ("b", 5.0)] {
        text += &format!("[[robot]]\nname = {name:?}\nurdf = {urdf:?}\npose = {{ position = [{x}, 0, 0] }}\n\n");
    }
    let motors = [("a/joint3", 1.0, 0.05), ("a/joint5", 0.3, 0.0), ("b/joint2", 2.0, 0.1), ("b/joint4", 0.5, 0.05)];
    for (joint, target, period) in motors {
        text += &format!(
            "[[motor]]\njoint = {joint:?}\nkind = \"position\"\ntarget = {target}\nkp = 2.0\nkd = 0.1\n{}\n",
            if period > 0.0 { format!("period = {period}\n") } else { String::new() }
        );
    }
    std::fs::write(&scene, text).expect("written");
    let model = Model::load(&scene).expect("a model");
    let at = |time: f64| {
        let mut run = Simulation::new(&model).tolerance(1e-6);
        run.step_to(time).expect("it runs");
        run
    };
    let (tick, long) = (at(0.15), at(0.1));
    let held = at(0.17).held_efforts();
    let of = |run: &Simulation, (joint, target, _): (&str, f64, f64)| {
        2.0 * (target - run.position(joint).expect("a joint")[0]) - 0.1 * run.velocity(joint).expect("a joint")[0]
    };
    let expected = [Some(of(&tick, motors[0])), None, Some(of(&long, motors[2])), Some(of(&tick, motors[3]))];
    for ((held, expected), (joint, ..)) in held.iter().zip(expected).zip(motors) {
        let apart = held.zip(expected).map_or(0.0, |(held, expected)| (held - expected).abs());
        // The steps are others, to the tolerance of 1e-6.
        assert!(held.is_some() == expected.is_some() && apart < 1e-5, "{joint}: {held:?} {expected:?}");
    }
    assert!(held[3].zip(expected[0]).is_some_and(|(one, other)| (one - other).abs() > 0.1), "they differ");
    std::fs::remove_dir_all(folder).expect("removed");
}

#[test]
fn a_motor_that_holds_its_effort_too_long_is_warned_of_where_its_motion_grows_and_not_before() {
    // Each tick multiplies the rate by 1 − kd T/J.
    let (_, inertia, folder) = driven_pendulum("long_periods", "kind = \"velocity\"\ntarget = 0.0\nkd = 1.0");
    for (factor, grows) in [(0.99, false), (1.01, true)] {
        let motor =
            format!("kind = \"velocity\"\ntarget = 0.0\nkd = {:?}\nperiod = 0.01", factor * 2.0 * inertia / 0.01);
        let (model, _, own) = driven_pendulum(&format!("long_periods_{grows}"), &motor);
        let mut simulation = Simulation::new(&model).tolerance(1e-6).velocities([("hinge", 0.5)]).expect("a start");
        simulation.step_to(0.2).expect("it runs");
        let rate = simulation.velocity("hinge").expect("a joint")[0];
        assert!((rate - 0.5 * (1.0 - 2.0 * factor).powi(20)).abs() < 1e-6, "{factor}: {rate}");
        let report = simulation.finish().expect("a report");
        let told =
            report.warnings.iter().filter(|line| line.contains("motor on \"hinge\": it holds its effort for 0.01 s"));
        assert_eq!(told.count(), usize::from(grows), "{factor}: {:?}", report.warnings);
        std::fs::remove_dir_all(own).expect("removed");
    }
    std::fs::remove_dir_all(folder).expect("removed");
}
