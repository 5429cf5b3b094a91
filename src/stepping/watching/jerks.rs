//! How accelerations change in time: the equations of motion, differentiated as they stand.
//!
//! The symbols are as in [`super`]; a dot is the derivative in time, and arms, sliding velocities and turning rates turn with the parent:
//!
//! ```text
//!     ḟ = m (ȧ + d³c/dt³)  [N/s],     Ṫ = d²(J ω)/dt² + ċ × f + c × ḟ + Σ_children (Ṫ + ṙ × F + r × Ḟ)  [N m/s]
//!     (ω_p × z)·T + z·Ṫ = 0,          (ω_p × t)·F + t·Ḟ = 0
//! ```

use crate::watching::dynamics::{Dynamics, joint_motion, spin_inertia};
use catena_lobatto::plan::tree::Plan;
use catena_lobatto::stages::start::Start;
use nalgebra::Vector3;

impl Dynamics {
    /// Writes the time derivative of [`Dynamics::accelerations`].
    pub fn jerks(&mut self, plan: &Plan, start: &Start, out: &mut [f64]) {
        for (index, (own, known)) in plan.bodies.iter().zip(&start.bodies).enumerate() {
            let (above, spin) = self.parent(own, start);
            let (jerk, angular_jerk) = self.parent_twist(own);
            let (slide, turn) = joint_motion(own, start, &start.rates);
            let (slide_rate, turn_rate) = joint_motion(own, start, &self.accelerations);
            let (arm, com, own_spin) = (Vector3::from(known.arm), Vector3::from(known.com), Vector3::from(known.spin));
            let body = &self.bodies[index];
            // Derivatives of the arm, of the sliding velocity and of the turning rate, first to third.
            let arm1 = spin.cross(&arm) + slide;
            let slide1 = slide_rate + spin.cross(&slide);
            let arm2 = above.angular.cross(&arm) + spin.cross(&arm1) + slide1;
            let slide2 = spin.cross(&slide_rate) + above.angular.cross(&slide) + spin.cross(&slide1);
            let arm3 = angular_jerk.cross(&arm) + 2.0 * above.angular.cross(&arm1) + spin.cross(&arm2) + slide2;
            let turn1 = turn_rate + spin.cross(&turn);
            let angular = angular_jerk + above.angular.cross(&turn) + spin.cross(&turn1) + own_spin.cross(&turn_rate);
            let linear = jerk + arm3;
            self.pairs[index] = (linear, angular);
            let com1 = own_spin.cross(&com);
            let com2 = body.angular.cross(&com) + own_spin.cross(&com1);
            let com3 = angular.cross(&com) + 2.0 * body.angular.cross(&com1) + own_spin.cross(&com2);
            let force = known.mass * (linear + com3);
            // The second derivative of R J Rᵀ ω.
            let (swirl, push) = (spin_inertia(known, &own_spin), spin_inertia(known, &body.angular));
            let torque = spin_inertia(known, &angular) + own_spin.cross(&push)
                - spin_inertia(known, &own_spin.cross(&body.angular))
                + body.angular.cross(&swirl)
                + own_spin.cross(&(push + own_spin.cross(&swirl)));
            self.changes[index] = (force, torque + com1.cross(&body.own) + com.cross(&force));
        }
        for (index, (own, known)) in plan.bodies.iter().zip(&start.bodies).enumerate().rev() {
            let (_, spin) = self.parent(own, start);
            self.rows_of(own, start, index, &spin, out);
            if let Some(above) = own.parent {
                let arm = Vector3::from(known.arm);
                let (slide, _) = joint_motion(own, start, &start.rates);
                let (force, torque) = self.changes[index];
                let turned = (spin.cross(&arm) + slide).cross(&self.bodies[index].force);
                self.changes[above].0 += force;
                self.changes[above].1 += torque + turned + arm.cross(&force);
            }
        }
        out.iter_mut().for_each(|row| *row = -*row);
        self.solve(plan, start, out);
    }
}
