//! From what `urdf-rs` parsed, and the lines it came from, to a [`Robot`]'s links and joints.

use crate::scene::clean::error_at;
use crate::scene::element::CleanElement;
use crate::scene::error::{Element, Problem, SceneError};
use crate::scene::inertia::impossible_inertia;
use crate::scene::mesh_files::MeshFiles;
use crate::scene::numbers::{normalised, turn, unit};
use crate::scene::robot::{
    Dynamics, Geometry, Inertial, Limit, Link, LoopType, MeshFile, Mimic, Pose, Shape, UrdfJoint, UrdfJointKind,
    UrdfLoop, UrdfLoopEnd,
};
use crate::scene::schema::WORLD_LINK;
use crate::scene::warning::{Warning, WarningGroup};
use nalgebra::{Matrix3, Quaternion, Translation3, UnitQuaternion, Vector3, Vector4};
use std::path::Path;

/// What all conversions need.
pub(crate) struct Converter<'c> {
    pub file: &'c Path,
    pub meshes: &'c MeshFiles,
    pub materials: &'c [urdf_rs::Material],
    /// Whether the file's version (1.1 and later) knows `quat_xyzw`.
    pub quaternions: bool,
    pub warnings: Vec<Warning>,
    /// Of inertias that no body has.
    pub impossible_inertias: Vec<Warning>,
}

impl Converter<'_> {
    /// A link.
    pub fn link(&mut self, link: &urdf_rs::Link, element: &CleanElement) -> Result<Link, SceneError> {
        let owner = Element::Link(link.name.clone());
        let inertial = match element.child("inertial") {
            None => None,
            Some(inertial) => Some(self.inertial(&link.inertial, inertial, &owner)?),
        };
        let mut visuals = Vec::new();
        for (visual, element) in link.visual.iter().zip(element.children_named("visual")) {
            let color = visual.material.as_ref().and_then(|material| self.color(material));
            let (origin, rpy) = self.origin(&visual.origin, element, &owner)?;
            let geometry = self.geometry(&visual.geometry);
            visuals.push(Shape { name: visual.name.clone(), origin, rpy, geometry, color, line: element.line });
        }
        let mut collisions = Vec::new();
        for (collision, element) in link.collision.iter().zip(element.children_named("collision")) {
            let (origin, rpy) = self.origin(&collision.origin, element, &owner)?;
            let (name, geometry) = (collision.name.clone(), self.geometry(&collision.geometry));
            collisions.push(Shape { name, origin, rpy, geometry, color: None, line: element.line });
        }
        Ok(Link { name: link.name.clone(), inertial, visuals, collisions, line: element.line })
    }

    /// A joint.
    pub fn joint(&mut self, joint: &urdf_rs::Joint, element: &CleanElement) -> Result<UrdfJoint, SceneError> {
        let owner = Element::Joint(joint.name.clone());
        let kind = joint_kind(&joint.joint_type);
        let axis = self.axis(joint, kind, element, &owner)?;
        let limit = element.child("limit").map(|limit| Limit {
            lower: limit.gives("lower").then_some(joint.limit.lower),
            upper: limit.gives("upper").then_some(joint.limit.upper),
            effort: limit.gives("effort").then_some(joint.limit.effort),
            velocity: limit.gives("velocity").then_some(joint.limit.velocity),
        });
        if limit.is_none() && matches!(kind, UrdfJointKind::Revolute | UrdfJointKind::Prismatic) {
            self.warn(element.line, &owner, format!("a {} joint should have a <limit>; none is assumed", kind.name()));
        }
        let line_of = |child: &str| element.child(child).map_or(element.line, |child| child.line);
        if let Some(Limit { lower: Some(lower), upper: Some(upper), .. }) = limit
            && lower > upper
            && matches!(kind, UrdfJointKind::Revolute | UrdfJointKind::Prismatic)
        {
            let problem = Problem::ReversedLimits { lower, upper };
            return Err(error_at(self.file, line_of("limit"), Some(owner), problem));
        }
        if let Some(friction) = joint.dynamics.as_ref().map(|dynamics| dynamics.friction)
            && friction < 0.0
        {
            let problem = Problem::NegativeFriction(friction);
            return Err(error_at(self.file, line_of("dynamics"), Some(owner), problem));
        }
        let (origin, rpy) = self.origin(&joint.origin, element, &owner)?;
        Ok(UrdfJoint {
            name: joint.name.clone(),
            kind,
            parent: joint.parent.link.clone(),
            child: joint.child.link.clone(),
            origin,
            rpy,
            axis,
            given_axis: Vector3::from(joint.axis.xyz.0),
            limit,
            dynamics: joint.dynamics.as_ref().map(|d| Dynamics { damping: d.damping, friction: d.friction }),
            mimic: joint.mimic.as_ref().map(|mimic| Mimic {
                joint: mimic.joint.clone(),
                multiplier: mimic.multiplier.unwrap_or(1.0),
                offset: mimic.offset.unwrap_or(0.0),
            }),
            line: element.line,
        })
    }

    /// A joint that closes a loop, among the links of the robot.
    pub fn closing_joint(&mut self, element: &CleanElement, links: &[Link]) -> Result<UrdfLoop, SceneError> {
        let name = element.attribute("name").unwrap_or_default().to_string();
        let owner = Element::Loop(name.clone());
        let kind = match element.attribute("type").unwrap_or_default() {
            "revolute" | "continuous" => LoopType::Revolute,
            "prismatic" => LoopType::Prismatic,
            "cylindrical" => LoopType::Cylindrical,
            "universal" => LoopType::Universal,
            "spherical" | "ball" => LoopType::Spherical,
            "planar" => LoopType::Planar,
            "fixed" => LoopType::Fixed,
            other => {
                let problem = Problem::LoopType(other.to_string());
                return Err(error_at(self.file, element.line, Some(owner), problem));
            }
        };
        let (axis, given_axis) = match element.child("axis").and_then(|axis| Some((axis.line, axis.numbers("xyz")?))) {
            Some((line, numbers)) if kind.needs_axes() => {
                let given = Vector3::from_column_slice(&numbers);
                (self.unit_axis(&given, line, &owner)?, given)
            }
            _ => (Vector3::x(), Vector3::x()),
        };
        let damping = element.child("dynamics").and_then(|dynamics| dynamics.numbers("damping"));
        if damping.is_some_and(|damping| damping[0] != 0.0) {
            let message = "the damping of a joint that closes a loop is not simulated".to_string();
            let warning = self.warning(element.line, &owner, message);
            self.warnings.push(warning.in_group(WarningGroup::NotSimulated));
        }
        let a = self.closing_end(element, "link1", links, &owner)?;
        let b = self.closing_end(element, "link2", links, &owner)?;
        Ok(UrdfLoop { name, kind, axis, given_axis, a, b, line: element.line })
    }

    /// The link of one end of a loop, and the frame in it.
    fn closing_end(
        &self,
        element: &CleanElement,
        role: &'static str,
        links: &[Link],
        owner: &Element,
    ) -> Result<UrdfLoopEnd, SceneError> {
        // The schema requires both.
        let end = element.child(role).unwrap_or(element);
        let name = end.attribute("link").unwrap_or_default();
        let link = links.iter().position(|link| link.name == name);
        if link.is_none() && name != WORLD_LINK {
            let problem = Problem::UnknownLink { role, name: name.to_string() };
            return Err(error_at(self.file, end.line, Some(owner.clone()), problem));
        }
        let numbers = |attribute| {
            let given = end.numbers(attribute);
            given.map_or([0.0; 3], |given| [given[0], given[1], given[2]])
        };
        let (xyz, rpy) = (numbers("xyz"), numbers("rpy"));
        Ok(UrdfLoopEnd { link, origin: Pose::from_parts(Translation3::from(xyz), turn(rpy)), rpy })
    }

    /// The axis, of length one.
    fn axis(
        &mut self,
        joint: &urdf_rs::Joint,
        kind: UrdfJointKind,
        element: &CleanElement,
        owner: &Element,
    ) -> Result<Vector3<f64>, SceneError> {
        let given = Vector3::from(joint.axis.xyz.0);
        if !kind.has_axis() {
            return Ok(unit(&given).map_or(Vector3::x(), |(axis, _)| axis));
        }
        let line = element.child("axis").map_or(element.line, |axis| axis.line);
        self.unit_axis(&given, line, owner)
    }

    /// An axis that means something, of length one.
    fn unit_axis(&mut self, given: &Vector3<f64>, line: usize, owner: &Element) -> Result<Vector3<f64>, SceneError> {
        let (axis, warning) =
            unit(given).ok_or_else(|| error_at(self.file, line, Some(owner.clone()), Problem::ZeroAxis))?;
        if let Some(warning) = warning {
            self.warn(line, owner, warning);
        }
        Ok(axis)
    }

    fn inertial(
        &mut self,
        inertial: &urdf_rs::Inertial,
        element: &CleanElement,
        owner: &Element,
    ) -> Result<Inertial, SceneError> {
        let mass = inertial.mass.value;
        if mass < 0.0 {
            let line = element.child("mass").map_or(element.line, |mass| mass.line);
            return Err(error_at(self.file, line, Some(owner.clone()), Problem::NegativeMass(mass)));
        }
        let i = &inertial.inertia;
        let inertia = Matrix3::new(i.ixx, i.ixy, i.ixz, i.ixy, i.iyy, i.iyz, i.ixz, i.iyz, i.izz);
        self.check_inertia(mass, &inertia, element, owner);
        let (origin, rpy) = self.origin(&inertial.origin, element, owner)?;
        Ok(Inertial { origin, rpy, mass, inertia, line: element.line })
    }

    /// Warns of an inertia that no rigid body has, and of one without mass.
    fn check_inertia(&mut self, mass: f64, inertia: &Matrix3<f64>, element: &CleanElement, owner: &Element) {
        let line = element.child("inertia").map_or(element.line, |inertia| inertia.line);
        match impossible_inertia(self.file, line, owner, mass, inertia) {
            Some(warning) => self.impossible_inertias.push(warning),
            None if mass == 0.0 && inertia.symmetric_eigenvalues().max() != 0.0 => {
                self.warn(element.line, owner, "has inertia but no mass".to_string());
            }
            None => {}
        }
    }

    /// The `<origin>` of an element, and its roll, pitch and yaw (rad); without one, the identity.
    fn origin(
        &mut self,
        pose: &urdf_rs::Pose,
        parent: &CleanElement,
        owner: &Element,
    ) -> Result<(Pose, [f64; 3]), SceneError> {
        let translation = Translation3::from(pose.xyz.0);
        let by_angles = (Pose::from_parts(translation, turn(pose.rpy.0)), pose.rpy.0);
        let Some(origin) = parent.child("origin") else { return Ok(by_angles) };
        let Some(q) = origin.numbers("quat_xyzw") else { return Ok(by_angles) };
        if !self.quaternions {
            self.warn(origin.line, owner, "quat_xyzw is ignored: it needs <robot version=\"1.1\">".to_string());
            return Ok(by_angles);
        }
        let refuse = |reason: &str| {
            let problem = Problem::Number {
                element: "origin".to_string(),
                attribute: "quat_xyzw".to_string(),
                text: origin.attribute("quat_xyzw").unwrap_or_default().to_string(),
                reason: reason.to_string(),
            };
            Err(error_at(self.file, origin.line, Some(owner.clone()), problem))
        };
        if origin.gives("rpy") {
            return refuse("rpy is given too");
        }
        // urdf-rs would turn it into roll, pitch, yaw, which loses up to 4 mrad near a pitch of 90°.
        match normalised(&Vector4::from_column_slice(&q)) {
            Some(xyzw) => {
                let rotation = UnitQuaternion::new_unchecked(Quaternion::from(xyzw)).to_rotation_matrix();
                let (roll, pitch, yaw) = rotation.euler_angles();
                Ok((Pose::from_parts(translation, rotation), [roll, pitch, yaw]))
            }
            None => refuse("the quaternion is zero"),
        }
    }

    fn geometry(&self, geometry: &urdf_rs::Geometry) -> Geometry {
        match geometry {
            urdf_rs::Geometry::Box { size } => Geometry::Box { size: Vector3::from(size.0) },
            urdf_rs::Geometry::Cylinder { radius, length } => Geometry::Cylinder { radius: *radius, length: *length },
            urdf_rs::Geometry::Sphere { radius } => Geometry::Sphere { radius: *radius },
            urdf_rs::Geometry::Capsule { radius, length } => Geometry::Capsule { radius: *radius, length: *length },
            urdf_rs::Geometry::Mesh { filename, scale } => Geometry::Mesh(MeshFile {
                path: filename.clone(),
                resolved: self.meshes.get(filename).cloned(),
                scale: scale.map_or(Vector3::repeat(1.0), |scale| Vector3::from(scale.0)),
                carried: None,
            }),
        }
    }

    /// The colour of a material, or of the robot's material of that name.
    fn color(&self, material: &urdf_rs::Material) -> Option<[f64; 4]> {
        let own = material.color.as_ref();
        let named = || self.materials.iter().find(|known| known.name == material.name)?.color.as_ref();
        own.or_else(named).map(|color| color.rgba.0)
    }

    fn warn(&mut self, line: usize, element: &Element, message: String) {
        self.warnings.push(self.warning(line, element, message));
    }

    fn warning(&self, line: usize, element: &Element, message: String) -> Warning {
        Warning::odd(self.file, Some(line), Some(element.clone()), message)
    }
}

fn joint_kind(kind: &urdf_rs::JointType) -> UrdfJointKind {
    match kind {
        urdf_rs::JointType::Revolute => UrdfJointKind::Revolute,
        urdf_rs::JointType::Continuous => UrdfJointKind::Continuous,
        urdf_rs::JointType::Prismatic => UrdfJointKind::Prismatic,
        urdf_rs::JointType::Fixed => UrdfJointKind::Fixed,
        urdf_rs::JointType::Floating => UrdfJointKind::Floating,
        urdf_rs::JointType::Planar => UrdfJointKind::Planar,
        urdf_rs::JointType::Spherical => UrdfJointKind::Spherical,
    }
}
