//! The equations of a closure for a motion in a plane.
//!
//! Let n be the normal of the plane. The points of the closure are `d + z n` apart, d in the plane, and their height z never changes; the component
//! along n of any direction fixed in a body never changes either. Some equations of [`crate::description::closure::LoopKind`] are then satisfied once
//! and for all, others are equal to each other, and the remaining ones are
//!
//! | translation        | z_a along n              | z_a across n             |
//! |--------------------|--------------------------|--------------------------|
//! | none free          | `d = 0`, if `z = 0`      | `d = 0`, if `z = 0`      |
//! | along z_a          | `d = 0`                  | `d·(n × z_a)`, if `z = 0`|
//! | along x_a and y_a  | nothing, if `z = 0`      | `d·z_a`                  |
//! | a fixed distance L | `(|d|² + z² − L²) / 2L`  | the same                 |
//!
//! | rotation           | z_a along n              | z_a across n             |
//! |--------------------|--------------------------|--------------------------|
//! | none free          | no turn                  | no turn                  |
//! | about z_a          | nothing, if z_b is too   | `(n × z_a)·z_b`, if z_b is too |
//! | about z_a and z_b  | nothing, if z_b is not   | `z_a·z_b` if z_b is too, else nothing |
//!
//! and anything else is no motion in the plane. No turn means `u_a·w_b = 0` for directions of the two frames that lie in the plane and
//! are square to each other where the frames agree, if n is the same direction in both.

use crate::description::body_state::BodyState;
use crate::description::closure::{LoopJoint, LoopKind};
use nalgebra::{Matrix3, Vector3};

/// Axes count as parallel, or as being across each other, if their directions are off by no more than this (rad): some thousand
/// products of rotations, rounded. More would change the motion by as much of itself.
pub const PARALLEL: f64 = 1e-12;

/// Points count as equally high if their heights differ by no more than this (m): rounding, with a margin.
const LEVEL: f64 = 1e-11;

/// An equation of a closure in a plane; directions are in the world at zero displacement, and lie in the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlanarEquation {
    /// The points coincide along a direction fixed in the first body.
    Slide(Vector3<f64>),
    /// A direction fixed in the first body is square to one fixed in the second.
    Square(Vector3<f64>, Vector3<f64>),
    /// The points are `length` apart (m), of which `height` is along the normal.
    Distance { length: f64, height: f64 },
}

/// How a direction lies against the plane.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Lies {
    Along,
    Across,
}

/// Whether a direction is along the normal, or across it; `None` if it is neither.
fn lies(direction: &Vector3<f64>, normal: &Vector3<f64>) -> Option<Lies> {
    if direction.cross(normal).norm() <= PARALLEL {
        Some(Lies::Along)
    } else {
        (direction.dot(normal).abs() <= PARALLEL).then_some(Lies::Across)
    }
}

/// The equations that a loop joint leaves of a motion in the plane with these axes, the normal last, for bodies that are placed so
/// at zero displacement; `None` if it allows no such motion, or not for sure.
pub fn planar_equations(
    joint: &LoopJoint,
    axes: &[Vector3<f64>; 3],
    zero: &[BodyState],
) -> Option<Vec<PlanarEquation>> {
    let [first, second, normal] = axes;
    let ((a, on_a), (b, on_b)) = (joint.a.place(zero), joint.b.place(zero));
    let (z_a, z_b) = (on_a.column(2).into_owned(), on_b.column(2).into_owned());
    let height = (b - a).dot(normal);
    let level = || (height.abs() <= LEVEL).then_some(());
    let both = || [first, second].map(|&axis| PlanarEquation::Slide(axis));
    let mut equations = Vec::new();
    match joint.kind {
        LoopKind::Revolute | LoopKind::Universal | LoopKind::Spherical | LoopKind::Fixed => {
            level()?;
            equations.extend(both());
        }
        LoopKind::Prismatic | LoopKind::Cylindrical => match lies(&z_a, normal)? {
            Lies::Along => equations.extend(both()),
            Lies::Across => {
                level()?;
                equations.push(PlanarEquation::Slide(normal.cross(&z_a)));
            }
        },
        LoopKind::Planar => match lies(&z_a, normal)? {
            Lies::Along => level()?,
            Lies::Across => equations.push(PlanarEquation::Slide(z_a)),
        },
        LoopKind::Distance(length) => equations.push(PlanarEquation::Distance { length, height }),
    }
    match joint.kind {
        LoopKind::Revolute | LoopKind::Cylindrical | LoopKind::Planar => {
            match (lies(&z_a, normal)?, lies(&z_b, normal)?) {
                (Lies::Along, Lies::Along) => {}
                (Lies::Across, Lies::Across) => equations.push(PlanarEquation::Square(normal.cross(&z_a), z_b)),
                _ => return None,
            }
        }
        LoopKind::Prismatic | LoopKind::Fixed => {
            let (in_a, in_b) = (on_a.tr_mul(normal), on_b.tr_mul(normal));
            if (in_a - in_b).norm() > PARALLEL {
                return None;
            }
            let flat = across(&in_a);
            equations.push(PlanarEquation::Square(on_a * flat, on_b * in_b.cross(&flat)));
        }
        LoopKind::Universal => match (lies(&z_a, normal)?, lies(&z_b, normal)?) {
            (Lies::Across, Lies::Across) => equations.push(PlanarEquation::Square(z_a, z_b)),
            (Lies::Along, Lies::Along) => return None,
            _ => {}
        },
        LoopKind::Spherical | LoopKind::Distance(_) => {}
    }
    Some(equations)
}

/// A unit vector across another.
pub fn across(direction: &Vector3<f64>) -> Vector3<f64> {
    // The start is the axis of the world that is farthest from it, so that digits do not cancel.
    let axis = Matrix3::identity().column(direction.iamin()).into_owned();
    direction.cross(&axis).normalize()
}
