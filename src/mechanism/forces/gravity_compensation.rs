//! The effort of a joint that holds the weight of all bodies beyond it.
//!
//! ```text
//!     S = Σ_b m_b (x_b − p) [kg m],   M = Σ_b m_b [kg]          b: the bodies beyond the joint, x_b: their centres of mass
//!     τ = −f a · (S × g) [N m]                                  about the axis a through the anchor p
//!     τ = −f M (a · g) [N]                                      along the axis a
//! ```
//!
//! with the part f of the weight. It is minus the generalised force of gravity on the joint. The bodies beyond are the subtree of the joint, so that
//! no loop may lead around it. If only some joints of a chain have it, it has no potential; all of its work is counted as put in.
//!
//! Source: R. Featherstone, Rigid Body Dynamics Algorithms (2008), section 5.3 (inverse dynamics at rest).

use crate::description::body_state::BodyState;
use crate::description::forces::GravityCompensation;
use crate::description::joint::JointKind;
use crate::description::mechanism::Mechanism;
use crate::ground::matrices::{column, times};
use nalgebra::Vector3;

impl GravityCompensation {
    /// The effort along the joint [N m or N], where the bodies have been placed.
    pub fn effort(&self, mechanism: &Mechanism, bodies: &[BodyState]) -> f64 {
        let Some(head) = mechanism.body_of_freedom(self.freedom) else { return 0.0 };
        let (joint, state) = (&mechanism.bodies[head].joint, &bodies[head]);
        let anchor = state.position + times(&state.rotation, &joint.on_child.translation.vector);
        let (mut moment, mut mass) = (Vector3::zeros(), 0.0);
        for body in mechanism.subtree(head) {
            let own = mechanism.bodies[body].mass;
            moment += own * (bodies[body].position - anchor);
            mass += own;
        }
        let axis = times(&state.rotation, &column(joint.on_child.rotation.matrix(), 2));
        -self.factor
            * match joint.kind {
                JointKind::Prismatic => mass * axis.dot(&mechanism.gravity),
                _ => axis.dot(&moment.cross(&mechanism.gravity)),
            }
    }
}
