//! The unknowns of a step: guessed before it, and kept after it for the guess of the next one.

use crate::stages::coefficients::Coefficients;
/// Inputs of the guess: the displacements in a step, and the motion at its start.
pub struct Unknowns<'s, V> {
    /// At all stages; one entry a degree of freedom.
    pub displacement: &'s mut [V],
    /// Velocity of each degree of freedom at the start.
    pub rates: &'s [f64],
    /// Length of the step (s).
    pub step: f64,
    /// The scheme.
    pub coefficients: &'s Coefficients<V>,
}
