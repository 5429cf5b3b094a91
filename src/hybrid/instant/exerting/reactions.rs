//! The wrenches of joints and loops at an instant ([`crate::instant::exerting::reactions_on_tree`]), computed on the spanning tree with the least
//! work.
//!
//! If equations are redundant, the load of a joint of a loop is not unique. It then depends on which equations have multipliers, that is on which
//! joints are cut, as it does on nature's choice.

use crate::instant::exerting::reactions_elsewhere::ReactionsElsewhere;
pub use crate::instant::exerting::reactions_on_tree::LoopReaction;
use crate::instant::exerting::reactions_on_tree::ReactionsOnTree;
use crate::lobatto::coupled::counted::Counted;
use crate::mechanism::description::body_state::{BodyState, WORLD};
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::contact_point::ContactPoint;
use crate::mechanism::motion::kinematics::{BodyAcceleration, forward_kinematics};
use crate::reduced::Reaction;
use std::borrow::Borrow;
use std::sync::Arc;

/// Works out the reactions of one state after another.
pub struct Reactions<M> {
    way: Way<M>,
    bodies: Vec<BodyState>,
}

/// On which tree.
enum Way<M> {
    OfMechanism(Box<ReactionsOnTree<M>>),
    Elsewhere(Box<ReactionsElsewhere<M>>),
}

impl<M: Borrow<Mechanism>> Reactions<M> {
    /// Sets up a mechanism, of its own or borrowed.
    pub fn new(of: M) -> Self {
        let bodies = vec![WORLD; of.borrow().bodies.len()];
        let way = match ReactionsElsewhere::new(of) {
            Ok(elsewhere) => Way::Elsewhere(Box::new(elsewhere)),
            Err(of) => Way::OfMechanism(Box::new(ReactionsOnTree::new(of))),
        };
        Reactions { way, bodies }
    }

    /// The same on the spanning tree of the mechanism itself, however much work that is.
    pub fn on_its_tree(of: M) -> Self {
        let bodies = vec![WORLD; of.borrow().bodies.len()];
        Reactions { way: Way::OfMechanism(Box::new(ReactionsOnTree::new(of))), bodies }
    }

    /// Takes the count of the closures in the first state that will be asked for.
    pub fn expect_at(&mut self, counted: Option<Arc<Counted>>) {
        if let Way::OfMechanism(reactions) = &mut self.way {
            reactions.expect_at(counted);
        }
    }

    /// Takes the time of the states that follow, for forces that change (s).
    pub fn clock(&mut self, time: f64) {
        match &mut self.way {
            Way::OfMechanism(reactions) => reactions.clock(time),
            Way::Elsewhere(elsewhere) => elsewhere.clock(time),
        }
    }

    /// Takes the efforts of the motors for all states that follow: one entry a motor of the mechanism [N m or N]; before, no motor drives.
    pub fn drive(&mut self, motors: &[f64]) {
        match &mut self.way {
            Way::OfMechanism(reactions) => reactions.drive(motors),
            Way::Elsewhere(elsewhere) => elsewhere.drive(motors),
        }
    }

    /// Takes the contacts of the states that follow, with their forces, as the run that meets these states knows them; `None` if they are to be worked out.
    pub fn touch(&mut self, points: Option<&[ContactPoint]>) {
        match &mut self.way {
            Way::OfMechanism(reactions) => reactions.touch(points),
            Way::Elsewhere(elsewhere) => elsewhere.touch(points),
        }
    }

    /// The acceleration of each body at these positions and velocities, which place the bodies, with all closures and
    /// forces, but without motors, dry friction and limits. Does not allocate.
    pub fn accelerations(&mut self, position: &[f64], velocity: &[f64], bodies: &[BodyState]) -> &[BodyAcceleration] {
        match &mut self.way {
            Way::OfMechanism(reactions) => reactions.accelerations(position, velocity, bodies),
            Way::Elsewhere(elsewhere) => elsewhere.accelerations(position, velocity),
        }
    }

    /// The load of each joint at these positions and velocities, which place the bodies: one entry a body, and the load of each loop. Motors, dry
    /// friction, limits and contacts take part. Does not allocate while no joint is held and no bodies may touch.
    pub fn of_placed(
        &mut self,
        position: &[f64],
        velocity: &[f64],
        bodies: &[BodyState],
    ) -> (&[Reaction], &[LoopReaction]) {
        match &mut self.way {
            Way::OfMechanism(reactions) => reactions.of_placed(position, velocity, bodies),
            Way::Elsewhere(elsewhere) => elsewhere.of_placed(position, velocity, bodies),
        }
    }

    /// The accelerations of the bodies in the state that reactions were asked for last: under all that acts there.
    pub fn accelerated(&mut self) -> &[BodyAcceleration] {
        match &mut self.way {
            Way::OfMechanism(reactions) => reactions.accelerated(),
            Way::Elsewhere(elsewhere) => elsewhere.accelerated(),
        }
    }

    /// The same, for bodies that have not been placed yet.
    pub fn at(&mut self, position: &[f64], velocity: &[f64]) -> (&[Reaction], &[LoopReaction]) {
        let mechanism = match &self.way {
            Way::OfMechanism(reactions) => reactions.mechanism(),
            Way::Elsewhere(elsewhere) => elsewhere.mechanism(),
        };
        let mut bodies = std::mem::take(&mut self.bodies);
        forward_kinematics(mechanism, position, velocity, &mut bodies);
        self.bodies = bodies;
        match &mut self.way {
            Way::OfMechanism(reactions) => reactions.of_placed(position, velocity, &self.bodies),
            Way::Elsewhere(elsewhere) => elsewhere.of_placed(position, velocity, &self.bodies),
        }
    }
}
