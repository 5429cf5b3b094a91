//! The numbers of scene files and poses of them, each number refused with its reason where it is read.

/// The possible numbers of stages.
pub(crate) const STAGES: std::ops::RangeInclusive<usize> = 2..=16;

/// A finite number.
#[derive(Clone, Copy, Default, serde::Deserialize)]
#[serde(try_from = "f64")]
pub(crate) struct Finite(pub f64);

/// A finite number that is not negative.
#[derive(Clone, Copy, Default, serde::Deserialize)]
#[serde(try_from = "f64")]
pub(crate) struct NotNegative(pub f64);

/// A friction coefficient: not negative, and at most [`MOST_FRICTION`].
#[derive(Clone, Copy, serde::Deserialize)]
#[serde(try_from = "f64")]
pub(crate) struct Friction(pub f64);

/// The law of a cone that is nearly a half space is solved to fewer digits: with 1e5 one instant in some is not exact.
const MOST_FRICTION: f64 = 1e4;

/// A finite number greater than zero.
#[derive(Clone, Copy, serde::Deserialize)]
#[serde(try_from = "f64")]
pub(crate) struct Positive(pub f64);

/// A place (m), and its roll, pitch and yaw (rad).
#[derive(Default, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct PoseTable {
    pub position: [Finite; 3],
    pub rpy: [Finite; 3],
}

impl TryFrom<f64> for Finite {
    type Error = String;
    fn try_from(number: f64) -> Result<Self, String> {
        if number.is_finite() { Ok(Finite(number)) } else { Err(format!("{number} is not finite")) }
    }
}

impl TryFrom<f64> for NotNegative {
    type Error = String;
    fn try_from(number: f64) -> Result<Self, String> {
        match Finite::try_from(number)?.0 {
            number if number >= 0.0 => Ok(NotNegative(number)),
            number => Err(format!("{number} must not be negative")),
        }
    }
}

impl TryFrom<f64> for Friction {
    type Error = String;
    fn try_from(number: f64) -> Result<Self, String> {
        match NotNegative::try_from(number)?.0 {
            number if number <= MOST_FRICTION => Ok(Friction(number)),
            number => Err(format!("{number:e} must be at most {MOST_FRICTION:e}; with 10 next to nothing slips")),
        }
    }
}

impl TryFrom<f64> for Positive {
    type Error = String;
    fn try_from(number: f64) -> Result<Self, String> {
        match Finite::try_from(number)?.0 {
            number if number > 0.0 => Ok(Positive(number)),
            number => Err(format!("{number} must be greater than zero")),
        }
    }
}

/// A finite number that is not negative.
#[derive(Clone, Copy, serde::Deserialize)]
#[serde(try_from = "f64")]
pub(crate) struct Bound(pub f64);

/// A number from 0 to 1.
#[derive(Clone, Copy, serde::Deserialize)]
#[serde(try_from = "f64")]
pub(crate) struct Fraction(pub f64);

impl TryFrom<f64> for Bound {
    type Error = String;
    fn try_from(number: f64) -> Result<Self, String> {
        match number {
            number if number.is_nan() => Err("NaN is not a number; leave it out or write inf for no bound".to_string()),
            number if number < 0.0 => Err(format!("{number} must not be negative; write inf for no bound")),
            number => Ok(Bound(number)),
        }
    }
}

impl TryFrom<f64> for Fraction {
    type Error = String;
    fn try_from(number: f64) -> Result<Self, String> {
        if (0.0..=1.0).contains(&number) { Ok(Fraction(number)) } else { Err(format!("{number} must be from 0 to 1")) }
    }
}
