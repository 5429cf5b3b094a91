//! Planar motion: a mechanism whose joints keep every body parallel to one plane.
//!
//! Every hinge turns about the normal n of the plane, every slide is across it: then at zero displacement and ever after
//!
//! ```text
//!     ω = ψ̇ n,      ẋ · n = 0
//! ```
//!
//! for every body, whatever its inertia and wherever its centre of mass is. The joints carry the effects of forces, products of inertia and offsets
//! along n, which do not move the bodies. Three coordinates a body are complete. Mimic relations are between them, and closures keep the equations
//! that are not trivial in the plane ([`crate::structure::planar_loops`]).

use crate::description::body_state::BodyState;
use crate::description::closure::LoopJoint;
use crate::description::joint::{FreeRotation, JointKind};
use crate::description::mechanism::{Body, Mechanism};
use crate::motion::kinematics::body_states;
use crate::motion::state::State;
use crate::structure::planar_loops::{PARALLEL, PlanarEquation, across, planar_equations};
use nalgebra::{Matrix3, Vector3};

/// The plane to which all bodies of a mechanism move parallel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Unit vectors of the world: two in the plane, and its normal, right-handed.
    pub axes: [Vector3<f64>; 3],
}

impl Plane {
    /// The plane of a mechanism; `None` without such a plane, or with contacts, whose equations are spatial.
    pub fn of(mechanism: &Mechanism) -> Option<Plane> {
        if !mechanism.touches.is_empty() {
            return None;
        }
        let axes = joint_axes(mechanism)?;
        let normal = normal(&axes)?;
        let fits = |&(axis, turns): &(Vector3<f64>, bool)| match turns {
            true => axis.cross(&normal).norm() <= PARALLEL,
            false => axis.dot(&normal).abs() <= PARALLEL,
        };
        if !axes.iter().all(fits) {
            return None;
        }
        let first = across(&normal);
        let plane = Plane { axes: [first, normal.cross(&first), normal] };
        if !mechanism.loops.is_empty() {
            let zero = body_states(mechanism, &State::zero(mechanism));
            let closes = |joint: &LoopJoint| plane.equations(joint, &zero).is_some();
            if !mechanism.loops.iter().all(closes) {
                return None;
            }
        }
        Some(plane)
    }

    /// The equations of a loop joint for motions in the plane, for bodies that are placed so at zero displacement; `None` if it allows no such
    /// motion.
    pub fn equations(&self, joint: &LoopJoint, zero: &[BodyState]) -> Option<Vec<PlanarEquation>> {
        planar_equations(joint, &self.axes, zero)
    }

    /// The components of a vector in the plane.
    pub fn flat(&self, v: &Vector3<f64>) -> [f64; 2] {
        [self.axes[0].dot(v), self.axes[1].dot(v)]
    }

    /// The normal, n.
    pub fn normal(&self) -> Vector3<f64> {
        self.axes[2]
    }

    /// Whether another plane is parallel.
    pub fn is_parallel(&self, other: &Plane) -> bool {
        self.normal().cross(&other.normal()).norm() <= PARALLEL
    }
}

/// Directions of all joints in the world at zero displacement, z of the joint frame, and whether the joint turns about it; `None` if a joint has no
/// such direction, or if there are no joints.
fn joint_axes(mechanism: &Mechanism) -> Option<Vec<(Vector3<f64>, bool)>> {
    let planar = |kind| matches!(kind, JointKind::Revolute | JointKind::Prismatic | JointKind::Planar);
    let possible = mechanism.bodies.iter().all(|body| planar(body.joint.kind));
    if !possible || mechanism.bodies.is_empty() {
        return None;
    }
    let mut turned: Vec<Matrix3<f64>> = Vec::with_capacity(mechanism.bodies.len());
    let mut axes = Vec::with_capacity(mechanism.bodies.len());
    for Body { parent, joint, .. } in &mechanism.bodies {
        let frame = parent.map_or_else(Matrix3::identity, |parent| turned[parent]) * joint.on_parent.rotation.matrix();
        axes.push((frame.column(2).into_owned(), joint.kind.rotation() != FreeRotation::None));
        turned.push(frame * joint.on_child.rotation.matrix().transpose());
    }
    Some(axes)
}

/// The normal that these directions leave as the only one, or one of them.
fn normal(axes: &[(Vector3<f64>, bool)]) -> Option<Vector3<f64>> {
    let hinge = axes.iter().find(|(_, turns)| *turns).map(|(axis, _)| *axis);
    let slides = || {
        let (first, _) = axes.first()?;
        let crossed = axes.iter().map(|(axis, _)| first.cross(axis)).find(|cross| cross.norm() > PARALLEL);
        Some(crossed.unwrap_or_else(|| across(first)))
    };
    hinge.or_else(slides).map(|normal| normal.normalize())
}
