//! Starts near one that is wedged: shapes between others cannot be moved apart by small motions from there, and often can from beside it.
//!
//! ```text
//!     q_k = q ⊕ r 1.15^k ξ_k,   ξ_k in [−1, 1]ⁿ,   k = 0, 1, …        r = 0.02 rad or m, up to 0.5
//! ```
//!
//! ξ_k are the same on every machine. The nearest of these starts from which shapes come apart is taken.

use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::state::State;

/// The first reach (rad, m), the factor between one and the next, and their number.
const FIRST: f64 = 0.02;
const FARTHER: f64 = 1.15;
const STARTS: usize = 24;
/// Scenes with many freedoms have fewer: this many divided by their freedoms, and one at least.
const FEW: usize = 1000;

/// Starts beside one, nearer ones first.
pub(super) fn beside<'a>(mechanism: &'a Mechanism, wanted: &'a State) -> impl Iterator<Item = State> + 'a {
    let freedoms = mechanism.velocity_count;
    let starts = (FEW / freedoms.max(1)).clamp(1, STARTS);
    let mut bits = 1_u64;
    let mut signed = move || {
        bits = bits.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        2.0 * (bits >> 11) as f64 / (1_u64 << 53) as f64 - 1.0
    };
    (0..starts).map(move |start| {
        let reach = FIRST * FARTHER.powi(start as i32);
        let change: Vec<f64> = (0..freedoms).map(|_| reach * signed()).collect();
        let mut state = wanted.clone();
        state.displace(mechanism, &change);
        state
    })
}
