//! The winch of a rope whose length changes in time: a slide that a motion moves, with the beginning of the rope on it.
//!
//! ```text
//!     P_w = P_0 + (L − l) e          |P_w − P_0| + Σ |P_{i+1} − P_i| ≤ L      so that      Σ |P_{i+1} − P_i| ≤ l(t)
//! ```
//!
//! P_0 is the first point of the rope, which is in the world, L the most of it (m), l the position of the slide, and e its direction. The slide has
//! 1e-12 kg, as an equation of motion needs some: its kinetic energy is a rounding. The work of the motion is the tension times l̇.

use crate::mechanism::description::target::Target;
use crate::scene::description::SceneRobot;
use crate::scene::error::{Element, SceneError};
use crate::scene::joint_settings::TargetTable;
use crate::scene::robot::Pose;
use crate::scene::urdf_reading::element::escaped;
use crate::scene::urdf_reading::urdf::robot_without_meshes;
use nalgebra::{Rotation3, Translation3, Vector3};
use std::path::Path;

/// The joint of a winch: its position is the length that is paid out.
pub(crate) const PAID_OUT: &str = "length";
/// Looks at a length that is a formula or a spline.
const LOOKS: usize = 2000;
/// The most of a rope, as a factor of the largest length that was seen.
const SPARE: f64 = 1.25;

/// A winch.
pub(crate) struct Winch {
    /// The name of its rope.
    pub name: String,
    /// P_0 (m).
    pub place: Vector3<f64>,
    /// L (m).
    pub longest: f64,
    /// The line of its rope.
    pub line: usize,
}

impl Winch {
    /// The link at which the rope begins.
    pub fn end(&self) -> String {
        format!("{}/end", self.name)
    }

    /// The robot that it is, in a scene file.
    ///
    /// # Errors
    /// [`SceneError`] for numbers that no URDF has.
    pub fn robot(self, path: &Path) -> Result<SceneRobot, SceneError> {
        let Winch { name, place, longest, line } = self;
        let text = format!(
            "<robot name=\"{}\"><link name=\"stand\"/><link name=\"end\"><inertial><mass value=\"1e-12\"/>\
             <inertia ixx=\"1e-18\" iyy=\"1e-18\" izz=\"1e-18\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>\
             <joint name=\"{PAID_OUT}\" type=\"prismatic\"><parent link=\"stand\"/><child link=\"end\"/><origin xyz=\"{longest} 0 0\"/>\
             <axis xyz=\"-1 0 0\"/><limit lower=\"0\" upper=\"{longest}\" effort=\"0\" velocity=\"0\"/></joint></robot>",
            escaped(&name)
        );
        let placed = |mut error: SceneError| {
            (error.line, error.element) = (Some(line), Some(Element::Rope(name.clone())));
            error
        };
        let mut robot = robot_without_meshes(&text, path).map_err(placed)?;
        robot.source.clear();
        robot.warnings.clear();
        robot.links.iter_mut().for_each(|link| link.line = line);
        for joint in &mut robot.joints {
            (joint.line, joint.limit) = (line, None);
        }
        Ok(SceneRobot {
            prefix: format!("{name}/"),
            name,
            body: None,
            copy: true,
            robot,
            floating: false,
            pose: Pose::from_parts(Translation3::from(place), Rotation3::identity()),
            rpy: [0.0; 3],
            velocity: None,
            positions: Vec::new(),
            velocities: Vec::new(),
            line,
        })
    }
}

/// A table as a cubic spline that begins and ends at rest, as for every joint that is moved; a formula as it is.
pub(crate) fn smooth(target: Target, table: Option<&TargetTable>) -> Target {
    // Times and values of a table have been checked.
    table.and_then(|table| Target::smooth(&table.points).ok()).unwrap_or(target)
}

/// The most of a rope with this length in time until an end (s), with some to spare (m).
pub(crate) fn most(length: &Target, end: f64) -> f64 {
    let at = |look: usize| length.motion(0.0, end * look as f64 / LOOKS as f64)[0];
    let seen = (0..=LOOKS).map(at).filter(|length| length.is_finite());
    SPARE * seen.fold(f64::MIN_POSITIVE, f64::max)
}
