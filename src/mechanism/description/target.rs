//! The target of a motor: a number, values at given instants with a curve between them, or a formula of time.
//!
//! ```text
//!     hold     r(t) = r_i                                  t_i ≤ t < t_{i+1}
//!     linear   r(t) = r_i + (t − t_i) (r_{i+1} − r_i)/h_i   h_i = t_{i+1} − t_i
//!     cubic    Hermite's polynomial through r_i, r_{i+1} with the slopes m_i of the natural cubic spline
//! ```
//!
//! Before the first instant and after the last the value is held. Source of the spline: C. de Boor, A Practical Guide to Splines,
//! Springer 2001, chapter IV (second derivatives zero at both ends).

use crate::description::formula::Formula;

/// How values between given instants come about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interpolation {
    /// The last given value.
    Hold,
    /// Along a straight line.
    #[default]
    Linear,
    /// Along a cubic spline with continuous second derivative.
    Cubic,
}

/// A target over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Target {
    times: Vec<f64>,
    values: Vec<f64>,
    /// Slopes at the instants, of a cubic.
    slopes: Vec<f64>,
    interpolation: Interpolation,
    /// Whether all values are the same.
    constant: bool,
    /// In place of the values.
    formula: Option<Formula>,
}

/// Why values over time are no target.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TargetError {
    /// There is no value.
    #[error("there are no values: give at least one")]
    Empty,
    /// A time or value is not a finite number.
    #[error("entry {index} (time {time}, value {value}) is not finite")]
    NotFinite {
        /// Counted from 1.
        index: usize,
        /// s.
        time: f64,
        /// The value there.
        value: f64,
    },
    /// The times do not grow.
    #[error("the time {time} s of entry {index} is not after {before} s, the one before it: give increasing times")]
    Order {
        /// Counted from 1.
        index: usize,
        /// s.
        time: f64,
        /// s.
        before: f64,
    },
}

impl Target {
    /// A number that does not change.
    pub fn constant(value: f64) -> Self {
        let (times, values, interpolation) = (vec![0.0], vec![value], Interpolation::Hold);
        Target { times, values, slopes: Vec::new(), interpolation, constant: true, formula: None }
    }

    /// A formula of time, which is smooth.
    pub fn formula(formula: Formula) -> Self {
        Target { constant: formula.is_constant(), formula: Some(formula), ..Target::constant(0.0) }
    }

    /// Its formula, if it is one.
    pub fn as_formula(&self) -> Option<&Formula> {
        self.formula.as_ref()
    }

    /// The same to be changed.
    pub fn as_formula_mut(&mut self) -> Option<&mut Formula> {
        self.formula.as_mut()
    }

    /// Values at instants (s), which must increase.
    ///
    /// # Errors
    /// [`TargetError`] for no values, numbers that are not finite, and times that do not increase.
    pub fn table(points: &[(f64, f64)], interpolation: Interpolation) -> Result<Self, TargetError> {
        if points.is_empty() {
            return Err(TargetError::Empty);
        }
        for (index, &(time, value)) in points.iter().enumerate() {
            if !time.is_finite() || !value.is_finite() {
                return Err(TargetError::NotFinite { index: index + 1, time, value });
            }
            if index > 0 && time <= points[index - 1].0 {
                return Err(TargetError::Order { index: index + 1, time, before: points[index - 1].0 });
            }
        }
        let (times, values): (Vec<f64>, Vec<f64>) = points.iter().copied().unzip();
        let slopes = if interpolation == Interpolation::Cubic { spline_slopes(&times, &values) } else { Vec::new() };
        let constant = values.iter().all(|&value| value == values[0]);
        Ok(Target { times, values, slopes, interpolation, constant, formula: None })
    }

    /// A number that a program may change at any time.
    pub fn commanded(value: f64) -> Self {
        Target { constant: false, ..Target::constant(value) }
    }

    /// Whether a program may change it.
    pub fn is_commanded(&self) -> bool {
        !self.constant && self.times.len() == 1 && self.formula.is_none()
    }

    /// The program gives it another value, without allocation.
    pub fn command(&mut self, value: f64) {
        self.values.fill(value);
    }

    /// Takes over another target, without allocation where both have as many values.
    pub fn copy_from(&mut self, other: &Target) {
        self.times.clone_from(&other.times);
        self.values.clone_from(&other.values);
        self.slopes.clone_from(&other.slopes);
        (self.interpolation, self.constant) = (other.interpolation, other.constant);
        self.formula.clone_from(&other.formula);
    }

    /// Whether it never changes.
    pub fn is_constant(&self) -> bool {
        self.constant
    }

    /// Its value at a time; at a jump, that after it.
    pub fn value(&self, time: f64) -> f64 {
        self.at(time, time).0
    }

    /// Its rate at a time; at a kink, that after it.
    pub fn rate(&self, time: f64) -> f64 {
        self.at(time, time).1
    }

    /// A curve through values at instants (s) with continuous rate, which is zero at both ends: of a joint that is moved.
    ///
    /// # Errors
    /// As [`Target::table`].
    pub fn smooth(points: &[(f64, f64)]) -> Result<Self, TargetError> {
        let mut target = Target::table(points, Interpolation::Cubic)?;
        target.slopes = slopes_between(&target.times, &target.values, [Some(0.0); 2]);
        Ok(target)
    }

    /// Value, rate and rate of the rate at a time, of the curve that begins at or before `since` (s).
    pub fn motion(&self, since: f64, time: f64) -> [f64; 3] {
        if let Some(formula) = &self.formula {
            return formula.at(time);
        }
        let (value, rate) = self.at(since, time);
        let piece = self.times.partition_point(|&knot| knot <= since + 1e-12 * since.abs().max(1.0));
        if self.interpolation != Interpolation::Cubic || piece == 0 || piece == self.times.len() {
            return [value, rate, 0.0];
        }
        let left = piece - 1;
        let (step, change) = (self.times[piece] - self.times[left], self.values[piece] - self.values[left]);
        let (first, second) = (step * self.slopes[left], step * self.slopes[piece]);
        let (square, cubic) = (3.0 * change - 2.0 * first - second, first + second - 2.0 * change);
        let x = (time - self.times[left]) / step;
        [value, rate, (2.0 * square + 6.0 * cubic * x) / (step * step)]
    }

    /// Value and rate at a time, of the curve that begins at or before `since` (s): where that ends, the values before the jump.
    pub fn piece(&self, since: f64, time: f64) -> (f64, f64) {
        self.at(since, time)
    }

    /// The next given instant after `time` (s).
    pub fn next_knot(&self, time: f64) -> f64 {
        if self.is_constant() || self.formula.is_some() {
            return f64::INFINITY;
        }
        let next = self.times.partition_point(|&knot| knot <= time + 1e-12 * time.abs().max(1.0));
        self.times.get(next).copied().unwrap_or(f64::INFINITY)
    }

    /// The longest step from a time on, of `step` seconds at most, over which stages resolve its formula, if it is one; the run goes on to `until` (s).
    pub fn resolved_step(&self, time: f64, step: f64, until: f64) -> f64 {
        self.formula.as_ref().map_or(step, |formula| formula.resolved_step(time, step, until))
    }

    fn at(&self, since: f64, time: f64) -> (f64, f64) {
        if let Some(formula) = &self.formula {
            let [value, rate, _] = formula.at(time);
            return (value, rate);
        }
        // An instant that a step has reached but for a rounding is reached.
        let piece = self.times.partition_point(|&knot| knot <= since + 1e-12 * since.abs().max(1.0));
        let last = self.times.len() - 1;
        if piece == 0 {
            return (self.values[0], 0.0);
        }
        let left = piece - 1;
        if left == last || self.interpolation == Interpolation::Hold {
            return (self.values[left], 0.0);
        }
        let (step, change) = (self.times[piece] - self.times[left], self.values[piece] - self.values[left]);
        let x = (time - self.times[left]) / step;
        match self.interpolation {
            Interpolation::Hold => (self.values[left], 0.0),
            Interpolation::Linear => (self.values[left] + x * change, change / step),
            Interpolation::Cubic => {
                let (first, second) = (step * self.slopes[left], step * self.slopes[piece]);
                let (square, cubic) = (3.0 * change - 2.0 * first - second, first + second - 2.0 * change);
                let value = self.values[left] + x * (first + x * (square + x * cubic));
                (value, (first + x * (2.0 * square + x * 3.0 * cubic)) / step)
            }
        }
    }
}

/// Slopes of the natural cubic spline: `m_{i−1}/h_{i−1} + 2 m_i (1/h_{i−1} + 1/h_i) + m_{i+1}/h_i = 3 (d_{i−1}/h_{i−1} + d_i/h_i)`, with
/// `d_i = (r_{i+1} − r_i)/h_i`, and `2 m_0 + m_1 = 3 d_0` at the ends.
fn spline_slopes(times: &[f64], values: &[f64]) -> Vec<f64> {
    slopes_between(times, values, [None; 2])
}

/// The same with given slopes at the first and the last instant.
fn slopes_between(times: &[f64], values: &[f64], ends: [Option<f64>; 2]) -> Vec<f64> {
    let count = times.len();
    if count == 1 {
        return vec![0.0];
    }
    let inverse: Vec<f64> = times.windows(2).map(|pair| 1.0 / (pair[1] - pair[0])).collect();
    let slope: Vec<f64> =
        values.windows(2).zip(&inverse).map(|(pair, inverse)| (pair[1] - pair[0]) * inverse).collect();
    let row = |index: usize| {
        let given = if index == 0 { ends[0] } else { ends[1].filter(|_| index + 1 == count) };
        if let Some(slope) = given {
            return (0.0, 1.0, 0.0, slope);
        }
        let before = if index > 0 { inverse[index - 1] } else { 0.0 };
        let after = if index + 1 < count { inverse[index] } else { 0.0 };
        let left = if index > 0 { slope[index - 1] * before } else { 0.0 };
        let right = if index + 1 < count { slope[index] * after } else { 0.0 };
        (before, 2.0 * (before + after), after, 3.0 * (left + right))
    };
    // Elimination of the tridiagonal rows, which are dominated by their diagonals.
    let (mut factors, mut sums) = (vec![0.0; count], vec![0.0; count]);
    for index in 0..count {
        let (before, diagonal, after, sum) = row(index);
        let (factor, known) = if index > 0 { (factors[index - 1], sums[index - 1]) } else { (0.0, 0.0) };
        let pivot = diagonal - before * factor;
        factors[index] = after / pivot;
        sums[index] = (sum - before * known) / pivot;
    }
    for index in (0..count - 1).rev() {
        sums[index] -= factors[index] * sums[index + 1];
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_goes_through_its_points_with_continuous_slope_and_curvature() {
        let points = [(0.0, 1.0), (0.5, -0.3), (0.8, 0.4), (2.0, 0.9)];
        let target = Target::table(&points, Interpolation::Cubic).unwrap();
        for &(time, value) in &points {
            assert!((target.value(time) - value).abs() < 1e-15, "{time}");
        }
        for time in [0.5, 0.8] {
            let (before, after) = (time - 1e-7, time + 1e-7);
            // The slope changes by curvature × 2e-7, the curvature by its own slope × 2e-4; both are below 100 here.
            assert!((target.rate(before) - target.rate(after)).abs() < 2e-5, "slope at {time}");
            let curvature = |near: f64, far: f64| (target.rate(near) - target.rate(far)) / (near - far);
            let (left, right) = (curvature(time - 1e-6, time - 1e-4), curvature(time + 1e-6, time + 1e-4));
            assert!((left - right).abs() < 3e-2, "curvature at {time}: {left} and {right}");
        }
    }

    #[test]
    fn values_are_held_outside_and_jumps_belong_to_what_follows() {
        let points = [(1.0, 2.0), (3.0, 5.0)];
        let hold = Target::table(&points, Interpolation::Hold).unwrap();
        assert_eq!([0.0, 1.0, 2.9, 3.0, 9.0].map(|time| hold.value(time)), [2.0, 2.0, 2.0, 5.0, 5.0]);
        let linear = Target::table(&points, Interpolation::Linear).unwrap();
        assert_eq!([0.0, 2.0, 9.0].map(|time| linear.value(time)), [2.0, 3.5, 5.0]);
        assert_eq!([0.0, 2.0, 9.0].map(|time| linear.rate(time)), [0.0, 1.5, 0.0]);
        assert_eq!([0.0, 1.0, 2.0, 3.0].map(|time| linear.next_knot(time)), [1.0, 3.0, 3.0, f64::INFINITY]);
    }

    #[test]
    fn what_is_no_target_is_refused_with_the_entry() {
        let table = |points: &[(f64, f64)]| Target::table(points, Interpolation::Linear).unwrap_err().to_string();
        assert!(table(&[]).contains("no values"));
        assert!(table(&[(0.0, 1.0), (0.0, 2.0)]).contains("entry 2"));
        assert!(table(&[(0.0, f64::NAN)]).contains("entry 1"));
    }
}
