//! Claims about scene files: what they may say, what they may not, and where the command line has the last word.

mod bodies;
mod built;
mod command_line;
mod contact;
mod contact_errors;
mod errors;
mod holding;
mod joint_errors;
mod joints;
mod surfaces;

use crate::common::command;
use catena::mechanism::motion::state::State;
use catena::model::{Model, Start};
use catena::scene::{FilesOnDisk, PackagePath, Scene, SceneError, scene_from_text};
use std::path::{Path, PathBuf};

/// Two rods one below the other, a point mass fixed to the second, and a leaf without mass.
const DOUBLE: &str = r#"<robot name="double">
  <link name="base"/>
  <link name="upper"><inertial><origin xyz="0 0 -0.5" rpy="0.3 0.2 0.1"/><mass value="1"/>
    <inertia ixx="0.1" iyy="0.2" izz="0.15" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="lower"><inertial><origin xyz="0 0 -0.5"/><mass value="1"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="weight"><inertial><mass value="2"/><inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="sensor"/>
  <link name="lens"/>
  <joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/></joint>
  <joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/><origin xyz="0 0 -1"/><axis xyz="0 1 0"/></joint>
  <joint name="weld" type="fixed"><parent link="lower"/><child link="weight"/><origin xyz="0.1 0 -1" rpy="0 0 0.5"/></joint>
  <joint name="tilt" type="continuous"><parent link="lower"/><child link="sensor"/><axis xyz="0 1 0"/></joint>
  <joint name="mount" type="fixed"><parent link="sensor"/><child link="lens"/></joint>
</robot>"#;

const BALL: &str = r#"<robot name="ball">
  <link name="ball"><inertial><origin xyz="0.1 0 0"/><mass value="1"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
</robot>"#;

/// One joint of every kind, one after the other; what each says of limits, friction and damping is in its line.
const LIMBS: &str = r#"<robot name="limbs">
  <link name="base"/>
  LINKS
  <joint name="hinge" type="revolute"><parent link="base"/><child link="link1"/><axis xyz="0 1 0"/><limit lower="-1" upper="2" effort="30" velocity="4"/><dynamics damping="0.5" friction="0.25"/></joint>
  <joint name="slide" type="prismatic"><parent link="link1"/><child link="link2"/><limit lower="0.1" upper="0.1" effort="0" velocity="0"/></joint>
  <joint name="wheel" type="continuous"><parent link="link2"/><child link="link3"/><limit effort="7" velocity="0"/></joint>
  <joint name="ball" type="spherical"><parent link="link3"/><child link="link4"/><dynamics friction="0.5"/></joint>
  <joint name="sheet" type="planar"><parent link="link4"/><child link="link5"/><axis xyz="0 0 1"/></joint>
  <joint name="free" type="floating"><parent link="link5"/><child link="link6"/></joint>
  <joint name="weld" type="fixed"><parent link="link6"/><child link="link7"/></joint>
  <joint name="finger" type="revolute"><parent link="base"/><child link="link8"/><limit lower="0" upper="0" effort="1" velocity="1"/><mimic joint="hinge"/></joint>
  <joint name="thumb" type="revolute"><parent link="base"/><child link="link9"/><limit effort="1" velocity="1"/></joint>
  <joint name="cap" type="continuous"><parent link="base"/><child link="link10"/></joint>
  <link name="link10"/>
  <loop_joint name="closure" type="spherical"><link1 link="link1" xyz="0.3 0 0.5"/><link2 link="link9" xyz="0.3 0 0.5"/></loop_joint>
</robot>"#;

fn limbs() -> String {
    let inertial = "<inertial><origin xyz=\"0.1 0.2 -0.5\"/><mass value=\"1\"/>\
         <inertia ixx=\"0.1\" iyy=\"0.1\" izz=\"0.1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>";
    let links: String = (1..=9).map(|index| format!("<link name=\"link{index}\">{inertial}</link>")).collect();
    LIMBS.replace("LINKS", &links)
}

/// A folder with the robots in it.
fn folder(name: &str) -> PathBuf {
    let folder = command::folder(name);
    for (file, text) in [("double.urdf", DOUBLE), ("ball.urdf", BALL), ("limbs.urdf", &limbs())] {
        std::fs::write(folder.join(file), text).expect("written");
    }
    folder
}

fn read(folder: &Path, text: &str) -> Result<Scene, SceneError> {
    scene_from_text(text, &folder.join("scene.toml"), &mut FilesOnDisk(&PackagePath::default()))
}

fn build(folder: &Path, text: &str) -> (Model, Start, State) {
    let scene = read(folder, text).unwrap_or_else(|error| panic!("{error}"));
    let (model, start) = Model::from_scene(&scene).unwrap_or_else(|error| panic!("{error}"));
    let state = model.initial_state(&start.positions, &start.velocities, None).unwrap();
    (model, start, state)
}

/// The message of a scene that cannot be, without the folder.
fn refusal(folder: &Path, text: &str) -> String {
    let message = match read(folder, text) {
        Err(error) => error.to_string(),
        Ok(scene) => match Model::from_scene(&scene) {
            Err(error) => error.to_string(),
            Ok(_) => panic!("accepted:\n{text}"),
        },
    };
    message.replace(&format!("{}/", folder.display()), "")
}

const ONE: &str = "[[robot]]\nurdf = \"double.urdf\"\n";

/// The robot with a joint of every kind, on two lines.
const LIMBED: &str = "[[robot]]\nurdf = \"limbs.urdf\"\n";

/// Two robots, on six lines.
const TWO: &str =
    "[[robot]]\nname = \"left\"\nurdf = \"pendulum.urdf\"\n[[robot]]\nname = \"right\"\nurdf = \"pendulum.urdf\"\n";
