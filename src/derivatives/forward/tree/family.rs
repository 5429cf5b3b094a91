//! Which freedoms of a tree move which bodies, and their motions in the world.
//!
//! A freedom moves the bodies behind its joint. It moves the axes of the joints behind its own, and those of the rotations of its own joint: a slide
//! takes their anchor along, and a ball joint turns about the axes of its child.

use crate::derivatives::equations::figures::{Figures, Frame};
use crate::derivatives::forward::spatial::{NOUGHT, Twist};
use crate::derivatives::forward::twelve::Twelve;
use crate::derivatives::numbers::vector::{Matrix, Vector};
use crate::mechanism::description::joint::{FreeRotation, rotation_from_wxyz};
use crate::mechanism::motion::state::State;

/// A freedom of a joint.
#[derive(Clone, Copy, Debug)]
pub(super) struct Freedom {
    /// Its entry among all freedoms.
    pub index: usize,
    /// Its entry among those that move; `None` if it is held.
    pub row: Option<usize>,
    pub is_rotation: bool,
}

/// The freedoms of a tree, by its bodies.
#[derive(Clone, Debug, Default)]
pub(super) struct Family {
    pub parents: Vec<Option<usize>>,
    /// Of the joint of each body.
    pub own: Vec<Vec<Freedom>>,
    /// Of all joints before it.
    pub before: Vec<Vec<Freedom>>,
}

impl Family {
    pub fn new(figures: &Figures<f64>, free: &[usize]) -> Self {
        let mut family = Family::default();
        for body in &figures.bodies {
            let slides = body.kind.translation_axes().len();
            let count = body.kind.velocity_count();
            let of = |offset: usize| {
                let index = body.velocity_index + offset;
                Freedom { index, row: free.binary_search(&index).ok(), is_rotation: offset >= slides }
            };
            let before = body.parent.map_or_else(Vec::new, |parent| {
                let all = family.before[parent].iter().chain(&family.own[parent]);
                all.copied().collect()
            });
            family.parents.push(body.parent);
            family.own.push((0..count).map(of).collect());
            family.before.push(before);
        }
        family
    }

    /// Adds the entries of all bodies to the entries of their parents.
    pub fn gather<S>(&self, of: &mut [S], add: impl Fn(&mut S, &S)) {
        for body in (0..self.parents.len()).rev() {
            if let Some(parent) = self.parents[body] {
                let (before, after) = of.split_at_mut(body);
                add(&mut before[parent], &after[0]);
            }
        }
    }
}

/// A stage of a step: the places of the bodies, and the motions of all freedoms.
#[derive(Clone, Debug)]
pub(super) struct TreeStage {
    pub places: Vec<Twelve<f64>>,
    pub motions: Vec<Twist>,
}

impl TreeStage {
    /// At the places of a state, as in [`crate::derivatives::equations::placed`], seen from a point of the world.
    pub fn at(figures: &Figures<f64>, state: &State, from: Vector<f64>) -> Self {
        let world = Twelve { origin: NOUGHT - from, axes: Matrix::identity() };
        let mut motions = vec![Twist::NONE; figures.freedoms];
        let mut places: Vec<Twelve<f64>> = Vec::with_capacity(figures.bodies.len());
        for body in &figures.bodies {
            let parent = body.parent.map_or(&world, |parent| &places[parent]);
            let joint = within(parent, &body.on_parent);
            let slides = body.kind.translation_axes();
            let (mut anchor, slot) = (joint.origin, body.position_index + slides.len());
            for (offset, &axis) in slides.iter().enumerate() {
                let position = body.position_index + offset;
                anchor = anchor + joint.axes.0[axis].scaled(state.position[position] + state.compensation[position]);
                motions[body.velocity_index + offset] = Twist { turn: NOUGHT, shift: joint.axes.0[axis] };
            }
            let [x, y, z] = joint.axes.0;
            let on_child = match body.kind.rotation() {
                FreeRotation::None => joint.axes,
                FreeRotation::AboutZ => {
                    let (sine, cosine) = (state.position[slot] + state.compensation[slot]).sin_cos();
                    Matrix([x.scaled(cosine) + y.scaled(sine), y.scaled(cosine) - x.scaled(sine), z])
                }
                FreeRotation::Ball => {
                    joint.axes.product(&Matrix::of(&rotation_from_wxyz(&state.position[slot..slot + 4])))
                }
            };
            for (offset, &axis) in body.kind.rotation_axes().iter().enumerate() {
                let turn = on_child.0[axis];
                motions[body.velocity_index + slides.len() + offset] = Twist { turn, shift: anchor.cross(turn) };
            }
            let axes = on_child.product(&body.on_child.axes.transpose());
            places.push(Twelve { origin: anchor - axes.apply(body.on_child.origin), axes });
        }
        TreeStage { places, motions }
    }

    /// The velocities of all bodies.
    pub fn speeds(&self, family: &Family, velocities: &[f64]) -> Vec<Twist> {
        let mut speeds: Vec<Twist> = Vec::with_capacity(self.places.len());
        for (parent, own) in family.parents.iter().zip(&family.own) {
            let mut speed = parent.map_or(Twist::NONE, |parent| speeds[parent]);
            for freedom in own {
                speed = speed.plus(&self.motions[freedom.index].scaled(velocities[freedom.index]));
            }
            speeds.push(speed);
        }
        speeds
    }
}

/// A frame that is fixed in another.
fn within(outer: &Twelve<f64>, inner: &Frame<f64>) -> Twelve<f64> {
    Twelve { origin: outer.origin + outer.axes.apply(inner.origin), axes: outer.axes.product(&inner.axes) }
}
