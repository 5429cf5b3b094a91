//! The next contact of two convex shapes that touch at one place: distances of all other features from that place's tangent plane.
//!
//! Two convex shapes that touch at a point with the normal n do not overlap elsewhere as long as the tangent plane separates them. Let p be a point
//! of the contact. The condition for all features that do not touch is
//!
//! ```text
//!     min over b of n · (q − p) ≥ 0,     min over a of n · (p − q) ≥ 0                 [m], q vertices, and of a rim its nearest point
//! ```
//!
//! Unlike the gaps of pairs of features this is there for everything at any distance, and no faster than the bodies: a function that can be
//! bracketed.
//!
//! Vertices that other places hold in the plane are left out, because their heights are roundings: vertices that touch themselves, the ends of an
//! edge with two places on it, and the corners of a face with three. One place on an edge holds neither of its ends, because shapes that lie on each
//! other may tilt about two corners of their common area. Two edges of a face that lie across the same edge of the other shape hold the face: the
//! tangent plane has one of them and that edge in it, and so the place of the other.

use crate::features::feature::{FeatureId, Part, part};
use crate::shapes::convex::{Convex, Core};
use crate::shapes::polytope::Polytope;
use nalgebra::{Matrix3, Vector3};

/// The features of a place: of the shape at hand, and of the other one.
#[derive(Clone, Copy)]
pub struct Place {
    pub own: FeatureId,
    pub other: FeatureId,
}

/// The least height of a core over the tangent plane of a place, without the touching features (m). The plane has this normal into the core's side
/// and goes through `foot`, all in the frame of the body; `own` is the core's feature of the place, which is one of the closed ones. Infinite for a
/// flat feature: the rest of the body is always behind it.
pub fn height(shape: &Convex, own: Place, closed: &[Place], [normal, foot]: [&Vector3<f64>; 2]) -> f64 {
    if matches!(own.own, FeatureId::Face(_) | FeatureId::Cap(_)) {
        return f64::INFINITY;
    }
    match &shape.core {
        Core::Polytope(polytope) => {
            let held = held_vertices(polytope, own, closed);
            let others = polytope.vertices.iter().zip(&held).filter(|(_, held)| !**held);
            others.map(|(vertex, _)| normal.dot(&(vertex - foot))).fold(f64::INFINITY, f64::min)
        }
        Core::Cylinder(cylinder) => {
            let touches = |end: u32| {
                let own = [FeatureId::Rim(end), FeatureId::Cap(end), FeatureId::Side];
                closed.iter().any(|place| own.contains(&place.own))
            };
            let across = cylinder.axis.cross(normal).norm();
            let lowest = |end: u32| {
                let centre = cylinder.rim_centre(end as usize);
                let mut points = closed
                    .iter()
                    .map(|place| &place.own)
                    .filter(|feature| matches!(feature, FeatureId::RimPoint { end: own, .. } if *own == end));
                // If one point touches alone, the cylinder tilts in a plane, and the opposite point is next.
                match (points.next().map(|&point| part(&shape.core, point)), points.next()) {
                    (Some(Part::Point(point)), None) => normal.dot(&(centre * 2.0 - point - foot)),
                    _ => normal.dot(&(centre - foot)) - cylinder.radius * across,
                }
            };
            (0..2).filter(|&end| !touches(end)).map(lowest).fold(f64::INFINITY, f64::min)
        }
        // Its surface is one feature.
        Core::Ellipsoid(_) => f64::INFINITY,
    }
}

/// For each vertex whether it is in the tangent plane of a place while these places are closed.
fn held_vertices(polytope: &Polytope, own: Place, closed: &[Place]) -> Vec<bool> {
    let corners = |feature: &FeatureId| -> &[usize] {
        match *feature {
            FeatureId::Edge(edge) | FeatureId::EdgePoint { edge, .. } => {
                polytope.edges.get(edge as usize).map_or(&[], |edge| &edge.ends)
            }
            FeatureId::Face(face) => polytope.faces.get(face as usize).map_or(&[], |face| &face.corners),
            _ => &[],
        }
    };
    let is_on = |of: &[usize], feature: &FeatureId| match *feature {
        FeatureId::Vertex(vertex) => of.contains(&(vertex as usize)),
        _ => !corners(feature).is_empty() && corners(feature).iter().all(|corner| of.contains(corner)),
    };
    let places_on = |of: &[usize]| closed.iter().filter(|place| is_on(of, &place.own)).count();
    let mut held = vec![false; polytope.vertices.len()];
    let mut hold = |of: &[usize]| of.iter().for_each(|&corner| held[corner] = true);
    for place in closed {
        match place.own {
            FeatureId::Vertex(vertex) if (vertex as usize) < polytope.vertices.len() => hold(&[vertex as usize]),
            FeatureId::Edge(_) | FeatureId::EdgePoint { .. } if places_on(corners(&place.own)) > 1 => {
                hold(corners(&place.own));
            }
            _ if place.own == own.own => hold(corners(&place.own)),
            _ => {}
        }
    }
    if matches!([own.own, own.other], [FeatureId::Edge(_), FeatureId::Edge(_)]) {
        let across = |place: &Place| place.other == own.other && place.own != own.own;
        let beside =
            |of: &[usize]| is_on(of, &own.own) && closed.iter().any(|place| across(place) && is_on(of, &place.own));
        polytope.faces.iter().filter(|face| beside(&face.corners)).for_each(|face| hold(&face.corners));
    }
    if closed.len() > 2 {
        polytope.faces.iter().filter(|face| places_on(&face.corners) > 2).for_each(|face| hold(&face.corners));
    }
    held
}

/// [`height`] in a frame in which the body has this rotation and translation (m).
pub fn height_of_moved(
    shape: &Convex,
    own: Place,
    closed: &[Place],
    [normal, foot]: [&Vector3<f64>; 2],
    rotation: &Matrix3<f64>,
    translation: &Vector3<f64>,
) -> f64 {
    height(shape, own, closed, [&rotation.tr_mul(normal), &rotation.tr_mul(&(foot - translation))])
}
