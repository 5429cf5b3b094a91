//! The workspace of the rotors that are geared to joints, at the stages of a step. The equations are in [`crate::equations::rotors`].

use crate::numbers::lanes::{Lanes, MAX_LANES};
use crate::tableau::butcher::Tableau;
use catena_mechanism::description::mechanism::Mechanism;

/// The rotors of a mechanism at the stages of a step.
#[derive(Clone)]
pub struct Rotors<V> {
    /// Freedom and A [kg m² or kg].
    pub(crate) rotors: Vec<(usize, f64)>,
    /// A of every degree of freedom, mostly zero.
    pub(crate) inertia: Vec<f64>,
    /// Minus the residual of every degree of freedom in the rows, or its momentum at the end of the step.
    pub(crate) carried: Vec<V>,
    /// `w_i` in all lanes, and their rounding errors.
    pub(crate) weights: [V; MAX_LANES],
    pub(crate) rest: [V; MAX_LANES],
}

impl<V: Lanes> Rotors<V> {
    /// Room for the rotors of a mechanism; `None` if it has none.
    pub(crate) fn new(mechanism: &Mechanism, tableau: &Tableau) -> Option<Self> {
        let rotors: Vec<(usize, f64)> = mechanism.rotors().collect();
        if rotors.is_empty() {
            return None;
        }
        let mut inertia = vec![0.0; mechanism.velocity_count];
        rotors.iter().for_each(|&(freedom, armature)| inertia[freedom] = armature);
        let carried = vec![V::zero(); mechanism.velocity_count];
        let lanes = |numbers: &[f64]| {
            let mut lanes = [V::zero(); MAX_LANES];
            lanes.iter_mut().zip(numbers).for_each(|(lane, &number)| *lane = V::splat(number));
            lanes
        };
        let (weights, rest) = (lanes(&tableau.momentum_weights), lanes(&tableau.remainders.momentum_weights));
        Some(Rotors { rotors, inertia, carried, weights, rest })
    }
}
