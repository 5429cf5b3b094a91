//! Tests of distances, places and borders of features.

mod certificates;
mod manifolds;
mod margins;
mod meshes;
mod refused;
mod scenes;
