//! Contacts that go on with other features where they pass a border of theirs.
//!
//! ```text
//!     n' − n:   a step ends up to δ = 1.2e-11 ℓ beyond the border, where the normal over an edge has turned by δ/r
//!     rest':    max(rest, 2 |γ' − γ|)           γ, γ' [m/s]: rates of the gap over the features before and after
//! ```
//!
//! ℓ (m): size of the larger shape, r (m): radius of the rounded one. A ball that rolls over the edge of a table would leave it at γ' = u δ/r, and come
//! back to it in an impact.
//!
//! A contact at another place does not go on from one: a capsule that lands flat passes the border of the cone of normals at its end, and meets the ground
//! with its side at the same instant.

use crate::events::effects::contacts::Contacts;
use crate::events::effects::decision::Scene;
use crate::events::finding::watched::Watched;
use crate::events::modes::mode::{Closed, Mode};
use crate::instant::holding::touching::Contact;
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::motion::touches::touch_motion;

/// Normals that differ by more than this belong to a real corner.
const SMOOTH: f64 = 1e-6;
/// Points that are farther apart than this part of the size of the larger shape are different places. Beyond a border by δ the point of a rim is √(δ/r) farther
/// along it, 3.5e-6.
const SAME_PLACE: f64 = 1e-4;

impl Contacts {
    /// Takes contacts of a pair that are near now, each with its number in the mode before where it was closed there, after events of these functions.
    pub(super) fn take_near(
        &mut self,
        scene: &Scene,
        before: &Mode,
        pair: usize,
        near: Vec<Contact>,
        triggers: &[Watched],
        bodies: &[BodyState],
    ) {
        let closed = || before.contacts.iter().enumerate().filter(|(_, closed)| closed.contact.pair == pair);
        // An edge crosses a rim at two places that have the same features.
        let place = |contact: &Contact| touch_motion(&contact.joint, bodies).point;
        for contact in near {
            let same = closed().filter(|(_, closed)| closed.contact.features == contact.features);
            let apart = |closed: &Closed| (place(&closed.contact) - place(&contact)).norm();
            let known = same.min_by(|(_, one), (_, other)| apart(one).total_cmp(&apart(other)));
            if known.is_none() {
                let passed = closed().filter(|&(index, _)| triggers.contains(&Watched::Feature(index)));
                let size = scene.touching.pairs[pair].extents.larger;
                let rest = passed.filter_map(|(_, closed)| self.goes_on([&closed.contact, &contact], size, bodies));
                let rest = rest.reduce(f64::max);
                self.gone_on.extend(rest.map(|rest| (contact.clone(), rest)));
            }
            self.known.push(known.map(|(index, _)| index));
            self.all.push(contact);
        }
    }

    /// Whether a contact of a pair with this size (m) goes on from one that was closed, and the speed that counts as rest for it then [m/s].
    fn goes_on(&self, [before, contact]: [&Contact; 2], size: f64, bodies: &[BodyState]) -> Option<f64> {
        let [old, new] = [before, contact].map(|contact| touch_motion(&contact.joint, bodies));
        let here = (new.point - old.point).norm() <= SAME_PLACE * size;
        let goes_on = here && (new.normal - old.normal).norm() <= SMOOTH;
        goes_on.then(|| self.rest.max(2.0 * (new.rate - old.rate).abs()))
    }

    /// Slower than this is rest for a contact [m/s].
    pub(super) fn rest_of(&self, contact: &Contact) -> f64 {
        let own = self.gone_on.iter().find(|(of, _)| of.is_at(contact));
        own.map_or(self.rest, |&(_, rest)| rest.max(self.rest))
    }
}
