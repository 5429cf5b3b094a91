//! The unknowns of a step: guessed before it, and kept after it for the guess of the next one.

use crate::stages::coefficients::Coefficients;
/// What is guessed: the displacements in a step, and what is known of them.
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
