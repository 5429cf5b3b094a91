//! Wheels: shapes of revolution that turn about their own axes, up to roundings of the file: the rule `wheels`.
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
use nalgebra::{Rotation3, Translation3, Vector3};

/// The largest angle between the axes (rad): angles of files are rounded to three digits or more.
const TILT: f64 = 1e-3;
/// The largest distance of the centre from the axis, as a part of the radius.
const BESIDE: f64 = 1e-6;
/// Shapes that move by less than this part of their size are on their axes and stay where they are: compositions of frames round by as much.
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

/// How a shape of revolution lies on the axis of the hinge of its body.
struct Mounting {
    /// The axis a of the hinge, and the angle from the axis of the shape to it (rad).
    axis: Vector3<f64>,
    across: Vector3<f64>,
    angle: f64,
    /// From the axis to the centre (m).
    beside: Vector3<f64>,
    radius: f64,
    farthest: f64,
}

impl Mounting {
    /// Of a collider; `None` for other shapes, and where no hinge carries the body.
    fn of(mechanism: &Mechanism, collider: &Collider) -> Option<Self> {
        let (radius, farthest) = round(&collider.shape)?;
        let joint = &mechanism.bodies[collider.body?].joint;
        if joint.kind != JointKind::Revolute {
            return None;
        }
        let axis: Vector3<f64> = joint.on_child.rotation.matrix().column(2).into();
        let own: Vector3<f64> = collider.pose.rotation.matrix().column(2).into();
        let axis = if own.dot(&axis) < 0.0 { -axis } else { axis };
        let across = own.cross(&axis);
        // A ball is turned onto any axis as it is.
        let is_ball = matches!(collider.shape, Shape::Sphere { .. });
        let angle = if is_ball { 0.0 } else { across.norm().atan2(own.dot(&axis)) };
        let arm = collider.pose.translation.vector - joint.on_child.translation.vector;
        Some(Mounting { axis, across, angle, beside: arm - axis * axis.dot(&arm), radius, farthest })
    }

    /// The most that a point of the surface moves if the shape is turned onto the axis (m).
    fn moved(&self) -> f64 {
        2.0 * (0.5 * self.angle).sin() * self.farthest + self.beside.norm()
    }
}

/// The body against which a shape on another one never moves: what its body hangs on, if the shape turns about its own axis.
pub(crate) fn rigid_with(mechanism: &Mechanism, collider: &Collider) -> Option<usize> {
    let turns = |mounting: Mounting| mounting.moved() <= NOTHING * mounting.farthest;
    match collider.body {
        Some(body) if Mounting::of(mechanism, collider).is_some_and(turns) => mechanism.bodies[body].parent,
        own => own,
    }
}

/// Turns all wheels onto the axes of their joints; says which, and where the files put them.
pub(crate) fn turned_onto_axes(mechanism: &Mechanism, colliders: &mut [Collider]) -> Vec<Wheel> {
    let mut wheels = Vec::new();
    for (number, collider) in colliders.iter_mut().enumerate() {
        let Some(mounting) = Mounting::of(mechanism, collider) else { continue };
        let (written, moved) = (collider.pose, mounting.moved());
        let Mounting { axis, across, angle, beside, radius, farthest } = mounting;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanism::description::joint::Joint;
    use crate::mechanism::description::mechanism::Body;
    use std::f64::consts::FRAC_PI_2;

    /// A body on a joint about y, 0.2 m beside its centre of mass.
    fn on_joint(kind: JointKind) -> Mechanism {
        let across = Rotation3::from_axis_angle(&Vector3::x_axis(), -FRAC_PI_2);
        let frame = Pose::from_parts(Translation3::new(0.2, 0.0, 0.0), across);
        let joint = Joint::new("axle", kind, Pose::identity(), frame);
        let body = Body { name: "wheel".into(), parent: None, mass: 1.0, inertia: Vector3::repeat(1.0), joint };
        Mechanism::new("cart", Vector3::zeros(), vec![body]).expect("a mechanism")
    }

    /// A shape at (0.2, 0.3, `beside`) turned by `roll` about x.
    fn placed(shape: Shape, roll: f64, beside: f64) -> Collider {
        let turned = Rotation3::from_axis_angle(&Vector3::x_axis(), roll);
        Collider::still("wheel", Some(0), Pose::from_parts(Translation3::new(0.2, 0.3, beside), turned), shape)
    }

    const CYLINDER: Shape = Shape::Cylinder { radius: 0.3, half: 0.4 };

    #[test]
    fn a_wheel_is_turned_onto_the_axis_of_its_hinge_and_its_points_move_by_no_more_than_is_told() {
        for (off, beside) in [(8e-4, 0.0), (2.7e-8, 0.0), (-4e-4, 1e-7), (0.0, -2e-7)] {
            let roll = FRAC_PI_2 - off;
            for shape in [CYLINDER, Shape::Capsule { radius: 0.3, half: 0.4 }] {
                let mut colliders = vec![placed(shape, roll, beside)];
                let written = colliders[0].pose;
                let wheels = turned_onto_axes(&on_joint(JointKind::Revolute), &mut colliders);
                let [Wheel { angle, moved, written: known, .. }] = wheels[..] else { panic!("{roll}: {wheels:?}") };
                let pose = colliders[0].pose;
                assert_eq!((known, (angle - (FRAC_PI_2 - roll).abs()).abs() < 1e-15), (written, true));
                let axis = pose.rotation * Vector3::z();
                // The sine of the last of these angles is 6e-17.
                assert!(axis.x.abs() + axis.z.abs() < 1e-16 && pose.translation.z.abs() < 1e-16, "{roll}: {pose}");
                assert_eq!(axis.y.signum(), (written.rotation * Vector3::z()).y.signum());
                let off = |point: Vector3<f64>| {
                    (pose * nalgebra::Point3::from(point) - written * nalgebra::Point3::from(point)).norm()
                };
                let farthest = off(Vector3::new(0.0, 0.3, 0.4)).max(off(Vector3::new(0.0, -0.3, 0.4)));
                assert!(farthest <= moved + 1e-15, "{roll}: {farthest} m, not {moved} m");
                assert!(pose.rotation.matrix().determinant() > 1.0 - 1e-14, "{roll}");
            }
        }
    }

    #[test]
    fn what_is_no_wheel_stays_as_it_is_written() {
        let ball = Shape::Sphere { radius: 0.3 };
        let cuboid = Shape::Box { half: Vector3::repeat(0.3) };
        for (kind, shape, roll, beside) in [
            (JointKind::Revolute, CYLINDER, FRAC_PI_2 - 1.1e-3, 0.0),
            (JointKind::Revolute, CYLINDER, FRAC_PI_2 - 8e-4, 1e-6),
            (JointKind::Revolute, CYLINDER, FRAC_PI_2, 0.0),
            (JointKind::Revolute, ball, 0.7, 0.0),
            (JointKind::Revolute, cuboid, FRAC_PI_2 - 8e-4, 0.0),
            (JointKind::Floating, CYLINDER, FRAC_PI_2 - 8e-4, 0.0),
            (JointKind::Prismatic, CYLINDER, FRAC_PI_2 - 8e-4, 0.0),
        ] {
            let mut colliders = vec![placed(shape, roll, beside)];
            let before = colliders.clone();
            assert_eq!(turned_onto_axes(&on_joint(kind), &mut colliders), vec![], "{before:?}");
            assert_eq!(colliders, before);
        }
    }

    #[test]
    fn a_ball_beside_its_axis_by_a_rounding_is_moved_onto_it_and_not_turned() {
        let mut colliders = vec![placed(Shape::Sphere { radius: 0.3 }, 0.7, 1e-8)];
        let rotation = colliders[0].pose.rotation;
        let wheels = turned_onto_axes(&on_joint(JointKind::Revolute), &mut colliders);
        assert_eq!((wheels.len(), wheels[0].angle), (1, 0.0));
        assert!((wheels[0].moved - 1e-8).abs() < 1e-16, "{:?}", wheels[0]);
        assert!(colliders[0].pose.translation.z.abs() < 1e-16, "{}", colliders[0].pose);
        assert_eq!(colliders[0].pose.rotation, rotation);
    }

    #[test]
    fn a_shape_is_rigid_with_what_its_body_turns_on_if_it_turns_about_its_own_axis() {
        let mut mechanism = on_joint(JointKind::Revolute);
        let rigid = |mechanism: &Mechanism, shape, roll, beside| rigid_with(mechanism, &placed(shape, roll, beside));
        let ball = || Shape::Sphere { radius: 0.3 };
        assert_eq!(rigid(&mechanism, ball(), 0.7, 0.0), None);
        assert_eq!(rigid(&mechanism, CYLINDER, FRAC_PI_2, 0.0), None);
        for (shape, roll, beside) in
            [(ball(), 0.7, 1e-9), (CYLINDER, 0.7, 0.0), (Shape::Box { half: Vector3::repeat(0.3) }, FRAC_PI_2, 0.0)]
        {
            assert_eq!(rigid(&mechanism, shape, roll, beside), Some(0));
        }
        mechanism = on_joint(JointKind::Spherical);
        assert_eq!(rigid(&mechanism, ball(), 0.7, 0.0), Some(0));
    }
}
