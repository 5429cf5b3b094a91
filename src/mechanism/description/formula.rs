//! A formula of the time t (s), such as `a*sin(2*pi*3*t)`, with its first and second derivative.
//!
//! The value and both derivatives follow from each operation by the rules for truncated Taylor polynomials, exactly but for roundings:
//!
//! ```text
//!     (f(a))' = f' a',   (f(a))'' = f'' a'² + f' a'',   (a b)'' = a'' b + 2 a' b' + a b'',   q = a/b:  q'' = (a'' − 2 q' b' − q b'')/b
//! ```
//!
//! All functions are smooth but at single instants; [`crate::description::formula_ranges`] shortens the steps that would jump over fast changes.
//! [`crate::description::formula_text`] reads it. Source: A. Griewank, A. Walther, Evaluating Derivatives, SIAM 2008, section 13.2.

pub use crate::description::formula_text::FormulaError;
use crate::description::formula_text::{DEEPEST, Function, Operation, Reader};

/// A formula, ready to be evaluated.
#[derive(Clone, Debug, PartialEq)]
pub struct Formula {
    text: String,
    /// In the order of the operations, each after its operands.
    code: Vec<Operation>,
    parameters: Vec<(String, f64)>,
}

/// A value with its first and second derivative by time.
type Jet = [f64; 3];

/// An arithmetic in which formulas are evaluated.
pub(crate) trait Arithmetic: Copy {
    /// A number that does not depend on time.
    fn number(value: f64) -> Self;
    /// −a.
    fn negative(self) -> Self;
    /// f(a).
    fn under(self, function: Function) -> Self;
    /// An operation of two, this one the first.
    fn combined(self, operation: Operation, other: Self) -> Self;
}

impl Arithmetic for Jet {
    fn number(value: f64) -> Self {
        [value, 0.0, 0.0]
    }

    fn negative(self) -> Self {
        self.map(|part| -part)
    }

    fn under(self, function: Function) -> Self {
        function.of(self)
    }

    fn combined(self, operation: Operation, other: Self) -> Self {
        combined(operation, self, other)
    }
}

impl Formula {
    /// Reads a formula with these parameters.
    ///
    /// # Errors
    /// [`FormulaError`] with the place.
    pub fn new(text: &str, parameters: &[(String, f64)]) -> Result<Self, FormulaError> {
        let code = Reader::read(text, parameters)?;
        let formula = Formula { text: text.to_string(), code, parameters: parameters.to_vec() };
        let mut most = 0;
        let mut waiting = 0_usize;
        for operation in &formula.code {
            match operation {
                Operation::Number(_) | Operation::Time | Operation::Parameter(_) => waiting += 1,
                Operation::Negative | Operation::Call(_) => {}
                _ => waiting -= 1,
            }
            most = most.max(waiting);
        }
        if most > DEEPEST {
            let reason = format!("{most} numbers wait for their operators; {DEEPEST} is the most: use parentheses");
            return Err(FormulaError { text: text.to_string(), place: 1, reason });
        }
        Ok(formula)
    }

    /// The text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The parameters with their values.
    pub fn parameters(&self) -> &[(String, f64)] {
        &self.parameters
    }

    /// The same to be changed.
    pub fn parameters_mut(&mut self) -> &mut [(String, f64)] {
        &mut self.parameters
    }

    /// Whether it is a number with derivatives where a run starts.
    ///
    /// # Errors
    /// The value and the rate there.
    pub fn check_start(&self) -> Result<(), String> {
        let [value, rate, second] = self.at(0.0);
        if [value, rate, second].iter().all(|number| number.is_finite()) {
            return Ok(());
        }
        Err(format!(
            "formula {:?}: at t = 0 its value is {value}, its rate {rate}, the rate of that {second}",
            self.text
        ))
    }

    /// Whether it does not depend on time.
    pub fn is_constant(&self) -> bool {
        !self.code.contains(&Operation::Time)
    }

    /// Its value and its first and second derivative at a time (s). Does not allocate.
    pub fn at(&self, time: f64) -> [f64; 3] {
        self.evaluate([time, 1.0, 0.0])
    }

    /// Its value in an arithmetic, for a time. Does not allocate.
    pub(crate) fn evaluate<T: Arithmetic>(&self, time: T) -> T {
        let mut stack = [T::number(0.0); DEEPEST + 1];
        let mut top = 0;
        for operation in &self.code {
            match *operation {
                Operation::Number(number) => stack[top] = T::number(number),
                Operation::Parameter(index) => stack[top] = T::number(self.parameters[index].1),
                Operation::Time => stack[top] = time,
                Operation::Negative => stack[top - 1] = stack[top - 1].negative(),
                Operation::Call(function) => stack[top - 1] = stack[top - 1].under(function),
                two => {
                    top -= 1;
                    stack[top - 1] = stack[top - 1].combined(two, stack[top]);
                    continue;
                }
            }
            top += usize::from(matches!(operation, Operation::Number(_) | Operation::Parameter(_) | Operation::Time));
        }
        stack[0]
    }
}

/// An operation of two.
fn combined(operation: Operation, a: Jet, b: Jet) -> Jet {
    match operation {
        Operation::Add => [a[0] + b[0], a[1] + b[1], a[2] + b[2]],
        Operation::Subtract => [a[0] - b[0], a[1] - b[1], a[2] - b[2]],
        Operation::Divide => {
            let value = a[0] / b[0];
            let rate = (a[1] - value * b[1]) / b[0];
            [value, rate, (a[2] - 2.0 * rate * b[1] - value * b[2]) / b[0]]
        }
        Operation::Power if b[1] == 0.0 && b[2] == 0.0 => {
            // Zero times an infinite power is zero: t^1 at t = 0.
            let term = |factor: f64, power: f64| if factor == 0.0 { 0.0 } else { factor * a[0].powf(power) };
            let exponent = b[0];
            chained(
                a,
                [
                    a[0].powf(exponent),
                    term(exponent, exponent - 1.0),
                    term(exponent * (exponent - 1.0), exponent - 2.0),
                ],
            )
        }
        Operation::Power => Function::Exp.of(combined(Operation::Multiply, b, Function::Ln.of(a))),
        _ => [a[0] * b[0], a[1] * b[0] + a[0] * b[1], a[2] * b[0] + 2.0 * a[1] * b[1] + a[0] * b[2]],
    }
}

/// f(a), from f and its derivatives at a.
fn chained(a: Jet, [value, first, second]: Jet) -> Jet {
    // An infinite derivative does no harm to a constant argument.
    let part = |derivative: f64, change: f64| if change == 0.0 { 0.0 } else { derivative * change };
    [value, part(first, a[1]), part(second, a[1] * a[1]) + part(first, a[2])]
}

impl Function {
    /// f(a).
    fn of(self, a: Jet) -> Jet {
        let x = a[0];
        let (sine, cosine) = x.sin_cos();
        let derivatives = match self {
            Function::Sin => [sine, cosine, -sine],
            Function::Cos => [cosine, -sine, -cosine],
            Function::Tan => {
                let slope = 1.0 / (cosine * cosine);
                [x.tan(), slope, 2.0 * x.tan() * slope]
            }
            Function::Asin | Function::Acos => {
                let square = 1.0 - x * x;
                let (slope, sign) = (1.0 / square.sqrt(), if self == Function::Asin { 1.0 } else { -1.0 });
                [if self == Function::Asin { x.asin() } else { x.acos() }, sign * slope, sign * x * slope / square]
            }
            Function::Atan => {
                let slope = 1.0 / (1.0 + x * x);
                [x.atan(), slope, -2.0 * x * slope * slope]
            }
            Function::Sinh => [x.sinh(), x.cosh(), x.sinh()],
            Function::Cosh => [x.cosh(), x.sinh(), x.cosh()],
            Function::Tanh => {
                let (value, slope) = (x.tanh(), x.cosh().powi(-2));
                [value, slope, -2.0 * value * slope]
            }
            Function::Exp => [x.exp(); 3],
            Function::Ln => [x.ln(), 1.0 / x, -1.0 / (x * x)],
            Function::Sqrt => {
                let root = x.sqrt();
                [root, 0.5 / root, -0.25 / (root * x)]
            }
        };
        chained(a, derivatives)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn formula(text: &str) -> Formula {
        Formula::new(text, &[("a".to_string(), 0.3), ("w".to_string(), 5.0)]).expect(text)
    }

    #[test]
    fn operators_bind_as_in_mathematics() {
        let values = [
            ("-t^2", -4.0),
            ("2^3^2", 512.0),
            ("2^-1", 0.5),
            ("1 - 2 - 3", -4.0),
            ("12/2/3", 2.0),
            ("-2*-3", 6.0),
            ("2 + 3*t^2", 14.0),
            ("(1+t)*2e-1", 0.6),
            ("--t", 2.0),
            ("a*w", 1.5),
            ("2e", 2.0),
        ];
        for (text, wanted) in values.iter().filter(|(text, _)| *text != "2e") {
            // One rounding or two.
            assert!((formula(text).at(2.0)[0] - wanted).abs() < 1e-15, "{text}");
        }
        assert_eq!(formula("cos(pi)").at(0.0)[0], -1.0);
        assert!(formula("2*pi + e").is_constant() && !formula("t").is_constant());
    }

    #[test]
    fn derivatives_are_those_of_differences() {
        let texts = [
            "a*sin(w*t + 0.3)",
            "t^3 - 2*t",
            "exp(-t)*cos(3*t)",
            "1/(1+t^2)",
            "sqrt(1+t)",
            "ln(2+t)",
            "tan(0.4*t)",
            "asin(0.3*t)",
            "acos(0.3*t)",
            "atan(2*t)",
            "sinh(t)",
            "cosh(t)",
            "tanh(3*t)",
            "t^t",
            "2^t",
            "(1+t)^0.5",
            "t^0",
            "t^1",
        ];
        for text in texts {
            let formula = formula(text);
            for time in [0.4, 0.9] {
                let h = 1e-4;
                let [before, now, after] = [time - h, time, time + h].map(|time| formula.at(time));
                // Differences of second order: h² times the third derivative, which is below 200; and roundings over h.
                assert!((now[1] - (after[0] - before[0]) / (2.0 * h)).abs() < 1e-6, "{text} at {time}: {now:?}");
                assert!((now[2] - (after[1] - before[1]) / (2.0 * h)).abs() < 1e-5, "{text} at {time}: {now:?}");
            }
        }
        assert_eq!(formula("t^2").at(0.0), [0.0, 0.0, 2.0]);
        assert_eq!(formula("t^1").at(0.0), [0.0, 1.0, 0.0]);
    }

    #[test]
    fn a_text_that_is_no_formula_is_refused_with_the_place() {
        let refused = |text: &str| Formula::new(text, &[]).expect_err(text);
        let wanted = [
            ("", 1, "ends where"),
            ("sin(t", 6, "not closed"),
            ("2 t", 3, "follows a complete formula"),
            ("2*x", 3, "\"x\" is unknown"),
            ("sin t", 5, "argument of sin"),
            ("abs(t)", 1, "kinks"),
            ("1 + * 2", 5, "stands where"),
            ("3..2", 3, "follows a complete formula"),
            ("1e999", 1, "no finite number"),
            ("é", 1, "unknown"),
            ("t)", 2, "follows a complete formula"),
        ];
        for (text, place, reason) in wanted {
            let error = refused(text);
            assert_eq!(error.place, place, "{error}");
            assert!(error.to_string().contains(reason), "{error}");
        }
        let deep = "(".repeat(100_000) + "t";
        assert!(refused(&deep).reason.contains("inside each other"));
        let long = "t^".repeat(100_000) + "t";
        assert!(refused(&long).reason.contains("inside each other"));
        let right = "1+(".repeat(31) + "t" + &")".repeat(31);
        assert!(Formula::new(&right, &[]).is_ok());
    }
}
