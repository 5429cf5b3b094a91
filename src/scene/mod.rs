//! The user's files, read and validated.
//!
//! ```text
//!     URDF  → text → XML → clean (schema.rs: known elements, good numbers) → Robot → tree checks
//!     scene → text → TOML → serde (scene_schema.rs: known keys, good numbers) → Scene of Robots, names resolved
//! ```
//!
//! Mesh files are read by [`crate::meshes`]: those of obstacles here, others when they are needed.
//!
//! Nothing here knows about simulation: a [`Robot`] is the URDF with every number finite, every reference resolved
//! and every link on one tree. Parts of the file that are not used are listed in [`Robot::warnings`].

mod bounded;
mod clean;
#[cfg(feature = "scene")]
mod contact_reader;
#[cfg(feature = "scene")]
mod contact_schema;
pub mod contact_settings;
mod convert;
pub mod coupling;
#[cfg(feature = "scene")]
mod coupling_reader;
mod description;
mod element;
pub mod error;
mod inertia;
#[cfg(feature = "scene")]
mod joint_reader;
#[cfg(feature = "scene")]
mod joint_schema;
pub mod joint_settings;
mod mesh_files;
#[cfg(not(feature = "scene"))]
mod no_scene_file;
mod numbers;
pub mod package_path;
pub mod parameters;
pub mod robot;
#[cfg(feature = "scene")]
mod scene_file;
mod scene_files;
#[cfg_attr(
    not(feature = "scene"),
    expect(dead_code, reason = "key paths ask only whether a number may be one of these")
)]
mod scene_numbers;
#[cfg(feature = "scene")]
mod scene_schema;
pub mod schema;
#[cfg(feature = "scene")]
mod target_csv;
#[cfg(feature = "scene")]
mod target_reader;
mod text;
#[cfg(feature = "scene")]
mod toml_text;
mod tree;
mod unsimulated;
mod urdf;
mod warning;

pub use contact_settings::{
    ContactSettings, LinkShapes, MeshSource, Obstacle, PairRule, SceneLink, Touching, UnknownTouching,
};
pub use coupling::{
    JointReference, LinkReference, LoadKind, LoopEnd, Point, SceneLoad, SceneLoop, SceneSpring, SpringPlace,
};
pub use description::{JointValues, STANDARD_GRAVITY, Scene, SceneRobot, SimulationSettings};
pub(crate) use error::quoted;
pub use error::{Element, Problem, SceneError};
pub use joint_settings::{LimitChoice, SceneJoint, SceneMotor, TableFile, TargetTable};
#[cfg(not(feature = "scene"))]
pub use no_scene_file::read_scene;
pub use package_path::PackagePath;
pub use parameters::Parameter;
pub use robot::{
    Dynamics, Geometry, Inertial, Limit, Link, LoopType, MeshFile, Mimic, Pose, Robot, Shape, UrdfJoint, UrdfJointKind,
    UrdfLoop, UrdfLoopEnd,
};
#[cfg(feature = "scene")]
pub(crate) use scene_file::simulation;
#[cfg(feature = "scene")]
pub use scene_file::{read_scene, scene_from_text};
pub use scene_files::{FilesOnDisk, SceneFiles};
#[cfg(feature = "scene")]
pub(crate) use scene_schema::SimulationTable;
pub use schema::WORLD_LINK;
#[cfg(feature = "scene")]
pub(crate) use text::read_text;
#[cfg(feature = "scene")]
pub(crate) use toml_text::TomlText;
pub use urdf::{read_urdf, robot_from_text, robot_without_meshes};
pub use warning::{Warning, WarningGroup, warning_lines};
