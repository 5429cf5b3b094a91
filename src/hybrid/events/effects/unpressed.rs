//! Contacts of an event that touch only once others have come to rest, and contacts that touch without pressure: between closed ones, or kept by loops.
//!
//! ```text
//!     joins:      φ ≤ 1e-11 of its size and γ ≤ rest, after the gaps and rates of the other contacts have become zero
//!     unpressed:  a candidate that is open, its gap implied by closed contacts, while friction follows their pressures
//! ```
//!
//! A box whose corners clatter lands on three of them within one instant. The fourth is then at zero by the places of the others, although it was
//! further away when contacts were looked for. It bears its share of the load as the others do.

use crate::events::effects::contacts::Contacts;
use crate::events::effects::decision::{Candidate, Scene};
use crate::events::effects::memory::Found;
use crate::events::finding::watched::Watched;
use crate::events::forces::returning::shares;
use crate::events::modes::mode::{Closed, Mode};
use crate::instant::holding::kept_by_loops::kept_by_loops;
use crate::instant::holding::touching::{Contact, TOUCHED};
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use crate::mechanism::motion::touches::touch_motion;
use std::collections::BTreeSet;

impl Contacts {
    /// Leaves out the contacts whose gaps loops alone keep: they take no part in impacts and decisions.
    pub fn leave_out_kept(&mut self, scene: &mut Scene, state: &State) {
        let kept = kept_by_loops(scene.whole, scene.response, state, &self.all, self.rest);
        self.kept = self.take_out(|number| kept[number]);
        self.gathered = self.all.len();
    }

    /// Adds the contacts that did not press before an event and still touch: if one of them opens because it does not press either, the others stay open.
    /// Contacts of pairs that return or are looked at anew are decided with the others.
    pub(super) fn take_unpressed(&mut self, scene: &Scene, before: &Mode, found: &Found, bodies: &[BodyState]) {
        if found.anew {
            return;
        }
        let returns = |pair: usize| {
            found.triggers.iter().any(|trigger| match *trigger {
                Watched::Returns(number) => before.unpressed[number].pair == pair,
                _ => false,
            })
        };
        for contact in &before.unpressed {
            let within = scene.touching.pairs[contact.pair].within(TOUCHED);
            let touches = || touch_motion(&contact.joint, bodies).gap.abs() <= within;
            if !returns(contact.pair) && !self.all.iter().any(|known| known.is_at(contact)) && touches() {
                self.known.push(None);
                self.all.push(contact.clone());
                self.unpressed.push(contact.clone());
            }
        }
    }

    /// Adds contacts of pairs at rest that touch now and do not move; false if there are none. Flat ends choose their points in other ways.
    pub fn join_touching(&mut self, scene: &Scene, state: &State) -> bool {
        let flat: BTreeSet<usize> =
            self.all.iter().filter(|contact| contact.flat_end().is_some()).map(|contact| contact.pair).collect();
        let pairs = self.candidates.iter().map(|candidate| candidate.contact.pair);
        let pairs: BTreeSet<usize> = pairs.filter(|pair| !flat.contains(pair)).collect();
        let bodies = body_states(scene.whole, state);
        let before = self.all.len();
        for pair in pairs {
            let of = &scene.touching.pairs[pair];
            if of.has_one_place() {
                continue;
            }
            for (contact, _) in scene.touching.near(pair, &bodies, of.within(TOUCHED)) {
                let mut known = self.all.iter().chain(&self.seams).chain(&self.kept);
                let is_there = known.any(|other| other.is_at(&contact));
                let rate = touch_motion(&contact.joint, &bodies).rate;
                if contact.flat_end().is_none() && rate.abs() <= self.rest && !is_there {
                    self.known.push(None);
                    self.all.push(contact);
                }
            }
        }
        self.leave_out_seams(scene.touching, &bodies, before);
        self.all.len() > before
    }
}

/// The candidates that are open in a mode although closed contacts keep their gaps at zero, if friction slides and so follows the pressures.
pub(crate) fn unpressed(scene: &mut Scene, state: &State, mode: &Mode, candidates: &[Candidate]) -> Vec<Contact> {
    let Scene { whole, touching, response, .. } = scene;
    let rubs = |pair: usize| touching.pairs[pair].friction > 0.0;
    let slides = |closed: &Closed| closed.slides.is_some() && rubs(closed.contact.pair);
    let closed = |contact: &Contact| mode.contacts.iter().any(|closed| closed.contact == *contact);
    let open = candidates.iter().map(|candidate| &candidate.contact).filter(|contact| {
        let beside = |closed: &Closed| slides(closed) && closed.contact.joint.shares_a_body(&contact.joint);
        rubs(contact.pair)
            && contact.flat_end().is_none()
            && !contact.joint.is_reeved()
            && !closed(contact)
            && mode.contacts.iter().any(beside)
    });
    let open: Vec<&Contact> = open.collect();
    if open.is_empty() {
        return Vec::new();
    }
    let bodies = body_states(whole, state);
    let held = mode.contacts.iter().map(|closed| &closed.contact.joint);
    let shares = shares(whole, response, state, &bodies, held, open.iter().map(|contact| &contact.joint));
    open.into_iter().zip(shares).filter(|(_, share)| share.is_some()).map(|(contact, _)| contact.clone()).collect()
}
