//! Ranges of a formula and of its derivatives over a stretch of time, and the longest stretch that stages of a step resolve.
//!
//! Each operation takes intervals of its operands to an interval that contains all its values (R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction
//! to Interval Analysis, SIAM 2009, chapters 2 and 5). Nothing between two instants is missed. A stretch of h seconds is resolved if
//!
//! ```text
//!     h max |f'| ≤ 8 W   and   h² max |f''| ≤ 64 W        W = max f − min f over the stretch, by its range
//!     or both ≤ 10⁻⁶ W over the next hundred steps        a part that changes too little to count
//! ```
//!
//! A sine is resolved over 8 rad, longer than any step of the scheme, so that smooth formulas bound no step. A pulse is resolved over a few of its
//! widths, and the steps that meet it see it. At kinks, as of √((t − c)²), one of the derivatives has no bound: steps end before the kink and pass it in
//! one step of 10⁻⁵ of their length. Roundings of the ends of ranges are neglected.

use crate::description::formula::{Arithmetic, Formula};
use crate::description::formula_text::{Function, Operation};
use std::f64::consts::{FRAC_PI_2, TAU};

/// `h max |f'|/W` and `h² max |f''|/W` of a stretch that is resolved, at most.
const RATE: f64 = 8.0;
const SECOND: f64 = 64.0;
/// The part of the changes within the next steps that need not be resolved, and the number of these steps.
const NEGLIGIBLE: f64 = 1e-6;
const AHEAD: f64 = 100.0;
/// The part of a step that passes a kink.
const PASSING: f64 = 1e-5;
/// Halvings of a step until its end before a kink is known.
const HALVINGS: usize = 30;
/// The part of a value that is a rounding.
const ROUNDING: f64 = 1e-12;

/// All numbers from `low` to `high`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Range {
    low: f64,
    high: f64,
}

/// Ranges of a value and of its first and second derivative by time.
type Jets = [Range; 3];

const EVERYTHING: Range = Range { low: f64::NEG_INFINITY, high: f64::INFINITY };
const ZERO: Range = Range::of(0.0);

impl Range {
    const fn of(value: f64) -> Self {
        Range { low: value, high: value }
    }

    /// The range of two ends in any order; everything if one of them is no number.
    fn between(a: f64, b: f64) -> Self {
        if a.is_nan() || b.is_nan() { EVERYTHING } else { Range { low: a.min(b), high: a.max(b) } }
    }

    fn plus(self, other: Range) -> Self {
        Range::between(self.low + other.low, self.high + other.high)
    }

    fn negative(self) -> Self {
        Range { low: -self.high, high: -self.low }
    }

    fn minus(self, other: Range) -> Self {
        self.plus(other.negative())
    }

    fn times(self, other: Range) -> Self {
        if self == ZERO || other == ZERO {
            return ZERO;
        }
        let corners = [self.low * other.low, self.low * other.high, self.high * other.low, self.high * other.high];
        if corners.iter().any(|corner| corner.is_nan()) {
            return EVERYTHING;
        }
        Range {
            low: corners.into_iter().fold(f64::INFINITY, f64::min),
            high: corners.into_iter().fold(f64::NEG_INFINITY, f64::max),
        }
    }

    fn scaled(self, factor: f64) -> Self {
        self.times(Range::of(factor))
    }

    fn inverse(self) -> Self {
        if self.low <= 0.0 && self.high >= 0.0 { EVERYTHING } else { Range::between(1.0 / self.low, 1.0 / self.high) }
    }

    /// Under a function that grows or falls throughout.
    fn monotone(self, function: impl Fn(f64) -> f64) -> Self {
        Range::between(function(self.low), function(self.high))
    }

    /// Under a function that is even and grows from zero.
    fn even(self, function: impl Fn(f64) -> f64) -> Self {
        let (least, most) = self.sizes();
        Range::between(function(least), function(most))
    }

    /// The least and the largest size.
    fn sizes(self) -> (f64, f64) {
        let least = if self.low <= 0.0 && self.high >= 0.0 { 0.0 } else { self.low.abs().min(self.high.abs()) };
        (least, self.low.abs().max(self.high.abs()))
    }

    fn size(self) -> f64 {
        self.sizes().1
    }

    fn square(self) -> Self {
        self.even(|size| size * size)
    }

    /// The part within bounds, where a function is defined.
    fn within(self, low: f64, high: f64) -> Self {
        Range { low: self.low.clamp(low, high), high: self.high.clamp(low, high) }
    }

    fn sine(self) -> Self {
        let full = Range { low: -1.0, high: 1.0 };
        if self.high - self.low >= TAU {
            return full;
        }
        // Whether a crest or a trough is inside.
        let meets = |phase: f64| ((self.high - phase) / TAU).floor() >= ((self.low - phase) / TAU).ceil();
        let ends = Range::between(self.low.sin(), self.high.sin());
        Range {
            low: if meets(-FRAC_PI_2) { -1.0 } else { ends.low },
            high: if meets(FRAC_PI_2) { 1.0 } else { ends.high },
        }
    }

    fn cosine(self) -> Self {
        self.plus(Range::of(FRAC_PI_2)).sine()
    }

    /// To a constant power.
    fn power(self, exponent: f64) -> Self {
        if exponent == 0.0 {
            return Range::of(1.0);
        }
        if exponent.fract() != 0.0 {
            return self.within(0.0, f64::INFINITY).monotone(|base| base.powf(exponent));
        }
        if exponent < 0.0 {
            return self.power(-exponent).inverse();
        }
        if exponent % 2.0 == 0.0 {
            self.even(|size| size.powf(exponent))
        } else {
            self.monotone(|base| base.powf(exponent))
        }
    }
}

/// f(a), from the ranges of f and its derivatives over that of a.
fn chained(a: Jets, [value, first, second]: Jets) -> Jets {
    [value, first.times(a[1]), second.times(a[1].square()).plus(first.times(a[2]))]
}

/// A function of a range.
fn function_of(function: Function, a: Jets) -> Jets {
    let x = a[0];
    let one = Range::of(1.0);
    let derivatives = match function {
        Function::Sin => [x.sine(), x.cosine(), x.sine().negative()],
        Function::Cos => [x.cosine(), x.sine().negative(), x.cosine().negative()],
        Function::Tan => {
            let slope = x.cosine().square().inverse();
            let value = if slope.high.is_finite() { x.monotone(f64::tan) } else { EVERYTHING };
            [value, slope, value.times(slope).scaled(2.0)]
        }
        Function::Asin | Function::Acos => {
            let x = x.within(-1.0, 1.0);
            let square = one.minus(x.square());
            let slope = square.monotone(f64::sqrt).inverse();
            let sign = if function == Function::Asin { 1.0 } else { -1.0 };
            let value = x.monotone(if function == Function::Asin { f64::asin } else { f64::acos });
            [value, slope.scaled(sign), x.times(slope).times(square.inverse()).scaled(sign)]
        }
        Function::Atan => {
            let slope = x.square().plus(one).inverse();
            [x.monotone(f64::atan), slope, x.times(slope.square()).scaled(-2.0)]
        }
        Function::Sinh => [x.monotone(f64::sinh), x.even(f64::cosh), x.monotone(f64::sinh)],
        Function::Cosh => [x.even(f64::cosh), x.monotone(f64::sinh), x.even(f64::cosh)],
        Function::Tanh => {
            let (value, slope) = (x.monotone(f64::tanh), x.even(|size| size.cosh().powi(-2)));
            [value, slope, value.times(slope).scaled(-2.0)]
        }
        Function::Exp => [x.monotone(f64::exp); 3],
        Function::Ln => {
            let x = x.within(0.0, f64::INFINITY);
            [x.monotone(f64::ln), x.inverse(), x.square().inverse().negative()]
        }
        Function::Sqrt => {
            let x = x.within(0.0, f64::INFINITY);
            [x.power(0.5), x.power(-0.5).scaled(0.5), x.power(-1.5).scaled(-0.25)]
        }
    };
    chained(a, derivatives)
}

/// An operation of two.
fn combined(operation: Operation, a: Jets, b: Jets) -> Jets {
    match operation {
        Operation::Add => [a[0].plus(b[0]), a[1].plus(b[1]), a[2].plus(b[2])],
        Operation::Subtract => [a[0].minus(b[0]), a[1].minus(b[1]), a[2].minus(b[2])],
        Operation::Divide if b[1] == ZERO && b[2] == ZERO => a.map(|part| part.times(b[0].inverse())),
        Operation::Divide => combined(Operation::Multiply, a, chained(b, powers(b[0], -1.0))),
        Operation::Power if b[1] == ZERO && b[2] == ZERO => chained(a, powers(a[0], b[0].low)),
        Operation::Power => {
            let exponent = combined(Operation::Multiply, b, function_of(Function::Ln, a));
            function_of(Function::Exp, exponent)
        }
        _ => {
            let cross = a[1].times(b[1]).scaled(2.0);
            [
                a[0].times(b[0]),
                a[1].times(b[0]).plus(a[0].times(b[1])),
                a[2].times(b[0]).plus(cross).plus(a[0].times(b[2])),
            ]
        }
    }
}

/// A constant power with its derivatives by the base.
fn powers(base: Range, exponent: f64) -> Jets {
    let term = |factor: f64, power: f64| if factor == 0.0 { ZERO } else { base.power(power).scaled(factor) };
    [base.power(exponent), term(exponent, exponent - 1.0), term(exponent * (exponent - 1.0), exponent - 2.0)]
}

impl Arithmetic for Jets {
    fn number(value: f64) -> Self {
        [Range::of(value), ZERO, ZERO]
    }

    fn negative(self) -> Self {
        self.map(Range::negative)
    }

    fn under(self, function: Function) -> Self {
        function_of(function, self)
    }

    fn combined(self, operation: Operation, other: Self) -> Self {
        combined(operation, self, other)
    }
}

impl Formula {
    /// Ranges of the value and of its first and second derivative from one time to another (s). Does not allocate.
    fn ranges(&self, from: f64, to: f64) -> Jets {
        self.evaluate([Range::between(from, to), Range::of(1.0), ZERO])
    }

    /// Whether the stretch from a time to another (s) is resolved; a change of less than `ignored` does not count.
    fn is_resolved(&self, from: f64, to: f64, ignored: f64) -> bool {
        let [value, rate, second] = self.ranges(from, to);
        let length = to - from;
        let (changes, bends) = (length * rate.size(), length * length * second.size());
        let wide = value.high - value.low + ROUNDING * value.size();
        // An unbounded range is not resolved.
        wide < f64::INFINITY
            && (changes <= RATE * wide && bends <= SECOND * wide || changes <= ignored && bends <= ignored)
    }

    /// The longest step that stages resolve, of `step` seconds from a time at most, where the run goes on to `until` (s). Does not allocate.
    pub fn resolved_step(&self, time: f64, step: f64, until: f64) -> f64 {
        let step = step.min(until - time);
        if self.is_constant() || step <= 0.0 || self.is_resolved(time, time + step, 0.0) {
            return step;
        }
        let [ahead, ..] = self.ranges(time, until.min(time + AHEAD * step));
        let wide = ahead.high - ahead.low;
        let ignored = if wide < f64::INFINITY { NEGLIGIBLE * wide } else { 0.0 };
        let holds = |from: f64, to: f64| self.is_resolved(time + from, time + to, ignored);
        if holds(0.0, step) {
            return step;
        }
        let passing = PASSING * step;
        if !holds(0.0, passing) {
            // A kink is passed. A formula without bounds behind it, too, tells nothing.
            return if holds(4.0 * passing, 5.0 * passing) { passing } else { step };
        }
        let (mut good, mut bad) = (passing, step);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (good + bad);
            if holds(0.0, middle) {
                good = middle;
            } else {
                bad = middle;
            }
        }
        good
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn formula(text: &str) -> Formula {
        let parameters = [("w".to_string(), 0.01)];
        Formula::new(text, &parameters).expect(text)
    }

    #[test]
    fn ranges_contain_all_values_and_derivatives() {
        let texts = [
            "sin(3*t)*exp(-t)",
            "t^3 - 2*t",
            "1/(1 + t^2)",
            "sqrt(1+t)",
            "ln(2+t)",
            "tan(0.4*t)",
            "asin(0.3*t)",
            "acos(0.3*t)",
            "atan(2*t)",
            "sinh(t) - cosh(t)",
            "tanh((t - 1)/0.3)",
            "(1+t)^t",
            "2^t",
            "(1+t)^0.5",
            "exp(-((t-0.7)/0.2)^2)",
            "cos(9*t)/(2 + t)",
        ];
        for text in texts {
            let formula = formula(text);
            for (from, to) in [(0.1, 0.2), (0.0, 1.0), (0.5, 2.0)] {
                let ranges = formula.ranges(from, to);
                for index in 0..=40 {
                    let time = from + (to - from) * f64::from(index) / 40.0;
                    for (range, value) in ranges.iter().zip(formula.at(time)) {
                        // The ends are rounded.
                        let rounding = 1e-13 * range.size().min(1e6);
                        let inside = range.low - rounding <= value && value <= range.high + rounding;
                        assert!(inside, "{text} at {time}: {value} is not in {range:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn smooth_formulas_bound_no_step_and_a_pulse_bounds_those_that_meet_it() {
        // 7 rad, from any phase.
        for time in [0.0, 0.4, 1.1, 2.9] {
            for text in ["sin(50*t)", "1 + 0.01*cos(50*t + 0.3)"] {
                assert_eq!(formula(text).resolved_step(time, 0.14, 10.0), 0.14, "{text} from {time}");
            }
        }
        for text in ["t", "3 - 2*t^2", "10*t^3 - 15*t^4 + 6*t^5", "exp(-t)", "tanh(t)", "1 - exp(-3*t)", "t^8"] {
            assert_eq!(formula(text).resolved_step(0.0, 0.5, 10.0), 0.5, "{text}");
        }
        let pulse = formula("exp(-((t-3.7)/w)^2)/w");
        let first = pulse.resolved_step(0.0, 10.0, 10.0);
        // It ends where the pulse is 10⁻⁶ of its height, 3.7 widths before, or a little sooner: the range of a product is too wide.
        assert!((3.6..3.67).contains(&first), "{first}");
        let inside = pulse.resolved_step(3.69, 10.0, 10.0);
        assert!((0.005..0.06).contains(&inside), "{inside}");
        assert_eq!(pulse.resolved_step(4.0, 6.0, 10.0), 6.0);
        // Between two kinks of a formula the steps end before each.
        let kink = formula("sqrt((t-0.533)^2)");
        let before = kink.resolved_step(0.0, 2.0, 2.0);
        assert!((0.3..0.533).contains(&before), "{before}");
        assert_eq!(kink.resolved_step(0.532_999_9, 1.0, 2.0), 1e-5);
    }
}
