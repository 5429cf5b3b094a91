//! Displacements of all bodies by motions of freedoms and of the frames of joints, and the transpose.
//!
//! A frame on the parent moves the joint and the child, as a freedom before the joint does. One on the child moves the child the other way.
//!
//! ```text
//!     T_body = T_parent + F_parent + Σ_freedoms s − F_child        carriers of the joint: before its freedoms, and after them
//! ```

use crate::derivatives::forward::spatial::Twist;
use crate::derivatives::forward::tree::family::Family;

/// How the bodies are displaced, or the cotangents of that.
pub(super) struct Displaced {
    pub bodies: Vec<Twist>,
    /// The motion that carries the slides of each joint, and the one that carries its rotations.
    pub carriers: Vec<[Twist; 2]>,
}

/// The cotangents of the motions of a joint.
pub(super) struct JointCotangents {
    /// Of its frames on the parent and on the child.
    pub frames: [Twist; 2],
    /// Of its freedoms.
    pub own: Twist,
}

impl Displaced {
    pub fn none(bodies: usize) -> Self {
        Displaced { bodies: vec![Twist::NONE; bodies], carriers: vec![[Twist::NONE; 2]; bodies] }
    }

    /// The displacements by the motions of freedoms, and of the frames of a body's joint if they vary.
    pub fn of(family: &Family, freedom: impl Fn(usize) -> Twist, frames: Option<impl Fn(usize) -> [Twist; 2]>) -> Self {
        let count = family.parents.len();
        let mut found = Displaced { bodies: Vec::with_capacity(count), carriers: Vec::with_capacity(count) };
        for (body, (parent, own)) in family.parents.iter().zip(&family.own).enumerate() {
            let frames = frames.as_ref().map(|frames| frames(body));
            let mut by = parent.map_or(Twist::NONE, |parent| found.bodies[parent]);
            if let Some([on_parent, _]) = &frames {
                by = by.plus(on_parent);
            }
            let before = by;
            for freedom_of in own {
                by = by.plus(&freedom(freedom_of.index));
            }
            found.carriers.push([before, by]);
            if let Some([_, on_child]) = &frames {
                by = by.plus(&on_child.scaled(-1.0));
            }
            found.bodies.push(by);
        }
        found
    }

    /// Adds a multiple of another one.
    pub fn add(&mut self, other: &Displaced, factor: f64) {
        for (own, other) in self.bodies.iter_mut().zip(&other.bodies) {
            *own = own.plus(&other.scaled(factor));
        }
        for (own, other) in self.carriers.iter_mut().flatten().zip(other.carriers.iter().flatten()) {
            *own = own.plus(&other.scaled(factor));
        }
    }

    /// The cotangents of the motions, from the cotangents of the displacements.
    pub fn pulled(mut self, family: &Family) -> Vec<JointCotangents> {
        let mut found = Vec::with_capacity(self.bodies.len());
        for body in (0..self.bodies.len()).rev() {
            let on_child = self.bodies[body].scaled(-1.0);
            let own = self.bodies[body].plus(&self.carriers[body][1]);
            let whole = own.plus(&self.carriers[body][0]);
            found.push(JointCotangents { frames: [whole, on_child], own });
            if let Some(parent) = family.parents[body] {
                self.bodies[parent] = self.bodies[parent].plus(&whole);
            }
        }
        found.reverse();
        found
    }
}
