//! Projects velocities so that the rates along given rows are zero: elements that touch come to rest.
//!
//! ```text
//!     minimise ½ dvᵀ H dv   subject to  W (v + dv) = 0          dv = Y Wᵀ P,   D P = −W v
//!
//!     of joints S in a tree, F the other freedoms:               dv_S = v_S⁺ − v_S,   H_FF dv_F = −H_FS dv_S        v_S⁺ = 0
//! ```
//!
//! Rates along the tangents of belts are rates of slips: bodies at rest on a belt move with it.
//!
//! Rows that loops hold take no part: `D_ii <= 1e-13 W_i H⁻¹ W_iᵀ` is rounding.
//!
//! Near gimbal lock D is a difference of large numbers, and the second form is taken, which has no such difference. It is needed if the first one
//! leaves rates or gains energy.

use crate::events::effects::decision::Scene;
use crate::events::effects::immobile::{ROUNDING, response_of_tree};
use crate::instant::cone::bounded::minimise;
use crate::instant::cone::least_norm::least_norm;
use crate::instant::dynamics::mass_matrix::mass_matrix;
use crate::instant::holding::blocks::{Row, Rows};
use crate::instant::holding::elements::{ElementJoint, Elements};
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::forces::total::powers;
use crate::mechanism::motion::energy::{Energy, energy_with_forces};
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use nalgebra::{DMatrix, DVector};

/// Rates that are left beyond this part of the largest are not at rest.
const LEFT: f64 = 1e-7;
/// An answer of a row below this part of the largest may be a rounding.
const SUSPECT: f64 = 1e-9;

/// The energy of a state (J).
pub(crate) fn energy(mechanism: &Mechanism, state: &State) -> Energy {
    energy_with_forces(mechanism, &state.position, &body_states(mechanism, state))
}

/// The work of forces without a potential in a short step (s) through a state, which has the rates of the step (J).
pub(crate) fn work_of_forces(mechanism: &Mechanism, state: &State, step: f64) -> f64 {
    step * powers(mechanism, state.time, &state.velocity, &body_states(mechanism, state)).work
}

/// Takes from the velocities what a state has more than it had before it was moved (J); returns the energy that this has taken in all (J).
pub(crate) fn keep_from_gaining(scene: &Scene, state: &mut State, before: f64) -> f64 {
    let after = energy(scene.whole, state);
    let gained = after.total() - before;
    if gained > 0.0 && after.kinetic > 0.0 {
        let factor = (1.0 - gained / after.kinetic).max(0.0).sqrt();
        state.velocity.iter_mut().for_each(|rate| *rate *= factor);
    }
    before - energy(scene.whole, state).total()
}

/// The freedoms of the joints that friction or limits may hold and that do not move.
pub(crate) fn joints_at_rest(elements: &Elements, state: &State) -> Vec<usize> {
    let is_held = |joint: &ElementJoint| joint.friction > 0.0 || joint.side(joint.position(state)).is_some();
    let at_rest = elements.joints.iter().filter(|joint| joint.rate(state) == 0.0 && is_held(joint));
    at_rest.map(|joint| joint.coordinate.freedom).collect()
}

/// Velocities without rates along some rows, with the least change in the metric of the mass matrix; returns the energy that this takes (J).
pub(crate) fn bring_rows_to_rest(scene: &mut Scene, state: &mut State, rows: Vec<Row>) -> f64 {
    let rows = Rows::new(scene.response, state, rows);
    let rows = without_rounded(scene, state, rows);
    if rows.rows().is_empty() {
        return 0.0;
    }
    let rates = rows.rates(&state.velocity);
    let unbounded = vec![(f64::NEG_INFINITY, f64::INFINITY); rates.len()];
    let impulses = minimise(&rows.square, &rates, &unbounded).efforts;
    let before = state.velocity.clone();
    rows.add(&impulses, &mut state.velocity);
    if let Some(joints) = joints_of_tree(scene.whole, rows.rows()) {
        let most = LEFT * before.iter().fold(0.0_f64, |most, rate| most.max(rate.abs()));
        if !joints.iter().all(|&freedom| state.velocity[freedom].abs() <= most) {
            state.velocity.copy_from_slice(&before);
            return bring_joints_to_rest(scene.whole, state, &joints);
        }
    }
    let taken: f64 = impulses.iter().zip(&rates).map(|(impulse, rate)| -0.5 * rate * impulse).sum();
    taken - rows.work_of_belts(&impulses)
}

/// The rows but those that loops hold: their answers are roundings of those without closures, and an impulse that is to take a rounding from their rates
/// moves the rest of the loop by anything.
fn without_rounded(scene: &mut Scene, state: &State, rows: Rows) -> Rows {
    let (whole, answers) = (scene.whole, rows.square.diagonal());
    if whole.loops.is_empty() || answers.iter().all(|answer| *answer > SUSPECT * answers.max()) {
        return rows;
    }
    let free = Rows::new(&mut response_of_tree(whole), state, rows.rows().to_vec()).square.diagonal();
    let moves = |row: &usize| answers[*row] > ROUNDING * free[*row];
    let kept: Vec<Row> = (0..answers.len()).filter(moves).map(|row| rows.rows()[row].clone()).collect();
    if kept.len() == answers.len() { rows } else { Rows::new(scene.response, state, kept) }
}

/// The freedoms of the rows, if each row belongs to one joint of a tree; otherwise `None`.
fn joints_of_tree(whole: &Mechanism, rows: &[Row]) -> Option<Vec<usize>> {
    if whole.has_closures() {
        return None;
    }
    let of = |row: &Row| {
        let mut own = row.iter().enumerate().filter(|(_, entry)| **entry != 0.0).map(|(freedom, _)| freedom);
        own.next().filter(|_| own.next().is_none())
    };
    rows.iter().map(of).collect()
}

/// Brings joints of a tree to rest by the mass matrix; returns the energy that this takes (J).
pub(crate) fn bring_joints_to_rest(whole: &Mechanism, state: &mut State, joints: &[usize]) -> f64 {
    let rates: Vec<(usize, f64)> = joints.iter().map(|&joint| (joint, 0.0)).collect();
    give_rates(whole, state, &rates)
}

/// Gives joints of a tree, by their freedoms, these rates; all others change by the least motion in the metric of the mass matrix, as after impulses
/// along these joints alone. Returns the energy that this takes (J).
pub(crate) fn give_rates(whole: &Mechanism, state: &mut State, rates: &[(usize, f64)]) -> f64 {
    let mass = mass_matrix(whole, state);
    let before = energy(whole, state).kinetic;
    let given = |freedom: usize| rates.iter().any(|(joint, _)| *joint == freedom);
    let others: Vec<usize> = (0..mass.nrows()).filter(|freedom| !given(*freedom)).collect();
    if !others.is_empty() {
        // To a unit diagonal, so that units and light links do not count.
        let unit =
            |freedom: usize| if mass[(freedom, freedom)] > 0.0 { 1.0 / mass[(freedom, freedom)].sqrt() } else { 0.0 };
        let units: Vec<f64> = others.iter().map(|&freedom| unit(freedom)).collect();
        let entry = |row: usize, column: usize| mass[(others[row], others[column])] * units[row] * units[column];
        let square = DMatrix::from_fn(others.len(), others.len(), entry);
        // −H_FS dv_S = H_FS (v_S − v_S⁺).
        let held = |row: usize| -> f64 {
            rates.iter().map(|&(joint, rate)| mass[(others[row], joint)] * (state.velocity[joint] - rate)).sum()
        };
        let right = DVector::from_fn(others.len(), |row, _| units[row] * held(row));
        if let Some((change, _)) = least_norm(&square, &right) {
            let changes = others.iter().zip(change.iter().zip(&units));
            changes.for_each(|(&freedom, (change, unit))| state.velocity[freedom] += unit * change);
        }
    }
    rates.iter().for_each(|&(joint, rate)| state.velocity[joint] = rate);
    before - energy(whole, state).kinetic
}
