//! The graph of bodies and joints, and its spanning trees.
//!
//! The nodes are the bodies and the world, the edges the joints: the joints of the file's tree, and the loop joints that could as well be joints of a
//! tree. A spanning tree hangs every body on one edge; all other edges are cut, which makes them closures. The choice of the cut edges changes only
//! the coordinates and the cost of a step.
//!
//! Not every joint can be cut: forces, mimic relations and efforts along its own coordinate need that coordinate. Not every loop joint can carry a
//! body: there are no tree joints that are universal, cylindrical, fixed or of one distance. In a plane every loop joint that holds two points
//! together is a hinge.

use crate::description::body_state::BodyState;
use crate::description::closure::{Attachment, LoopJoint, LoopKind};
use crate::description::joint::{JointKind, Pose};
use crate::description::mechanism::{Body, Mechanism};
use crate::description::nonsmooth::Nonsmooth;
use crate::motion::kinematics::body_states;
use crate::motion::state::State;
use crate::structure::planar_loops::PlanarEquation;
use crate::structure::plane::Plane;
use nalgebra::{Matrix3, Rotation3, Translation3};

/// A joint of the graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Edge {
    /// The joint of this body in the file's tree.
    Tree(usize),
    /// This loop joint.
    Loop(usize),
}

/// The edge by which a body hangs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hang {
    /// The body above; `None` is the world.
    pub parent: Option<usize>,
    /// The joint between them.
    pub by: Edge,
    /// Whether the joint's first end, which is the parent of the file's tree, is on this body.
    pub backwards: bool,
}

/// A spanning tree.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SpanningTree {
    /// The edge of every body, by its number in the file's tree.
    pub hangs: Vec<Hang>,
    /// The bodies by these numbers, depth first.
    pub order: Vec<usize>,
}

impl SpanningTree {
    /// The file's.
    pub fn of_file(mechanism: &Mechanism) -> Self {
        let bodies = mechanism.bodies.iter().enumerate();
        let hangs = bodies.map(|(body, own)| Hang { parent: own.parent, by: Edge::Tree(body), backwards: false });
        SpanningTree { hangs: hangs.collect(), order: (0..mechanism.bodies.len()).collect() }
    }

    /// The joints of the file's tree that it cuts, by their bodies.
    pub fn cut_joints(&self) -> impl Iterator<Item = usize> {
        let kept = |&body: &usize| self.hangs.iter().any(|hang| hang.by == Edge::Tree(body));
        (0..self.hangs.len()).filter(move |body| !kept(body))
    }

    /// The loop joints that bodies hang on.
    pub fn hung_loops(&self) -> impl Iterator<Item = usize> {
        self.hangs.iter().filter_map(|hang| match hang.by {
            Edge::Loop(index) => Some(index),
            Edge::Tree(_) => None,
        })
    }
}

/// An edge and its cost.
#[derive(Clone, Copy, Debug)]
pub struct Link {
    /// The joint; `None` for links that only close: contacts, springs, mimic relations and loop joints that no body can hang on.
    pub edge: Option<Edge>,
    /// Its two ends; `None` is the world.
    pub ends: [Option<usize>; 2],
    /// Degrees of freedom as a joint of a tree.
    pub freedoms: usize,
    /// Equations as a closure.
    pub rows: usize,
    /// Whether it must stay in the tree.
    pub fixed: bool,
}

/// The graph of a mechanism.
#[derive(Clone, Debug)]
pub struct Graph {
    /// The joint of every body, then everything that closes.
    pub links: Vec<Link>,
    /// Number of bodies.
    pub bodies: usize,
    /// Components of a twist: three in a plane, six in space.
    pub width: usize,
}

impl Graph {
    /// The graph of a mechanism, which moves in this plane or in space.
    pub fn new(mechanism: &Mechanism, plane: Option<&Plane>) -> Self {
        let zero = body_states(mechanism, &State::zero(mechanism));
        let rows = |joint: &LoopJoint| match plane {
            Some(plane) => plane.equations(joint, &zero).map_or(joint.kind.rows(), |equations| equations.len()),
            None => joint.kind.rows(),
        };
        let fixed = fixed_joints(mechanism);
        let mut links = Vec::new();
        for (index, body) in mechanism.bodies.iter().enumerate() {
            let closure = as_closure(body, index);
            links.push(Link {
                edge: Some(Edge::Tree(index)),
                ends: [body.parent, Some(index)],
                freedoms: body.joint.kind.velocity_count(),
                rows: closure.as_ref().map_or(0, rows),
                fixed: fixed[index] || closure.is_none(),
            });
        }
        for (index, joint) in mechanism.loops.iter().enumerate() {
            let as_joint = hanging(joint, plane, &zero);
            links.push(Link {
                edge: as_joint.map(|_| Edge::Loop(index)),
                ends: [joint.a.body, joint.b.body],
                freedoms: as_joint.map_or(0, |(kind, _)| kind.velocity_count()),
                rows: rows(joint),
                fixed: false,
            });
        }
        let only_closes =
            |ends: [Option<usize>; 2], rows: usize| Link { edge: None, ends, freedoms: 0, rows, fixed: false };
        let contacts = mechanism.touches.iter();
        links.extend(contacts.flat_map(|joint| {
            let next = joint.points().skip(1);
            let parts = joint.points().zip(next).map(|(one, other)| [one.body, other.body]);
            parts.filter(|[one, other]| one != other || !joint.is_reeved()).map(|ends| only_closes(ends, joint.rows()))
        }));
        let mimics = mechanism.mimics.iter().filter(|mimic| !mimic.is_moved());
        links.extend(mimics.map(|mimic| only_closes([Some(mimic.follower.body), Some(mimic.leader.body)], 1)));
        let more =
            mechanism.mimics.iter().flat_map(|mimic| mimic.more.iter().map(|(own, _)| (mimic.follower.body, own.body)));
        links.extend(more.map(|(one, other)| only_closes([Some(one), Some(other)], 1)));
        let springs = mechanism.forces.point_springs.iter();
        links.extend(springs.map(|spring| only_closes([spring.a.body, spring.b.body], 1)));
        Graph { links, bodies: mechanism.bodies.len(), width: if plane.is_some() { 3 } else { 6 } }
    }

    /// Keeps the joint of this body in the tree.
    pub fn keep(&mut self, body: usize) {
        self.links[body].fixed = true;
    }

    /// Whether a tree reverses a joint that must stay and that has coordinates of its own on either end: efforts could not act along them.
    pub fn turns(&self, mechanism: &Mechanism, tree: &SpanningTree) -> bool {
        tree.hangs.iter().any(|hang| match hang.by {
            Edge::Tree(of) => {
                hang.backwards && self.links[of].fixed && mechanism.bodies[of].joint.kind.position_count() > 1
            }
            Edge::Loop(_) => false,
        })
    }

    /// Whether there is an edge besides the edges of the file's tree.
    pub fn has_choice(&self) -> bool {
        self.links[self.bodies..].iter().any(|link| link.edge.is_some())
    }
}

/// For every body whether something acts along a coordinate of its own joint; limits alone do not while they are not met.
fn fixed_joints(mechanism: &Mechanism) -> Vec<bool> {
    let mut fixed = vec![false; mechanism.bodies.len()];
    let forces = &mechanism.forces;
    let freedoms = forces.joint_dampers.iter().map(|damper| damper.freedom);
    let freedoms = freedoms.chain(forces.joint_loads.iter().map(|load| load.freedom));
    let freedoms = freedoms.chain(forces.joint_courses.iter().map(|load| load.freedom));
    let freedoms = freedoms.chain(forces.gravity_compensations.iter().map(|holding| holding.freedom));
    let bodies = freedoms.filter_map(|freedom| mechanism.body_of_freedom(freedom));
    let bodies = bodies.chain(forces.joint_springs.iter().map(|spring| spring.coordinate.body));
    let Nonsmooth { friction, motors, .. } = &mechanism.nonsmooth;
    let bodies = bodies.chain(friction.iter().map(|friction| friction.coordinate.body));
    let bodies = bodies.chain(motors.iter().map(|motor| motor.coordinate.body));
    let bodies = bodies.chain(mechanism.rotors().filter_map(|(freedom, _)| mechanism.body_of_freedom(freedom)));
    for body in bodies.chain(mechanism.mimics.iter().flat_map(|mimic| mimic.terms().map(|(own, _)| own.body))) {
        fixed[body] = true;
    }
    fixed
}

/// The joint of a body as a loop joint; `None` for one that leaves everything free.
pub fn as_closure(body: &Body, index: usize) -> Option<LoopJoint> {
    let joint = &body.joint;
    let kind = match joint.kind {
        JointKind::Revolute => LoopKind::Revolute,
        JointKind::Prismatic => LoopKind::Prismatic,
        JointKind::Planar => LoopKind::Planar,
        JointKind::Spherical => LoopKind::Spherical,
        JointKind::Floating => return None,
    };
    let a = Attachment { body: body.parent, frame: joint.on_parent };
    let b = Attachment { body: Some(index), frame: joint.on_child };
    Some(LoopJoint { name: joint.name.clone(), kind, a, b })
}

/// A loop joint as a joint of a tree: its kind, and its frames on both ends; `None` if no tree joint is like it. `zero` are the bodies at zero
/// displacement.
pub fn hanging(joint: &LoopJoint, plane: Option<&Plane>, zero: &[BodyState]) -> Option<(JointKind, [Pose; 2])> {
    if joint.a.body == joint.b.body {
        return None;
    }
    let frames = [joint.a.frame, joint.b.frame];
    if let Some(plane) = plane {
        let level = matches!(joint.kind, LoopKind::Revolute | LoopKind::Spherical | LoopKind::Universal);
        let equations = plane.equations(joint, zero)?;
        if level && matches!(equations[..], [PlanarEquation::Slide(_), PlanarEquation::Slide(_)]) {
            let axes = Matrix3::from_columns(&plane.axes);
            let hinge = [&joint.a, &joint.b].map(|end| {
                let turn = Rotation3::from_matrix_unchecked(end.on(zero).rotation.tr_mul(&axes));
                Pose::from_parts(Translation3::from(end.frame.translation.vector), turn)
            });
            return Some((JointKind::Revolute, hinge));
        }
    }
    match joint.kind {
        LoopKind::Revolute => Some((JointKind::Revolute, frames)),
        LoopKind::Prismatic => Some((JointKind::Prismatic, frames)),
        LoopKind::Planar => Some((JointKind::Planar, frames)),
        // A ball joint would leave the plane.
        LoopKind::Spherical if plane.is_none() => Some((JointKind::Spherical, frames)),
        _ => None,
    }
}
