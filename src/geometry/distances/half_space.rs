//! A half space and a convex shape: the support points of the shape decide, and all is in closed form.
//!
//! ```text
//!     distance = min over the core of n · (q − o) − r
//! ```
//!
//! A vertex, the centre of a sphere and the ends of a capsule are points over a plane. An ellipsoid touches with one point of its surface. A cylinder touches with its rims: with one if it is
//! slanted, with both if it lies. An end that is flat on the plane to within `near` touches with four points of its rim; see
//! [`crate::features::feature::FeatureId::RimPoint`].

use crate::distances::few::{MOST, tilts};
use crate::features::both::Candidate;
use crate::features::feature::{FeatureId, Part, contact_features, part};
use crate::features::meet::{Guess, meet};
use crate::shapes::convex::{Convex, Core};
use crate::shapes::polytope::Polytope;
use nalgebra::{Matrix3, Vector3};

/// A half space in the frame of its body.
#[derive(Clone, Debug, PartialEq)]
pub struct HalfSpace {
    /// On its surface (m).
    pub point: Vector3<f64>,
    /// Unit normal out of it.
    pub normal: Vector3<f64>,
}

impl HalfSpace {
    /// Its surface.
    pub fn part(&self) -> Part {
        Part::Plane(self.point, self.normal)
    }

    /// The lowest point of a convex core whose frame has this rotation and translation (m) in the frame of the half space.
    pub fn nearest(&self, b: &Convex, rotation: &Matrix3<f64>, translation: &Vector3<f64>) -> Candidate {
        let down = -rotation.tr_mul(&self.normal);
        let q = rotation * b.core.support_point(&down) + translation;
        let feature = match &b.core {
            Core::Polytope(polytope) => FeatureId::Vertex(polytope.support_vertex(&down) as u32),
            Core::Cylinder(cylinder) => FeatureId::Rim(u32::from(cylinder.axis.dot(&down) >= 0.0)),
            Core::Ellipsoid(_) => FeatureId::Side,
        };
        self.candidate(q, feature)
    }

    /// All points of a convex shape whose gap is below a bound (m).
    pub fn manifold(
        &self,
        b: &Convex,
        rotation: &Matrix3<f64>,
        translation: &Vector3<f64>,
        near: f64,
    ) -> Vec<Candidate> {
        let down = -rotation.tr_mul(&self.normal);
        let guess = Guess { normal: self.normal, point: rotation * b.centre + translation, at_point: false };
        let place = |feature: FeatureId| {
            let on_b = part(&b.core, feature).moved(rotation, translation);
            if !matches!(on_b, Part::Point(_) | Part::Circle(..) | Part::Ellipsoid(_)) {
                return None;
            }
            let (_, [_, q]) = meet(&self.part(), &on_b, &guess)?;
            Some(self.candidate(q, feature)).filter(|candidate| candidate.distance() - b.radius < near)
        };
        let nearest = self.nearest(b, rotation, translation);
        let gap = nearest.distance() - b.radius;
        if let (Core::Polytope(polytope), FeatureId::Vertex(lowest)) = (&b.core, nearest.features[1])
            && polytope.neighbours.are_known()
        {
            let vertex = |vertex: usize| place(FeatureId::Vertex(vertex as u32));
            let low = polytope.neighbours.connected(lowest as usize, usize::MAX, |number| vertex(number).is_some());
            return low.into_iter().flatten().filter_map(vertex).collect();
        }
        contact_features(&b.core, &down, near - gap).filter_map(place).collect()
    }

    /// A few of these points of a polytope with many vertices, instead of all: the lowest ones after small turns ([`crate::distances::few`]); `None` of other shapes.
    pub fn few(
        &self,
        b: &Convex,
        rotation: &Matrix3<f64>,
        translation: &Vector3<f64>,
        near: f64,
    ) -> Option<Vec<Candidate>> {
        let Core::Polytope(polytope) = &b.core else { return None };
        if !polytope.neighbours.are_known() {
            return None;
        }
        let down = -rotation.tr_mul(&self.normal);
        let lowest = polytope.support_vertex(&down);
        let candidate = |vertex: usize| {
            self.candidate(rotation * polytope.vertices[vertex] + translation, FeatureId::Vertex(vertex as u32))
        };
        let is_near = |vertex: usize| candidate(vertex).distance() - b.radius < near;
        let low = polytope.neighbours.connected(lowest, MOST, is_near).unwrap_or_else(|| {
            let mut low: Vec<usize> =
                tilts(&down, near, b.size).map(|tilt| polytope.support_vertex(&(down + tilt))).collect();
            low.sort_unstable();
            low.dedup();
            low
        });
        Some(low.into_iter().filter(|&vertex| is_near(vertex)).map(candidate).collect())
    }

    /// The least height of the vertices of a polytope that are not among these (m); `None` for other cores. Because the vertices below any height are
    /// connected, the lowest of the others is the lowest of all or a neighbour of one of these.
    pub fn lowest_but(
        &self,
        b: &Convex,
        closed: impl Iterator<Item = FeatureId> + Clone,
        rotation: &Matrix3<f64>,
        translation: &Vector3<f64>,
    ) -> Option<f64> {
        let Core::Polytope(polytope) = &b.core else { return None };
        let is_closed = |vertex: usize| closed.clone().any(|feature| feature == FeatureId::Vertex(vertex as u32));
        let height = |vertex: usize| {
            let q = rotation * polytope.vertices[vertex] + translation;
            self.normal.dot(&(q - self.point)) - b.radius
        };
        let mut least = f64::INFINITY;
        let mut see = |vertex: usize| {
            if !is_closed(vertex) {
                least = least.min(height(vertex));
            }
        };
        if polytope.neighbours.are_known() {
            see(polytope.support_vertex(&-rotation.tr_mul(&self.normal)));
        }
        let known = closed.clone().filter_map(|feature| vertex_of(polytope, feature));
        polytope.neighbours.see_beside(known, polytope.vertices.len(), see);
        Some(least)
    }

    /// The least slope over the surface of the lines from touching vertices of a polytope to open vertices beside them; `None` for other
    /// cores. Each of these is seen from the touching vertex over which it is steepest. A body that turns about its touching vertices by no more than
    /// this angle (rad) brings no other vertex to the surface: a line at the slope sin α turns by α to get there, and the first vertex to touch is
    /// beside one that does.
    pub fn least_slope_beside(
        &self,
        b: &Convex,
        closed: impl Iterator<Item = FeatureId> + Clone,
        rotation: &Matrix3<f64>,
    ) -> Option<f64> {
        let Core::Polytope(polytope) = &b.core else { return None };
        let closed = closed.map(|feature| vertex_of(polytope, feature));
        if !closed.clone().all(|vertex| vertex.is_some()) {
            return None;
        }
        let closed = closed.flatten();
        let up = rotation.tr_mul(&self.normal);
        let slope = |from: usize, to: usize| {
            let line = polytope.vertices[to] - polytope.vertices[from];
            up.dot(&line) / line.norm()
        };
        let steepest = |to: usize| closed.clone().map(|from| slope(from, to)).fold(f64::NEG_INFINITY, f64::max);
        let mut least = f64::INFINITY;
        polytope.neighbours.see_beside(closed.clone(), polytope.vertices.len(), |other| {
            if closed.clone().all(|vertex| vertex != other) {
                least = least.min(steepest(other));
            }
        });
        Some(least)
    }

    /// A point (m) over the surface.
    fn candidate(&self, q: Vector3<f64>, feature: FeatureId) -> Candidate {
        let separation = self.normal.dot(&(q - self.point));
        let points = [q - self.normal * separation, q];
        Candidate { normal: self.normal, points, features: [FeatureId::Face(0), feature], separation }
    }
}

/// The number of a vertex of a polytope; `None` for other features.
fn vertex_of(polytope: &Polytope, feature: FeatureId) -> Option<usize> {
    match feature {
        FeatureId::Vertex(vertex) if (vertex as usize) < polytope.vertices.len() => Some(vertex as usize),
        _ => None,
    }
}
