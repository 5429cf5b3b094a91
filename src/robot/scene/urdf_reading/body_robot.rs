//! The robot of one link that a body of a scene file is, by way of its URDF.

use crate::scene::body::SceneBody;
use crate::scene::error::{Element, SceneError};
use crate::scene::robot::{Geometry, Robot};
use crate::scene::urdf_reading::element::escaped;
use crate::scene::urdf_reading::urdf::robot_without_meshes;
use std::fmt::Write;
use std::path::Path;

impl SceneBody {
    /// The robot that it is; `path` and `line` belong to its table.
    ///
    /// # Errors
    /// [`SceneError`] for numbers that no URDF has: a mass or moment that is infinite.
    pub fn robot(&self, name: &str, path: &Path, line: usize) -> Result<Robot, SceneError> {
        let text = self.urdf(name);
        let placed = |mut error: SceneError| {
            (error.line, error.element) = (Some(line), Some(Element::Body(name.to_string())));
            error
        };
        let mut robot = robot_without_meshes(&text, path).map_err(placed)?;
        robot.source.clear();
        for link in &mut robot.links {
            (link.line, link.surface) = (line, self.surface);
            link.inertial.iter_mut().for_each(|inertial| inertial.line = line);
            link.visuals.iter_mut().chain(&mut link.collisions).for_each(|shape| shape.line = line);
        }
        for warning in &mut robot.warnings {
            (warning.line, warning.element) = (Some(line), Some(Element::Body(name.to_string())));
        }
        Ok(robot)
    }

    /// The URDF of the robot that it is. Numbers are written with all their digits.
    pub fn urdf(&self, name: &str) -> String {
        let name = escaped(name);
        let form = match &self.shape {
            Geometry::Sphere { radius } => format!("<sphere radius=\"{radius}\"/>"),
            Geometry::Box { size } => format!("<box size=\"{} {} {}\"/>", size.x, size.y, size.z),
            Geometry::Cylinder { radius, length } => format!("<cylinder radius=\"{radius}\" length=\"{length}\"/>"),
            Geometry::Capsule { radius, length } => format!("<capsule radius=\"{radius}\" length=\"{length}\"/>"),
            Geometry::Ellipsoid { radii } => format!("<ellipsoid radii=\"{} {} {}\"/>", radii.x, radii.y, radii.z),
            Geometry::Mesh(mesh) => format!("<mesh filename=\"{}\"/>", escaped(&mesh.path)),
        };
        let material = self.color.map_or(String::new(), |[red, green, blue, opacity]| {
            format!("<material name=\"{name}\"><color rgba=\"{red} {green} {blue} {opacity}\"/></material>")
        });
        let (mass, moments) = (self.mass(), self.moments());
        let mut text = format!("<robot name=\"{name}\"><link name=\"{name}\">");
        // Writing into a String cannot fail.
        let _ = write!(
            text,
            "<inertial><mass value=\"{mass}\"/><inertia ixx=\"{}\" iyy=\"{}\" izz=\"{}\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>",
            moments.x, moments.y, moments.z
        );
        let _ = write!(text, "<visual><geometry>{form}</geometry>{material}</visual>");
        let _ = write!(text, "<collision><geometry>{form}</geometry></collision></link></robot>");
        text
    }
}
