//! The balance of energy of a step that ends at an event, or in which contacts slide: a step that is off by more than is allowed follows another motion
//! than the equations.
//!
//! ```text
//!     Δ = |E₁ − E₀ + lost|  ≤  max(0.03 T, 10⁻⁶) K           K: the largest kinetic energy so far (J), T: the tolerance (m)
//!                           ≤  max(10⁻⁸ K, W)                 contacts slide, and h ≤ 10⁻⁵ s;   W: the loss by friction (J)
//!                           ≤  max(10⁻⁶ K, 10⁻⁴ W)            contacts slide, given steps
//!                           ≤  10⁻⁴ K                         all contacts stick, given steps
//!                           ≤  max(0.03 T, 10⁻⁶) K            without contacts, near a gimbal lock, at an event or h ≤ 10⁻⁷ s
//! ```
//!
//! Steps of chosen lengths are judged by their energy where they are made; one that is made again, to end at an event, is not. A slip that no polynomial
//! follows is off by about the loss by friction. More than that in a short step, which has no truncation, comes from pressures without bound: contacts
//! jam there, and their equations have other solutions. Near a gimbal lock joints turn at rates without bound, and a step is off by their roundings.

use crate::events::effects::resting::energy;
use crate::events::integrator::Eventful;
use crate::events::modes::piece::Piece;
use crate::events::next_step::Ending;
use crate::events::sliding::JAM;
use crate::mechanism::forces::total::Exchange;
use crate::mechanism::motion::distance::size;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::state::State;
use crate::stepping::watching::unseen::Pushes;

/// The part of the tolerance by which a step may be off, as a part of the largest kinetic energy: as for steps of chosen lengths.
const SHARE: f64 = 0.03;
/// No rounding changes the energy by a larger part of the kinetic energy in a step of chosen length.
const LARGEST_ROUNDING: f64 = 1e-6;
/// A step in which contacts slide may always be off by this part.
const OFF: f64 = 1e-8;
/// Such a step has no truncation if it is shorter than this (s).
const SHORT: f64 = 1e-5;
/// Energies are not known better than to this part of them.
const ROUNDED: f64 = 1e-14;
/// Given steps are made shorter if more than this part is unaccounted for, and more than this part of the friction loss. A step that cannot follow a
/// slip or a jam is off by about the friction loss. Truncation errors are far smaller.
const OFF_GIVEN: f64 = 1e-6;
const OFF_FRICTION: f64 = 1e-4;
/// If all contacts stick, they take no energy. A given step is then made shorter if it is off by more than this part of the largest kinetic energy.
const OFF_STUCK: f64 = 1e-4;

impl Eventful {
    /// Whether the energy of the step to this end is off balance, or friction gives energy. If all contacts stick, only a given step that is far off
    /// counts; without contacts only one to an event, or a very short one, near a gimbal lock.
    pub(super) fn is_off_balance(&self, inputs: Inputs, end: &State, ending: &Ending, exchange: &Exchange) -> bool {
        let length = end.time - self.trial.origin.time;
        let (flies, sticks) = (self.mode.contacts.is_empty(), !self.slides());
        let tolerance = self.model.recipe.tolerance();
        let asked =
            if flies { matches!(ending, Ending::AtEvent(_)) || length <= JAM } else { !sticks || tolerance.is_none() };
        if length <= 0.0 || !asked {
            return false;
        }
        let (before, after) = (energy(&self.model.whole, &self.trial.origin), energy(&self.model.whole, end));
        let largest = self.memory.kinetic.max(before.kinetic).max(after.kinetic);
        let off = (after.total() - before.total() + exchange.lost()).abs();
        let by_share = |tolerance: f64| (SHARE * tolerance).max(LARGEST_ROUNDING) * largest;
        if flies {
            return off > by_share(tolerance.unwrap_or(0.0)) && self.starts_singular();
        }
        let most = match tolerance {
            // A body that begins to move has a tiny kinetic energy: roundings are small beside the work that forces do over its size.
            _ if sticks => {
                OFF_STUCK * largest + OFF * self.pushes(inputs, end) * size(&self.model.whole, &self.trial.origin)
            }
            _ if length <= JAM => OFF * largest,
            Some(tolerance) => {
                let truncated = by_share(tolerance).min(tolerance.max(OFF) * largest);
                let jammed = if length <= SHORT { exchange.friction.abs() } else { f64::INFINITY };
                truncated.min(jammed.max(OFF * largest))
            }
            None => (OFF_GIVEN * largest).max(OFF_FRICTION * exchange.friction.abs()),
        };
        // One that slides without friction may not move at all: its energy has the roundings of its weight.
        let rounded = |off: f64| {
            let turned = self.pushes(inputs, end) * size(&self.model.whole, &self.trial.origin);
            off <= ROUNDED * (before.total().abs() + turned)
        };
        off > most && !rounded(off) || exchange.friction < -OFF * largest
    }

    /// Sum of the sizes of all forces [N or N m].
    fn pushes(&self, inputs: Inputs, end: &State) -> f64 {
        let Piece { moving, small, .. } = self.workspaces.active();
        let driving = self.mode.driving_efforts(&self.model.elements, inputs, end);
        let efforts = driving.iter().map(|effort| effort.abs()).sum();
        Pushes::of(&moving.mechanism).with(energy(&moving.mechanism, small).spring, efforts)
    }
}
