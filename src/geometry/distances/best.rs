//! The best of several candidates: the one with the least error.
//!
//! The distance is not less than the largest separation S of all normals that were tried. So the error of a candidate with the certificate ε and the
//! separation s is `max(ε, S − s)`. Among candidates whose points face each other, the one of the largest separation is the best. Points that do not
//! face each other are worse, whatever their normal.

use crate::features::both::{Both, Candidate};
use crate::features::feature::FeatureId;
use nalgebra::Vector3;

/// Depths below this, relative to the size, differ by no more than this.
const TOUCHING: f64 = 1e-9;
/// Errors up to this, relative to the size, are roundings, and more where places are far from the origin. Shapes with many small features have larger
/// ones, because their normals do.
const ROUNDING: f64 = 2e-14;
const ROUNDING_OF_SMALL: f64 = 2e-13;

/// Proposals between two convex shapes, of which the best is kept.
pub struct Best<'a> {
    both: &'a Both<'a>,
    found: Option<Candidate>,
    /// The largest separation (m) of all normals that were tried, and that normal.
    steepest: (f64, Vector3<f64>),
}

impl<'a> Best<'a> {
    /// No candidate yet.
    pub fn new(both: &'a Both<'a>) -> Self {
        Best { both, found: None, steepest: (f64::NEG_INFINITY, both.centres()) }
    }

    /// The largest separation (m) so far and its normal, whether or not points are known that face each other along it.
    pub fn steepest(&self) -> (f64, Vector3<f64>) {
        self.steepest
    }

    /// Tries a unit normal from a to b, and returns its separation (m).
    pub fn try_normal(&mut self, normal: &Vector3<f64>) -> f64 {
        let separation = self.both.separation(normal);
        if separation > self.steepest.0 {
            self.steepest = (separation, *normal);
        }
        separation
    }

    /// The best so far.
    pub fn found(&self) -> Option<Candidate> {
        self.found
    }

    /// A length (m) that neither the distance nor the depth exceeds, if the points of the best so far lie on both shapes; infinite without a
    /// candidate.
    pub fn reach(&self) -> f64 {
        let apart = self.found.map_or(f64::INFINITY, |found| (found.points[1] - found.points[0]).norm());
        apart.max(-self.steepest.0) + TOUCHING * self.both.size()
    }

    /// The error of a candidate (m): see the module.
    pub fn error(&self, candidate: &Candidate) -> f64 {
        candidate.certificate().max(self.steepest.0 - candidate.separation)
    }

    /// Whether the points of the best so far prove that it is exact to rounding, at least among the normals that were tried.
    pub fn is_exact(&self) -> bool {
        let dense = self.both.a.is_dense() || self.both.b.is_dense();
        let part = if dense { ROUNDING_OF_SMALL } else { ROUNDING };
        let rounding = (part * self.both.size()).max(f64::EPSILON * self.both.farthest());
        self.found.is_some_and(|found| self.error(&found) <= rounding)
    }

    /// Whether no other normal can be better: of shapes that overlap there can be several that are exact among the normals around them.
    pub fn is_global(&self) -> bool {
        self.is_exact() && self.found.is_some_and(|found| found.separation >= -TOUCHING * self.both.size())
    }

    /// Proposes points p of a and q of b (m) with the unit normal from a to b.
    pub fn offer(&mut self, normal: Vector3<f64>, points: [Vector3<f64>; 2], features: [FeatureId; 2]) {
        let separation = self.try_normal(&normal);
        let candidate = Candidate { normal, points, features, separation };
        if self.found.is_none_or(|found| self.error(&candidate) < self.error(&found)) {
            self.found = Some(candidate);
        }
    }
}
