//! States of runs are values: a run goes on from one bit for bit, and begins elsewhere as a new one would.

use crate::{folder, robot};
use catena::prelude::*;
use catena::session::{Batch, Rollout};

type Coordinates = (Vec<f64>, Vec<f64>);

/// Models with a tree, closed loops, limits, impacts, friction that holds, motors with tables and several contacts, and the time of a state in the
/// middle of what happens to them (s).
fn models() -> Vec<(Model, f64)> {
    let plain = [
        ("arm7.urdf", 0.3),
        ("arm7_held.toml", 0.5),
        ("bouncing_pendulum.toml", 0.8),
        ("friction_pendulum.toml", 0.6),
        ("four_bar_2.toml", 0.2),
        ("gripper_holds_box.toml", 0.3),
        ("quadruped_dropped.toml", 0.12),
        ("ball_in_bowl.toml", 0.3),
    ];
    plain.map(|(name, time)| (Model::load(robot(name)).expect("a model"), time)).into()
}

/// Where a run is after a few calls from `time` on (s).
fn go_on(simulation: &mut Simulation, time: f64) -> Coordinates {
    for part in 1..=3 {
        simulation.step_to(time + 0.03 * f64::from(part)).expect("it goes on");
    }
    simulation.coordinates().expect("coordinates")
}

#[test]
fn a_run_and_its_copies_go_on_from_a_state_bit_for_bit() {
    for (model, time) in models() {
        let name = &model.description().mechanism.name;
        let mut simulation = Simulation::new(&model).tolerance(1e-6);
        simulation.step_to(time).expect("it runs");
        let state = simulation.state().expect("a state");
        let expected = go_on(&mut simulation, time);
        assert_eq!(state.time(), time, "{name}");
        for again in 0..2 {
            simulation.set_state(&state).expect("it goes back");
            assert_eq!(simulation.coordinates().expect("coordinates"), state.coordinates(), "{name}");
            assert_eq!(go_on(&mut simulation, time), expected, "{name}, {again}");
        }
        // A run that has not begun, and one that is elsewhere.
        let mut other = Simulation::new(&model).tolerance(1e-6);
        other.set_state(&state).expect("the same model");
        assert_eq!(go_on(&mut other, time), expected, "{name}");
        simulation.set_state(&state).expect("it goes back");
        let mut copy = simulation.copy().expect("a copy");
        simulation.step_to(time + 0.1).expect("it goes on");
        assert_eq!(go_on(&mut copy, time), expected, "{name}");
    }
}

#[test]
fn a_run_that_is_placed_elsewhere_is_a_new_run_from_there_bit_for_bit() {
    for (model, time) in models() {
        let name = &model.description().mechanism.name;
        let (q, v) = model.start().expect("a start");
        let new = || Simulation::new(&model).tolerance(1e-6).start_from(&q, &v).expect("a start");
        let expected = go_on(&mut new().begin_at(0.0), 0.0);
        let mut simulation = new();
        simulation.step_to(time).expect("it runs");
        simulation.place(0.0, &q, &v).expect("it is placed");
        assert_eq!((simulation.time(), simulation.coordinates().expect("coordinates")), (0.0, (q.clone(), v.clone())));
        assert_eq!(go_on(&mut simulation, 0.0), expected, "{name}");
    }
}

#[test]
fn a_run_that_begins_at_known_starts_again_and_again_is_a_new_run_each_time_bit_for_bit() {
    for (model, time) in models() {
        let name = &model.description().mechanism.name;
        let mut before = Simulation::new(&model).tolerance(1e-6);
        before.step_to(time).expect("it runs");
        // On closed loops and on the ground, but for roundings.
        let (q, v) = before.coordinates().expect("coordinates");
        let slower: Vec<f64> = v.iter().map(|rate| 0.5 * rate).collect();
        let pushed: Vec<f64> = (0..v.len()).map(|freedom| 0.1 * (freedom + 1) as f64).collect();
        let starts = [(&v, None), (&v, Some(&pushed)), (&slower, None)];
        let go_on_from = |simulation: &mut Simulation, start: usize| {
            if let Some(efforts) = starts[start].1 {
                simulation.set_efforts(efforts).expect("efforts");
            }
            go_on(simulation, 0.0)
        };
        let new =
            |start: usize| Simulation::new(&model).tolerance(1e-6).start_from(&q, starts[start].0).expect("a start");
        let expected = [0, 1, 2].map(|start| {
            let mut simulation = new(start);
            simulation.step_to(0.0).expect("it begins");
            go_on_from(&mut simulation, start)
        });
        let mut simulation = new(0);
        go_on(&mut simulation, 0.0);
        // The third run from the same start under the same efforts is the first to find it known.
        for start in [0, 0, 0, 0, 2, 1, 0, 1, 1, 1, 1, 0, 2] {
            simulation.place(0.0, &q, starts[start].0).expect("it is placed");
            assert_eq!(go_on_from(&mut simulation, start), expected[start], "{name}, start {start}");
        }
    }
}

#[test]
fn targets_that_are_given_at_a_start_that_is_known_count() {
    let model = Model::load(robot("quadruped_dropped.toml")).expect("a model");
    let mut simulation = Simulation::new(&model).tolerance(1e-5);
    simulation.step_to(0.3).expect("it stands");
    let (q, v) = simulation.coordinates().expect("coordinates");
    let from = |simulation: &mut Simulation, target: Option<f64>| {
        simulation.place(0.0, &q, &v).expect("it is placed");
        if let Some(target) = target {
            simulation.set_target("front_left_hip", target).expect("a target");
        }
        go_on(simulation, 0.0)
    };
    let mut new = Simulation::new(&model).tolerance(1e-5).start_from(&q, &v).expect("a start");
    new.set_target("front_left_hip", 0.7).expect("a target");
    let expected = go_on(&mut new, 0.0);
    for target in [None, None, None, Some(0.7), None, Some(0.7)] {
        let found = from(&mut simulation, target);
        assert_eq!(found == expected, target.is_some(), "{target:?}");
    }
}

#[test]
fn parts_that_are_simulated_apart_go_on_from_a_state_too() {
    let folder = folder("apart");
    let scene = folder.join("scene.toml");
    let robots = ["left", "right"].map(|name| {
        let urdf = robot("chain_10.urdf");
        format!("[[robot]]\nname = {name:?}\nurdf = {urdf:?}\npositions = {{ joint1 = {} }}\n", name.len())
    });
    std::fs::write(&scene, format!("[scene]\nname = \"apart\"\n\n{}", robots.join("\n"))).expect("written");
    let model = Model::load(&scene).expect("a model");
    let mut simulation = Simulation::new(&model).tolerance(1e-6);
    simulation.step_to(0.2).expect("it runs");
    let state = simulation.state().expect("a state");
    let expected = go_on(&mut simulation, 0.2);
    simulation.set_state(&state).expect("it goes back");
    assert_eq!(go_on(&mut simulation, 0.2), expected);
    let (q, v) = model.start().expect("a start");
    simulation.place(0.0, &q, &v).expect("placed");
    assert_eq!(go_on(&mut simulation, 0.0), go_on(&mut Simulation::new(&model).tolerance(1e-6), 0.0));
    assert_eq!(simulation.finish().expect("a report").islands.len(), 2, "they are apart");
    std::fs::remove_dir_all(folder).expect("removed");
}

#[test]
fn efforts_and_ticks_of_controllers_are_part_of_a_state() {
    let model = Model::load(robot("arm7.urdf")).expect("a model");
    let efforts = [1.0, -5.0, 2.0, 3.0, 0.5, 0.1, 0.0];
    let mut simulation = Simulation::new(&model).tolerance(1e-6);
    simulation.set_efforts(&efforts).expect("efforts");
    simulation.step_to(0.05).expect("it runs");
    let state = simulation.state().expect("a state");
    let expected = go_on(&mut simulation, 0.05);
    simulation.set_efforts(&[0.0; 7]).expect("efforts");
    simulation.step_to(0.5).expect("it runs");
    simulation.set_state(&state).expect("it goes back");
    assert_eq!(go_on(&mut simulation, 0.05), expected);

    // Asked every 20 ms: after a state at 50 ms the next times are 60, 80, 100, … ms.
    let (told, asked) = std::sync::mpsc::channel();
    let mut simulation = Simulation::new(&model);
    let law = move |now: &catena::session::Moment, _: &mut [f64]| told.send(now.time).expect("somebody listens");
    simulation.set_controller(0.02, law).expect("a controller");
    simulation.step_to(0.05).expect("it runs");
    let state = simulation.state().expect("a state");
    simulation.step_to(0.2).expect("it runs");
    simulation.set_state(&state).expect("it goes back");
    asked.try_iter().for_each(drop);
    simulation.step_to(0.11).expect("it runs");
    assert_eq!(asked.try_iter().collect::<Vec<_>>(), [0.06, 0.08, 0.1]);
}

#[test]
fn states_of_other_models_and_runs_with_logs_are_refused() {
    let [arm, pendulum] = ["arm7.urdf", "pendulum.urdf"].map(|name| Model::load(robot(name)).expect("a model"));
    let state = Simulation::new(&arm).state().expect("a state");
    let refused = Simulation::new(&pendulum).set_state(&state).expect_err("refused").to_string();
    assert!(refused.contains("the state is of \"arm7\", and the run of \"pendulum\""), "{refused}");
    // A model that was loaded a second time is the same.
    Simulation::new(&Model::load(robot("arm7.urdf")).expect("a model")).set_state(&state).expect("the same");
    let folder = folder("logged-states");
    let mut logged = Simulation::new(&arm).log(folder.join("log.mcap"));
    assert!(matches!(logged.set_state(&state), Err(Error::Logged)));
    assert!(matches!(logged.place(0.0, &[0.0; 7], &[0.0; 7]), Err(Error::Logged)));
    drop(logged);
    std::fs::remove_dir_all(folder).expect("removed");
    let mut simulation = Simulation::new(&arm);
    assert!(matches!(simulation.place(f64::NAN, &[0.0; 7], &[0.0; 7]), Err(Error::Option { option: "time", .. })));
    assert!(matches!(simulation.place(0.0, &[0.0; 6], &[0.0; 7]), Err(Error::Count { what: "q", .. })));
}

#[test]
fn a_run_that_failed_begins_again_elsewhere() {
    let model = Model::loader().gravity([0.0; 3]).load(robot("pendulum.urdf")).expect("a model");
    let mut simulation = Simulation::new(&model);
    simulation
        .set_fallible_controller(0.1, |now, _| if now.v[0] > 1.5 { Err("too fast".into()) } else { Ok(()) })
        .expect("a controller");
    simulation.place(0.0, &[0.0], &[2.0]).expect("placed");
    let failed = simulation.step_to(0.2).expect_err("too fast").to_string();
    assert_eq!(failed, "the controller failed at t = 0 s: too fast");
    simulation.place(0.0, &[0.0], &[1.0]).expect("placed");
    simulation.step_to(1.0).expect("it runs");
    // Free motion: q = t, but for roundings.
    assert!((simulation.coordinates().expect("coordinates").0[0] - 1.0).abs() < 1e-13);
}

#[test]
fn steps_of_a_program_are_made_without_an_estimate() {
    let model = Model::load(robot("quadruped_dropped.toml")).expect("a model");
    let mut simulation = Simulation::new(&model);
    simulation.step_to(0.02).expect("it runs");
    let report = simulation.finish().expect("a report");
    let why = report.no_accuracy.expect("no estimate").reason;
    assert!(report.accuracy.is_none() && why.contains("a program makes this run step by step"), "{why}");
}

/// A pendulum of inertia J without weight, with a motor.
pub fn driven_pendulum(test: &str, motor: &str) -> (Model, f64, std::path::PathBuf) {
    let folder = folder(test);
    let (urdf, scene) = (robot("pendulum.urdf"), folder.join("scene.toml"));
    let text = format!(
        "[scene]\ngravity = [0, 0, 0]\n\n[[robot]]\nurdf = {urdf:?}\n\n[[motor]]\njoint = \"hinge\"\n{motor}\n"
    );
    std::fs::write(&scene, text).expect("written");
    let model = Model::load(&scene).expect("a model");
    let inertia = model.mass_matrix(&[0.0]).expect("a matrix")[(0, 0)];
    (model, inertia, folder)
}

#[test]
fn a_motor_follows_targets_that_a_program_gives_it() {
    let (model, inertia, folder) = driven_pendulum("targets", "kind = \"position\"\ntarget = 0.0\nkp = 8.0\nkd = 0.5");
    assert_eq!(model.motor_names(), ["hinge"]);
    let mut simulation = Simulation::new(&model).tolerance(1e-9);
    simulation.step_to(0.5).expect("it rests");
    // J q̈ = 8 (r − q) − 0.5 q̇ from (q, q̇): a damped oscillation about r.
    let decay = 0.25 / inertia;
    let frequency = (8.0 / inertia - decay * decay).sqrt();
    let oscillate = |(q, v): (f64, f64), r: f64, t: f64| {
        let (cosine, sine) = ((frequency * t).cos(), (frequency * t).sin());
        let (a, b) = (q - r, (v + decay * (q - r)) / frequency);
        let fall = (-decay * t).exp();
        let rate = fall * ((b * frequency - decay * a) * cosine - (a * frequency + decay * b) * sine);
        (r + fall * (a * cosine + b * sine), rate)
    };
    let mut expected = (0.0, 0.0);
    for (part, target) in [0.3, -0.2, -0.2, 0.7].into_iter().enumerate() {
        simulation.set_target("hinge", target).expect("a target");
        expected = oscillate(expected, target, 0.1);
        simulation.step_to(0.5 + 0.1 * (part + 1) as f64).expect("it moves");
        let (q, v) = simulation.coordinates().expect("coordinates");
        // The tolerance of the run, in metres of a pendulum of less than one.
        assert!(
            (q[0] - expected.0).abs() < 1e-8 && (v[0] - expected.1).abs() < 1e-7,
            "{part}: {q:?} {v:?} {expected:?}"
        );
    }
    // The target is part of a state, and a run that is placed anew has the target of the file.
    let state = simulation.state().expect("a state");
    simulation.set_targets(&[5.0]).expect("targets");
    simulation.set_state(&state).expect("it goes back");
    simulation.step_to(1.0).expect("it moves");
    let (q, _) = simulation.coordinates().expect("coordinates");
    assert!((q[0] - oscillate(expected, 0.7, 0.1).0).abs() < 1e-8, "{q:?}");
    simulation.place(0.0, &[0.0], &[0.0]).expect("placed");
    simulation.step_to(0.5).expect("it rests");
    assert_eq!(simulation.coordinates().expect("coordinates").0, [0.0]);
    std::fs::remove_dir_all(folder).expect("removed");
}

#[test]
fn targets_meet_the_bound_of_a_motor_and_its_ticks() {
    let bounded = "kind = \"position\"\ntarget = 0.0\nkp = 100.0\nkd = 0.0\nmax_effort = 2.0";
    let (model, inertia, folder) = driven_pendulum("bounded", bounded);
    let mut simulation = Simulation::new(&model).tolerance(1e-9);
    simulation.step_to(0.1).expect("it rests");
    simulation.set_target("hinge", 50.0).expect("a target");
    simulation.step_to(0.15).expect("it moves");
    // Constant acceleration, which the scheme integrates exactly.
    let q = simulation.coordinates().expect("coordinates").0[0];
    assert!((q - 0.5 * 2.0 / inertia * 0.05_f64.powi(2)).abs() < 1e-13, "{q}");
    std::fs::remove_dir_all(folder).expect("removed");

    let (model, inertia, folder) = driven_pendulum("ticks", "kind = \"effort\"\ntarget = 0.0\nperiod = 0.1");
    let mut simulation = Simulation::new(&model).tolerance(1e-9);
    simulation.step_to(0.05).expect("it rests");
    simulation.set_target("hinge", 3.0).expect("a target");
    simulation.step_to(0.15).expect("it moves");
    // From the tick at 0.1 s on.
    let q = simulation.coordinates().expect("coordinates").0[0];
    assert!((q - 0.5 * 3.0 / inertia * 0.05_f64.powi(2)).abs() < 1e-13, "{q}");
    std::fs::remove_dir_all(folder).expect("removed");
}

#[test]
fn targets_that_cannot_be_are_named() {
    let (model, _, folder) = driven_pendulum("wrong-targets", "kind = \"velocity\"\ntarget = 0.0\nkd = 1.0");
    let mut simulation = Simulation::new(&model);
    let refused = simulation.set_target("elbow", 1.0).expect_err("refused").to_string();
    assert_eq!(refused, "joint \"elbow\" has no motor; the joints with motors are \"hinge\"");
    let refused = simulation.set_target("hinge", f64::NAN).expect_err("refused").to_string();
    assert_eq!(refused, "the target of the motor of joint \"hinge\" is NaN: give a finite number");
    assert!(matches!(simulation.set_targets(&[1.0, 2.0]), Err(Error::Count { what: "targets", given: 2, wanted: 1 })));
    std::fs::remove_dir_all(folder).expect("removed");
}

#[test]
fn runs_at_once_have_efforts_targets_and_feedback_of_their_own_as_single_ones_have() {
    let (model, inertia, folder) = driven_pendulum("batch", "kind = \"position\"\ntarget = 0.0\nkp = 8.0\nkd = 0.5");
    let (efforts, targets) = ([0.1, 0.2, 0.0, -0.3], [0.5, 0.1, -0.4, 0.0]);
    let (gain, reference) = ([0.7, 0.05], [0.2, 0.0]);
    let options = Rollout {
        duration: Some(0.2),
        rate: Some(10.0),
        period: Some(0.1),
        efforts: &efforts,
        targets: &targets,
        feedback: &gain,
        reference: &reference,
        energies: true,
        threads: 2,
        ..Rollout::default()
    };
    let runs = model.rollout(&[0.0, 0.3], &[0.0, -1.0], &options).expect("two runs");
    for run in 0..2 {
        let mut single = Simulation::new(&model).start_from(&[0.3 * run as f64], &[-(run as f64)]).expect("a start");
        for tick in 0..2 {
            let (q, v) = single.coordinates().expect("coordinates");
            let law = gain[0] * (q[0] - reference[0]) + gain[1] * (v[0] - reference[1]);
            single.set_targets(&[targets[2 * run + tick]]).expect("targets");
            single.set_efforts(&[efforts[2 * run + tick] - law]).expect("efforts");
            single.step_to(0.1 * (tick + 1) as f64).expect("it runs");
            let (q, v) = single.coordinates().expect("coordinates");
            let at = run * 3 + tick + 1;
            assert_eq!((runs.q[at], runs.v[at]), (q[0], v[0]), "run {run}, tick {tick}");
            let kinetic = runs.energies[4 * at];
            assert!((kinetic - 0.5 * inertia * v[0] * v[0]).abs() < 1e-13, "{kinetic}");
        }
    }
    let refused = |options: Rollout| model.rollout(&[0.0], &[0.0], &options).expect_err("refused").to_string();
    let wrong = Rollout { efforts: &[1.0; 3], period: Some(0.1), duration: Some(0.2), ..Rollout::default() };
    assert_eq!(refused(wrong), "efforts, a row a run and tick: 3 numbers where 2 are wanted");
    let wrong = Rollout { efforts: &[1.0, f64::NAN], period: Some(0.1), duration: Some(0.2), ..Rollout::default() };
    assert_eq!(refused(wrong), "efforts: the number for \"hinge\" is NaN: give a finite number");
    std::fs::remove_dir_all(folder).expect("removed");
}

#[test]
fn runs_at_once_have_parameters_of_their_own_and_tell_of_moved_starts() {
    let model = Model::load(robot("four_bar_2.toml")).expect("a model");
    let (q, v) = model.start().expect("a start");
    let mut moved = q.clone();
    moved[0] += 0.1;
    let starts = [q.clone(), moved].concat();
    let numbers = [("gravity.z".to_string(), vec![-9.81, -1.62])];
    let options = Rollout { duration: Some(0.1), params: &numbers, ..Rollout::default() };
    let runs = model.rollout(&starts, &[&v[..], &v[..]].concat(), &options).expect("two runs");
    let moon = model.with_params([("gravity.z", -1.62)]).expect("a model");
    let mut single = Simulation::new(&moon).duration(0.1).start_from(&starts[q.len()..], &v).expect("a start");
    single.run().expect("it runs");
    assert_eq!(runs.q[3 * q.len()..], single.coordinates().expect("coordinates").0);
    assert!(runs.warnings[0].is_empty(), "{:?}", runs.warnings);
    assert!(runs.warnings[1].iter().any(|warning| warning.contains("the start was adjusted")), "{:?}", runs.warnings);
}

#[test]
fn runs_side_by_side_are_single_runs_bit_for_bit_whatever_the_number_of_threads() {
    let model = Model::load(robot("quadruped_dropped.toml")).expect("a model");
    let (q, v) = model.start().expect("a start");
    let n = v.len();
    let efforts: Vec<f64> = (0..3 * n).map(|k| if k % n < 6 { 0.0 } else { (k as f64).sin() }).collect();
    let run = |threads: usize| {
        let mut batch = Batch::new(&mut Simulation::new(&model).duration(1e3), 3, threads).expect("a batch");
        for _ in 0..6 {
            assert!(batch.step(0.02, &efforts, &[]).expect("the right counts").is_empty());
        }
        batch.place(1, &q, &v).expect("placed");
        assert!(batch.step(0.02, &efforts, &[]).expect("the right counts").is_empty());
        let (mut all_q, mut all_v) = (vec![0.0; 3 * q.len()], vec![0.0; 3 * n]);
        batch.write_coordinates(&mut all_q, &mut all_v).expect("the right counts");
        (all_q, all_v)
    };
    let (all_q, all_v) = run(1);
    assert_eq!(run(3), (all_q.clone(), all_v.clone()));
    for (number, ticks) in [(0, 7), (1, 1), (2, 7)] {
        let mut single = Simulation::new(&model).duration(1e3);
        for _ in 0..ticks {
            single.set_efforts(&efforts[number * n..(number + 1) * n]).expect("efforts");
            single.step_to(single.time() + 0.02).expect("it runs");
        }
        let (own_q, own_v) = single.coordinates().expect("coordinates");
        assert_eq!(all_q[number * q.len()..(number + 1) * q.len()], own_q, "{number}");
        assert_eq!(all_v[number * n..(number + 1) * n], own_v, "{number}");
    }
    let mut batch = Batch::new(&mut Simulation::new(&model), 2, 1).expect("a batch");
    assert!(matches!(batch.step(0.02, &[0.0], &[]), Err(Error::Count { what: "efforts", .. })));
    assert!(batch.place(2, &q, &v).is_err());
}

/// A quadruped whose motors hold it on the floor, and where it is some time after it was dropped (s).
fn dropped(before: f64) -> (Model, Vec<f64>, Vec<f64>) {
    let model = Model::load(robot("quadruped_dropped.toml")).expect("a model");
    let mut run = Simulation::new(&model).duration(before);
    run.run().expect("it lands");
    let (q, v) = run.coordinates().expect("coordinates");
    (model, q, v)
}

#[test]
fn the_first_span_that_a_program_asks_for_has_three_stages_where_they_end_as_finer_steps_do() {
    // It sways for a second, the less the later.
    let spans = [(0.2, 1e-4), (0.3, 1e-4), (0.5, 1e-4), (1.0, 1e-4), (0.5, 1e-6), (1.0, 1e-6)];
    let few = spans.map(|(before, tolerance)| {
        let (model, q, v) = dropped(before);
        let ended = |tolerance: f64| {
            let mut simulation = Simulation::new(&model).tolerance(tolerance).start_from(&q, &v).expect("a start");
            simulation.step_to(0.02).expect("a step");
            let (q, _) = simulation.coordinates().expect("coordinates");
            (q, simulation.finish().expect("a report").method.few_stage_steps)
        };
        let ((q, made), (reference, _)) = (ended(tolerance), ended(1e-11));
        let apart = q.iter().zip(&reference).map(|(one, other)| (one - other).abs()).fold(0.0, f64::max);
        println!("{before} s, {tolerance}: {made} spans of three stages, {apart:e} apart");
        assert!(apart < 1e-3 * tolerance, "{before} s, {tolerance}: {apart} apart");
        made
    });
    assert_eq!(few, [0, 0, 0, 1, 0, 0]);
}

#[test]
fn a_first_span_that_three_stages_are_not_stable_in_has_many() {
    // Its fastest mode has 106 rad/s: 0.05 s are 5.3 rad of it, and three stages are stable up to 2.8.
    let (model, q, v) = dropped(2.0);
    let mut simulation = Simulation::new(&model).tolerance(1e-4).start_from(&q, &v).expect("a start");
    simulation.step_to(0.05).expect("a step");
    assert_eq!(simulation.finish().expect("a report").method.few_stage_steps, 0);
}
