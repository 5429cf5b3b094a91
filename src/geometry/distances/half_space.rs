//! A half space and a convex shape: the support points of the shape decide, and all is in closed form.
//!
//! ```text
//!     distance = min over the core of n · (q − o) − r
//! ```
//!
//! A vertex, the centre of a sphere and the ends of a capsule are points over a plane. A cylinder touches with its rims: with one if it is
//! slanted, with both if it lies. An end that is flat on the plane to within `near` touches with four points of its rim; see
//! [`crate::features::feature::FeatureId::RimPoint`].

use crate::features::both::Candidate;
use crate::features::feature::{FeatureId, Part, contact_features, part};
use crate::features::meet::{Guess, meet};
use crate::shapes::convex::{Convex, Core};
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
            if !matches!(on_b, Part::Point(_) | Part::Circle(..)) {
                return None;
            }
            let (_, [_, q]) = meet(&self.part(), &on_b, &guess)?;
            Some(self.candidate(q, feature)).filter(|candidate| candidate.distance() - b.radius < near)
        };
        let gap = self.nearest(b, rotation, translation).distance() - b.radius;
        contact_features(&b.core, &down, near - gap).filter_map(place).collect()
    }

    /// A point (m) over the surface.
    fn candidate(&self, q: Vector3<f64>, feature: FeatureId) -> Candidate {
        let separation = self.normal.dot(&(q - self.point));
        let points = [q - self.normal * separation, q];
        Candidate { normal: self.normal, points, features: [FeatureId::Face(0), feature], separation }
    }
}
