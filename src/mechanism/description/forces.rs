//! Smooth forces besides gravity: springs, dampers and loads. A mechanism without forces has empty lists alone.
//!
//! The data is here, the physics of each force in a file of its own: `joint_damper`, `joint_spring`,
//! `joint_load`, `point_spring`, `wrench`, `link_load`, `drag`, `gravity_compensation`. `total` sums them up for a state; the scheme has its own
//! evaluation for all stages at once (`lobatto::equations::forces`).

use crate::description::closure::{Attachment, Coordinate};
use crate::description::course::Course;
use nalgebra::Vector3;

/// Every force on a mechanism besides gravity.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Forces {
    /// Viscous dampers in joints.
    pub joint_dampers: Vec<JointDamper>,
    /// Linear springs in joints.
    pub joint_springs: Vec<JointSpring>,
    /// Constant efforts in joints.
    pub joint_loads: Vec<JointLoad>,
    /// Springs with dampers between two points.
    pub point_springs: Vec<PointSpring>,
    /// Constant wrenches on bodies.
    pub wrenches: Vec<Wrench>,
    /// Efforts in joints that change in time.
    pub joint_courses: Vec<JointCourse>,
    /// Loads on bodies that change in time or turn with their body.
    pub link_loads: Vec<LinkLoad>,
    /// Drag of bodies.
    pub drags: Vec<Drag>,
    /// Efforts in joints against the weight of the bodies beyond them.
    pub gravity_compensations: Vec<GravityCompensation>,
    /// Whether efforts are handed to every step ([`crate::motion::inputs::Inputs`]): simplifications that hold under gravity alone are then not
    /// allowed.
    pub driven: bool,
}

/// `τ = −coefficient · q̇` along one degree of freedom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointDamper {
    /// Entry of the velocity vector.
    pub freedom: usize,
    /// N m s/rad or N s/m, not negative.
    pub coefficient: f64,
}

/// `τ = −stiffness · (q − rest)` along one scalar joint coordinate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointSpring {
    /// The coordinate.
    pub coordinate: Coordinate,
    /// N m/rad or N/m.
    pub stiffness: f64,
    /// The coordinate at which it is free of force (rad or m).
    pub rest: f64,
}

/// A constant effort along one degree of freedom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLoad {
    /// Entry of the velocity vector.
    pub freedom: usize,
    /// N m or N.
    pub effort: f64,
}

/// A spring and damper between the origins of two frames, `u = (P_b − P_a)/ℓ`: the force on b is
/// `−(stiffness (ℓ − rest_length) + damping ℓ̇) u`, on a its opposite.
#[derive(Clone, Debug, PartialEq)]
pub struct PointSpring {
    /// Its name.
    pub name: String,
    /// One end.
    pub a: Attachment,
    /// The other end.
    pub b: Attachment,
    /// N/m.
    pub stiffness: f64,
    /// N s/m.
    pub damping: f64,
    /// m.
    pub rest_length: f64,
}

/// A constant wrench on a body, with the directions of the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wrench {
    /// The body.
    pub body: usize,
    /// The point of action of the force, in the body frame (m).
    pub point: Vector3<f64>,
    /// The force, in the world (N).
    pub force: Vector3<f64>,
    /// The torque, in the world (N m).
    pub torque: Vector3<f64>,
}

/// An effort along a scalar coordinate that changes in time.
#[derive(Clone, Debug, PartialEq)]
pub struct JointCourse {
    /// Entry of the velocity vector.
    pub freedom: usize,
    /// N m or N.
    pub effort: f64,
    /// Its factor over time.
    pub course: Course,
}

/// A force and a torque on a body that change in time or turn with it.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkLoad {
    /// The body.
    pub body: usize,
    /// The point of action of the force, in the body frame (m).
    pub point: Vector3<f64>,
    /// The force, in the world or in the body frame (N).
    pub force: Vector3<f64>,
    /// The torque, in the same axes (N m).
    pub torque: Vector3<f64>,
    /// Whether both have the axes of the body.
    pub turns: bool,
    /// Their factor over time.
    pub course: Course,
}

/// Drag of a body: `−(linear + quadratic |v|) v` at a point, and a torque `−(angular_linear + angular_quadratic |ω|) ω`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drag {
    /// The body.
    pub body: usize,
    /// The point in the body frame (m).
    pub point: Vector3<f64>,
    /// N s/m.
    pub linear: f64,
    /// N s²/m².
    pub quadratic: f64,
    /// N m s/rad.
    pub angular_linear: f64,
    /// N m s²/rad².
    pub angular_quadratic: f64,
}

/// The effort along a joint of one freedom that holds a part of the weight of all bodies beyond it, in every pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GravityCompensation {
    /// Entry of the velocity vector.
    pub freedom: usize,
    /// Part of the weight; one holds all of it.
    pub factor: f64,
}

impl Forces {
    /// The next instant after `time` at which a force jumps or has a kink (s).
    pub fn next_instant(&self, time: f64) -> f64 {
        self.courses().map(|course| course.next_instant(time)).fold(f64::INFINITY, f64::min)
    }

    /// The longest step from a time on, of `step` seconds at most, over which stages resolve all of them; the run goes on to `until` (s).
    pub fn resolved_step(&self, time: f64, step: f64, until: f64) -> f64 {
        self.courses().fold(step, |step, course| course.resolved_step(time, step, until))
    }

    /// Whether a force changes in time.
    pub fn change(&self) -> bool {
        self.courses().any(|course| !course.is_constant())
    }

    fn courses(&self) -> impl Iterator<Item = &Course> {
        let in_joints = self.joint_courses.iter().map(|load| &load.course);
        in_joints.chain(self.link_loads.iter().map(|load| &load.course))
    }

    /// Whether the same forces act, whoever drives them.
    #[inline]
    pub fn are_those_of(&self, other: &Forces) -> bool {
        let Forces { joint_dampers, joint_springs, joint_loads, point_springs, wrenches, .. } = self;
        let Forces { joint_courses, link_loads, drags, gravity_compensations, .. } = self;
        *joint_dampers == other.joint_dampers
            && *joint_springs == other.joint_springs
            && *joint_loads == other.joint_loads
            && *point_springs == other.point_springs
            && *wrenches == other.wrenches
            && *joint_courses == other.joint_courses
            && *link_loads == other.link_loads
            && *drags == other.drags
            && *gravity_compensations == other.gravity_compensations
    }

    /// Whether there are no forces.
    #[inline]
    pub fn is_empty(&self) -> bool {
        let Forces { joint_dampers, joint_springs, joint_loads, point_springs, wrenches, driven, .. } = self;
        let Forces { joint_courses, link_loads, drags, gravity_compensations, .. } = self;
        joint_dampers.is_empty()
            && joint_springs.is_empty()
            && joint_loads.is_empty()
            && point_springs.is_empty()
            && wrenches.is_empty()
            && joint_courses.is_empty()
            && link_loads.is_empty()
            && drags.is_empty()
            && gravity_compensations.is_empty()
            && !driven
    }
}
