//! Every number of a scene file and of its robots shows in the value of a key path: what can be written can be swept.
//!
//! The texts below have all tables and keys of `doc/scene_files.md` that take numbers. One number after the other is written otherwise; the list of
//! key paths must then have another value. Numbers that say how many things there are, and which, are words here, or are left as they are.

use crate::common::command;
use catena::scene::{FilesOnDisk, PackagePath, Scene, scene_from_text};
use std::path::Path;

const ARM: &str = r#"<robot name="arm">
  <link name="base"/>
  <link name="upper"><inertial><origin xyz="0.1 0.2 -0.5" rpy="0.1 0.2 0.3"/><mass value="1.5"/>
    <inertia ixx="0.2" iyy="0.21" izz="0.15" ixy="0.01" ixz="0.011" iyz="0.012"/></inertial>
    <collision><origin xyz="0.5 0.1 0.2" rpy="0.3 0.2 0.1"/><geometry><capsule radius="0.1" length="0.75"/></geometry></collision>
    <collision><geometry><box size="0.1 0.2 0.3"/></geometry></collision></link>
  <link name="lower"><inertial><mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="nut"><inertial><mass value="0.5"/><inertia ixx="0.1" iyy="0.1" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="tip"><inertial><mass value="0.25"/><inertia ixx="0.1" iyy="0.1" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><origin xyz="0.1 0.2 0.3" rpy="0.4 0.5 0.6"/><axis xyz="0.3 0.9 0.2"/>
    <limit lower="-2" upper="2.5" effort="9" velocity="3"/><dynamics friction="0.1" damping="0.3"/></joint>
  <joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/><axis xyz="0 1 0"/></joint>
  <joint name="screw" type="screw"><parent link="lower"/><child link="nut"/><axis xyz="0 0 1"/><thread_pitch value="0.01"/></joint>
  <joint name="wrist" type="continuous"><parent link="lower"/><child link="tip"/><axis xyz="1 0 0"/><mimic joint="elbow" multiplier="0.5" offset="0.2"/></joint>
  <transmission name="drive"><type>transmission_interface/SimpleTransmission</type><joint name="elbow"/>
    <actuator name="motor"><mechanicalReduction>20</mechanicalReduction><rotorInertia>0.0001</rotorInertia></actuator></transmission>
  <gazebo reference="upper"><mu1>0.8</mu1></gazebo>
</robot>"#;

const SCENE: &str = r#"
[scene]
gravity = [0.1, 0.2, -9.81]
[[robot]]
name = "arm"
urdf = "arm.urdf"
pose = { position = [0.1, 0.2, 9], rpy = [0.1, 0.2, 0.3] }
positions = { shoulder = 0.5 }
velocities = { shoulder = 0.25 }
[[body]]
name = "ball"
shape = { type = "sphere", radius = 0.1 }
density = 1000
friction = 0.5
restitution = 0.25
rolling_friction = 0.003
spinning_friction = 0.002
surface_velocity = [0.1, 0.2, 0.3]
pose = { position = [3, 0.1, 2], rpy = [0.1, 0.2, 0.3] }
velocity = { linear = [1, 2, 3], angular = [0.1, 0.2, 0.3] }
[[body]]
name = "stone"
shape = { type = "ellipsoid", radii = [0.3, 0.2, 0.1] }
mass = 2
pose = { position = [6, 0.1, 2] }
[[body]]
name = "brick"
shape = { type = "box", size = [0.3, 0.2, 0.1] }
mass = 2
pose = { position = [12, 0.1, 2] }
count = TWO
spacing = [2, 0.3, 0.4]
[[body]]
name = "rod"
shape = { type = "cylinder", radius = 0.1, length = 0.7 }
mass = 3
pose = { position = [20, 0.1, 2] }
[[loop]]
name = "stay"
type = "distance"
a = { link = "brick1", position = [0.01, 0.02, 0.03] }
b = { link = "world", position = [12.5, 0.3, 4] }
length = 2.1
[[loop]]
name = "hinge"
type = "spherical"
a = { link = "rod", position = [0.01, 0.02, 0.03] }
b = { link = "world", position = [20.01, 0.12, 2.03] }
[[spring]]
name = "band"
a = { link = "ball", position = [0.01, 0.02, 0.03] }
b = { link = "world", position = [4, 0.2, 3] }
stiffness = 30
damping = 0.5
rest_length = 1.5
[[spring]]
name = "coil"
joint = "arm/shoulder"
stiffness = 2
damping = 0.1
rest = 0.1
[[rope]]
name = "rope"
points = [{ link = "world", position = [20.5, 0.3, 6] }, { link = "rod", position = [0.01, 0.02, 0.03] }, { link = "brick2", position = [0.04, 0.05, 0.06] }]
length = 30
stop = 0.002
restitution = 0.3
[[rope]]
name = "winch"
points = [{ link = "world", position = [6.5, 0.3, 6] }, { link = "stone", position = [0.01, 0.02, 0.03] }]
length = { formula = "l - v*t", l = 6.2, v = 0.1 }
longest = 9
[[load]]
joint = "arm/shoulder"
effort = 0.033
factor = [[0.5, 0.25], [1, 2]]
interpolation = "linear"
from = 0.6
until = 1.7
[[load]]
link = "ball"
position = [0.01, 0.02, 0.03]
force = [1, 2, 5]
torque = [0.1, 0.2, 0.3]
wave = { mean = 0.4, amplitude = 1, frequency = 6.3, phase = 0.7 }
[[load]]
link = "stone"
force = [1, 2, 5]
factor = { formula = "a*sin(w*t)", a = 0.3, w = 5 }
[[load]]
link = "brick1"
force = [1, 2, 5]
factor = 0.5
[[drag]]
link = "ball"
position = [0.01, 0.02, 0.03]
linear = 0.2
quadratic = 0.1
angular = 0.01
angular_quadratic = 0.02
[[motor]]
joint = "arm/shoulder"
kind = "position"
target = [[0.5, 0.25], [1, 0.5]]
interpolation = "cubic"
kp = 100
kd = 5
max_effort = 50
period = 0.01
gravity_compensation = 0.8
[[motor]]
joint = "arm/elbow"
kind = "velocity"
target = { formula = "a*sin(w*t)", a = 0.3, w = 5 }
kd = 5
[[motor]]
joint = "arm/screw"
kind = "effort"
target = 0.75
[[joint]]
name = "arm/shoulder"
limit = [-1.5, 1.75]
restitution = 0.5
friction = 0.25
damping = 0.125
armature = 0.01
[[obstacle]]
name = "slope"
shape = { type = "half_space", normal = [0.1, 0.2, 1] }
pose = { position = [0.1, 0.2, -90], rpy = [0.1, 0.2, 0.3] }
friction = 0.5
restitution = 0.25
rolling_friction = 0.003
spinning_friction = 0.002
surface_velocity = [0.1, 0.2, 0.3]
[[obstacle]]
name = "post"
shape = { type = "capsule", radius = 0.5, length = 2 }
pose = { position = [90, 0.1, 0.2] }
[[obstacle]]
name = "crate"
shape = { type = "box", size = [1, 2, 3] }
pose = { position = [0.1, 90, 0.2] }
[[link]]
name = "arm/upper"
friction = 0.7
restitution = 0.2
rolling_friction = 0.003
spinning_friction = 0.002
surface_velocity = [0.1, 0.2, 0.3]
[contact]
friction = 0.4
restitution = 0.1
rolling_friction = 0.001
spinning_friction = 0.0005
[[contact.pair]]
a = "ball"
b = "crate"
friction = 0.7
restitution = 0.25
rolling_friction = 0.004
spinning_friction = 0.003
[simulation]
duration = 2
tolerance = 1e-5
rate = 50
"#;

/// Relations of joints, moved joints and given steps, which exclude others.
const DRIVEN: &str = r#"
[[robot]]
name = "arm"
urdf = "arm.urdf"
[[coupling]]
name = "gear"
joints = { shoulder = 1, elbow = -2.5 }
offset = 0.3
[[motion]]
joint = "screw"
position = [[0.5, 0.25], [1.5, 0.75]]
[simulation]
duration = 2
stages = FOUR
step = 0.01
"#;

/// Where numbers other than zero stand in a text, outside of names.
fn numbers(text: &str) -> Vec<(usize, usize)> {
    let is_part = |byte: u8| byte.is_ascii_alphanumeric() || matches!(byte, b'.' | b'-' | b'+' | b'_');
    let bytes = text.as_bytes();
    let mut found = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let end = at + bytes[at..].iter().take_while(|byte| is_part(**byte)).count();
        let is_number = text[at..end].parse::<f64>().is_ok_and(|number| number.is_finite() && number != 0.0);
        if is_number {
            found.push((at, end));
        }
        at = end.max(at + 1);
    }
    found
}

fn read(folder: &Path, robot: &str, scene: &str) -> Result<Scene, String> {
    std::fs::write(folder.join("arm.urdf"), robot).expect("written");
    let scene = scene.replace("TWO", "2").replace("FOUR", "4");
    scene_from_text(&scene, &folder.join("scene.toml"), &mut FilesOnDisk(&PackagePath::default()))
        .map_err(|error| error.to_string())
}

/// All key paths with the values that the files say.
fn values(scene: &Scene) -> Vec<(String, Option<f64>)> {
    scene.parameters().iter().map(|one| (one.key().to_string(), one.said())).collect()
}

#[test]
fn every_number_that_is_written_is_that_of_a_key_path() {
    let folder = command::folder("parameters_walked");
    let mut missing = Vec::new();
    let place = |text: &str, start: usize| {
        let line = text[..start].rfind('\n').map_or(0, |at| at + 1);
        text[line..].lines().next().unwrap_or_default().trim().to_string()
    };
    let otherwise = |text: &str, (start, end): (usize, usize)| {
        let number: f64 = text[start..end].parse().expect("a number");
        format!("{}{}{}", &text[..start], 0.96875 * number, &text[end..])
    };
    let base = [SCENE, DRIVEN].map(|scene| values(&read(&folder, ARM, scene).expect("a scene")));
    // What a scene says of a joint or link replaces what the robot says: the other scene says nothing of it.
    let of_robot = numbers(ARM);
    assert!(of_robot.len() >= 60, "{}", of_robot.len());
    for at in of_robot {
        let robot = otherwise(ARM, at);
        let edited = [SCENE, DRIVEN].map(|scene| read(&folder, &robot, scene).map(|scene| values(&scene)));
        if edited.iter().zip(&base).all(|(edited, base)| edited.as_ref().is_ok_and(|edited| edited == base)) {
            missing.push(place(ARM, at.0));
        }
        missing.extend(edited.into_iter().filter_map(Result::err));
    }
    for (scene, base) in [SCENE, DRIVEN].into_iter().zip(&base) {
        for at in numbers(scene) {
            match read(&folder, ARM, &otherwise(scene, at)) {
                Ok(edited) if values(&edited) == *base => missing.push(place(scene, at.0)),
                Ok(_) => {}
                Err(error) => missing.push(error),
            }
        }
    }
    assert!(missing.is_empty(), "no key path has\n{}", missing.join("\n"));
}
