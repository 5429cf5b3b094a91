//! Contacts that go on with other features where they pass a border of theirs.
//!
//! ```text
//!     n' − n:   a step ends up to δ = 1.2e-11 ℓ beyond the border, where the normal over an edge has turned by δ/r
//!     rest':    max(rest, 2 |γ' − γ|)           γ, γ' [m/s]: rates of the gap over the features before and after
//! ```
//!
//! ℓ (m): size of the larger shape, r (m): radius of the rounded one. A ball that rolls over the edge of a table would leave it at γ' = u δ/r, and come
//! back to it in an impact.

use crate::events::effects::contacts::Contacts;
use crate::instant::holding::touching::Contact;
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::motion::touches::touch_motion;

/// Normals that differ by more than this belong to a real corner.
const SMOOTH: f64 = 1e-6;

impl Contacts {
    /// Whether a contact goes on from one that was closed, and the speed that counts as rest for it then [m/s].
    pub(super) fn goes_on(&self, contact: &Contact, before: &Contact, bodies: &[BodyState]) -> Option<f64> {
        let [old, new] = [before, contact].map(|contact| touch_motion(&contact.joint, bodies));
        let goes_on = (new.normal - old.normal).norm() <= SMOOTH;
        goes_on.then(|| self.rest.max(2.0 * (new.rate - old.rate).abs()))
    }

    /// Slower than this is rest for a contact [m/s].
    pub(super) fn rest_of(&self, contact: &Contact) -> f64 {
        let own = self.gone_on.iter().find(|(of, _)| of.pair == contact.pair && of.features == contact.features);
        own.map_or(self.rest, |&(_, rest)| rest.max(self.rest))
    }
}
