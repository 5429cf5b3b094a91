//! Links and joints of a [`Robot`], from the elements of a valid URDF.

use crate::scene::error::{Element, Problem, SceneError};
use crate::scene::numbers::{normalised, turn, unit, unrounded};
use crate::scene::robot::{
    Dynamics, Geometry, Inertial, Limit, Link, LoopType, MeshFile, Mimic, Pose, Shape, Surface, UrdfJoint,
    UrdfJointKind, UrdfLoop, UrdfLoopEnd,
};
use crate::scene::urdf_reading::clean::error_at;
use crate::scene::urdf_reading::element::CleanElement;
use crate::scene::urdf_reading::inertia::impossible_inertia;
use crate::scene::urdf_reading::mesh_files::MeshFiles;
use crate::scene::warning::{Warning, WarningGroup};
use crate::scene::world::WORLD_LINK;
use nalgebra::{Matrix3, Quaternion, Translation3, UnitQuaternion, Vector3, Vector4};
use std::path::Path;

/// The common data of all conversions.
pub(crate) struct Converter<'c> {
    pub file: &'c Path,
    pub meshes: &'c MeshFiles,
    pub robot: &'c CleanElement,
    /// Whether the file's version (1.1 and later) knows `quat_xyzw`.
    pub quaternions: bool,
    pub warnings: Vec<Warning>,
    /// Warnings of inertias that no body has.
    pub impossible_inertias: Vec<Warning>,
}

impl Converter<'_> {
    /// A link.
    pub fn link(&mut self, element: &CleanElement) -> Result<Link, SceneError> {
        let name = element.text("name");
        let owner = Element::Link(name.clone());
        let inertial = match element.child("inertial") {
            None => None,
            Some(inertial) => Some(self.inertial(inertial, &owner)?),
        };
        let visuals = self.shapes(element, "visual", &owner)?;
        let collisions = self.shapes(element, "collision", &owner)?;
        Ok(Link { name, inertial, visuals, collisions, surface: Surface::default(), line: element.line })
    }

    /// The shapes of a link; collision shapes have no colour.
    fn shapes(&mut self, link: &CleanElement, kind: &str, owner: &Element) -> Result<Vec<Shape>, SceneError> {
        let mut shapes = Vec::new();
        for element in link.children_named(kind) {
            let Some(geometry) = element.child("geometry").and_then(|geometry| self.geometry(geometry)) else {
                continue;
            };
            let name = element.attribute("name").map(str::to_string);
            let color = element.child("material").and_then(|material| self.color(material));
            let (origin, rpy) = self.origin(element, owner)?;
            let surface = Surface::default();
            shapes.push(Shape { name, origin, rpy, geometry, color, surface, line: element.line });
        }
        Ok(shapes)
    }

    /// A joint.
    pub fn joint(&mut self, element: &CleanElement) -> Result<UrdfJoint, SceneError> {
        let name = element.text("name");
        let owner = Element::Joint(name.clone());
        let kind = self.joint_kind(element, &owner)?;
        // URDF's default.
        let given_axis = element.child("axis").and_then(|axis| axis.vector("xyz")).map_or(Vector3::x(), Vector3::from);
        let axis = self.axis(&given_axis, kind, element, &owner)?;
        let limit = element.child("limit").map(|limit| {
            let given = |name| limit.number(name).filter(|_| limit.gives(name));
            let [lower, upper, effort, velocity] = ["lower", "upper", "effort", "velocity"].map(given);
            Limit { lower, upper, effort, velocity }
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
        let dynamics = element.child("dynamics").map(|dynamics| {
            let [damping, friction] = ["damping", "friction"].map(|name| dynamics.number(name).unwrap_or(0.0));
            Dynamics { damping, friction }
        });
        if let Some(Dynamics { friction, .. }) = dynamics
            && friction < 0.0
        {
            let problem = Problem::NegativeFriction(friction);
            return Err(error_at(self.file, line_of("dynamics"), Some(owner), problem));
        }
        let armature = element.child("dynamics").and_then(|dynamics| dynamics.number("armature"));
        if let Some(armature) = armature.filter(|armature| *armature < 0.0) {
            let problem = Problem::NegativeArmature(armature);
            return Err(error_at(self.file, line_of("dynamics"), Some(owner), problem));
        }
        let (origin, rpy) = self.origin(element, &owner)?;
        let [parent, child] =
            ["parent", "child"].map(|role| element.child(role).map_or(String::new(), |link| link.text("link")));
        let mimic = element.child("mimic").map(|mimic| Mimic {
            joint: mimic.text("joint"),
            multiplier: mimic.number("multiplier").unwrap_or(1.0),
            offset: mimic.number("offset").unwrap_or(0.0),
        });
        Ok(UrdfJoint {
            name,
            kind,
            parent,
            child,
            origin,
            rpy,
            axis,
            given_axis,
            limit,
            dynamics,
            armature,
            mimic,
            line: element.line,
        })
    }

    fn joint_kind(&self, element: &CleanElement, owner: &Element) -> Result<UrdfJointKind, SceneError> {
        Ok(match element.attribute("type").unwrap_or_default() {
            "revolute" => UrdfJointKind::Revolute,
            "continuous" => UrdfJointKind::Continuous,
            "prismatic" => UrdfJointKind::Prismatic,
            "fixed" => UrdfJointKind::Fixed,
            "floating" => UrdfJointKind::Floating,
            "planar" => UrdfJointKind::Planar,
            "spherical" => UrdfJointKind::Spherical,
            other => {
                let problem = Problem::JointType(other.to_string());
                return Err(error_at(self.file, element.line, Some(owner.clone()), problem));
            }
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
        let (xyz, rpy) = (numbers("xyz"), numbers("rpy").map(unrounded));
        Ok(UrdfLoopEnd { link, origin: Pose::from_parts(Translation3::from(xyz), turn(rpy)), rpy })
    }

    /// The axis, of length one.
    fn axis(
        &mut self,
        given: &Vector3<f64>,
        kind: UrdfJointKind,
        element: &CleanElement,
        owner: &Element,
    ) -> Result<Vector3<f64>, SceneError> {
        if !kind.has_axis() {
            return Ok(unit(given).map_or(Vector3::x(), |(axis, _)| axis));
        }
        let line = element.child("axis").map_or(element.line, |axis| axis.line);
        self.unit_axis(given, line, owner)
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

    fn inertial(&mut self, element: &CleanElement, owner: &Element) -> Result<Inertial, SceneError> {
        let of = |child: &str, name: &str| element.child(child).and_then(|child| child.number(name)).unwrap_or(0.0);
        let mass = of("mass", "value");
        if mass < 0.0 {
            let line = element.child("mass").map_or(element.line, |mass| mass.line);
            return Err(error_at(self.file, line, Some(owner.clone()), Problem::NegativeMass(mass)));
        }
        let [xx, xy, xz, yy, yz, zz] = ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"].map(|moment| of("inertia", moment));
        let inertia = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        self.check_inertia(mass, &inertia, element, owner);
        let (origin, rpy) = self.origin(element, owner)?;
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
    fn origin(&mut self, parent: &CleanElement, owner: &Element) -> Result<(Pose, [f64; 3]), SceneError> {
        let Some(origin) = parent.child("origin") else { return Ok((Pose::identity(), [0.0; 3])) };
        let [xyz, rpy] = ["xyz", "rpy"].map(|name| origin.vector(name).unwrap_or_default());
        let (translation, rpy) = (Translation3::from(xyz), rpy.map(unrounded));
        let by_angles = (Pose::from_parts(translation, turn(rpy)), rpy);
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
        // The rotation itself: by way of roll, pitch and yaw up to 4 mrad are lost near a pitch of 90°.
        match normalised(&Vector4::from_column_slice(&q)) {
            Some(xyzw) => {
                let rotation = UnitQuaternion::new_unchecked(Quaternion::from(xyzw)).to_rotation_matrix();
                let (roll, pitch, yaw) = rotation.euler_angles();
                Ok((Pose::from_parts(translation, rotation), [roll, pitch, yaw]))
            }
            None => refuse("the quaternion is zero"),
        }
    }

    fn geometry(&self, geometry: &CleanElement) -> Option<Geometry> {
        let form = geometry.children.first()?;
        let number = |name| form.number(name);
        Some(match form.name {
            "box" => Geometry::Box { size: form.vector("size")?.into() },
            "cylinder" => Geometry::Cylinder { radius: number("radius")?, length: number("length")? },
            "sphere" => Geometry::Sphere { radius: number("radius")? },
            "capsule" => Geometry::Capsule { radius: number("radius")?, length: number("length")? },
            "ellipsoid" => Geometry::Ellipsoid { radii: form.vector("radii")?.into() },
            _ => Geometry::Mesh(MeshFile {
                path: form.text("filename"),
                resolved: self.meshes.get(form.attribute("filename")?).cloned(),
                scale: form.vector("scale").map_or(Vector3::repeat(1.0), Vector3::from),
                carried: self.meshes.carried(form.attribute("filename")?).cloned(),
            }),
        })
    }

    /// The colour of a material, or of the robot's material of that name.
    fn color(&self, material: &CleanElement) -> Option<[f64; 4]> {
        let name = material.attribute("name");
        let named = || self.robot.children_named("material").find(|known| known.attribute("name") == name);
        let color = material.child("color").or_else(|| named()?.child("color"))?;
        color.numbers("rgba")?.try_into().ok()
    }

    fn warn(&mut self, line: usize, element: &Element, message: String) {
        self.warnings.push(self.warning(line, element, message));
    }

    fn warning(&self, line: usize, element: &Element, message: String) -> Warning {
        Warning::odd(self.file, Some(line), Some(element.clone()), message)
    }
}
