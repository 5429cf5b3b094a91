//! Joints that are moved in time and press on what cannot give way: the run stops and names them.

use crate::scene_files::scene_of;
use catena::prelude::{Model, Simulation};

const BLOCK: &str = "<link name='block'><inertial><mass value='1.3'/><inertia ixx='0.01' iyy='0.01' izz='0.01' ixy='0' ixz='0' iyz='0'/></inertial>\
    <collision><geometry><box size='0.2 0.2 0.2'/></geometry></collision></link>";

/// The message with which a scene stops, and when (s).
fn stopped(folder: &str, urdf: &str, text: &str) -> (String, f64) {
    let file = scene_of(folder, &format!("<link name='base'/>{urdf}"), text);
    let model = Model::load(&file).unwrap_or_else(|error| panic!("{error}"));
    let mut simulation = Simulation::new(&model).tolerance(1e-6).duration(3.0);
    let error = simulation.run().expect_err("nothing can give way").to_string();
    let time = error.split("t = ").nth(1).and_then(|rest| rest.split(' ').next()?.parse().ok()).expect("a time");
    let energy = simulation.energy().expect("energies").total();
    assert!(energy.is_finite(), "{error}");
    (error, time)
}

fn slide(axis: &str, height: f64) -> String {
    format!(
        "{BLOCK}<joint name='drive' type='prismatic'><parent link='base'/><child link='block'/><origin xyz='0 0 {height}'/><axis xyz='{axis}'/>\
         <limit lower='-9' upper='9' effort='9' velocity='9'/></joint>"
    )
}

#[test]
fn a_motion_that_presses_a_link_on_the_floor_stops_the_run() {
    let text = "[[robot]]\nurdf = \"robot.urdf\"\n[[motion]]\njoint = \"drive\"\nposition = { formula = \"-v*t\", v = 0.25 }\n\
        [[obstacle]]\nname = \"floor\"\nshape = { type = \"half_space\" }\n";
    let (error, time) = stopped("presses_floor", &slide("0 0 1", 0.13), text);
    assert!(["drive", "block", "floor"].iter().all(|name| error.contains(name)), "{error}");
    assert!((time - 0.03 / 0.25).abs() < 1e-9, "{error}");
}

#[test]
fn a_motion_that_runs_a_box_against_a_wall_stops_the_run_there() {
    // The block pushes the box from 0.35 m on; the wall is at 0.9 m.
    let text = "[[robot]]\nurdf = \"robot.urdf\"\n[[motion]]\njoint = \"drive\"\nposition = { formula = \"v*t\", v = 0.5 }\n\
        [[body]]\nname = \"box\"\nshape = { type = \"box\", size = [0.2, 0.2, 0.2] }\nmass = 2\npose.position = [0.35, 0, 0.1]\n\
        [[obstacle]]\nname = \"floor\"\nshape = { type = \"half_space\" }\nfriction = 0.4\n\
        [[obstacle]]\nname = \"wall\"\nshape = { type = \"box\", size = [0.1, 1, 1] }\npose.position = [0.95, 0, 0.5]\n";
    let (error, time) = stopped("presses_wall", &slide("1 0 0", 0.1001), text);
    assert!(error.contains("drive") && error.contains("wall"), "{error}");
    // It may slide ahead of the block, but not through the wall: block, box and wall touch when the block has gone 0.6 m.
    assert!((time - 0.6 / 0.5).abs() < 1e-6, "{error}");
}

#[test]
fn a_winch_that_hoists_a_crate_against_a_ceiling_stops_the_run() {
    let text = "[[body]]\nname = \"crate\"\nshape = { type = \"box\", size = [0.3, 0.3, 0.2] }\nmass = 2\npose.position = [0, 0, 0.1]\n\
        [[obstacle]]\nname = \"floor\"\nshape = { type = \"half_space\" }\n\
        [[obstacle]]\nname = \"ceiling\"\nshape = { type = \"box\", size = [2, 2, 0.1] }\npose.position = [0, 0, 1.05]\n\
        [[rope]]\nname = \"hoist\"\npoints = [{ link = \"world\", position = [0, 0, 1.6] }, { link = \"crate\", position = [0, 0, 0.1] }]\n\
        length = { formula = \"1.4-v*t\", v = 0.4 }\n";
    let (error, time) = stopped("presses_ceiling", "", text);
    assert!(error.contains("hoist") && error.contains("ceiling"), "{error}");
    // The top of the crate is at 1 m when the rope has 0.6 m.
    assert!((time - 0.8 / 0.4).abs() < 1e-6, "{error}");
}
