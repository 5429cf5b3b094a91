//! The contact settings of a scene: obstacles, which shapes may touch, and how.
//!
//! Units: m. Coefficients of friction μ ≥ 0 and of restitution e in 0..1 are pure numbers.

use crate::mechanism::description::contact::Shape;
use crate::scene::coupling::LinkReference;
use crate::scene::numbers::turn;
use crate::scene::robot::{Pose, Surface};
use nalgebra::{Rotation3, Translation3, Vector3};
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::Arc;

/// Static geometry: an `[[obstacle]]`, or the floor of `--floor`.
#[derive(Clone, Debug, PartialEq)]
pub struct Obstacle {
    /// Name, unique among the obstacles.
    pub name: String,
    /// Its shape.
    pub shape: Shape,
    /// The frame of the shape in the world.
    pub pose: Pose,
    /// Roll, pitch and yaw as they were given (rad), to which the turn of the shape's normal comes.
    pub rpy: [f64; 3],
    /// The rotation that takes z to the normal of a half space; the identity for all other shapes.
    pub turn: Rotation3<f64>,
    /// The normal of a half space in the frame of the obstacle as given, of any length but zero; of no use for other shapes.
    pub normal: Vector3<f64>,
    /// μ with everything, if given.
    pub friction: Option<f64>,
    /// e with everything, if given.
    pub restitution: Option<f64>,
    /// Lengths of rolling and of spinning friction with everything, if given (m).
    pub moments: [Option<f64>; 2],
    /// Velocity of its surface, as of a belt, in the axes of the obstacle as given [m/s].
    pub surface_velocity: Vector3<f64>,
    /// The mesh that it was read from.
    pub mesh: Option<MeshSource>,
    /// Scale of that mesh along x, y, z.
    pub scale: Vector3<f64>,
    /// Its line; `None` for the floor of the command line.
    pub line: Option<usize>,
}

/// A mesh file that was read.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshSource {
    /// Its key: for a link `robotN: ` and the name that its URDF gives the mesh, with the number N of the robot from 1.
    pub name: String,
    /// The path of its file.
    pub path: PathBuf,
    /// Its bytes.
    pub bytes: Arc<Vec<u8>>,
}

/// Which shapes may touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Touching {
    /// No pair.
    None,
    /// Links and obstacles.
    Environment,
    /// Links and obstacles, and the links of different robots.
    All,
}

/// There is no such choice.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0:?} is not one of: none, environment, all")]
pub struct UnknownTouching(pub String);

impl Touching {
    /// The name, for files and the command line.
    pub fn name(self) -> &'static str {
        match self {
            Touching::None => "none",
            Touching::Environment => "environment",
            Touching::All => "all",
        }
    }
}

impl FromStr for Touching {
    type Err = UnknownTouching;

    fn from_str(name: &str) -> Result<Self, UnknownTouching> {
        let all = [Touching::None, Touching::Environment, Touching::All];
        all.into_iter().find(|one| one.name() == name).ok_or_else(|| UnknownTouching(name.to_string()))
    }
}

/// A `[[contact.pair]]`; a value of `None` leaves the value of the pair as it is.
#[derive(Clone, Debug, PartialEq)]
pub struct PairRule {
    /// A name, in which `*` stands for any text.
    pub a: String,
    /// The other.
    pub b: String,
    /// μ.
    pub friction: Option<f64>,
    /// e.
    pub restitution: Option<f64>,
    /// Lengths of rolling and of spinning friction (m).
    pub moments: [Option<f64>; 2],
    /// Whether they never touch.
    pub ignore: Option<bool>,
    /// Its line.
    pub line: usize,
}

/// The shapes that stand for the collision meshes of a link.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LinkShapes {
    /// The convex hull of each.
    #[default]
    Hull,
    /// Convex pieces of each of their connected parts.
    Decompose,
    /// The shape, or every shape of the link, has no contacts.
    None,
}

/// A `[[link]]`.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneLink {
    /// The link.
    pub link: LinkReference,
    /// Its name, as written.
    pub name: String,
    /// The place of one collision shape among the shapes of the link from 1, as in key paths; `None` for all.
    pub shape: Option<usize>,
    /// What its collision meshes are taken for, if it says so.
    pub shapes: Option<LinkShapes>,
    /// Its settings of the surface of the whole link, or of that shape, instead of the URDF's.
    pub surface: Surface,
    /// The line of its `name`.
    pub line: usize,
}

/// All that a scene says of contact.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactSettings {
    /// Which shapes may touch, if that is said; see [`ContactSettings::touching`].
    pub touching: Option<Touching>,
    /// Whether links of one robot touch each other; `None`: wherever shapes touch anything else.
    pub self_contact: Option<bool>,
    /// The default of μ.
    pub friction: f64,
    /// The default of e.
    pub restitution: f64,
    /// The defaults of the lengths of rolling and of spinning friction (m).
    pub moments: [f64; 2],
    /// Whether the larger of two coefficients that are said holds, as in MuJoCo.
    pub larger: bool,
    /// In the order of the file; later ones override earlier ones.
    pub rules: Vec<PairRule>,
    /// The obstacles.
    pub obstacles: Vec<Obstacle>,
    /// The settings of links.
    pub links: Vec<SceneLink>,
}

impl Default for ContactSettings {
    fn default() -> Self {
        ContactSettings {
            touching: None,
            self_contact: None,
            friction: 0.5,
            restitution: 0.0,
            moments: [0.0; 2],
            larger: false,
            rules: Vec::new(),
            obstacles: Vec::new(),
            links: Vec::new(),
        }
    }
}

impl ContactSettings {
    /// Which shapes may touch: what is said, or everything in a scene with an obstacle.
    pub fn touching(&self) -> Touching {
        let everything = if self.obstacles.is_empty() { Touching::Environment } else { Touching::All };
        self.touching.unwrap_or(everything)
    }

    /// Whether shapes of one robot touch what is not of that robot, in a scene with this number of robots.
    pub fn touches_others(&self, robots: usize) -> bool {
        match self.touching() {
            Touching::None => false,
            Touching::Environment => !self.obstacles.is_empty(),
            Touching::All => !self.obstacles.is_empty() || robots > 1,
        }
    }

    /// Whether links of one robot touch each other, in a scene with this number of robots.
    pub fn touches_itself(&self, robots: usize) -> bool {
        self.touching() != Touching::None && self.self_contact.unwrap_or(self.touches_others(robots))
    }

    /// The choice for a collision shape of a link, by its place among the shapes of the link from 1: its own setting, else the setting of the link.
    pub fn choice(&self, link: LinkReference, number: usize) -> LinkShapes {
        let of = |shape| self.links.iter().find(|said| said.link == link && said.shape == shape);
        let said = |shape| of(shape).and_then(|said| said.shapes);
        said(Some(number)).or_else(|| said(None)).unwrap_or_default()
    }
}

impl Obstacle {
    /// The name of [`Obstacle::floor`].
    pub const FLOOR: &'static str = "floor";

    /// The velocity of its surface in the world [m/s].
    pub fn surface_velocity_in_world(&self) -> Vector3<f64> {
        turn(self.rpy) * self.surface_velocity
    }

    /// All points of the world with z ≤ `height` (m).
    pub fn floor(height: f64) -> Self {
        Obstacle {
            name: Obstacle::FLOOR.to_string(),
            shape: Shape::HalfSpace,
            pose: Pose::from_parts(Translation3::new(0.0, 0.0, height), Rotation3::identity()),
            rpy: [0.0; 3],
            turn: Rotation3::identity(),
            normal: Vector3::z(),
            friction: None,
            restitution: None,
            moments: [None; 2],
            surface_velocity: Vector3::zeros(),
            mesh: None,
            scale: Vector3::repeat(1.0),
            line: None,
        }
    }
}
