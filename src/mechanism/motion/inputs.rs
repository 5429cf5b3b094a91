//! External inputs of one step: efforts that a controller sets during the run.

use crate::description::mechanism::Mechanism;
use crate::motion::state::State;
use crate::motion::step_error::StepError;
use nalgebra::DMatrix;

/// Efforts along the degrees of freedom: constant over a step, and some that change with time in a known way.
///
/// They act besides the forces of the mechanism ([`crate::description::forces::Forces`]). Their work is put into the mechanism, `∫ τ q̇ dt` (J).
#[derive(Clone, Copy, Default)]
pub struct Inputs<'i> {
    /// One entry a degree of freedom [N m or N], for ball joints about the axes of the child's joint frame; empty for zero efforts.
    pub efforts: &'i [f64],
    /// Efforts that change in time, besides the constant ones.
    pub changing: Option<&'i dyn ChangingEfforts>,
    /// Efforts that follow the state, besides the constant ones; in place of the efforts that change in time.
    pub feedback: Option<&'i dyn Feedback>,
}

/// Efforts that change smoothly in time, along scalar joint coordinates.
pub trait ChangingEfforts {
    /// The degrees of freedom along which they act, each once; the same for the whole life of an integrator.
    fn freedoms(&self) -> &[usize];
    /// The effort along the freedom of this entry at a time (s) [N m or N].
    fn effort(&self, entry: usize, time: f64) -> f64;
}

/// Efforts that follow the state at every stage of a step, along scalar joint coordinates.
pub trait Feedback {
    /// The degrees of freedom along which they act, each once (m of n); the same for the whole life of an integrator.
    fn freedoms(&self) -> &[usize];
    /// The efforts along these freedoms in a state, which has its time [N m or N] (m).
    fn efforts(&self, state: &State, efforts: &mut [f64]);
    /// The derivatives of the efforts by positions and by rates in a state, f_q and f_v (m × n each), written into matrices of zeros. Errors cost
    /// iterations, and beyond some size convergence, but no accuracy; the same holds for errors of the mobility.
    fn derivatives(&self, state: &State, by_position: &mut DMatrix<f64>, by_rate: &mut DMatrix<f64>);
    /// The accelerations per unit of each effort in a state, Y (n × m).
    fn mobility(&self, state: &State) -> DMatrix<f64>;
}

impl<'i> Inputs<'i> {
    /// Zero efforts.
    pub const NONE: Inputs<'static> = Inputs { efforts: &[], changing: None, feedback: None };

    /// Constant efforts, one entry a degree of freedom.
    pub fn constant(efforts: &'i [f64]) -> Self {
        Inputs { efforts, ..Inputs::NONE }
    }

    /// Writes the constant efforts, one entry a degree of freedom.
    #[inline]
    pub fn write_constant(&self, efforts: &mut [f64]) {
        efforts.fill(0.0);
        efforts[..self.efforts.len()].copy_from_slice(self.efforts);
    }

    /// Adds the efforts that follow the state, in this state, to `efforts`: one entry a degree of freedom [N m or N].
    pub fn add_feedback(&self, state: &State, efforts: &mut [f64]) {
        for (freedom, effort) in self.following(state) {
            efforts[freedom] += effort;
        }
    }

    /// Whether the efforts that follow the state are numbers in this one.
    ///
    /// # Errors
    /// [`StepError::Effort`] names the first that is not.
    pub fn check(&self, mechanism: &Mechanism, state: &State) -> Result<(), StepError> {
        let Some((freedom, effort)) = self.following(state).find(|(_, effort)| !effort.is_finite()) else {
            return Ok(());
        };
        let body = mechanism.body_of_freedom(freedom);
        let joint = body.map_or_else(String::new, |body| mechanism.bodies[body].joint.name.clone());
        Err(StepError::Effort { time: state.time, joint, effort })
    }

    /// The efforts that follow the state, in this state, with their degrees of freedom.
    fn following(&self, state: &State) -> impl Iterator<Item = (usize, f64)> + use<'i> {
        let freedoms = self.feedback.map_or(&[][..], Feedback::freedoms);
        let mut law = vec![0.0; freedoms.len()];
        if let Some(feedback) = self.feedback {
            feedback.efforts(state, &mut law);
        }
        freedoms.iter().copied().zip(law)
    }

    /// Whether all efforts are zero.
    #[inline]
    pub fn is_none(&self) -> bool {
        self.changing.is_none() && self.feedback.is_none() && self.efforts.iter().all(|&effort| effort == 0.0)
    }
}
