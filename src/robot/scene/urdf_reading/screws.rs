//! Screws: `<joint type="screw">` with a `<thread_pitch value="...">` (m a turn, positive for a right-handed thread).
//!
//! Standard URDF has no screws; SDF and Drake do. One is written as a hinge and a slide on the same axis, with a link without mass between them:
//!
//! ```text
//!     NAME: continuous or revolute, parent → NAME_nut,     NAME_slide: prismatic, NAME_nut → child,     slide = pitch / 2π · turn
//! ```
//!
//! The limits, dynamics and mimic of the joint are those of the hinge.

use crate::scene::error::{Element, Problem, SceneError};
use crate::scene::urdf_reading::clean::error_at;
use crate::scene::urdf_reading::element::{CleanAttribute, CleanElement};
use std::f64::consts::TAU;
use std::path::Path;

/// Writes all screws of a robot as hinges and slides.
pub(crate) fn expand_screws(file: &Path, robot: &mut CleanElement) -> Result<(), SceneError> {
    let is_screw = |element: &CleanElement| element.name == "joint" && element.attribute("type") == Some("screw");
    if !robot.children.iter().any(is_screw) {
        return Ok(());
    }
    let taken: Vec<String> = robot.children.iter().map(|element| element.text("name")).collect();
    let free = |name: String| {
        std::iter::successors(Some(name), |name| Some(format!("{name}_"))).find(|name| !taken.contains(name))
    };
    let mut children = Vec::with_capacity(robot.children.len());
    for mut joint in std::mem::take(&mut robot.children) {
        if !is_screw(&joint) {
            children.push(joint);
            continue;
        }
        let name = joint.text("name");
        let pitch = joint.child("thread_pitch").and_then(|pitch| pitch.number("value")).filter(|pitch| *pitch != 0.0);
        let Some(pitch) = pitch else {
            return Err(error_at(file, joint.line, Some(Element::Joint(name)), Problem::ScrewPitch));
        };
        joint.children.retain(|child| child.name != "thread_pitch");
        let has_range = joint.child("limit").is_some_and(|limit| limit.gives("lower") || limit.gives("upper"));
        joint.set("type", if has_range { "revolute" } else { "continuous" }.to_string());
        let line = joint.line;
        let [nut, slide] = ["nut", "slide"].map(|part| free(format!("{name}_{part}")).unwrap_or_default());
        let child = joint.child("child").map_or(String::new(), |child| child.text("link"));
        if let Some(own) = joint.child_mut("child") {
            own.set("link", nut.clone());
        }
        let mut parts = vec![element("parent", line, &[("link", &nut)]), element("child", line, &[("link", &child)])];
        parts.extend(joint.child("axis").map(|axis| element("axis", line, &[("xyz", &axis.text("xyz"))])));
        let free = [("lower", "-inf"), ("upper", "inf"), ("effort", "inf"), ("velocity", "inf")];
        parts.push(element("limit", line, &free));
        parts.push(element("mimic", line, &[("joint", &name), ("multiplier", &(pitch / TAU).to_string())]));
        let mut sliding = element("joint", line, &[("name", &slide), ("type", "prismatic")]);
        sliding.children = parts;
        children.extend([element("link", line, &[("name", &nut)]), joint, sliding]);
    }
    robot.children = children;
    Ok(())
}

/// An element with these attributes.
fn element(name: &'static str, line: usize, attributes: &[(&'static str, &str)]) -> CleanElement {
    let attribute = |&(name, text): &(&'static str, &str)| CleanAttribute { name, text: text.to_string(), given: true };
    CleanElement { name, line, attributes: attributes.iter().map(attribute).collect(), children: Vec::new() }
}
