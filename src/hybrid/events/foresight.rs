//! A mode that is seen to last, by the multipliers of the step that was made: the forces of its contacts are not worked out anew.
//!
//! ```text
//!     step with three stages ─▶ its forces are calm ─▶ their signs are not looked for, and a tick at its end leaves the mode as it is
//!                                          not calm ─▶ forces from the states at its ends, and after the tick
//! ```
//!
//! What counts as calm is in [`crate::events::forces::foreseen`].

use crate::events::finding::watched::Watched;
use crate::events::integrator::Eventful;
use crate::events::modes::instants::Inside;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::state::State;
use crate::mechanism::motion::touches::touch_motion;

impl Eventful {
    /// Looks at the forces of the closed contacts in the step that was made on contacts without moments whose forces are unique.
    pub(super) fn see_forces(&mut self) {
        let contacts = self.mode.contacts.len();
        let plain = self.model.whole.loops.is_empty() && self.has_plain_contacts();
        if contacts == 0 || !plain || !self.trial.holding.is_unique() {
            return;
        }
        let piece = self.workspaces.active();
        let reduced = &piece.moving.mechanism;
        let anchors = self.mode.contacts.iter().filter(|closed| self.mode.is_anchored(closed)).count();
        if reduced.loops.len() != anchors || reduced.touches.len() != contacts - anchors {
            return;
        }
        let end = piece.small.time;
        self.place(Inside::at(end));
        let Eventful { workspaces, trial, mode, model, .. } = self;
        let Some(steps) = workspaces.active().steps.as_ref() else { return };
        // Anchors are loops, and come first.
        let mode = &*mode;
        let order = [true, false].into_iter().flat_map(|anchored| {
            mode.contacts.iter().enumerate().filter(move |(_, closed)| mode.is_anchored(closed) == anchored)
        });
        let order = order.map(|(number, closed)| {
            let friction = closed.slides.is_none().then(|| model.touching.pairs[closed.contact.pair].friction);
            (number, touch_motion(&closed.contact.joint, &trial.bodies).normal.into(), friction)
        });
        trial.holding.foreseen.see(contacts, end, |forces| steps.closure_forces(forces), order);
        for (number, closed) in mode.contacts.iter().enumerate() {
            if trial.fresh_pairs.holds(closed.contact.pair) {
                trial.holding.foreseen.forget(number);
            }
        }
    }

    /// Whether no contact is a rope, or has rolling or spinning friction.
    fn has_plain_contacts(&self) -> bool {
        let plain = |pair: usize| {
            let pair = &self.model.touching.pairs[pair];
            !pair.is_reeved() && pair.moments.are_zero()
        };
        self.mode.contacts.iter().all(|closed| plain(closed.contact.pair))
    }

    /// Whether a function is known to stay positive over the step.
    pub(super) fn is_foreseen(&self, watched: Watched) -> bool {
        match watched {
            Watched::Presses(contact) => self.trial.holding.foreseen.is_calm(contact, false),
            Watched::Grips(contact) => self.trial.holding.foreseen.is_calm(contact, true),
            _ => false,
        }
    }

    /// Whether the mode is known to go on under constant efforts that have jumped at the end of a step.
    pub(super) fn is_foreseen_to_go_on(&mut self, inputs: Inputs, state: &State) -> bool {
        let forces = self.trial.watched.iter().filter(|watched| watched.needs_efforts());
        let sticks = self.mode.contacts.iter().all(|closed| closed.slides.is_none());
        if !sticks || inputs.feedback.is_some() || !self.trial.holding.foreseen.holds_all_at(state.time) {
            return false;
        }
        if !forces.clone().all(|watched| matches!(watched, Watched::Presses(_) | Watched::Grips(_))) {
            return false;
        }
        let Eventful { trial, mode, model, .. } = self;
        inputs.write_constant(&mut trial.efforts);
        mode.add_constant_efforts(&model.elements, &mut trial.efforts);
        let friction = mode.contacts.iter().map(|closed| model.touching.pairs[closed.contact.pair].friction);
        trial.holding.foreseen.takes(state, &trial.efforts, friction)
    }
}
