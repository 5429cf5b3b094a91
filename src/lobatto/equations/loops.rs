//! The equations of loop joints at all stages: gaps, and the directions in which their multipliers push.
//!
//! With the points `P_a`, `P_b` (m) and axes `x, y, z` of the two frames ([`catena_mechanism::description::closure::LoopJoint`]), `d = P_b − P_a`, every
//! equation has one gradient, a wrench `(f, t)` about the common origin that acts on b, and its opposite on a:
//!
//! ```text
//!     slide along u_a:       g = d · u_a              f = u_a          t = P_b × u_a
//!     u_a square to w_b:     g = u_a · w_b            f = 0            t = w_b × u_a
//!     distance L:            g = (d·d − L²)/2L        f = d / L        t = P_b × d / L
//!     line of a spring:      no gap                   f = d / |d|      t = P_b × d / |d|
//! ```
//!
//! On a the arm is `P_b` too: the direction `u_a` turns with a, which makes up for the gap.

use crate::numbers::algebra::{Matrix, Vector};
use crate::numbers::lanes::Lanes;
use crate::stages::start::Start;
use catena_mechanism::description::closure::{Attachment, LoopKind};
use catena_mechanism::forces::point_spring::NO_LENGTH;
use catena_mechanism::ground::matrices::{product, times};
use nalgebra::Vector3;

/// One equation of a closure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Equation {
    /// The points coincide along an axis (0 = x, 1 = y, 2 = z) of a.
    Slide(usize),
    /// An axis of a is square to an axis of b.
    Square(usize, usize),
    /// The points keep their distance (m).
    Distance(f64),
    /// No equation, but the line of a spring: the direction from a to b.
    Line,
}

/// The equations of a loop joint, in the order of [`LoopKind`]'s table.
pub fn equations(kind: LoopKind) -> Vec<Equation> {
    let slides = kind.slides().iter().map(|&axis| Equation::Slide(axis));
    let squares = kind.squares().iter().map(|&(on_a, on_b)| Equation::Square(on_a, on_b));
    let distance = if let LoopKind::Distance(length) = kind { Some(Equation::Distance(length)) } else { None };
    slides.chain(squares).chain(distance).collect()
}

/// One end of a loop joint at the start of a step, in world axes.
#[derive(Clone, Copy, Debug, Default)]
pub struct EndStart {
    /// The body; `None` is the world.
    pub body: Option<usize>,
    /// The point, from the common origin (m).
    pub point: [f64; 3],
    /// From the body's anchor to the point (m); zero in the world.
    pub arm: [f64; 3],
    /// The frame's axes.
    pub axes: [[f64; 3]; 3],
}

impl EndStart {
    /// The end where the step starts; `origin` is the common origin.
    pub fn new(end: &Attachment, start: &Start, origin: &[f64; 3]) -> Self {
        let frame = end.frame.rotation.matrix();
        let (rotation, position, arm) = match end.body {
            None => (*frame, end.frame.translation.vector, Vector3::zeros()),
            Some(body) => {
                let state = start.body_state(body);
                let reach = times(&state.rotation, &end.frame.translation.vector);
                let arm = reach + Vector3::from(start.bodies[body].com);
                (product(&state.rotation, frame), state.position + reach, arm)
            }
        };
        EndStart {
            body: end.body,
            point: (position - Vector3::from(*origin)).into(),
            arm: arm.into(),
            axes: [0, 1, 2].map(|axis| rotation.column(axis).into_owned().into()),
        }
    }
}

/// Where a body is since the start of the step: `R = (1 + turn) R₀`, and the displacement of its anchor (m).
#[derive(Clone, Copy)]
pub struct Moved<V> {
    /// `N = R R₀ᵀ − 1`.
    pub turn: Matrix<V>,
    /// Displacement of the anchor.
    pub anchor: Vector<V>,
}

/// A gap and its gradient.
#[derive(Clone, Copy)]
pub struct EquationValue<V> {
    /// `g` (m, or the sine of an angle).
    pub gap: V,
    /// Direction of the force on b.
    pub force: Vector<V>,
    /// Its torque about the common origin.
    pub torque: Vector<V>,
}

impl<V: Lanes> EquationValue<V> {
    /// Nothing.
    pub fn zero() -> Self {
        EquationValue { gap: V::zero(), force: Vector::zero(), torque: Vector::zero() }
    }
}

/// A frame at all stages.
struct End<V> {
    point: Vector<V>,
    turn: Option<Matrix<V>>,
}

impl<V: Lanes> End<V> {
    #[inline(always)]
    fn new(start: &EndStart, moved: Option<&Moved<V>>) -> Self {
        let point = Vector::splat(&start.point);
        match moved {
            None => End { point, turn: None },
            Some(moved) => {
                let swing = moved.turn.apply_plus(Vector::splat(&start.arm), moved.anchor);
                End { point: point.plus(swing), turn: Some(moved.turn) }
            }
        }
    }

    #[inline(always)]
    fn axis(&self, start: &EndStart, axis: usize) -> Vector<V> {
        let axis = Vector::splat(&start.axes[axis]);
        match &self.turn {
            None => axis,
            Some(turn) => turn.apply_plus(axis, axis),
        }
    }
}

/// The equations of one loop joint, written to `out` in their order.
#[inline(always)]
pub fn evaluate<V: Lanes>(
    equations: &[Equation],
    ends: &[EndStart; 2],
    moved: [Option<&Moved<V>>; 2],
    out: &mut [EquationValue<V>],
) {
    let a = End::new(&ends[0], moved[0]);
    let b = End::new(&ends[1], moved[1]);
    let apart = b.point.minus(a.point);
    for (equation, out) in equations.iter().zip(out) {
        *out = match *equation {
            Equation::Slide(axis) => {
                let along = a.axis(&ends[0], axis);
                EquationValue { gap: apart.dot(along), force: along, torque: b.point.cross(along) }
            }
            Equation::Square(on_a, on_b) => {
                let (first, second) = (a.axis(&ends[0], on_a), b.axis(&ends[1], on_b));
                EquationValue { gap: first.dot(second), force: Vector::zero(), torque: second.cross(first) }
            }
            Equation::Distance(length) => {
                let inverse = V::splat(1.0 / length);
                let along = apart.times(inverse);
                let gap = (apart.dot(along) - V::splat(length)) * V::splat(0.5);
                EquationValue { gap, force: along, torque: b.point.cross(along) }
            }
            Equation::Line => {
                let length = apart.dot_plus(apart, V::splat(NO_LENGTH)).square_root();
                let along = apart.times(length.reciprocal());
                EquationValue { gap: V::zero(), force: along, torque: b.point.cross(along) }
            }
        };
    }
}
