//! The geometry of contact: distances and touching features of two shapes, exact to rounding.
//!
//! [`PairGeometry`] answers all questions about two colliders: their certified distance, the places where they touch as features with frames in the
//! bodies, and how far a place is from the borders of its features. Conservative advancement needs only the distance: two shapes whose points
//! approach at no more than V [m/s] do not touch before distance / V.
//!
//! | file | what is in it |
//! |---|---|
//! | `plane`, `polytope`, `hull`, `convex`, `half_space`, `mesh` | shapes, prepared |
//! | `feature` | vertices, edges, faces, rims, sides: names, parts, borders |
//! | `meet`, `guesses` | normal and points of two features: closed forms; where they are looked for |
//! | `both`, `best`, `nearest`, `deepest` | the distance of two convex shapes with its certificate; the depth at rims |
//! | `manifold`, `lens`, `arcs` | all places where they touch; the points of two discs on each other, of a disc on a face |
//! | `beyond` | how far the rest of two shapes is from each other while they touch |
//! | `forms`, `crossing`, `rims` | which pair of a joint two features are, and which form the gap of rims has |
//! | `place`, `pair` | answers |
//! | `decompose`, `cells` | convex pieces of a surface; exact ones |
//! | `hull_surface` | the triangles of a hull, for drawing |
//!
//! parry proposes candidates (GJK, hulls, the tree of triangles, VHACD). This crate computes every result from the features.

#![deny(unsafe_code)]

mod arcs;
mod best;
mod beyond;
mod both;
mod cells;
mod convex;
mod crossing;
mod decompose;
mod deepest;
mod error;
mod feature;
mod forms;
mod guesses;
mod half_space;
mod hull;
mod hull_surface;
mod lens;
mod manifold;
mod meet;
mod mesh;
mod nearest;
mod pair;
mod place;
mod plane;
mod polytope;
mod rims;
#[cfg(test)]
mod tests;

pub use convex::check_shape;
pub use decompose::{Pieces, decompose};
pub use error::GeometryError;
pub use feature::FeatureId;
pub use hull_surface::hull_surface;
pub use pair::{Distance, PairGeometry};
pub use place::{PlaceId, TouchPlace};
