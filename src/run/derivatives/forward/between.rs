//! The motion from one state to another, along the degrees of freedom.

use crate::mechanism::description::joint::{FreeRotation, rotation_from_wxyz};
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::state::State;
use nalgebra::{DVector, Matrix3, Vector3};

/// The motion from one state to another (n): turns of ball joints as rotation vectors about the axes of the child.
pub(crate) fn motion_between(mechanism: &Mechanism, from: &State, to: &State) -> DVector<f64> {
    let mut motion = DVector::zeros(mechanism.velocity_count);
    for body in &mechanism.bodies {
        let joint = &body.joint;
        let slides = joint.kind.translation_axes().len();
        let is_ball = joint.kind.rotation() == FreeRotation::Ball;
        let scalars = if is_ball { slides } else { joint.kind.velocity_count() };
        for offset in 0..scalars {
            let slot = joint.position_index + offset;
            motion[joint.velocity_index + offset] =
                (to.position[slot] - from.position[slot]) + (to.compensation[slot] - from.compensation[slot]);
        }
        if is_ball {
            let slot = joint.position_index + slides;
            let [from, to] = [from, to].map(|state| rotation_from_wxyz(&state.position[slot..slot + 4]));
            let turn = rotation_vector(&(from.transpose() * to));
            motion.rows_mut(joint.velocity_index + slides, 3).copy_from(&turn);
        }
    }
    motion
}

/// The rotation vector of a rotation by less than half a turn: `s (angle/|s|)` with `s = ½ vee(R − Rᵀ)`, zero for no rotation.
fn rotation_vector(rotation: &Matrix3<f64>) -> Vector3<f64> {
    let skew = rotation - rotation.transpose();
    let half = 0.5 * Vector3::new(skew[(2, 1)], skew[(0, 2)], skew[(1, 0)]);
    let sine = half.norm();
    if sine == 0.0 { half } else { half * (sine.atan2(0.5 * (rotation.trace() - 1.0)) / sine) }
}
