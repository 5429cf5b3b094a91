//! A robot as its URDF describes it: links, joints and shapes.
//!
//! Units: m, rad, kg, kg m², N m. A [`Pose`] `X` places a child frame in its parent: `p_parent = X p_child`.

use crate::scene::bounded::read_bounded;
use crate::scene::taken::Taken;
use crate::scene::warning::Warning;
use crate::scene::world::WORLD_LINK;

use nalgebra::{IsometryMatrix3, Matrix3, Vector3};
use std::io;
use std::path::PathBuf;
use std::sync::Arc;

/// A rigid placement: rotation matrix and translation (m).
pub type Pose = IsometryMatrix3<f64>;

/// A URDF, validated: the links and joints form one tree and every number is finite.
#[derive(Clone, Debug)]
pub struct Robot {
    /// Name from the `<robot>` element.
    pub name: String,
    /// The links, in the order of the file.
    pub links: Vec<Link>,
    /// The joints, in the order of the file.
    pub joints: Vec<UrdfJoint>,
    /// The joints that close loops (`<loop_joint>`), in the order of the file.
    pub loops: Vec<UrdfLoop>,
    /// The link at the root of the tree; `None` when the root is a world that only joints mention.
    pub root: Option<usize>,
    /// The file it came from.
    pub path: PathBuf,
    /// The text of the file, as written.
    pub source: String,
    /// The repaired URDF with the mesh files made absolute (`file://`), for viewers.
    pub description: String,
    /// Repairs, parts that were left out, and parts that will not be simulated.
    pub warnings: Vec<Warning>,
    /// Numbers from parts that other programs write, of which the warnings say that they are taken.
    pub taken: Vec<Taken>,
}

impl Robot {
    /// The index of the link with this name.
    pub fn link(&self, name: &str) -> Option<usize> {
        self.links.iter().position(|link| link.name == name)
    }

    /// Whether the root of the tree is the fixed world: a link named `world`, or one that only joints mention.
    pub fn root_is_world(&self) -> bool {
        self.root.is_none_or(|root| self.links[root].name == WORLD_LINK)
    }
}

/// A link: a frame, perhaps with mass and shapes.
#[derive(Clone, Debug)]
pub struct Link {
    /// Name, unique among the links.
    pub name: String,
    /// Mass and inertia, if given.
    pub inertial: Option<Inertial>,
    /// Shapes that viewers show.
    pub visuals: Vec<Shape>,
    /// Shapes that touch.
    pub collisions: Vec<Shape>,
    /// Coefficients of contact of its collision shapes, where a file says them; a shape may have its own.
    pub surface: Surface,
    /// Line of the `<link>` element.
    pub line: usize,
}

/// The surface of a link or of one of its shapes, as far as a file says it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Surface {
    /// Coulomb's coefficient of friction μ ≥ 0.
    pub friction: Option<f64>,
    /// Restitution of impacts, 0 to 1.
    pub restitution: Option<f64>,
    /// Lengths of rolling and of spinning friction (m).
    pub moments: [Option<f64>; 2],
    /// Velocity of the surface over the link, as of a belt, in the axes of the link [m/s].
    pub velocity: Option<Vector3<f64>>,
}

impl Surface {
    /// It, and where it says no value the value of another one.
    pub fn or(self, other: &Surface) -> Surface {
        Surface {
            friction: self.friction.or(other.friction),
            restitution: self.restitution.or(other.restitution),
            moments: [0, 1].map(|of: usize| self.moments[of].or(other.moments[of])),
            velocity: self.velocity.or(other.velocity),
        }
    }

    /// Whether it has the friction and the restitution of another one.
    pub fn touches_like(&self, other: &Surface) -> bool {
        (self.friction, self.restitution, self.moments) == (other.friction, other.restitution, other.moments)
    }
}

/// Mass and inertia of a link.
#[derive(Clone, Debug)]
pub struct Inertial {
    /// The inertial frame in the link frame: its origin is the centre of mass.
    pub origin: Pose,
    /// Roll, pitch and yaw of that frame, as given (rad); for a quaternion, the angles of its rotation.
    pub rpy: [f64; 3],
    /// Mass (kg), not negative.
    pub mass: f64,
    /// Inertia about the centre of mass, in the axes of the inertial frame [kg m²].
    pub inertia: Matrix3<f64>,
    /// Line of the `<inertial>` element.
    pub line: usize,
}

/// A visual or collision shape.
#[derive(Clone, Debug)]
pub struct Shape {
    /// Name, if given.
    pub name: Option<String>,
    /// The shape's frame in the link frame.
    pub origin: Pose,
    /// Roll, pitch and yaw of that frame, as given (rad); for a quaternion, the angles of its rotation.
    pub rpy: [f64; 3],
    /// Its geometry.
    pub geometry: Geometry,
    /// Colour (red, green, blue, opacity in 0..1) from the material, if given.
    pub color: Option<[f64; 4]>,
    /// Coefficients of contact of this shape alone, instead of its link's.
    pub surface: Surface,
    /// Line of the `<visual>` or `<collision>` element.
    pub line: usize,
}

/// The geometry of a shape; cylinders and capsules lie along z.
#[derive(Clone, Debug, PartialEq)]
pub enum Geometry {
    /// A box with these edge lengths (m).
    Box { size: Vector3<f64> },
    /// A cylinder (m).
    Cylinder { radius: f64, length: f64 },
    /// A sphere (m).
    Sphere { radius: f64 },
    /// A capsule whose cylindrical part has this length (m).
    Capsule { radius: f64, length: f64 },
    /// An ellipsoid with these semi-axes along x, y and z (m).
    Ellipsoid { radii: Vector3<f64> },
    /// A mesh from a file.
    Mesh(MeshFile),
}

/// A reference to a mesh file.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshFile {
    /// As written in the URDF.
    pub path: String,
    /// The existing file it stands for, if one was found.
    pub resolved: Option<PathBuf>,
    /// Scale along x, y, z.
    pub scale: Vector3<f64>,
    /// Its bytes, where a log carries them.
    pub carried: Option<Arc<Vec<u8>>>,
}

impl MeshFile {
    /// Its path and its bytes; `None` if there is no such file.
    ///
    /// # Errors
    /// Errors of the file system, for a file that is there, and for one that is too large.
    pub fn read(&self) -> Option<io::Result<(PathBuf, Arc<Vec<u8>>)>> {
        if let Some(bytes) = &self.carried {
            return Some(Ok((PathBuf::from(&self.path), bytes.clone())));
        }
        let path = self.resolved.as_ref()?;
        Some(read_bounded(path).map(|bytes| (path.clone(), Arc::new(bytes))))
    }
}

/// The joint types of URDF.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UrdfJointKind {
    /// One limited rotation about the axis.
    Revolute,
    /// One unlimited rotation about the axis.
    Continuous,
    /// One translation along the axis.
    Prismatic,
    /// No relative motion.
    Fixed,
    /// Every relative motion.
    Floating,
    /// Translations across the axis and the rotation about it.
    Planar,
    /// Every rotation.
    Spherical,
}

impl UrdfJointKind {
    /// The name in a URDF.
    pub fn name(self) -> &'static str {
        match self {
            UrdfJointKind::Revolute => "revolute",
            UrdfJointKind::Continuous => "continuous",
            UrdfJointKind::Prismatic => "prismatic",
            UrdfJointKind::Fixed => "fixed",
            UrdfJointKind::Floating => "floating",
            UrdfJointKind::Planar => "planar",
            UrdfJointKind::Spherical => "spherical",
        }
    }

    /// Whether number `index` of a position or velocity of the joint, as users give it, is an angle or its rate.
    pub fn is_angle(self, index: usize) -> bool {
        match self {
            UrdfJointKind::Revolute | UrdfJointKind::Continuous | UrdfJointKind::Spherical => true,
            UrdfJointKind::Prismatic | UrdfJointKind::Fixed => false,
            UrdfJointKind::Planar => index == 2,
            UrdfJointKind::Floating => index >= 3,
        }
    }

    /// Whether the axis of the joint means something.
    pub fn has_axis(self) -> bool {
        !matches!(self, UrdfJointKind::Fixed | UrdfJointKind::Floating | UrdfJointKind::Spherical)
    }
}

/// A joint of the URDF.
#[derive(Clone, Debug)]
pub struct UrdfJoint {
    /// Name, unique among the joints.
    pub name: String,
    /// Type.
    pub kind: UrdfJointKind,
    /// Name of the parent link; [`WORLD_LINK`] need not be declared.
    pub parent: String,
    /// Name of the child link.
    pub child: String,
    /// The joint frame, which is the child's link frame at zero displacement, in the parent's link frame.
    pub origin: Pose,
    /// Roll, pitch and yaw of that frame, as given (rad); for a quaternion, the angles of its rotation.
    pub rpy: [f64; 3],
    /// Unit axis in the joint frame.
    pub axis: Vector3<f64>,
    /// The axis as given, of any length but zero.
    pub given_axis: Vector3<f64>,
    /// Limits, if given.
    pub limit: Option<Limit>,
    /// Damping and friction, if given.
    pub dynamics: Option<Dynamics>,
    /// Inertia of the rotor that is geared to it, about its own coordinate [kg m² or kg], if the file says one.
    pub armature: Option<f64>,
    /// The joint this one should follow, if any.
    pub mimic: Option<Mimic>,
    /// Line of the `<joint>` element.
    pub line: usize,
}

impl UrdfJoint {
    /// Whether a motor can drive it for itself: it turns about or slides along an axis, and follows no other joint.
    pub fn can_be_driven(&self) -> bool {
        use UrdfJointKind::{Continuous, Prismatic, Revolute};
        self.mimic.is_none() && matches!(self.kind, Revolute | Continuous | Prismatic)
    }

    /// The limits [rad or m] between which the URDF keeps a joint of one freedom, if it has them; limits of a continuous joint are not read.
    pub fn own_limits(&self) -> Option<(f64, f64)> {
        self.limit.filter(|_| self.kind != UrdfJointKind::Continuous).and_then(|limit| limit.range())
    }
}

/// A `<loop_joint>`: a joint between two links of the tree. Standard URDF has no such element; RigidBodyDynamics.jl, Dojo and Isaac Sim write loops
/// in this way.
#[derive(Clone, Debug)]
pub struct UrdfLoop {
    /// Name, unique among the loops.
    pub name: String,
    /// Type.
    pub kind: LoopType,
    /// Unit axis in the frames of both ends.
    pub axis: Vector3<f64>,
    /// The axis as given, of any length but zero.
    pub given_axis: Vector3<f64>,
    /// The end of `<link1>`.
    pub a: UrdfLoopEnd,
    /// The end of `<link2>`.
    pub b: UrdfLoopEnd,
    /// Line of the `<loop_joint>` element.
    pub line: usize,
}

impl UrdfLoop {
    /// The end of `<link2>`, or the end of `<link1>`.
    pub(crate) fn end_mut(&mut self, b: bool) -> &mut UrdfLoopEnd {
        if b { &mut self.b } else { &mut self.a }
    }
}

/// One end of a `<loop_joint>`.
#[derive(Clone, Debug)]
pub struct UrdfLoopEnd {
    /// The link, by index; `None` is the undeclared world.
    pub link: Option<usize>,
    /// The joint frame in it.
    pub origin: Pose,
    /// Roll, pitch and yaw of that frame, as given (rad).
    pub rpy: [f64; 3],
}

/// The motions that a joint that closes a loop leaves free.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LoopType {
    /// Rotation about the axis.
    Revolute,
    /// Translation along the axis.
    Prismatic,
    /// Rotation about the axis and translation along it.
    Cylindrical,
    /// Rotations about the axes of both ends, which stay perpendicular.
    Universal,
    /// Every rotation.
    Spherical,
    /// Translations across the axis and rotation about it.
    Planar,
    /// No motion is free.
    Fixed,
    /// Everything but the distance of two points.
    Distance,
}

impl LoopType {
    /// Whether the axes of the ends mean something, and must be given.
    pub fn needs_axes(self) -> bool {
        !matches!(self, LoopType::Spherical | LoopType::Fixed | LoopType::Distance)
    }
}

/// Joint limits; `None` where the file has no value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// Smallest position [rad or m].
    pub lower: Option<f64>,
    /// Largest position [rad or m].
    pub upper: Option<f64>,
    /// Largest effort [N m or N].
    pub effort: Option<f64>,
    /// Largest speed [rad/s or m/s].
    pub velocity: Option<f64>,
}

impl Limit {
    /// The positions between which it keeps a joint [rad or m], if it says so; equal ones lock it. Both at zero, or neither given,
    /// is what writers of URDFs leave where they know of no limit.
    pub fn range(&self) -> Option<(f64, f64)> {
        let (lower, upper) = (self.lower.unwrap_or(f64::NEG_INFINITY), self.upper.unwrap_or(f64::INFINITY));
        let says = lower < upper || (lower == upper && lower != 0.0);
        (says && (lower.is_finite() || upper.is_finite())).then_some((lower, upper))
    }
}

/// Joint damping and friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dynamics {
    /// Viscous damping [N m s/rad or N s/m].
    pub damping: f64,
    /// Dry friction [N m or N].
    pub friction: f64,
}

/// This joint's position should be `multiplier · (position of joint) + offset`.
#[derive(Clone, Debug, PartialEq)]
pub struct Mimic {
    /// The joint to follow.
    pub joint: String,
    /// Factor.
    pub multiplier: f64,
    /// Offset [rad or m].
    pub offset: f64,
}
