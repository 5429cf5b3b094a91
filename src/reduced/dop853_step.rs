//! One step of [`crate::dop853`]: its stages, its error, and the polynomial of dense output.

use crate::dop853_table::{DENSE, DENSE_STAGES, FIFTH_ORDER_ERROR, Row, SOLUTION, STAGES, THIRD_ORDER};
use crate::ode::{ReducedOde, joint_of_entry};
use crate::weighted_sums::{add_scaled, weighted_sum};
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::motion::inputs::Inputs;
use catena_mechanism::motion::integrator::StepError;

/// The error estimate behaves like h⁸.
pub(crate) const ORDER: f64 = 8.0;
/// The slope at the end of the step has this place among the slopes.
pub(crate) const END_SLOPE: usize = 12;

/// The vectors of a step, one behind the other where they are summed together.
#[derive(Clone, Debug)]
pub(crate) struct Work {
    pub ode: ReducedOde,
    pub start: Vec<f64>,
    pub end: Vec<f64>,
    pub stage: Vec<f64>,
    /// Σ b k and Σ (b − b̂) k.
    pub mean_slope: Vec<f64>,
    pub fifth_order_error: Vec<f64>,
    /// The 12 slopes of the stages, the one at the end, and the 3 of dense output.
    pub slopes: Vec<f64>,
    /// The 8 coefficients of dense output.
    pub polynomial: Vec<f64>,
    pub polynomial_is_current: bool,
    /// When the step begins (s), if what drives the joints changes in time.
    pub clock: Option<f64>,
}

/// The instant of a stage, as a part of the step: c = Σ a.
fn node(row: Row) -> f64 {
    row.iter().map(|(_, weight)| weight).sum()
}

impl Work {
    /// Room for the steps of a system.
    pub fn new(ode: ReducedOde) -> Self {
        let zeros = |count: usize| vec![0.0; count * ode.dimension()];
        Work {
            start: zeros(1),
            end: zeros(1),
            stage: zeros(1),
            mean_slope: zeros(1),
            fifth_order_error: zeros(1),
            slopes: zeros(16),
            polynomial: zeros(8),
            polynomial_is_current: false,
            clock: None,
            ode,
        }
    }

    /// Tells the system what drives it at a part of the step, if that changes in time.
    fn drive(&mut self, since_start: f64, inputs: Inputs) {
        if let Some(start) = self.clock {
            self.ode.drive_at(start + since_start, inputs);
        }
    }

    /// The first slope.
    pub fn slope_of_start(&mut self, inputs: Inputs) {
        self.drive(0.0, inputs);
        let n = self.start.len();
        self.ode.derivative(&self.start, &mut self.slopes[..n]);
    }

    /// The slope at the end, and dense output where it could not be had later.
    pub fn finish(&mut self, step: f64, inputs: Inputs) {
        self.polynomial_is_current = false;
        self.ode.normalise(&mut self.end);
        self.drive(step, inputs);
        let n = self.end.len();
        self.ode.derivative(&self.end, &mut self.slopes[END_SLOPE * n..(END_SLOPE + 1) * n]);
        if self.clock.is_some() {
            self.find_polynomial(step, inputs);
        }
    }

    /// A first step from the sizes of y, ẏ and ÿ, by one explicit Euler step (algorithm II.4.14). One evaluation.
    pub fn initial_step(&mut self, tolerance: f64, longest: f64, inputs: Inputs) -> f64 {
        let n = self.start.len();
        let (first, rest) = self.slopes.split_at_mut(n);
        let second = &mut rest[..n];
        let scale = |y: f64| tolerance * (1.0 + y.abs());
        let sum =
            |values: &[f64]| values.iter().zip(&self.start).map(|(&value, &y)| (value / scale(y)).powi(2)).sum::<f64>();
        let (slope_size, state_size) = (sum(first), sum(&self.start));
        let tiny = slope_size <= 1e-10 || state_size <= 1e-10;
        let trial = if tiny { 1e-6 } else { 0.01 * (state_size / slope_size).sqrt() }.min(longest);
        // Speeds whose squares are infinite give no scale for a first step.
        if trial.is_nan() || trial <= 0.0 {
            return longest;
        }
        for ((stage, &y), &slope) in self.stage.iter_mut().zip(&self.start).zip(first.iter()) {
            *stage = y + trial * slope;
        }
        if let Some(start) = self.clock {
            self.ode.drive_at(start + trial, inputs);
        }
        self.ode.derivative(&self.stage, second);
        second.iter_mut().zip(first.iter()).for_each(|(entry, &slope)| *entry -= slope);
        let curvature = (sum(second).sqrt() / trial).max(slope_size.sqrt());
        let by_curvature =
            if curvature <= 1e-15 { (1e-3 * trial).max(1e-6) } else { (0.01 / curvature).powf(1.0 / ORDER) };
        (100.0 * trial).min(by_curvature).min(longest)
    }

    /// Slopes 1 to 11, the end point and what the error estimate needs.
    pub fn attempt(&mut self, step: f64, inputs: Inputs) {
        let n = self.start.len();
        for (stage, row) in STAGES.iter().enumerate().skip(1) {
            weighted_sum(row, &self.slopes, &mut self.stage);
            add_scaled(&self.start, step, &mut self.stage);
            self.drive(step * node(row), inputs);
            self.ode.derivative(&self.stage, &mut self.slopes[stage * n..(stage + 1) * n]);
        }
        weighted_sum(SOLUTION, &self.slopes, &mut self.mean_slope);
        self.end.copy_from_slice(&self.mean_slope);
        add_scaled(&self.start, step, &mut self.end);
    }

    /// The error of the step in units of the tolerance; NaN if anything in it is not finite.
    pub fn error(&mut self, step: f64, tolerance: f64) -> f64 {
        let n = self.start.len();
        weighted_sum(FIFTH_ORDER_ERROR, &self.slopes, &mut self.fifth_order_error);
        weighted_sum(THIRD_ORDER, &self.slopes, &mut self.stage);
        let (mut fifth, mut third) = (0.0, 0.0);
        let sizes = self.start.iter().zip(&self.end);
        let slopes = self.fifth_order_error.iter().zip(self.mean_slope.iter().zip(&self.stage));
        for ((&start, &end), (&difference, (&mean, &embedded))) in sizes.zip(slopes) {
            let weight = 1.0 / (tolerance * (1.0 + start.abs().max(end.abs())));
            fifth += (difference * weight).powi(2);
            third += ((mean - embedded) * weight).powi(2);
        }
        let denominator = fifth + 0.01 * third;
        if denominator == 0.0 { 0.0 } else { step * fifth / (n as f64 * denominator).sqrt() }
    }

    /// The entry with the largest error of order 5 in the last attempt.
    pub fn worst_entry(&self) -> usize {
        let size = |i: usize| self.fifth_order_error[i].abs() / (1.0 + self.end[i].abs());
        (0..self.end.len()).max_by(|&a, &b| size(a).total_cmp(&size(b))).unwrap_or(0)
    }

    /// The three further slopes and the coefficients of dense output (formula II.6.20 in the form of the code).
    pub fn find_polynomial(&mut self, step: f64, inputs: Inputs) {
        let n = self.start.len();
        for (stage, row) in (END_SLOPE + 1..).zip(DENSE_STAGES) {
            weighted_sum(row, &self.slopes, &mut self.stage);
            add_scaled(&self.start, step, &mut self.stage);
            self.drive(step * node(row), inputs);
            self.ode.derivative(&self.stage, &mut self.slopes[stage * n..(stage + 1) * n]);
        }
        let (low, high) = self.polynomial.split_at_mut(4 * n);
        for i in 0..n {
            let rise = self.end[i] - self.start[i];
            let start_bend = step * self.slopes[i] - rise;
            low[i] = self.start[i];
            low[n + i] = rise;
            low[2 * n + i] = start_bend;
            low[3 * n + i] = rise - step * self.slopes[END_SLOPE * n + i] - start_bend;
        }
        for (coefficient, row) in high.chunks_exact_mut(n).zip(DENSE) {
            weighted_sum(row, &self.slopes, coefficient);
            coefficient.iter_mut().for_each(|entry| *entry *= step);
        }
        self.polynomial_is_current = true;
    }

    /// Names the joint of the last entry that is not finite; velocities come after positions and fail first,
    /// and what fails in a leaf spoils everything that carries it.
    pub fn check_finite(&self, mechanism: &Mechanism, y: &[f64], time: f64, step: f64) -> Result<(), StepError> {
        match y.iter().rposition(|value| !value.is_finite()) {
            Some(bad) => Err(StepError::NotFinite { time, step, joint: joint_of_entry(mechanism, bad) }),
            None => Ok(()),
        }
    }
}
