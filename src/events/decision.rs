//! What joints at rest do next: which of them are held, by friction or on a limit, and which way the others go.
//!
//! All joints whose rate is zero and that have friction or are on a limit are decided together, at the level of accelerations:
//!
//! ```text
//!     a = b + D λ,   b = W a_free,  D = W Y Wᵀ            a_free under all efforts but λ; friction that slides is among them
//!     λ_i ∈ [lo_i, hi_i]:   a_i = 0 inside,  a_i ≥ 0 at lo_i,  a_i ≤ 0 at hi_i           (the box of `mode`)
//! ```
//!
//! A joint with `a_i = 0` is held; one with `a_i > 0` goes forward with friction `−τ_f = lo_i` against it, or leaves its lower limit. With closures
//! whatever can then not move any more is held, too, so that what is left has no closure that says nothing.
//!
//! Source: Ch. Glocker, Set-Valued Force Laws, Springer 2001, chapter 9.

use crate::events::mode::{JointMode, Mode};
use crate::instant::bounded::minimise;
use crate::instant::elements::Elements;
use crate::instant::response::Response;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::state::State;
use nalgebra::DMatrix;

/// Accelerations below this part of their terms are zero.
const ROUNDING: f64 = 1e-10;
/// And so are those below this part of the largest of all, and of one unit.
const DIFFERENCE: f64 = 1e-14;
/// The part by which a joint that has been seen to reach the end of what holds it is held less.
const LESS: f64 = 1e-9;
/// A freedom that answers to an effort with less than this part of its free answer cannot move.
const IMMOBILE: f64 = 1e-10;

/// What has been seen to reach its end.
#[derive(Clone, Debug, Default)]
pub(crate) struct Yielding {
    /// Joints at an end of the efforts that can hold them, and the direction in which they go.
    pub joints: Vec<(usize, i8)>,
    /// All held joints together.
    pub all: bool,
}

/// Decides the joints whose rate is zero; `efforts` are those from outside and of motors.
pub(crate) fn decide(
    elements: &Elements,
    mode: &mut Mode,
    response: &mut Response,
    state: &State,
    efforts: &[f64],
    yielding: &Yielding,
) {
    let mut undecided = Vec::new();
    let mut efforts = efforts.to_vec();
    for (index, joint) in elements.joints.iter().enumerate() {
        let (rate, side) = (joint.rate(state), joint.side(joint.position(state)));
        let goes = yielding.joints.iter().find(|(yields, _)| *yields == index).map(|(_, direction)| *direction);
        let goes = if rate != 0.0 { Some(rate.signum() as i8) } else { goes };
        mode.joints[index] = if let Some(direction) = goes {
            let sliding = if joint.friction > 0.0 { direction } else { 0 };
            efforts[joint.coordinate.freedom] -= f64::from(sliding) * joint.friction;
            JointMode::Free { sliding }
        } else if joint.friction > 0.0 || side.is_some() {
            undecided.push(index);
            JointMode::Held { on: side }
        } else {
            JointMode::Free { sliding: 0 }
        };
    }
    if undecided.is_empty() {
        return;
    }
    let freedoms: Vec<usize> = undecided.iter().map(|&index| elements.joints[index].coordinate.freedom).collect();
    let mut free = vec![0.0; state.velocity.len()];
    response.accelerations(state, &efforts, &mut free);
    let (_, square) = response.matrix(state, &freedoms);
    let offset: Vec<f64> = freedoms.iter().map(|&freedom| free[freedom]).collect();
    let load: Vec<f64> =
        (0..freedoms.len()).map(|row| offset[row].abs() / square[(row, row)].max(f64::MIN_POSITIVE)).collect();
    let bounds: Vec<(f64, f64)> = undecided
        .iter()
        .zip(&load)
        .map(|(&index, load)| {
            let (low, high) = mode.joints[index].holding(&elements.joints[index]);
            let less = if yielding.all { LESS * elements.joints[index].friction.max(*load) } else { 0.0 };
            let less = less.min(0.25 * (high - low));
            if low.is_finite() || high.is_finite() { (low + less, high - less) } else { (low, high) }
        })
        .collect();
    let found = minimise(&square, &offset, &bounds);
    // Each acceleration is a difference of others.
    let largest = free.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    for (row, &index) in undecided.iter().enumerate() {
        let joint = &elements.joints[index];
        let terms: f64 = (0..freedoms.len()).map(|column| (square[(row, column)] * found.efforts[column]).abs()).sum();
        let moves = found.at[row] != 0
            && found.rest[row].abs() > ROUNDING * (terms + offset[row].abs()) + DIFFERENCE * (1.0 + largest);
        if moves && !joint.is_locked() {
            let sliding = if joint.friction > 0.0 { found.rest[row].signum() as i8 } else { 0 };
            mode.joints[index] = JointMode::Free { sliding };
        }
    }
}

/// For each body whether it is held: its joint is, or cannot move because others are.
pub(crate) fn held_bodies(
    whole: &Mechanism,
    elements: &Elements,
    mode: &Mode,
    response: &mut Response,
    state: &State,
) -> Vec<bool> {
    let mut held = mode.held_bodies(elements, whole.bodies.len());
    // What follows a joint is held with it; loops may hold more.
    if whole.loops.is_empty() || !held.contains(&true) {
        return held;
    }
    let rows: Vec<usize> = (0..whole.bodies.len())
        .filter(|&body| held[body])
        .map(|body| whole.bodies[body].joint.velocity_index)
        .collect();
    let (columns, square) = response.matrix(state, &rows);
    let inverse = pseudo_inverse(&square);
    let single = |body: &usize| !held[*body] && whole.bodies[*body].joint.velocity_range().len() == 1;
    let others: Vec<usize> = (0..whole.bodies.len()).filter(single).collect();
    let freedom = |body: usize| whole.bodies[body].joint.velocity_index;
    let answers = response.diagonal(state, others.iter().map(|&body| freedom(body)));
    for (&body, answer) in others.iter().zip(answers) {
        // Y_ii − Y_iS (Y_SS)⁺ Y_Si: what is left of the answer.
        let row = columns.row(freedom(body));
        let taken = (row * &inverse * row.transpose())[(0, 0)];
        held[body] = answer - taken <= IMMOBILE * answer;
    }
    held
}

/// The Moore–Penrose inverse of a positive semidefinite matrix, whatever the units of its rows.
fn pseudo_inverse(square: &DMatrix<f64>) -> DMatrix<f64> {
    let count = square.nrows();
    let inverse: Vec<f64> =
        (0..count).map(|row| if square[(row, row)] > 0.0 { 1.0 / square[(row, row)].sqrt() } else { 0.0 }).collect();
    let scaled = DMatrix::from_fn(count, count, |row, column| square[(row, column)] * inverse[row] * inverse[column]);
    let eigen = scaled.symmetric_eigen();
    let largest = eigen.eigenvalues.max();
    let mut sum = DMatrix::zeros(count, count);
    for (index, &value) in eigen.eigenvalues.iter().enumerate() {
        if value > IMMOBILE * largest {
            let vector = eigen.eigenvectors.column(index);
            sum += vector * vector.transpose() / value;
        }
    }
    DMatrix::from_fn(count, count, |row, column| sum[(row, column)] * inverse[row] * inverse[column])
}
