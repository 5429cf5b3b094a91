//! Pairs of shapes that cannot meet, by proof.
//!
//! **Reach.** A root joint of a tree holds the point A of the world. Let `a_i` be the origin of the joint frame of body i. All points of a shape on
//! body k of the chain 1 … k stay within
//!
//! ```text
//!     D = Σ (|a_i+1 − a_i| + t_i) + |c − a_k| + ρ        of A   [m]
//! ```
//!
//! where `t_i` is the largest travel of joint i (0 of one that only turns, the larger of |lower| and |upper| of a limited slide, else ∞), c the
//! origin of the shape and ρ its radius about c. Two shapes whose distance of A to A' exceeds D + D' never meet, nor does one with an
//! obstacle that is farther than D from A.
//!
//! **Level.** Where all joints of the chain turn about the normal n of a half space, the heights n · p of all points are constant: the shape
//! never meets it if its least height is positive at any position.

use crate::mechanism::description::body_state::{BodyState, WORLD};
use crate::mechanism::description::contact::{Collider, Shape};
use crate::mechanism::description::joint::{JointKind, Pose};
use crate::mechanism::description::mechanism::Mechanism;
use nalgebra::Vector3;

/// The relative rounding error of a bound.
const MARGIN: f64 = 1e-9;

/// A ball of the world in which all points of something stay.
#[derive(Clone, Copy, Debug)]
struct Ball {
    center: Vector3<f64>,
    radius: f64,
}

/// The proofs for one mechanism.
pub(crate) struct ContactReach<'m> {
    mechanism: &'m Mechanism,
    /// For each body the ball in which the origin of its joint frame stays.
    joints: Vec<Ball>,
    /// Any position of the bodies.
    placed: Vec<BodyState>,
}

impl<'m> ContactReach<'m> {
    /// For a mechanism whose bodies are somewhere.
    pub fn new(mechanism: &'m Mechanism, placed: Vec<BodyState>) -> Self {
        let mut joints: Vec<Ball> = Vec::with_capacity(mechanism.bodies.len());
        for (index, body) in mechanism.bodies.iter().enumerate() {
            let on_parent = body.joint.on_parent.translation.vector;
            let before = match body.parent {
                None => Ball { center: on_parent, radius: 0.0 },
                Some(parent) => {
                    let arm = on_parent - mechanism.bodies[parent].joint.on_child.translation.vector;
                    Ball { center: joints[parent].center, radius: joints[parent].radius + arm.norm() }
                }
            };
            joints.push(Ball { radius: before.radius + travel(mechanism, index), ..before });
        }
        ContactReach { mechanism, joints, placed }
    }

    /// The mechanism.
    pub fn mechanism(&self) -> &'m Mechanism {
        self.mechanism
    }

    /// Whether a collider may come to every place that moving bodies come to.
    pub fn roams(&self, collider: &Collider) -> bool {
        collider.body.is_some() && self.ball(collider).radius == f64::INFINITY
    }

    /// Whether two colliders never meet.
    pub fn never_meet(&self, a: &Collider, b: &Collider) -> bool {
        let (ball_a, ball_b) = (self.ball(a), self.ball(b));
        let apart = match (a.body, b.body) {
            (_, None) => distance_to_fixed(&ball_a.center, b),
            (None, _) => distance_to_fixed(&ball_b.center, a),
            _ => (ball_a.center - ball_b.center).norm(),
        };
        let reach = match (a.body, b.body) {
            (_, None) => ball_a.radius,
            (None, _) => ball_b.radius,
            _ => ball_a.radius + ball_b.radius,
        };
        let scale = reach + ball_a.center.norm() + ball_b.center.norm();
        apart > reach + MARGIN * scale || self.stays_above(a, b, scale) || self.stays_above(b, a, scale)
    }

    /// The ball in which all points of a collider stay.
    fn ball(&self, collider: &Collider) -> Ball {
        let center = collider.pose.translation.vector;
        let radius = radius(&collider.shape);
        match collider.body {
            None => Ball { center, radius },
            Some(body) => {
                let arm = center - self.mechanism.bodies[body].joint.on_child.translation.vector;
                let Ball { center, radius: of_joint } = self.joints[body];
                Ball { center, radius: of_joint + arm.norm() + radius }
            }
        }
    }

    /// Whether a collider keeps a positive height over a half space of the world.
    fn stays_above(&self, collider: &Collider, ground: &Collider, scale: f64) -> bool {
        if ground.shape != Shape::HalfSpace || ground.body.is_some() || !scale.is_finite() {
            return false;
        }
        let normal = ground.pose.rotation.matrix().column(2).into_owned();
        let mut above = collider.body;
        while let Some(body) = above {
            let Joint { kind, axis } = self.joint(body);
            if kind != JointKind::Revolute || axis.cross(&normal).norm() > MARGIN * MARGIN.sqrt() {
                return false;
            }
            above = self.mechanism.bodies[body].parent;
        }
        let place = collider.body.map_or(&WORLD, |body| &self.placed[body]);
        let center = place.position + place.rotation * collider.pose.translation.vector;
        let turn = place.rotation * collider.pose.rotation.matrix();
        let height = normal.dot(&(center - ground.pose.translation.vector));
        height - extent(&collider.shape, &(turn.transpose() * -normal)) > MARGIN * scale
    }

    /// The kind of the joint of a body, and its axis in the world.
    fn joint(&self, body: usize) -> Joint {
        let joint = &self.mechanism.bodies[body].joint;
        let axis = self.placed[body].rotation * joint.on_child.rotation.matrix().column(2);
        Joint { kind: joint.kind, axis }
    }
}

struct Joint {
    kind: JointKind,
    axis: Vector3<f64>,
}

/// How far the joint of a body can take its child along (m).
fn travel(mechanism: &Mechanism, body: usize) -> f64 {
    match mechanism.bodies[body].joint.kind {
        JointKind::Revolute | JointKind::Spherical => 0.0,
        JointKind::Prismatic => {
            let limit = mechanism.nonsmooth.limits.iter().find(|limit| limit.coordinate.body == body);
            limit.map_or(f64::INFINITY, |limit| limit.lower.abs().max(limit.upper.abs()))
        }
        JointKind::Planar | JointKind::Floating => f64::INFINITY,
    }
}

/// The largest distance of a point of a shape from its origin (m).
fn radius(shape: &Shape) -> f64 {
    let farthest = |points: &[Vector3<f64>]| points.iter().map(Vector3::norm).fold(0.0, f64::max);
    match shape {
        Shape::HalfSpace => f64::INFINITY,
        Shape::Sphere { radius } => *radius,
        Shape::Capsule { radius, half } => radius + half,
        Shape::Cylinder { radius, half } => radius.hypot(*half),
        Shape::Box { half } => half.norm(),
        Shape::Ellipsoid { radii } => radii.max(),
        Shape::Hollow { .. } => f64::INFINITY,
        Shape::Point => 0.0,
        Shape::Hull(points) => farthest(points),
        Shape::Mesh(surface) => farthest(&surface.vertices),
    }
}

/// The support of a shape: the largest `d · p` of its points p, in its frame, for a unit vector d (m).
fn extent(shape: &Shape, direction: &Vector3<f64>) -> f64 {
    let farthest = |points: &[Vector3<f64>]| points.iter().map(|p| p.dot(direction)).fold(f64::NEG_INFINITY, f64::max);
    match shape {
        Shape::HalfSpace => f64::INFINITY,
        Shape::Sphere { radius } => *radius,
        Shape::Capsule { radius, half } => radius + half * direction.z.abs(),
        Shape::Cylinder { radius, half } => radius * direction.xy().norm() + half * direction.z.abs(),
        Shape::Box { half } => half.dot(&direction.abs()),
        Shape::Ellipsoid { radii } => radii.component_mul(direction).norm(),
        Shape::Hollow { .. } => f64::INFINITY,
        Shape::Point => 0.0,
        Shape::Hull(points) => farthest(points),
        Shape::Mesh(surface) => farthest(&surface.vertices),
    }
}

/// No more than the distance of a point of the world to a collider of the world (m): to the box about it along its axes, or to the half space.
fn distance_to_fixed(point: &Vector3<f64>, collider: &Collider) -> f64 {
    let Pose { translation, rotation } = &collider.pose;
    let local = rotation.inverse_transform_vector(&(point - translation.vector));
    if collider.shape == Shape::HalfSpace {
        return local.z;
    }
    let outside = Vector3::from_fn(|axis, _| {
        let (along, back) = (Vector3::ith(axis, 1.0), Vector3::ith(axis, -1.0));
        (local[axis] - extent(&collider.shape, &along)).max(-local[axis] - extent(&collider.shape, &back)).max(0.0)
    });
    outside.norm()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanism::description::mechanism::Body;
    use crate::mechanism::motion::kinematics::body_states;
    use crate::mechanism::motion::state::State;
    use nalgebra::{Rotation3, Translation3};

    fn at(x: f64, y: f64, z: f64) -> Pose {
        Pose::from_parts(Translation3::new(x, y, z), Rotation3::identity())
    }

    /// Two links of one metre with their joints at their lower ends, the first of which stands at the origin.
    fn arm(kinds: [JointKind; 2], turned: Pose) -> Mechanism {
        let body = |parent: Option<usize>, kind, on_parent| Body {
            name: "link".to_string(),
            parent,
            mass: 1.0,
            inertia: Vector3::repeat(1.0),
            joint: crate::mechanism::description::joint::Joint::new(
                "joint",
                kind,
                on_parent,
                at(0.0, 0.0, -0.5) * turned,
            ),
        };
        let bodies = vec![body(None, kinds[0], turned), body(Some(0), kinds[1], at(0.0, 0.0, 0.5) * turned)];
        Mechanism::new("arm", Vector3::zeros(), bodies).expect("an arm")
    }

    fn never_meet(mechanism: &Mechanism, a: &Collider, b: &Collider) -> bool {
        let state = State::zero(mechanism);
        ContactReach::new(mechanism, body_states(mechanism, &state)).never_meet(a, b)
    }

    fn collider(body: Option<usize>, shape: Shape, pose: Pose) -> Collider {
        Collider::still("", body, pose, shape)
    }

    #[test]
    fn a_shape_reaches_as_far_as_the_links_above_it_are_long_and_no_farther() {
        // The end of the second link is 2 m from the base, and its ball of 0.1 m is about that.
        let ball = collider(Some(1), Shape::Sphere { radius: 0.1 }, at(0.0, 0.0, 0.5));
        let across = Pose::from_parts(Translation3::identity(), Rotation3::from_euler_angles(1.5, 0.0, 0.0));
        let turning = arm([JointKind::Revolute, JointKind::Spherical], across);
        for (distance, never) in [(2.09, false), (2.11, true)] {
            let floor = collider(None, Shape::HalfSpace, at(0.0, 0.0, -distance));
            let wall = collider(None, Shape::Box { half: Vector3::repeat(0.5) }, at(distance + 0.5, 0.0, 0.0));
            let pin = collider(None, Shape::Cylinder { radius: 0.2, half: 0.3 }, at(0.0, -distance - 0.2, 0.0));
            for fixed in [floor, wall, pin] {
                assert_eq!(never_meet(&turning, &ball, &fixed), never, "{distance} {fixed:?}");
                assert_eq!(never_meet(&turning, &fixed, &ball), never, "{distance} {fixed:?}");
            }
        }
        for kind in [JointKind::Floating, JointKind::Prismatic, JointKind::Planar] {
            let far = collider(None, Shape::Sphere { radius: 0.1 }, at(1e6, 0.0, 0.0));
            assert!(!never_meet(&arm([JointKind::Revolute, kind], across), &ball, &far), "{kind:?}");
        }
    }

    #[test]
    fn what_only_turns_about_the_normal_of_a_floor_keeps_its_height() {
        let upright = arm([JointKind::Revolute; 2], Pose::identity());
        let tilted = arm([JointKind::Revolute; 2], at(0.0, 0.0, 0.0) * Rotation3::from_euler_angles(0.1, 0.0, 0.0));
        // The lower end of the second link is at 1 m, and the ball of 0.3 m about it ends at 0.7 m.
        let ball = collider(Some(1), Shape::Sphere { radius: 0.3 }, at(0.0, 0.0, -0.5));
        for (height, never) in [(0.69, true), (0.71, false)] {
            let floor = collider(None, Shape::HalfSpace, at(0.0, 0.0, height));
            assert_eq!(never_meet(&upright, &ball, &floor), never, "{height}");
            assert!(!never_meet(&tilted, &ball, &floor), "{height}");
        }
    }
}
