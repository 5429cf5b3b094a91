//! The geometry of contact: distances and touching features of two shapes, exact to rounding.
//!
//! [`PairGeometry`] answers all questions about two colliders: their certified distance, the places where they touch as features with frames in the
//! bodies, and how far a place is from the borders of its features. Conservative advancement needs only the distance: two shapes whose points
//! approach at no more than V [m/s] do not touch before distance / V.
//!
//! | where | what is in it |
//! |---|---|
//! | `shapes` | shapes, prepared; convex pieces of a surface; the triangles of a hull, for drawing |
//! | `features` | vertices, edges, faces, rims, sides: names, parts, borders; closed forms by pair; points that stand for rims |
//! | `distances` | the distance of two shapes with its certificate; all places where they touch; how far the rest is |
//! | `prepared_shape`, `pair` | a shape, shared by its pairs; answers |
//!
//! parry proposes candidates (GJK, hulls, the tree of triangles, VHACD). This crate computes every result from the features.

#![deny(unsafe_code)]

mod distances;
mod features;
mod pair;
mod prepared_shape;
mod shapes;
#[cfg(test)]
mod tests;

pub use features::feature::FeatureId;
pub use features::place::{PlaceId, TouchPlace};
pub use pair::{Before, Distance, PairGeometry, Revolved};
pub use prepared_shape::PreparedShape;
pub use shapes::convex::{check_shape, kind};
pub use shapes::decompose::{Pieces, decompose};
pub use shapes::error::GeometryError;
pub use shapes::extents::Extents;
pub use shapes::hull_surface::hull_surface;
