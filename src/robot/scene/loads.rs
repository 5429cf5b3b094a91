//! The loads and the drag of a scene, their names resolved.
//!
//! Units: m, rad, N, N m, s.

use crate::mechanism::description::course::Wave;
use crate::mechanism::description::formula::Formula;
use crate::scene::coupling::{JointReference, Point};
use crate::scene::joint_settings::TargetTable;
use nalgebra::Vector3;

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
    /// A formula of time.
    Formula(Formula),
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
