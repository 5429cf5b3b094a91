//! Numbers that are taken from parts of a URDF that other programs write.

use crate::scene::error::Element;

/// The kind of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TakenNumber {
    /// Coulomb's coefficient of a link.
    Friction,
    /// Armature of a joint [kg m² or kg].
    Armature,
}

/// A number that was taken from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Taken {
    /// Its kind.
    pub number: TakenNumber,
    /// The link or joint that it is of.
    pub of: Element,
    /// Its value in the file.
    pub value: f64,
    /// Its line.
    pub line: usize,
}
