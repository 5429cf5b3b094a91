//! Limits and contacts that strike in one impact, and one after the other as soon as a parameter changes.
//!
//! ```text
//!     φ_k = 0 at the impact t*(θ),  φ̇_k < 0          dφ_k/dθ = ∂φ_k/∂θ + ∂φ_k/∂q dq/dθ,  dq/dθ at t*(θ)
//! ```
//!
//! The gap that ends the step has dφ/dθ = 0. Another one with dφ_k/dθ ≠ 0 closes earlier or later, by the sign of δθ. Both strike at once for δθ = 0
//! alone, so that the derivatives are valid within 0.

use crate::derivatives::equations::closed::ClosedContacts;
use crate::derivatives::events::closing::STAYS;
use crate::derivatives::events::instant::Instant;
use crate::derivatives::events::walk::Walk;
use crate::derivatives::events::watched::gap_of_joint;
use crate::derivatives::forward::stage_equations::BothFigures;
use crate::derivatives::forward::step::{Part, WIDTH};
use crate::derivatives::forward::tangent::with;
use crate::events::trace::{Meeting, TracedJump};
use crate::instant::holding::blocks::Of;

/// The cause in words, for an impact at this time (s).
pub(super) fn one_after_the_other(time: f64) -> String {
    format!("contacts that strike together at {time:.6} s strike one after the other")
}

/// The limits and contacts that approach before an impact.
fn striking(jump: &TracedJump) -> impl Iterator<Item = &Meeting> {
    jump.meetings.iter().filter(|meeting| meeting.approaches(&jump.before.velocity))
}

impl Walk<'_> {
    /// Tells of parameters by which contacts and limits strike one after the other.
    pub(super) fn see_apart(&mut self, jump: &TracedJump) {
        if !self.tells || striking(jump).count() < 2 {
            return;
        }
        let what = one_after_the_other(self.state.time);
        let (n, p) = self.tangent.positions.shape();
        for first in (0..p).step_by(WIDTH) {
            let offsets: Vec<Part> = (0..n).map(|row| with(0.0, &self.tangent.positions, row, first)).collect();
            let gaps = self.gaps_of(jump, &self.varied.chunks()[first / WIDTH], &offsets);
            for column in first..p.min(first + WIDTH) {
                // Gaps have the roundings of the derivatives of places.
                let stays = STAYS * self.tangent.positions.column(column).amax().max(1.0);
                if gaps.iter().any(|gap| gap.parts[column - first].abs() > stays) {
                    self.validity.none(column, &what);
                }
            }
        }
    }

    /// The gaps that close in the impact, with their derivatives (rad or m).
    fn gaps_of(&self, jump: &TracedJump, figures: &BothFigures<Part>, offsets: &[Part]) -> Vec<Part> {
        let at = Instant { figures, state: &self.state, offsets, closed: &ClosedContacts::default() };
        let placed = at.at_rest();
        let gap = |of: Of| match of {
            Of::Contact(index) => Some(self.touch(jump.contacts.get(index)?, &figures.laws)?.at(&placed).gap),
            Of::Joint(index) => {
                let (elements, joint) = (self.subject.elements, &self.subject.elements.joints[index]);
                let side = joint.side(joint.position(&jump.before))?;
                Some(gap_of_joint(&at, elements, index, side))
            }
            Of::Moment { .. } => None,
        };
        striking(jump).filter_map(|meeting| gap(meeting.block.of)).collect()
    }
}
