//! Numbers on the command line: positive ones and `NAME=NUMBERS`.

use std::str::FromStr;

/// One finite number.
pub fn finite(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        Ok(_) => Err(format!("{text:?} is not finite")),
        Err(_) => Err(format!("{text:?} is not a number")),
    }
}

/// One finite number greater than zero.
pub fn positive(text: &str) -> Result<f64, String> {
    match finite(text)? {
        number if number > 0.0 => Ok(number),
        _ => Err("must be greater than zero".to_string()),
    }
}

/// Samples per second: positive, and at most a million, so that their times in nanoseconds differ.
pub fn rate(text: &str) -> Result<f64, String> {
    match positive(text)? {
        rate if rate <= 1e6 => Ok(rate),
        _ => Err("must be at most 1e6".to_string()),
    }
}

/// `NAME=NUMBER[,NUMBER…]`; the name may itself have an equals sign.
#[derive(Clone, Debug, PartialEq)]
pub struct Assignment {
    /// Name of a joint.
    pub name: String,
    /// Its numbers.
    pub values: Vec<f64>,
}

impl FromStr for Assignment {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.rsplit_once('=') {
            Some((name, values)) if !name.is_empty() => {
                Ok(Assignment { name: name.to_string(), values: finite_numbers(values)? })
            }
            _ => Err("must be JOINT=VALUE".to_string()),
        }
    }
}

/// Names and numbers, as models take them.
pub fn pairs<'a>(given: impl IntoIterator<Item = &'a Assignment>) -> Vec<(String, Vec<f64>)> {
    given.into_iter().map(|one| (one.name.clone(), one.values.clone())).collect()
}

/// Exactly `N` finite numbers, separated by commas.
pub fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let numbers: Vec<f64> = finite_numbers(text)?;
    let count = numbers.len();
    numbers.try_into().map_err(|_| format!("{N} numbers separated by commas are needed, not {count}"))
}

/// Finite numbers, separated by commas.
pub fn finite_numbers(text: &str) -> Result<Vec<f64>, String> {
    text.split(',')
        .map(|word| match word.trim().parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            _ => Err(format!("{word:?} is not a finite number")),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::{Assignment, positive};

    #[test]
    fn numbers_that_are_none_are_refused() {
        for text in ["", "x", "NaN", "inf", "1;2", "0", "-1", "1e999"] {
            assert!(positive(text).is_err(), "{text:?}");
        }
        for text in ["joint", "=1", "joint=", "joint=a"] {
            assert!(text.parse::<Assignment>().is_err(), "{text:?}");
        }
    }

    #[test]
    fn a_joint_may_have_an_equals_sign_in_its_name() {
        assert_eq!("a=b=1,-2".parse(), Ok(Assignment { name: "a=b".to_string(), values: vec![1.0, -2.0] }));
    }
}
