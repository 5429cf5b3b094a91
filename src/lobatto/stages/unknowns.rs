//! What is guessed before a step and learnt from after it.

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
