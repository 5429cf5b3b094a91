//! Starts without overlap: shapes that start inside each other are moved apart, by the least motion.
//!
//! ```text
//!     minimise ½ dqᵀ H dq   subject to  φ + W dq ≥ 0,  J dq = 0          dq = Y Wᵀ r,   0 ≤ r ⊥ D r + φ ≥ 0
//! ```
//!
//! with the gaps φ of all contacts that are near, their rows W and `D = W Y Wᵀ` ([`crate::instant::blocks`]), and limits of joints that are met; repeated with the new gaps
//! to, until nothing overlaps by more than rounding.

use crate::instant::blocks::{Rows, row_of_freedom, rows_of_contact};
use crate::instant::cone::bounded::minimise;
use crate::instant::response::Response;
use crate::instant::touching::Touching;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;

/// Largest number of rounds.
const ROUNDS: usize = 60;
/// What may be left of an overlap, as a part of the size of a pair.
const APART: f64 = 1e-14;
/// Contacts of a pair that overlaps are near if their gaps are less than this part of its size.
const NEAR: f64 = 0.1;
/// Largest change of a freedom in one round (rad, m).
const REACH: f64 = 0.2;

/// The pair that overlaps most, and by how much (m); none if nothing does.
pub(crate) fn deepest(touching: &Touching, mechanism: &Mechanism, state: &State) -> Option<(usize, f64)> {
    let bodies = body_states(mechanism, state);
    let depth = |pair: usize| (pair, -touching.distance(pair, &bodies));
    let overlaps =
        (0..touching.pairs.len()).map(depth).filter(|&(pair, depth)| depth > APART * touching.pairs[pair].size);
    overlaps.max_by(|one, other| one.1.total_cmp(&other.1))
}

/// Makes one round: moves a state so that what overlaps would not, were its gaps linear. Says whether anything was moved.
pub(crate) fn move_apart(
    touching: &Touching,
    mechanism: &Mechanism,
    response: &mut Response,
    state: &mut State,
) -> bool {
    let bodies = body_states(mechanism, state);
    let (mut rows, mut gaps) = (Vec::new(), Vec::new());
    for (pair, size) in touching.pairs.iter().map(|pair| pair.size).enumerate() {
        if touching.distance(pair, &bodies) > NEAR * size {
            continue;
        }
        for (contact, gap) in touching.near(pair, &bodies, NEAR * size) {
            rows.extend(rows_of_contact(mechanism, &bodies, &contact.joint, false));
            gaps.push(gap);
        }
    }
    if gaps.iter().all(|gap| *gap >= 0.0) {
        return false;
    }
    for limit in &mechanism.nonsmooth.limits {
        let position = state.position[limit.coordinate.position];
        for (sign, room) in [(1.0, position - limit.lower), (-1.0, limit.upper - position)] {
            if room.is_finite() {
                rows.push(row_of_freedom(mechanism.velocity_count, limit.coordinate.freedom, sign));
                gaps.push(room);
            }
        }
    }
    let rows = Rows::new(response, state, rows);
    let pushes = minimise(&rows.square, &gaps, &vec![(0.0, f64::INFINITY); gaps.len()]).efforts;
    let mut change = vec![0.0; mechanism.velocity_count];
    rows.add(&pushes, &mut change);
    let largest = change.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    if largest > REACH {
        change.iter_mut().for_each(|value| *value *= REACH / largest);
    }
    state.displace(mechanism, &change);
    true
}

/// A pair that overlaps, by its number, and by how much (m); none if nothing does.
pub(crate) type Overlap = Option<(usize, f64)>;

/// Moves a state apart; `close` brings it back on what else has to hold. Says which pair overlapped most, and which still does.
pub(crate) fn without_overlap<E>(
    mechanism: &Mechanism,
    state: &mut State,
    mut close: impl FnMut(&mut State) -> Result<(), E>,
) -> Result<(Overlap, Overlap), E> {
    let touching = Touching::new(mechanism);
    if touching.pairs.is_empty() {
        return Ok((None, None));
    }
    let named = |(pair, depth): (usize, f64)| (touching.pairs[pair].number, depth);
    let first = deepest(&touching, mechanism, state).map(named);
    let mut response = None;
    for _ in 0..ROUNDS {
        if deepest(&touching, mechanism, state).is_none() {
            return Ok((first, None));
        }
        let response = response.get_or_insert_with(|| Response::new(mechanism));
        if !move_apart(&touching, mechanism, response, state) {
            break;
        }
        close(state)?;
    }
    let left = deepest(&touching, mechanism, state);
    let left = left.filter(|&(pair, depth)| depth > 1e-12 * touching.pairs[pair].size);
    Ok((first, left.map(named)))
}
