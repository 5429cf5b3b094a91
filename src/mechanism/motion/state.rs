//! The state: the quantities that change in time.
//!
//! The state is stored as joint displacements, accumulated with compensation. The maximal-coordinate poses `(x, R)`
//! and velocities `(v, ω)` of all bodies are rebuilt from them ([`crate::motion::kinematics`]), so that every joint holds to
//! rounding whatever the length of the run.

use crate::description::joint::FreeRotation;
use crate::description::mechanism::Mechanism;

/// Joint positions and velocities at a time, in the layout of the [`Mechanism`].
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Time (s).
    pub time: f64,
    /// Joint positions (`position_count` numbers; see the table of [`crate::description::joint`]).
    pub position: Vec<f64>,
    /// Accumulated rounding errors of `position`, to be added to it (zero for quaternions).
    pub compensation: Vec<f64>,
    /// Joint velocities (`velocity_count` numbers).
    pub velocity: Vec<f64>,
}

impl State {
    /// Every joint at zero displacement, at rest, at time zero.
    pub fn zero(mechanism: &Mechanism) -> Self {
        let position: Vec<f64> = mechanism.bodies.iter().flat_map(|body| body.joint.kind.zero_position()).collect();
        State {
            time: 0.0,
            compensation: vec![0.0; position.len()],
            position,
            velocity: vec![0.0; mechanism.velocity_count],
        }
    }

    /// Takes over another state of the same mechanism. Does not allocate.
    #[inline]
    pub fn copy_from(&mut self, other: &State) {
        self.time = other.time;
        self.position.copy_from_slice(&other.position);
        self.compensation.copy_from_slice(&other.compensation);
        self.velocity.copy_from_slice(&other.velocity);
    }

    /// The positions of one body's joint.
    #[inline]
    pub fn joint_position<'s>(&'s self, mechanism: &Mechanism, body: usize) -> &'s [f64] {
        &self.position[mechanism.bodies[body].joint.position_range()]
    }

    /// The velocities of one body's joint.
    #[inline]
    pub fn joint_velocity<'s>(&'s self, mechanism: &Mechanism, body: usize) -> &'s [f64] {
        &self.velocity[mechanism.bodies[body].joint.velocity_range()]
    }

    /// Adds `increment` to the positions: a number for each velocity entry, rotation vectors (in the child's joint
    /// frame) for ball rotations. Sums are compensated (Kahan), quaternions renormalised.
    #[inline]
    pub fn displace(&mut self, mechanism: &Mechanism, increment: &[f64]) {
        for body in &mechanism.bodies {
            let joint = &body.joint;
            let scalars = joint.kind.velocity_count() - if joint.kind.rotation() == FreeRotation::Ball { 3 } else { 0 };
            for offset in 0..scalars {
                let slot = joint.position_index + offset;
                let wanted = increment[joint.velocity_index + offset] + self.compensation[slot];
                let sum = self.position[slot] + wanted;
                self.compensation[slot] = wanted - (sum - self.position[slot]);
                self.position[slot] = sum;
            }
            if joint.kind.rotation() == FreeRotation::Ball {
                let theta = &increment[joint.velocity_index + scalars..joint.velocity_index + scalars + 3];
                let slot = joint.position_index + scalars;
                let turned = quaternion_product(&self.position[slot..slot + 4], &quaternion_exponential(theta));
                let norm = turned.iter().map(|c| c * c).sum::<f64>().sqrt();
                for (entry, component) in self.position[slot..slot + 4].iter_mut().zip(turned) {
                    *entry = component / norm;
                }
            }
        }
    }
}

/// The unit quaternion (w, x, y, z) of a rotation vector (rad).
pub fn quaternion_exponential(theta: &[f64]) -> [f64; 4] {
    let angle = (theta[0] * theta[0] + theta[1] * theta[1] + theta[2] * theta[2]).sqrt();
    let half = 0.5 * angle;
    // sin(φ/2)/φ has the limit 1/2; below 1e-8 the next term is under the rounding of a double.
    let scale = if angle < 1e-8 { 0.5 } else { half.sin() / angle };
    [half.cos(), scale * theta[0], scale * theta[1], scale * theta[2]]
}

/// The Hamilton product of two quaternions (w, x, y, z).
pub fn quaternion_product(a: &[f64], b: &[f64]) -> [f64; 4] {
    [
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] + a[2] * b[0] + a[3] * b[1] - a[1] * b[3],
        a[0] * b[3] + a[3] * b[0] + a[1] * b[2] - a[2] * b[1],
    ]
}
