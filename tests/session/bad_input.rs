//! Every wrong input is an error that names it, and nothing is written.

use crate::{folder, robot};
use catena::prelude::*;
use catena::session::Rollout;

fn arm() -> Model {
    Model::load(robot("arm7.urdf")).expect("a model")
}

#[test]
fn wrong_starts_efforts_and_names_are_named() {
    let model = arm();
    let new = || Simulation::new(&model);
    let refused = |result: Result<Simulation, Error>| result.err().expect("refused").to_string();
    assert!(
        refused(new().start([("elbow", 0.1)]))
            .starts_with(r#"there is no joint "elbow"; the joints that move are "joint1""#)
    );
    assert!(refused(new().start([("joint1", f64::NAN)])).contains(r#"the position of joint "joint1" is not finite"#));
    assert!(refused(new().start([("joint1", [0.1, 0.2])])).contains("needs one number (angle), not 2"));
    assert!(refused(new().start([("joint1", 0.1), ("joint1", 0.2)])).contains(r#"given twice for joint "joint1""#));
    assert_eq!(refused(new().start_from(&[0.0; 6], &[0.0; 7])), "q: 6 numbers where 7 are wanted");
    let mut q = [0.0; 7];
    q[2] = f64::INFINITY;
    assert!(refused(new().start_from(&q, &[0.0; 7])).contains(r#"q: the number for "joint3" is inf"#));
    let mut simulation = new();
    let count = simulation.set_efforts(&[0.0; 3]).expect_err("refused").to_string();
    assert_eq!(count, "3 efforts for 7 degrees of freedom: give one for each, in the order of the velocities");
    let mut efforts = [0.0; 7];
    efforts[4] = f64::NAN;
    let none = simulation.set_efforts(&efforts).expect_err("refused").to_string();
    assert!(none.contains(r#"the effort on joint "joint5" is NaN"#), "{none}");
    assert!(simulation.set_controller(0.0, |_, _| {}).expect_err("refused").to_string().contains("period is 0"));
    assert!(simulation.pose("hand").expect_err("refused").to_string().starts_with(r#"there is no link "hand""#));
    assert!(simulation.position("elbow").expect_err("refused").to_string().starts_with(r#"there is no joint "elbow""#));
}

#[test]
fn wrong_options_are_named_before_anything_is_written() {
    let model = arm();
    let folder = folder("options");
    let path = folder.join("log.mcap");
    let refused = |simulation: Simulation| {
        let mut simulation = simulation.log(&path);
        simulation.run().expect_err("refused").to_string()
    };
    let new = || Simulation::new(&model);
    assert_eq!(refused(new().tolerance(0.0)), "tolerance is 0: must be greater than zero");
    assert_eq!(refused(new().tolerance(f64::NAN)), "tolerance is NaN: give a finite number");
    assert_eq!(refused(new().duration(-1.0)), "duration is -1: must be greater than zero");
    assert_eq!(refused(new().rate(1e7)), "rate is 10000000: must be at most 1e6");
    assert!(refused(new().fixed(0, 0.01)).contains("stages"));
    assert!(refused(new().fixed(4, f64::INFINITY)).contains("step is inf"));
    assert_eq!(std::fs::read_dir(&folder).expect("a folder").count(), 0, "nothing was written");
    let over = folder.join("copy.urdf");
    std::fs::copy(robot("arm7.urdf"), &over).expect("copied");
    let mut simulation = Simulation::new(&Model::load(&over).expect("a model")).log(&over);
    assert!(simulation.run().expect_err("refused").to_string().contains("the run is made from"));
    let mut simulation = new().log(folder.join("missing/log.mcap"));
    assert!(simulation.run().expect_err("refused").to_string().contains("there is no folder"));
    std::fs::remove_dir_all(folder).expect("removed");
}

#[test]
fn nobody_steps_back_or_beyond_the_end() {
    let mut simulation = Simulation::new(&arm()).duration(0.2);
    simulation.step_to(0.1).expect("it runs");
    for wrong in [0.05, 0.3, f64::NAN] {
        let error = simulation.step_to(wrong).expect_err("refused").to_string();
        assert!(error.contains("the run is at 0.1 s and ends at 0.2 s"), "{error}");
    }
    simulation.step_to(0.2).expect("it goes on");
}

#[test]
fn files_and_worlds_that_cannot_be_are_named() {
    let refused = |result: Result<Model, Error>| result.expect_err("refused").to_string();
    assert!(refused(Model::load("nowhere.urdf")).contains("nowhere.urdf"));
    let nan = Model::loader().gravity([0.0, f64::NAN, 0.0]).load(robot("arm7.urdf"));
    assert_eq!(refused(nan), "gravity is NaN: give a finite number");
    let package = Model::loader().package("arm", "/nowhere").load(robot("arm7.urdf"));
    assert!(refused(package).contains(r#"--package arm: there is no folder "/nowhere""#));
}

#[test]
fn numbers_of_many_runs_that_a_model_does_not_have_are_named_before_any_run() {
    let model = arm();
    let params = [("link.forearm.mess".to_string(), vec![1.0])];
    let options = Rollout { duration: Some(0.1), params: &params, ..Rollout::default() };
    let refused = model.rollout(&[0.0; 7], &[0.0; 7], &options).expect_err("refused").to_string();
    assert!(refused.contains("link.forearm.mess"), "{refused}");
}

#[test]
fn wrong_arrays_of_many_runs_are_named_and_a_run_that_fails_is_told() {
    let model = arm();
    let options = Rollout { duration: Some(0.1), ..Rollout::default() };
    let refused = |q: &[f64], v: &[f64]| model.rollout(q, v, &options).expect_err("refused").to_string();
    assert_eq!(refused(&[0.0; 8], &[0.0; 7]), "q0, a row a run: 8 numbers where 14 are wanted");
    assert_eq!(refused(&[0.0; 14], &[0.0; 7]), "v0, a row a run: 7 numbers where 14 are wanted");
    let mut q = [0.0; 14];
    q[8] = f64::NAN;
    assert!(refused(&q, &[0.0; 14]).contains(r#"q0: the number for "joint2" is NaN"#));
    q[8] = 1e12;
    let runs = model.rollout(&q, &[0.0; 14], &options).expect("the first runs");
    assert_eq!(runs.failures.len(), 1);
    assert!(runs.failures[0].0 == 1 && runs.failures[0].1.contains("joint2"), "{:?}", runs.failures);
    assert!(runs.q[..14].iter().all(|number| number.is_finite()) && runs.q[14..].iter().all(|number| number.is_nan()));
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_ends_the_run_with_an_error() {
    let mut simulation = Simulation::new(&arm()).duration(5.0).rate(1000.0).log("/dev/full");
    let error = simulation.run().and_then(|()| simulation.finish().map(drop)).expect_err("no room");
    assert!(error.to_string().contains("/dev/full"), "{error}");
}

#[test]
fn the_text_of_a_robot_is_the_model_of_its_file_and_its_errors_have_the_name_and_the_line() {
    let path = format!("{}/robots/quadruped.urdf", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).expect("the file");
    let (ours, theirs) = (Model::load(&path), Model::loader().load_urdf_text(&text, "robots/quadruped.urdf"));
    let (ours, theirs) = (ours.expect("a model"), theirs.expect("a model"));
    let (q, v) = ours.start().expect("a start");
    assert_eq!(theirs.start().expect("a start"), (q.clone(), v));
    let [one, two] = [&ours, &theirs].map(|model| model.mass_matrix(&q).expect("a matrix"));
    assert_eq!(one, two);
    // Nothing is read from a file of this name.
    let broken = text.replacen("<mass value=\"", "<mass value=\"-", 1);
    let line = 1 + broken.lines().position(|line| line.contains("<mass value=\"-")).expect("a mass");
    let refused = Model::loader().load_urdf_text(&broken, "nowhere/of_a_program.urdf").expect_err("a negative mass");
    let (words, place) = (refused.to_string(), format!("nowhere/of_a_program.urdf:{line}:"));
    assert!(words.starts_with(&place) && words.contains("mass"), "{words}");
}
