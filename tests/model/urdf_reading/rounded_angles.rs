//! Right angles of seven digits, in every kind of file: they are right angles.

use crate::common::scratch;
use catena::scene::{PackagePath, read_input};
use catena::session::{Model, Simulation};
use std::path::PathBuf;

/// A four-bar whose hinges are about y, the first in a frame that is rolled by an angle, and the second in one that is rolled back.
fn four_bar(name: &str, angle: &str) -> PathBuf {
    let link = |name: &str| {
        format!(
            "<link name='{name}'><inertial><origin xyz='0.2 0 0'/><mass value='1'/><inertia ixx='0.01' iyy='0.02' izz='0.02' ixy='0' ixz='0' iyz='0'/></inertial></link>"
        )
    };
    let hinge = |name: &str, [parent, child]: [&str; 2], x: f64, roll: &str, axis: &str| {
        format!(
            "<joint name='{name}' type='continuous'><parent link='{parent}'/><child link='{child}'/><origin xyz='{x} 0 0' rpy='{roll} 0 0'/><axis xyz='{axis}'/></joint>"
        )
    };
    let robot = [
        "<robot name='bar'><link name='base'/>".to_string(),
        ["crank", "coupler", "rocker"].map(link).concat(),
        hinge("a", ["base", "crank"], 0.0, &format!("-{angle}"), "0 0 1"),
        hinge("b", ["crank", "coupler"], 0.4, angle, "0 1 0"),
        hinge("c", ["base", "rocker"], 1.0, "0", "0 1 0"),
        "</robot>".to_string(),
    ];
    let folder = scratch(&format!("rounded_{name}"));
    std::fs::write(folder.join("bar.urdf"), robot.concat()).expect("written");
    let file = folder.join("scene.toml");
    let scene = "[[robot]]\nurdf = \"bar.urdf\"\npositions = { a = -0.9, b = 0.5, c = -1.3 }\n[[loop]]\ntype = \"revolute\"\n\
                 a = { link = \"coupler\", position = [0.9, 0, 0], axis = [0, 1, 0] }\nb = { link = \"rocker\", position = [0.7, 0, 0], axis = [0, 1, 0] }\n";
    std::fs::write(&file, scene).expect("written");
    file
}

/// With axes that are 2.7e-8 rad apart it was a structure, whose start was found 1.8 rad away.
#[test]
fn a_four_bar_with_a_right_angle_of_seven_digits_moves_as_one_with_all_digits() {
    let end = |name: &str, angle: &str| {
        let model = Model::load(four_bar(name, angle)).expect("a model");
        let mut run = Simulation::new(&model).tolerance(1e-6).duration(0.5);
        run.run().expect("a run");
        let report = run.finish().expect("a report");
        (report.model.degrees_of_freedom, report.links)
    };
    let exact = end("all", "1.5707963267948966");
    assert_eq!(exact.0, 1);
    assert_eq!(end("seven", "1.570796"), exact);
    assert_eq!(end("eight", "1.5707963"), exact);
}

#[test]
fn right_angles_of_seven_digits_are_right_angles_in_scene_files_and_models_of_mujoco_too() {
    let folder = scratch("rounded_files");
    let read = |name: &str, text: &str| {
        let file = folder.join(name);
        std::fs::write(&file, text).expect("written");
        read_input(&file, None, &PackagePath::default()).expect("a scene")
    };
    let body = |angle: &str| {
        let text = format!(
            "[[body]]\nshape = {{ type = \"box\", size = [1, 2, 3] }}\nmass = 1\npose = {{ rpy = [0, 0, {angle}] }}\n\
             [[obstacle]]\nname = \"wall\"\nshape = {{ type = \"half_space\" }}\npose = {{ rpy = [0, {angle}, 0] }}\n"
        );
        let scene = read("scene.toml", &text);
        [scene.robots[0].pose, scene.contact.obstacles[0].pose]
    };
    assert_eq!(body("1.5707963"), body("1.5707963267948966"));
    assert_ne!(body("1.5708"), body("1.5707963267948966"));
    let geom = |frame: &str| {
        let text = format!(
            "<mujoco><compiler angle=\"radian\"/><worldbody><body name=\"b\"><freejoint/>\
             <geom type=\"box\" size=\"1 2 3\" mass=\"1\" {frame}/></body></worldbody></mujoco>"
        );
        read("model.xml", &text).robots[0].robot.links.last().expect("a link").collisions[0].origin
    };
    for [seven, all] in [
        ["euler=\"0 -1.5707963 0\"", "euler=\"0 -1.5707963267948966 0\""],
        ["axisangle=\"1 0 0 3.1415927\"", "axisangle=\"1 0 0 3.141592653589793\""],
    ] {
        assert_eq!(geom(seven), geom(all));
    }
}
