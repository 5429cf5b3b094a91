//! The numbers of limits, dry friction, motors and contacts, which may carry derivatives.
//!
//! They are taken in one order, after the figures of the mechanism ([`crate::derivatives::equations::figures`]). An infinite bound has no derivative.

use crate::derivatives::equations::figures::{Frame, frame};
use crate::derivatives::numbers::number::Number;
use crate::instant::holding::elements::Elements;
use crate::mechanism::description::contact::Shape;
use crate::mechanism::description::joint::Pose;
use crate::mechanism::description::mechanism::Mechanism;

/// A joint with limits or dry friction.
#[derive(Clone, Copy, Debug)]
pub struct JointLaw<T> {
    /// rad or m.
    pub lower: T,
    pub upper: T,
    /// e.
    pub restitution: T,
    /// N m or N.
    pub friction: T,
}

/// A motor.
#[derive(Clone, Copy, Debug)]
pub struct MotorLaw<T> {
    /// N m/rad or N/m.
    pub kp: T,
    /// N m s/rad or N s/m.
    pub kd: T,
    /// Its largest effort [N m or N].
    pub bound: T,
}

/// A pair of colliders.
#[derive(Clone, Copy, Debug)]
pub struct PairLaw<T> {
    /// μ.
    pub friction: T,
    /// e.
    pub restitution: T,
}

/// A collider: its frame in the frame of its body, and its sizes (m).
#[derive(Clone, Copy, Debug)]
pub struct ColliderFigures<T> {
    pub frame: Frame<T>,
    /// The half sizes of a box; radius, radius and half length of others.
    pub sizes: [T; 3],
}

/// The numbers of all elements.
#[derive(Clone, Debug)]
pub struct Laws<T> {
    pub joints: Vec<JointLaw<T>>,
    pub motors: Vec<MotorLaw<T>>,
    pub pairs: Vec<PairLaw<T>>,
    pub colliders: Vec<ColliderFigures<T>>,
}

impl<T: Number> Laws<T> {
    /// The laws of a mechanism, each number as `take` makes it of the double; `frames` are the frames of the bodies, each in the body's own.
    pub(crate) fn taken(
        mechanism: &Mechanism,
        elements: &Elements,
        frames: &[Pose],
        take: &mut dyn FnMut(f64) -> T,
    ) -> Self {
        let mut bound = |value: f64| {
            let taken = take(if value.is_finite() { value } else { 0.0 });
            if value.is_finite() { taken } else { T::of(value) }
        };
        let joints = elements.joints.iter().map(|joint| JointLaw {
            lower: bound(joint.lower),
            upper: bound(joint.upper),
            restitution: bound(joint.restitution),
            friction: bound(joint.friction),
        });
        let joints = joints.collect();
        let motors = elements.motors.iter().map(|motor| {
            let (kp, kd) = motor.law.gains();
            MotorLaw { kp: bound(kp), kd: bound(kd), bound: bound(motor.max_effort) }
        });
        let motors = motors.collect();
        let pairs = mechanism.nonsmooth.pairs.iter();
        let pairs = pairs.map(|pair| PairLaw { friction: bound(pair.friction), restitution: bound(pair.restitution) });
        let pairs = pairs.collect();
        let colliders = mechanism.nonsmooth.colliders.iter().map(|collider| {
            let own = collider.body.map_or_else(Pose::identity, |body| frames[body].inverse());
            ColliderFigures {
                frame: frame(&(own * collider.pose), &mut *take),
                sizes: sizes(&collider.shape).map(&mut *take),
            }
        });
        let colliders = colliders.collect();
        Laws { joints, motors, pairs, colliders }
    }
}

/// The sizes of a shape (m).
fn sizes(shape: &Shape) -> [f64; 3] {
    match shape {
        Shape::Sphere { radius } => [*radius, *radius, 0.0],
        Shape::Capsule { radius, half } | Shape::Cylinder { radius, half } => [*radius, *radius, *half],
        Shape::Box { half } => [half.x, half.y, half.z],
        Shape::Ellipsoid { radii } => [radii.x, radii.y, radii.z],
        Shape::Hollow { radius } => [*radius; 3],
        Shape::HalfSpace | Shape::Point | Shape::Hull(_) | Shape::Mesh(_) => [0.0; 3],
    }
}
