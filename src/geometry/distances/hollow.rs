//! A rope: a ball from inside, about the point where one end is tied, and the point where the other one is.
//!
//! ```text
//!     distance = L − |q − c|        n = (c − q)/|c − q|
//! ```
//!
//! L is the length of the rope, c and q are its ends (m). A distance of zero is a taut rope, a negative one would be a longer rope.

use crate::features::both::Candidate;
use crate::features::feature::{FeatureId, Part};
use crate::features::meet::{Guess, meet};
use nalgebra::Vector3;

/// A rope in the frame of the body to which its first end is tied.
#[derive(Clone, Debug, PartialEq)]
pub struct Hollow {
    /// c (m).
    pub centre: Vector3<f64>,
    /// L (m).
    pub length: f64,
}

impl Hollow {
    /// All points that it holds, from inside.
    pub fn part(&self) -> Part {
        Part::Hollow(self.centre, self.length)
    }

    /// The other end at a point (m), and the point of the ball beyond it.
    pub fn nearest(&self, q: &Vector3<f64>) -> Candidate {
        let guess = Guess { normal: Vector3::z(), point: *q, at_point: false };
        let found = meet(&self.part(), &Part::Point(*q), &guess);
        let (normal, points) = found.unwrap_or((Vector3::repeat(f64::NAN), [Vector3::repeat(f64::NAN); 2]));
        let separation = normal.dot(&(points[1] - points[0]));
        Candidate { normal, points, features: [FeatureId::Face(0), FeatureId::Vertex(0)], separation }
    }
}
