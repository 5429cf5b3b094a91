//! Links on slides that push bodies over a floor: friction that holds bears no weight that the floor can carry.

use crate::scene_files::{joint, report, scene_of};
use catena::report::Report;

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
