//! MJCF, the format of MuJoCo, as the scene file and the URDFs that say the same.
//!
//! ```text
//!     text → tree.rs (elements with lines, includes) → replicate.rs (copies) → defaults.rs (classes) → bodies.rs, geoms.rs, meshes.rs, joints.rs
//!          → rotors.rs, tuning.rs, tendons.rs, equality.rs, actuator_kinds.rs, actuators.rs, activations.rs, contacts.rs, keyframes.rs
//!          → written.rs (TOML and URDF) → scene_reading → Scene
//! ```
//!
//! Each child of the world with a joint in it is a robot, each without is an obstacle. What has no counterpart is a warning with its line. A log
//! carries the scene file and the URDFs that were made, so that its run can be made again without the MJCF file and its meshes.

pub(crate) mod activations;
pub(crate) mod actuator_kinds;
pub(crate) mod actuators;
pub(crate) mod bodies;
pub(crate) mod compiler;
pub(crate) mod contacts;
pub(crate) mod defaults;
pub(crate) mod equality;
pub(crate) mod fields;
pub(crate) mod fitted;
pub(crate) mod flags;
pub(crate) mod free_frames;
pub(crate) mod geoms;
pub(crate) mod grips;
pub(crate) mod joints;
pub(crate) mod keyframes;
pub(crate) mod mass;
pub(crate) mod meshes;
pub(crate) mod mjcf;
pub(crate) mod orientation;
pub(crate) mod parts;
pub(crate) mod reader;
pub(crate) mod replicate;
pub(crate) mod rest_lengths;
pub(crate) mod rotors;
pub(crate) mod tendons;
pub(crate) mod tree;
pub(crate) mod tuning;
pub(crate) mod written;
