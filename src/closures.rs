//! Gaps of loop joints and mimics at one instant, from the maximal coordinates alone: the check of every run.
//!
//! Equations as in the table of [`crate::model::LoopJoint`]; rates by differentiating them. With `d = P_b − P_a`,
//!
//! ```text
//!     d/dt (d · u_a)   = ḋ · u_a + d · (ω_a × u_a)            [m/s]
//!     d/dt (u_a · w_b) = (ω_a − ω_b) · (u_a × w_b)            [rad/s]
//!     d/dt (d·d − L²)/2L = d · ḋ / L                          [m/s]
//! ```

use crate::kinematics::WORLD;
use crate::model::{Attachment, LoopJoint, LoopKind, Mimic};
use crate::state::{BodyState, State};
use nalgebra::{Matrix3, Vector3};

/// The gaps of one closure and their rates; the first `count` entries are in use.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gaps {
    /// Number of equations.
    pub count: usize,
    /// `g`: m, or sines of angles.
    pub position: [f64; 6],
    /// `ġ`: m/s, or rad/s.
    pub velocity: [f64; 6],
}

impl Gaps {
    fn push(&mut self, position: f64, velocity: f64) {
        self.position[self.count] = position;
        self.velocity[self.count] = velocity;
        self.count += 1;
    }

    /// The largest gap and the largest rate.
    pub fn largest(&self) -> (f64, f64) {
        let of = |numbers: &[f64; 6]| numbers[..self.count].iter().fold(0.0_f64, |most, gap| most.max(gap.abs()));
        (of(&self.position), of(&self.velocity))
    }
}

/// One end of a loop in the world.
struct End {
    point: Vector3<f64>,
    rate: Vector3<f64>,
    axes: Matrix3<f64>,
    spin: Vector3<f64>,
}

impl End {
    fn new(end: &Attachment, bodies: &[BodyState]) -> Self {
        let body = end.body.map_or(&WORLD, |body| &bodies[body]);
        let arm = body.rotation * end.frame.translation.vector;
        End {
            point: body.position + arm,
            rate: body.velocity + body.angular_velocity.cross(&arm),
            axes: body.rotation * end.frame.rotation.matrix(),
            spin: body.angular_velocity,
        }
    }

    fn axis(&self, axis: usize) -> Vector3<f64> {
        self.axes.column(axis).into_owned()
    }
}

/// The gaps of a loop joint.
pub fn loop_gaps(joint: &LoopJoint, bodies: &[BodyState]) -> Gaps {
    let (a, b) = (End::new(&joint.a, bodies), End::new(&joint.b, bodies));
    let (apart, rate) = (b.point - a.point, b.rate - a.rate);
    let mut gaps = Gaps::default();
    let slides: &[usize] = match joint.kind {
        LoopKind::Revolute | LoopKind::Universal | LoopKind::Spherical | LoopKind::Fixed => &[0, 1, 2],
        LoopKind::Prismatic | LoopKind::Cylindrical => &[0, 1],
        LoopKind::Planar => &[2],
        LoopKind::Distance(_) => &[],
    };
    for &axis in slides {
        let along = a.axis(axis);
        gaps.push(apart.dot(&along), rate.dot(&along) + apart.dot(&a.spin.cross(&along)));
    }
    let squares: &[(usize, usize)] = match joint.kind {
        LoopKind::Revolute | LoopKind::Cylindrical | LoopKind::Planar => &[(0, 2), (1, 2)],
        LoopKind::Prismatic | LoopKind::Fixed => &[(0, 2), (1, 2), (1, 0)],
        LoopKind::Universal => &[(2, 2)],
        LoopKind::Spherical | LoopKind::Distance(_) => &[],
    };
    for &(on_a, on_b) in squares {
        let (first, second) = (a.axis(on_a), b.axis(on_b));
        gaps.push(first.dot(&second), (a.spin - b.spin).dot(&first.cross(&second)));
    }
    if let LoopKind::Distance(length) = joint.kind {
        gaps.push((apart.norm_squared() - length * length) / (2.0 * length), apart.dot(&rate) / length);
    }
    gaps
}

/// The gap of a mimic relation (rad or m) and its rate.
pub fn mimic_gap(mimic: &Mimic, state: &State) -> (f64, f64) {
    let gap = state.position[mimic.follower.position]
        - mimic.multiplier * state.position[mimic.leader.position]
        - mimic.offset;
    let rate = state.velocity[mimic.follower.freedom] - mimic.multiplier * state.velocity[mimic.leader.freedom];
    (gap, rate)
}
