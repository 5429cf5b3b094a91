//! Two convex cores at one instant, in the frame of the first body, and the separation along a normal.
//!
//! ```text
//!     sep(n) = min_b n · q − max_a n · p  ≤  distance      for every unit n from a to b
//! ```
//!
//! The largest sep(n) is the distance of the cores; if they overlap, it is minus the depth. Let p be a point of a and q of b. Then n · (q − p) −
//! sep(n) ≥ 0 is the *certificate*: an upper bound of the error of the distance, whatever the source of n, p and q. GJK (parry) only proposes: its
//! tolerances are absolute, so it is asked in units of the size.

use crate::features::feature::FeatureId;
use crate::shapes::convex::{Convex, Core};
use nalgebra::{Matrix3, Vector3};
use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::query::gjk::{self, CsoPoint, GJKResult, VoronoiSimplex};
use parry3d_f64::shape::SupportMap;

/// Two convex shapes at one instant.
pub struct Both<'a> {
    /// The first, in whose body frame everything is.
    pub a: &'a Convex,
    /// The second, in its own body frame.
    pub b: &'a Convex,
    /// Rotation from the second body frame to the first.
    pub rotation: Matrix3<f64>,
    /// Place of the second body in the first (m).
    pub translation: Vector3<f64>,
}

/// Possible nearest points of the cores, in the frame of the first body.
#[derive(Clone, Copy, Debug)]
pub struct Candidate {
    /// Unit normal from a to b.
    pub normal: Vector3<f64>,
    /// Points on the core of a and on the core of b (m).
    pub points: [Vector3<f64>; 2],
    /// The features that they lie on.
    pub features: [FeatureId; 2],
    /// sep(n) (m).
    pub separation: f64,
}

impl Candidate {
    /// Distance of the points along the normal (m).
    pub fn distance(&self) -> f64 {
        self.normal.dot(&(self.points[1] - self.points[0]))
    }

    /// An upper bound of the error of the distance (m).
    pub fn certificate(&self) -> f64 {
        let between = self.points[1] - self.points[0];
        let across = (between - self.normal * self.distance()).norm();
        (self.distance() - self.separation).abs().max(across)
    }
}

impl Both<'_> {
    /// Size of the larger of the two (m).
    pub fn size(&self) -> f64 {
        self.a.size.max(self.b.size)
    }

    /// How far the shapes are from the origins of their frames, and these from each other, in all (m): obstacles are in the frame of the world.
    pub fn farthest(&self) -> f64 {
        self.a.centre.norm() + self.b.centre.norm() + self.translation.norm()
    }

    /// A point of the second shape (m).
    pub fn of_b(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.rotation * point + self.translation
    }

    /// A direction of the second shape.
    pub fn turned(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        self.rotation * direction
    }

    /// `max n · p` over the core of a (m).
    pub fn high(&self, normal: &Vector3<f64>) -> f64 {
        self.a.core.support(normal)
    }

    /// `min n · q` over the core of b (m).
    pub fn low(&self, normal: &Vector3<f64>) -> f64 {
        normal.dot(&self.translation) - self.b.core.support(&-(self.rotation.tr_mul(normal)))
    }

    /// sep(n) (m).
    pub fn separation(&self, normal: &Vector3<f64>) -> f64 {
        self.low(normal) - self.high(normal)
    }

    /// The direction from the middle of a to the middle of b, as a unit vector.
    pub fn centres(&self) -> Vector3<f64> {
        let between = self.of_b(&self.b.centre) - self.a.centre;
        between.try_normalize(0.0).unwrap_or_else(Vector3::z)
    }

    /// The normal from a to b that GJK finds with b moved by a shift (m); `None` if the cores overlap or touch there.
    pub fn hint(&self, shift: &Vector3<f64>) -> Option<Vector3<f64>> {
        let size = self.size();
        let (middle, nowhere) = (self.a.centre, Vector3::zeros());
        let start = self.centres();
        // Without its tolerances, a point and a point have no simplex to reduce.
        if let (Core::Polytope(a), Core::Polytope(b)) = (&self.a.core, &self.b.core)
            && a.vertices.len() == 1
            && b.vertices.len() == 1
        {
            return (self.of_b(&b.vertices[0]) + shift - a.vertices[0]).try_normalize(0.0);
        }
        let a = Scaled { of: self, middle, shift: &nowhere, size, second: false };
        let b = Scaled { of: self, middle, shift, size, second: true };
        let mut simplex = VoronoiSimplex::new();
        let direction = Vector::new(start.x, start.y, start.z);
        simplex.reset(CsoPoint::from_shapes(&Pose::IDENTITY, &a, &b, direction));
        match gjk::closest_points(&Pose::IDENTITY, &a, &b, f64::MAX, true, &mut simplex) {
            GJKResult::ClosestPoints(p, q, _) => {
                let between = Vector3::new(q.x - p.x, q.y - p.y, q.z - p.z);
                between.try_normalize(1e-14)
            }
            _ => None,
        }
    }
}

/// One of the cores about the middle of a, in units of the size.
struct Scaled<'a> {
    of: &'a Both<'a>,
    middle: Vector3<f64>,
    shift: &'a Vector3<f64>,
    size: f64,
    second: bool,
}

impl SupportMap for Scaled<'_> {
    fn local_support_point(&self, direction: Vector) -> Vector {
        let direction = Vector3::new(direction.x, direction.y, direction.z);
        let point = match self.second {
            false => self.of.a.core.support_point(&direction),
            true => self.of.of_b(&self.of.b.core.support_point(&self.of.rotation.tr_mul(&direction))),
        };
        let point = (point - self.middle + self.shift) / self.size;
        Vector::new(point.x, point.y, point.z)
    }
}
