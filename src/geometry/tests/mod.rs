//! Tests of distances, places and borders of features.

mod axes;
mod beyond;
mod certificates;
mod extents;
mod few;
mod manifolds;
mod margins;
mod meshes;
mod pieces;
mod refused;
pub(crate) mod scenes;
mod turning;
