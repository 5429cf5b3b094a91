//! Closed contacts at an instant: where two shapes touch, and the force between them.
//!
//! The unit normal n points from b to a, and f is the force on a (N). Let `f_N = n · f` and `f_T = f − f_N n`; Coulomb's cone is `|f_T| ≤ μ f_N`. A
//! gap φ (m) is negative where the shapes overlap.

use crate::description::contact_pairs::ContactPairs;
use nalgebra::Vector3;

/// Parts of a force that its components are not known to.
const ROUNDINGS: f64 = 4.0 * f64::EPSILON;

/// One point at which two shapes touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactPoint {
    /// The pair ([`ContactPair::number`](crate::description::contact::ContactPair::number)).
    pub pair: usize,
    /// In the world (m).
    pub position: Vector3<f64>,
    /// Unit vector from b to a, in the world.
    pub normal: Vector3<f64>,
    /// On a, in the world (N).
    pub force: Vector3<f64>,
    /// φ (m).
    pub gap: f64,
    /// Whether friction holds it.
    pub sticks: bool,
}

impl ContactPoint {
    /// How far the force is outside the cone (N): the larger of `|f_T| − μ f_N` and `−f_N`, not negative. Four roundings of the force, 9e-16 of it,
    /// count as zero: they are lost as the force is turned into the world and back (4e-6 N of the 4e10 N of a foot that jams).
    pub fn cone_violation(&self, friction: f64) -> f64 {
        let normal = self.normal.dot(&self.force);
        let tangential = (self.force - normal * self.normal).norm();
        let off = (tangential - friction * normal).max(-normal);
        if off > ROUNDINGS * self.force.norm() { off } else { 0.0 }
    }

    /// How deep the shapes overlap (m), not negative.
    pub fn penetration(&self) -> f64 {
        (-self.gap).max(0.0)
    }
}

/// The part of the largest force at an instant that a force may be outside its cone: more is no rounding.
const OUTSIDE: f64 = 1e-6;

/// A force that is outside its cone by more than roundings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutsideCone {
    /// How far it is outside (N).
    pub violation: f64,
    /// The largest contact force at that instant (N).
    pub largest: f64,
    /// When (s).
    pub time: f64,
    /// The pair ([`ContactPair::number`](crate::description::contact::ContactPair::number)).
    pub pair: usize,
    /// Where the shapes touch, in the world (m).
    pub position: Vector3<f64>,
}

/// The worst of the contacts of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactFigures {
    /// The deepest overlap (m).
    pub penetration: f64,
    /// The farthest of a force from its cone (N).
    pub cone_violation: f64,
    /// The farthest of a force that is outside its cone by more than roundings, if there is one.
    pub outside: Option<OutsideCone>,
}

impl ContactFigures {
    /// Takes in the contacts of an instant (s), whose pairs are among these.
    pub fn see(&mut self, time: f64, points: &[ContactPoint], pairs: &ContactPairs) {
        let largest = points.iter().map(|point| point.force.norm()).fold(0.0, f64::max);
        for point in points {
            let friction = pairs.with_number(point.pair).map_or(0.0, |pair| pair.friction);
            let violation = point.cone_violation(friction);
            let outside = OutsideCone { violation, largest, time, pair: point.pair, position: point.position };
            self.include(&ContactFigures {
                penetration: point.penetration(),
                cone_violation: violation,
                outside: Some(outside).filter(|_| violation > OUTSIDE * largest),
            });
        }
    }

    /// Adds the figures of another part of the run.
    pub fn include(&mut self, other: &ContactFigures) {
        self.penetration = self.penetration.max(other.penetration);
        self.cone_violation = self.cone_violation.max(other.cone_violation);
        let worse = |other: &OutsideCone| self.outside.is_none_or(|own| other.violation > own.violation);
        if let Some(worse) = other.outside.filter(worse) {
            self.outside = Some(worse);
        }
    }

    /// The forces alone, without the overlap.
    pub fn of_forces(&self) -> Self {
        ContactFigures { penetration: 0.0, ..*self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::contact::ContactPair;

    fn point(force: [f64; 3], gap: f64) -> ContactPoint {
        let (position, normal) = (Vector3::zeros(), Vector3::z());
        ContactPoint { pair: 3, position, normal, force: force.into(), gap, sticks: true }
    }

    #[test]
    fn a_force_in_the_cone_violates_nothing_and_one_outside_by_what_friction_lacks_or_by_its_pull() {
        for (force, violation) in [
            ([3.0, 4.0, 10.0], 0.0),
            ([3.0, 4.0, 6.0], 2.0),
            ([0.0, 0.0, -2.0], 2.0),
            ([0.0, 1.0, -2.0], 2.0),
            ([0.0, 0.0, 0.0], 0.0),
            // 2⁻¹⁸ N of 4e10 N, and 2⁻¹⁶ N: a unit in the last place, and four.
            ([2e10 + 3.814697265625e-6, 0.0, 4e10], 0.0),
            ([2e10 + 6.103515625e-5, 0.0, 4e10], 6.103515625e-5),
        ] {
            assert_eq!(point(force, 0.0).cone_violation(0.5), violation, "{force:?}");
        }
    }

    #[test]
    fn figures_keep_the_worst_of_each_with_the_friction_of_its_pair_and_its_instant() {
        let pair = |number, friction| ContactPair::without_moments(number, [0, 1], friction, 0.0);
        let mut figures = ContactFigures::default();
        let points = [point([3.0, 4.0, 6.0], 1e-3), point([0.0, 0.0, 1.0], -1e-9)];
        figures.see(0.25, &points, &vec![pair(2, 0.0), pair(3, 0.5)].into());
        let largest = 61.0_f64.sqrt();
        let outside = Some(OutsideCone { violation: 2.0, largest, time: 0.25, pair: 3, position: Vector3::zeros() });
        assert_eq!(figures, ContactFigures { penetration: 1e-9, cone_violation: 2.0, outside });
        figures.include(&ContactFigures { penetration: 1e-8, cone_violation: 1.0, outside: None });
        assert_eq!(figures, ContactFigures { penetration: 1e-8, cone_violation: 2.0, outside });
        // A millionth of the largest force is no rounding, and a part of it is.
        for (off, is_outside) in [(1.0e-6, false), (1.3e-6, true)] {
            let mut figures = ContactFigures::default();
            figures.see(
                0.5,
                &[point([5.0 + 10.0 * off, 0.0, 10.0], 0.0), point([0.0, 0.0, 10.0], 0.0)],
                &vec![pair(3, 0.5)].into(),
            );
            assert_eq!(figures.outside.is_some(), is_outside, "{figures:?}");
        }
    }
}
