//! The equations of motion of a mechanism at one instant, with all first derivatives.
//!
//! ```text
//!     ρ(q, v, a) − G(q)ᵀ λ = τ        g(q) = 0,   ġ = G v,   g̈ = G a + Ġ v
//! ```
//!
//! | symbol | meaning                                                            | size, unit        |
//! |--------|--------------------------------------------------------------------|-------------------|
//! | ρ      | efforts that a motion needs ([`crate::derivatives::equations::residual`]) | n; N m and N |
//! | g, G   | closures, and their gradient by the degrees of freedom              | m, m × n; m and 1 |
//! | λ      | multipliers                                                         | m; N and N m      |
//!
//! The derivatives come from dual numbers, and are exact.

use crate::derivatives::equations::closures::closures;
use crate::derivatives::equations::figures::Figures;
use crate::derivatives::equations::placed::{Offsets, place};
use crate::derivatives::equations::residual::residual;
use crate::derivatives::numbers::dual::Dual;
use crate::derivatives::numbers::jet::Jet;
use crate::derivatives::numbers::number::Number;
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
    /// ρ − Gᵀ λ (n rows).
    pub efforts: DMatrix<f64>,
    /// g, ġ and g̈ (m rows each).
    pub closures: [DMatrix<f64>; 3],
}

/// The equations of one mechanism.
pub struct Equations {
    figures: Figures<Jet<Part>>,
    freedoms: usize,
    rows: usize,
}

impl Equations {
    /// The equations of a mechanism without closed contacts.
    pub fn new(mechanism: &Mechanism) -> Self {
        let loops: usize = mechanism.loops.iter().map(|joint| joint.kind.rows()).sum();
        Equations {
            figures: Figures::constant(mechanism),
            freedoms: mechanism.velocity_count,
            rows: loops + mechanism.mimics.len(),
        }
    }

    /// Number of closures.
    pub fn rows(&self) -> usize {
        self.rows
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

    fn room(&self, columns: usize) -> Evaluated {
        let closures = [(); 3].map(|()| DMatrix::zeros(self.rows, columns));
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
        let zero = Part::zero();
        let first: Vec<Jet<Part>> = (0..self.freedoms)
            .map(|freedom| Jet { value: part(0.0, By::Positions, freedom), rate: zero, acceleration: zero })
            .collect();
        let moving = |freedom: usize| Jet {
            value: zero,
            rate: part(point.state.velocity[freedom], By::Velocities, freedom),
            acceleration: part(point.accelerations[freedom], By::Accelerations, freedom),
        };
        let second: Vec<Jet<Part>> = (0..self.freedoms).map(moving).collect();
        let offsets = Offsets { from: point.state, to: point.state, first: &first, second: &second, motion: &[] };
        let placed = place(&self.figures, &offsets);
        let mut efforts = residual(&self.figures, &placed, &offsets);
        for (row, value) in closures(&self.figures, &[], &placed, &offsets).into_iter().enumerate() {
            set(row, Some(0), value.value);
            set(row, Some(1), value.rate);
            set(row, Some(2), value.acceleration);
        }
        if point.multipliers.iter().any(|&multiplier| multiplier != 0.0) {
            // The gradient of the closures is their rate for unit velocities.
            let mut unit = vec![Jet::<Part>::zero(); self.freedoms];
            for (freedom, effort) in efforts.iter_mut().enumerate() {
                unit[freedom].rate = Dual::of(1.0);
                let offsets = Offsets { second: &unit, ..offsets };
                let rates = closures(&self.figures, &[], &place(&self.figures, &offsets), &offsets);
                for (rate, &multiplier) in rates.iter().zip(point.multipliers.iter()) {
                    *effort = *effort - rate.rate.times(multiplier);
                }
                unit[freedom].rate = zero;
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
