//! Ropes through several points, as pairs that touch where they are taut.

use crate::geometry::{PairGeometry, TouchPlace};
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::closure::Attachment;
use crate::mechanism::description::contact::{Cores, TouchJoint};
use crate::mechanism::description::joint::Pose;
use crate::mechanism::motion::reeved::rope_length;
use nalgebra::{Rotation3, Translation3, Vector3};

/// Whether a contact is a rope.
pub(crate) fn is_rope(joint: &TouchJoint) -> bool {
    joint.touch.pairing().is_some_and(|pairing| pairing.cores == Cores::Hollow)
}

/// The rounding of the gap of a rope through several points, as a part of its length.
pub(super) const ROUNDED: f64 = 1e-13;

/// Two bodies, and how far they reach (m).
pub(crate) type Part = ([Option<usize>; 2], [f64; 2]);

/// A rope through several points ([`crate::mechanism::motion::reeved`]).
#[derive(Clone)]
pub(super) struct Rope {
    /// m.
    pub length: f64,
    pub points: Vec<Attachment>,
    /// Where two of its points on different bodies are, as of a rope between them.
    pub place: TouchPlace,
}

impl Rope {
    /// A rope of this length (m) through points, with the geometry of its pair; `None` if all points are on one body.
    pub fn new(points: &[Attachment], length: f64, geometry: &PairGeometry) -> Option<Self> {
        let apart = |shift: Vector3<f64>| {
            let moved = Pose::from_parts(Translation3::from(shift), Rotation3::identity());
            geometry.touches(&Pose::identity(), &moved, f64::INFINITY).pop()
        };
        let place = [Vector3::zeros(), Vector3::x()].into_iter().find_map(apart)?;
        Some(Rope { length, points: points.to_vec(), place })
    }

    /// Its parts between points on different bodies.
    pub fn parts(&self) -> Vec<Part> {
        let ends = self.points.windows(2).map(|ends| [0, 1].map(|end: usize| ends[end]));
        let apart = ends.filter(|[one, other]| one.body != other.body);
        apart.map(|ends| (ends.map(|end| end.body), ends.map(|end| end.frame.translation.vector.norm()))).collect()
    }

    /// φ (m).
    pub fn gap(&self, bodies: &[BodyState]) -> f64 {
        self.length - rope_length(&self.points, bodies)
    }
}
