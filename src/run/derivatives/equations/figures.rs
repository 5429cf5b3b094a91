//! The figures of a mechanism: all of its constant numbers, each of which may carry derivatives.
//!
//! The residual of a body is linear in its ten inertial numbers, in any frame that is fixed in it:
//!
//! ```text
//!     m = ∫ dm [kg]        p = ∫ r dm [kg m]        P = ∫ r rᵀ dm [kg m²]
//! ```
//!
//! Principal axes have no derivative where moments are equal; these numbers always have one. A frame for each body, which parameters do not move,
//! takes the place of its principal frame.
//!
//! The numbers are always taken in the same order, so that a list of their derivatives belongs to them.

use crate::derivatives::numbers::number::Number;
use crate::derivatives::numbers::vector::{Matrix, Vector};
use crate::mechanism::description::closure::{Attachment, Coordinate, LoopKind};
use crate::mechanism::description::joint::{JointKind, Pose};
use crate::mechanism::description::mechanism::Mechanism;
use nalgebra::{Matrix3, Vector3};

/// A frame: its axes as columns, and its origin (m).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame<T> {
    pub axes: Matrix<T>,
    pub origin: Vector<T>,
}

/// A body and the joint to its parent.
#[derive(Clone, Debug)]
pub struct BodyFigures<T> {
    pub parent: Option<usize>,
    pub kind: JointKind,
    pub position_index: usize,
    pub velocity_index: usize,
    /// kg.
    pub mass: T,
    /// p [kg m].
    pub moment: Vector<T>,
    /// P [kg m²].
    pub second_moments: Matrix<T>,
    pub on_parent: Frame<T>,
    pub on_child: Frame<T>,
}

/// A frame on a body, or in the world.
#[derive(Clone, Copy, Debug)]
pub struct End<T> {
    pub body: Option<usize>,
    pub frame: Frame<T>,
}

/// A joint that closes a loop.
#[derive(Clone, Debug)]
pub struct LoopFigures<T> {
    pub kind: LoopKind,
    pub a: End<T>,
    pub b: End<T>,
    /// The distance, if its kind has one (m).
    pub length: T,
}

/// A coordinate that follows another.
#[derive(Clone, Debug)]
pub struct MimicFigures<T> {
    pub follower: Coordinate,
    pub leader: Coordinate,
    pub multiplier: T,
    pub offset: T,
    /// More leaders with their multipliers.
    pub more: Vec<(Coordinate, T)>,
}

/// `τ = −stiffness · (q − rest)`.
#[derive(Clone, Debug)]
pub struct SpringFigures<T> {
    pub coordinate: Coordinate,
    pub stiffness: T,
    pub rest: T,
}

/// A spring and damper between two points.
#[derive(Clone, Debug)]
pub struct PointSpringFigures<T> {
    pub a: End<T>,
    pub b: End<T>,
    pub stiffness: T,
    pub damping: T,
    pub rest_length: T,
}

/// A constant wrench on a body.
#[derive(Clone, Debug)]
pub struct WrenchFigures<T> {
    pub body: usize,
    pub point: Vector<T>,
    pub force: Vector<T>,
    pub torque: Vector<T>,
}

/// Where the mass of a body is in the list of all numbers; p and P follow it.
pub(crate) fn mass_entry(body: usize) -> usize {
    3 + 37 * body
}

/// The entries of the frames of all joints in the list of all numbers: axes, and then origin, on the parent and on the child.
pub(crate) fn frame_entries(bodies: usize) -> impl Iterator<Item = std::ops::Range<usize>> {
    // Three numbers of gravity; for each body mass, p, P, and two frames of twelve numbers.
    let of_frame = |first: usize| [first..first + 9, first + 9..first + 12];
    (0..bodies).flat_map(move |body| [13, 25].map(|after| of_frame(mass_entry(body) + after))).flatten()
}

/// All constant numbers of a mechanism.
#[derive(Clone, Debug)]
pub struct Figures<T> {
    pub gravity: Vector<T>,
    pub bodies: Vec<BodyFigures<T>>,
    pub loops: Vec<LoopFigures<T>>,
    pub mimics: Vec<MimicFigures<T>>,
    /// Degree of freedom and coefficient.
    pub dampers: Vec<(usize, T)>,
    pub springs: Vec<SpringFigures<T>>,
    /// Degree of freedom and effort.
    pub loads: Vec<(usize, T)>,
    pub point_springs: Vec<PointSpringFigures<T>>,
    pub wrenches: Vec<WrenchFigures<T>>,
    /// Degree of freedom and armature of each rotor.
    pub rotors: Vec<(usize, T)>,
    pub freedoms: usize,
}

impl<T: Number> Figures<T> {
    /// The figures of a mechanism as constants, each body in its own frame.
    pub fn constant(mechanism: &Mechanism) -> Self {
        let frames = vec![Pose::identity(); mechanism.bodies.len()];
        Figures::taken(mechanism, &frames, &mut T::of)
    }

    /// The figures of a mechanism, each number as `take` makes it of the double; `frames` are the frames of the bodies, each in the body's own.
    pub fn taken(mechanism: &Mechanism, frames: &[Pose], take: &mut dyn FnMut(f64) -> T) -> Self {
        let forces = &mechanism.forces;
        let gravity = vector(&mechanism.gravity, take);
        let bodies = mechanism.bodies.iter().enumerate().map(|(index, body)| {
            let own = frames[index].inverse();
            let parent = body.parent.map_or_else(Pose::identity, |parent| frames[parent].inverse());
            let center = own.translation.vector;
            let turn = own.rotation.matrix();
            let about_center = Vector3::repeat(0.5 * body.inertia.sum()) - body.inertia;
            let second = turn * Matrix3::from_diagonal(&about_center) * turn.transpose()
                + body.mass * center * center.transpose();
            let joint = &body.joint;
            BodyFigures {
                parent: body.parent,
                kind: joint.kind,
                position_index: joint.position_index,
                velocity_index: joint.velocity_index,
                mass: take(body.mass),
                moment: vector(&(body.mass * center), take),
                second_moments: matrix(&second, take),
                on_parent: frame(&(parent * joint.on_parent), take),
                on_child: frame(&(own * joint.on_child), take),
            }
        });
        let bodies = bodies.collect();
        let end = |at: &Attachment, take: &mut dyn FnMut(f64) -> T| {
            let own = at.body.map_or_else(Pose::identity, |body| frames[body].inverse());
            End { body: at.body, frame: frame(&(own * at.frame), take) }
        };
        let loops = mechanism.loops.iter().map(|joint| LoopFigures {
            kind: joint.kind,
            a: end(&joint.a, take),
            b: end(&joint.b, take),
            length: take(if let LoopKind::Distance(length) = joint.kind { length } else { 0.0 }),
        });
        let loops = loops.collect();
        let mimics = mechanism.mimics.iter().map(|mimic| MimicFigures {
            follower: mimic.follower,
            leader: mimic.leader,
            multiplier: take(mimic.multiplier),
            offset: take(mimic.offset),
            more: mimic.more.iter().map(|&(own, ratio)| (own, take(ratio))).collect(),
        });
        let mimics = mimics.collect();
        let dampers = forces.joint_dampers.iter().map(|damper| (damper.freedom, take(damper.coefficient))).collect();
        let springs = forces.joint_springs.iter().map(|spring| SpringFigures {
            coordinate: spring.coordinate,
            stiffness: take(spring.stiffness),
            rest: take(spring.rest),
        });
        let springs = springs.collect();
        let loads = forces.joint_loads.iter().map(|load| (load.freedom, take(load.effort))).collect();
        let point_springs = forces.point_springs.iter().map(|spring| PointSpringFigures {
            a: end(&spring.a, take),
            b: end(&spring.b, take),
            stiffness: take(spring.stiffness),
            damping: take(spring.damping),
            rest_length: take(spring.rest_length),
        });
        let point_springs = point_springs.collect();
        let wrenches = forces.wrenches.iter().map(|wrench| WrenchFigures {
            body: wrench.body,
            point: vector(&(frames[wrench.body].inverse() * nalgebra::Point3::from(wrench.point)).coords, take),
            force: vector(&wrench.force, take),
            torque: vector(&wrench.torque, take),
        });
        let wrenches = wrenches.collect();
        let rotors = mechanism.rotors().map(|(freedom, armature)| (freedom, take(armature))).collect();
        let freedoms = mechanism.velocity_count;
        Figures { gravity, bodies, loops, mimics, dampers, springs, loads, point_springs, wrenches, rotors, freedoms }
    }
}

fn vector<T: Number>(of: &Vector3<f64>, take: &mut dyn FnMut(f64) -> T) -> Vector<T> {
    Vector([0, 1, 2].map(|row| take(of[row])))
}

fn matrix<T: Number>(of: &Matrix3<f64>, take: &mut dyn FnMut(f64) -> T) -> Matrix<T> {
    Matrix([0, 1, 2].map(|column| Vector([0, 1, 2].map(|row| take(of[(row, column)])))))
}

/// A frame, each number as `take` makes it of the double.
pub(in crate::derivatives) fn frame<T: Number>(pose: &Pose, take: &mut dyn FnMut(f64) -> T) -> Frame<T> {
    Frame { axes: matrix(pose.rotation.matrix(), take), origin: vector(&pose.translation.vector, take) }
}
