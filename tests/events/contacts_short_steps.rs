//! A table whose legs are joints that motors hold stands on their edges: closed contacts that a motion could open, at the ends of steps of any length.

use crate::common::scratch;
use crate::mechanisms::run;
use catena::model::Model;
use catena::scene::{PackagePath, read_scene};
use catena::simulation::StepChoice;
use std::fmt::Write;

/// Side of the box that each leg ends with, which stands on its edge (m).
const FOOT: f64 = 0.04;

/// A table of 50 kg on four legs of 1 kg, each on a hinge.
fn table() -> String {
    let inertia =
        |value: f64| format!(r#"<inertia ixx="{value}" ixy="0" ixz="0" iyy="{value}" iyz="0" izz="{value}"/>"#);
    let mut text = format!(
        r#"<robot name="table"><link name="top"><inertial><mass value="50"/>{}</inertial></link>"#,
        inertia(1.0)
    );
    for (leg, [x, y]) in [[0.2, 0.15], [0.2, -0.15], [-0.2, 0.15], [-0.2, -0.15]].iter().enumerate() {
        let (eighth, own) = (std::f64::consts::FRAC_PI_4, inertia(0.002));
        write!(
            text,
            r#"<link name="leg{leg}"><inertial><origin xyz="0 0 -0.05"/><mass value="1"/>{own}</inertial>
            <collision><origin xyz="0 0 -0.1" rpy="0 {eighth} 0"/><geometry><box size="{FOOT} {FOOT} {FOOT}"/></geometry></collision></link>
            <joint name="hinge{leg}" type="continuous"><parent link="top"/><child link="leg{leg}"/><origin xyz="{x} {y} 0"/><axis xyz="0 1 0"/></joint>"#
        )
        .expect("text");
    }
    text + "</robot>"
}

/// The table 50 mm above a floor, with motors.
fn scene() -> String {
    let height = 0.15 + FOOT * std::f64::consts::FRAC_1_SQRT_2;
    let mut text = format!(
        "[[robot]]\nname = \"t\"\nurdf = \"table.urdf\"\nbase = \"floating\"\npose = {{ position = [0, 0, {height:?}] }}\n\
         [[obstacle]]\nname = \"floor\"\nshape = {{ type = \"half_space\" }}\nfriction = 0.8\n"
    );
    for leg in 0..4 {
        let motor = "kind = \"position\"\ntarget = 0.0\nkp = 500.0\nkd = 20.0\n";
        write!(text, "[[motor]]\njoint = \"hinge{leg}\"\n{motor}").expect("text");
    }
    text
}

#[test]
fn a_short_step_after_long_ones_leaves_no_overlap_of_contacts_that_stick() {
    let folder = scratch("table");
    std::fs::write(folder.join("table.urdf"), table()).expect("a file");
    std::fs::write(folder.join("scene.toml"), scene()).expect("a file");
    let read = read_scene(&folder.join("scene.toml"), &PackagePath::default()).expect("a scene");
    let (model, start) = Model::from_scene(&read).expect("a model");
    let start = model.initial_state(&start.positions, &start.velocities, None).expect("a start");
    // The last step is what longer ones have left of the run: 5 to 45 ms, where the overlap was 2e-13 to 6e-11 m.
    for duration in (0..16).map(|count| 0.5 + 0.005 * f64::from(count)) {
        let finished = run(&model.mechanism, &start, duration, StepChoice::Tolerance(1e-4));
        let overlap = finished.summary.contact.penetration;
        assert!(overlap <= 1e-13, "{overlap:e} m after {duration} s");
    }
}
