//! The gap, normal and point of a contact, with the velocities of its bodies there, over numbers with derivatives.
//!
//! ```text
//!     φ, n, p  as in [`crate::mechanism::motion::contact_geometry`]        u = v_b(p) − v_a(p)
//! ```
//!
//! A feature is fixed in the frame of its collider. The corners, edges and ends of boxes, cylinders and capsules move with their sizes. The rim of a
//! cylinder on a plane grows with its radius ρ:
//!
//! ```text
//!     p ← p + δρ r,   φ ← φ + δρ n · r        r = (p − c)/ρ, c: the middle of the rim
//! ```

use crate::derivatives::equations::figures::{End, Frame, frame};
use crate::derivatives::equations::laws::Laws;
use crate::derivatives::equations::placed::{Placed, end_frame};
use crate::derivatives::numbers::jet::Jet;
use crate::derivatives::numbers::number::Number;
use crate::derivatives::numbers::vector::{Matrix, Vector};
use crate::mechanism::description::closure::Attachment;
use crate::mechanism::description::contact::{Collider, Cores, Feature, Pairing, Shape, TouchJoint};
use crate::mechanism::ground::smooth::{Smooth, Triple};
use crate::mechanism::motion::contact_geometry::{self, contact};
use std::ops::{Add, Mul, Sub};

/// A contact with the frames of its features.
#[derive(Clone, Copy, Debug)]
pub struct TouchFigures<T> {
    pairing: Pairing,
    side: f64,
    /// The sum of the radii, and the radius of the second feature (m).
    reach: T,
    radius: T,
    /// How much wider a rim on a plane is than in its core: zero but for its derivatives (m).
    wider: T,
    pub a: End<T>,
    pub b: End<T>,
}

/// A contact of placed bodies.
#[derive(Clone, Copy, Debug)]
pub struct Touching<T> {
    /// φ (m).
    pub gap: T,
    /// n, from a to b, and p (m).
    pub normal: Vector<T>,
    pub point: Vector<T>,
}

/// A number with derivatives in the formulas of contacts.
#[derive(Clone, Copy)]
struct Plain<T>(T);

impl<T: Number> Add for Plain<T> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Plain(self.0 + other.0)
    }
}

impl<T: Number> Sub for Plain<T> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Plain(self.0 - other.0)
    }
}

impl<T: Number> Mul for Plain<T> {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Plain(self.0 * other.0)
    }
}

impl<T: Number> Smooth for Plain<T> {
    fn constant(value: f64) -> Self {
        Plain(T::of(value))
    }
    fn square_root(self) -> Self {
        Plain(self.0.square_root())
    }
    fn reciprocal(self) -> Self {
        Plain(T::of(1.0) / self.0)
    }
    fn held(self) -> Self {
        Plain(T::of(self.0.value()))
    }
    fn is_within(self, bound: f64) -> bool {
        self.0.value().abs() <= bound
    }
}

impl<T: Number> TouchFigures<T> {
    /// A contact of two colliders, by their numbers; `frames` turns an attachment into one in the frame of its body. `None` for features without a gap.
    pub fn new(
        joint: &TouchJoint,
        colliders: [(&Collider, usize); 2],
        laws: &Laws<T>,
        frames: &dyn Fn(&Attachment) -> Attachment,
    ) -> Option<Self> {
        let pairing = joint.touch.pairing()?;
        let ends = [(&joint.a, colliders[0]), (&joint.b, colliders[1])];
        let [a, b] = ends.map(|(end, (collider, number))| {
            let local = collider.pose.inverse() * end.frame;
            let figures = &laws.colliders[number];
            let sized = |axis: usize| {
                let at = local.translation.vector[axis];
                let (size, own) = (figures.sizes[axis].value(), figures.sizes[axis]);
                // Places on the axis of a cylinder, or on its rims.
                let scales = matches!(collider.shape, Shape::Box { .. } | Shape::Cylinder { .. })
                    || axis == 2 && matches!(collider.shape, Shape::Capsule { .. });
                if scales && size != 0.0 { own.times(at / size) } else { T::of(at) }
            };
            let origin = Vector([sized(0), sized(1), sized(2)]);
            let axes = figures.frame.axes.product(&Matrix::of(local.rotation.matrix()));
            let frame = Frame { axes, origin: figures.frame.origin + figures.frame.axes.apply(origin) };
            End { body: frames(end).body, frame }
        });
        let round = |feature: Feature, number: usize| match feature {
            Feature::Point { radius } | Feature::Line { radius } if radius > 0.0 => laws.colliders[number].sizes[0],
            _ => T::zero(),
        };
        let radii = [round(joint.touch.features[0], colliders[0].1), round(joint.touch.features[1], colliders[1].1)];
        let wider = match pairing.cores {
            Cores::PlaneRim(_) => {
                let own = laws.colliders[colliders[1].1].sizes[0];
                own - T::of(own.value())
            }
            _ => T::zero(),
        };
        Some(TouchFigures {
            pairing,
            side: joint.touch.side,
            reach: radii[0] + radii[1],
            radius: radii[1],
            wider,
            a,
            b,
        })
    }

    /// A contact of constants, with attachments in the frames of the bodies, if its features have a gap.
    pub fn constant(joint: &TouchJoint) -> Option<Self> {
        let pairing = joint.touch.pairing()?;
        let [a, b] = [&joint.a, &joint.b].map(|at| End { body: at.body, frame: frame(&at.frame, &mut T::of) });
        // The length of a rope stays with its cores.
        let reach = if pairing.cores == Cores::Hollow { 0.0 } else { pairing.reach };
        let (reach, radius) = (T::of(reach), T::of(pairing.radius));
        Some(TouchFigures { pairing, side: joint.touch.side, reach, radius, wider: T::zero(), a, b })
    }

    /// The features whose sizes have no derivatives here: rims that meet other than planes. First and second.
    pub fn fixed(&self) -> [bool; 2] {
        match self.pairing.cores {
            Cores::LineRim(_) => [false, true],
            Cores::RimLine(_) | Cores::RimPoint(_) | Cores::RimBesideLine(_) => [true, false],
            Cores::Rims(..) | Cores::LevelRims(..) => [true, true],
            _ => [false, false],
        }
    }

    /// The same contact for places with rates.
    pub fn with_rates(&self) -> TouchFigures<Jet<T>> {
        let jet = |value: T| Jet { value, rate: T::zero(), acceleration: T::zero() };
        let end = |end: &End<T>| {
            let Frame { axes, origin } = end.frame;
            End { body: end.body, frame: Frame { axes: axes.map(|column| column.map(jet)), origin: origin.map(jet) } }
        };
        let [reach, radius, wider] = [self.reach, self.radius, self.wider].map(jet);
        TouchFigures { pairing: self.pairing, side: self.side, reach, radius, wider, a: end(&self.a), b: end(&self.b) }
    }

    /// Where the bodies are.
    pub fn at(&self, placed: &[Placed<T>]) -> Touching<T> {
        let axis = |frame: &Frame<T>, which: usize| Triple(frame.axes.0[which].0.map(Plain));
        let place = |frame: &Frame<T>| contact_geometry::Placed {
            origin: Triple(frame.origin.0.map(Plain)),
            axis: axis(frame, 2),
        };
        let [a, b] = [&self.a, &self.b].map(|end| end_frame(end, placed));
        // The radii of round features are added with their derivatives; the length of a rope is no such radius.
        let cores = match self.pairing.cores {
            Cores::Hollow => self.pairing,
            _ => Pairing { reach: 0.0, radius: 0.0, ..self.pairing },
        };
        let found = contact(cores, self.side, place(&a), place(&b), || axis(&b, 0));
        let normal = Vector(found.normal.0.map(|entry| entry.0));
        let point = Vector(found.point.0.map(|entry| entry.0)) - normal.scaled(self.radius);
        let gap = found.gap.0 - self.reach;
        if let Cores::PlaneRim(rim) = self.pairing.cores {
            let wider = (point - b.origin).scaled(self.wider.times(1.0 / rim));
            return Touching { gap: gap + normal.dot(wider), normal, point: point + wider };
        }
        Touching { gap, normal, point }
    }

    /// u: the velocity of the second body at a point of the world, seen from the first [m/s].
    pub fn slip(&self, placed: &[Placed<Jet<T>>], point: Vector<T>) -> Vector<T> {
        material(self.b.body, placed, point) - material(self.a.body, placed, point)
    }
}

/// The velocity of the material of a body at a point of the world.
fn material<T: Number>(body: Option<usize>, placed: &[Placed<Jet<T>>], point: Vector<T>) -> Vector<T> {
    let Some(body) = body else { return Vector::zero() };
    let frame = &placed[body].frame;
    let arm = point - frame.origin.map(|entry| entry.value);
    let local = frame.axes.map(|column| column.map(|entry| entry.value)).transpose().apply(arm);
    frame.origin.map(|entry| entry.rate) + frame.axes.map(|column| column.map(|entry| entry.rate)).apply(local)
}
