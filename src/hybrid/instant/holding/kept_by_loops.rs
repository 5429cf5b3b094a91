//! Contacts whose gaps loops alone keep as they are: a roller of a scissor lift that glides along a table, the end of a rod whose slider is parallel to it.
//!
//! ```text
//!     kept:   W Y Wᵀ ≤ 1e-12 |W|⁴/(W H Wᵀ)  and  |φ̇| ≤ rest,  here and a little further along the motion that loops allow
//! ```
//!
//! W is the row of the normal, Y the answer with closures; a tree answers with `W H⁻¹ Wᵀ ≥ |W|⁴/(W H Wᵀ)`. The row is a sum of rows of the loops, so that
//! rigid bodies do not tell how much the contact presses, and no impulse at it changes anything. At a dead point a row is such a sum in one place alone: a
//! little further on the contact answers.
//!
//! Gaps and closures are analytic functions: a gap that loops keep near a state they keep until the mechanism comes to a place where its branches meet.

use crate::instant::dynamics::response::Response;
use crate::instant::holding::blocks::{Row, Rows, rows_of_contact};
use crate::instant::holding::touching::Contact;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::distance::size;
use crate::mechanism::motion::energy::energy;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use crate::mechanism::motion::touches::touch_motion;

/// Answers below this part of the answers of a tree are roundings; loops in place give 1e-28 of them. It is the square of a slope of 1e-6.
const ROUNDING: f64 = 1e-12;
/// How far bodies go along the motion that loops allow, as a part of the size of the mechanism. It opens the loops by the square of this part, and the
/// answer of a kept row is its fourth power; the answer after a dead point is its square.
const FURTHER: f64 = 1e-4;

/// Which of some contacts loops keep as they are; `rest` is the fastest rate that counts as rest [m/s].
pub(crate) fn kept_by_loops(
    whole: &Mechanism,
    response: &mut Response,
    state: &State,
    contacts: &[Contact],
    rest: f64,
) -> Vec<bool> {
    let mut kept = vec![false; contacts.len()];
    if !whole.has_closures() || contacts.is_empty() {
        return kept;
    }
    if whole.moves_joints() {
        // A motion in time may press contacts together later that it keeps now.
        let mut loops = whole.clone();
        loops.mimics.retain(|mimic| !mimic.is_moved());
        return kept_by_loops(&loops, &mut Response::new(&loops), state, contacts, rest);
    }
    let bodies = body_states(whole, state);
    let is_still = |contact: &Contact| touch_motion(&contact.joint, &bodies).rate.abs() <= rest;
    kept.iter_mut().zip(contacts).for_each(|(kept, contact)| *kept = is_still(contact));
    leave_answering(whole, response, state, contacts, &mut kept);
    if kept.contains(&true) {
        let further = further(whole, response, state);
        leave_answering(whole, response, &further, contacts, &mut kept);
    }
    kept
}

/// Leaves the kept contacts whose answers in a state are roundings.
fn leave_answering(whole: &Mechanism, response: &mut Response, state: &State, contacts: &[Contact], kept: &mut [bool]) {
    let bodies = body_states(whole, state);
    let numbers: Vec<usize> = (0..kept.len()).filter(|&number| kept[number]).collect();
    let normal = |&number: &usize| rows_of_contact(whole, &bodies, &contacts[number].joint, false);
    let rows: Vec<Row> = numbers.iter().flat_map(normal).collect();
    let least: Vec<f64> = rows.iter().map(|row| least_of_tree(whole, state, row)).collect();
    let answers = Rows::new(response, state, rows).square.diagonal();
    for ((&number, answer), least) in numbers.iter().zip(answers.iter()).zip(least) {
        kept[number] = *answer <= ROUNDING * least;
    }
}

/// |W|⁴/(W H Wᵀ), in which the rates Wᵀ have the energy of the denominator; below zero for a row without entries, which no loop holds.
fn least_of_tree(whole: &Mechanism, state: &State, row: &Row) -> f64 {
    let square: f64 = row.iter().map(|entry| entry * entry).sum();
    let moves = State { velocity: row.to_vec(), ..state.clone() };
    let twice = 2.0 * energy(whole, &body_states(whole, &moves)).kinetic;
    if twice > 0.0 { square * square / twice } else { -1.0 }
}

/// A state a little further along a motion that closures allow: the answer to efforts of which no two are alike.
fn further(whole: &Mechanism, response: &mut Response, state: &State) -> State {
    let efforts: Vec<f64> = (0..whole.velocity_count).map(|freedom| 1.0 + 0.37 * (freedom as f64).sqrt()).collect();
    let answer = Rows::new(response, state, vec![efforts.into()]);
    let mut moves = State { velocity: answer.columns().column(0).iter().copied().collect(), ..state.clone() };
    let fastest = body_states(whole, &moves).iter().map(|body| body.velocity.norm()).fold(0.0, f64::max);
    if fastest > 0.0 {
        let factor = FURTHER * size(whole, state) / fastest;
        let change: Vec<f64> = moves.velocity.iter().map(|rate| factor * rate).collect();
        moves.displace(whole, &change);
    }
    State { velocity: state.velocity.clone(), ..moves }
}
