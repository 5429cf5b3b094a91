//! The user's files, read and validated.
//!
//! ```text
//!     URDF  → text → XML → clean (schema.rs: known elements, good numbers) → Robot → tree checks
//!     scene → text → TOML → serde (scene_schema.rs: known keys, good numbers) → Scene of Robots, names resolved
//! ```
//!
//! Mesh files are read by [`crate::meshes`]: meshes of obstacles here, others when they are needed.
//!
//! | room | what is in it |
//! |---|---|
//! | here | what the files say: robots, couplings, settings of joints and contacts, the scene; text, numbers, errors, warnings |
//! | `urdf_reading` | from a URDF file to a [`Robot`] |
//! | `scene_reading` | from a scene file to a [`Scene`] |
//! | [`parameters`] | numbers of a scene by their key paths |
//!
//! This module is independent of simulation: a [`Robot`] is the URDF with every number finite, every reference resolved and every link on one tree.
//! Parts of the file that are not used are listed in [`Robot::warnings`].

mod body;
mod bounded;
pub mod contact_settings;
pub mod coupling;
mod description;
pub mod error;
mod input_reading;
pub mod joint_settings;
pub mod loads;
#[cfg(feature = "scene")]
mod mjcf_reading;
mod numbers;
pub mod parameters;
pub(crate) mod pattern;
pub mod robot;
mod scene_reading;
mod taken;
mod text;
mod urdf_reading;
mod warning;
pub(crate) mod world;

pub use body::{SceneBody, Weight};
pub use contact_settings::{
    ContactSettings, LinkShapes, MeshSource, Obstacle, PairRule, SceneLink, Touching, UnknownTouching,
};
pub use coupling::{
    JointReference, LinkReference, LoopEnd, Point, SceneCoupling, SceneLoop, SceneRope, SceneSpring, SpringPlace,
};
pub use description::{JointValues, STANDARD_GRAVITY, Scene, SceneRobot, SimulationSettings};
pub use error::{Element, Problem, SceneError};
pub use error::{listed, quoted};
pub use input_reading::input::{Format, read_input};
pub use joint_settings::{LimitChoice, SceneJoint, SceneMotion, SceneMotor, TableFile, TargetTable};
pub use loads::{Factor, LoadKind, SceneDrag, SceneLoad};
pub use parameters::{InertialNumber, Parameter};
pub use robot::{
    Dynamics, Geometry, Inertial, Limit, Link, LoopType, MeshFile, Mimic, Pose, Robot, Shape, Surface, UrdfJoint,
    UrdfJointKind, UrdfLoop, UrdfLoopEnd,
};
#[cfg(not(feature = "scene"))]
pub use scene_reading::no_scene_file::read_scene;
#[cfg(feature = "scene")]
pub use scene_reading::scene_file::simulation;
#[cfg(feature = "scene")]
pub use scene_reading::scene_file::{read_scene, scene_from_text};
pub use scene_reading::scene_files::{FilesOnDisk, SceneFiles};
pub use scene_reading::scene_numbers::{Quantity, Unit};
#[cfg(feature = "scene")]
pub use scene_reading::scene_schema::SimulationTable;
#[cfg(feature = "scene")]
pub use scene_reading::target_csv::rows_of_csv;
#[cfg(feature = "scene")]
pub use scene_reading::toml_text::TomlText;
#[cfg(feature = "scene")]
pub use taken::{Taken, TakenNumber};
pub use text::read_text;
pub use urdf_reading::package_path::PackagePath;
pub use urdf_reading::urdf::{read_urdf, robot_from_text, robot_without_meshes};
pub use warning::{Warning, WarningGroup, warning_lines};
pub use world::WORLD_LINK;
