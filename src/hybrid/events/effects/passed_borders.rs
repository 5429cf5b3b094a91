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
use crate::instant::holding::touching::Contact;
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::motion::touches::touch_motion;

/// Normals that differ by more than this belong to a real corner.
const SMOOTH: f64 = 1e-6;
/// Points that are farther apart than this part of the size of the larger shape are different places. Beyond a border by δ the point of a rim is √(δ/r) farther
/// along it, 3.5e-6.
const SAME_PLACE: f64 = 1e-4;

impl Contacts {
    /// Whether a contact of a pair with this size (m) goes on from one that was closed, and the speed that counts as rest for it then [m/s].
    pub(super) fn goes_on(&self, [before, contact]: [&Contact; 2], size: f64, bodies: &[BodyState]) -> Option<f64> {
        let [old, new] = [before, contact].map(|contact| touch_motion(&contact.joint, bodies));
        let here = (new.point - old.point).norm() <= SAME_PLACE * size;
        let goes_on = here && (new.normal - old.normal).norm() <= SMOOTH;
        goes_on.then(|| self.rest.max(2.0 * (new.rate - old.rate).abs()))
    }

    /// Slower than this is rest for a contact [m/s].
    pub(super) fn rest_of(&self, contact: &Contact) -> f64 {
        let own = self.gone_on.iter().find(|(of, _)| of.pair == contact.pair && of.features == contact.features);
        own.map_or(self.rest, |&(_, rest)| rest.max(self.rest))
    }
}
