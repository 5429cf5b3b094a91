//! Wheels: shapes of revolution that turn about their own axes, up to roundings of the file ([`Rule::Wheels`]).
//!
//! Files turn the cylinder of a wheel by 1.57 or 1.5707963 rad instead of π/2. The wheel then wobbles by micrometres, its rims meet the floor in turns, and
//! four wheels on a floor rock over the gaps between them. No wheel is made so: its shape is turned about its centre onto the axis of its hinge.
//!
//! ```text
//!     θ = ∠(z of the shape, ±a) ≤ 1e-3 rad,    δ = |(1 − a aᵀ)(c − p)| ≤ 1e-6 r          c ← c − (1 − a aᵀ)(c − p),   z ← ±a
//!     no point of the surface moves farther than  2 sin(θ/2) R + δ
//! ```
//!
//! with the centre c of the shape, its radius r and its farthest point R from c (m), the point p and the direction a of the axis of the joint by which
//! its body hangs on others. A ball has no axis of its own: its centre alone is moved. All else stays as the file says, the inertia too.

use crate::mechanism::description::contact::{Collider, Shape};
use crate::mechanism::description::joint::{JointKind, Pose};
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::description::rules::Rule;
use crate::model::description::robot_model::Model;
use nalgebra::{Rotation3, Translation3, Vector3};

/// The largest angle between the axes (rad): angles of files are rounded to three digits or more.
const TILT: f64 = 1e-3;
/// The largest distance of the centre from the axis, as a part of the radius.
const BESIDE: f64 = 1e-6;
/// Shapes that move by less than this part of their size stay where they are: compositions of frames round by as much.
const NOTHING: f64 = 1e-13;

/// A shape that was turned onto the axis of its joint.
#[derive(Clone, Debug, PartialEq)]
pub struct Wheel {
    /// Its number among the colliders.
    pub collider: usize,
    /// Its frame in its body where the file puts it.
    pub written: Pose,
    /// The angle between the axes there (rad).
    pub angle: f64,
    /// The most that a point of its surface was moved (m).
    pub moved: f64,
}

/// Radius and farthest point from the centre of a shape of revolution about z (m); `None` for other shapes.
fn round(shape: &Shape) -> Option<(f64, f64)> {
    match *shape {
        Shape::Sphere { radius } => Some((radius, radius)),
        Shape::Capsule { radius, half } => Some((radius, radius + half)),
        Shape::Cylinder { radius, half } => Some((radius, radius.hypot(half))),
        _ => None,
    }
}

/// Turns all wheels onto the axes of their joints; says which, and where the files put them.
pub(crate) fn turned_onto_axes(mechanism: &Mechanism, colliders: &mut [Collider]) -> Vec<Wheel> {
    let mut wheels = Vec::new();
    for (number, collider) in colliders.iter_mut().enumerate() {
        let (Some(body), Some((radius, farthest))) = (collider.body, round(&collider.shape)) else { continue };
        let joint = &mechanism.bodies[body].joint;
        if joint.kind != JointKind::Revolute {
            continue;
        }
        let written = collider.pose;
        let axis: Vector3<f64> = joint.on_child.rotation.matrix().column(2).into();
        let own: Vector3<f64> = written.rotation.matrix().column(2).into();
        let axis = if own.dot(&axis) < 0.0 { -axis } else { axis };
        let across = own.cross(&axis);
        // A ball is turned onto any axis as it is.
        let is_ball = matches!(collider.shape, Shape::Sphere { .. });
        let angle = if is_ball { 0.0 } else { across.norm().atan2(own.dot(&axis)) };
        let arm = written.translation.vector - joint.on_child.translation.vector;
        let beside = arm - axis * axis.dot(&arm);
        let moved = 2.0 * (0.5 * angle).sin() * farthest + beside.norm();
        if angle > TILT || beside.norm() > BESIDE * radius || moved <= NOTHING * farthest {
            continue;
        }
        if angle > 0.0 {
            let turn = Rotation3::new(across.normalize() * angle);
            // The axis to the last bit, and two directions across it.
            let x: Vector3<f64> = (turn * written.rotation).matrix().column(0).into();
            let x = (x - axis * axis.dot(&x)).normalize();
            let columns = nalgebra::Matrix3::from_columns(&[x, axis.cross(&x), axis]);
            collider.pose.rotation = Rotation3::from_matrix_unchecked(columns);
        }
        collider.pose.translation = Translation3::from(written.translation.vector - beside);
        wheels.push(Wheel { collider: number, written, angle, moved });
    }
    wheels
}

impl Model {
    /// Simulates the model without the rules that have simplified it already, as far as they are switched off.
    pub fn keep(&mut self, rules: &[Rule]) {
        if rules.contains(&Rule::Wheels) && !self.contact.wheels.is_empty() {
            for wheel in std::mem::take(&mut self.contact.wheels) {
                self.mechanism.nonsmooth.colliders[wheel.collider].pose = wheel.written;
            }
            // Shapes that are out of reach of each other were so where they are now.
            self.forget_reach();
        }
    }
}
