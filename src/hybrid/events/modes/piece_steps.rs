//! The integrator of a piece: the scheme, or DOP853 in joint coordinates for comparison.
//!
//! An event asks three more things of a step than every integrator has: to be made again with another length, the mean square of a rate over it (for
//! the heat of the dampers that motors are), and the pace at which the next piece goes on.

use crate::mechanism::description::closure::Coordinate;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::description::rules::Rule;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::integrator::{Integrator, MethodDescription, StepError, StepOutcome};
use crate::mechanism::motion::state::State;
use crate::reduced::Dop853;
use crate::stepping::integrator::{MethodError, StepPace};
use crate::stepping::length::companion::Companion;
use crate::stepping::recipe::{Recipe, Steps};
use crate::stepping::spans::SpanSteps;
use crate::stepping::trees::other_tree::OnOtherTree;

/// How the integrators of pieces are made.
#[derive(Clone, Debug)]
pub(crate) enum PieceRecipe {
    /// The scheme.
    Lobatto(Recipe),
    /// DOP853 in joint coordinates, with this tolerance, of trees alone.
    Dop853(f64),
}

impl PieceRecipe {
    /// The integrator of the reduced mechanism, with efforts from outside in the joints of these bodies.
    ///
    /// # Errors
    /// [`MethodError`] for impossible stages and steps.
    pub fn make(&self, mechanism: &Mechanism, driven: &[usize]) -> Result<Box<dyn PieceSteps>, MethodError> {
        Ok(match self {
            PieceRecipe::Lobatto(recipe) => match OnOtherTree::new(mechanism, driven, recipe)? {
                Some(other) => Box::new(other),
                None => Box::new(SpanSteps::new(mechanism, recipe)?),
            },
            PieceRecipe::Dop853(tolerance) => Box::new(Dop853::new(mechanism, *tolerance)),
        })
    }

    /// The method description used while every joint is held.
    ///
    /// # Errors
    /// As of [`PieceRecipe::make`].
    pub fn idle(&self, whole: &Mechanism) -> Result<MethodDescription, MethodError> {
        let nothing = Mechanism {
            bodies: Vec::new(),
            loops: Vec::new(),
            mimics: Vec::new(),
            forces: Default::default(),
            position_count: 0,
            velocity_count: 0,
            ..whole.clone()
        };
        Ok(self.make(&nothing, &[])?.description())
    }

    /// Whether a rule is switched off.
    pub fn keeps(&self, rule: Rule) -> bool {
        matches!(self, PieceRecipe::Lobatto(recipe) if recipe.kept.contains(&rule))
    }

    /// The tolerance (m) and the number of stages of steps of the scheme that are chosen from it.
    pub fn chosen(&self) -> Option<(f64, usize)> {
        match self {
            PieceRecipe::Lobatto(Recipe { steps: Steps::Chosen { tolerance, stages, .. }, .. }) => {
                Some((*tolerance, stages.count()))
            }
            PieceRecipe::Lobatto(Recipe { steps: Steps::Fixed { .. }, .. }) | PieceRecipe::Dop853(_) => None,
        }
    }

    /// The number of stages of given steps.
    pub fn given(&self) -> Option<usize> {
        match self {
            PieceRecipe::Lobatto(Recipe { steps: Steps::Fixed { stages, .. }, .. }) => Some(*stages),
            PieceRecipe::Lobatto(Recipe { steps: Steps::Chosen { .. }, .. }) | PieceRecipe::Dop853(_) => None,
        }
    }

    /// The tolerance from which steps are chosen (m); `None` for given steps.
    pub fn tolerance(&self) -> Option<f64> {
        match self {
            PieceRecipe::Lobatto(Recipe { steps: Steps::Fixed { .. }, .. }) => None,
            PieceRecipe::Lobatto(Recipe { steps: Steps::Chosen { tolerance, .. }, .. })
            | PieceRecipe::Dop853(tolerance) => Some(*tolerance),
        }
    }
}

/// Steps that can end at events.
pub(crate) trait PieceSteps: Integrator + Send + Sync {
    /// The same steps with the same past: they go on to the same bits.
    fn duplicate(&self) -> Box<dyn PieceSteps>;

    /// Makes the last step again from its start with another length (s): moves `state` to the new end. The inputs are the inputs of that step.
    ///
    /// # Errors
    /// [`StepError`] where the equations cannot be solved.
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

    /// The mean square of the rate of a coordinate over the last step [(m/s)² or (rad/s)²]; `rates` is room.
    fn mean_square_rate(&self, coordinate: Coordinate, rates: &mut Vec<f64>) -> f64;

    /// Takes the state from which the next step goes on, as far as that can be done before; the step takes it otherwise.
    fn meet(&mut self, _mechanism: &Mechanism, _inputs: Inputs, _state: &State) {}

    /// The pace of the steps, for one who goes on; `origin` is where a grid began (s).
    fn pace(&self, origin: f64) -> StepPace;

    /// Goes on at the pace of another, which made steps up to `time` (s).
    fn go_on_at(&mut self, pace: StepPace, time: f64);

    /// Says whether a given instant, such as a tick, bounds the next step.
    fn expect_instant(&mut self, _given: bool) {}

    /// Whether the last step was a span to a given instant, short beside the steps of the motion.
    fn is_short_span(&self) -> bool {
        false
    }

    /// Writes the forces on the second ends of the closures in the last step ([`SpanSteps::closure_forces`]); whether it has found them.
    fn closure_forces(&self, _forces: &mut Vec<[f64; 3]>) -> bool {
        false
    }

    /// A step that is shorter than this (s) and cannot be solved is given up, now and later.
    fn give_up_below(&mut self, _length: f64) {}

    /// Whether stability, and not accuracy, has limited a step.
    fn was_held_by_stability(&self) -> bool;

    /// The error of samples inside the steps so far, beside the error of their ends (m); `None` if it is not known.
    fn between(&self) -> Option<f64>;

    /// The largest error of samples inside steps that were too long for a damper (m), where it is looked at.
    fn ringing_inside(&self) -> f64 {
        0.0
    }

    /// Carries a companion from the next step on, where there can be one ([`SpanSteps::accompany`]).
    fn accompany(&mut self, _mechanism: &Mechanism) {}

    /// Carries it no more.
    fn leave_companion(&mut self) {}

    /// The companion.
    fn companion(&self) -> Option<&Companion> {
        None
    }
}

impl Clone for Box<dyn PieceSteps> {
    fn clone(&self) -> Self {
        self.duplicate()
    }
}

impl PieceSteps for SpanSteps {
    fn duplicate(&self) -> Box<dyn PieceSteps> {
        Box::new(self.clone())
    }

    fn again(
        &mut self,
        mechanism: &Mechanism,
        inputs: Inputs,
        state: &mut State,
        length: f64,
    ) -> Result<StepOutcome, StepError> {
        SpanSteps::again(self, mechanism, inputs, state, length)
    }

    fn meet(&mut self, mechanism: &Mechanism, inputs: Inputs, state: &State) {
        // An error is told by the step, which meets the state again.
        let _ = SpanSteps::meet(self, mechanism, inputs, state);
    }

    fn interpolate(&mut self, mechanism: &Mechanism, time: f64, position: &mut [f64], velocity: &mut [f64]) {
        SpanSteps::interpolate(self, mechanism, time, position, velocity);
    }

    fn mean_square_rate(&self, coordinate: Coordinate, rates: &mut Vec<f64>) -> f64 {
        SpanSteps::mean_square_rate(self, coordinate.freedom, rates)
    }

    fn pace(&self, origin: f64) -> StepPace {
        self.step_pace(origin)
    }

    fn go_on_at(&mut self, pace: StepPace, time: f64) {
        self.keep_pace(pace, time);
    }

    fn expect_instant(&mut self, given: bool) {
        SpanSteps::expect_instant(self, given);
    }

    fn is_short_span(&self) -> bool {
        SpanSteps::is_short_span(self)
    }

    fn closure_forces(&self, forces: &mut Vec<[f64; 3]>) -> bool {
        SpanSteps::closure_forces(self, forces)
    }

    fn give_up_below(&mut self, length: f64) {
        SpanSteps::give_up_below(self, length);
    }

    fn was_held_by_stability(&self) -> bool {
        SpanSteps::was_held_by_stability(self)
    }

    fn between(&self) -> Option<f64> {
        SpanSteps::between(self)
    }

    fn ringing_inside(&self) -> f64 {
        SpanSteps::ringing_inside(self)
    }

    fn accompany(&mut self, mechanism: &Mechanism) {
        if !mechanism.has_closures() {
            SpanSteps::accompany(self, mechanism);
        }
    }

    fn leave_companion(&mut self) {
        SpanSteps::leave_companion(self);
    }

    fn companion(&self) -> Option<&Companion> {
        SpanSteps::companion(self)
    }
}

impl PieceSteps for OnOtherTree {
    fn duplicate(&self) -> Box<dyn PieceSteps> {
        Box::new(self.clone())
    }

    fn again(
        &mut self,
        mechanism: &Mechanism,
        inputs: Inputs,
        state: &mut State,
        length: f64,
    ) -> Result<StepOutcome, StepError> {
        OnOtherTree::again(self, mechanism, inputs, state, length)
    }

    fn mean_square_rate(&self, coordinate: Coordinate, rates: &mut Vec<f64>) -> f64 {
        OnOtherTree::mean_square_rate(self, coordinate, rates)
    }

    fn pace(&self, origin: f64) -> StepPace {
        self.step_pace(origin)
    }

    fn go_on_at(&mut self, pace: StepPace, time: f64) {
        self.keep_pace(pace, time);
    }

    fn give_up_below(&mut self, length: f64) {
        OnOtherTree::give_up_below(self, length);
    }

    fn was_held_by_stability(&self) -> bool {
        OnOtherTree::was_held_by_stability(self)
    }

    fn between(&self) -> Option<f64> {
        OnOtherTree::between(self)
    }
}

/// It chooses its first step anew in every piece.
impl PieceSteps for Dop853 {
    fn duplicate(&self) -> Box<dyn PieceSteps> {
        Box::new(self.clone())
    }

    fn again(
        &mut self,
        mechanism: &Mechanism,
        inputs: Inputs,
        state: &mut State,
        length: f64,
    ) -> Result<StepOutcome, StepError> {
        Dop853::again(self, mechanism, inputs, state, length)
    }

    fn mean_square_rate(&self, coordinate: Coordinate, _rates: &mut Vec<f64>) -> f64 {
        Dop853::mean_square_rate(self, coordinate.position)
    }

    fn pace(&self, origin: f64) -> StepPace {
        StepPace::Grid { origin }
    }

    fn go_on_at(&mut self, _pace: StepPace, _time: f64) {}

    fn was_held_by_stability(&self) -> bool {
        false
    }

    fn between(&self) -> Option<f64> {
        None
    }
}
