//! The shapes, prepared from user input: planes, polytopes, hulls, round bodies; convex pieces of surfaces.

pub(crate) mod beside;
pub(crate) mod cells;
pub(crate) mod convex;
pub(crate) mod decompose;
pub(crate) mod error;
pub(crate) mod extents;
pub(crate) mod hull;
pub(crate) mod hull_surface;
pub(crate) mod neighbours;
pub(crate) mod plane;
pub(crate) mod polytope;
pub(crate) mod prepared;
