//! What makes steps: one interface of the scheme, of the scheme on another spanning tree, of motions with events, and of the comparator.
//!
//! ```text
//!     Integrator ─▶ StepMaker: what its steps tell of their errors, and a motion beside it
//!                       └────▶ PieceSteps: steps that may end at an event
//! ```
//!
//! An event asks three more things of a step than every run does: to be made again with another length, the mean square of a rate over it (for the heat
//! of the dampers that motors are), and the pace at which the steps of the next mode go on.

use catena_mechanism::description::closure::Coordinate;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::motion::distance::probes;
use catena_mechanism::motion::inputs::Inputs;
use catena_mechanism::motion::integrator::{Integrator, StepError, StepOutcome};
use catena_mechanism::motion::state::State;
use nalgebra::Vector3;

/// What steps so far tell of their errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepFigures {
    /// The error of samples inside the steps, beside the error of their ends (m); `None` if it is not known: given steps.
    pub between: Option<f64>,
    /// The part of it in steps that were too long for a damper (m), where it is looked at.
    pub ringing: f64,
    /// Whether a step that was to be chosen for its accuracy was shortened for the stability of the scheme.
    pub held_by_stability: bool,
}

impl StepFigures {
    /// Of no step.
    pub const NONE: StepFigures = StepFigures { between: Some(0.0), ringing: 0.0, held_by_stability: false };

    /// Sees what others tell.
    pub fn include(&mut self, other: &StepFigures) {
        self.see_between(other.between);
        self.ringing = self.ringing.max(other.ringing);
        self.held_by_stability |= other.held_by_stability;
    }

    /// Sees the error of samples inside other steps (m).
    pub fn see_between(&mut self, other: Option<f64>) {
        self.between = self.between.zip(other).map(|(one, other)| one.max(other));
    }
}

/// How steps go on after an event.
#[derive(Clone, Copy, Debug)]
pub enum StepPace {
    /// On a grid that began at this time (s).
    Grid {
        /// s.
        origin: f64,
    },
    /// Chosen steps.
    Step {
        /// Length (s); zero before the first step.
        length: f64,
        /// The largest kinetic energy that was seen (J).
        kinetic: f64,
    },
}

/// What makes steps.
pub trait StepMaker: Integrator + Send {
    /// What its steps so far tell of their errors.
    fn figures(&self) -> StepFigures;

    /// Carries a companion from the next step on, where that tells the errors of the steps; returns whether it does.
    fn accompany(&mut self, _mechanism: &Mechanism) -> bool {
        false
    }

    /// Carries it no more.
    fn leave_companion(&mut self) {}

    /// Writes the state of the companion after the last step, which has left the motion in `state`; `false` without a companion.
    fn place_companion(&self, _state: &mut State) -> bool {
        false
    }

    /// The probes of the companion after the last step, which has left the motion in `state` ([`probes`]); `None` without a companion.
    fn companion_probes(&self, mechanism: &Mechanism, state: &State) -> Option<Vec<Vector3<f64>>> {
        let mut there = state.clone();
        self.place_companion(&mut there).then(|| probes(mechanism, &there))
    }
}

/// Steps that can end at events.
pub trait PieceSteps: StepMaker + Sync {
    /// The same steps with the same past: they go on to the same bits.
    fn duplicate(&self) -> Box<dyn PieceSteps>;

    /// Makes the last step again from its start with another length (s): moves `state` to the new end. The inputs are the inputs of that step.
    ///
    /// # Errors
    /// [`StepError`] where the equations cannot be solved; the state is then the start of the step.
    fn again(
        &mut self,
        mechanism: &Mechanism,
        inputs: Inputs,
        state: &mut State,
        length: f64,
    ) -> Result<StepOutcome, StepError>;

    /// Positions and velocities at a time inside the last step (s), which closures may be off from by as much as interpolation errs: for a fraction
    /// of the time of [`Integrator::dense`].
    fn interpolate(&mut self, mechanism: &Mechanism, time: f64, position: &mut [f64], velocity: &mut [f64]) {
        self.dense(mechanism, time, position, velocity);
    }

    /// The weighted mean of the squares of a scalar joint coordinate's rate over the last step [(m/s)² or (rad/s)²]; `rates` is room. Zero for a joint
    /// that has no forces.
    fn mean_square_rate(&self, coordinate: Coordinate, rates: &mut Vec<f64>) -> f64;

    /// Takes the forces and the state from which the next step goes on, as far as that can be done before; the step takes them otherwise, and tells an
    /// error.
    fn meet(&mut self, _mechanism: &Mechanism, _inputs: Inputs, _state: &State) {}

    /// The pace of the steps, for one who goes on; `origin` is where a grid began (s).
    fn step_pace(&self, origin: f64) -> StepPace;

    /// Goes on at the pace of another, which made steps of the same motion up to `time` (s).
    fn keep_pace(&mut self, pace: StepPace, time: f64);

    /// Says whether a given instant, such as a tick, bounds the next step; the stop of a slip does not.
    fn expect_instant(&mut self, _given: bool) {}

    /// Whether the last step was a span to a given instant, short beside the steps of the motion.
    fn is_short_span(&self) -> bool {
        false
    }

    /// Whether it was made with the fewest stages, for which steps of first order are no cheaper.
    fn is_cheap_span(&self) -> bool {
        false
    }

    /// Writes the forces (N) on the second ends of the closures at all stages of the last step but its end, stage after stage of each; whether it
    /// solved for them.
    fn closure_forces(&self, _forces: &mut Vec<[f64; 3]>) -> bool {
        false
    }

    /// Whether hard dampers may have left more of a transient at the end of the last step than its tolerance allows.
    fn leaves_transient(&self) -> bool {
        false
    }

    /// A step that is shorter than this (s) and cannot be solved is given up, now and later.
    fn give_up_below(&mut self, _length: f64) {}
}

impl Clone for Box<dyn PieceSteps> {
    fn clone(&self) -> Self {
        self.duplicate()
    }
}
