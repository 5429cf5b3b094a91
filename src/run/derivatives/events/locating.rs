//! A step that ends at an event, with its length as one more unknown.
//!
//! ```text
//!     φ(q̄(h), v̄(h), t₀ + h) = 0          h ← h − φ/φ̇,     φ̇ = φ_q ∂q̄/∂h + φ_v ∂v̄/∂h + φ_t
//!     δh = −(φ_q δq̄ + φ_v δv̄ + φ_t δt₀ + φ_θ δθ)/φ̇          δq̄, δv̄ at fixed h
//! ```

use crate::derivatives::equations::closed::ClosedContacts;
use crate::derivatives::equations::contacts::TouchFigures;
use crate::derivatives::events::efforts::{EffortLaws, Efforts};
use crate::derivatives::events::instant::{Accelerations, Instant};
use crate::derivatives::events::validity::MetEvent;
use crate::derivatives::events::walk::{KeptStep, Subject, Walk};
use crate::derivatives::events::watched::Sight;
use crate::derivatives::forward::failure::SensitivityError;
use crate::derivatives::forward::figure_slopes::FigureSlopes;
use crate::derivatives::forward::step::{Part, SolvedStep, StepMode, WIDTH};
use crate::derivatives::forward::tangent::{Tangent, with};
use crate::derivatives::forward::tree::by_length;
use crate::derivatives::numbers::number::Number;
use crate::events::trace::{Closed, Mode, TracedJump, TracedStep, Watched};
use crate::instant::holding::touching::Contact;
use crate::mechanism::description::closure::Attachment;
use crate::mechanism::description::joint::Pose;
use crate::mechanism::motion::event::Side;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use crate::mechanism::motion::touches::touch_motion;
use nalgebra::{DMatrix, DVector};
use std::cell::OnceCell;
use std::sync::Arc;

/// Newton iterations for the length of a step; three or four are made.
const ATTEMPTS: usize = 12;
/// Lengths of steps have this part of their time as roundings.
const ROUNDINGS: f64 = 2.0 * f64::EPSILON;

/// Second differences of places over this time (s) have roundings of 1e-8 m/s².
const SOON: f64 = 1e-4;

/// A direction in which a state varies: by the length of its step, or by some parameters.
pub(super) struct Varying<'v> {
    /// The parameters among all that are meant; `None` for the length of the step.
    pub chunk: Option<usize>,
    pub tangent: &'v Tangent,
    /// Of the state without its derivatives, if they were asked for.
    pub accelerations: &'v OnceCell<Option<Accelerations>>,
}

/// A solved step that ends at an event.
struct Located {
    kept: Arc<KeptStep>,
    efforts: Vec<Efforts>,
    /// φ̇ at its end.
    rate: f64,
    /// The derivatives of its end by its length.
    along: Tangent,
}

impl Walk<'_> {
    pub(super) fn step_to_event(
        &mut self,
        traced: &TracedStep,
        (mode, known): (&StepMode, Option<Arc<KeptStep>>),
        closed: &[ClosedContacts<Part>],
        trigger: Watched,
        next: Option<&TracedJump>,
    ) -> Result<(), SensitivityError> {
        let since = self.state.time;
        let contact = next.and_then(|jump| self.contact_of(trigger, jump, &traced.mode));
        let words = self.words(trigger, contact, &traced.mode);
        let unknown = |time: f64| SensitivityError::Event { time, what: words.clone() };
        let of = (trigger, contact);
        let Located { kept, efforts, rate, along } = self.locate(traced, (mode, known), of, &words)?;
        let (step, solved) = (kept.step, &kept.solved);
        let start = self.state.clone();
        let still = DVector::zeros(self.tangent.times.len());
        self.carry(mode, step, solved, efforts, closed, &still)?;
        self.take_end(solved, since + step);
        self.see_turn(traced, trigger, [&start, solved.stages.iter().rev().nth(1).unwrap_or(&start)], &words);
        let mut longer = DVector::zeros(still.len());
        let accelerations = OnceCell::new();
        for (chunk, closed) in closed.iter().enumerate().take(longer.len().div_ceil(WIDTH)) {
            let (chunk, tangent) = (Some(chunk), &self.tangent);
            let varying = Varying { chunk, tangent, accelerations: &accelerations };
            let value = self
                .seen(traced, mode, &self.state, since, &varying, closed, of)
                .ok_or_else(|| unknown(traced.end.time))?;
            let first = chunk.unwrap_or(0) * WIDTH;
            let width = WIDTH.min(longer.len() - first);
            (0..width).for_each(|part| longer[first + part] = -value.parts[part] / rate);
        }
        self.tangent.positions += &along.positions * longer.transpose();
        self.tangent.velocities += &along.velocities * longer.transpose();
        self.tangent.times += &longer;
        let by_time = self.tangent.times.transpose();
        self.still = Some(Tangent {
            positions: &self.tangent.positions - &along.positions * &by_time,
            velocities: &self.tangent.velocities - &along.velocities * &by_time,
            times: still,
        });
        let by = self.tangent.times.iter().copied().collect();
        let (state, tangent) = (self.state.clone(), self.tangent.clone());
        let event = MetEvent { time: state.time, what: words, by, rate, state, tangent, along };
        let bend = match trigger {
            _ if !self.tells => None,
            Watched::Gap(..) | Watched::Approach(_) => self.bend(traced, mode, since, &event.along, of),
            // Such functions have no second derivative without a third one of the motion: the mean over the step.
            _ => self.value(traced, mode, &start, since, of).map(|begun| 2.0 * (begun + rate * step) / (step * step)),
        };
        self.validity.see_event(&event, bend.unwrap_or(0.0), self.events.last());
        self.events.push(event);
        Ok(())
    }

    /// The step that ends at an event: Newton's method for its length, unless it is known.
    fn locate(
        &mut self,
        traced: &TracedStep,
        (mode, known): (&StepMode, Option<Arc<KeptStep>>),
        of: (Watched, Option<&Contact>),
        words: &str,
    ) -> Result<Located, SensitivityError> {
        let since = self.state.time;
        let unknown = || SensitivityError::Event { time: traced.end.time, what: words.to_string() };
        if let Some(kept) = known {
            let efforts = self.efforts_over(traced, kept.step);
            let by_length = self.by_length(traced, mode, kept.step, &kept.solved, &efforts, of);
            let (_, rate, along) = by_length.ok_or_else(unknown)?;
            return Ok(Located { kept, efforts, rate, along });
        }
        let mut step = traced.end.time - since;
        let mut last = f64::INFINITY;
        let mut known = None;
        for attempt in 1..=ATTEMPTS {
            let (solved, efforts) = self.solved(traced, mode, step, known)?;
            let by_length = self.by_length(traced, mode, step, &solved, &efforts, of);
            let (value, rate, along) = by_length.ok_or_else(unknown)?;
            let change = value / rate;
            if !change.is_finite() {
                return Err(SensitivityError::Graze { time: traced.end.time, what: words.to_string() });
            }
            // A root cannot be told from its roundings any more.
            let rounding = ROUNDINGS * step.max((since + step).abs());
            let ends = change.abs() <= rounding || change.abs() <= 1e-9 * step && change.abs() >= 0.25 * last;
            if ends || attempt == ATTEMPTS {
                let values = efforts.iter().map(|efforts| efforts.values.clone()).collect();
                let kept = Arc::new(KeptStep { step, mode: mode.clone(), solved, efforts: values });
                if self.keeps {
                    self.kept = Some(kept.clone());
                }
                return Ok(Located { kept, efforts, rate, along });
            }
            known = Some((solved, (change / step).abs()));
            step -= change;
            last = change.abs();
        }
        Err(self.failed())
    }

    /// φ at the end of a solved step, φ̇, and the derivatives of the end by the length of the step.
    #[allow(clippy::too_many_arguments)]
    fn by_length(
        &self,
        traced: &TracedStep,
        mode: &StepMode,
        step: f64,
        solved: &SolvedStep,
        efforts: &[Efforts],
        of: (Watched, Option<&Contact>),
    ) -> Option<(f64, f64, Tangent)> {
        let values: Vec<DVector<f64>> = efforts.iter().map(|efforts| efforts.values.clone()).collect();
        let rates: Vec<DVector<f64>> = efforts.iter().map(|efforts| efforts.rates.clone()).collect();
        let end = solved.stages.last()?;
        let (positions, velocities) = if self.is_brief(traced) {
            let found = Accelerations::of(&self.constant, end, mode, values.last()?.as_slice())?;
            (DVector::from_column_slice(&end.velocity), DVector::from_column_slice(found.values()))
        } else {
            by_length(&self.problem(mode, step, &values), solved, &rates)?
        };
        let n = positions.len();
        let along = Tangent {
            positions: DMatrix::from_column_slice(n, 1, positions.as_slice()),
            velocities: DMatrix::from_column_slice(n, 1, velocities.as_slice()),
            times: DVector::from_element(1, 1.0),
        };
        let varying = Varying { chunk: None, tangent: &along, accelerations: &OnceCell::new() };
        let value = self.seen(traced, mode, end, self.state.time, &varying, &mode.constant, of)?;
        Some((value.value, value.parts[0], along))
    }

    /// φ̈ of a function of places where the state is now, which moves with these rates.
    fn bend(
        &self,
        traced: &TracedStep,
        mode: &StepMode,
        since: f64,
        rates: &Tangent,
        of: (Watched, Option<&Contact>),
    ) -> Option<f64> {
        let at = |time: f64| {
            let moved = &rates.positions * time + &rates.velocities * (0.5 * time * time);
            let mut state = self.state.clone();
            state.displace(self.subject.mechanism, moved.as_slice());
            self.value(traced, mode, &state, since, of)
        };
        Some((at(SOON)? + at(-SOON)? - 2.0 * at(0.0)?) / (SOON * SOON))
    }

    /// φ in a state.
    fn value(
        &self,
        traced: &TracedStep,
        mode: &StepMode,
        state: &State,
        since: f64,
        of: (Watched, Option<&Contact>),
    ) -> Option<f64> {
        let n = state.velocity.len();
        let nothing =
            Tangent { positions: DMatrix::zeros(n, 1), velocities: DMatrix::zeros(n, 1), times: DVector::zeros(1) };
        let varying = Varying { chunk: None, tangent: &nothing, accelerations: &OnceCell::new() };
        Some(self.seen(traced, mode, state, since, &varying, &mode.constant, of)?.value)
    }

    /// φ in a state, with its derivatives.
    #[allow(clippy::too_many_arguments)]
    fn seen(
        &self,
        traced: &TracedStep,
        mode: &StepMode,
        state: &State,
        since: f64,
        varying: &Varying,
        closed: &ClosedContacts<Part>,
        (trigger, contact): (Watched, Option<&Contact>),
    ) -> Option<Part> {
        self.sighted(traced, mode, (state, since), varying, closed, contact, |sight| sight.value(trigger))
    }

    /// An answer of a state with its derivatives.
    #[allow(clippy::too_many_arguments)]
    pub(super) fn sighted<R>(
        &self,
        traced: &TracedStep,
        mode: &StepMode,
        (state, since): (&State, f64),
        varying: &Varying,
        closed: &ClosedContacts<Part>,
        contact: Option<&Contact>,
        answer: impl FnOnce(&Sight) -> Option<R>,
    ) -> Option<R> {
        let n = state.velocity.len();
        let Tangent { positions, velocities, times } = varying.tangent;
        let first = varying.chunk.unwrap_or(0) * WIDTH;
        let width = WIDTH.min(times.len() - first);
        let figures = varying.chunk.map_or(&self.constant, |chunk| &self.varied.chunks()[chunk]);
        let own: Vec<Part> = (0..n).map(|row| with(0.0, positions, row, first)).collect();
        let rates: Vec<Part> = (0..n).map(|row| with(state.velocity[row], velocities, row, first)).collect();
        let of_parameters = varying.chunk.is_some();
        // The derivatives of a number that depends on parameters and time.
        let with_time = |value: f64, slope: &dyn Fn(usize) -> f64, rate: f64| {
            let mut part = Part::of(value);
            for index in 0..width {
                let fixed = if of_parameters { slope(first + index) } else { 0.0 };
                part.parts[index] = fixed + rate * times[first + index];
            }
            part
        };
        let efforts = &self.efforts_at(&traced.mode, since, &[state.time])[0];
        let efforts: Vec<Part> = (0..n)
            .map(|row| with_time(efforts.values[row], &|column| efforts.slopes[(row, column)], efforts.rates[row]))
            .collect();
        let Subject { elements, laws, parameters, .. } = *self.subject;
        let of = EffortLaws { elements, laws, parameters, varied: &self.varied };
        let drives: Vec<Part> = (0..elements.motors.len())
            .map(|motor| {
                let (value, slopes, rate) = of.drive(motor, since, state.time);
                with_time(value, &|column| slopes[column], rate)
            })
            .collect();
        let touch = contact.and_then(|contact| self.touch(contact, &figures.laws));
        let contacts = traced.mode.contacts.iter().map(|closed| self.touch(&closed.contact, &figures.laws));
        let contacts: Vec<Option<TouchFigures<Part>>> = contacts.collect();
        let at = Instant { figures, state, offsets: &own, closed };
        let sight = Sight {
            at,
            constant: &self.constant,
            velocities: &rates,
            elements,
            mode: &traced.mode,
            equations: mode,
            efforts: &efforts,
            drives: &drives,
            touch: touch.as_ref(),
            contacts: &contacts,
            accelerations: varying.accelerations,
        };
        answer(&sight)
    }

    /// The contact at which a pair closes: the one with the least gap of those that were not closed before.
    fn contact_of<'j>(&self, trigger: Watched, jump: &'j TracedJump, mode: &Mode) -> Option<&'j Contact> {
        let Watched::Approach(pair) = trigger else { return None };
        let bodies = body_states(self.subject.mechanism, &jump.before);
        let gap = |contact: &&Contact| touch_motion(&contact.joint, &bodies).gap.abs();
        let own = || jump.contacts.iter().filter(|contact| contact.pair == pair);
        let rests = |contact: &&Contact| {
            let same = |closed: &Closed| closed.contact.pair == pair && closed.contact.features == contact.features;
            mode.contacts.iter().any(same)
        };
        let least = |one: &&Contact, other: &&Contact| gap(one).total_cmp(&gap(other));
        own().filter(|contact| !rests(contact)).min_by(least).or_else(|| own().min_by(least))
    }

    /// A contact with the numbers of its colliders.
    pub(super) fn touch<T: Number>(
        &self,
        contact: &Contact,
        laws: &crate::derivatives::equations::laws::Laws<T>,
    ) -> Option<TouchFigures<T>> {
        let Subject { mechanism, .. } = *self.subject;
        let pair = mechanism.nonsmooth.pairs.get(contact.pair)?;
        let numbers = if contact.is_swapped() { [pair.b, pair.a] } else { [pair.a, pair.b] };
        let colliders = numbers.map(|number| (&mechanism.nonsmooth.colliders[number], number));
        let in_frame = |end: &Attachment| {
            let own = end.body.map_or_else(Pose::identity, |body| self.subject.frames[body].inverse());
            Attachment { body: end.body, frame: own * end.frame }
        };
        let touch = TouchFigures::new(&contact.joint, colliders, laws, &in_frame)?;
        let varies = |number: usize| {
            let radius = |slopes: &FigureSlopes| slopes.laws.colliders[number].sizes[0];
            self.varied.slopes().iter().flatten().any(|slopes| radius(slopes) != 0.0)
        };
        let is_lost = touch.fixed().into_iter().zip(numbers).any(|(fixed, number)| fixed && varies(number));
        (!is_lost).then_some(touch)
    }

    /// An event in words.
    fn words(&self, trigger: Watched, contact: Option<&Contact>, mode: &Mode) -> String {
        let Subject { mechanism, elements, .. } = *self.subject;
        let joint = |index: usize| mechanism.joint_of_freedom(elements.joints[index].coordinate.freedom).to_string();
        let motor = |index: usize| mechanism.joint_of_freedom(elements.motors[index].coordinate.freedom).to_string();
        let side = |side: Side| if side == Side::Lower { "lower" } else { "upper" };
        let pair_of = |index: usize| mode.contacts[index].contact.pair;
        match trigger {
            Watched::Gap(index, of) => format!("joint {:?} meets its {} limit", joint(index), side(of)),
            Watched::Slide(index) => format!("joint {:?} stops", joint(index)),
            Watched::Bears(index, _) => format!("joint {:?} is let go", joint(index)),
            Watched::Margin => "held joints are let go".into(),
            Watched::Motor(index, _) => format!("the motor of {:?} reaches its bound", motor(index)),
            Watched::Excess(index) => format!("the motor of {:?} leaves its bound", motor(index)),
            Watched::Approach(pair) => self.names("meets", contact.map_or(pair, |contact| contact.pair)),
            Watched::SlipsTogether(pair) => self.names("stops on", pair),
            Watched::Presses(index) => self.names("parts from", pair_of(index)),
            Watched::Returns(index) => self.names("presses again on", mode.unpressed[index].pair),
            Watched::Grips(index) => self.names("begins to slide on", pair_of(index)),
            Watched::Slips(index) => self.names("stops on", pair_of(index)),
            Watched::Resists(index, _) => self.names("begins to roll or spin on", pair_of(index)),
            Watched::Turns(index, _) => self.names("stops to roll or spin on", pair_of(index)),
            Watched::Feature(_) => "a contact leaves its features".into(),
        }
    }

    pub(super) fn names(&self, verb: &str, pair: usize) -> String {
        let nonsmooth = &self.subject.mechanism.nonsmooth;
        nonsmooth.pairs.get(pair).map_or_else(String::new, |pair| {
            format!("{:?} {verb} {:?}", nonsmooth.colliders[pair.a].name, nonsmooth.colliders[pair.b].name)
        })
    }
}
