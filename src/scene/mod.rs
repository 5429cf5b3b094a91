//! What the user wrote, validated.
//!
//! ```text
//!     file → text → XML → clean (schema.rs: known elements, good numbers) → urdf-rs → Robot → tree checks
//! ```
//!
//! Nothing here knows about simulation: a [`Robot`] is the URDF with every number finite, every reference resolved
//! and every link on one tree. What the file says and nobody will use is listed in [`Robot::warnings`].

mod clean;
mod convert;
mod element;
mod error;
mod mesh_files;
mod numbers;
pub mod package_path;
mod robot;
mod schema;
mod text;
mod tree;
mod unsimulated;
mod urdf;

pub(crate) use error::quoted;
pub use error::{Element, Problem, SceneError, Warning};
pub use package_path::PackagePath;
pub use robot::{
    Dynamics, Geometry, Inertial, Limit, Link, MeshFile, Mimic, Pose, Robot, Shape, UrdfJoint, UrdfJointKind,
    WORLD_LINK,
};
pub use urdf::{read_urdf, robot_from_text};
