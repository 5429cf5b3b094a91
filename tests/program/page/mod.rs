//! Pages: `catena report`, `catena model -o`, `catena simulate --report`.

pub mod browser;
mod contacts;
mod files;
mod numbers;

use crate::common::command::{folder, run, text};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// The pendulum of other tests with a red rod and a limit, which it runs into.
pub const RED: &str = r#"<robot name="red">
  <link name="base"/>
  <joint name="hinge" type="revolute"><parent link="base"/><child link="rod"/><axis xyz="0 1 0"/>
    <limit lower="-0.5" upper="1.2" effort="10" velocity="10"/></joint>
  <link name="rod">
    <inertial><origin xyz="0 0 -0.5"/><mass value="1"/>
      <inertia ixx="0.1" iyy="0.1" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><origin xyz="0 0 -0.5"/><geometry><box size="0.2 0.2 1"/></geometry>
      <material name="red"><color rgba="0.9 0.05 0.05 1"/></material></visual>
  </link>
</robot>"#;

/// A folder with that pendulum, and a log of 2 s that begins at rest in the position 1 rad.
fn with_log(name: &str) -> PathBuf {
    let folder = folder(name);
    std::fs::write(folder.join("red.urdf"), RED).expect("written");
    done(&folder, &["simulate", "red.urdf", "--duration", "2", "--position", "hinge=1", "--quiet"]);
    folder
}

/// Runs catena, which must succeed; what it prints.
fn done(folder: &Path, arguments: &[&str]) -> String {
    let output = run(folder, arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", text(&output.stderr));
    text(&output.stdout).to_string()
}

/// What is between two texts in a page.
fn between<'p>(page: &'p str, start: &str, end: &str) -> &'p str {
    let (_, rest) = page.split_once(start).expect(start);
    rest.split_once(end).expect(end).0
}

/// The header of a page.
fn header(page: &str) -> Value {
    let json = between(page, r#"<script type="application/json" id="header">"#, "</script>");
    serde_json::from_str(json).expect("JSON")
}
