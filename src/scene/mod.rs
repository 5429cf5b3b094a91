//! What the user wrote, validated.
//!
//! ```text
//!     URDF  → text → XML → clean (schema.rs: known elements, good numbers) → urdf-rs → Robot → tree checks
//!     scene → text → TOML → serde (scene_schema.rs: known keys, good numbers) → Scene of Robots, names resolved
//! ```
//!
//! Nothing here knows about simulation: a [`Robot`] is the URDF with every number finite, every reference resolved
//! and every link on one tree. What the file says and nobody will use is listed in [`Robot::warnings`].

mod clean;
mod convert;
mod coupling;
mod coupling_reader;
mod element;
mod error;
mod mesh_files;
mod numbers;
pub mod package_path;
mod robot;
mod scene_file;
mod scene_schema;
mod schema;
mod text;
mod toml_text;
mod tree;
mod unsimulated;
mod urdf;

pub use coupling::{
    JointReference, LinkReference, LoadKind, LoopEnd, Point, SceneLoad, SceneLoop, SceneSpring, SpringPlace,
};
pub(crate) use error::quoted;
pub use error::{Element, Problem, SceneError, Warning};
pub use package_path::PackagePath;
pub use robot::{
    Dynamics, Geometry, Inertial, Limit, Link, LoopType, MeshFile, Mimic, Pose, Robot, Shape, UrdfJoint, UrdfJointKind,
    UrdfLoop, WORLD_LINK,
};
pub use scene_file::{JointValues, Scene, SceneRobot, SimulationSettings, read_scene, scene_from_text};
pub use urdf::{read_urdf, robot_from_text, robot_without_meshes};
