//! A surface of triangles and a point, the core of a ball, in closed form.
//!
//! Seen from a point c, one feature of a triangle is nearest. With the unit normal n of the triangle, the unit vector m_k in its plane from its side k
//! inward, and a corner v of that side:
//!
//! ```text
//!     h = n · (c − v)      s_k = m_k · (c − v)      all s_k ≥ 0 ─▶ the face, at |h|      otherwise the nearest point of a side with s_k < 0
//! ```
//!
//! The whole triangle is at least |h| from c, and at least −s_k. Numbers of features are those of the general search ([`crate::distances::nearest`]).
//!
//! Source: C. Ericson, Real-Time Collision Detection, Morgan Kaufmann 2005, section 5.1.5.

use crate::distances::mesh::{ALONG, Mesh, Triangle};
use crate::features::both::{Both, Candidate};
use crate::features::feature::{FeatureId, Part};
use crate::features::meet::{Guess, meet};
use crate::shapes::convex::{Convex, Core};
use nalgebra::{Matrix3, Vector3};

/// Outside of a feature, relative to the size, as far as contacts keep their features; and by rounding.
const OUTSIDE: f64 = 1e-9;
const ROUNDING: f64 = 1e-12;

/// The core of a ball in the frame of the mesh.
pub(super) struct Ball<'b> {
    convex: &'b Convex,
    rotation: Matrix3<f64>,
    translation: Vector3<f64>,
    centre: Vector3<f64>,
}

/// The least that a triangle is apart from a point (m), and the height of the point over its sides in its plane (m).
struct Over {
    height: f64,
    sides: [f64; 3],
}

impl<'b> Ball<'b> {
    /// A convex shape, if it is a ball.
    pub fn of(b: &'b Convex, rotation: &Matrix3<f64>, translation: &Vector3<f64>) -> Option<Self> {
        let Core::Polytope(polytope) = &b.core else { return None };
        let [centre] = polytope.vertices[..] else { return None };
        let centre = rotation * centre + translation;
        Some(Ball { convex: b, rotation: *rotation, translation: *translation, centre })
    }

    /// The point and a feature of a triangle.
    fn meets(&self, triangle: &Triangle, feature: FeatureId, on: Part) -> Option<Candidate> {
        let both = Both { a: &triangle.shape, b: self.convex, rotation: self.rotation, translation: self.translation };
        let guess = Guess { normal: triangle.normal, point: self.centre, at_point: false };
        let (normal, points) = meet(&on, &Part::Point(self.centre), &guess)?;
        let separation = both.separation(&normal);
        Some(Candidate { normal, points, features: [feature, FeatureId::Vertex(0)], separation })
    }
}

impl Over {
    fn of(triangle: &Triangle, corners: &[Vector3<f64>; 3], centre: &Vector3<f64>) -> Self {
        let sides = [0, 1, 2].map(|side: usize| triangle.inward[side].dot(&(centre - corners[triangle.ends[side][0]])));
        Over { height: triangle.normal.dot(&(centre - corners[0])), sides }
    }

    /// How far inside the sides the point is (m).
    fn inside(&self) -> f64 {
        self.sides.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// A length that the triangle and the point are at least apart (m).
    fn least(&self) -> f64 {
        self.height.abs().max(-self.inside())
    }
}

impl Mesh {
    /// The nearest point of a triangle to the centre of a ball, unless it is farther than `most` (m).
    pub(super) fn ask_ball(&self, number: usize, ball: &Ball, most: f64) -> Option<Candidate> {
        let triangle = self.triangle(number);
        let corners = self.corners_of(triangle);
        let over = Over::of(triangle, &corners, &ball.centre);
        if over.least() > most {
            return None;
        }
        if over.inside() >= 0.0 {
            let side = u32::from(over.height < 0.0);
            let normal = if side == 1 { -triangle.normal } else { triangle.normal };
            let found = ball.meets(triangle, FeatureId::Face(side), Part::Plane(corners[0], normal));
            return found.map(|candidate| self.named(number, candidate));
        }
        let mut best: Option<(f64, FeatureId, Part)> = None;
        for side in (0..3).filter(|&side| over.sides[side] < 0.0) {
            let ends = triangle.ends[side].map(|end| corners[end]);
            let (from, length) = ((ends[1] - ends[0]), (ends[1] - ends[0]).norm());
            let along = from.dot(&(ball.centre - ends[0])) / length;
            let (feature, part, point) = if along <= 0.0 || along >= length {
                let end = usize::from(along > 0.0);
                (FeatureId::Vertex(triangle.ends[side][end] as u32), Part::Point(ends[end]), ends[end])
            } else {
                (FeatureId::Edge(side as u32), Part::Line(ends, 0.0), ends[0] + from * (along / length))
            };
            let apart = (ball.centre - point).norm();
            if best.as_ref().is_none_or(|(least, ..)| apart < *least) {
                best = Some((apart, feature, part));
            }
        }
        let (_, feature, part) = best?;
        ball.meets(triangle, feature, part).map(|candidate| self.named(number, candidate))
    }

    /// Adds the places of a triangle and a ball whose gap is below a bound (m).
    pub(super) fn add_places_of_ball(&self, number: usize, ball: &Ball, near: f64, found: &mut Vec<Candidate>) {
        let triangle = self.triangle(number);
        let corners = self.corners_of(triangle);
        let over = Over::of(triangle, &corners, &ball.centre);
        let (inside, radius) = (over.inside(), ball.convex.radius);
        if over.least() - radius >= near {
            return;
        }
        let size = triangle.shape.size.max(ball.convex.size);
        let outside = -(near.abs().min(OUTSIDE * size) + ROUNDING * size);
        let mut add = |feature: FeatureId, part: Part| {
            let candidate = ball.meets(triangle, feature, part).map(|candidate| self.named(number, candidate));
            found.extend(candidate.filter(|one| one.distance() - radius < near && self.may_touch(one)));
        };
        if over.height > 0.0 && inside >= outside {
            add(FeatureId::Face(0), Part::Plane(corners[0], triangle.normal));
        }
        // Over the face no normal of a side or corner points at the centre.
        if inside > ALONG * (ball.centre - corners[0]).norm() {
            return;
        }
        for (side, local) in triangle.ends.iter().enumerate() {
            let ends = local.map(|end| corners[end]);
            let along = (ends[1] - ends[0]).normalize();
            let within = along.dot(&(ball.centre - ends[0])).min(along.dot(&(ends[1] - ball.centre)));
            if self.is_open_edge(triangle.edges[side]) && within >= outside {
                add(FeatureId::Edge(side as u32), Part::Line(ends, 0.0));
            }
        }
        for (vertex, corner) in corners.iter().enumerate() {
            if self.is_open_vertex(triangle.corners[vertex]) {
                add(FeatureId::Vertex(vertex as u32), Part::Point(*corner));
            }
        }
    }
}
