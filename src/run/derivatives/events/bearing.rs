//! The forces of closed contacts at an instant, and their slips, with derivatives.
//!
//! ```text
//!     λ_N, λ_T    multipliers of accelerations ([`crate::derivatives::events::instant::Accelerations`]), along n and across it
//!     u_T · t₀    t₀: direction of the slip at the start of the step
//! ```

use crate::derivatives::equations::closed::{ClosedTouch, across};
use crate::derivatives::equations::residual::still;
use crate::derivatives::events::instant::Accelerations;
use crate::derivatives::events::watched::Sight;
use crate::derivatives::forward::step::Part;
use crate::derivatives::numbers::number::Number;
use crate::derivatives::numbers::vector::Vector;

/// The force of a contact on its second body.
pub(super) struct Bearing {
    pub normal: Part,
    /// In the world.
    pub across: Vector<Part>,
}

impl Sight<'_> {
    /// The force of a closed contact, by its number in the mode; `None` if the forces of contacts are not unique.
    pub(super) fn bearing(&self, contact: usize) -> Option<Bearing> {
        let closed = self.at.closed;
        if self.equations.rows.len() != self.equations.row_count {
            return None;
        }
        let (_, multipliers) = self.accelerations()?;
        let touches = multipliers.len() - closed.touch_rows();
        let mimics = self.at.figures.plain.mimics.len();
        let before = &self.mode.contacts[..contact];
        let touch = self.touch_of(contact)?;
        let placed = self.at.at_rest();
        let found = touch.at(&placed);
        if self.mode.is_anchored(&self.mode.contacts[contact]) {
            let own = before.iter().filter(|closed| self.mode.is_anchored(closed)).count();
            let first = touches - mimics - 3 * (closed.anchors.len() - own);
            let force = Vector([0, 1, 2].map(|axis: usize| multipliers[first + axis]));
            return Some(Bearing { normal: found.normal.dot(force), across: across(found.normal, force) });
        }
        let own = before.iter().filter(|closed| !self.mode.is_anchored(closed)).count();
        let first = touches + closed.touches[..own].iter().map(ClosedTouch::rows).sum::<usize>();
        let own = &closed.touches[own];
        let force = own.force(&self.at.placed(self.velocities), &multipliers[first..first + own.rows()]).force;
        Some(Bearing { normal: multipliers[first], across: across(found.normal, force) })
    }

    /// `u_T · t₀` of a closed contact.
    pub(super) fn slip_along(&self, contact: usize) -> Option<Part> {
        let touch = self.touch_of(contact)?;
        let placed = self.at.placed(self.velocities);
        let found = touch.at(&still(&placed));
        let slip = across(found.normal, touch.slip(&placed, found.point));
        Some(slip.dot(Vector::of(self.equations.slips.get(contact)?)))
    }

    /// The mean of the slips of the contacts of a pair that slide.
    pub(super) fn slip_of_pair(&self, pair: usize) -> Option<Part> {
        let own = self.mode.contacts.iter().enumerate();
        let own = own.filter(|(_, closed)| closed.contact.pair == pair && closed.slides.is_some());
        let slips = own.map(|(contact, _)| self.slip_along(contact)).collect::<Option<Vec<Part>>>()?;
        let count = slips.len() as f64;
        Some(slips.into_iter().fold(Part::zero(), |sum, slip| sum + slip).times(1.0 / count))
    }

    /// The remaining friction of a contact that sticks: `μ λ_N − |λ_T|`.
    pub(super) fn grip(&self, contact: usize) -> Option<Part> {
        let Bearing { normal, across } = self.bearing(contact)?;
        let friction = self.at.figures.laws.pairs[self.mode.contacts[contact].contact.pair].friction;
        Some(friction * normal - across.dot(across).square_root())
    }

    /// a and λ with their derivatives.
    pub(super) fn accelerations(&self) -> Option<(Vec<Part>, Vec<Part>)> {
        let values = |parts: &[Part]| -> Vec<f64> { parts.iter().map(|part| part.value).collect() };
        let found = self.accelerations.get_or_init(|| {
            let mut state = self.at.state.clone();
            state.velocity = values(self.velocities);
            Accelerations::of(self.constant, &state, self.equations, &values(self.efforts))
        });
        found.as_ref()?.varied(&self.at, self.equations, self.velocities, self.efforts)
    }
}
