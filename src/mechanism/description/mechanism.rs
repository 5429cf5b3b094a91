//! The mechanism: the constant data of a simulation.
//!
//! A tree of rigid bodies, numbered depth first: a parent comes before its children and a subtree is contiguous.
//! Each body's frame sits at its centre of mass with its axes along the principal axes of inertia, so that the
//! body inertia is `J = diag(J₁, J₂, J₃)` [kg m²] and `Σ = ½ tr(J) 1 − J` is diagonal too.

use crate::description::closure::{Attachment, JointLimit, LoopJoint, Mimic};
use crate::description::contact::{Grip, TouchJoint};
use crate::description::forces::Forces;
use crate::description::joint::Joint;
use crate::description::nonsmooth::Nonsmooth;
use nalgebra::Vector3;

/// A rigid body and the joint to its parent.
#[derive(Clone, Debug)]
pub struct Body {
    /// Name of the link that heads this body.
    pub name: String,
    /// Index of the parent body; `None` is the world.
    pub parent: Option<usize>,
    /// Mass (kg).
    pub mass: f64,
    /// Principal moments of inertia about the centre of mass [kg m²].
    pub inertia: Vector3<f64>,
    /// The joint to the parent.
    pub joint: Joint,
}

/// The constant description of bodies, their joints, and the forces on them.
#[derive(Clone, Debug)]
pub struct Mechanism {
    /// Name of the robot or scene.
    pub name: String,
    /// Acceleration of gravity in the world [m/s²].
    pub gravity: Vector3<f64>,
    /// The bodies, depth first.
    pub bodies: Vec<Body>,
    /// Joints that close loops of the tree.
    pub loops: Vec<LoopJoint>,
    /// Contacts that are closed. Their equations come after the equations of the loops, and before the mimics.
    pub touches: Vec<TouchJoint>,
    /// Joint coordinates that follow others.
    pub mimics: Vec<Mimic>,
    /// Forces besides gravity.
    pub forces: Forces,
    /// Limits of joints, within which closed loops are assembled.
    pub limits: Vec<JointLimit>,
    /// Causes of nonsmooth motion: limits that stop it, dry friction, motors.
    pub nonsmooth: Nonsmooth,
    /// Length of the position vector.
    pub position_count: usize,
    /// Number of degrees of freedom: length of the velocity vector.
    pub velocity_count: usize,
}

/// Why a list of bodies is not a mechanism.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum MechanismError {
    /// The numbering is not depth first.
    #[error("body {body:?} (number {index}): its parent must come before it, and every subtree must be contiguous")]
    Order { body: String, index: usize },
    /// A mass or moment of inertia is negative or not finite.
    #[error("body {body:?}: mass {mass} kg and principal inertia {inertia:?} kg m² must be finite and not negative")]
    Inertia { body: String, mass: f64, inertia: [f64; 3] },
}

impl Mechanism {
    /// Numbers the joints' places in the state vectors and checks the order of the bodies.
    ///
    /// # Errors
    /// [`MechanismError::Order`] if the bodies are not depth first, [`MechanismError::Inertia`] for impossible masses.
    pub fn new(name: &str, gravity: Vector3<f64>, mut bodies: Vec<Body>) -> Result<Self, MechanismError> {
        let (mut position_count, mut velocity_count) = (0, 0);
        let mut branch: Vec<usize> = Vec::new();
        for (index, body) in bodies.iter_mut().enumerate() {
            while branch.last().copied() != body.parent && branch.pop().is_some() {}
            if branch.last().copied() != body.parent {
                return Err(MechanismError::Order { body: body.name.clone(), index });
            }
            branch.push(index);
            let numbers = [body.mass, body.inertia.x, body.inertia.y, body.inertia.z];
            if numbers.iter().any(|value| !value.is_finite()) || body.mass < 0.0 {
                return Err(MechanismError::Inertia {
                    body: body.name.clone(),
                    mass: body.mass,
                    inertia: body.inertia.into(),
                });
            }
            body.joint.position_index = position_count;
            body.joint.velocity_index = velocity_count;
            position_count += body.joint.kind.position_count();
            velocity_count += body.joint.kind.velocity_count();
        }
        Ok(Mechanism {
            name: name.to_string(),
            gravity,
            bodies,
            loops: Vec::new(),
            touches: Vec::new(),
            mimics: Vec::new(),
            forces: Forces::default(),
            limits: Vec::new(),
            nonsmooth: Nonsmooth::default(),
            position_count,
            velocity_count,
        })
    }

    /// Whether the tree of joints under gravity is all there is.
    #[inline]
    pub fn is_plain_tree(&self) -> bool {
        !self.has_closures() && self.is_unforced()
    }

    /// Whether the bodies under gravity are all that joints feel: no forces act, and no rotors turn.
    #[inline]
    pub fn is_unforced(&self) -> bool {
        self.forces.is_empty() && self.rotors().next().is_none()
    }

    /// The degree of freedom and the armature of every joint that turns a rotor.
    pub fn rotors(&self) -> impl Iterator<Item = (usize, f64)> {
        let turning = self.bodies.iter().map(|body| &body.joint).filter(|joint| joint.armature != 0.0);
        turning.map(|joint| (joint.velocity_index, joint.armature))
    }

    /// Whether there are equations between coordinates that the tree does not have.
    #[inline]
    pub fn has_closures(&self) -> bool {
        !self.loops.is_empty() || !self.touches.is_empty() || !self.mimics.is_empty()
    }

    /// The next instant after `time` at which a force or a motion in time jumps or has a kink (s).
    pub fn next_instant(&self, time: f64) -> f64 {
        let moved = self.mimics.iter().filter_map(|mimic| mimic.over_time.as_ref());
        moved.map(|motion| motion.next_knot(time)).fold(self.forces.next_instant(time), f64::min)
    }

    /// The longest step from a time on, of `step` seconds at most, over which stages resolve all forces and motions in time; the run goes on to
    /// `until` (s).
    pub fn resolved_step(&self, time: f64, step: f64, until: f64) -> f64 {
        let moved = self.mimics.iter().filter_map(|mimic| mimic.over_time.as_ref());
        moved.fold(self.forces.resolved_step(time, step, until), |step, motion| motion.resolved_step(time, step, until))
    }

    /// Whether forces change in time or joints are moved.
    pub fn changes(&self) -> bool {
        self.forces.change() || self.moves_joints()
    }

    /// Whether joints are moved in time.
    pub fn moves_joints(&self) -> bool {
        self.mimics.iter().any(Mimic::is_moved)
    }

    /// The two ends of every loop joint and then of every closed contact, in the order of their equations.
    pub fn closing_ends(&self) -> impl Iterator<Item = [&Attachment; 2]> {
        let loops = self.loops.iter().map(|joint| [&joint.a, &joint.b]);
        loops.chain(self.touches.iter().map(|joint| [&joint.a, &joint.b]))
    }

    /// The closed contacts that slide with friction.
    pub fn rubbing(&self) -> impl Iterator<Item = &TouchJoint> {
        self.touches.iter().filter(|joint| joint.touch.friction() != 0.0)
    }

    /// Whether friction holds a closed contact while it brakes another one on one of its bodies: the load of that must not be borne by what holds.
    pub fn holds_beside_rubbing(&self, joint: &TouchJoint) -> bool {
        joint.touch.grip == Grip::Rolls && self.rubbing().any(|other| other.shares_a_body(joint))
    }

    /// The motions that friction brakes at closed contacts and whose direction can turn: slips, then turnings across the normal.
    pub fn braked(&self) -> impl Iterator<Item = &TouchJoint> {
        self.rubbing()
            .chain(self.touches.iter().filter(|joint| joint.touch.rows() > 0 && joint.moments.brakes_rolling()))
    }

    /// The body whose joint has this name.
    pub fn body_of_joint(&self, joint: &str) -> Option<usize> {
        self.bodies.iter().position(|body| body.joint.name == joint)
    }

    /// The body whose joint has this degree of freedom.
    #[inline]
    pub fn body_of_freedom(&self, freedom: usize) -> Option<usize> {
        let after = self.bodies.partition_point(|body| body.joint.velocity_index <= freedom);
        after.checked_sub(1).filter(|_| freedom < self.velocity_count)
    }

    /// The name of the joint that has this degree of freedom; empty if there is none.
    pub fn joint_of_freedom(&self, freedom: usize) -> &str {
        self.body_of_freedom(freedom).map_or("", |body| &self.bodies[body].joint.name)
    }

    /// A body and all bodies beyond its joint in the tree.
    pub fn subtree(&self, head: usize) -> std::ops::Range<usize> {
        let is_beyond = |body: &Body| body.parent.is_some_and(|parent| parent >= head);
        let after = self.bodies.iter().skip(head + 1).take_while(|body| is_beyond(body)).count();
        head..head + 1 + after
    }

    /// Total mass of the moving bodies (kg).
    pub fn total_mass(&self) -> f64 {
        self.bodies.iter().map(|body| body.mass).sum()
    }
}
