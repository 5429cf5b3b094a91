//! A triangle of a surface and a point, the core of a ball, in closed form.
//!
//! Seen from a point c, one feature of a triangle is nearest. With the unit normal n of the triangle, the unit vector m_k in its plane from its side k
//! inward, and a corner v of that side:
//!
//! ```text
//!     h = n · (c − v)      s_k = m_k · (c − v)      all s_k ≥ 0 ─▶ the face, at |h|      otherwise the nearest point of a side with s_k < 0
//! ```
//!
//! The whole triangle is at least |h| from c, and at least −s_k. Features have the names of the general search ([`crate::distances::nearest`]).
//!
//! Source: C. Ericson, Real-Time Collision Detection, Morgan Kaufmann 2005, section 5.1.5.

use crate::features::both::{Both, Candidate};
use crate::features::feature::{FeatureId, Part};
use crate::features::meet::{Guess, meet};
use crate::shapes::convex::{Convex, Core};
use crate::shapes::polytope::Polytope;
use nalgebra::{Matrix3, Vector3};

/// Normals that lean over a neighbour by less than this angle (rad) belong to the border.
pub(super) const ALONG: f64 = 1e-9;
/// Outside of a feature, relative to the size, as far as contacts keep their features; and by rounding.
const OUTSIDE: f64 = 1e-9;
const ROUNDING: f64 = 1e-12;

/// A triangle with its sides in the order of the polytope's edges.
pub(super) struct Facet {
    /// The corners (m), and the unit normal out of the surface.
    pub corners: [Vector3<f64>; 3],
    pub normal: Vector3<f64>,
    /// Which corners are the ends of each side.
    pub ends: [[usize; 2]; 3],
    /// The unit vectors in the plane of the triangle from the sides inward.
    inward: [Vector3<f64>; 3],
    pub shape: Convex,
}

/// A ball in the frame of the surface.
pub(super) struct Ball<'b> {
    convex: &'b Convex,
    rotation: Matrix3<f64>,
    translation: Vector3<f64>,
    centre: Vector3<f64>,
}

/// The heights of a point over a triangle and over its sides in its plane (m).
struct Over {
    height: f64,
    sides: [f64; 3],
}

impl Facet {
    /// The triangle with these corners (m).
    pub fn new(corners: [Vector3<f64>; 3], normal: Vector3<f64>) -> Self {
        let polytope = Polytope::triangle(corners, normal);
        let ends = [0, 1, 2].map(|side: usize| polytope.edges[side].ends);
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        let inward = ends.map(|[from, to]| {
            let across = normal.cross(&(corners[to] - corners[from])).normalize();
            across * across.dot(&(middle - corners[from])).signum()
        });
        Facet { corners, normal, ends, inward, shape: Convex::round(polytope, 0.0) }
    }

    fn over(&self, centre: &Vector3<f64>) -> Over {
        let sides = [0, 1, 2].map(|side: usize| self.inward[side].dot(&(centre - self.corners[self.ends[side][0]])));
        Over { height: self.normal.dot(&(centre - self.corners[0])), sides }
    }

    /// The side of the triangle on which a point is: its front, or its back.
    fn side(&self, over: &Over) -> (FeatureId, Part) {
        let (side, normal) = if over.height < 0.0 { (1, -self.normal) } else { (0, self.normal) };
        (FeatureId::Face(side), Part::Plane(self.corners[0], normal))
    }
}

impl Over {
    /// How far inside the sides the point is (m).
    fn inside(&self) -> f64 {
        self.sides.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// A length that the triangle and the point are at least apart (m).
    fn least(&self) -> f64 {
        self.height.abs().max(-self.inside())
    }
}

impl<'b> Ball<'b> {
    /// A convex shape, if it is a ball.
    pub fn of(b: &'b Convex, rotation: &Matrix3<f64>, translation: &Vector3<f64>) -> Option<Self> {
        let Core::Polytope(polytope) = &b.core else { return None };
        let [centre] = polytope.vertices[..] else { return None };
        let centre = rotation * centre + translation;
        Some(Ball { convex: b, rotation: *rotation, translation: *translation, centre })
    }

    /// The nearest point of a triangle, unless it is farther from the centre than `most` (m).
    pub fn nearest(&self, facet: &Facet, most: f64) -> Option<Candidate> {
        let Facet { corners, ends, .. } = facet;
        let over = facet.over(&self.centre);
        if over.least() > most {
            return None;
        }
        if over.inside() >= 0.0 {
            let (side, plane) = facet.side(&over);
            return self.meets(facet, side, plane);
        }
        let mut best: Option<(f64, FeatureId, Part)> = None;
        for side in (0..3).filter(|&side| over.sides[side] < 0.0) {
            let [from, to] = ends[side].map(|end| corners[end]);
            let length = (to - from).norm();
            let along = (to - from).dot(&(self.centre - from)) / length;
            let (feature, part, point) = if along <= 0.0 || along >= length {
                let end = ends[side][usize::from(along > 0.0)];
                (FeatureId::Vertex(end as u32), Part::Point(corners[end]), corners[end])
            } else {
                (FeatureId::Edge(side as u32), Part::Line([from, to], 0.0), from + (to - from) * (along / length))
            };
            let apart = (self.centre - point).norm();
            if best.as_ref().is_none_or(|(least, ..)| apart < *least) {
                best = Some((apart, feature, part));
            }
        }
        let (_, feature, part) = best?;
        self.meets(facet, feature, part)
    }

    /// Calls a function with each place of a triangle whose gap is below a bound (m) and whose feature is open: its sides and corners are asked.
    pub fn places(
        &self,
        facet: &Facet,
        near: f64,
        is_open: impl Fn(FeatureId) -> bool,
        mut add: impl FnMut(Candidate),
    ) {
        let Facet { corners, ends, .. } = facet;
        let over = facet.over(&self.centre);
        let (inside, radius) = (over.inside(), self.convex.radius);
        if over.least() - radius >= near {
            return;
        }
        let size = facet.shape.size.max(self.convex.size);
        let outside = -(near.abs().min(OUTSIDE * size) + ROUNDING * size);
        let mut see = |feature: FeatureId, part: Part| {
            let found = self.meets(facet, feature, part);
            found.filter(|one| one.distance() - radius < near).into_iter().for_each(&mut add);
        };
        if inside >= outside {
            let (side, plane) = facet.side(&over);
            see(side, plane);
        }
        // Over the face no normal of a side or corner points at the centre.
        if inside > ALONG * (self.centre - corners[0]).norm() {
            return;
        }
        for (side, local) in ends.iter().enumerate() {
            let (feature, [from, to]) = (FeatureId::Edge(side as u32), local.map(|end| corners[end]));
            let along = (to - from).normalize();
            let within = along.dot(&(self.centre - from)).min(along.dot(&(to - self.centre)));
            if is_open(feature) && within >= outside {
                see(feature, Part::Line([from, to], 0.0));
            }
        }
        for (vertex, corner) in corners.iter().enumerate() {
            let feature = FeatureId::Vertex(vertex as u32);
            if is_open(feature) {
                see(feature, Part::Point(*corner));
            }
        }
    }

    /// The centre and a feature of a triangle.
    fn meets(&self, facet: &Facet, feature: FeatureId, on: Part) -> Option<Candidate> {
        let both = Both { a: &facet.shape, b: self.convex, rotation: self.rotation, translation: self.translation };
        let guess = Guess { normal: facet.normal, point: self.centre, at_point: false };
        let (normal, points) = meet(&on, &Part::Point(self.centre), &guess)?;
        let separation = both.separation(&normal);
        Some(Candidate { normal, points, features: [feature, FeatureId::Vertex(0)], separation })
    }
}
