//! Steps of a motion that is interrupted at given instants: ticks of a controller, kinks of a table of targets.
//!
//! Instants bound the steps, and the truncation of a scheme with many stages is far below the rounding in such a short span. Three stages (order 4)
//! are enough there, for a fraction of the work where contacts or loops couple the stages. A span is made in one step:
//!
//! ```text
//!     span τ = until − t < h      h: the step that many stages would make (s)
//!     accepted with three stages, if  E ≤ min(1.7 c √ε, (T/2)^{2/3})  and the energy changes by no more than its share of T
//! ```
//!
//! E is the top Legendre coefficient of the displacements in the step (rad, m), ε the stop of the iteration, T the tolerance (m), `c = 0.34`
//! ([`crate::length::stage_choice`]). The local error is less than E²/100, so that ten thousand spans leave 3 % of T. A refused span is made with
//! many stages. After each refusal in a row twice as many of the next spans are made with many stages. The order between events is the order of many
//! stages, because spans are made with few stages only where both are below the tolerance.
//!
//! Where a program asks for all steps and closures couple the stages, the first span of a motion is tried as well. No h is known then, and E must leave
//! room for a span that is four times as long: `64 E` is bounded.

use crate::integrator::{Lobatto, MethodError};
use crate::length::control::Beginning;
use crate::length::stage_choice::StageChoice;
use crate::recipe::{Recipe, Steps};
use crate::step_maker::{PieceSteps, StepFigures, StepMaker, StepPace};
use catena_mechanism::description::body_state::BodyState;
use catena_mechanism::description::closure::Coordinate;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::motion::inputs::Inputs;
use catena_mechanism::motion::integrator::{Cost, Integrator, MethodDescription, StepError, StepOutcome};
use catena_mechanism::motion::state::State;

/// Spans in a row that many stages have made in one step each, before three stages are tried: the last step of a run is no such span.
const IN_A_ROW: usize = 2;
/// Spans that are made with many stages after a refusal.
const WAIT: usize = 8;
/// A span is short beside the steps of a motion of which many stages have made none, if three stages could make one that is longer by this factor: E
/// is 64 times smaller.
const ROOM: f64 = 4.0;
/// That number doubles with each refusal in a row, this often at most.
const DOUBLINGS: u32 = 3;

/// The scheme with many stages, and with three stages in spans that are short beside its steps.
#[derive(Clone)]
pub struct SpanSteps {
    many: Lobatto,
    few: Option<Box<Lobatto>>,
    recipe: Recipe,
    /// Whether three stages made the last step.
    by_few: bool,
    /// Whether the first span of a motion is tried with three stages: closures couple the stages, and a program asks for all steps. Many stages of trees
    /// side by side are as cheap as a span that is refused.
    at_once: bool,
    /// Whether a given instant bounds the next step.
    given: bool,
    /// Spans to given instants in a row that many stages have made in one step.
    in_a_row: usize,
    /// Spans that many stages make before three are tried again, and refusals in a row.
    waits: usize,
    refusals: u32,
    /// The cost of refused spans that no outcome has counted yet.
    lost: Cost,
}

impl SpanSteps {
    /// For a mechanism.
    ///
    /// # Errors
    /// [`MethodError`] for stages and steps that cannot be.
    pub fn new(mechanism: &Mechanism, recipe: &Recipe) -> Result<Self, MethodError> {
        let many = recipe.lobatto(mechanism)?;
        let recipe = recipe.clone();
        let at_once = recipe.asked_for && mechanism.has_closures();
        Ok(SpanSteps {
            many,
            few: None,
            recipe,
            by_few: false,
            at_once,
            given: false,
            in_a_row: 0,
            waits: 0,
            refusals: 0,
            lost: Cost::default(),
        })
    }

    /// The scheme that made the last step.
    fn last(&self) -> &Lobatto {
        self.few.as_deref().filter(|_| self.by_few).unwrap_or(&self.many)
    }

    fn last_mut(&mut self) -> &mut Lobatto {
        match &mut self.few {
            Some(few) if self.by_few => few,
            _ => &mut self.many,
        }
    }

    /// Whether the span from a time to `until` (s) is to be tried with three stages. One that a program asks for before many stages have made a step
    /// is tried, too.
    fn is_short(&self, time: f64, until: f64) -> bool {
        let begun = matches!(self.many.step_pace(0.0), StepPace::Step { length, .. } if length > 0.0);
        self.given
            && (self.in_a_row >= IN_A_ROW || self.at_once)
            && self.waits == 0
            && (self.is_within_a_step(until - time) || self.at_once && !begun)
            && self.many.companion().is_none()
    }

    /// Whether a span (s) is known to be shorter than the next step of many stages.
    fn is_within_a_step(&self, span: f64) -> bool {
        matches!(self.many.step_pace(0.0), StepPace::Step { length, .. } if span < length)
    }

    /// The scheme with three stages; `None` for given steps.
    fn few(&mut self, mechanism: &Mechanism) -> Option<&mut Lobatto> {
        if self.few.is_none() {
            let Steps::Chosen { tolerance, stop, .. } = self.recipe.steps else { return None };
            let steps = Steps::Chosen { tolerance, stop, stages: StageChoice::Fewest };
            self.few = Recipe { steps, ..self.recipe.clone() }.lobatto(mechanism).ok().map(Box::new);
        }
        self.few.as_deref_mut()
    }

    /// The scheme with three stages, if the first span of a motion is tried with it.
    fn few_to_begin(&mut self, mechanism: &Mechanism) -> Option<&mut Lobatto> {
        if self.at_once && self.waits == 0 { self.few(mechanism) } else { None }
    }

    /// Tries a span with three stages.
    fn try_few(&mut self, mechanism: &Mechanism, inputs: Inputs, state: &mut State, until: f64) -> Option<StepOutcome> {
        let first = if self.is_within_a_step(until - state.time) { 1.0 } else { ROOM };
        let begins = Beginning { ahead: self.at_once, room: first };
        match self.few(mechanism)?.span(mechanism, inputs, state, until, begins) {
            Ok(made) => {
                self.refusals = 0;
                Some(made)
            }
            Err(cost) => {
                self.lost.add(&cost);
                self.waits = WAIT << self.refusals.min(DOUBLINGS);
                self.refusals += 1;
                None
            }
        }
    }
}

impl StepMaker for SpanSteps {
    fn figures(&self) -> StepFigures {
        let few = self.few.as_ref().map_or(StepFigures::NONE, |few| few.figures());
        let mut all = self.many.figures();
        all.see_between(few.between);
        all.ringing = all.ringing.max(few.ringing);
        all
    }

    /// All steps have many stages then.
    fn accompany(&mut self, mechanism: &Mechanism) -> bool {
        self.many.accompany(mechanism)
    }

    fn leave_companion(&mut self) {
        self.many.leave_companion();
    }

    fn place_companion(&self, state: &mut State) -> bool {
        self.many.place_companion(state)
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
        self.last_mut().again(mechanism, inputs, state, length)
    }

    fn interpolate(&mut self, mechanism: &Mechanism, time: f64, position: &mut [f64], velocity: &mut [f64]) {
        self.last_mut().interpolate(mechanism, time, position, velocity);
    }

    fn mean_square_rate(&self, coordinate: Coordinate, rates: &mut Vec<f64>) -> f64 {
        self.last().mean_square_rate(coordinate.freedom, rates)
    }

    fn meet(&mut self, mechanism: &Mechanism, inputs: Inputs, state: &State) {
        // An error is told by the step, which meets the state again.
        let _ = match self.few_to_begin(mechanism) {
            Some(few) => few.meet_before(mechanism, inputs, state).map(|()| few.look_ahead(mechanism, state)),
            None => self.many.meet_before(mechanism, inputs, state),
        };
    }

    fn step_pace(&self, origin: f64) -> StepPace {
        self.many.step_pace(origin)
    }

    fn keep_pace(&mut self, pace: StepPace, time: f64) {
        self.many.keep_pace(pace, time);
    }

    fn expect_instant(&mut self, given: bool) {
        self.given = given || self.at_once;
    }

    fn is_short_span(&self) -> bool {
        self.by_few
    }

    fn closure_forces(&self, forces: &mut Vec<[f64; 3]>) -> bool {
        self.last().closure_forces(forces)
    }

    fn give_up_below(&mut self, length: f64) {
        self.many.give_up_below(length);
    }
}

impl Integrator for SpanSteps {
    fn step(
        &mut self,
        mechanism: &Mechanism,
        inputs: Inputs,
        state: &mut State,
        until: f64,
    ) -> Result<StepOutcome, StepError> {
        if self.is_short(state.time, until)
            && let Some(outcome) = self.try_few(mechanism, inputs, state, until)
        {
            self.by_few = true;
            return Ok(outcome);
        }
        if self.by_few {
            // Many stages have not seen the spans since their last step, and go on with its length.
            self.many.keep_pace(self.many.step_pace(state.time), state.time);
            self.by_few = false;
        }
        let mut outcome = self.many.step(mechanism, inputs, state, until)?;
        outcome.cost.add(&std::mem::take(&mut self.lost));
        self.waits = self.waits.saturating_sub(1);
        self.in_a_row = if self.given && state.time == until { self.in_a_row + 1 } else { 0 };
        Ok(outcome)
    }

    fn take_abandoned(&mut self) -> Cost {
        let mut cost = self.many.take_abandoned();
        if let Some(few) = &mut self.few {
            cost.add(&few.take_abandoned());
        }
        cost
    }

    fn dense(&mut self, mechanism: &Mechanism, time: f64, position: &mut [f64], velocity: &mut [f64]) {
        self.last_mut().dense(mechanism, time, position, velocity);
    }

    fn bodies(&self) -> Option<&[BodyState]> {
        self.last().bodies()
    }

    fn description(&self) -> MethodDescription {
        let mut description = self.many.description();
        if let Some(few) = &self.few {
            let of_few = few.description();
            description.include_stability(&of_few);
            let (many_steps, few_steps) = (self.many.step_count(), few.step_count());
            let total = description.step * many_steps as f64 + of_few.step * few_steps as f64;
            if description.adaptive {
                description.step = total / (many_steps + few_steps).max(1) as f64;
            }
            description.few_stage_steps = few_steps;
        }
        description
    }
}
