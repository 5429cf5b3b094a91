//! Closures: joints that close loops, and joints that mimic others. The tree of joints has no place for them.
//!
//! Both stay equations `g(q) = 0` with multipliers. A loop joint holds two frames `a` and `b`, each fixed in a body or in the
//! world, with origins `P_a`, `P_b` (m) and axes `x, y, z`; `z` is the axis of the joint, as for tree joints:
//!
//! | kind        | rows | g(q)                                                                |
//! |-------------|------|---------------------------------------------------------------------|
//! | revolute    | 5    | `P_b − P_a`, `z_b·x_a`, `z_b·y_a`                                   |
//! | prismatic   | 5    | `(P_b − P_a)·x_a`, `(P_b − P_a)·y_a`, `z_b·x_a`, `z_b·y_a`, `x_b·y_a` |
//! | cylindrical | 4    | `(P_b − P_a)·x_a`, `(P_b − P_a)·y_a`, `z_b·x_a`, `z_b·y_a`          |
//! | universal   | 4    | `P_b − P_a`, `z_a·z_b`                                              |
//! | spherical   | 3    | `P_b − P_a`                                                         |
//! | planar      | 3    | `(P_b − P_a)·z_a`, `z_b·x_a`, `z_b·y_a`                             |
//! | fixed       | 6    | `P_b − P_a`, `z_b·x_a`, `z_b·y_a`, `x_b·y_a`                        |
//! | distance    | 1    | `(|P_b − P_a|² − L²) / 2L`                                          |

use crate::description::body_state::{BodyState, WORLD};
use crate::description::joint::Pose;
use crate::description::target::Target;
use crate::ground::matrices::{cross, product, times};
use nalgebra::{Matrix3, Vector3};

/// A frame fixed in a body or in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Attachment {
    /// The body; `None` is the world.
    pub body: Option<usize>,
    /// The frame in the body frame, or in the world.
    pub frame: Pose,
}

impl Attachment {
    /// Origin (m) and axes (as columns) of the frame in the world.
    pub fn place(&self, bodies: &[BodyState]) -> (Vector3<f64>, Matrix3<f64>) {
        (self.point(bodies).0, self.axes(bodies))
    }

    /// Place (m) and velocity [m/s] of the origin in the world.
    pub fn point(&self, bodies: &[BodyState]) -> (Vector3<f64>, Vector3<f64>) {
        let body = self.on(bodies);
        let arm = times(&body.rotation, &self.frame.translation.vector);
        (body.position + arm, body.velocity + cross(&body.angular_velocity, &arm))
    }

    /// Axes (as columns) in the world.
    pub fn axes(&self, bodies: &[BodyState]) -> Matrix3<f64> {
        product(&self.on(bodies).rotation, self.frame.rotation.matrix())
    }

    /// The body in which it is fixed.
    pub fn on<'b>(&self, bodies: &'b [BodyState]) -> &'b BodyState {
        self.body.map_or(&WORLD, |body| &bodies[body])
    }
}

/// Which relative motions a loop joint leaves free; see the table of the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LoopKind {
    /// Rotation about z.
    Revolute,
    /// Translation along z.
    Prismatic,
    /// Rotation about z and translation along it.
    Cylindrical,
    /// Rotations about `z_a` and `z_b`, which stay perpendicular and meet.
    Universal,
    /// Every rotation.
    Spherical,
    /// Translations along x and y, and rotation about z.
    Planar,
    /// Nothing.
    Fixed,
    /// Everything but the distance of the origins (m), which is positive.
    Distance(f64),
}

impl LoopKind {
    /// The axes of a (0 = x, 1 = y, 2 = z) along which the points coincide: the first equations.
    pub fn slides(self) -> &'static [usize] {
        match self {
            LoopKind::Revolute | LoopKind::Universal | LoopKind::Spherical | LoopKind::Fixed => &[0, 1, 2],
            LoopKind::Prismatic | LoopKind::Cylindrical => &[0, 1],
            LoopKind::Planar => &[2],
            LoopKind::Distance(_) => &[],
        }
    }

    /// The axes of a and of b that are orthogonal to each other: the equations after the points.
    pub fn squares(self) -> &'static [(usize, usize)] {
        match self {
            LoopKind::Revolute | LoopKind::Cylindrical | LoopKind::Planar => &[(0, 2), (1, 2)],
            LoopKind::Prismatic | LoopKind::Fixed => &[(0, 2), (1, 2), (1, 0)],
            LoopKind::Universal => &[(2, 2)],
            LoopKind::Spherical | LoopKind::Distance(_) => &[],
        }
    }

    /// Number of equations.
    pub fn rows(self) -> usize {
        self.slides().len() + self.squares().len() + usize::from(matches!(self, LoopKind::Distance(_)))
    }

    /// The name, as scene files write it.
    pub fn name(self) -> &'static str {
        match self {
            LoopKind::Revolute => "revolute",
            LoopKind::Prismatic => "prismatic",
            LoopKind::Cylindrical => "cylindrical",
            LoopKind::Universal => "universal",
            LoopKind::Spherical => "spherical",
            LoopKind::Planar => "planar",
            LoopKind::Fixed => "fixed",
            LoopKind::Distance(_) => "distance",
        }
    }
}

/// A joint between two bodies that the tree already connects, or between a body and the world.
#[derive(Clone, Debug, PartialEq)]
pub struct LoopJoint {
    /// Its name.
    pub name: String,
    /// The motions that it leaves free.
    pub kind: LoopKind,
    /// The frame on the first body.
    pub a: Attachment,
    /// The frame on the second body.
    pub b: Attachment,
}

/// One scalar coordinate of a tree joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Coordinate {
    /// The body whose joint it belongs to.
    pub body: usize,
    /// Its entry in the position vector.
    pub position: usize,
    /// Its entry in the velocity vector.
    pub freedom: usize,
}

/// `g(q) = q_follower − multiplier · q_leader − offset = 0` between two scalar joint coordinates (rad or m, unwrapped), or with more leaders
/// `g(q) = q_follower − Σ multiplier_i · q_i − offset = 0`. A joint that is moved in time leads itself with the multiplier zero:
/// `g(q, t) = q − r(t) = 0`, so that the hidden equation is `q̇ = ṙ(t)`, and that of accelerations `q̈ = r̈(t)`.
#[derive(Clone, Debug, PartialEq)]
pub struct Mimic {
    /// Name of the following joint.
    pub name: String,
    /// The coordinate that follows.
    pub follower: Coordinate,
    /// The coordinate that leads.
    pub leader: Coordinate,
    /// Ratio of the displacements.
    pub multiplier: f64,
    /// The follower's position where all leaders are at zero.
    pub offset: f64,
    /// More leaders, each with the ratio of the displacements; mostly there are none.
    pub more: Vec<(Coordinate, f64)>,
    /// r(t), which adds to the offset: the joint is moved in time.
    pub over_time: Option<Target>,
}

impl Mimic {
    /// The coordinates of the relation with their coefficients in g: the follower first.
    pub fn terms(&self) -> impl Iterator<Item = (Coordinate, f64)> {
        let more = self.more.iter().map(|&(own, ratio)| (own, -ratio));
        let leader = (!self.is_moved()).then_some((self.leader, -self.multiplier));
        std::iter::once((self.follower, 1.0)).chain(leader).chain(more)
    }

    /// The equation of a joint that is moved in time.
    pub fn moved(name: String, joint: Coordinate, motion: Target) -> Self {
        let (follower, leader) = (joint, joint);
        Mimic { name, follower, leader, multiplier: 0.0, offset: 0.0, more: Vec::new(), over_time: Some(motion) }
    }

    /// Whether its joint is moved in time.
    pub fn is_moved(&self) -> bool {
        self.over_time.is_some()
    }

    /// r, ṙ and r̈ at a time, of the curve that begins at or before `since` (s); zeros if no joint is moved.
    pub fn motion(&self, since: f64, time: f64) -> [f64; 3] {
        self.over_time.as_ref().map_or([0.0; 3], |motion| motion.motion(since, time))
    }
}

/// The allowed range of a scalar joint coordinate (rad or m).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLimit {
    /// The coordinate.
    pub coordinate: Coordinate,
    /// Smallest position.
    pub lower: f64,
    /// Largest position.
    pub upper: f64,
    /// The part of the rate that an impact on it gives back, from 0 to 1.
    pub restitution: f64,
}
