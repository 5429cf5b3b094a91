//! Velocities that jump at one instant: the impact of the run at its active set, with its derivatives.

use crate::derivatives::equations::laws::Laws;
use crate::derivatives::events::closing::STAYS;
use crate::derivatives::events::impact::Impact;
use crate::derivatives::events::instant::Instant;
use crate::derivatives::events::limit_impact::{LimitImpact, is_on_limits};
use crate::derivatives::events::meet::Met;
use crate::derivatives::events::struck::{Answer, BlockState, struck};
use crate::derivatives::events::together::one_after_the_other;
use crate::derivatives::events::walk::{Subject, Walk, fastest};
use crate::derivatives::forward::failure::SensitivityError;
use crate::derivatives::forward::step::{Part, StepMode, WIDTH};
use crate::derivatives::forward::tangent::{Tangent, with};
use crate::derivatives::linear::independent::Independent;
use crate::derivatives::numbers::number::Number;
use crate::events::trace::{Meeting, TracedJump};
use crate::instant::cone::impact::{Round, impact_in_rounds};
pub use crate::instant::cone::problem::{Law, Problem};
use crate::instant::dynamics::response::Response;
pub use crate::instant::holding::blocks::{Block, Of, Rows};
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::contact_solvers::ContactSolvers;

/// A rate after an impact below this part of its rebound is no rebound.
const AT_REST: f64 = 1e-6;
/// Velocities after an impact may differ by this many times the difference before it, and the fastest rebound that the run left out: it stops rebounds
/// after an impact with them.
const AMPLIFIED: f64 = 4.0;
/// Velocities after an impact are those of the run to this part of the largest so far: laws of impact are solved to 1e-11, and rates at rest are removed.
const SAME_IMPACT: f64 = 1e-7;

/// A limit or contact that meets, as it counts in an impact.
#[derive(Clone, Copy)]
struct Counted<'m> {
    meeting: &'m Meeting,
    /// e, or zero if it does not rebound.
    restitution: f64,
    /// Whether it has friction.
    rubs: bool,
}

impl Walk<'_> {
    /// Goes through what happens at an instant.
    pub(super) fn jump(&mut self, jump: &TracedJump) -> Result<(), SensitivityError> {
        self.fastest = self.fastest.max(fastest(&jump.before.velocity));
        // A slip that stops leaves the error of its step, which the mode after it takes away.
        if !jump.meetings.iter().any(|meeting| meeting.approaches(&jump.before.velocity)) {
            return Ok(());
        }
        self.see_apart(jump);
        let lost = || SensitivityError::Impact { time: jump.before.time };
        let (restitution, slow) = self.without_low_rebounds(jump).ok_or_else(lost)?;
        let before = self.state.velocity.iter().zip(&jump.before.velocity).map(|(own, of_run)| own - of_run);
        let apart = fastest(&before.collect::<Vec<f64>>());
        let bound = SAME_IMPACT * self.fastest + AMPLIFIED * slow.max(apart);
        let tangent = self.tangent.velocities.clone();
        // Rebounds that a run stops may kick others open, which it stops as well: an impact of all without restitution.
        let plastic = vec![0.0; restitution.len()];
        for counted in [&restitution, &plastic] {
            let Some(rounds) = rounds(self.subject.mechanism, jump, counted) else { continue };
            if rounds.is_empty() {
                return Ok(());
            }
            let whole = |(meeting, &counted)| Counted { meeting, restitution: counted, rubs: true };
            let all: Vec<Counted> = jump.meetings.iter().zip(counted).map(whole).collect();
            let Ok(mut after) = self.impact(jump, &all, &rounds) else { continue };
            let before = self.state.velocity.clone();
            let is_of_run = |after: &[f64]| {
                let gained = after.iter().zip(&before).map(|(after, before)| after - before);
                let of_run = jump.after.velocity.iter().zip(&jump.before.velocity);
                let off = gained.zip(of_run).map(|(own, (after, before))| own - (after - before));
                fastest(&off.collect::<Vec<f64>>()) <= bound
            };
            let mut kicked = Vec::new();
            if !is_of_run(&after) {
                (after, kicked) = self.stop_kicked(jump, after, &is_of_run);
            }
            if is_of_run(&after) {
                self.state.velocity = after;
                kicked.into_iter().for_each(|(meeting, rate)| self.tell_of_end(meeting, jump, rate));
                for ((meeting, own), counted) in jump.meetings.iter().zip(&restitution).zip(counted) {
                    let rate = meeting.rate(&jump.before.velocity);
                    if own > counted && rate < -meeting.rest {
                        self.tell_of_end(meeting, jump, -rate * own);
                    }
                }
                return Ok(());
            }
            self.tangent.velocities.copy_from(&tangent);
        }
        Err(lost())
    }

    /// Brings to rest what an impact with these velocities has kicked open and the run has stopped, with all that rests beside it: by pulls along the
    /// normals alone, or along the friction of what slides as well. Returns the velocities, and what was kicked with its rates [rad/s or m/s].
    fn stop_kicked<'j>(
        &mut self,
        jump: &'j TracedJump,
        after: Vec<f64>,
        is_of_run: &dyn Fn(&[f64]) -> bool,
    ) -> (Vec<f64>, Vec<(&'j Meeting, f64)>) {
        let rests = |meeting: &&Meeting| meeting.rate(&jump.after.velocity).abs() <= meeting.rest;
        let at_rest: Vec<&Meeting> = jump.meetings.iter().filter(rests).collect();
        let rates = at_rest.iter().map(|&meeting| (meeting, meeting.rate(&after)));
        let kicked: Vec<(&Meeting, f64)> = rates.filter(|(meeting, rate)| *rate > meeting.rest).collect();
        if kicked.is_empty() {
            return (after, kicked);
        }
        let (before, tangent) = (self.state.velocity.clone(), self.tangent.velocities.clone());
        for rubs in [false, true] {
            let slides = |meeting: &Meeting| match &meeting.block.rows[..] {
                [_, first, second] if rubs => first.rate(&after).hypot(second.rate(&after)) > meeting.rest,
                _ => false,
            };
            let counted = |&meeting| Counted { meeting, restitution: 0.0, rubs: slides(meeting) };
            let all: Vec<Counted> = at_rest.iter().map(counted).collect();
            let state = |of: &Counted| if of.rubs { BlockState::Slips } else { BlockState::Inside };
            let none = vec![0.0; all.iter().map(|of| if of.rubs { of.meeting.block.rows.len() } else { 1 }).sum()];
            let states = all.iter().map(state).collect();
            let plastic = Answer { forces: none.clone(), rates: none, states, residual: 0.0 };
            let round = Round { part: (0..all.len()).collect(), plastic, rebound: None, share: 1.0 };
            self.state.velocity.copy_from_slice(&after);
            let stopped = self.impact(jump, &all, &[round]);
            self.state.velocity.copy_from_slice(&before);
            match stopped {
                Ok(stopped) if is_of_run(&stopped) => return (stopped, kicked),
                _ => self.tangent.velocities.copy_from(&tangent),
            }
        }
        (after, kicked)
    }

    /// The restitution of all meetings as the run has it after the impact, zero where it left out a rebound because it was too low, and the fastest of
    /// these [rad/s or m/s].
    fn without_low_rebounds(&mut self, jump: &TracedJump) -> Option<(Vec<f64>, f64)> {
        let mut restitution: Vec<f64> = jump.meetings.iter().map(|meeting| meeting.restitution).collect();
        let mut slow = 0.0_f64;
        for (own, meeting) in restitution.iter_mut().zip(&jump.meetings) {
            let [before, after] = [&jump.before, &jump.after].map(|state| meeting.rate(&state.velocity));
            let rebounds = -before * self.law_of(meeting, jump)?;
            if before < -meeting.rest && rebounds > 0.0 && after.abs() <= meeting.rest.max(AT_REST * rebounds) {
                *own = 0.0;
                slow = slow.max(rebounds);
                self.tell_of_end(meeting, jump, rebounds);
            }
        }
        Some((restitution, slow))
    }

    /// e of a meeting, whatever counted in the impact.
    fn law_of(&self, meeting: &Meeting, jump: &TracedJump) -> Option<f64> {
        let laws = &self.figures.laws;
        Some(match meeting.block.of {
            Of::Joint(index) if self.subject.elements.joints[index].is_locked() => 0.0,
            Of::Joint(index) => laws.joints[index].restitution,
            Of::Contact(index) => laws.pairs[jump.contacts.get(index)?.pair].restitution,
            Of::Moment { .. } => 0.0,
        })
    }

    /// Tells once that the rebounds of an element end.
    fn tell_of_end(&mut self, meeting: &Meeting, jump: &TracedJump, rate: f64) {
        let Subject { mechanism, elements, .. } = *self.subject;
        let what = match meeting.block.of {
            Of::Joint(index) => {
                let joint = mechanism.joint_of_freedom(elements.joints[index].coordinate.freedom);
                format!("the rebounds of joint {joint:?} end")
            }
            Of::Contact(index) | Of::Moment { contact: index, .. } => {
                let pair = jump.contacts.get(index).map_or(0, |contact| contact.pair);
                format!("the rebounds of {} end", self.names("on", pair))
            }
        };
        if !self.warnings.iter().any(|known| known.starts_with(&what)) {
            self.warnings.push(format!(
                "{what} at {:.6} s: those from {rate:.1e} rad/s or m/s on are left out, and derivatives behind lack their part; take a finer \
                 tolerance and compare",
                jump.before.time
            ));
        }
    }

    /// The velocities after the rounds, with their derivatives in the tangent.
    fn impact(
        &mut self,
        jump: &TracedJump,
        counted: &[Counted],
        rounds: &[Round],
    ) -> Result<Vec<f64>, SensitivityError> {
        let n = self.state.velocity.len();
        let mode = StepMode { free: (0..n).collect(), ..StepMode::default() };
        let gradient = self.gradient(&mode);
        let closed = Independent::of(&gradient, &vec![1.0; n]).rows;
        let lost = || SensitivityError::Impact { time: jump.before.time };
        let met: Option<Vec<Met<f64>>> = counted.iter().map(|of| self.met(of, jump, &self.figures.laws)).collect();
        let met = met.ok_or_else(lost)?;
        let (values, found) = {
            let still = vec![0.0; n];
            let at = Instant { figures: &self.figures, state: &self.state, offsets: &still, closed: &mode.closed };
            let closures = gradient.select_rows(&closed);
            struck(&at, &met, &closures, &self.state.velocity, rounds).ok_or_else(lost)?
        };
        if is_on_limits(&self.figures.plain, &met, &found) {
            let slopes = self.varied.slopes();
            let restitution = |number: usize, column: usize| {
                let Counted { meeting, restitution, .. } = counted[number];
                match (meeting.block.of, &slopes[column]) {
                    (Of::Joint(index), Some(slopes)) if restitution != 0.0 => slopes.laws.joints[index].restitution,
                    _ => 0.0,
                }
            };
            let (figures, state) = (&self.figures.plain, &self.state);
            let impact = LimitImpact { figures, state, met: &met, restitution: &restitution, slopes };
            let Tangent { positions, velocities, .. } = &self.tangent;
            self.tangent.velocities = impact.after(positions, velocities, &found).ok_or_else(lost)?;
            return Ok(values);
        }
        let mut tangent = self.tangent.velocities.clone();
        for (chunk, figures) in self.varied.chunks().iter().enumerate() {
            let first = chunk * WIDTH;
            let offsets: Vec<Part> = (0..n).map(|row| with(0.0, &self.tangent.positions, row, first)).collect();
            let before: Vec<Part> =
                (0..n).map(|row| with(self.state.velocity[row], &self.tangent.velocities, row, first)).collect();
            let met: Option<Vec<Met<Part>>> = counted.iter().map(|of| self.met(of, jump, &figures.laws)).collect();
            let at = Instant { figures, state: &self.state, offsets: &offsets, closed: &mode.constant };
            let impact = Impact { at, met: &met.ok_or_else(lost)?, closed: &closed, row_count: gradient.nrows() };
            let (after, lacking) = impact.after(&before, &found).ok_or_else(lost)?;
            // Laws of redundant contacts that lack less agree with each other.
            for (column, _) in (first..tangent.ncols()).zip(lacking).filter(|(_, lacking)| *lacking > STAYS) {
                self.validity.none(column, &one_after_the_other(self.state.time));
            }
            for (row, part) in after.iter().enumerate() {
                (first..tangent.ncols().min(first + WIDTH))
                    .for_each(|column| tangent[(row, column)] = part.parts[column - first]);
            }
        }
        self.tangent.velocities = tangent;
        Ok(values)
    }

    /// A limit or contact with its numbers; restitution counts if it did in the run.
    fn met<T: Number>(&self, of: &Counted, jump: &TracedJump, laws: &Laws<T>) -> Option<Met<T>> {
        let Counted { meeting, restitution: counted, rubs } = *of;
        let restitution = |of: T| if counted == 0.0 { T::zero() } else { of };
        Some(match meeting.block.of {
            Of::Joint(index) => {
                let freedom = self.subject.elements.joints[index].coordinate.freedom;
                let sign = meeting.block.rows.first()?.get(freedom).copied()?;
                Met::Joint { freedom, sign, restitution: restitution(laws.joints[index].restitution) }
            }
            Of::Moment { .. } => return None,
            Of::Contact(index) => {
                let contact = jump.contacts.get(index)?;
                let pair = &laws.pairs[contact.pair];
                let touch = self.touch(contact, laws)?;
                let friction = if rubs { pair.friction } else { T::zero() };
                Met::Contact { touch, friction, restitution: restitution(pair.restitution) }
            }
        })
    }
}

/// The rounds of the impact of a run, with a restitution for each meeting.
fn rounds(mechanism: &Mechanism, jump: &TracedJump, restitution: &[f64]) -> Option<Vec<Round>> {
    let mut response = Response::new(mechanism);
    let blocks: Vec<Block> = jump.meetings.iter().map(|meeting| meeting.block.clone()).collect();
    let rows = Rows::of(&mut response, &jump.before, &blocks);
    let before = rows.rates(&jump.before.velocity);
    let laws: Vec<Law> = blocks.iter().map(|block| block.law).collect();
    let problem = Problem { mobility: &rows.square, free: &before, laws: &laws };
    let mut rounds = Some(Vec::new());
    let found = impact_in_rounds(&problem, restitution, &mut ContactSolvers::default(), &mut rounds).ok()?;
    rounds.filter(|rounds| rounds.len() == found.rounds)
}
