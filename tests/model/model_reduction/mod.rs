//! The reduction keeps the physics: masses, centres, inertias and the pose of every link are those of the URDF.

mod coordinates;
mod links;
mod masses;

use crate::common::Numbers;
use catena::mechanism::description::joint::Pose;
use catena::model::{Base, Model, ModelOptions};
use catena::scene::{PackagePath, Robot, robot_from_text};
use std::path::Path;

fn read(text: &str) -> Robot {
    robot_from_text(text, Path::new("robot.urdf"), &PackagePath::default()).expect("a good URDF")
}

fn fixed(text: &str) -> Model {
    Model::new(read(text), &ModelOptions::default()).expect("a good model")
}

fn floating(text: &str, base_pose: Pose) -> Model {
    Model::new(read(text), &ModelOptions { base: Base::Floating, base_pose, ..Default::default() })
        .expect("a good model")
}

fn link(name: &str, mass: f64, center: &str, rpy: &str, moments: [f64; 3]) -> String {
    let [x, y, z] = moments;
    format!(
        r#"<link name="{name}"><inertial><origin xyz="{center}" rpy="{rpy}"/><mass value="{mass}"/><inertia ixx="{x}" ixy="0" ixz="0" iyy="{y}" iyz="0" izz="{z}"/></inertial></link>"#
    )
}

fn joint(name: &str, kind: &str, parent: &str, child: &str, xyz: &str, rpy: &str, axis: &str) -> String {
    format!(
        r#"<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/><origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="{axis}"/></joint>"#
    )
}

fn robot(parts: &[String]) -> String {
    format!("<robot name=\"r\">\n{}\n</robot>", parts.join("\n"))
}

/// A robot with every joint type, fixed joints between, skew frames and rotated inertias.
fn zoo() -> String {
    let kinds = ["revolute", "prismatic", "planar", "spherical", "floating", "continuous", "fixed"];
    let mut parts = vec![link("l0", 1.5, "0.1 0.2 -0.3", "0.1 0.2 0.3", [0.1, 0.2, 0.25])];
    for index in 1..22 {
        let s = index as f64;
        let name = format!("l{index}");
        let center = format!("{} {} {}", 0.1 * s.sin(), 0.1 * s.cos(), 0.05 * s);
        let rpy = format!("{} {} {}", s.sin(), (2.0 * s).cos(), 3.0 * (3.0 * s).sin());
        parts.push(link(&name, 0.3 + 0.1 * s, &center, &rpy, [0.02, 0.03 + 0.001 * s, 0.04]));
        let parent = format!("l{}", (index * 5) / 7);
        let axis = format!("{} {} {}", (5.0 * s).sin(), (7.0 * s).cos(), 0.4);
        let origin = format!("{} {} {}", 0.3 * (4.0 * s).sin(), 0.2, 0.1 * s);
        parts.push(joint(&format!("j{index}"), kinds[index % 7], &parent, &name, &origin, &rpy, &axis));
    }
    robot(&parts)
}

/// Random user coordinates for every moving joint.
fn random_positions(model: &Model, numbers: &mut Numbers) -> Vec<(String, Vec<f64>)> {
    let moving = model.joints.iter().filter_map(|joint| Some((joint, joint.body?)));
    moving
        .map(|(joint, body)| {
            // As many as there are degrees of freedom: roll, pitch, yaw for rotations.
            let count = model.mechanism.bodies[body].joint.kind.velocity_count();
            (joint.name.clone(), (0..count).map(|_| numbers.next(-1.5, 1.5)).collect())
        })
        .collect()
}
