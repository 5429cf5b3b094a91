//! The wrenches of joints and loops at an instant, computed on the spanning tree of the mechanism.
//!
//! The accelerations of the tree by the articulated-body algorithm ([`crate::reduced`]), corrected for the closures,
//!
//! ```text
//!     H a = τ − c + Jᵀ μ,    J a + J̇ v = 0
//! ```
//!
//! with the efforts τ of forces in joints, of motors, dry friction, limits and contacts ([`crate::instant::exerting::exerted`]); then Newton and
//! Euler for every subtree with the multipliers' wrenches on the bodies. If equations are redundant μ is not unique; the one with the least `Σ s μ²`
//! is taken, s the mobility of each equation, and the load of a joint of a loop then depends on that choice as it does on nature's.

use crate::instant::dynamics::closing::Closing;
use crate::instant::exerting::exerted::Exerted;
use crate::lobatto::coupled::counted::Counted;
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::forces::total::{BodyWrench, body_wrenches};
use crate::mechanism::motion::contact_point::ContactPoint;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::kinematics::{BodyAcceleration, body_accelerations};
use crate::mechanism::motion::state::State;
use crate::reduced::{Reaction, ReducedOde, reactions_under};
use nalgebra::Vector3;
use std::borrow::Borrow;
use std::sync::Arc;

/// Works out the reactions of one state after another.
pub struct ReactionsOnTree<M> {
    mechanism: M,
    ode: ReducedOde,
    joint_accelerations: Vec<f64>,
    accelerations: Vec<BodyAcceleration>,
    applied: Vec<BodyWrench>,
    reactions: Vec<Reaction>,
    loops: Vec<LoopReaction>,
    /// The closures, if there are any, with the state that was asked for last.
    closing: Option<(Closing, State)>,
    exerted: Option<Exerted>,
    /// The efforts of motors.
    motors: Vec<f64>,
    /// The time of the states that are asked for (s).
    time: f64,
}

/// The load of a loop joint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LoopReaction {
    /// Force of the first end on the second, in the world (N).
    pub force: Vector3<f64>,
    /// Torque about the point of the second end [N m].
    pub torque: Vector3<f64>,
}

impl<M: Borrow<Mechanism>> ReactionsOnTree<M> {
    /// Sets up a mechanism, of its own or borrowed.
    pub fn new(of: M) -> Self {
        let mechanism = of.borrow();
        let count = mechanism.bodies.len();
        let exerted = Exerted::new(mechanism);
        let ode = if exerted.is_some() {
            let mut driven = mechanism.clone();
            driven.forces.driven = true;
            ReducedOde::new(&driven)
        } else {
            ReducedOde::new(mechanism)
        };
        ReactionsOnTree {
            ode,
            joint_accelerations: vec![0.0; mechanism.velocity_count],
            accelerations: vec![BodyAcceleration::default(); count],
            applied: vec![BodyWrench::default(); count],
            reactions: vec![Reaction::default(); count],
            loops: vec![LoopReaction::default(); mechanism.loops.len()],
            closing: Closing::new(mechanism).map(|closing| (closing, State::zero(mechanism))),
            exerted,
            motors: Vec::with_capacity(mechanism.nonsmooth.motors.len()),
            time: 0.0,
            mechanism: of,
        }
    }

    /// The mechanism.
    pub fn mechanism(&self) -> &Mechanism {
        self.mechanism.borrow()
    }

    /// Takes the count of the closures in the first state that will be asked for.
    pub fn expect_at(&mut self, counted: Option<Arc<Counted>>) {
        if let Some((closing, _)) = &mut self.closing {
            closing.expect_at(counted);
        }
    }

    /// Takes the time of the states that follow (s).
    pub fn clock(&mut self, time: f64) {
        self.time = time;
        if let Some(exerted) = &mut self.exerted {
            exerted.clock(time);
        }
    }

    /// Takes the efforts of the motors for all states that follow: one entry a motor of the mechanism [N m or N]; before, no motor drives.
    pub fn drive(&mut self, motors: &[f64]) {
        self.motors.clear();
        self.motors.extend_from_slice(motors);
    }

    /// Takes the contacts of the states that follow, with their forces; `None` if they are to be worked out.
    pub fn touch(&mut self, points: Option<&[ContactPoint]>) {
        if let Some(exerted) = &mut self.exerted {
            exerted.touch(points);
        }
    }

    /// The acceleration of each body at these positions and velocities, which place the bodies, with all closures and
    /// forces, but without motors, dry friction and limits. Does not allocate.
    pub fn accelerations(&mut self, position: &[f64], velocity: &[f64], bodies: &[BodyState]) -> &[BodyAcceleration] {
        self.ode.drive_at(self.time, Inputs::NONE);
        self.accelerate(position, velocity, bodies);
        &self.accelerations
    }

    /// The same under the efforts that the system in joint coordinates has been handed.
    fn accelerate(&mut self, position: &[f64], velocity: &[f64], bodies: &[BodyState]) {
        let ReactionsOnTree { mechanism, joint_accelerations, accelerations, closing, .. } = self;
        let mechanism = (*mechanism).borrow();
        self.ode.accelerations_of_placed(position, velocity, bodies, joint_accelerations);
        // The tree's joint accelerations are corrected for the closures.
        if let Some((closing, state)) = closing {
            state.position.copy_from_slice(position);
            state.velocity.copy_from_slice(velocity);
            state.time = self.time;
            closing.place(mechanism, state);
            closing.accelerations(mechanism, velocity, bodies, joint_accelerations, accelerations);
        }
        body_accelerations(mechanism, bodies, velocity, joint_accelerations, accelerations);
    }

    /// The accelerations of the bodies that were computed last.
    pub fn accelerated(&self) -> &[BodyAcceleration] {
        &self.accelerations
    }

    /// The load of each joint at these positions and velocities, which place the bodies: one entry a body, and the load of each loop. Motors, dry
    /// friction, limits and contacts take part. Does not allocate while no joint is held and no bodies may touch.
    pub fn of_placed(
        &mut self,
        position: &[f64],
        velocity: &[f64],
        bodies: &[BodyState],
    ) -> (&[Reaction], &[LoopReaction]) {
        let Some(mut exerted) = self.exerted.take() else { return self.react(position, velocity, bodies, &[]) };
        let (efforts, wrenches) = exerted.at(position, velocity, &self.motors);
        self.of_placed_under(position, velocity, bodies, efforts, wrenches);
        self.exerted = Some(exerted);
        (&self.reactions, &self.loops)
    }

    /// The same of a mechanism whose forces are driven, under efforts along its degrees of freedom and wrenches on its bodies which do the work of
    /// some of them.
    pub fn of_placed_under(
        &mut self,
        position: &[f64],
        velocity: &[f64],
        bodies: &[BodyState],
        efforts: &[f64],
        wrenches: &[BodyWrench],
    ) -> (&[Reaction], &[LoopReaction]) {
        self.ode.drive_at(self.time, Inputs::constant(efforts));
        self.react(position, velocity, bodies, wrenches)
    }

    /// The same under the efforts that the system in joint coordinates has been handed.
    fn react(
        &mut self,
        position: &[f64],
        velocity: &[f64],
        bodies: &[BodyState],
        wrenches: &[BodyWrench],
    ) -> (&[Reaction], &[LoopReaction]) {
        self.accelerate(position, velocity, bodies);
        let ReactionsOnTree { mechanism, accelerations, applied, reactions, loops, closing, .. } = self;
        let mechanism = (*mechanism).borrow();
        body_wrenches(mechanism, self.time, bodies, applied);
        for ((force, torque), (own_force, own_torque)) in applied.iter_mut().zip(wrenches) {
            *force += own_force;
            *torque += own_torque;
        }
        if let Some((closing, _)) = closing {
            for (index, joint) in mechanism.loops.iter().enumerate() {
                let (force, torque) = closing.loop_wrench(index);
                loops[index] = LoopReaction { force, torque };
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
        reactions_under(mechanism, bodies, accelerations, applied, reactions);
        (reactions, loops)
    }
}
