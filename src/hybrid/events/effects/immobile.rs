//! Elements that cannot move by themselves because joints and contacts are held: bodies, and pairs that touch without pressing.
//!
//! ```text
//!     left of the answer of a freedom i, or of a normal i, beside held rows S:    Y_ii − Y_iS (Y_SS)⁺ Y_Si
//! ```
//!
//! If the rest is at most 1e-10 of Y_ii, the held rows determine the freedom. At a dead point of a loop the freedom turns round and moves on. Y_ii
//! without held rows is zero there, a rounding of H⁻¹_ii, the answer without closures, and decides no freedom. Contacts that stick have dead points, too:
//! a freedom that they determine is asked once more in a state beside, and is not held if it moves there. A pair is idle if held rows keep its
//! gap at zero and it does not press. An example is a wheel that touches a floor while its axle stands on the other wheel. Its gap has the roundings
//! of the held gaps.

use crate::events::effects::decision::{Candidate, Scene};
use crate::events::effects::shared_loads::shared_with_braked;
use crate::events::modes::mode::{Closed, JointMode, Mode};
use crate::instant::cone::apart::parts_of;
use crate::instant::dynamics::response::Response;
use crate::instant::holding::blocks::{Row, Rows, least_answer, row_of_freedom, row_of_torque, rows_of_contact};
use crate::instant::holding::elements::Elements;
use crate::instant::holding::touching::Touching;
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::contact::TouchJoint;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use crate::mechanism::motion::touches::{tangents, touch_motion};
use nalgebra::{DMatrix, DMatrixView, DVector};
use std::iter::successors;

/// A freedom that answers to an effort with less than this part of its free answer cannot move.
const IMMOBILE: f64 = 1e-10;
/// How far a state is displaced for a look beside a dead point (rad, m), and the largest part of a motion of one that counts as none.
const ASIDE: f64 = 1e-3;
const FREE: f64 = 1e-6;
/// An answer below this part of that without closures is rounding.
pub(crate) const ROUNDING: f64 = 1e-13;

/// The pairs of candidates without a closed contact in a mode, whose gaps its held joints and closed contacts keep as they are.
pub fn idle_pairs(scene: &mut Scene, state: &State, mode: &Mode, candidates: &[Candidate]) -> Vec<usize> {
    let Scene { whole, elements, response, .. } = scene;
    let closed = |pair: usize| mode.contacts.iter().any(|closed| closed.contact.pair == pair);
    let open: Vec<&Candidate> = candidates.iter().filter(|candidate| !closed(candidate.contact.pair)).collect();
    if open.is_empty() || mode.contacts.is_empty() {
        return Vec::new();
    }
    let bodies = body_states(whole, state);
    let held = elements.joints.iter().zip(&mode.joints).filter(|(_, mode)| matches!(mode, JointMode::Held { .. }));
    let mut rows: Vec<Row> =
        held.map(|(joint, _)| row_of_freedom(whole.velocity_count, joint.coordinate.freedom, 1.0)).collect();
    for closed in &mode.contacts {
        rows.extend(rows_of_contact(whole, &bodies, &closed.contact.joint, closed.slides.is_none()));
        rows.extend(rows_of_held_turns(whole, &bodies, closed));
    }
    let count = rows.len();
    rows.extend(open.iter().flat_map(|candidate| rows_of_contact(whole, &bodies, &candidate.contact.joint, false)));
    let square = Rows::new(response, state, rows).square;
    let inverse = pseudo_inverse(&square.view((0, 0), (count, count)).into_owned());
    let mut idle = Vec::new();
    for (index, candidate) in open.iter().enumerate() {
        let (own, pair) = (count + index, candidate.contact.pair);
        let row = square.view((own, 0), (1, count));
        if !idle.contains(&pair) && cannot_move(square[(own, own)], row, &inverse) {
            idle.push(pair);
        }
    }
    idle
}

/// For each body whether it is held: its joint is, or cannot move because others are. Where friction brakes by the forces with which contacts hold a body, it
/// is not: its motors and its weight give these forces.
pub(crate) fn held_bodies(
    whole: &Mechanism,
    elements: &Elements,
    touching: &Touching,
    mode: &Mode,
    response: &mut Response,
    state: &State,
) -> Vec<bool> {
    let mut held = mode.held_bodies(elements, whole.bodies.len());
    // A body that a belt or a joint that is moved in time carries is not at rest.
    let carries =
        |joint: &TouchJoint| joint.is_belt() || [&joint.a, &joint.b].iter().any(|end| is_moved(whole, end.body));
    let sticks = |closed: &Closed| closed.slides.is_none() && !carries(&closed.contact.joint);
    let mut holding: Vec<usize> = (0..mode.contacts.len()).filter(|&number| sticks(&mode.contacts[number])).collect();
    if !holding.is_empty() {
        let shared = shared_with_braked(whole, elements, touching, mode, response, state);
        holding.retain(|&number| !shared[number]);
    }
    let sticks = !holding.is_empty();
    // Joints that follow a held joint are held with it; loops and contacts may hold more.
    if !(sticks || (held.contains(&true) && !whole.loops.is_empty())) {
        return held;
    }
    let joints = (0..whole.bodies.len()).filter(|&body| held[body]);
    let joints: Vec<usize> = joints.flat_map(|body| whole.bodies[body].joint.velocity_range()).collect();
    let contacts: Vec<&Closed> = holding.into_iter().map(|number| &mode.contacts[number]).collect();
    let rows_at = |state: &State| {
        let mut rows: Vec<Row> =
            joints.iter().map(|&freedom| row_of_freedom(whole.velocity_count, freedom, 1.0)).collect();
        if sticks {
            let bodies = body_states(whole, state);
            for closed in &contacts {
                rows.extend(rows_of_contact(whole, &bodies, &closed.contact.joint, true));
                rows.extend(rows_of_held_turns(whole, &bodies, closed));
            }
        }
        rows
    };
    let rows = Rows::new(response, state, rows_at(state));
    let inverse = pseudo_inverse(&rows.square);
    let rest = |body: &usize| !held[*body] && (sticks || whole.bodies[*body].joint.velocity_range().len() == 1);
    let others: Vec<usize> = (0..whole.bodies.len()).filter(rest).collect();
    let mut immobile = immobile_among(whole, response, state, others, &rows, &inverse);
    // Contacts that stick have dead points, too: a freedom that they hold here alone moves on.
    if sticks
        && whole.loops.is_empty()
        && let Some(beside) = beside(whole, state, &rows, &inverse, &immobile)
    {
        let bodies: Vec<usize> = immobile.iter().map(|(body, _)| *body).collect();
        let rows = Rows::new(response, &beside, rows_at(&beside));
        let inverse = pseudo_inverse(&rows.square);
        let there = immobile_among(whole, response, &beside, bodies, &rows, &inverse);
        immobile.retain(|(body, _)| there.iter().any(|(other, _)| other == body));
    }
    immobile.iter().for_each(|(body, _)| held[*body] = true);
    let answers: Vec<(usize, f64)> = immobile.into_iter().flat_map(|(_, answers)| answers).collect();
    for freedom in rounded(whole, state, &answers) {
        whole.body_of_freedom(freedom).into_iter().for_each(|body| held[body] = false);
    }
    held
}

/// The bodies whose freedoms are all determined by held rows in a state, each with its freedoms and their answers `Y_ii`.
fn immobile_among(
    whole: &Mechanism,
    response: &mut Response,
    state: &State,
    bodies: Vec<usize>,
    rows: &Rows,
    inverse: &DMatrix<f64>,
) -> Vec<(usize, Vec<(usize, f64)>)> {
    let range = |body: usize| whole.bodies[body].joint.velocity_range();
    let mut answers = response.diagonal(state, bodies.iter().flat_map(|&body| range(body))).into_iter();
    let determined = |&(freedom, answer): &(usize, f64)| {
        cannot_move(answer, rows.columns().view((freedom, 0), (1, inverse.ncols())), inverse)
    };
    let all = bodies.into_iter().map(|body| (body, range(body).zip(answers.by_ref()).collect::<Vec<_>>()));
    all.filter(|(_, own)| own.iter().all(determined)).collect()
}

/// A state beside this one: a motion without a preferred direction leads there, which held rows leave free. `None` if no row has both a freedom that
/// moves and one of an immobile body: the rows of immobile bodies are the same there.
///
/// ```text
///     q ⊕ ε x,    x = r − Y Wᵀ (Y_SS)⁺ W r,    r_i = sin(1.7 i + 0.4)
/// ```
fn beside(
    whole: &Mechanism,
    state: &State,
    rows: &Rows,
    inverse: &DMatrix<f64>,
    immobile: &[(usize, Vec<(usize, f64)>)],
) -> Option<State> {
    if immobile.is_empty() {
        return None;
    }
    let mut motion: Vec<f64> = (0..state.velocity.len()).map(|freedom| (1.7 * freedom as f64 + 0.4).sin()).collect();
    let along = DVector::from_vec(rows.rates(&motion));
    let pushes = -(inverse * along);
    rows.add(pushes.as_slice(), &mut motion);
    let holds = |row: &Row| immobile.iter().flat_map(|(_, own)| own).any(|(freedom, _)| row[*freedom] != 0.0);
    let moves = |row: &Row| row.iter().zip(&motion).any(|(entry, rate)| *entry != 0.0 && rate.abs() > FREE);
    if !rows.rows().iter().any(|row| holds(row) && moves(row)) {
        return None;
    }
    let mut beside = state.clone();
    beside.displace(whole, &motion.iter().map(|value| ASIDE * value).collect::<Vec<f64>>());
    Some(beside)
}

/// Whether a joint above a body, or its own, is moved in time.
fn is_moved(whole: &Mechanism, body: Option<usize>) -> bool {
    let moved = |body: usize| whole.mimics.iter().any(|mimic| mimic.is_moved() && mimic.follower.body == body);
    whole.moves_joints() && successors(body, |&body| whole.bodies[body].parent).any(moved)
}

/// The rows of the turnings that rolling and spinning friction hold at a closed contact.
fn rows_of_held_turns(whole: &Mechanism, bodies: &[BodyState], closed: &Closed) -> Vec<Row> {
    if closed.moments.rows() == 0 {
        return Vec::new();
    }
    let joint = TouchJoint { moments: closed.moments, ..closed.contact.joint.clone() };
    let normal = touch_motion(&joint, bodies).normal;
    let held = joint.held_turns(&normal, &tangents(&normal));
    held.map(|along| row_of_torque(whole, bodies, &joint, &along)).collect()
}

/// The freedoms among these that are at dead points of loops in a state.
pub(crate) fn at_dead_points(
    whole: &Mechanism,
    response: &mut Response,
    state: &State,
    freedoms: &[usize],
) -> Vec<usize> {
    if freedoms.is_empty() || whole.loops.is_empty() {
        return Vec::new();
    }
    let answers = response.diagonal(state, freedoms.iter().copied());
    rounded(whole, state, &freedoms.iter().copied().zip(answers).collect::<Vec<_>>())
}

/// The freedoms whose answers are roundings of those without closures: they are at dead points.
fn rounded(whole: &Mechanism, state: &State, answers: &[(usize, f64)]) -> Vec<usize> {
    if answers.is_empty() || !whole.has_closures() {
        return Vec::new();
    }
    let of_tree = answers_of_tree(whole, state, answers.iter().map(|(freedom, _)| *freedom));
    let dead = answers.iter().zip(of_tree).filter(|((_, answer), free)| *answer <= ROUNDING * free);
    dead.map(|((freedom, _), _)| *freedom).collect()
}

/// `H⁻¹_ii` of freedoms: their answers without closures.
pub(crate) fn answers_of_tree(whole: &Mechanism, state: &State, freedoms: impl Iterator<Item = usize>) -> Vec<f64> {
    response_of_tree(whole).diagonal(state, freedoms)
}

/// The response without closures.
pub(crate) fn response_of_tree(whole: &Mechanism) -> Response {
    let mut open = whole.clone();
    open.loops.clear();
    open.mimics.clear();
    Response::new(&open)
}

/// Whether an answer Y_ii vanishes beside held rows, with `row` = Y_iS and `inverse` = (Y_SS)⁺.
fn cannot_move(answer: f64, row: DMatrixView<f64>, inverse: &DMatrix<f64>) -> bool {
    let felt: Vec<(usize, f64)> = row.iter().copied().enumerate().filter(|(_, entry)| *entry != 0.0).collect();
    let along = |&(one, entry): &(usize, f64)| {
        entry * felt.iter().map(|&(other, entry)| inverse[(one, other)] * entry).sum::<f64>()
    };
    let taken: f64 = felt.iter().map(along).sum();
    answer - taken <= IMMOBILE * answer
}

/// The Moore–Penrose inverse of a positive semidefinite matrix, whatever the units of its rows: part by part of those that zeros keep apart, as of
/// bodies that stand beside each other. A row along which nothing moves but for roundings holds nothing.
fn pseudo_inverse(square: &DMatrix<f64>) -> DMatrix<f64> {
    let count = square.nrows();
    let least = least_answer(square);
    let scale = |own: f64| if own > least { 1.0 / own.sqrt() } else { 0.0 };
    let inverse: Vec<f64> = (0..count).map(|row| scale(square[(row, row)])).collect();
    let parts = parts_of(square);
    let scaled = |part: &[usize]| {
        let entry = |row: usize, column: usize| square[(row, column)] * inverse[row] * inverse[column];
        DMatrix::from_fn(part.len(), part.len(), |row, column| entry(part[row], part[column])).symmetric_eigen()
    };
    let eigen: Vec<_> = parts.iter().map(|part| scaled(part)).collect();
    let largest = eigen.iter().map(|own| own.eigenvalues.max()).fold(0.0, f64::max);
    let mut found = DMatrix::zeros(count, count);
    for (part, own) in parts.iter().zip(&eigen) {
        let mut sum = DMatrix::zeros(part.len(), part.len());
        for (index, &value) in own.eigenvalues.iter().enumerate() {
            if value > IMMOBILE * largest {
                let vector = own.eigenvectors.column(index);
                sum += vector * vector.transpose() / value;
            }
        }
        for (one, &row) in part.iter().enumerate() {
            for (other, &column) in part.iter().enumerate() {
                found[(row, column)] = sum[(one, other)] * inverse[row] * inverse[column];
            }
        }
    }
    found
}
