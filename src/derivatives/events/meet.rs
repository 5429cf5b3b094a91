//! The limits and contacts that meet at one instant, over any numbers: their places, their rates, the efforts of their impulses, and their laws.
//!
//! ```text
//!     u = W v        Wᵀ P + Gᵀ Λ        laws as in [`crate::derivatives::events::impact`]
//! ```
//!
//! The rows of a contact are along its normal and, if it has friction, along two tangents.

use crate::derivatives::equations::contacts::TouchFigures;
use crate::derivatives::equations::placed::Placed;
use crate::derivatives::events::instant::Instant;
use crate::derivatives::numbers::jet::Jet;
use crate::derivatives::numbers::number::Number;
use crate::derivatives::numbers::vector::Vector;
use crate::instant::cone::problem::BlockState;

/// A limit or contact that meets.
pub(super) enum Met<T> {
    /// A degree of freedom, the direction into the allowed range, and e.
    Joint { freedom: usize, sign: f64, restitution: T },
    /// A contact with μ and e; without friction only its normal counts.
    Contact { touch: TouchFigures<T>, friction: T, restitution: T },
}

impl<T: Number> Met<T> {
    pub fn rows(&self) -> usize {
        match self {
            Met::Contact { friction, .. } if friction.value() > 0.0 => 3,
            _ => 1,
        }
    }

    /// μ and e.
    pub fn law(&self) -> (T, T) {
        match self {
            Met::Joint { restitution, .. } => (T::zero(), *restitution),
            Met::Contact { friction, restitution, .. } => (*friction, *restitution),
        }
    }
}

/// A contact in its place.
pub(super) struct InPlace<T> {
    point: Vector<T>,
    axes: [Vector<T>; 3],
}

/// Bodies that move, with the rates u of the blocks that take part.
pub(super) struct Moving<T> {
    pub bodies: Vec<Placed<Jet<T>>>,
    pub rates: Vec<T>,
}

/// The blocks that meet at an instant, and their numbers in an answer.
pub(super) struct Meet<'m, T> {
    pub at: &'m Instant<'m, T>,
    pub met: &'m [Met<T>],
    pub part: &'m [usize],
}

impl<T: Number> Meet<'_, T> {
    pub fn in_place(&self) -> Vec<Option<InPlace<T>>> {
        if self.part.iter().all(|&block| matches!(self.met[block], Met::Joint { .. })) {
            return self.part.iter().map(|_| None).collect();
        }
        let bodies = self.at.at_rest();
        let place = |&block: &usize| match &self.met[block] {
            Met::Joint { .. } => None,
            Met::Contact { touch, .. } => {
                let found = touch.at(&bodies);
                let normal = found.normal;
                let values = normal.0.map(Number::value);
                let mut axis = Vector::zero();
                axis.0[if values[0].abs() <= 0.6 { 0 } else { 1 }] = T::of(1.0);
                let along = axis - normal.scaled(normal.dot(axis));
                let first = along.scaled(T::of(1.0) / along.dot(along).square_root());
                Some(InPlace { point: found.point, axes: [normal, first, normal.cross(first)] })
            }
        };
        self.part.iter().map(place).collect()
    }

    /// The motion of velocities (n).
    pub fn moving(&self, places: &[Option<InPlace<T>>], velocities: &[T]) -> Moving<T> {
        let bodies = self.at.placed(velocities);
        let mut rates = Vec::new();
        for (&block, place) in self.part.iter().zip(places) {
            match (&self.met[block], place) {
                (Met::Contact { touch, .. }, Some(InPlace { point, axes })) => {
                    let slip = touch.slip(&bodies, *point);
                    rates.extend(axes[..self.met[block].rows()].iter().map(|axis| axis.dot(slip)));
                }
                (Met::Joint { freedom, sign, .. }, _) => rates.push(velocities[*freedom].times(*sign)),
                (Met::Contact { .. }, None) => {}
            }
        }
        Moving { bodies, rates }
    }

    /// `Wᵀ P + Gᵀ Λ` (n).
    pub fn pushed(
        &self,
        places: &[Option<InPlace<T>>],
        moving: &Moving<T>,
        impulses: &[T],
        multipliers: &[T],
    ) -> Vec<T> {
        let (mut forces, mut efforts) = (Vec::new(), Vec::new());
        let mut own = impulses.iter();
        for (&block, place) in self.part.iter().zip(places) {
            match (&self.met[block], place) {
                (Met::Contact { touch, .. }, Some(InPlace { point, axes })) => {
                    let sizes = axes[..self.met[block].rows()].iter().zip(own.by_ref());
                    let force = sizes.fold(Vector::zero(), |sum, (axis, &size)| sum + axis.scaled(size));
                    forces.push((touch.b.body, *point, force));
                    forces.push((touch.a.body, *point, -force));
                }
                (Met::Joint { freedom, sign, .. }, _) => {
                    efforts.extend(own.next().map(|size| (*freedom, size.times(*sign))));
                }
                (Met::Contact { .. }, None) => {}
            }
        }
        let mut rows = self.at.pushes(&moving.bodies, multipliers, &forces);
        efforts.into_iter().for_each(|(freedom, effort)| rows[freedom] = rows[freedom] + effort);
        rows
    }

    /// The laws of all blocks that take part; zero at the answer.
    pub fn laws(&self, states: &[BlockState], rebounds: bool, [before, after]: [&[T]; 2], impulses: &[T]) -> Vec<T> {
        let mut laws = Vec::new();
        let mut end = 0;
        for (&block, &state) in self.part.iter().zip(states) {
            let rows = end..end + self.met[block].rows();
            end = rows.end;
            let (own, before, after) = (&impulses[rows.clone()], &before[rows.clone()], &after[rows]);
            let (friction, restitution) = self.met[block].law();
            let approaches = rebounds && before[0].value() < 0.0;
            let normal = if approaches { after[0] + restitution * before[0] } else { after[0] };
            match state {
                BlockState::Open | BlockState::AtLower | BlockState::AtUpper => laws.extend(own),
                BlockState::Inside => laws.push(normal),
                BlockState::Sticks => {
                    laws.push(normal);
                    laws.extend(&after[1..]);
                }
                BlockState::Slips => {
                    laws.push(normal);
                    let (x, y) = (after[1], after[2]);
                    let share = friction * own[0] / (x * x + y * y).square_root();
                    laws.extend([own[1] + share * x, own[2] + share * y]);
                }
            }
        }
        laws
    }

    /// `v_C + σ (v_N − v_C)`, with the σ near `share` at which no energy is gained.
    pub fn shared(&self, before: &[T], plastic: &[T], rebound: &[T], share: f64) -> Option<Vec<T>> {
        let energy = |velocities: &[T]| {
            let momenta = self.at.momenta(velocities);
            velocities.iter().zip(momenta).fold(T::zero(), |sum, (&rate, momentum)| sum + rate * momentum).times(0.5)
        };
        let mixed = |share: T| -> Vec<T> {
            plastic.iter().zip(rebound).map(|(&one, &other)| one + share * (other - one)).collect()
        };
        // The energy is a polynomial of second degree in σ.
        let start = energy(before);
        let at = |share: f64| energy(&mixed(T::of(share))) - start;
        let width = 0.25;
        let slope = (at(share + width) - at(share - width)).value() / (2.0 * width);
        if slope == 0.0 || !slope.is_finite() {
            return None;
        }
        let mut root = share;
        for _ in 0..3 {
            root -= at(root).value() / slope;
        }
        Some(mixed(T::of(root) - at(root).times(1.0 / slope)))
    }
}
