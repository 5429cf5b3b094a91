//! The places of all bodies, joint by joint, as in [`crate::mechanism::description::joint`], over numbers with derivatives.
//!
//! ```text
//!     R = R_p F_p.R Rj F_c.Rᵀ        a = x_p + R_p (F_p.t + F_p.R t)        x = a − R F_c.t
//! ```
//!
//! A motion starts in a known state. Each degree of freedom moves from there by an offset; a ball joint turns by the product of slight rotations
//! about the axes of the child, `Rj = Rj₀ exp(δ̂) exp(θ̂)`. Offsets are zero but for their derivatives, so that with θ = w t + ẇ t²/2 the velocity of
//! a ball joint is w, and its acceleration ẇ.

use crate::derivatives::equations::figures::{BodyFigures, End, Figures, Frame};
use crate::derivatives::numbers::number::Number;
use crate::derivatives::numbers::vector::{Matrix, Vector};
use crate::mechanism::description::closure::Coordinate;
use crate::mechanism::description::joint::{FreeRotation, rotation_from_wxyz};
use crate::mechanism::motion::state::State;

/// A placed body.
#[derive(Clone, Copy, Debug)]
pub struct Placed<T> {
    /// The frame of the body in the world.
    pub frame: Frame<T>,
    /// The anchor of its joint, on the body.
    pub anchor: Vector<T>,
    /// The axes of its joint on the parent, and on the body.
    pub on_parent: Matrix<T>,
    pub on_child: Matrix<T>,
}

/// How a mechanism has moved away from a state.
#[derive(Clone, Copy)]
pub struct Offsets<'o, T> {
    /// Where it was.
    pub from: &'o State,
    /// δ: one entry a degree of freedom (rad or m).
    pub first: &'o [T],
    /// θ, after the other (rad or m).
    pub second: &'o [T],
}

impl<T: Number> Offsets<'_, T> {
    /// The value of a scalar coordinate.
    pub fn coordinate(&self, at: Coordinate) -> T {
        self.scalar(at.position, at.freedom)
    }

    fn scalar(&self, position: usize, freedom: usize) -> T {
        // The rounding error of a position is a part of it.
        let value = T::of(self.from.position[position]) + T::of(self.from.compensation[position]);
        value + self.first[freedom] + self.second[freedom]
    }
}

/// Places all bodies, parents first.
pub fn place<T: Number>(figures: &Figures<T>, offsets: &Offsets<T>) -> Vec<Placed<T>> {
    let mut placed: Vec<Placed<T>> = Vec::with_capacity(figures.bodies.len());
    for body in &figures.bodies {
        let parent = match body.parent {
            Some(parent) => placed[parent].frame,
            None => world(),
        };
        placed.push(on_parent(body, &parent, offsets));
    }
    placed
}

/// The frame of an end in the world.
pub fn end_frame<T: Number>(end: &End<T>, placed: &[Placed<T>]) -> Frame<T> {
    within(&end.body.map_or_else(world, |body| placed[body].frame), &end.frame)
}

fn on_parent<T: Number>(body: &BodyFigures<T>, parent: &Frame<T>, offsets: &Offsets<T>) -> Placed<T> {
    let slides = body.kind.translation_axes();
    let mut along = Vector::zero();
    for (offset, &axis) in slides.iter().enumerate() {
        along.0[axis] = offsets.scalar(body.position_index + offset, body.velocity_index + offset);
    }
    let (position, freedom) = (body.position_index + slides.len(), body.velocity_index + slides.len());
    let turn = match body.kind.rotation() {
        FreeRotation::None => Matrix::identity(),
        FreeRotation::AboutZ => {
            let (sine, cosine) = offsets.scalar(position, freedom).sine_cosine();
            let (zero, one) = (T::zero(), T::of(1.0));
            Matrix([Vector([cosine, sine, zero]), Vector([-sine, cosine, zero]), Vector([zero, zero, one])])
        }
        FreeRotation::Ball => {
            let start = Matrix::of(&rotation_from_wxyz(&offsets.from.position[position..position + 4]));
            let slight = |by: &[T]| Matrix::turned_slightly(Vector([by[freedom], by[freedom + 1], by[freedom + 2]]));
            start.product(&slight(offsets.first)).product(&slight(offsets.second))
        }
    };
    let joint = within(parent, &body.on_parent);
    let anchor = joint.origin + joint.axes.apply(along);
    let on_child = joint.axes.product(&turn);
    let axes = on_child.product(&body.on_child.axes.transpose());
    let origin = anchor - axes.apply(body.on_child.origin);
    Placed { frame: Frame { axes, origin }, anchor, on_parent: joint.axes, on_child }
}

/// A frame that is fixed in another, in the world.
fn within<T: Number>(outer: &Frame<T>, inner: &Frame<T>) -> Frame<T> {
    Frame { axes: outer.axes.product(&inner.axes), origin: outer.origin + outer.axes.apply(inner.origin) }
}

fn world<T: Number>() -> Frame<T> {
    Frame { axes: Matrix::identity(), origin: Vector::zero() }
}
