//! The text of a formula as operations, each after its operands.
//!
//! ```text
//!     sum = product { (+ | −) product },   product = sign { (* | /) sign },   sign = [+ | −] sign | power,   power = atom [^ sign]
//!     atom = number | t | pi | e | parameter | function(sum) | (sum)                    so that −t^2 = −(t²) and 2^3^2 = 2^(3²)
//! ```
//!
//! Source: recursive descent, A. V. Aho et al., Compilers, Addison-Wesley 2006, section 4.4. No kept crate with a permissive licence reads −t^2 in this
//! way and names the character of a defect.

/// Why a text is no formula.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("formula {text:?}, character {place}: {reason}")]
pub struct FormulaError {
    /// The formula.
    pub text: String,
    /// The character, counted from 1.
    pub place: usize,
    /// The defect.
    pub reason: String,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Operation {
    Number(f64),
    Time,
    Parameter(usize),
    Negative,
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
    Call(Function),
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Function {
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Sinh,
    Cosh,
    Tanh,
    Exp,
    Ln,
    Sqrt,
}

const FUNCTIONS: [(&str, Function); 12] = [
    ("sin", Function::Sin),
    ("cos", Function::Cos),
    ("tan", Function::Tan),
    ("asin", Function::Asin),
    ("acos", Function::Acos),
    ("atan", Function::Atan),
    ("sinh", Function::Sinh),
    ("cosh", Function::Cosh),
    ("tanh", Function::Tanh),
    ("exp", Function::Exp),
    ("ln", Function::Ln),
    ("sqrt", Function::Sqrt),
];

/// Parts inside each other, and operands that wait: as many as an evaluation has room for.
pub(crate) const DEEPEST: usize = 32;

/// A formula that is being read.
pub(crate) struct Reader<'r> {
    text: &'r str,
    rest: &'r str,
    code: Vec<Operation>,
    parameters: &'r [(String, f64)],
    depth: usize,
}

impl<'r> Reader<'r> {
    /// The operations of a formula.
    pub(crate) fn read(text: &'r str, parameters: &'r [(String, f64)]) -> Result<Vec<Operation>, FormulaError> {
        let mut reader = Reader { text, rest: text, code: Vec::new(), parameters, depth: 0 };
        reader.sum()?;
        reader.skip();
        match reader.rest.chars().next() {
            None => Ok(reader.code),
            Some(next) => {
                let reason = format!("{next:?} follows a complete formula; an operator such as * is missing");
                Err(reader.refuse(reason))
            }
        }
    }

    fn refuse(&self, reason: String) -> FormulaError {
        let read = self.text.len() - self.rest.len();
        FormulaError { text: self.text.to_string(), place: self.text[..read].chars().count() + 1, reason }
    }

    fn skip(&mut self) {
        self.rest = self.rest.trim_start();
    }

    /// Whether the next character is this one, which is then read.
    fn takes(&mut self, wanted: char) -> bool {
        self.skip();
        let rest = self.rest.strip_prefix(wanted);
        self.rest = rest.unwrap_or(self.rest);
        rest.is_some()
    }

    fn sum(&mut self) -> Result<(), FormulaError> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(self.refuse(format!("more than {DEEPEST} parts are inside each other")));
        }
        self.product()?;
        loop {
            let operation = match () {
                () if self.takes('+') => Operation::Add,
                () if self.takes('-') => Operation::Subtract,
                () => break,
            };
            self.product()?;
            self.code.push(operation);
        }
        self.depth -= 1;
        Ok(())
    }

    fn product(&mut self) -> Result<(), FormulaError> {
        self.sign()?;
        loop {
            let operation = match () {
                () if self.takes('*') => Operation::Multiply,
                () if self.takes('/') => Operation::Divide,
                () => return Ok(()),
            };
            self.sign()?;
            self.code.push(operation);
        }
    }

    fn sign(&mut self) -> Result<(), FormulaError> {
        let mut negative = false;
        loop {
            match () {
                () if self.takes('-') => negative = !negative,
                () if self.takes('+') => {}
                () => break,
            }
        }
        self.power()?;
        self.code.extend(negative.then_some(Operation::Negative));
        Ok(())
    }

    fn power(&mut self) -> Result<(), FormulaError> {
        self.atom()?;
        if self.takes('^') {
            self.depth += 1;
            if self.depth > DEEPEST {
                return Err(self.refuse(format!("more than {DEEPEST} parts are inside each other")));
            }
            self.sign()?;
            self.depth -= 1;
            self.code.push(Operation::Power);
        }
        Ok(())
    }

    fn atom(&mut self) -> Result<(), FormulaError> {
        self.skip();
        let Some(first) = self.rest.chars().next() else {
            return Err(self.refuse("it ends where a number, t, a function or a parenthesis is due".to_string()));
        };
        if self.takes('(') {
            return self.inside();
        }
        if first.is_ascii_digit() || first == '.' {
            return self.number();
        }
        if !first.is_alphabetic() && first != '_' {
            return Err(self.refuse(format!("{first:?} stands where a number, t, a function or a parenthesis is due")));
        }
        let end = self.rest.find(|next: char| !next.is_alphanumeric() && next != '_').unwrap_or(self.rest.len());
        let (name, rest) = self.rest.split_at(end);
        if let Some((_, function)) = FUNCTIONS.iter().find(|(known, _)| *known == name) {
            self.rest = rest;
            if !self.takes('(') {
                return Err(self.refuse(format!("the argument of {name} is missing: {name}(…)")));
            }
            self.inside()?;
            self.code.push(Operation::Call(*function));
            return Ok(());
        }
        let parameter = self.parameters.iter().position(|(known, _)| known == name);
        let operation = match (parameter, name) {
            (Some(index), _) => Operation::Parameter(index),
            (None, "t") => Operation::Time,
            (None, "pi") => Operation::Number(std::f64::consts::PI),
            (None, "e") => Operation::Number(std::f64::consts::E),
            (None, "abs" | "min" | "max" | "floor" | "ceil" | "round" | "sign" | "mod") => {
                return Err(self.refuse(format!("{name} has kinks or jumps, and formulas are smooth: use a table")));
            }
            _ => {
                let known: Vec<&str> = FUNCTIONS.iter().map(|(known, _)| *known).collect();
                let own = self.parameters.iter().map(|(known, _)| format!(", {known}")).collect::<String>();
                return Err(self.refuse(format!("{name:?} is unknown; there are t, pi, e, {}{own}", known.join(", "))));
            }
        };
        self.rest = rest;
        self.code.push(operation);
        Ok(())
    }

    /// The rest of a parenthesis.
    fn inside(&mut self) -> Result<(), FormulaError> {
        self.sum()?;
        if self.takes(')') { Ok(()) } else { Err(self.refuse("a parenthesis is not closed".to_string())) }
    }

    /// A number such as 0.5 or 2e-3.
    fn number(&mut self) -> Result<(), FormulaError> {
        let bytes = self.rest.as_bytes();
        let digits = |mut at: usize| {
            while bytes.get(at).is_some_and(u8::is_ascii_digit) {
                at += 1;
            }
            at
        };
        let mut end = digits(0);
        if bytes.get(end) == Some(&b'.') {
            end = digits(end + 1);
        }
        if matches!(bytes.get(end), Some(b'e' | b'E')) {
            let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
            let exponent = digits(end + 1 + sign);
            end = if exponent > end + 1 + sign { exponent } else { end };
        }
        match self.rest[..end].parse::<f64>() {
            Ok(number) if number.is_finite() => {
                self.rest = &self.rest[end..];
                self.code.push(Operation::Number(number));
                Ok(())
            }
            _ => Err(self.refuse(format!("{:?} is no finite number", &self.rest[..end]))),
        }
    }
}
