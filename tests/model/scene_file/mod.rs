//! Claims about scene files: what they may say, what they may not, and where the command line has the last word.

mod built;
mod command_line;
mod errors;

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

/// A folder with the robots in it.
fn folder(name: &str) -> PathBuf {
    let folder = command::folder(name);
    for (file, text) in [("double.urdf", DOUBLE), ("ball.urdf", BALL)] {
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

/// Two robots, on six lines.
const TWO: &str =
    "[[robot]]\nname = \"left\"\nurdf = \"pendulum.urdf\"\n[[robot]]\nname = \"right\"\nurdf = \"pendulum.urdf\"\n";
