//! The derivative of an impact at its active set, round by round.
//!
//! ```text
//!     M(q) (v⁺ − v⁻) = Wᵀ P + Gᵀ Λ,   G v⁺ = 0
//!     open     P = 0
//!     closed   u_N + e min(u_N⁻, 0) = 0          sticks   u_T = 0          slides   P_T + μ P_N u_T/|u_T| = 0
//!
//!     v = v_C + σ (v_N − v_C)          σ = 1, or the root of ½ vᵀ M v = ½ v⁻ᵀ M v⁻
//! ```
//!
//! v_C is the plastic answer (e = 0), v_N the one of Newton's law; both have active sets of their own, as in [`crate::instant::cone::impact`]. The
//! equations are solved again by Newton's method, and the matrix at the solution gives the derivatives.

use crate::derivatives::equations::contacts::TouchFigures;
use crate::derivatives::equations::residual::still;
use crate::derivatives::events::instant::Instant;
use crate::derivatives::forward::step::{Part, WIDTH, constant};
use crate::derivatives::numbers::number::Number;
use crate::derivatives::numbers::vector::Vector;
use crate::instant::cone::impact::Round;
use crate::instant::cone::problem::{Answer, BlockState};
use nalgebra::{DMatrix, DVector};

/// Iterations; two or three are made.
const ITERATIONS: usize = 30;
/// Corrections below this part of the velocities that do not shrink any more are rounding.
const ROUNDING: f64 = 1e-10;

/// A limit or contact that meets.
pub enum Met<T> {
    /// A degree of freedom, the direction into the allowed range, and e.
    Joint { freedom: usize, sign: f64, restitution: T },
    /// A contact with μ and e; without friction only its normal counts.
    Contact { touch: TouchFigures<T>, friction: T, restitution: T },
}

impl<T: Number> Met<T> {
    fn rows(&self) -> usize {
        match self {
            Met::Contact { friction, .. } if friction.value() > 0.0 => 3,
            _ => 1,
        }
    }
}

/// The equations of one answer.
struct Equations<'e, T> {
    at: &'e Instant<'e, T>,
    met: &'e [Met<T>],
    /// The blocks that take part, and their states.
    part: &'e [usize],
    states: &'e [BlockState],
    /// Whether restitution counts.
    rebounds: bool,
    before: &'e [T],
    /// Independent closures.
    closed: &'e [usize],
}

/// One contact in place.
struct Placed<T> {
    point: Vector<T>,
    axes: [Vector<T>; 3],
}

impl<T: Number> Equations<'_, T> {
    fn placed(&self) -> Vec<Option<Placed<T>>> {
        if self.part.iter().all(|&block| matches!(self.met[block], Met::Joint { .. })) {
            return self.part.iter().map(|_| None).collect();
        }
        let rest = vec![T::zero(); self.before.len()];
        let bodies = still(&self.at.placed(&rest));
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
                Some(Placed { point: found.point, axes: [normal, first, normal.cross(first)] })
            }
        };
        self.part.iter().map(place).collect()
    }

    /// The rates of all rows of a block.
    fn rates(&self, block: usize, placed: Option<&Placed<T>>, velocities: &[T]) -> Vec<T> {
        match (&self.met[block], placed) {
            (Met::Contact { touch, .. }, Some(placed)) => {
                let slip = touch.slip(&self.at.placed(velocities), placed.point);
                placed.axes[..self.met[block].rows()].iter().map(|axis| axis.dot(slip)).collect()
            }
            (Met::Joint { freedom, sign, .. }, _) => vec![velocities[*freedom].times(*sign)],
            (Met::Contact { .. }, None) => Vec::new(),
        }
    }

    /// The residuals for velocities, impulses and multipliers of closures.
    fn residual(&self, velocities: &[T], impulses: &[T], multipliers: &[T]) -> Vec<T> {
        let placed = self.placed();
        let change: Vec<T> = velocities.iter().zip(self.before).map(|(&after, &before)| after - before).collect();
        let mut rows = self.at.momenta(&change);
        let mut forces = Vec::new();
        let mut laws = Vec::new();
        let mut first = 0;
        for ((&block, placed), &state) in self.part.iter().zip(&placed).zip(self.states) {
            let met = &self.met[block];
            let own = &impulses[first..first + met.rows()];
            first += met.rows();
            let after = self.rates(block, placed.as_ref(), velocities);
            let before = self.rates(block, placed.as_ref(), self.before);
            let (restitution, friction) = match met {
                Met::Joint { freedom, sign, restitution } => {
                    rows[*freedom] = rows[*freedom] - own[0].times(*sign);
                    (*restitution, T::zero())
                }
                Met::Contact { touch, friction, restitution } => {
                    if let Some(Placed { point, axes }) = placed {
                        let mut force = Vector::zero();
                        own.iter().zip(axes).for_each(|(&size, axis)| force = force + axis.scaled(size));
                        forces.push((touch.b.body, *point, force));
                        forces.push((touch.a.body, *point, -force));
                    }
                    (*restitution, *friction)
                }
            };
            let approaches = self.rebounds && before[0].value() < 0.0;
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
        for (row, push) in rows.iter_mut().zip(self.at.pushes(velocities, multipliers, &forces)) {
            *row = *row - push;
        }
        let rates = self.at.closure_rates(velocities);
        rows.into_iter().chain(laws).chain(self.closed.iter().map(|&row| rates[row])).collect()
    }
}

/// The instant of an impact, for doubles and for each [`WIDTH`] parameters.
pub struct Impact<'i> {
    pub at: Instant<'i, Part>,
    pub met: &'i [Met<Part>],
    pub closed: &'i [usize],
    pub row_count: usize,
}

impl Impact<'_> {
    /// The velocities after all rounds, with their derivatives; `None` if the equations of a round are singular.
    pub(crate) fn after(&self, before: &[Part], rounds: &[Round]) -> Option<Vec<Part>> {
        let mut velocities = before.to_vec();
        for round in rounds {
            let plastic = self.answer(&velocities, &round.part, &round.plastic, false)?;
            velocities = match &round.rebound {
                None => plastic,
                Some(answer) => {
                    let rebound = self.answer(&velocities, &round.part, answer, true)?;
                    if round.share == 1.0 {
                        rebound
                    } else {
                        self.shared(&velocities, &plastic, &rebound, round.share)?
                    }
                }
            };
        }
        Some(velocities)
    }

    /// One answer, with its derivatives.
    fn answer(&self, before: &[Part], part: &[usize], answer: &Answer, rebounds: bool) -> Option<Vec<Part>> {
        let n = before.len();
        let equations = Equations {
            at: &self.at,
            met: self.met,
            part,
            states: &answer.states,
            rebounds,
            before,
            closed: self.closed,
        };
        let impulses = answer.forces.len();
        let count = n + impulses + self.closed.len();
        let mut unknowns: Vec<f64> = before.iter().map(|rate| rate.value).collect();
        unknowns.extend(&answer.forces);
        unknowns.resize(count, 0.0);
        if answer.states.contains(&BlockState::Slips) {
            self.move_off(&equations, before, &mut unknowns)?;
        }
        let mut last = f64::INFINITY;
        for _ in 0..ITERATIONS {
            let (matrix, residual) = self.linear(&equations, before, &unknowns);
            let factors = matrix.lu();
            if !factors.is_invertible() {
                return None;
            }
            let values = DVector::from_iterator(count, residual.iter().map(|row| row.value));
            let correction = factors.solve(&values)?;
            unknowns.iter_mut().zip(correction.iter()).for_each(|(unknown, by)| *unknown -= by);
            let speed = before.iter().fold(f64::MIN_POSITIVE, |most, rate| most.max(rate.value.abs()));
            let size = correction.rows(0, n).amax() / speed;
            if !size.is_finite() {
                return None;
            }
            if size < ROUNDING && size >= 0.25 * last || size == 0.0 {
                let (matrix, residual) = self.linear(&equations, before, &unknowns);
                let right = DMatrix::from_fn(count, WIDTH, |row, part| -residual[row].parts[part]);
                let found = matrix.lu().solve(&right)?;
                let part = |row: usize| {
                    let mut value = Part::of(unknowns[row]);
                    (0..WIDTH).for_each(|part| value.parts[part] = found[(row, part)]);
                    value
                };
                return Some((0..n).map(part).collect());
            }
            last = size;
        }
        None
    }

    /// Begins with the velocities that the impulses of the answer give, because a direction of slip is needed.
    fn move_off(&self, equations: &Equations<Part>, before: &[Part], unknowns: &mut [f64]) -> Option<()> {
        let n = before.len();
        let mass = self.columns(n, |unit| self.at.momenta(unit));
        let impulses: Vec<Part> = constant(&unknowns[n..unknowns.len() - self.closed.len()]);
        let pushes = equations.residual(before, &impulses, &vec![Part::zero(); self.row_count]);
        let right = DVector::from_iterator(n, pushes[..n].iter().map(|row| -row.value));
        let border = self.columns(n, |unit| {
            let rates = self.at.closure_rates(unit);
            self.closed.iter().map(|&row| rates[row]).collect()
        });
        let m = self.closed.len();
        let mut whole = DMatrix::zeros(n + m, n + m);
        whole.view_mut((0, 0), (n, n)).copy_from(&mass);
        whole.view_mut((n, 0), (m, n)).copy_from(&border);
        whole.view_mut((0, n), (n, m)).copy_from(&border.transpose());
        let found = whole.lu().solve(&right.resize_vertically(n + m, 0.0))?;
        (0..n).for_each(|row| unknowns[row] = before[row].value + found[row]);
        Some(())
    }

    /// A linear function of velocities as a matrix.
    fn columns(&self, n: usize, of: impl Fn(&[Part]) -> Vec<Part>) -> DMatrix<f64> {
        let mut columns = Vec::new();
        for freedom in 0..n {
            let mut unit = vec![Part::zero(); n];
            unit[freedom] = Part::of(1.0);
            columns.push(of(&unit));
        }
        let rows = columns.first().map_or(0, Vec::len);
        DMatrix::from_fn(rows, n, |row, column| columns[column][row].value)
    }

    /// The matrix of the equations, and their residuals with the derivatives by the parameters.
    fn linear(&self, equations: &Equations<Part>, before: &[Part], unknowns: &[f64]) -> (DMatrix<f64>, Vec<Part>) {
        let (n, count) = (before.len(), unknowns.len());
        let split = |unknowns: &[Part]| {
            let impulses = unknowns[n..count - self.closed.len()].to_vec();
            let mut multipliers = vec![Part::zero(); self.row_count];
            let rest = &unknowns[count - self.closed.len()..];
            self.closed.iter().zip(rest).for_each(|(&row, &value)| multipliers[row] = value);
            equations.residual(&unknowns[..n], &impulses, &multipliers)
        };
        let residual = split(&constant(unknowns));
        let mut matrix = DMatrix::zeros(count, count);
        for first in (0..count).step_by(WIDTH) {
            let width = WIDTH.min(count - first);
            let mut own: Vec<Part> = constant(unknowns);
            (0..width).for_each(|part| own[first + part] = Part::parameter(unknowns[first + part], part));
            let rows = split(&own);
            // The parameters are in the same parts: their share is taken off.
            for (row, value) in rows.iter().enumerate() {
                (0..width).for_each(|part| {
                    matrix[(row, first + part)] = value.parts[part] - residual[row].parts[part];
                });
            }
        }
        (matrix, residual)
    }

    /// `v_C + σ (v_N − v_C)`, with σ at which no energy is gained.
    fn shared(&self, before: &[Part], plastic: &[Part], rebound: &[Part], share: f64) -> Option<Vec<Part>> {
        let energy = |velocities: &[Part]| {
            let momenta = self.at.momenta(velocities);
            velocities.iter().zip(momenta).fold(Part::zero(), |sum, (&rate, momentum)| sum + rate * momentum).times(0.5)
        };
        let mixed = |share: Part| -> Vec<Part> {
            plastic.iter().zip(rebound).map(|(&one, &other)| one + share * (other - one)).collect()
        };
        // The energy is a polynomial of second degree in σ.
        let start = energy(before);
        let at = |share: f64| energy(&mixed(Part::of(share))) - start;
        let width = 0.25;
        let slope = (at(share + width) - at(share - width)).value / (2.0 * width);
        if slope == 0.0 || !slope.is_finite() {
            return None;
        }
        let mut share = Part::of(share);
        for _ in 0..3 {
            share.value -= at(share.value).value / slope;
        }
        let left = at(share.value);
        (0..WIDTH).for_each(|part| share.parts[part] = -left.parts[part] / slope);
        Some(mixed(share))
    }
}
