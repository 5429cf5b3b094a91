//! The mechanism that moves in a mode, and its steps.
//!
//! A piece is kept with its workspace while it may be needed again. It depends on the held joints and their places, and on the motors that follow
//! their laws.

use crate::events::modes::drives::Drives;
use crate::events::modes::instants::Instants;
use crate::events::modes::narrowed::{Narrowed, Room};
use crate::events::modes::piece_recipe::PieceRecipe;
use crate::instant::holding::held::Closures;
use crate::instant::holding::held::Held;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::inputs::{ChangingEfforts, Feedback, Inputs};
use crate::mechanism::motion::integrator::{StepError, StepOutcome};
use crate::mechanism::motion::state::State;
use crate::stepping::step_maker::PieceSteps;
use std::sync::Arc;

/// The reduced mechanism of a mode, and its steps.
#[derive(Clone)]
pub(crate) struct Piece {
    pub(crate) key: Key,
    pub(crate) moving: Arc<Held>,
    pub(crate) drives: Drives,
    /// `None` if every joint is held.
    pub(crate) steps: Option<Box<dyn PieceSteps>>,
    /// For efforts that follow the state, once there are any.
    pub(crate) law: Option<Box<Room>>,
    pub(crate) small: State,
    pub(crate) small_start: State,
    pub(crate) small_efforts: Vec<f64>,
    pub(crate) small_position: Vec<f64>,
    pub(crate) small_velocity: Vec<f64>,
    /// States inside the last step that were asked for.
    pub(crate) instants: Instants,
    pub(crate) used: usize,
}

/// The key of the workspace of a mode: the held joints and their places, the motors that follow their laws, the closed contacts.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Key {
    pub(crate) held: Vec<bool>,
    pub(crate) places: Vec<f64>,
    pub(crate) motors: Vec<bool>,
    /// Closed contacts.
    pub(crate) closures: Closures,
}

impl Piece {
    /// A step of the reduced mechanism begins in a state of the whole, under these efforts on it and the efforts that follow its state.
    pub(crate) fn begin(&mut self, whole: &Mechanism, inputs: Inputs, efforts: &[f64], start: &State) {
        self.instants.forget();
        self.drives.begin(start.time);
        self.small.time = start.time;
        if let Some(law) = inputs.feedback {
            let room = self.law.get_or_insert_with(|| Box::new(Room::new(law, whole, &self.moving, &self.drives)));
            room.begin(start);
        }
        self.moving.gather_velocities(whole, efforts, &mut self.small_efforts);
        self.small_start.copy_from(&self.small);
    }

    /// Lets the steps take the state in which it begins, with the ranks of the closures there. A step that finds an error tells it.
    pub(crate) fn meet(&mut self) {
        let Piece { moving, drives, steps: Some(steps), small, small_efforts, .. } = self else { return };
        let changing = drives.change().then_some(&*drives as &dyn ChangingEfforts);
        let inputs = Inputs { efforts: small_efforts, changing, feedback: None };
        steps.meet(&moving.mechanism, inputs, small);
    }

    /// Makes it, towards `until`.
    pub(crate) fn step(&mut self, whole: &Mechanism, inputs: Inputs, until: f64) -> Result<StepOutcome, StepError> {
        self.attempt(whole, inputs, until, |steps, moving, inputs, small| steps.step(moving, inputs, small, until))
    }

    /// Makes it again with another length (s).
    pub(crate) fn again(
        &mut self,
        whole: &Mechanism,
        inputs: Inputs,
        since: f64,
        length: f64,
    ) -> Result<StepOutcome, StepError> {
        let attempt = |steps: &mut dyn PieceSteps, moving: &Mechanism, inputs: Inputs, small: &mut State| {
            steps.again(moving, inputs, small, length)
        };
        self.attempt(whole, inputs, since + length, attempt)
    }

    /// Attempts it under the efforts on the reduced mechanism; if every joint is held, only the time goes on to `end`.
    fn attempt(
        &mut self,
        whole: &Mechanism,
        inputs: Inputs,
        end: f64,
        attempt: impl FnOnce(&mut dyn PieceSteps, &Mechanism, Inputs, &mut State) -> Result<StepOutcome, StepError>,
    ) -> Result<StepOutcome, StepError> {
        self.instants.forget();
        let Piece { moving, drives, steps, small, small_start, small_efforts, law, .. } = self;
        let Some(steps) = steps else {
            small.time = end;
            return Ok(StepOutcome { step: end - small_start.time, ..StepOutcome::default() });
        };
        let changing = drives.change().then_some(&*drives as &dyn ChangingEfforts);
        let narrowed = Narrowed::of(inputs.feedback, whole, moving, drives, law.as_deref());
        let feedback = narrowed.as_ref().map(|narrowed| narrowed as &dyn Feedback);
        attempt(steps.as_mut(), &moving.mechanism, Inputs { efforts: small_efforts, changing, feedback }, small)
    }

    /// Throws the step away.
    pub(crate) fn go_back(&mut self, since: f64, recipe: &PieceRecipe) {
        self.instants.forget();
        let Piece { small, small_start, steps, .. } = self;
        small.copy_from(small_start);
        if let (Some(steps), Some(_)) = (steps, recipe.tolerance()) {
            steps.keep_pace(steps.step_pace(since), since);
        }
    }

    /// Puts the moving bodies where they were at a time of the last step (s); `roughly` means as interpolated, with errors in closures.
    pub(crate) fn place(&mut self, whole: &Mechanism, time: f64, roughly: bool, state: &mut State) {
        let Piece { moving, steps, small, small_start, small_position, small_velocity, instants, .. } = self;
        state.time = time;
        let Some(steps) = steps else { return };
        for (at, of) in [(small_start.time, &*small_start), (small.time, &*small)] {
            if time == at {
                moving.spread(whole, of, state);
                return;
            }
        }
        if roughly {
            steps.interpolate(&moving.mechanism, time, small_position, small_velocity);
        } else if !instants.recall(time, small_position, small_velocity) {
            steps.dense(&moving.mechanism, time, small_position, small_velocity);
            instants.keep(time, small_position, small_velocity);
        }
        moving.spread_positions(whole, small_position, &mut state.position);
        state.compensation.fill(0.0);
        moving.spread_velocities(whole, small_velocity, &mut state.velocity);
    }
}
