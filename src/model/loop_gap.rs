//! How far the two frames of a loop joint are from where the joint wants them: `g(q)` of the table in [`super::closure`].

use super::closure::{Attachment, LoopJoint, LoopKind};
use crate::kinematics::WORLD;
use crate::state::BodyState;
use nalgebra::{Matrix3, Vector3};

impl Attachment {
    /// Origin (m) and axes (as columns) of the frame in the world.
    pub fn place(&self, bodies: &[BodyState]) -> (Vector3<f64>, Matrix3<f64>) {
        let body = self.body.map_or(&WORLD, |body| &bodies[body]);
        let origin = body.position + body.rotation * self.frame.translation.vector;
        (origin, body.rotation * self.frame.rotation.matrix())
    }
}

impl LoopJoint {
    /// The values of the joint's equations (`kind.rows()` numbers, m and rad), zero where it is closed.
    pub fn gap(&self, bodies: &[BodyState]) -> Vec<f64> {
        let (place_a, axes_a) = self.a.place(bodies);
        let (place_b, axes_b) = self.b.place(bodies);
        let apart = place_b - place_a;
        let [x_a, y_a, z_a] = [0, 1, 2].map(|axis| axes_a.column(axis).into_owned());
        let [x_b, _, z_b] = [0, 1, 2].map(|axis| axes_b.column(axis).into_owned());
        let (tilt_x, tilt_y, twist) = (z_b.dot(&x_a), z_b.dot(&y_a), x_b.dot(&y_a));
        let (along_x, along_y) = (apart.dot(&x_a), apart.dot(&y_a));
        match self.kind {
            LoopKind::Revolute => vec![apart.x, apart.y, apart.z, tilt_x, tilt_y],
            LoopKind::Prismatic => vec![along_x, along_y, tilt_x, tilt_y, twist],
            LoopKind::Cylindrical => vec![along_x, along_y, tilt_x, tilt_y],
            LoopKind::Universal => vec![apart.x, apart.y, apart.z, z_a.dot(&z_b)],
            LoopKind::Spherical => vec![apart.x, apart.y, apart.z],
            LoopKind::Planar => vec![apart.dot(&z_a), tilt_x, tilt_y],
            LoopKind::Fixed => vec![apart.x, apart.y, apart.z, tilt_x, tilt_y, twist],
            LoopKind::Distance(length) => vec![(apart.norm_squared() - length * length) / (2.0 * length)],
        }
    }
}
