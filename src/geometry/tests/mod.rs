//! Tests of the room: what a reviewer asks of distances, places and borders.

mod certificates;
mod manifolds;
mod margins;
mod meshes;
mod refused;
mod scenes;
