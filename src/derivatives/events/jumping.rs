//! Velocities that jump at one instant: the impact of the run at its active set, with its derivatives.

use crate::derivatives::equations::laws::Laws;
use crate::derivatives::events::impact::Impact;
use crate::derivatives::events::instant::Instant;
use crate::derivatives::events::limit_impact::{LimitImpact, is_on_limits};
use crate::derivatives::events::meet::Met;
use crate::derivatives::events::struck::struck;
use crate::derivatives::events::walk::{Walk, fastest};
use crate::derivatives::forward::failure::SensitivityError;
use crate::derivatives::forward::step::{Part, StepMode, WIDTH};
use crate::derivatives::forward::tangent::{Tangent, with};
use crate::derivatives::linear::independent::Independent;
use crate::derivatives::numbers::number::Number;
use crate::events::trace::{Meeting, TracedJump};
use crate::instant::cone::impact::{Round, impact_in_rounds};
use crate::instant::cone::problem::{Law, Problem};
use crate::instant::dynamics::response::Response;
use crate::instant::holding::blocks::{Block, Of, Rows};
use crate::mechanism::motion::contact_solvers::ContactSolvers;

/// Velocities after an impact are those of the run to this part of the largest so far: laws of impact are solved to 1e-11, and rates at rest are removed.
const SAME_IMPACT: f64 = 1e-7;

impl Walk<'_> {
    /// Goes through what happens at an instant.
    pub(super) fn jump(&mut self, jump: &TracedJump) -> Result<(), SensitivityError> {
        self.fastest = self.fastest.max(fastest(&jump.before.velocity));
        let lost = || SensitivityError::Impact { time: jump.before.time };
        let rounds = if jump.meetings.iter().any(|meeting| meeting.rate(&jump.before.velocity) < -meeting.rest) {
            self.rounds(jump).ok_or_else(lost)?
        } else {
            Vec::new()
        };
        // A slip that stops leaves the error of its step, which the mode after it takes away.
        if rounds.is_empty() {
            return Ok(());
        }
        let after = self.impact(jump, &rounds)?;
        let off = after.iter().zip(&jump.after.velocity).map(|(own, of_run)| own - of_run).collect::<Vec<f64>>();
        if fastest(&off) > SAME_IMPACT * self.fastest {
            return Err(lost());
        }
        self.state.velocity = after;
        Ok(())
    }

    /// The rounds of the impact of the run.
    fn rounds(&self, jump: &TracedJump) -> Option<Vec<Round>> {
        let mut response = Response::new(self.subject.mechanism);
        let blocks: Vec<Block> = jump.meetings.iter().map(|meeting| meeting.block.clone()).collect();
        let rows = Rows::of(&mut response, &jump.before, &blocks);
        let before = rows.rates(&jump.before.velocity);
        let laws: Vec<Law> = blocks.iter().map(|block| block.law).collect();
        let restitution: Vec<f64> = jump.meetings.iter().map(|meeting| meeting.restitution).collect();
        let problem = Problem { mobility: &rows.square, free: &before, laws: &laws };
        let mut rounds = Some(Vec::new());
        let found = impact_in_rounds(&problem, &restitution, &mut ContactSolvers::default(), &mut rounds).ok()?;
        rounds.filter(|rounds| rounds.len() == found.rounds)
    }

    /// The velocities after the rounds, with their derivatives in the tangent.
    fn impact(&mut self, jump: &TracedJump, rounds: &[Round]) -> Result<Vec<f64>, SensitivityError> {
        let n = self.state.velocity.len();
        let mode = StepMode { free: (0..n).collect(), ..StepMode::default() };
        let gradient = self.gradient(&mode);
        let closed = Independent::of(&gradient, &vec![1.0; n]).rows;
        let lost = || SensitivityError::Impact { time: jump.before.time };
        let met: Option<Vec<Met<f64>>> =
            jump.meetings.iter().map(|meeting| self.met(meeting, jump, &self.figures.laws)).collect();
        let met = met.ok_or_else(lost)?;
        let (values, found) = {
            let still = vec![0.0; n];
            let at = Instant { figures: &self.figures, state: &self.state, offsets: &still, closed: &mode.closed };
            let closures = gradient.select_rows(&closed);
            struck(&at, &met, &closures, &self.state.velocity, rounds).ok_or_else(lost)?
        };
        if is_on_limits(&self.figures.plain, &met, &found) {
            let slopes = self.varied.slopes();
            let restitution = |meeting: usize, column: usize| match (jump.meetings[meeting].block.of, &slopes[column]) {
                (Of::Joint(index), Some(slopes)) if jump.meetings[meeting].restitution != 0.0 => {
                    slopes.laws.joints[index].restitution
                }
                _ => 0.0,
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
            let met: Option<Vec<Met<Part>>> =
                jump.meetings.iter().map(|meeting| self.met(meeting, jump, &figures.laws)).collect();
            let at = Instant { figures, state: &self.state, offsets: &offsets, closed: &mode.constant };
            let impact = Impact { at, met: &met.ok_or_else(lost)?, closed: &closed, row_count: gradient.nrows() };
            let after = impact.after(&before, &found).ok_or_else(lost)?;
            for (row, part) in after.iter().enumerate() {
                (first..tangent.ncols().min(first + WIDTH))
                    .for_each(|column| tangent[(row, column)] = part.parts[column - first]);
            }
        }
        self.tangent.velocities = tangent;
        Ok(values)
    }

    /// A limit or contact with its numbers; restitution counts if it did in the run.
    fn met<T: Number>(&self, meeting: &Meeting, jump: &TracedJump, laws: &Laws<T>) -> Option<Met<T>> {
        let restitution = |of: T| if meeting.restitution == 0.0 { T::zero() } else { of };
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
                Met::Contact { touch, friction: pair.friction, restitution: restitution(pair.restitution) }
            }
        })
    }
}
