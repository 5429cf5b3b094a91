//! The equations of motion of a mechanism at one instant, with all first derivatives.
//!
//! ```text
//!     ρ(q, v, a) − P(q, v) λ = τ        g(q) = 0,   ġ = G v,   g̈ = G a + Ġ v        P = Gᵀ but for friction that slides
//! ```
//!
//! | symbol | meaning                                                            | size, unit        |
//! |--------|--------------------------------------------------------------------|-------------------|
//! | ρ      | efforts that a motion needs ([`crate::derivatives::equations::residual`]) | n; N m and N |
//! | g, G   | closures and gaps, and their gradient by the degrees of freedom     | m, m × n; m and 1 |
//! | λ      | multipliers                                                         | m; N and N m      |
//! | P      | the directions in which multipliers push                            | n × m             |
//!
//! The rows are closures, then the gaps of closed contacts, then two slips of each contact that rolls: these have G and no g.
//! The derivatives come from dual numbers, and are exact.

use crate::derivatives::equations::closed::{ClosedTouch, Friction};
use crate::derivatives::equations::closures::closures;
use crate::derivatives::equations::contacts::TouchFigures;
use crate::derivatives::equations::figures::Figures;
use crate::derivatives::equations::placed::{Offsets, Placed, place};
use crate::derivatives::equations::residual::{Load, along_freedoms, residual, still};
use crate::derivatives::numbers::dual::Dual;
use crate::derivatives::numbers::jet::Jet;
use crate::derivatives::numbers::number::Number;
use crate::derivatives::numbers::vector::Vector;
use crate::mechanism::description::contact::{Grip, TouchJoint};
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::state::State;
use nalgebra::{DMatrix, DVector};

/// Derivatives that are computed at once.
const WIDTH: usize = 4;
type Part = Dual<WIDTH>;

/// By which quantities derivatives are taken.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum By {
    Positions,
    Velocities,
    Accelerations,
}

/// A motion at an instant.
pub struct Point<'p> {
    /// With its velocities.
    pub state: &'p State,
    /// a (n).
    pub accelerations: &'p DVector<f64>,
    /// λ (m).
    pub multipliers: &'p DVector<f64>,
}

/// Values, or derivatives in columns.
pub struct Evaluated {
    /// ρ − P λ (n rows).
    pub efforts: DMatrix<f64>,
    /// g, ġ and g̈ (m rows each); zeros for g of slips.
    pub closures: [DMatrix<f64>; 3],
}

/// The equations of one mechanism.
pub struct Equations {
    figures: Figures<Jet<Part>>,
    touches: Vec<ClosedTouch<Part>>,
    freedoms: usize,
    closures: usize,
}

impl Equations {
    /// The equations of a mechanism with its closed contacts.
    pub fn new(mechanism: &Mechanism) -> Self {
        let loops: usize = mechanism.loops.iter().map(|joint| joint.kind.rows()).sum();
        Equations {
            figures: Figures::constant(mechanism),
            touches: mechanism.touches.iter().filter_map(closed).collect(),
            freedoms: mechanism.velocity_count,
            closures: loops + mechanism.mimics.len(),
        }
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.closures + self.touches.iter().map(ClosedTouch::rows).sum::<usize>()
    }

    /// The closures of joints, which come first.
    pub fn closures(&self) -> usize {
        self.closures
    }

    /// The rows of positions, which come before all others.
    pub fn of_positions(&self) -> usize {
        self.closures + self.touches.len()
    }

    /// Whether pressures with friction that slides are not told by these rows alone, because the others follow from them.
    pub fn share_friction(&self, independent: &[usize]) -> bool {
        let brakes = |closed: &ClosedTouch<Part>| match closed.friction {
            Friction::Slides { coefficient, .. } => coefficient.value != 0.0,
            Friction::Rolls => false,
        };
        self.touches.iter().any(brakes) && (self.closures..self.rows()).any(|row| !independent.contains(&row))
    }

    /// P (n × m), for G.
    pub fn pushes(&self, point: &Point, gradient: &DMatrix<f64>) -> DMatrix<f64> {
        let mut pushes = gradient.transpose();
        if self.touches.is_empty() {
            return pushes;
        }
        let [first, second] = self.jets(point, &|value, _, _| Dual::of(value));
        let offsets = Offsets { from: point.state, to: point.state, first: &first, second: &second, motion: &[] };
        let placed = place(&self.figures, &offsets);
        for (touch, closed) in self.touches.iter().enumerate() {
            for own in 0..closed.rows() {
                let mut unit = vec![Part::zero(); closed.rows()];
                unit[own] = Dual::of(1.0);
                let along = self.pushed(&placed, &[(closed, unit)]);
                let column = self.row_of(touch, own);
                along.iter().enumerate().for_each(|(row, push)| pushes[(row, column)] = push.value);
            }
        }
        pushes
    }

    /// The row of an equation of a touch: its gap, or one of its slips.
    fn row_of(&self, touch: usize, own: usize) -> usize {
        if own == 0 {
            return self.closures + touch;
        }
        let slips = self.touches[..touch].iter().map(|closed| closed.rows() - 1).sum::<usize>();
        self.of_positions() + slips + own - 1
    }

    /// The efforts of touches with their multipliers (n).
    fn pushed(&self, placed: &[Placed<Jet<Part>>], touches: &[(&ClosedTouch<Part>, Vec<Part>)]) -> Vec<Part> {
        let bodies = still(placed);
        let mut loads = vec![Load { force: Vector::zero(), torque: Vector::zero() }; bodies.len()];
        for (closed, multipliers) in touches {
            let found = closed.force(placed, multipliers);
            let [a, b] = found.bodies;
            for (body, force) in [(a, -found.force), (b, found.force)] {
                let Some(body) = body else { continue };
                let arm = found.point - bodies[body].frame.origin;
                loads[body].force = loads[body].force + force;
                loads[body].torque = loads[body].torque + arm.cross(force);
            }
        }
        along_freedoms(&self.figures, &bodies, loads)
    }

    /// The values, in one column.
    pub fn at(&self, point: &Point) -> Evaluated {
        let mut out = self.room(1);
        self.evaluate(point, None, |row, of, value: Part| out.set(row, of, 0, value.value));
        out
    }

    /// The derivatives, a column for each degree of freedom.
    pub fn derivatives(&self, point: &Point, by: By) -> Evaluated {
        let mut out = self.room(self.freedoms);
        for start in (0..self.freedoms).step_by(WIDTH) {
            let end = self.freedoms.min(start + WIDTH);
            self.evaluate(point, Some((by, start..end)), |row, of, value| {
                (start..end).for_each(|column| out.set(row, of, column, value.parts[column - start]));
            });
        }
        out
    }

    /// The offsets of a motion, with numbers as `part` makes them of a value, its kind and its degree of freedom.
    fn jets(&self, point: &Point, part: &dyn Fn(f64, By, usize) -> Part) -> [Vec<Jet<Part>>; 2] {
        let zero = Part::zero();
        let first = |freedom: usize| Jet { value: part(0.0, By::Positions, freedom), rate: zero, acceleration: zero };
        let moving = |freedom: usize| Jet {
            value: zero,
            rate: part(point.state.velocity[freedom], By::Velocities, freedom),
            acceleration: part(point.accelerations[freedom], By::Accelerations, freedom),
        };
        [(0..self.freedoms).map(first).collect(), (0..self.freedoms).map(moving).collect()]
    }

    fn room(&self, columns: usize) -> Evaluated {
        let closures = [(); 3].map(|()| DMatrix::zeros(self.rows(), columns));
        Evaluated { efforts: DMatrix::zeros(self.freedoms, columns), closures }
    }

    /// Hands every row to `set(row, of, value)`: of the efforts with `None`, of a derivative of the closures otherwise.
    fn evaluate(
        &self,
        point: &Point,
        by: Option<(By, std::ops::Range<usize>)>,
        mut set: impl FnMut(usize, Option<usize>, Part),
    ) {
        let part = |value: f64, of: By, freedom: usize| match &by {
            Some((by, among)) if *by == of && among.contains(&freedom) => Dual::parameter(value, freedom - among.start),
            _ => Dual::of(value),
        };
        let [first, second] = self.jets(point, &part);
        let offsets = Offsets { from: point.state, to: point.state, first: &first, second: &second, motion: &[] };
        let placed = place(&self.figures, &offsets);
        let mut efforts = residual(&self.figures, &placed, &offsets);
        for (row, value) in closures(&self.figures, &[], &placed, &offsets).into_iter().enumerate() {
            set(row, Some(0), value.value);
            set(row, Some(1), value.rate);
            set(row, Some(2), value.acceleration);
        }
        for (touch, closed) in self.touches.iter().enumerate() {
            set(self.row_of(touch, 0), Some(0), closed.touch.at(&still(&placed)).gap);
            for (own, rate) in closed.rates(&placed).into_iter().enumerate() {
                set(self.row_of(touch, own), Some(1), rate);
            }
            for (own, acceleration) in closed.accelerations(&placed).into_iter().enumerate() {
                set(self.row_of(touch, own), Some(2), acceleration);
            }
        }
        let (own, of_touches) = point.multipliers.as_slice().split_at(self.closures);
        if of_touches.iter().any(|&multiplier| multiplier != 0.0) {
            let touches = self.touches.iter().enumerate().map(|(touch, closed)| {
                let multipliers = (0..closed.rows()).map(|own| Dual::of(point.multipliers[self.row_of(touch, own)]));
                (closed, multipliers.collect())
            });
            let touches: Vec<_> = touches.collect();
            for (effort, push) in efforts.iter_mut().zip(self.pushed(&placed, &touches)) {
                *effort = *effort - push;
            }
        }
        if own.iter().any(|&multiplier| multiplier != 0.0) {
            // The gradient of the closures is their rate for unit velocities.
            let mut unit = vec![Jet::<Part>::zero(); self.freedoms];
            for (freedom, effort) in efforts.iter_mut().enumerate() {
                unit[freedom].rate = Dual::of(1.0);
                let offsets = Offsets { second: &unit, ..offsets };
                let rates = closures(&self.figures, &[], &place(&self.figures, &offsets), &offsets);
                for (rate, &multiplier) in rates.iter().zip(own) {
                    *effort = *effort - rate.rate.times(multiplier);
                }
                unit[freedom].rate = Part::zero();
            }
        }
        efforts.into_iter().enumerate().for_each(|(row, value)| set(row, None, value));
    }
}

impl Evaluated {
    fn set(&mut self, row: usize, of: Option<usize>, column: usize, value: f64) {
        match of {
            None => self.efforts[(row, column)] = value,
            Some(order) => self.closures[order][(row, column)] = value,
        }
    }
}

/// A closed contact as constants, if its features have a gap.
fn closed(joint: &TouchJoint) -> Option<ClosedTouch<Part>> {
    let friction = match joint.touch.grip {
        Grip::Slides { friction, direction } => {
            Friction::Slides { coefficient: Dual::of(friction), direction: Vector::of(&direction) }
        }
        Grip::Rolls => Friction::Rolls,
    };
    Some(ClosedTouch { touch: TouchFigures::constant(joint)?, friction })
}
