//! A run of a program is that of the command line, and its log replays.

use crate::{folder, robot};
use catena::prelude::*;
use catena::report::Numbers;
use catena::session::{Rollout, SharedRecording};
use std::path::Path;
use std::process::Command;

fn catena(arguments: &[&str]) -> std::process::Output {
    Command::new(env!("CARGO_BIN_EXE_catena")).args(arguments).output().expect("the program runs")
}

/// Everything after the metadata at the beginning, which have the command line.
fn samples(log: &Path) -> Vec<(String, u64, Vec<u8>)> {
    use catena::output::log::reading::reader::{Item, read_log};
    let mut all = Vec::new();
    read_log(log, |item| {
        if let Item::Message { channel, time, data, .. } = item {
            all.push((channel.topic.clone(), time, data.to_vec()));
        }
        std::ops::ControlFlow::Continue(())
    })
    .expect("a log");
    all
}

#[test]
fn written_coordinates_are_those_of_the_report() {
    // With hinges alone q and v are copied from the state; ball and floating joints are converted.
    for (input, floats) in [("arm7.urdf", false), ("spherical_chain.urdf", false), ("tumbling_body.urdf", true)] {
        let loader = if floats { Model::loader().floating() } else { Model::loader() };
        let model = loader.load(robot(input)).expect("a model");
        let v: Vec<f64> = (1..=model.coordinates().v_count()).map(|k| 0.1 * k as f64).collect();
        let (q, _) = model.start().expect("a start");
        let mut simulation = Simulation::new(&model).duration(0.1).start_from(&q, &v).expect("a start");
        simulation.run().expect("it runs");
        let (mut q, mut v) = (vec![f64::NAN; q.len()], vec![f64::NAN; v.len()]);
        simulation.write_coordinates(&mut q, &mut v).expect("it is written");
        let refused = simulation.write_coordinates(&mut q[1..].to_vec(), &mut v);
        assert!(matches!(refused, Err(Error::Count { what: "q", .. })), "{input}: {refused:?}");
        let report = simulation.finish().expect("a report");
        for place in model.coordinates().joints() {
            let (_, joint) = report.joints.iter().find(|(name, _)| **name == *place.name).expect("a joint");
            let written = (Numbers::from(q[place.q.clone()].to_vec()), Numbers::from(v[place.v.clone()].to_vec()));
            let reported = (&joint.position, &joint.velocity);
            assert_eq!(format!("{written:?}"), format!("{reported:?}"), "{input}: {}", place.name);
        }
    }
}

#[test]
fn a_log_of_a_program_has_the_messages_of_the_command_line_and_replays() {
    let folder = folder("same");
    for (input, start) in [
        ("double_pendulum.urdf", Some(("shoulder", 0.5))),
        ("four_bar_2.toml", None),
        ("bouncing_pendulum.toml", None),
        ("quadruped_dropped.toml", None),
    ] {
        let input = robot(input);
        let (ours, theirs) = (folder.join("ours.mcap"), folder.join("theirs.mcap"));
        let model = Model::load(&input).expect("a model");
        let simulation = Simulation::new(&model).duration(0.3).tolerance(1e-7).log(&ours);
        let mut simulation = match start {
            Some(start) => simulation.start([start]).expect("a start"),
            None => simulation,
        };
        simulation.run().expect("it runs");
        let report = simulation.finish().expect("a report");
        let (input, theirs_name) = (input.display().to_string(), theirs.display().to_string());
        let mut words =
            vec!["simulate", &input, "--duration", "0.3", "--tolerance", "1e-7", "--json", "-o", &theirs_name];
        let position = start.map(|(joint, value)| format!("{joint}={value}"));
        if let Some(position) = &position {
            words.extend(["--position", position]);
        }
        let printed = catena(&words);
        let printed: serde_json::Value = serde_json::from_slice(&printed.stdout).expect("a report");
        let mut report = serde_json::to_value(&report).expect("JSON");
        let mut expected = printed.clone();
        for clocked in ["wall_seconds", "cpu_seconds", "solve_cpu_seconds", "log"] {
            report[clocked].take();
            expected[clocked].take();
        }
        if let (Some(ours), Some(theirs)) = (report["islands"].as_array_mut(), expected["islands"].as_array_mut()) {
            ours.iter_mut().chain(theirs).for_each(|island| drop(island["solve_cpu_seconds"].take()));
        }
        assert_eq!(report, expected, "{input}");
        assert!(samples(&ours) == samples(&theirs), "{input}: the same messages");
        let replayed = catena(&["replay", &ours.display().to_string()]);
        assert!(replayed.status.success(), "{input}: {}", String::from_utf8_lossy(&replayed.stderr));
    }
    std::fs::remove_dir_all(folder).expect("removed");
}

#[test]
fn a_run_without_a_log_warns_of_fast_joints_as_one_with_a_log_and_as_the_command_line() {
    let (folder, input) = (folder("warned"), robot("arm7.urdf"));
    let model = Model::load(&input).expect("a model");
    let warnings_of = |mut simulation: Simulation| {
        simulation.run().expect("it runs");
        simulation.finish().expect("a report").warnings
    };
    let warned = warnings_of(Simulation::new(&model).duration(0.3));
    assert!(warned.iter().any(|warning| warning.contains("<limit velocity> is 3")), "{warned:?}");
    assert_eq!(warned, warnings_of(Simulation::new(&model).duration(0.3).log(folder.join("ours.mcap"))));
    let printed = catena(&["simulate", &input.display().to_string(), "--duration", "0.3", "--no-log", "--json"]);
    let printed: serde_json::Value = serde_json::from_slice(&printed.stdout).expect("a report");
    assert_eq!(serde_json::to_value(warned).expect("JSON"), printed["warnings"]);
    std::fs::remove_dir_all(folder).expect("removed");
}

#[test]
fn a_recorded_run_is_written_as_if_it_had_been_logged() {
    let folder = folder("recorded");
    for input in ["damped_pendulum.toml", "ball_dropped.toml"] {
        let model = Model::load(robot(input)).expect("a model");
        let (logged, written) = (folder.join("logged.mcap"), folder.join("written.mcap"));
        let recording = SharedRecording::default();
        let mut simulation = Simulation::new(&model).duration(0.5).log(&logged).observe(recording.clone());
        simulation.run().expect("it runs");
        let (_, told, model) = simulation.finish_told().expect("a report");
        told.write(&written, model.description(), &recording.take(), &Default::default()).expect("written");
        let (logged, written) = (std::fs::read(&logged).expect("a log"), std::fs::read(&written).expect("a log"));
        assert!(logged == written, "{input}: the same bytes");
    }
    std::fs::remove_dir_all(folder).expect("removed");
}

#[test]
fn a_floating_start_with_a_quaternion_is_replayed_bit_for_bit() {
    let folder = folder("floating");
    let path = folder.join("tumbling.mcap");
    let model = Model::loader().floating().gravity([0.0; 3]).load(robot("tumbling_body.urdf")).expect("a model");
    let q = [0.1, 0.2, 0.3, 0.5, -0.5, 0.5, 0.5];
    let v = [0.0, 0.1, 0.0, 1.0, 2.0, 3.0];
    let mut simulation = Simulation::new(&model).duration(0.5).log(&path).start_from(&q, &v).expect("a start");
    let (at, moving) = simulation.coordinates().expect("coordinates");
    // Two changes between the link's frame and that of the body: roundings.
    assert!(at.iter().zip(q).all(|(a, b)| (a - b).abs() < 1e-15), "{at:?}");
    assert!(moving.iter().zip(v).all(|(a, b)| (a - b).abs() < 1e-14), "{moving:?}");
    simulation.run().expect("it runs");
    simulation.finish().expect("a report");
    let replayed = catena(&["replay", &path.display().to_string()]);
    assert!(replayed.status.success(), "{}", String::from_utf8_lossy(&replayed.stderr));
    std::fs::remove_dir_all(folder).expect("removed");
}

#[test]
fn a_run_that_a_program_has_driven_says_that_it_cannot_be_replayed() {
    let folder = folder("driven");
    let path = folder.join("driven.mcap");
    let model = Model::load(robot("pendulum.urdf")).expect("a model");
    let mut simulation = Simulation::new(&model).duration(0.2).log(&path);
    simulation.step_to(0.1).expect("it runs");
    simulation.finish().expect("a report");
    let replayed = catena(&["replay", &path.display().to_string()]);
    assert_eq!(replayed.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&replayed.stderr).contains("a program has stepped it"));
    std::fs::remove_dir_all(folder).expect("removed");
}

#[test]
fn many_runs_are_those_of_single_ones_whatever_the_number_of_threads() {
    let model = Model::load(robot("double_pendulum.urdf")).expect("a model");
    let runs = 5;
    let q0: Vec<f64> = (0..2 * runs).map(|index| 0.3 * (index as f64).sin()).collect();
    let v0: Vec<f64> = (0..2 * runs).map(|index| (index as f64).cos()).collect();
    let rollout = |threads| {
        let options = Rollout { duration: Some(0.5), rate: Some(20.0), threads, ..Rollout::default() };
        model.rollout(&q0, &v0, &options).expect("all run")
    };
    let together = rollout(1);
    assert_eq!(together, rollout(3));
    assert_eq!((together.times.len(), together.failures.len()), (11, 0));
    for run in 0..runs {
        let recording = SharedRecording::default();
        let start = Simulation::new(&model).duration(0.5).rate(20.0).observe(recording.clone());
        let mut single = start.start_from(&q0[2 * run..][..2], &v0[2 * run..][..2]).expect("a start");
        single.run().expect("it runs");
        drop(single);
        let recording = recording.take();
        assert_eq!(recording.times, together.times);
        assert_eq!(recording.positions, together.q[run * 22..][..22], "run {run}");
        assert_eq!(recording.velocities, together.v[run * 22..][..22], "run {run}");
    }
}

#[test]
fn a_run_that_is_dropped_leaves_a_log_that_says_that_it_was_interrupted() {
    let folder = folder("dropped");
    let path = folder.join("dropped.mcap");
    let model = Model::load(robot("pendulum.urdf")).expect("a model");
    let mut simulation = Simulation::new(&model).duration(1.0).log(&path);
    simulation.step_to(0.5).expect("it runs");
    drop(simulation);
    let summary = catena::output::inspection::summary::Summary::read(&path).expect("a log");
    assert_eq!((summary.state().as_str(), summary.duration), ("complete, the run interrupted", 0.5));
    std::fs::remove_dir_all(folder).expect("removed");
}

#[test]
fn numbers_set_by_key_are_those_of_another_file_and_replayed() {
    let folder = folder("set");
    let text = std::fs::read_to_string(robot("pendulum.urdf")).expect("a robot");
    let model = Model::load(robot("pendulum.urdf")).expect("a model");
    let said = model.params().expect("numbers");
    let mass = said.iter().find(|(key, _)| key == "link.arm.mass").and_then(|(_, mass)| *mass).expect("a mass");
    let heavier = model.with_params([("arm.mass", 2.0 * mass)]).expect("a model");
    let (file, log) = (folder.join("pendulum.urdf"), folder.join("set.mcap"));
    std::fs::write(
        &file,
        text.replace(&format!("<mass value=\"{mass:?}\""), &format!("<mass value=\"{:?}\"", 2.0 * mass)),
    )
    .expect("written");
    let written = Model::load(&file).expect("a model");
    let all = |model: &Model| format!("{:?}", model.description().mechanism);
    assert_eq!(all(&heavier), all(&written));
    assert_ne!(all(&heavier), all(&model));
    let mut simulation = Simulation::new(&heavier).duration(0.2).log(&log);
    simulation.run().expect("it runs");
    simulation.finish().expect("a report");
    let replayed = catena(&["replay", &log.display().to_string()]);
    assert!(replayed.status.success(), "{}", String::from_utf8_lossy(&replayed.stderr));
    let unknown = model.with_params([("arm.mas", 1.0)]).expect_err("refused").to_string();
    assert!(unknown.contains("arm.mas") && unknown.contains("link.arm.mass"), "{unknown}");
    assert!(model.with_params([("arm.mass", -1.0)]).expect_err("refused").to_string().contains("arm.mass"));
    std::fs::remove_dir_all(folder).expect("removed");
}

#[test]
fn the_lines_of_the_readme_are_those_of_an_example_that_compiles_with_the_features_it_names() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let [readme, example] =
        ["README.md", "examples/readme_lines.rs"].map(|file| std::fs::read_to_string(root.join(file)).expect("a file"));
    let block = readme.split("```rust").nth(1).and_then(|rest| rest.split("```").next()).expect("lines of Rust");
    let squeezed = |text: &str| text.chars().filter(|character| !character.is_whitespace()).collect::<String>();
    let example = squeezed(&example).replace("&log", "\"run.mcap\"");
    for line in block.lines().filter(|line| !line.trim().is_empty()) {
        assert!(example.contains(&squeezed(line)), "{line}");
    }
}

#[test]
fn a_formula_that_ends_within_a_run_is_an_error_with_its_name_and_time() {
    let folder = folder("formula_ends");
    std::fs::write(
        folder.join("cart.urdf"),
        "<robot name='cart'><link name='rail'/><link name='cart'><inertial><mass value='2'/><inertia ixx='1' iyy='1' izz='1' ixy='0' \
         ixz='0' iyz='0'/></inertial></link><joint name='slide' type='prismatic'><parent link='rail'/><child link='cart'/>\
         <axis xyz='1 0 0'/><limit lower='-9' upper='9' effort='inf' velocity='inf'/></joint></robot>",
    )
    .expect("written");
    let scene = |driven: &str| {
        let file = folder.join("scene.toml");
        std::fs::write(&file, format!("[[robot]]\nurdf = \"cart.urdf\"\n{driven}")).expect("written");
        Model::load(&file).expect("a model")
    };
    let motor =
        "[[motor]]\njoint = \"slide\"\nkind = \"position\"\nkp = 10\ntarget = { formula = \"sqrt(1.5 - t)\" }\n";
    let load = "[[load]]\njoint = \"slide\"\neffort = 1\nfactor = { formula = \"ln(2 - t)\" }\n";
    let motion = "[[motion]]\njoint = \"slide\"\nposition = { formula = \"asin(t)\" }\n";
    for (driven, said) in [
        (motor, "the target of the motor on \"slide\" has a formula without a finite value or rate at t = 1.5 s"),
        (load, "the load in joint \"slide\" has a formula without a finite value or rate at t = 2 s"),
        (motion, "the motion of \"slide\" has a formula without a finite value or rate at t = 1 s"),
    ] {
        let model = scene(driven);
        let error = Simulation::new(&model).duration(2.5).run().expect_err("an error").to_string();
        assert!(error.contains(said), "{error}");
        Simulation::new(&model).duration(0.9).run().expect("a run that ends before");
        // A program that makes steps of its own hears it when it gets there.
        let mut steps = Simulation::new(&model).duration(2.5);
        let error = (1..=25).find_map(|step| steps.step_to(0.1 * f64::from(step)).err()).expect("an error").to_string();
        assert!(error.contains(said), "{error}");
    }
}
