//! What joints and loops carry at an instant.
//!
//! The accelerations of the tree by the articulated-body algorithm ([`crate::reduced`]), corrected for the closures,
//!
//! ```text
//!     H a = τ − c + Jᵀ μ,    J a + J̇ v = 0
//! ```
//!
//! then Newton and Euler for every subtree with the multipliers' wrenches on the bodies. Where equations are redundant μ is not
//! unique; the one with the least `Σ s μ²` is taken, s the mobility of each equation, and what a joint of a loop carries
//! then depends on that choice as it does on nature's.

use crate::closures::gap_accelerations;
use crate::forces::total::{BodyWrench, body_wrenches};
use crate::kinematics::{BodyAcceleration, WORLD, body_accelerations, forward_kinematics};
use crate::lobatto::projection::Projection;
use crate::lobatto::start::Start;
use crate::model::Mechanism;
use crate::reduced::{Reaction, ReducedOde, reactions_under};
use crate::state::{BodyState, State};
use nalgebra::Vector3;

/// Works out the reactions of one state after another.
pub struct Reactions<'m> {
    mechanism: &'m Mechanism,
    ode: ReducedOde,
    accelerations: Vec<f64>,
    closing: Option<Closing>,
}

/// What mechanisms with closures need besides.
struct Closing {
    projection: Projection,
    start: Start,
    state: State,
    multipliers: Vec<f64>,
}

/// What a loop joint carries.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LoopReaction {
    /// Force of the first end on the second, in the world (N).
    pub force: Vector3<f64>,
    /// Torque about the point of the second end [N m].
    pub torque: Vector3<f64>,
}

impl<'m> Reactions<'m> {
    /// Sets up the mechanism.
    pub fn new(mechanism: &'m Mechanism) -> Self {
        let closing = mechanism.has_closures().then(|| {
            let projection = Projection::new(mechanism);
            let multipliers = vec![0.0; projection.row_count()];
            Closing { projection, start: Start::new(mechanism), state: State::zero(mechanism), multipliers }
        });
        Reactions {
            mechanism,
            ode: ReducedOde::new(mechanism),
            accelerations: vec![0.0; mechanism.velocity_count],
            closing,
        }
    }

    /// The acceleration of each body at these positions and velocities, with all closures and forces.
    pub fn accelerations(&mut self, position: &[f64], velocity: &[f64]) -> Vec<BodyAcceleration> {
        let mut bodies = vec![WORLD; self.mechanism.bodies.len()];
        forward_kinematics(self.mechanism, position, velocity, &mut bodies);
        self.ode.accelerations(position, velocity, &mut self.accelerations);
        self.accelerate(&bodies, position, velocity)
    }

    /// Corrects the tree's joint accelerations for the closures; returns those of the bodies.
    fn accelerate(&mut self, bodies: &[BodyState], position: &[f64], velocity: &[f64]) -> Vec<BodyAcceleration> {
        let mechanism = self.mechanism;
        let mut accelerations = vec![Default::default(); bodies.len()];
        if let Some(Closing { projection, start, state, multipliers }) = &mut self.closing {
            state.position.copy_from_slice(position);
            state.velocity.copy_from_slice(velocity);
            start.set(mechanism, state);
            projection.accelerations(start, &mut self.accelerations, multipliers, |joints, out| {
                body_accelerations(mechanism, bodies, velocity, joints, &mut accelerations);
                gap_accelerations(mechanism, bodies, joints, &accelerations, out);
            });
        }
        body_accelerations(mechanism, bodies, velocity, &self.accelerations, &mut accelerations);
        accelerations
    }

    /// What each joint carries at these positions and velocities, one entry a body, and what each loop carries.
    pub fn at(&mut self, position: &[f64], velocity: &[f64]) -> (Vec<Reaction>, Vec<LoopReaction>) {
        let mechanism = self.mechanism;
        self.ode.accelerations(position, velocity, &mut self.accelerations);
        let mut bodies = vec![WORLD; mechanism.bodies.len()];
        forward_kinematics(mechanism, position, velocity, &mut bodies);
        let accelerations = self.accelerate(&bodies, position, velocity);
        let mut applied = vec![BodyWrench::default(); bodies.len()];
        body_wrenches(mechanism, &bodies, &mut applied);
        let mut loops = Vec::with_capacity(mechanism.loops.len());
        if let Some(Closing { projection, multipliers, .. }) = &self.closing {
            for (index, joint) in mechanism.loops.iter().enumerate() {
                let (force, torque) = projection.loop_wrench(index, multipliers);
                loops.push(LoopReaction { force, torque });
                let point = match joint.b.body {
                    Some(body) => bodies[body].position + bodies[body].rotation * joint.b.frame.translation.vector,
                    None => joint.b.frame.translation.vector,
                };
                for (end, sign) in [(joint.a.body, -1.0), (joint.b.body, 1.0)] {
                    if let Some(body) = end {
                        let arm = point - bodies[body].position;
                        applied[body].0 += sign * force;
                        applied[body].1 += sign * (torque + arm.cross(&force));
                    }
                }
            }
        }
        (reactions_under(mechanism, &bodies, &accelerations, &applied), loops)
    }
}
