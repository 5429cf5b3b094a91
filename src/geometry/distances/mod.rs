//! Distances of two shapes with their certificates, and all places where they touch.

pub(crate) mod axes;
pub(crate) mod best;
pub(crate) mod beyond;
pub(crate) mod deepest;
pub(crate) mod doubles;
pub(crate) mod few;
pub(crate) mod half_space;
pub(crate) mod hollow;
pub(crate) mod inner;
pub(crate) mod manifold;
pub(crate) mod mesh;
mod mesh_and_point;
mod mesh_parts;
pub(crate) mod near_pairs;
pub(crate) mod nearest;
pub(crate) mod otherwise;
