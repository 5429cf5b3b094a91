//! The plan of the sweeps over a tree: parents, free axes, the slots that gather the inertias of children, and the terms that vanish.

use catena_mechanism::description::joint::FreeRotation;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::description::rules::Rule;
use catena_mechanism::structure::special_bodies::{
    pivoted_bodies, point_bodies, sliding_bodies, spherical_bodies, tumbles,
};
use std::ops::Range;

/// The translations of a body that floats freely, which are known without an iteration.
pub(crate) const TRANSLATIONS: Range<usize> = 0..3;

/// The slot that receives the articulated inertia of a body's children, and how.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Children {
    /// No children.
    None,
    /// One child, which is the next body.
    Next,
    /// Several children: they meet in a slot of their own.
    Slot(usize),
}

/// The constant part of a body: where it hangs and which axes are free.
#[derive(Clone, Debug)]
pub struct BodyPlan {
    /// Parent body, or `None` for the world.
    pub parent: Option<usize>,
    /// The slot in which the parent collects; `Children::None` for the world.
    pub parent_collects: Children,
    /// Whether this is the last child of its parent, which the backward sweep meets first.
    pub first_collected: bool,
    /// How the children's inertia arrives.
    pub children: Children,
    /// First degree of freedom.
    pub first_axis: usize,
    /// Number of free translations.
    pub translations: usize,
    /// Which rotations are free.
    pub rotation: FreeRotation,
    /// Which of the bodies on hinges that the world holds this is, if it is one.
    pub pivot: Option<usize>,
    /// Whether the body is known never to turn, and whether its parent is; the world never does.
    pub slides: bool,
    pub parent_slides: bool,
    /// Whether the mass is known to be at a point.
    pub point: bool,
    /// Whether the inertia about the centre of mass is known to be the same about all axes.
    pub spherical: bool,
}

impl BodyPlan {
    /// The parent, unless it is known never to turn.
    #[inline(always)]
    pub fn turning_parent(&self) -> Option<usize> {
        self.parent.filter(|_| !self.parent_slides)
    }

    /// The degrees of freedom of the joint.
    pub fn freedoms(&self) -> std::ops::Range<usize> {
        let rotations = match self.rotation {
            FreeRotation::None => 0,
            FreeRotation::AboutZ => 1,
            FreeRotation::Ball => 3,
        };
        self.first_axis..self.first_axis + self.translations + rotations
    }
}

/// The plan of the sweeps over a mechanism; constant.
#[derive(Clone)]
pub struct Plan {
    /// One entry a body.
    pub bodies: Vec<BodyPlan>,
    /// Number of slots where children of branching bodies meet.
    pub slots: usize,
    /// Whether the mechanism is one body that floats freely ([`crate::solve::free_body`]).
    pub tumbles: bool,
}

impl Plan {
    /// Plans the sweeps over a mechanism.
    pub fn new(mechanism: &Mechanism) -> Self {
        let count = mechanism.bodies.len();
        let mut child_count = vec![0_usize; count];
        for body in &mechanism.bodies {
            if let Some(parent) = body.parent {
                child_count[parent] += 1;
            }
        }
        let mut slots = 0;
        let children: Vec<Children> = child_count
            .iter()
            .map(|&number| match number {
                0 => Children::None,
                1 => Children::Next,
                _ => {
                    slots += 1;
                    Children::Slot(slots - 1)
                }
            })
            .collect();
        let mut collected = vec![false; count];
        let mut plans: Vec<BodyPlan> = mechanism
            .bodies
            .iter()
            .enumerate()
            .rev()
            .map(|(index, body)| BodyPlan {
                parent: body.parent,
                parent_collects: body.parent.map_or(Children::None, |parent| children[parent]),
                first_collected: body.parent.is_some_and(|parent| !std::mem::replace(&mut collected[parent], true)),
                children: children[index],
                first_axis: body.joint.velocity_index,
                translations: body.joint.kind.translation_axes().len(),
                rotation: body.joint.kind.rotation(),
                pivot: None,
                slides: false,
                parent_slides: body.parent.is_none(),
                point: false,
                spherical: false,
            })
            .collect();
        plans.reverse();
        Plan { bodies: plans, slots, tumbles: false }
    }

    /// The same with the simplification rules, but for the rules that are `kept` from it.
    pub fn lean(mechanism: &Mechanism, kept: &[Rule]) -> Self {
        let mut plan = Plan::new(mechanism);
        if !kept.contains(&Rule::Translation) {
            let sliding = sliding_bodies(mechanism);
            for (own, &slides) in plan.bodies.iter_mut().zip(&sliding) {
                own.slides = slides;
                own.parent_slides = own.parent.is_none_or(|parent| sliding[parent]);
            }
        }
        if !kept.contains(&Rule::Points) {
            plan.bodies.iter_mut().zip(point_bodies(mechanism)).for_each(|(own, point)| own.point = point);
        }
        if !kept.contains(&Rule::Spheres) {
            plan.bodies.iter_mut().zip(spherical_bodies(mechanism)).for_each(|(own, round)| own.spherical = round);
        }
        if !kept.contains(&Rule::Pivots) {
            let pivoted = plan.bodies.iter_mut().zip(pivoted_bodies(mechanism)).filter(|(_, pivoted)| *pivoted);
            pivoted.enumerate().for_each(|(pivot, (own, _))| own.pivot = Some(pivot));
        }
        plan.tumbles = !kept.contains(&Rule::Tumblers) && tumbles(mechanism);
        plan
    }

    /// The slot with the sum of the children's inertias: one of the first for a branching body, the next after those for an only child, and the last,
    /// which is always zero, without children.
    #[inline(always)]
    pub fn below(&self, body: usize) -> usize {
        match self.bodies[body].children {
            Children::Slot(slot) => slot,
            Children::Next => self.slots,
            Children::None => self.slots + 1,
        }
    }

    /// How many of the degrees of freedom, the first ones, are known without an iteration.
    #[inline(always)]
    pub fn known(&self) -> usize {
        if self.tumbles { TRANSLATIONS.len() } else { 0 }
    }

    /// The first of the three rotations of every ball joint, counted from the first freedom that is iterated.
    pub fn balls(&self) -> Vec<usize> {
        let balls = self.bodies.iter().filter(|body| body.rotation == FreeRotation::Ball);
        balls.map(|body| body.first_axis + body.translations - self.known()).collect()
    }
}
