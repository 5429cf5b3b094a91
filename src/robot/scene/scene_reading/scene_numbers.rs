//! The numbers of scene files and poses of them, each number refused with its reason where it is read.
//!
//! Angles and rates of angles may be written in degrees, as `"30 deg"` and `"30 deg/s"`.

use crate::scene::numbers::{check_friction, unrounded};
use serde::de::{Deserialize, Deserializer, Error, Visitor};
use std::fmt;

/// The possible numbers of stages.
pub(crate) const STAGES: std::ops::RangeInclusive<usize> = 1..=16;

/// A finite number.
#[derive(Clone, Copy, Default, serde::Deserialize)]
#[serde(try_from = "f64")]
pub(crate) struct Finite(pub f64);

/// A finite number that is not negative.
#[derive(Clone, Copy, Default, serde::Deserialize)]
#[serde(try_from = "f64")]
pub(crate) struct NotNegative(pub f64);

/// A friction coefficient: not negative, and at most [`crate::scene::numbers::MOST_FRICTION`].
#[derive(Clone, Copy, serde::Deserialize)]
#[serde(try_from = "f64")]
pub(crate) struct Friction(pub f64);

/// A finite number greater than zero.
#[derive(Clone, Copy, serde::Deserialize)]
#[serde(try_from = "f64")]
pub(crate) struct Positive(pub f64);

/// A place (m), and its roll, pitch and yaw (rad).
#[derive(Default, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct PoseTable {
    pub position: [Finite; 3],
    pub rpy: [Angle; 3],
}

impl PoseTable {
    /// Roll, pitch and yaw as they are meant (rad).
    pub fn angles(&self) -> [f64; 3] {
        self.rpy.map(|angle| unrounded(angle.0))
    }
}

/// Velocity of a frame in the world [m/s, rad/s].
#[derive(Default, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct VelocityTable {
    pub linear: [Finite; 3],
    pub angular: [AngleRate; 3],
}

/// An angle (rad).
#[derive(Clone, Copy, Default)]
pub(crate) struct Angle(pub f64);

/// A rate of an angle (rad/s).
#[derive(Clone, Copy, Default)]
pub(crate) struct AngleRate(pub f64);

/// A number in SI units, and the unit that was written beside it: only the joint that it is for tells which units it may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity {
    /// In SI units.
    pub number: f64,
    /// The unit beside it.
    pub unit: Unit,
}

/// A unit beside a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// None: the number is in SI units.
    Unwritten,
    /// Degrees or radians.
    Angle,
    /// One of them per second.
    AngleRate,
}

impl From<f64> for Quantity {
    /// A number without a unit.
    fn from(number: f64) -> Self {
        Quantity { number, unit: Unit::Unwritten }
    }
}

impl Quantity {
    /// A finite number with the unit `deg`, `rad`, `deg/s` or `rad/s`.
    ///
    /// # Errors
    /// The reason why it is none.
    pub fn parse(text: &str) -> Result<Self, String> {
        let refuse =
            || format!("{text:?} is no number with a unit; give a number or, of angles, \"30 deg\" or \"30 deg/s\"");
        let text = text.trim();
        let start = text.find(|c: char| c.is_ascii_alphabetic() && !matches!(c, 'e' | 'E')).ok_or_else(refuse)?;
        let number: f64 = text[..start].trim().parse().map_err(|_| refuse())?;
        let number = Finite::try_from(number)?.0;
        let (number, unit) = match &text[start..] {
            "deg" => (number.to_radians(), Unit::Angle),
            "rad" => (number, Unit::Angle),
            "deg/s" => (number.to_radians(), Unit::AngleRate),
            "rad/s" => (number, Unit::AngleRate),
            _ => return Err(refuse()),
        };
        Ok(Quantity { number, unit })
    }

    /// The number, if the place has numbers with this unit; `Unwritten` stands for a place without a unit.
    pub(crate) fn of(self, unit: Unit) -> Result<f64, String> {
        if self.unit == unit || self.unit == Unit::Unwritten {
            return Ok(self.number);
        }
        Err(match unit {
            Unit::Angle => "it is an angle, not a rate; give it in rad or as \"30 deg\"".to_string(),
            Unit::AngleRate => "it is a rate; give it in rad/s or as \"30 deg/s\"".to_string(),
            Unit::Unwritten => "it is no angle; give a number in SI units".to_string(),
        })
    }

    /// The number in SI units, for a place where `angle` says whether it is one of an angle, and `rate` whether it is its rate.
    ///
    /// # Errors
    /// The reason why its unit does not belong there.
    pub fn value(self, angle: bool, rate: bool) -> Result<f64, String> {
        self.of(match (angle, rate) {
            (false, _) => Unit::Unwritten,
            (true, false) => Unit::Angle,
            (true, true) => Unit::AngleRate,
        })
    }
}

impl Quantity {
    /// A number that need not be finite, or one with a unit.
    pub fn deserialize_any_number<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NumberOrText;
        impl Visitor<'_> for NumberOrText {
            type Value = Quantity;

            fn expecting(&self, out: &mut fmt::Formatter) -> fmt::Result {
                out.write_str("a number")
            }

            fn visit_f64<E: Error>(self, number: f64) -> Result<Quantity, E> {
                Ok(Quantity { number, unit: Unit::Unwritten })
            }

            fn visit_i64<E: Error>(self, number: i64) -> Result<Quantity, E> {
                self.visit_f64(number as f64)
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<Quantity, E> {
                Quantity::parse(text).map_err(E::custom)
            }
        }
        deserializer.deserialize_any(NumberOrText)
    }
}

impl<'de> Deserialize<'de> for Quantity {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let given = Quantity::deserialize_any_number(deserializer)?;
        Finite::try_from(given.number).map_err(D::Error::custom)?;
        Ok(given)
    }
}

impl<'de> Deserialize<'de> for Angle {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Quantity::deserialize(deserializer)?.of(Unit::Angle).map(Angle).map_err(D::Error::custom)
    }
}

impl<'de> Deserialize<'de> for AngleRate {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Quantity::deserialize(deserializer)?.of(Unit::AngleRate).map(AngleRate).map_err(D::Error::custom)
    }
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
        check_friction(number).map(|()| Friction(number))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn degrees_are_read_as_radians_and_other_units_are_refused() {
        let quantity = |number, unit| Ok(Quantity { number, unit });
        assert_eq!(Quantity::parse("90 deg"), quantity(std::f64::consts::FRAC_PI_2, Unit::Angle));
        assert_eq!(Quantity::parse("-1.8e2deg/s"), quantity(-std::f64::consts::PI, Unit::AngleRate));
        assert_eq!(Quantity::parse(" 0.5 rad "), quantity(0.5, Unit::Angle));
        for text in ["90", "90 degrees", "deg", "x deg", "90 deg/min", "", "1e400 deg"] {
            assert!(Quantity::parse(text).is_err(), "{text}");
        }
        let angle = Quantity { number: 1.0, unit: Unit::Angle };
        assert_eq!(angle.value(true, false), Ok(1.0));
        assert!(angle.value(true, true).unwrap_err().contains("rate"));
        assert!(angle.value(false, false).unwrap_err().contains("no angle"));
    }
}
