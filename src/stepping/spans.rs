//! Steps of a motion that is interrupted at given instants: ticks of a controller, kinks of a table of targets.
//!
//! Instants bound the steps, and the truncation of a scheme with many stages is far below the rounding in such a short span. Three stages (order 4)
//! are enough there, or five (order 8), for a fraction of the work where contacts or loops couple the stages. A span is made in one step:
//!
//! ```text
//!     span τ = until − t < h      h: the step that many stages would make (s)
//!     accepted with few stages, if  E ≤ min(1.7 c √ε, (T/2)^{2/3})  and the energy changes by no more than its share of T
//! ```
//!
//! E is the top Legendre coefficient of the displacements in the step (rad, m), ε the stop of the iteration, T the tolerance (m), `c = 0.34`
//! ([`crate::length::stage_choice`]). The local error is less than E²/100, so that ten thousand spans leave 3 % of T. A span that three stages refuse
//! is made with five where closures couple the stages, and one that these refuse with many. After each refusal in a row twice as many of the next spans
//! are made with more stages. The order between events is the order of many stages, because spans are made with few stages only where both are below
//! the tolerance.
//!
//! Where a program asks for all steps and closures couple the stages, the first span of a motion is tried with three stages as well. No h is known
//! then, and E must leave room for a span that is four times as long: `64 E` is bounded.

use crate::integrator::{Lobatto, MethodError};
use crate::length::span::Beginning;
use crate::length::stage_choice::StageChoice;
use crate::recipe::{Recipe, Steps};
use crate::step_maker::{PieceSteps, StepFigures, StepMaker, StepPace};
use catena_mechanism::description::body_state::BodyState;
use catena_mechanism::description::closure::Coordinate;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::motion::inputs::Inputs;
use catena_mechanism::motion::integrator::{Cost, Integrator, MethodDescription, StepError, StepOutcome};
use catena_mechanism::motion::state::State;

/// Spans in a row that have been made in one step each, before h counts as known: the last step of a run is no such span.
const IN_A_ROW: usize = 2;
/// Spans that are made with more stages after a refusal.
const WAIT: usize = 8;
/// A span is short beside the steps of a motion of which many stages have made none, if three stages could make one that is longer by this factor: E
/// is 64 times smaller.
const ROOM: f64 = 4.0;
/// That number doubles with each refusal in a row, this often at most.
const DOUBLINGS: u32 = 3;
/// The stages that spans are tried with.
const TRIED: [StageChoice; 2] = [StageChoice::Fewest, StageChoice::Fewer];

/// The scheme with few stages of one number.
#[derive(Clone, Default)]
struct Tried {
    scheme: Option<Box<Lobatto>>,
    /// Spans that more stages make before it is tried again, and refusals in a row.
    waits: usize,
    refusals: u32,
}

/// The scheme with many stages, and with few stages in spans that are short beside its steps.
#[derive(Clone)]
pub struct SpanSteps {
    many: Lobatto,
    tried: [Tried; TRIED.len()],
    recipe: Recipe,
    /// Which of the schemes with few stages made the last step.
    by_few: Option<usize>,
    /// Whether closures couple the stages. Many stages of trees side by side are as cheap as a span that is refused.
    coupled: bool,
    /// Whether they are, and a program asks for all steps: each of them is such a span.
    at_once: bool,
    /// Whether a given instant bounds the next step.
    given: bool,
    /// Spans to given instants in a row that were made in one step each.
    in_a_row: usize,
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
        let coupled = mechanism.has_closures();
        let at_once = recipe.asked_for && coupled;
        Ok(SpanSteps {
            many,
            tried: Default::default(),
            recipe,
            by_few: None,
            coupled,
            at_once,
            given: false,
            in_a_row: 0,
            lost: Cost::default(),
        })
    }

    /// The scheme that made the last step.
    fn last(&self) -> &Lobatto {
        self.by_few.and_then(|level| self.tried[level].scheme.as_deref()).unwrap_or(&self.many)
    }

    fn last_mut(&mut self) -> &mut Lobatto {
        let few = self.by_few.and_then(|level| self.tried[level].scheme.as_deref_mut());
        few.unwrap_or(&mut self.many)
    }

    /// The schemes with few stages that were made.
    fn made(&self) -> impl Iterator<Item = &Lobatto> {
        self.tried.iter().filter_map(|tried| tried.scheme.as_deref())
    }

    /// Whether the span from a time to `until` (s) is to be tried with few stages. One that a program asks for is tried before many have made a step, too.
    fn is_short(&self, time: f64, until: f64) -> bool {
        self.given
            && (self.in_a_row >= IN_A_ROW || self.at_once)
            && (self.is_within_a_step(until - time) || self.at_once && !self.has_begun())
            && self.many.companion().is_none()
    }

    /// Whether many stages know the length of their next step.
    fn has_begun(&self) -> bool {
        matches!(self.many.step_pace(0.0), StepPace::Step { length, .. } if length > 0.0)
    }

    /// Whether a span (s) is known to be shorter than the next step of many stages.
    fn is_within_a_step(&self, span: f64) -> bool {
        matches!(self.many.step_pace(0.0), StepPace::Step { length, .. } if span < length)
    }

    /// One of the schemes with few stages; `None` for given steps.
    fn few(&mut self, level: usize, mechanism: &Mechanism) -> Option<&mut Lobatto> {
        if self.tried[level].scheme.is_none() {
            let Steps::Chosen { tolerance, stop, .. } = self.recipe.steps else { return None };
            let steps = Steps::Chosen { tolerance, stop, stages: TRIED[level] };
            self.tried[level].scheme = Recipe { steps, ..self.recipe.clone() }.lobatto(mechanism).ok().map(Box::new);
        }
        self.tried[level].scheme.as_deref_mut()
    }

    /// The scheme with three stages, if the first span of a motion is tried with it.
    fn few_to_begin(&mut self, mechanism: &Mechanism) -> Option<&mut Lobatto> {
        if self.at_once && self.tried[0].waits == 0 { self.few(0, mechanism) } else { None }
    }

    /// Tries a span with few stages, the fewest first.
    fn try_few(&mut self, mechanism: &Mechanism, inputs: Inputs, state: &mut State, until: f64) -> Option<StepOutcome> {
        let within = self.is_within_a_step(until - state.time);
        let seen = within && self.in_a_row >= IN_A_ROW;
        for level in 0..TRIED.len() {
            // Five are cheaper than many only where stages are coupled, and stand in for three that were refused in a motion that is seen.
            if self.tried[level].waits > 0 || level > 0 && !(seen && self.coupled) {
                continue;
            }
            let begins = Beginning { ahead: self.at_once, room: if within { 1.0 } else { ROOM } };
            match self.few(level, mechanism)?.span(mechanism, inputs, state, until, begins) {
                Ok(made) => {
                    self.tried[level].refusals = 0;
                    self.pass_by(level);
                    self.by_few = Some(level);
                    return Some(made);
                }
                Err(cost) => {
                    self.lost.add(&cost);
                    let tried = &mut self.tried[level];
                    tried.waits = WAIT << tried.refusals.min(DOUBLINGS);
                    tried.refusals += 1;
                }
            }
        }
        None
    }

    /// A span is made with more stages than these of the schemes have, which wait the shorter.
    fn pass_by(&mut self, fewer: usize) {
        self.tried[..fewer].iter_mut().for_each(|tried| tried.waits = tried.waits.saturating_sub(1));
    }
}

impl StepMaker for SpanSteps {
    fn figures(&self) -> StepFigures {
        let mut all = self.many.figures();
        for few in self.made().map(StepMaker::figures) {
            all.see_between(few.between);
            all.ringing = all.ringing.max(few.ringing);
        }
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
        self.by_few.is_some()
    }

    fn is_cheap_span(&self) -> bool {
        self.by_few == Some(0)
    }

    fn closure_forces(&self, forces: &mut Vec<[f64; 3]>) -> bool {
        self.last().closure_forces(forces)
    }

    fn leaves_transient(&self) -> bool {
        self.last().leaves_transient()
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
            && let Some(mut outcome) = self.try_few(mechanism, inputs, state, until)
        {
            outcome.cost.add(&std::mem::take(&mut self.lost));
            self.in_a_row += 1;
            return Ok(outcome);
        }
        if self.by_few.is_some() {
            // Many stages have not seen the spans since their last step, and go on with its length.
            self.many.keep_pace(self.many.step_pace(state.time), state.time);
            self.by_few = None;
        }
        let mut outcome = self.many.step(mechanism, inputs, state, until)?;
        outcome.cost.add(&std::mem::take(&mut self.lost));
        self.pass_by(TRIED.len());
        self.in_a_row = if self.given && state.time == until { self.in_a_row + 1 } else { 0 };
        Ok(outcome)
    }

    fn take_abandoned(&mut self) -> Cost {
        let mut cost = self.many.take_abandoned();
        for few in self.tried.iter_mut().filter_map(|tried| tried.scheme.as_mut()) {
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
        let many_steps = self.many.step_count();
        let (mut total, mut count) = (description.step * many_steps as f64, many_steps);
        for few in self.made() {
            let (of_few, steps) = (few.description(), few.step_count());
            description.include_stability(&of_few);
            total += of_few.step * steps as f64;
            count += steps;
            description.few_stage_steps += steps;
        }
        if description.adaptive && count > many_steps {
            description.step = total / count as f64;
        }
        description
    }
}
