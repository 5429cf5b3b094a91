//! Links on slides that push bodies over a floor: friction that holds bears no weight that the floor can carry.

use crate::scene_files::{joint, report, scene_of};
use catena::prelude::{Model, Simulation};
use catena::report::Report;
use nalgebra::{Rotation3, Vector3};

const GRAVITY: f64 = 9.81;

/// A ram of 1 kg on a rail, whose face touches a box of 2 kg on a floor, with a motor.
fn pushed(folder: &str, motor: &str, [face, floor]: [f64; 2], [height, gap]: [f64; 2], tolerance: f64) -> Report {
    let ram = format!(
        "<link name='base'/><link name='ram'><inertial><mass value='1'/><inertia ixx='0.01' ixy='0' ixz='0' iyy='0.01' iyz='0' izz='0.01'/></inertial>\
         <collision><geometry><box size='0.1 0.3 0.15'/></geometry></collision></link>\
         <joint name='x' type='prismatic'><origin xyz='0 0 {height}'/><parent link='base'/><child link='ram'/><axis xyz='1 0 0'/>\
         <limit lower='-1' upper='2' effort='500' velocity='9'/></joint>"
    );
    let scene = format!(
        "[[robot]]\nurdf = \"robot.urdf\"\n[[motor]]\njoint = \"x\"\n{motor}\n\
         [[body]]\nname = \"crate\"\nshape = {{ type = \"box\", size = [0.2, 0.2, 0.25] }}\nmass = 2\npose.position = [{}, 0, 0.125]\n\
         [[obstacle]]\nname = \"floor\"\nshape = {{ type = \"half_space\" }}\nfriction = {floor}\n[contact]\nfriction = {face}\n",
        0.15 + gap
    );
    report(&scene_of(folder, &ram, &scene), &[], &[], Some(0.5), tolerance)
}

#[test]
fn a_box_that_sticks_to_a_ram_is_braked_by_all_of_its_weight() {
    for (case, (force, height)) in [(6.0, 0.1607), (3.0, 0.08), (20.0, 0.2)].into_iter().enumerate() {
        for tolerance in [1e-3, 1e-6, 1e-8] {
            let motor = format!("kind = \"effort\"\ntarget = {force}");
            let report = pushed(&format!("ram_{case}"), &motor, [0.4, 0.15], [height, 0.0], tolerance);
            let acceleration = (force - 0.15 * 2.0 * GRAVITY) / 3.0;
            let (place, speed) = joint(&report, "x");
            println!("{force} N, {tolerance:e}: {:e} {:e}", place - 0.125 * acceleration, speed - 0.5 * acceleration);
            // Tangents that stick are more compliant than normals by 1e10: they bear that part of the weight, and friction errs by as much; and roundings.
            let error = 1e-9 * 0.15 * 2.0 * GRAVITY / 3.0;
            assert!((speed - 0.5 * acceleration).abs() < 0.5 * error, "{force} N, {tolerance:e}: {speed}");
            assert!((place - 0.125 * acceleration).abs() < 0.125 * error, "{force} N, {tolerance:e}: {place}");
        }
    }
}

#[test]
fn a_ram_under_a_velocity_motor_pushes_a_box_at_the_speed_at_which_it_balances_friction() {
    // kd (w − v) = μ m g once the motion is steady, after some m/kd = 7.5 ms.
    let report =
        pushed("ram_steady", "kind = \"velocity\"\nkd = 400\ntarget = 0.5", [0.4, 0.15], [0.1607, 0.001], 1e-6);
    let steady = 0.5 - 0.15 * 2.0 * GRAVITY / 400.0;
    let (_, speed) = joint(&report, "x");
    assert!((speed - steady).abs() < 1e-9 * 0.15 * 2.0 * GRAVITY / 400.0, "{speed} instead of {steady}");
}

/// A ball of 1 kg on a slide that pushes a box over a floor with a force of gravity's own size, beside its middle, in a world that is turned.
fn pushed_by_a_ball(folder: &str, world: &Rotation3<f64>) -> Simulation {
    let slide = "<link name='base'/><link name='hand'><inertial><mass value='1'/><inertia ixx='.01' iyy='.01' izz='.01' ixy='0' ixz='0' iyz='0'/></inertial>\
         <collision><geometry><sphere radius='0.03'/></geometry></collision></link>\
         <joint name='j' type='prismatic'><parent link='base'/><child link='hand'/><origin xyz='0 0 0.05'/><axis xyz='1 0 0'/>\
         <limit lower='-3' upper='3' effort='100' velocity='100'/></joint>";
    let list = |vector: Vector3<f64>| format!("[{:?}, {:?}, {:?}]", vector.x, vector.y, vector.z);
    let (roll, pitch, yaw) = world.euler_angles();
    let turned = list(Vector3::new(roll, pitch, yaw));
    let scene = format!(
        "scene.gravity = {}\n[[robot]]\nurdf = \"robot.urdf\"\npose.rpy = {turned}\n[[load]]\njoint = \"j\"\neffort = 10.3\n\
         [[body]]\nname = \"crate\"\nshape = {{ type = \"box\", size = [0.1, 0.16, 0.085] }}\nmass = {CRATE}\n\
         pose = {{ position = {}, rpy = {turned} }}\n\
         [[obstacle]]\nname = \"floor\"\nshape = {{ type = \"half_space\" }}\nfriction = 0.52\npose.rpy = {turned}\n\
         [contact]\nfriction = 0.22\n[[contact.pair]]\na = \"hand\"\nb = \"floor\"\nignore = true\n",
        list(world * Vector3::new(0.0, 0.0, -GRAVITY)),
        list(world * Vector3::new(0.081, -0.024, 0.0425)),
    );
    let model = Model::load(scene_of(folder, slide, &scene)).unwrap_or_else(|error| panic!("{error}"));
    Simulation::new(&model).tolerance(1e-7).duration(0.5)
}

/// The mass of the box that the ball pushes (kg).
const CRATE: f64 = 1.29;

#[test]
fn a_box_that_sticks_to_a_ball_on_a_slide_goes_the_same_way_in_a_turned_world() {
    let ends = |folder: &str, world: &Rotation3<f64>| {
        let mut simulation = pushed_by_a_ball(folder, world);
        simulation.run().unwrap_or_else(|error| panic!("{error}"));
        world.inverse() * simulation.link("crate").expect("a box").position
    };
    let plain = ends("ball_on_slide", &Rotation3::identity());
    for (number, [roll, pitch, yaw]) in
        [[0.5, 0.0, 0.0], [0.0, 0.7, 0.0], [1.571, 0.0, 0.0], [0.3, -1.1, 2.0]].into_iter().enumerate()
    {
        let off =
            (ends(&format!("ball_on_slide_{number}"), &Rotation3::from_euler_angles(roll, pitch, yaw)) - plain).norm();
        println!("world {number}: {off:e} m");
        assert!(off < 1e-8, "world {number}: {off:e} m");
    }
}

#[test]
fn the_forces_that_a_box_on_a_ball_reports_are_its_mass_times_its_acceleration() {
    let mut simulation = pushed_by_a_ball("forces_on_crate", &Rotation3::identity());
    let span = 1e-4;
    for time in [0.1, 0.2, 0.3] {
        let mut at = |time: f64| {
            simulation.step_to(time).unwrap_or_else(|error| panic!("{error}"));
            let force = simulation.sense().expect("readings").contact_force("crate").expect("a force");
            (simulation.link("crate").expect("a box").linear_velocity, force)
        };
        let ((before, _), (_, force), (after, _)) = (at(time - span), at(time), at(time + span));
        let acceleration = (after - before) / (2.0 * span);
        let off = (force / CRATE - Vector3::new(0.0, 0.0, GRAVITY) - acceleration).norm();
        println!("{time} s: {acceleration:?}, off by {off:e} m/s²");
        // Differences of velocities of 1e-12 m/s, and the curvature of the way.
        assert!(off < 1e-6, "{time} s: {off:e} m/s² beside {acceleration:?}");
    }
}
