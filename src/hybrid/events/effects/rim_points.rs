//! Points that flat ends lack in an impact or a decision, round after round until the answer is right for the discs (`flat_ends.rs`).
//!
//! ```text
//!     points ─▶ law ─▶ the disc goes below its plane at θ ─▶ points + θ − what was added before and carries nothing ─▶ law ─▶ …
//! ```
//!
//! The lowest θ is halfway between two points that press: each round halves that angle, so that some fifteen rounds are as exact as laws are solved.

use crate::events::effects::contacts::Contacts;
use crate::events::effects::decision::{Candidate, Decided, Scene};
use crate::events::effects::flat_ends::Asked;
use crate::events::effects::turnings::turning_faster;
use crate::events::modes::tolerances::SLIPS_TOGETHER;
use crate::instant::holding::touching::Contact;
use crate::mechanism::description::contact::TouchJoint;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use crate::mechanism::motion::touches::{tangents, touch_accelerations, touch_motion};
use nalgebra::Vector3;

/// Points of a flat end whose gaps fall with less than this part of the largest acceleration do not: laws are solved to 1e-10.
const LOWEST: f64 = 1e-9;

impl Contacts {
    /// Adds the points that flat ends lack after an impact, in a round; `holding` are the normal impulses that would hold all, `found` the normal
    /// impulses of the impact. Returns whether points were added.
    pub fn complete_impact(
        &mut self,
        scene: &Scene,
        state: &State,
        holding: &[f64],
        found: &[f64],
        round: usize,
    ) -> bool {
        let bodies = body_states(scene.whole, state);
        let value = |joint: &TouchJoint| touch_motion(joint, &bodies).rate;
        let asked =
            Asked { touching: scene.touching, bodies: &bodies, value, least: -self.rest, round, pressed: false };
        let lacking = asked.lacking(&self.all.iter().collect::<Vec<_>>(), holding);
        if lacking.is_empty() {
            return false;
        }
        let idle = self.idle(&lacking, self.all.iter().zip(found));
        self.exchange(&idle, lacking);
        true
    }

    /// Adds the points that flat ends lack that have been decided to stay, in a round; the first round asks for the points towards the centres of
    /// pressure in any case. Returns whether points were added.
    pub fn complete_decision(&mut self, scene: &Scene, state: &State, decided: &Decided, round: usize) -> bool {
        if !self.candidates.iter().any(|candidate| candidate.contact.flat_end().is_some()) {
            return false;
        }
        let bodies = body_states(scene.whole, state);
        let accelerations = decided.of_bodies(scene.whole, state, &bodies);
        let largest = decided.accelerations.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        // A flat end that has begun to tilt touches at one point, whatever its accelerations.
        let value = |joint: &TouchJoint| {
            let touch = touch_motion(joint, &bodies);
            let tilts = touch.rate.abs() > SLIPS_TOGETHER * self.rest;
            if tilts { 0.0 } else { touch_accelerations(joint, &bodies, &accelerations, &tangents(&touch.normal))[0] }
        };
        let least = -LOWEST * (scene.whole.gravity.norm() + largest).max(f64::MIN_POSITIVE);
        let asked = Asked { touching: scene.touching, bodies: &bodies, value, least, round, pressed: round == 0 };
        let contacts: Vec<&Contact> = self.candidates.iter().map(|candidate| &candidate.contact).collect();
        let mut lacking = asked.lacking(&contacts, &decided.holding);
        // Points that part are no candidates, as in [`Contacts::come_to_rest`].
        lacking.retain(|contact| touch_motion(&contact.joint, &bodies).rate <= self.rest);
        if lacking.is_empty() {
            return false;
        }
        let idle = self.idle(&lacking, contacts.into_iter().zip(&decided.pressures));
        self.candidates.retain(|candidate| !idle.contains(&candidate.contact));
        for contact in &lacking {
            let own = |candidate: &&Candidate| candidate.contact.pair == contact.pair;
            let slips = self.candidates.iter().filter(own).any(|candidate| candidate.slip != Vector3::zeros());
            let slip = if slips { touch_motion(&contact.joint, &bodies).slip } else { Vector3::zeros() };
            let turning = turning_faster(scene, &bodies, contact, [self.rest; 2]);
            let (contact, turns) = (contact.clone(), [false; 2]);
            self.candidates.push(Candidate { contact, slip, slides: false, opens: false, turning, turns });
        }
        self.exchange(&idle, lacking);
        true
    }

    /// The added points without a normal force, on ends that lack points now.
    fn idle<'c>(&self, lacking: &[Contact], forces: impl Iterator<Item = (&'c Contact, &'c f64)>) -> Vec<Contact> {
        let added = |contact: &Contact| self.all[self.gathered..].contains(contact);
        let lacks = |contact: &Contact| lacking.iter().any(|new| new.flat_end() == contact.flat_end());
        let idle = forces.filter(|(contact, force)| **force == 0.0 && lacks(contact) && added(contact));
        idle.map(|(contact, _)| contact.clone()).collect()
    }

    /// Removes points that have been added before, and adds others; the mode before has no numbers for the added points.
    fn exchange(&mut self, idle: &[Contact], lacking: Vec<Contact>) {
        let added = self.all.split_off(self.gathered);
        self.all.extend(added.into_iter().filter(|contact| !idle.contains(contact)).chain(lacking));
        self.known.resize(self.gathered, None);
        self.known.resize(self.all.len(), None);
    }
}
