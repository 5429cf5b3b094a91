//! The couplings of a scene: loops, springs and relations of joints, their names resolved.
//!
//! Units: m, rad, N, N m, s.

use crate::scene::robot::LoopType;
use nalgebra::Vector3;

/// A link of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinkReference {
    /// The world.
    World,
    /// A link of a robot, both by index.
    Link { robot: usize, link: usize },
}

/// A joint of a robot of the scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JointReference {
    /// The robot, by index.
    pub robot: usize,
    /// The name of the joint in it.
    pub joint: String,
}

/// A point fixed in a link.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// The link.
    pub link: LinkReference,
    /// Its name, as written.
    pub name: String,
    /// The point in the link frame (m).
    pub position: Vector3<f64>,
}

/// One end of a joint that closes a loop.
#[derive(Clone, Debug, PartialEq)]
pub struct LoopEnd {
    /// Its origin.
    pub point: Point,
    /// The unit axis in the link frame, if given.
    pub axis: Option<Vector3<f64>>,
    /// The axis as given, of any length but zero.
    pub given_axis: Option<Vector3<f64>>,
}

/// A `[[loop]]`.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneLoop {
    /// Name, unique among the loops of the file.
    pub name: String,
    /// Its kind, which says which motions are free.
    pub kind: LoopType,
    /// The distance to keep (m), if given.
    pub length: Option<f64>,
    /// The first end.
    pub a: LoopEnd,
    /// The second end.
    pub b: LoopEnd,
    /// Its line.
    pub line: usize,
}

/// A `[[spring]]`.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneSpring {
    /// Name.
    pub name: String,
    /// N/m, or N m/rad in a joint that turns.
    pub stiffness: f64,
    /// N s/m, or N m s/rad.
    pub damping: f64,
    /// Between what.
    pub place: SpringPlace,
    /// Its line.
    pub line: usize,
}

/// A `[[rope]]`: it runs from its first point to its last through those between, and is no longer than its length.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneRope {
    /// Name, unique among the ropes of the file.
    pub name: String,
    /// Its points in their order, two or more: its ends, and the eyelets between.
    pub points: Vec<Point>,
    /// m; the most of it, if a winch pays it out.
    pub length: f64,
    /// The joint whose position is the length that is paid out, if that changes in time. The rope then begins at its end, behind its first point.
    pub winch: Option<JointReference>,
    /// Neighbours on different bodies stay this far apart at least (m), if the rope goes through several points; zero without a stop.
    pub stop: f64,
    /// e of the blow with which it goes taut, 0 to 1, and of those at its stops.
    pub restitution: f64,
    /// Its line.
    pub line: usize,
}

/// The place of a spring.
#[derive(Clone, Debug, PartialEq)]
pub enum SpringPlace {
    /// Between two points that are `rest_length` (m) apart when it is free of force.
    Points { a: Point, b: Point, rest_length: f64 },
    /// In a joint that is at `rest` (rad or m) when it is free of force.
    Joint { joint: JointReference, rest: f64 },
}

/// A `[[coupling]]`: `Σ coefficient · position = offset` over joints.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneCoupling {
    /// Name.
    pub name: String,
    /// Two joints or more, with their coefficients.
    pub terms: Vec<(JointReference, f64)>,
    /// rad or m, times the unit of the coefficients.
    pub offset: f64,
    /// Its line.
    pub line: usize,
}
