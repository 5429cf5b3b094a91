//! The couplings and forces of a scene: loops, springs and loads, their names resolved.
//!
//! Units: m, rad, N, N m, s.

use crate::mechanism::description::course::Wave;
use crate::scene::joint_settings::TargetTable;
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

/// The place of a spring.
#[derive(Clone, Debug, PartialEq)]
pub enum SpringPlace {
    /// Between two points that are `rest_length` (m) apart when it is free of force.
    Points { a: Point, b: Point, rest_length: f64 },
    /// In a joint that is at `rest` (rad or m) when it is free of force.
    Joint { joint: JointReference, rest: f64 },
}

/// A `[[load]]`.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneLoad {
    /// The name of the loaded part, as written.
    pub on: String,
    /// Its kind.
    pub kind: LoadKind,
    /// Its factor over time.
    pub factor: Factor,
    /// When it begins and ends (s), if it does.
    pub from: Option<f64>,
    /// See `from`.
    pub until: Option<f64>,
    /// Its line.
    pub line: usize,
}

/// The part on which a load acts.
#[derive(Clone, Debug, PartialEq)]
pub enum LoadKind {
    /// An effort (N m or N) along the axis of a joint.
    Joint { joint: JointReference, effort: f64 },
    /// A force (N) at a point and a torque (N m), both with the directions of the world, or with those of the link if they turn with it.
    Link { point: Point, force: Vector3<f64>, torque: Vector3<f64>, turns: bool },
}

/// The factor of a load over time.
#[derive(Clone, Debug, PartialEq)]
pub enum Factor {
    /// It does not change.
    None,
    /// The same at all times.
    Number(f64),
    /// The values of a table.
    Table(TargetTable),
    /// A wave.
    Wave(Wave),
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

/// A `[[drag]]`.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneDrag {
    /// The name of the link, as written.
    pub on: String,
    /// The point at which its force acts.
    pub point: Point,
    /// Linear [N s/m], quadratic [N s²/m²], angular [N m s/rad] and angular quadratic [N m s²/rad²].
    pub numbers: [f64; 4],
    /// Its line.
    pub line: usize,
}
