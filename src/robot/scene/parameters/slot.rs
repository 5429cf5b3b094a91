//! A number of a scene that can be read and replaced, whatever it is kept as.

use crate::mechanism::description::target::Target;
use nalgebra::Matrix3;

/// A number that can be read and replaced.
pub(crate) enum Slot<'s> {
    Number(&'s mut f64),
    Optional(&'s mut Option<f64>),
    /// The stored value is half of the number.
    Half(&'s mut f64),
    /// Both sides of the diagonal.
    Symmetric {
        matrix: &'s mut Matrix3<f64>,
        row: usize,
        column: usize,
    },
    Target(&'s mut Target),
    /// A whole number.
    Count(&'s mut usize),
    /// 1 for yes, 0 for no.
    Flag(&'s mut Option<bool>),
}

impl Slot<'_> {
    /// The number; `None` if the slot is empty or holds several.
    pub fn read(&self) -> Option<f64> {
        match self {
            Slot::Number(number) => Some(**number),
            Slot::Optional(number) => **number,
            Slot::Half(half) => Some(2.0 * **half),
            Slot::Symmetric { matrix, row, column } => Some(matrix[(*row, *column)]),
            Slot::Target(target) => target.is_constant().then(|| target.value(0.0)),
            Slot::Count(count) => Some(**count as f64),
            Slot::Flag(flag) => flag.map(f64::from),
        }
    }

    /// Puts another in its place.
    pub fn write(&mut self, wanted: f64) {
        match self {
            Slot::Number(number) => **number = wanted,
            Slot::Optional(number) => **number = Some(wanted),
            Slot::Half(half) => **half = 0.5 * wanted,
            Slot::Symmetric { matrix, row, column } => {
                matrix[(*row, *column)] = wanted;
                matrix[(*column, *row)] = wanted;
            }
            Slot::Target(target) => **target = Target::constant(wanted),
            Slot::Count(count) => **count = wanted as usize,
            Slot::Flag(flag) => **flag = Some(wanted != 0.0),
        }
    }
}
