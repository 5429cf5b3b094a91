//! The numbers in an attribute: the right count, finite, separated by spaces; directions and turns.

use nalgebra::{Rotation3, SVector, Vector3};

/// The numbers of an attribute as separate texts, and whether commas stood between them; or the defect.
pub(crate) fn numbers(value: &str, count: usize, infinite_allowed: bool) -> Result<(Vec<String>, bool), String> {
    if value.contains("${") || value.contains("$(") {
        return Err("is unexpanded xacro; run xacro on its source first".to_string());
    }
    let wanted =
        || if count == 1 { "one number was expected".to_string() } else { format!("{count} numbers were expected") };
    let commas = value.contains(',');
    let words: Vec<&str> = if commas {
        // A comma between numbers is plain; `0,5 1` could be a decimal comma.
        let words: Vec<&str> = value.split(',').map(str::trim).collect();
        if words.len() != count {
            return Err(format!("{}, separated by spaces", wanted()));
        }
        words
    } else {
        value.split_whitespace().collect()
    };
    for word in &words {
        match word.parse::<f64>() {
            Err(_) => return Err(format!("{:?} is not a number", shown(word))),
            Ok(number) if number.is_nan() || (number.is_infinite() && !infinite_allowed) => {
                return Err(format!("{:?} is not a finite number", shown(word)));
            }
            Ok(_) => {}
        }
    }
    if words.len() != count {
        return Err(format!("{}, not {}", wanted(), words.len()));
    }
    Ok((words.iter().map(|word| word.to_string()).collect(), commas))
}

/// The direction of a vector and, if its length is not one, the warning about that; `None` if it is zero.
pub(crate) fn unit(given: &Vector3<f64>) -> Option<(Vector3<f64>, Option<String>)> {
    let unit = normalised(given)?;
    let length = given.norm();
    // Files write unit vectors with some five to seven digits.
    let warning = (length - 1.0).abs() > 1e-4;
    Some((unit, warning.then(|| format!("the axis has length {length}; it was normalised"))))
}

/// The vector of length one with this direction; `None` if it is zero.
pub(crate) fn normalised<const N: usize>(given: &SVector<f64, N>) -> Option<SVector<f64, N>> {
    // The largest entry is divided out first, so that neither 1e-200 nor 1e200 is taken for zero or infinity.
    let largest = given.amax();
    (largest != 0.0).then(|| if given.norm() == 1.0 { *given } else { (given / largest).normalize() })
}

/// Largest friction coefficient. The law of a cone that is nearly a half space is solved to fewer digits: with 1e5 one instant in some is not exact.
pub(crate) const MOST_FRICTION: f64 = 1e4;

/// Refuses what is no friction coefficient.
pub(crate) fn check_friction(number: f64) -> Result<(), String> {
    match number {
        number if !number.is_finite() => Err(format!("{number} is not finite")),
        number if number < 0.0 => Err(format!("{number} must not be negative")),
        number if number <= MOST_FRICTION => Ok(()),
        number => Err(format!("{number:e} must be at most {MOST_FRICTION:e}; with 10 next to nothing slips")),
    }
}

/// Angles of the file that are rounded from multiples of this are these multiples: π/12, a twelfth of a half turn.
const SHARES: f64 = 12.0;
/// They have this many digits or more: 1.57 may be meant.
const DIGITS: i32 = 7;
/// Multiples are known to this part of them.
const KNOWN: f64 = 1e-15;

/// The roll, pitch or yaw (rad) that a file means: `1.5707963` is π/2. A number of seven digits or more that is a multiple of π/12, rounded or cut off at its
/// last digit, is that multiple.
///
/// Hinges that are parallel but for 2.7e-8 rad are not in one plane, and close no loop. By chance one angle in some 100 000 is this near to a multiple.
pub(crate) fn unrounded(angle: f64) -> f64 {
    use std::f64::consts::PI;
    let multiple = PI * ((angle / PI * SHARES).round() / SHARES);
    let off = (angle - multiple).abs();
    if off <= KNOWN * multiple.abs() || off >= 1e-5 * multiple.abs() {
        return angle;
    }
    // The shortest number that is read as this one: `1.5707963e0`.
    let text = format!("{:e}", angle.abs());
    let Some((digits, exponent)) = text.split_once('e') else { return angle };
    let count = digits.chars().filter(char::is_ascii_digit).count() as i32;
    let exponent: i32 = exponent.parse().unwrap_or_default();
    let last = 10_f64.powi(exponent + 1 - count);
    let is_cut = angle.abs() < multiple.abs();
    if count >= DIGITS && off < if is_cut { last } else { 0.5 * last } { multiple } else { angle }
}

/// The rotation with this roll, pitch and yaw (rad).
pub(crate) fn turn([roll, pitch, yaw]: [f64; 3]) -> Rotation3<f64> {
    Rotation3::from_euler_angles(roll, pitch, yaw)
}

/// The rotation that takes z to a unit vector, by the shortest way.
pub(crate) fn turn_of_z(unit: &Vector3<f64>) -> Rotation3<f64> {
    let half_turn = || Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    Rotation3::rotation_between(&Vector3::z(), unit).unwrap_or_else(half_turn)
}

/// A piece of the file as messages show it: on one line and not endless.
pub(crate) fn shown(text: &str) -> String {
    const LONGEST: usize = 60;
    let mut shown: String = text.chars().take(LONGEST).map(|c| if c.is_control() { ' ' } else { c }).collect();
    if text.chars().nth(LONGEST).is_some() {
        shown.push('…');
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_3, FRAC_PI_4, PI};

    #[test]
    fn angles_of_seven_digits_that_are_rounded_multiples_are_these_and_others_stay_as_they_are() {
        for (written, meant) in [
            ("1.5707963", Some(FRAC_PI_2)),
            ("-1.570796", Some(-FRAC_PI_2)),
            ("1.5707964", None),
            ("1.570796326795", Some(FRAC_PI_2)),
            ("3.1415926", Some(PI)),
            ("3.1415927", Some(PI)),
            ("-3.14159265", Some(-PI)),
            ("0.78539816", Some(FRAC_PI_4)),
            ("1.0471976", Some(FRAC_PI_3)),
            ("6.2831853", Some(2.0 * PI)),
            // Fewer digits stay as they are written, and so do other numbers.
            ("1.5708", None),
            ("3.14159", None),
            ("1.57", None),
            ("0.0", None),
            ("1.5707", None),
            ("1.5707903", None),
            ("0.3", None),
        ] {
            let written: f64 = written.parse().expect("a number");
            let meant = meant.unwrap_or(written);
            // Thirds of a half turn are known to their last digit but one.
            assert!((unrounded(written) - meant).abs() <= 2.3e-16, "{written}");
        }
        // No multiple loses its last digit.
        for exact in [FRAC_PI_2, FRAC_PI_4, FRAC_PI_3, PI, 2.0 * PI / 3.0, -7.0 * PI / 12.0] {
            assert_eq!(unrounded(exact), exact);
        }
    }
}
