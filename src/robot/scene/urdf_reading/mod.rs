//! URDF files: text, tree of elements, checks, [`Robot`](crate::scene::robot::Robot).

pub(crate) mod body_robot;
pub(crate) mod clean;
pub(crate) mod convert;
pub(crate) mod element;
pub(crate) mod inertia;
pub(crate) mod mesh_files;
pub(crate) mod package_path;
pub(crate) mod schema;
pub(crate) mod screws;
pub(crate) mod surface_friction;
pub(crate) mod taken_numbers;
pub(crate) mod transmissions;
pub(crate) mod tree;
pub(crate) mod unsimulated;
pub(crate) mod urdf;
pub(crate) mod xacro;
