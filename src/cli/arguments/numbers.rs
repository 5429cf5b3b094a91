//! Numbers on the command line: positive ones and `NAME=NUMBERS`.

use anyhow::anyhow;
use catena::model::Model;
use catena::scene::{Quantity, Unit};
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

/// `NAME=NUMBER[,NUMBER…]`, where angles may have the unit `deg`; the name may itself have an equals sign.
#[derive(Clone, Debug, PartialEq)]
pub struct Assignment {
    /// Name of a joint.
    pub name: String,
    /// Its numbers.
    pub values: Vec<Quantity>,
}

/// Whether numbers are positions or velocities.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coordinates {
    /// Positions (rad, m).
    Positions,
    /// Velocities (rad/s, m/s).
    Velocities,
}

impl FromStr for Assignment {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.rsplit_once('=') {
            Some((name, values)) if !name.is_empty() => {
                let values = values.split(',').map(quantity).collect::<Result<_, _>>()?;
                Ok(Assignment { name: name.to_string(), values })
            }
            _ => Err("must be JOINT=VALUE".to_string()),
        }
    }
}

/// A finite number, or one with the unit of an angle.
fn quantity(word: &str) -> Result<Quantity, String> {
    match word.trim().parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(Quantity { number, unit: Unit::Unwritten }),
        Err(_) if word.contains(|c: char| c.is_ascii_digit()) => Quantity::parse(word),
        _ => Err(format!("{word:?} is not a finite number")),
    }
}

/// Names and numbers in SI units, as models take them.
///
/// # Errors
/// An angle for what is none.
pub fn pairs<'a>(
    given: impl IntoIterator<Item = &'a Assignment>,
    model: &Model,
    are: Coordinates,
) -> anyhow::Result<Vec<(String, Vec<f64>)>> {
    let rates = are == Coordinates::Velocities;
    let pair = |one: &Assignment| {
        // A joint that does not exist is refused by the model.
        let kind = model.joint(&one.name).map(|joint| model.joints[joint].kind);
        let angle = |number: usize| kind.is_none_or(|kind| kind.is_angle(number));
        let values = one.values.iter().enumerate().map(|(number, given)| given.value(angle(number), rates));
        let values: Result<Vec<f64>, String> = values.collect();
        let option = if rates { "velocity" } else { "position" };
        Ok((one.name.clone(), values.map_err(|reason| anyhow!("--{option} {}: {reason}", one.name))?))
    };
    given.into_iter().map(pair).collect()
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
    use super::{Assignment, Coordinates, pairs, positive};
    use catena::session::Model;

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
        let parsed: Assignment = "a=b=1,-2".parse().unwrap();
        assert_eq!((parsed.name.as_str(), parsed.values[0].number, parsed.values[1].number), ("a=b", 1.0, -2.0));
    }

    #[test]
    fn angles_may_be_in_degrees_and_lengths_may_not() {
        let model = Model::load("robots/gantry.urdf").unwrap();
        let read = |text: &str, are| {
            let given: Assignment = text.parse().map_err(|error: String| error)?;
            pairs([&given], model.description(), are).map_err(|error| error.to_string())
        };
        let (positions, velocities) = (Coordinates::Positions, Coordinates::Velocities);
        assert_eq!(read("wrist=90 deg", positions), Ok(vec![("wrist".into(), vec![std::f64::consts::FRAC_PI_2])]));
        assert_eq!(read("wrist=-180 deg/s", velocities), Ok(vec![("wrist".into(), vec![-std::f64::consts::PI])]));
        assert_eq!(read("rail_x=0.5", positions), Ok(vec![("rail_x".into(), vec![0.5])]));
        assert!(read("wrist=90 deg", velocities).unwrap_err().contains("rate"));
        assert!(read("rail_x=30 deg", positions).unwrap_err().contains("--position rail_x: it is no angle"));
        assert!(read("wrist=30 degrees", positions).is_err());
    }
}
