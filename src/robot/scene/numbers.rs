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
