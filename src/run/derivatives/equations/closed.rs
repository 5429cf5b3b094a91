//! Closed contacts of a mode: gap, friction and rolling, over numbers with derivatives.
//!
//! ```text
//!     gap         φ = 0,  n · u = 0            slides   the multiplier pushes along n − μ t,   t = u_T/|u_T|
//!     rolls       e · u = 0,  two tangents e            and along both e
//! ```
//!
//! n, p, u: as in [`crate::derivatives::equations::contacts`]. The tangents are constant vectors that are kept square to n. A contact without slip that
//! begins to slide has a given direction, with its own derivatives. Corners that stick are anchors, which are loops
//! ([`crate::derivatives::equations::closures`]).
//!
//! Source: [`crate::mechanism::description::contact`].

use crate::derivatives::equations::contacts::{TouchFigures, Touching};
use crate::derivatives::equations::figures::LoopFigures;
use crate::derivatives::equations::placed::Placed;
use crate::derivatives::equations::residual::still;
use crate::derivatives::numbers::jet::Jet;
use crate::derivatives::numbers::number::Number;
use crate::derivatives::numbers::vector::Vector;
use crate::mechanism::motion::touches::tangents;
use nalgebra::Vector3;
use std::borrow::Cow;

/// A slip of this part of the speeds of both bodies is none, and so is one of this size [m/s].
const NO_SLIP: f64 = 1e-9;
const NO_SPEED: f64 = 1e-12;

/// The tangential force of a closed contact.
#[derive(Clone, Copy, Debug)]
pub enum Friction<T> {
    /// μ, and the direction in which a contact without slip begins to slide; zero if there is none.
    Slides { coefficient: T, direction: Vector<T> },
    /// It holds.
    Rolls,
}

/// A closed contact.
#[derive(Clone, Copy, Debug)]
pub struct ClosedTouch<T> {
    pub touch: TouchFigures<T>,
    pub friction: Friction<T>,
}

/// All closed contacts of a mode.
#[derive(Clone, Debug)]
pub struct ClosedContacts<T> {
    /// Corners that stick.
    pub anchors: Vec<LoopFigures<T>>,
    /// The others.
    pub touches: Vec<ClosedTouch<T>>,
    /// Pressures that follow from others.
    pub shares: Vec<Share>,
}

/// A pressure that follows from others where normals imply each other: `λ = Σ c λ_i`, by the rows of the touches.
#[derive(Clone, Debug, PartialEq)]
pub struct Share {
    pub row: usize,
    pub of: Vec<(usize, f64)>,
}

/// The force of a contact on its second body, at a point of the world.
pub struct ContactForce<T> {
    pub bodies: [Option<usize>; 2],
    pub point: Vector<T>,
    pub force: Vector<T>,
}

impl<T> Default for ClosedContacts<T> {
    fn default() -> Self {
        ClosedContacts { anchors: Vec::new(), touches: Vec::new(), shares: Vec::new() }
    }
}

impl<T> ClosedContacts<T> {
    /// Whether no contact is closed.
    pub fn is_empty(&self) -> bool {
        self.anchors.is_empty() && self.touches.is_empty()
    }
}

impl<T: Number> ClosedContacts<T> {
    /// The number of equations of the touches, which come after those of all other closures.
    pub fn touch_rows(&self) -> usize {
        self.touches.iter().map(ClosedTouch::rows).sum()
    }

    /// The multipliers of the touches, with those that follow from others.
    pub fn shared<'m>(&self, multipliers: &'m [T]) -> Cow<'m, [T]> {
        if self.shares.is_empty() {
            return Cow::Borrowed(multipliers);
        }
        let mut all = multipliers.to_vec();
        for share in &self.shares {
            let sum = |sum: T, &(row, part): &(usize, f64)| sum + multipliers[row].times(part);
            all[share.row] = share.of.iter().fold(T::zero(), sum);
        }
        Cow::Owned(all)
    }
}

impl<T: Number> ClosedTouch<T> {
    /// The number of its equations.
    pub fn rows(&self) -> usize {
        match self.friction {
            Friction::Slides { .. } => 1,
            Friction::Rolls => 3,
        }
    }

    /// n · u, and e · u if it rolls, of moving bodies.
    pub fn rates(&self, placed: &[Placed<Jet<T>>]) -> Vec<T> {
        let found = self.touch.at(&still(placed));
        let slip = self.touch.slip(placed, found.point);
        let mut rates = vec![found.normal.dot(slip)];
        if let Friction::Rolls = self.friction {
            rates.extend(self.tangents(found.normal).map(|along| along.dot(slip)));
        }
        rates
    }

    /// φ̈, and the derivatives of e · u where it rolls.
    pub fn accelerations(&self, placed: &[Placed<Jet<T>>]) -> Vec<T> {
        let found = self.touch.with_rates().at(placed);
        let mut rows = vec![found.gap.acceleration];
        if let Friction::Rolls = self.friction {
            let change = self.slip_change(placed, &found);
            let normal = found.normal.map(|entry| entry.value);
            rows.extend(self.tangents(normal).map(|along| along.dot(change)));
        }
        rows
    }

    /// u̇ of moving bodies.
    pub fn slip_change(&self, placed: &[Placed<Jet<T>>], found: &Touching<Jet<T>>) -> Vector<T> {
        let forward = |entry: Jet<T>| Jet { value: entry.rate, rate: entry.acceleration, acceleration: T::zero() };
        let of = |body: Option<usize>| {
            let Some(body) = body else { return Vector::zero() };
            let frame = &placed[body].frame;
            let local = frame.axes.transpose().apply(found.point - frame.origin);
            let velocity = frame.origin.map(forward) + frame.axes.map(|column| column.map(forward)).apply(local);
            velocity.map(|entry| entry.rate)
        };
        of(self.touch.b.body) - of(self.touch.a.body)
    }

    /// The force of its multipliers in moving bodies.
    pub fn force(&self, placed: &[Placed<Jet<T>>], multipliers: &[T]) -> ContactForce<T> {
        let found = self.touch.at(&still(placed));
        let force = match self.friction {
            Friction::Slides { coefficient, direction } => {
                let slip = across(found.normal, self.touch.slip(placed, found.point));
                let along = if self.rests(placed, &found, slip) {
                    along(across(found.normal, direction))
                } else {
                    slip.scaled(T::of(1.0) / slip.dot(slip).square_root())
                };
                (found.normal - along.scaled(coefficient)).scaled(multipliers[0])
            }
            Friction::Rolls => {
                let [one, two] = self.tangents(found.normal);
                found.normal.scaled(multipliers[0]) + one.scaled(multipliers[1]) + two.scaled(multipliers[2])
            }
        };
        ContactForce { bodies: [self.touch.a.body, self.touch.b.body], point: found.point, force }
    }

    /// Whether a slip is zero beside the speeds of its bodies.
    pub fn rests(&self, placed: &[Placed<Jet<T>>], found: &Touching<T>, slip: Vector<T>) -> bool {
        let size = |of: Vector<T>| of.0.iter().map(|entry| entry.value().powi(2)).sum::<f64>().sqrt();
        let speed = |body: Option<usize>| {
            let Some(body) = body else { return 0.0 };
            let frame = &placed[body].frame;
            let arm = size(found.point - frame.origin.map(|entry| entry.value));
            let turning: f64 = frame.axes.0.iter().map(|column| size(column.map(|entry| entry.rate))).sum();
            size(frame.origin.map(|entry| entry.rate)) + turning * arm
        };
        size(slip) <= (NO_SLIP * (speed(self.touch.a.body) + speed(self.touch.b.body))).max(NO_SPEED)
    }

    /// Two unit vectors that are square to a normal.
    pub fn tangents(&self, normal: Vector<T>) -> [Vector<T>; 2] {
        let first = tangents(&Vector3::from(normal.0.map(Number::value)))[0];
        tangents_from(normal, &first)
    }
}

/// The tangents at a normal of which the first is nearest to a constant vector.
pub fn tangents_from<T: Number>(normal: Vector<T>, first: &Vector3<f64>) -> [Vector<T>; 2] {
    let one = across(normal, Vector::of(first));
    let one = one.scaled(T::of(1.0) / one.dot(one).square_root());
    [one, normal.cross(one)]
}

/// The part of a vector that is square to a unit vector.
pub fn across<T: Number>(normal: Vector<T>, vector: Vector<T>) -> Vector<T> {
    vector - normal.scaled(normal.dot(vector))
}

/// A direction as a unit vector; zero if it is much shorter than one.
pub fn along<T: Number>(direction: Vector<T>) -> Vector<T> {
    let square = direction.dot(direction);
    if square.value() < 0.25 { Vector::zero() } else { direction.scaled(T::of(1.0) / square.square_root()) }
}
