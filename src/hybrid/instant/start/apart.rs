//! Starts without overlap: shapes that start inside each other are moved apart, by the least motion.
//!
//! ```text
//!     minimise ½ dqᵀ H dq   subject to  φ + W dq ≥ 0,  J dq = 0          dq = Y Wᵀ r,   0 ≤ r ⊥ D r + φ ≥ 0
//! ```
//!
//! with the gaps φ of all contacts that are near, their rows W and `D = W Y Wᵀ` (as in [`crate::instant::holding::blocks`]), and limits of joints; repeated
//! with the new gaps until every overlap is rounding. Hundreds of vertices may be near, and a few of them push: rows are taken into the problem one
//! by one, the most violated first, until all are satisfied (a cutting-plane method). Of two hulls with many vertices only a few places are asked for, the
//! deepest among them: where they are deep inside each other, each vertex of one is near each face of the other.
//!
//! Source: J. E. Kelley, The cutting-plane method for solving convex programs, Journal of the SIAM 8 (1960).

use crate::instant::cone::bounded::minimise;
use crate::instant::dynamics::response::Response;
use crate::instant::holding::blocks::{Row, row_of_force, row_of_freedom, rows_of_contact};
use crate::instant::holding::near::Near;
use crate::instant::holding::touching::Touching;
use crate::instant::start::wedged::beside;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use nalgebra::{DMatrix, DVector};

/// Largest number of rounds.
const ROUNDS: usize = 60;
/// Overlaps up to this part of the size of a pair may remain.
const APART: f64 = 1e-14;
/// Contacts of a pair that overlaps are near if their gaps are less than this part of its size,
const NEAR: f64 = 0.1;
/// a little less than this part of the reaches of its bodies,
const NEARER: f64 = 0.11;
/// and less than this many times the deepest overlap: to move apart by a rounding, features of dense hulls a tenth of their size apart do not matter.
const MOVES: f64 = 100.0;
/// Gaps of the linear problem above minus this part of the deepest overlap are closed.
const CLOSED: f64 = 1e-13;
/// Rows that are taken into the problem of one round: of shapes deep inside each other hundreds push, and the rounds that follow take the others.
const TAKEN: usize = 48;
/// Largest change of a freedom in one round (rad, m).
const REACH: f64 = 0.2;
/// An overlap below this part of the size of a pair that remains is rounding.
const LEFT: f64 = 1e-12;

/// The pair that overlaps most, and its overlap (m); `None` without overlaps.
pub(crate) fn deepest(touching: &Touching, mechanism: &Mechanism, state: &State) -> Option<(usize, f64)> {
    let bodies = body_states(mechanism, state);
    let depth = |pair: usize| (pair, -touching.distance_within(pair, &bodies, 0.0));
    let near = Near::within(&touching.pairs, &bodies, |_| 0.0);
    let all = near.pairs().iter().copied().map(depth);
    let overlaps = all.filter(|&(pair, depth)| depth > touching.pairs[pair].within(APART));
    overlaps.max_by(|one, other| one.1.total_cmp(&other.1))
}

/// Makes one round: moves a state with this deepest overlap (m) so that no shapes would overlap, were its gaps linear. Says whether anything was moved.
pub(crate) fn move_apart(
    touching: &Touching,
    mechanism: &Mechanism,
    response: &mut Response,
    state: &mut State,
    depth: f64,
) -> bool {
    let bodies = body_states(mechanism, state);
    let (mut rows, mut gaps) = (Vec::new(), Vec::new());
    let pairs = &touching.pairs;
    let all = Near::within(pairs, &bodies, |body| NEARER * pairs.reach_of(body));
    for &pair in all.pairs() {
        let near = pairs[pair].within(NEAR).min(MOVES * depth);
        let distance = touching.distance_within(pair, &bodies, near);
        if distance > near {
            continue;
        }
        let mut deepest = 0.0_f64;
        for (contact, gap) in touching.a_few_near(pair, &bodies, near) {
            rows.extend(rows_of_contact(mechanism, &bodies, &contact.joint, false));
            gaps.push(gap);
            deepest = deepest.min(gap);
        }
        // Points on its rim stand for a flat end that is tilted by less than 1e-9 rad, and what is between them may be deeper.
        if distance < deepest - pairs[pair].within(APART) {
            let nearest = touching.nearest(pair, &bodies);
            let middle = 0.5 * (nearest.points[0] + nearest.points[1]);
            rows.push(row_of_force(mechanism, &bodies, pairs[pair].bodies, &middle, &nearest.normal));
            gaps.push(distance);
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
    let columns = response.answers(state, &rows);
    let entries: Vec<Vec<(usize, f64)>> = rows.iter().map(Row::acting).collect();
    let answer = |row: usize, column: usize| {
        entries[row].iter().map(|&(freedom, entry)| entry * columns[(freedom, column)]).sum::<f64>()
    };
    // Symmetric to the last bit.
    let column_of = |column: usize| {
        let mean = |row: usize| 0.5 * (answer(row, column) + answer(column, row));
        (0..rows.len()).map(|row| if row == column { answer(row, row) } else { mean(row) }).collect()
    };
    let pushes = least_pushes(column_of, &gaps);
    let mut change: Vec<f64> = (&columns * DVector::from_vec(pushes)).iter().copied().collect();
    let largest = change.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    if largest > REACH {
        change.iter_mut().for_each(|value| *value *= REACH / largest);
    }
    state.displace(mechanism, &change);
    true
}

/// The least pushes r ≥ 0 with `D r + φ ≥ 0`, of which the columns of D are made that are asked for: of thousands of rows a few push.
fn least_pushes(column_of: impl Fn(usize) -> Vec<f64>, gaps: &[f64]) -> Vec<f64> {
    let deepest = gaps.iter().fold(0.0_f64, |most, gap| most.max(-gap));
    let mut left = gaps.to_vec();
    let mut pushes = vec![0.0; gaps.len()];
    let mut taken: Vec<usize> = Vec::new();
    let mut columns: Vec<Vec<f64>> = Vec::new();
    loop {
        let violated = (0..gaps.len()).filter(|row| left[*row] < -CLOSED * deepest && !taken.contains(row));
        let next = violated.min_by(|&one, &other| left[one].total_cmp(&left[other]));
        let Some(next) = next.filter(|_| taken.len() < TAKEN) else { return pushes };
        taken.push(next);
        columns.push(column_of(next));
        let of = |row: usize, column: usize| columns[column][taken[row]];
        let own: Vec<f64> = taken.iter().map(|&row| gaps[row]).collect();
        let only_away = vec![(0.0, f64::INFINITY); taken.len()];
        let found = minimise(&DMatrix::from_fn(taken.len(), taken.len(), of), &own, &only_away).efforts;
        left.copy_from_slice(gaps);
        for ((&row, column), &push) in taken.iter().zip(&columns).zip(&found) {
            pushes[row] = push;
            left.iter_mut().zip(column).for_each(|(left, mobility)| *left += mobility * push);
        }
    }
}

/// How far a state may be moved to put it apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reach {
    /// A start: where small motions do not do, from beside it.
    Beside,
    /// The end of a step: by small motions alone.
    Nearby,
}

/// A pair that overlaps, by its number, and its overlap (m); `None` without overlaps.
pub(crate) type Overlap = Option<(usize, f64)>;

/// Moves a state apart; `close` brings it back on what else has to hold, if that is possible. One that is wedged is moved apart from beside it, if it may go
/// there. Says which pair overlapped most, and which still does: that one, too, where a loop holds shapes inside each other, so that it cannot be closed
/// again.
pub(crate) fn without_overlap(
    mechanism: &Mechanism,
    state: &mut State,
    reach: Reach,
    mut close: impl FnMut(&mut State) -> bool,
) -> (Overlap, Overlap) {
    let touching = Touching::new(mechanism);
    if touching.pairs.is_empty() {
        return (None, None);
    }
    let named = |(pair, depth): (usize, f64)| (touching.pairs[pair].number, depth);
    let Some(first) = deepest(&touching, mechanism, state) else { return (None, None) };
    let wanted = state.clone();
    let mut response = Response::new(mechanism);
    let mut left = |state: &mut State, close: &mut dyn FnMut(&mut State) -> bool| match in_rounds(
        &touching,
        mechanism,
        &mut response,
        state,
        close,
    ) {
        Ok(left) => left.filter(|&(pair, depth)| depth > touching.pairs[pair].within(LEFT)),
        Err(Unclosed) => Some(first),
    };
    let Some(wedged) = left(state, &mut close) else { return (Some(named(first)), None) };
    if reach == Reach::Nearby {
        return (Some(named(first)), Some(named(wedged)));
    }
    let moved = state.clone();
    for beside in beside(mechanism, &wanted) {
        state.copy_from(&beside);
        if close(state) && left(state, &mut close).is_none() {
            return (Some(named(first)), None);
        }
    }
    state.copy_from(&moved);
    (Some(named(first)), Some(named(wedged)))
}

/// What else has to hold does not hold near.
struct Unclosed;

/// Moves a state apart in rounds; returns the pair that overlaps most after them, by its place in the list, and its overlap (m).
fn in_rounds(
    touching: &Touching,
    mechanism: &Mechanism,
    response: &mut Response,
    state: &mut State,
    close: &mut dyn FnMut(&mut State) -> bool,
) -> Result<Option<(usize, f64)>, Unclosed> {
    for _ in 0..ROUNDS {
        let Some((_, depth)) = deepest(touching, mechanism, state) else { return Ok(None) };
        if !move_apart(touching, mechanism, response, state, depth) {
            break;
        }
        if !close(state) {
            return Err(Unclosed);
        }
    }
    Ok(deepest(touching, mechanism, state))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instant::cone::scenes::Random;

    #[test]
    fn rows_taken_one_by_one_are_pushed_as_all_rows_together() {
        let mut random = Random::new(2);
        for round in 0..50 {
            // Forty near vertices of a body that moves freely: rows n_k with n_z > 0, six freedoms.
            let rows = DMatrix::from_fn(40, 6, |_, freedom| if freedom == 2 { 1.0 } else { random.signed() });
            let square = &rows * rows.transpose();
            let gaps: Vec<f64> = (0..40).map(|_| 0.1 * random.signed()).collect();
            let all = minimise(&square, &gaps, &vec![(0.0, f64::INFINITY); 40]).efforts;
            let motion = |pushes: Vec<f64>| rows.transpose() * nalgebra::DVector::from_vec(pushes);
            // The least motion is unique, whatever the pushes; both have it to rounding.
            let difference = (motion(all)
                - motion(least_pushes(|column| square.column(column).iter().copied().collect(), &gaps)))
            .amax();
            assert!(difference < 1e-11, "round {round}: {difference:e}");
        }
    }
}
