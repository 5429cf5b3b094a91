//! Loop joints in space: which equations each kind has, and where its ends and axes are at the start of a step.
//!
//! A body has the rotation R and the anchor a; the frame of the joint has the point p and the axes A in the body's own frame:
//!
//! ```text
//!     P = x + R p             (m), from the common origin
//!     arm = P − a             (m)
//!     u = column of R A       the axes x, y, z of the frame in the world
//! ```

use crate::equations::loops::{Displaced, Equation, LoopStart};
use crate::equations::origins::common_origin;
use crate::numbers::algebra::{Matrix, Vector};
use crate::numbers::lanes::Lanes;
use crate::stages::start::Start;
use catena_mechanism::description::closure::{Attachment, LoopKind};
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::ground::matrices::{product, times};
use nalgebra::Vector3;

/// A closure in space.
#[derive(Clone)]
pub(crate) struct SpatialLoop {
    attachments: [Attachment; 2],
    /// The axes (0 = x, 1 = y, 2 = z) of the two frames that every equation takes as its directions.
    axes: Vec<[usize; 2]>,
    /// At the start of the step.
    pub start: LoopStart<[f64; 3]>,
}

/// An end of a closure in the world: its point from the common origin, its arm from the body's anchor (m), and its axes.
#[derive(Clone)]
pub(crate) struct End {
    /// P.
    pub point: [f64; 3],
    /// Vector from the anchor of the body.
    pub arm: [f64; 3],
    /// x, y, z.
    pub axes: [[f64; 3]; 3],
}

impl SpatialLoop {
    /// The loops of a mechanism, in the order of their equations in [`LoopKind`]'s table, and with `springs` the lines of its springs.
    pub fn all(mechanism: &Mechanism, springs: bool) -> Vec<Self> {
        let loops = mechanism.loops.iter().map(|joint| Self::new([joint.a, joint.b], equations(joint.kind)));
        let springs = mechanism.forces.point_springs.iter().filter(|_| springs);
        let lines = springs.map(|spring| Self::new([spring.a, spring.b], vec![(Equation::Line(0.0), [0, 0])]));
        loops.chain(lines).collect()
    }

    fn new(attachments: [Attachment; 2], equations: Vec<(Equation, [usize; 2])>) -> Self {
        let (equations, axes): (Vec<_>, Vec<_>) = equations.into_iter().unzip();
        SpatialLoop { start: LoopStart::new(attachments.map(|end| end.body), equations), attachments, axes }
    }

    /// Takes the start of a step; `origins` are the common origins of the parts of all bodies (m).
    pub fn begin(&mut self, start: &Start, origins: &[[f64; 3]]) {
        let origin = common_origin(self.attachments.iter().map(|end| end.body), origins);
        let ends = [0, 1].map(|end: usize| End::new(&self.attachments[end], start, &origin));
        for (side, end) in ends.iter().enumerate() {
            (self.start.points[side], self.start.arms[side]) = (end.point, end.arm);
        }
        for ((_, directions), axes) in self.start.equations.iter_mut().zip(&self.axes) {
            *directions = [ends[0].axes[axes[0]], ends[1].axes[axes[1]]];
        }
    }
}

/// The equations of a loop joint, and their axes on a and b.
fn equations(kind: LoopKind) -> Vec<(Equation, [usize; 2])> {
    let slides = kind.slides().iter().map(|&axis| (Equation::Slide, [axis, axis]));
    let squares = kind.squares().iter().map(|&(on_a, on_b)| (Equation::Square, [on_a, on_b]));
    let distance = match kind {
        LoopKind::Distance(length) => Some((Equation::Distance(length, length), [0, 0])),
        _ => None,
    };
    slides.chain(squares).chain(distance).collect()
}

impl End {
    /// The frame at the start of a step; `origin` is the common origin (m).
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
        End {
            point: (position - Vector3::from(*origin)).into(),
            arm: arm.into(),
            axes: [0, 1, 2].map(|axis| rotation.column(axis).into_owned().into()),
        }
    }
}

/// The pose of a body since the start of the step: `R = (1 + turn) R₀`, and the displacement of its anchor (m).
#[derive(Clone, Copy)]
pub(crate) struct Moved<V> {
    /// `N = R R₀ᵀ − 1`.
    pub turn: Matrix<V>,
    /// Displacement of the anchor.
    pub anchor: Vector<V>,
}

impl<V: Lanes> Moved<V> {
    /// The place of an anchor that starts at `anchor`, from the common origin (m).
    #[inline(always)]
    pub fn anchor_from(&self, anchor: &[f64; 3], origin: &[f64; 3]) -> Vector<V> {
        let from_origin = [anchor[0] - origin[0], anchor[1] - origin[1], anchor[2] - origin[2]];
        Vector::splat(&from_origin).plus(self.anchor)
    }
}

impl<V: Lanes> Displaced<V> for Moved<V> {
    type Vector = Vector<V>;

    #[inline(always)]
    fn turn(&self, v: &[f64; 3]) -> Vector<V> {
        let v = Vector::splat(v);
        self.turn.apply_plus(v, v)
    }

    #[inline(always)]
    fn displacement(&self, arm: &[f64; 3]) -> Vector<V> {
        self.turn.apply_plus(Vector::splat(arm), self.anchor)
    }
}
