//! Where two convex shapes that touch at one place touch next: distances of all other features from that place's tangent plane.
//!
//! Two convex shapes that touch at a point with the normal n overlap nowhere as long as the tangent plane separates them. With a point p of the
//! contact that is, for what is not part of the features that touch,
//!
//! ```text
//!     min over b of n · (q − p) ≥ 0,     min over a of n · (p − q) ≥ 0                 [m], q vertices, and of a rim its nearest point
//! ```
//!
//! Unlike the gaps of pairs of features this is there for everything at any distance, and no faster than the bodies: a function that can be
//! bracketed.

use crate::features::feature::{FeatureId, Part, part};
use crate::shapes::convex::{Convex, Core};
use nalgebra::{Matrix3, Vector3};

/// The least height of a core over a plane with this normal into the core's side, without what belongs to features that touch (m): the plane goes
/// through `foot`, all in the frame of the body.
pub fn height(shape: &Convex, closed: &[FeatureId], normal: &Vector3<f64>, foot: &Vector3<f64>) -> f64 {
    match &shape.core {
        Core::Polytope(polytope) => {
            let touches = |number: usize| {
                closed.iter().any(|feature| match *feature {
                    FeatureId::Vertex(vertex) => vertex as usize == number,
                    FeatureId::Edge(edge) | FeatureId::EdgePoint { edge, .. } => {
                        polytope.edges.get(edge as usize).is_some_and(|edge| edge.ends.contains(&number))
                    }
                    FeatureId::Face(face) => {
                        polytope.faces.get(face as usize).is_some_and(|face| face.corners.contains(&number))
                    }
                    _ => false,
                })
            };
            let others = polytope.vertices.iter().enumerate().filter(|(number, _)| !touches(*number));
            others.map(|(_, vertex)| normal.dot(&(vertex - foot))).fold(f64::INFINITY, f64::min)
        }
        Core::Cylinder(cylinder) => {
            let touches = |end: u32| {
                let own = [FeatureId::Rim(end), FeatureId::Cap(end), FeatureId::Side];
                closed.iter().any(|feature| own.contains(feature))
            };
            let across = cylinder.axis.cross(normal).norm();
            let lowest = |end: u32| {
                let centre = cylinder.rim_centre(end as usize);
                let mut points = closed
                    .iter()
                    .filter(|feature| matches!(feature, FeatureId::RimPoint { end: own, .. } if *own == end));
                // Where one point touches alone the cylinder tilts in a plane, and the opposite one is next.
                match (points.next().map(|&point| part(&shape.core, point)), points.next()) {
                    (Some(Part::Point(point)), None) => normal.dot(&(centre * 2.0 - point - foot)),
                    _ => normal.dot(&(centre - foot)) - cylinder.radius * across,
                }
            };
            (0..2).filter(|&end| !touches(end)).map(lowest).fold(f64::INFINITY, f64::min)
        }
    }
}

/// The same in another frame than that of the body, which has this rotation and translation (m) in it.
pub fn height_of_moved(
    shape: &Convex,
    closed: &[FeatureId],
    [normal, foot]: [&Vector3<f64>; 2],
    rotation: &Matrix3<f64>,
    translation: &Vector3<f64>,
) -> f64 {
    height(shape, closed, &rotation.tr_mul(normal), &rotation.tr_mul(&(foot - translation)))
}

/// Whether a feature is flat: what else its body has is behind it for ever.
pub fn is_flat(feature: FeatureId) -> bool {
    matches!(feature, FeatureId::Face(_) | FeatureId::Cap(_))
}
