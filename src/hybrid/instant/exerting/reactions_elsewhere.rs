//! Reactions computed on another spanning tree than the file's ([`crate::stepping::trees::other_tree`]), and assigned to the joints of the file.
//!
//! A joint that closes a loop on one tree and carries a body on the other exerts the same: force F on its second end, and torque T about that end's
//! point `P_b`. If a joint turns round in the tree, the computed wrench acts on its first end, about `P_a`:
//!
//! ```text
//!     F_b = −F_a        T_b = −(T_a + (P_a − P_b) × F_a)
//! ```
//!
//! Motors, friction, limits and contacts exert the efforts of the file's tree ([`crate::instant::exerting::exerted`]). Along the axis of a joint that
//! is cut the effort acts as a pair of wrenches, and is part of the load of the joint.

use crate::instant::exerting::exerted::Exerted;
use crate::instant::exerting::reactions_on_tree::{LoopReaction, ReactionsOnTree};
use crate::mechanism::description::body_state::{BodyState, WORLD};
use crate::mechanism::description::closure::Attachment;
use crate::mechanism::description::mechanism::{Body, Mechanism};
use crate::mechanism::description::rules::Rule;
use crate::mechanism::forces::total::BodyWrench;
use crate::mechanism::motion::contact_point::ContactPoint;
use crate::mechanism::motion::efforts::efforts_of_wrenches;
use crate::mechanism::motion::kinematics::{BodyAcceleration, place_bodies};
use crate::mechanism::motion::state::State;
use crate::mechanism::structure::other_efforts::exert;
use crate::mechanism::structure::other_tree::{Found, OtherTree};
use crate::mechanism::structure::spanning_tree::SpanningTree;
use crate::reduced::Reaction;
use crate::stepping::trees::other_tree::other_tree;
use nalgebra::Vector3;
use std::borrow::Borrow;

/// The workspace of one mechanism.
pub(crate) struct ReactionsElsewhere<M> {
    mechanism: M,
    tree: SpanningTree,
    other: OtherTree,
    inside: Box<ReactionsOnTree<Mechanism>>,
    state: State,
    own: State,
    bodies: Vec<BodyState>,
    accelerations: Vec<BodyAcceleration>,
    reactions: Vec<Reaction>,
    loops: Vec<LoopReaction>,
    exerted: Option<Exerted>,
    /// The efforts of motors.
    motors: Vec<f64>,
    /// Efforts and wrenches on the other tree, and the wrenches along the axes of joints that are cut.
    efforts: Vec<f64>,
    wrenches: Vec<BodyWrench>,
    along: Vec<BodyWrench>,
    /// Whether a state has told which way the axes of loop joints point.
    met: bool,
}

/// The mechanism on the other tree, with efforts from outside if there may be any.
fn driven(other: &OtherTree, acts: bool) -> Mechanism {
    let mut mechanism = other.mechanism.clone();
    mechanism.forces.driven |= acts;
    mechanism
}

impl<M: Borrow<Mechanism>> ReactionsElsewhere<M> {
    /// For a mechanism; gives it back if its own tree is as good.
    pub fn new(of: M) -> Result<Self, M> {
        let mechanism = of.borrow();
        // In space, because loads across a plane are asked for, too.
        let found = other_tree(mechanism, &[], &[Rule::Planar]);
        let other = found.and_then(|(tree, _)| {
            let other = OtherTree::new(mechanism, &tree, None, &State::zero(mechanism)).ok()?;
            Some((tree, other))
        });
        let Some((tree, other)) = other else { return Err(of) };
        let count = mechanism.bodies.len();
        let exerted = Exerted::new(mechanism);
        Ok(ReactionsElsewhere {
            inside: Box::new(ReactionsOnTree::new(driven(&other, exerted.is_some()))),
            state: State::zero(mechanism),
            own: State::zero(&other.mechanism),
            bodies: vec![WORLD; count],
            accelerations: vec![BodyAcceleration::default(); count],
            reactions: vec![Reaction::default(); count],
            loops: vec![LoopReaction::default(); mechanism.loops.len()],
            motors: Vec::with_capacity(mechanism.nonsmooth.motors.len()),
            efforts: vec![0.0; other.mechanism.velocity_count],
            wrenches: vec![BodyWrench::default(); count],
            along: vec![BodyWrench::default(); count],
            exerted,
            met: false,
            tree,
            other,
            mechanism: of,
        })
    }

    /// The mechanism.
    pub fn mechanism(&self) -> &Mechanism {
        self.mechanism.borrow()
    }

    /// Takes a state of the mechanism.
    fn take(&mut self, position: &[f64], velocity: &[f64]) {
        let ReactionsElsewhere { mechanism, tree, other, inside, state, own, bodies, met, exerted, .. } = self;
        let mechanism = (*mechanism).borrow();
        state.position.copy_from_slice(position);
        state.velocity.copy_from_slice(velocity);
        if !std::mem::replace(met, true)
            && !other.fits(mechanism, tree, None, state)
            && let Ok(fitting) = OtherTree::new(mechanism, tree, None, state)
        {
            **inside = ReactionsOnTree::new(driven(&fitting, exerted.is_some()));
            *other = fitting;
        }
        other.take(mechanism, state, own);
        place_bodies(&other.mechanism, own, bodies);
    }

    /// Takes the time of the states that follow (s).
    pub fn clock(&mut self, time: f64) {
        (self.state.time, self.own.time) = (time, time);
        self.inside.clock(time);
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

    /// Takes over what motors, friction, limits and contacts exert in the state that was taken last; returns whether anything of it may.
    fn exert(&mut self, position: &[f64], velocity: &[f64]) -> bool {
        let ReactionsElsewhere { mechanism, other, own, bodies, exerted, motors, efforts, wrenches, along, .. } = self;
        let Some(exerted) = exerted else { return false };
        let mechanism = (*mechanism).borrow();
        let (_, contacts) = exerted.at(position, velocity, motors);
        for (body, wrench) in contacts.iter().enumerate() {
            wrenches[other.number(body)] = *wrench;
        }
        let in_joints = exerted.in_joints();
        other.take_efforts(mechanism, own, in_joints, efforts);
        // The efforts of contacts on the file's tree would give loops wrong loads.
        if wrenches.iter().any(|wrench| *wrench != BodyWrench::default()) {
            let (mut on_subtrees, mut of_contacts) = (wrenches.clone(), vec![0.0; efforts.len()]);
            efforts_of_wrenches(&other.mechanism, bodies, &mut on_subtrees, &mut of_contacts);
            efforts.iter_mut().zip(of_contacts).for_each(|(effort, own)| *effort += own);
        }
        along.fill(BodyWrench::default());
        for &body in other.computed() {
            let Body { parent, joint, .. } = &mechanism.bodies[body];
            let own_efforts = &in_joints[joint.velocity_range()];
            if matches!(other.joint(body), Found::Closes(_)) && own_efforts.iter().any(|&effort| effort != 0.0) {
                let ends = [parent.map(|parent| other.number(parent)), Some(other.number(body))];
                along[body] = exert(joint, ends, bodies, own_efforts, wrenches);
            }
        }
        true
    }

    /// The acceleration of each body at these positions and velocities.
    pub fn accelerations(&mut self, position: &[f64], velocity: &[f64]) -> &[BodyAcceleration] {
        self.take(position, velocity);
        let there = self.inside.accelerations(&self.own.position, &self.own.velocity, &self.bodies);
        for (body, own) in self.accelerations.iter_mut().enumerate() {
            *own = there[self.other.number(body)];
        }
        &self.accelerations
    }

    /// The accelerations of the bodies that were computed last.
    pub fn accelerated(&mut self) -> &[BodyAcceleration] {
        let there = self.inside.accelerated();
        for (body, own) in self.accelerations.iter_mut().enumerate() {
            *own = there[self.other.number(body)];
        }
        &self.accelerations
    }

    /// The load of each joint and each loop at these positions and velocities, which place the bodies.
    pub fn of_placed(
        &mut self,
        position: &[f64],
        velocity: &[f64],
        bodies: &[BodyState],
    ) -> (&[Reaction], &[LoopReaction]) {
        self.take(position, velocity);
        let acts = self.exert(position, velocity);
        let ReactionsElsewhere { mechanism, other, inside, own, bodies: placed, reactions, loops, along, .. } = self;
        let mechanism = (*mechanism).borrow();
        let (joints, closures) = if acts {
            inside.of_placed_under(&own.position, &own.velocity, placed, &self.efforts, &self.wrenches)
        } else {
            inside.of_placed(&own.position, &own.velocity, placed)
        };
        let point = |body: Option<usize>, at: &Vector3<f64>| {
            let on = body.map_or(&WORLD, |body| &bodies[body]);
            on.position + on.rotation * at
        };
        let exerted = |found: Found, from: Vector3<f64>, to: Vector3<f64>| match found {
            Found::Carries { body, backwards: false } => (joints[body].force, joints[body].torque),
            Found::Carries { body, backwards: true } => {
                let Reaction { force, torque, .. } = joints[body];
                (-force, -(torque + (from - to).cross(&force)))
            }
            Found::Closes(index) => (closures[index].force, closures[index].torque),
        };
        for (index, (own, body)) in reactions.iter_mut().zip(&mechanism.bodies).enumerate() {
            let anchor = point(Some(index), &body.joint.on_child.translation.vector);
            let from = point(body.parent, &body.joint.on_parent.translation.vector);
            let (force, torque) = exerted(other.joint(index), from, anchor);
            let (force, torque) = (force + along[index].0, torque + along[index].1);
            *own = Reaction { anchor, force, torque };
        }
        let ends = |end: &Attachment| point(end.body, &end.frame.translation.vector);
        for (index, (own, joint)) in loops.iter_mut().zip(&mechanism.loops).enumerate() {
            let (force, torque) = exerted(other.closing(index), ends(&joint.a), ends(&joint.b));
            *own = LoopReaction { force, torque };
        }
        (reactions, loops)
    }
}
