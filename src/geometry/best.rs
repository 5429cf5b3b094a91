//! The best of several candidates: the one of the largest separation.

use crate::both::{Both, Candidate};
use crate::feature::FeatureId;
use nalgebra::Vector3;

/// Depths below this, relative to the size, differ by no more than this.
const TOUCHING: f64 = 1e-9;

/// Proposals between two convex shapes, of which the best is kept.
pub struct Best<'a> {
    both: &'a Both<'a>,
    found: Option<Candidate>,
    /// The largest separation (m) of all normals that were tried, and that normal.
    steepest: (f64, Vector3<f64>),
}

impl<'a> Best<'a> {
    /// None yet.
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

    /// Whether the points of the best so far prove that it is exact to rounding, at least among the normals around it.
    pub fn is_exact(&self) -> bool {
        self.found.is_some_and(|found| found.certificate() <= 2e-14 * self.both.size())
    }

    /// Whether no other normal can be better: of shapes that overlap there can be several that are exact among the normals around them.
    pub fn is_global(&self) -> bool {
        self.is_exact() && self.found.is_some_and(|found| found.separation >= -TOUCHING * self.both.size())
    }

    /// Proposes points p of a and q of b (m) with the unit normal from a to b.
    pub fn offer(&mut self, normal: Vector3<f64>, points: [Vector3<f64>; 2], features: [FeatureId; 2]) {
        let separation = self.try_normal(&normal);
        let candidate = Candidate { normal, points, features, separation };
        // Of two normals that separate as well the one whose points face each other.
        let rounding = 1e-15 * self.both.size();
        let better = self.found.is_none_or(|found| {
            separation > found.separation + rounding
                || (separation >= found.separation - rounding && candidate.certificate() < found.certificate())
        });
        if better {
            self.found = Some(candidate);
        }
    }
}
