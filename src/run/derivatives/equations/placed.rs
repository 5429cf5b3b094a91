//! The places of all bodies, joint by joint, as in [`crate::mechanism::description::joint`], over numbers with derivatives.
//!
//! ```text
//!     R = R_p F_p.R Rj F_c.Rᵀ        a = x_p + R_p (F_p.t + F_p.R t)        x = a − R F_c.t
//! ```
//!
//! A motion goes from one known state to another, which may be the same. Each degree of freedom has slight offsets in both; a ball joint turns by
//! the product of rotations `Rj = Rj₀ exp(δ̂) (Rj₀ᵀ Rj₁) exp(ε̂) exp(θ̂)`, about the axes of the child. Offsets are zero but for their derivatives:
//! with the motion θ = w t + ẇ t²/2 the velocity of a ball joint is w, and its acceleration ẇ.

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
    /// The state in which the first offsets begin.
    pub from: &'o State,
    /// The state in which the second offsets begin.
    pub to: &'o State,
    /// δ: one entry a degree of freedom (rad or m).
    pub first: &'o [T],
    /// θ, after the other (rad or m).
    pub second: &'o [T],
    /// The motion from there on, after both; empty if there is none.
    pub motion: &'o [T],
}

impl<T: Number> Offsets<'_, T> {
    /// The value of a scalar coordinate.
    pub fn coordinate(&self, at: Coordinate) -> T {
        self.scalar(at.position, at.freedom)
    }

    /// The value of a scalar coordinate, by its entries of position and velocity vectors.
    pub fn scalar(&self, position: usize, freedom: usize) -> T {
        // The rounding error of a position is a part of it.
        let value = T::of(self.to.position[position]) + T::of(self.to.compensation[position]);
        let offset = value + self.first[freedom] + self.second[freedom];
        self.motion.get(freedom).map_or(offset, |&motion| offset + motion)
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
            let rotation = |of: &State| rotation_from_wxyz(&of.position[position..position + 4]);
            let (from, to) = (rotation(offsets.from), rotation(offsets.to));
            let slight = |by: &[T]| Matrix::turned_slightly(Vector([by[freedom], by[freedom + 1], by[freedom + 2]]));
            let mut turn = Matrix::of(&from).product(&slight(offsets.first));
            if !std::ptr::eq(offsets.from, offsets.to) {
                turn = turn.product(&Matrix::of(&(from.transpose() * to)));
            }
            turn = turn.product(&slight(offsets.second));
            // Its rate is the velocity of the joint wherever the offsets put it.
            if !offsets.motion.is_empty() {
                turn = turn.product(&slight(offsets.motion));
            }
            turn
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
