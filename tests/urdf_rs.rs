//! Robots that `urdf-rs` has read are the models of their files, and its robots are checked like files.

use catena::prelude::*;
use std::path::Path;

fn file(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("robots").join(name).display().to_string()
}

#[test]
fn a_robot_that_urdf_rs_has_read_is_the_model_of_its_file_to_the_last_bit() {
    for name in ["arm7.urdf", "double_pendulum.urdf", "quadruped.urdf"] {
        let read = urdf_rs::read_file(file(name)).expect("a robot");
        let (ours, theirs) = (Model::load(file(name)).expect("a model"), Model::from_urdf_rs(&read).expect("a model"));
        assert_eq!(ours.joint_names(), theirs.joint_names(), "{name}");
        assert_eq!(ours.link_names(), theirs.link_names(), "{name}");
        let (q, v) = ours.start().expect("a start");
        assert_eq!((&q, &v), (&theirs.start().expect("a start").0, &theirs.start().expect("a start").1), "{name}");
        // Masses, centres and axes all enter the efforts that hold a bent posture.
        let bent: Vec<f64> = (0..q.len()).map(|k| 0.3 - 0.1 * k as f64).collect();
        let [one, two] = [&ours, &theirs].map(|model| model.gravity_efforts(&bent).expect("efforts"));
        assert_eq!(one, two, "{name}");
    }
}

#[test]
fn numbers_of_a_robot_of_urdf_rs_are_set_by_their_keys_without_a_file() {
    let robot = urdf_rs::read_file(file("double_pendulum.urdf")).expect("a robot");
    let model = Model::from_urdf_rs(&robot).expect("a model");
    let (key, mass) =
        model.params().expect("numbers").into_iter().find(|(key, _)| key.ends_with(".mass")).expect("a mass");
    let heavier = model.with_params([(key.as_str(), 2.0 * mass.expect("a number"))]).expect("a model");
    let said = heavier.params().expect("numbers").into_iter().find(|(other, _)| *other == key).expect("the mass");
    assert_eq!(said.1, mass.map(|mass| 2.0 * mass));
}

#[test]
fn what_urdf_rs_lets_pass_is_refused_with_the_name_of_its_link_or_joint() {
    let whole = urdf_rs::read_file(file("double_pendulum.urdf")).expect("a robot");
    let refused = |change: &dyn Fn(&mut urdf_rs::Robot)| {
        let mut robot = whole.clone();
        change(&mut robot);
        Model::from_urdf_rs(&robot).expect_err("it cannot be simulated").to_string()
    };
    let link = whole.links.last().expect("links").name.clone();
    let error = refused(&|robot| robot.links.last_mut().expect("links").inertial.mass.value = f64::NAN);
    assert!(error.contains(&link), "{error}");
    let joint = whole.joints[0].name.clone();
    let error = refused(&|robot| robot.joints[0].parent.link = "nowhere".to_string());
    assert!(error.contains(&joint) && error.contains("nowhere"), "{error}");
}
