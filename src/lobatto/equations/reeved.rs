//! Taut ropes through several points at all stages: the gap, and the pull of a unit tension on every body.
//!
//! ```text
//!     φ_i = L − Σ_j |P_{j+1} − P_j|           at the columns' stages i (m)
//!     a body with the points P_j:             the screw Σ_j (f_j, P_j × f_j),   f_j = u_j − u_{j−1}       at the columns' and at the rows' stages
//! ```
//!
//! P is from the common origin, u_j the direction from P_j to P_{j+1}. The multiplier of the rope is its tension, times h². A row of it touches as many
//! bodies as it has eyelets on, and each of them has a gradient of its own. Source: [`catena_mechanism::motion::reeved`].

use crate::equations::loops::Displaced;
use crate::equations::origins::common_origin;
use crate::equations::spatial_loops::{End, Moved};
use crate::numbers::algebra::{Matrix, Vector};
use crate::numbers::euclidean::Euclidean;
use crate::numbers::lanes::Lanes;
use crate::numbers::smooth_lanes::{triple, vector};
use crate::stages::start::Start;
use catena_mechanism::description::closure::Attachment;
use catena_mechanism::description::contact::TouchJoint;
use catena_mechanism::motion::reeved::reeved;

/// A taut rope through several points in a step.
#[derive(Clone)]
pub(crate) struct SpatialRope<V> {
    /// L (m).
    length: f64,
    points: Vec<RopePoint<V>>,
    /// φ at the columns' stages (m).
    gap: V,
    /// The screws on the bodies, in the order of [`TouchJoint::reeved_bodies`], at the columns' and the rows' stages.
    pulls: Vec<[[V; 6]; 2]>,
}

/// A point of a rope.
#[derive(Clone)]
struct RopePoint<V> {
    attachment: Attachment,
    /// The number of its body among the bodies of the rope; `None` in the world.
    number: Option<usize>,
    /// At the start of the step: from the common origin, and from the anchor of its body (m).
    point: [f64; 3],
    arm: [f64; 3],
    /// P at the stages in question.
    place: Vector<V>,
}

impl<V: Lanes> SpatialRope<V> {
    /// The rope that a contact is, if it is one through several points.
    pub fn new(joint: &TouchJoint) -> Option<Self> {
        let pairing = joint.touch.pairing().filter(|_| joint.is_reeved())?;
        let bodies = joint.reeved_bodies();
        let number = |body: usize| bodies.iter().position(|own| *own == body);
        let point = |attachment: &Attachment| RopePoint {
            attachment: *attachment,
            number: attachment.body.and_then(number),
            point: [0.0; 3],
            arm: [0.0; 3],
            place: Vector::zero(),
        };
        let points = joint.reeved.iter().map(point).collect();
        Some(SpatialRope {
            length: pairing.reach,
            points,
            gap: V::zero(),
            pulls: vec![[[V::zero(); 6]; 2]; bodies.len()],
        })
    }

    /// Takes the start of a step; `origins` are the common origins of the parts of all bodies (m).
    pub fn begin(&mut self, start: &Start, origins: &[[f64; 3]]) {
        let origin = common_origin(self.points.iter().map(|own| own.attachment.body), origins);
        for own in &mut self.points {
            let End { point, arm, .. } = End::new(&own.attachment, start, &origin);
            (own.point, own.arm) = (point, arm);
        }
        let still = Moved { turn: Matrix::zero(), anchor: Vector::zero() };
        for side in 0..2 {
            self.find(side, |_| &still);
        }
    }

    /// Finds gap and pulls for bodies that have moved so since the start: at the columns' and the rows' stages.
    #[inline(always)]
    pub fn place(&mut self, moved: &[[Moved<V>; 2]]) {
        for side in 0..2 {
            self.find(side, |body| &moved[body][side]);
        }
    }

    /// At the columns' (0) or the rows' (1) stages.
    #[inline(always)]
    fn find<'m>(&mut self, side: usize, moved: impl Fn(usize) -> &'m Moved<V>)
    where
        V: 'm,
    {
        let SpatialRope { points, pulls, .. } = self;
        for own in points.iter_mut() {
            own.place = Vector::splat(&own.point);
            if let Some(body) = own.attachment.body {
                own.place = own.place.plus(moved(body).displacement(&own.arm));
            }
        }
        pulls.iter_mut().for_each(|pull| pull[side] = [V::zero(); 6]);
        let points = &*points;
        let long = reeved(
            points.len(),
            |index| triple(points[index].place),
            |index, along| {
                let RopePoint { number, place, .. } = &points[index];
                if let Some(number) = number {
                    let along = vector(along);
                    let screw = along.joined(place.cross(along));
                    for (sum, part) in pulls[*number][side].iter_mut().zip(screw) {
                        *sum = *sum + part;
                    }
                }
            },
        );
        if side == 0 {
            self.gap = V::splat(self.length) - long.0;
        }
    }

    /// φ at the columns' stages (m).
    pub fn gap(&self) -> V {
        self.gap
    }

    /// The screws on its bodies, at the columns' and the rows' stages.
    pub fn pulls(&self) -> &[[[V; 6]; 2]] {
        &self.pulls
    }
}
