//! What the user wrote, validated.
//!
//! ```text
//!     URDF  → text → XML → clean (schema.rs: known elements, good numbers) → urdf-rs → Robot → tree checks
//!     scene → text → TOML → serde (scene_schema.rs: known keys, good numbers) → Scene of Robots, names resolved
//! ```
//!
//! Mesh files are read by [`crate::meshes`]: those of obstacles here, others when somebody needs them.
//!
//! Nothing here knows about simulation: a [`Robot`] is the URDF with every number finite, every reference resolved
//! and every link on one tree. What the file says and nobody will use is listed in [`Robot::warnings`].

mod bounded;
mod clean;
mod contact_reader;
mod contact_schema;
pub mod contact_settings;
mod convert;
pub mod coupling;
mod coupling_reader;
mod description;
mod element;
pub mod error;
mod inertia;
mod joint_reader;
mod joint_schema;
pub mod joint_settings;
mod mesh_files;
mod numbers;
pub mod package_path;
pub mod parameters;
pub mod robot;
mod scene_file;
mod scene_files;
mod scene_numbers;
mod scene_schema;
pub mod schema;
mod target_csv;
mod target_reader;
mod text;
mod toml_text;
mod tree;
mod unsimulated;
mod urdf;

pub use contact_settings::{
    ContactSettings, LinkShapes, MeshSource, Obstacle, PairRule, SceneLink, Touching, UnknownTouching,
};
pub use coupling::{
    JointReference, LinkReference, LoadKind, LoopEnd, Point, SceneLoad, SceneLoop, SceneSpring, SpringPlace,
};
pub use description::{JointValues, STANDARD_GRAVITY, Scene, SceneRobot, SimulationSettings};
pub(crate) use error::quoted;
pub use error::{Element, Problem, SceneError, Warning};
pub use joint_settings::{LimitChoice, SceneJoint, SceneMotor, TableFile};
pub use package_path::PackagePath;
pub use parameters::Parameter;
pub use robot::{
    Dynamics, Geometry, Inertial, Limit, Link, LoopType, MeshFile, Mimic, Pose, Robot, Shape, UrdfJoint, UrdfJointKind,
    UrdfLoop,
};
pub(crate) use scene_file::simulation;
pub use scene_file::{read_scene, scene_from_text};
pub use scene_files::{FilesOnDisk, SceneFiles};
pub(crate) use scene_schema::SimulationTable;
pub use schema::WORLD_LINK;
pub(crate) use text::read_text;
pub(crate) use toml_text::TomlText;
pub use urdf::{read_urdf, robot_from_text, robot_without_meshes};
