//! Contacts that friction holds and whose forces decide how much friction brakes: they share a load with a contact that is braked, or are braked themselves.
//!
//! ```text
//!     zᵀ W = 0,   W: rows of held joints and of closed contacts      rows i, j share a load if some projector part (Z Zᵀ)_ij of such z is not zero
//! ```
//!
//! A finger that presses a box against another finger cannot move while one corner of each sticks. If its joint were held, the joint would bear the force
//! with which it presses, no contact would press, and the corners that slide would not be braked.

use crate::events::modes::mode::{Closed, JointMode, Mode};
use crate::instant::cone::apart::{parts_of, sub_matrix, with_unit_diagonal};
use crate::instant::cone::sharing::implied;
use crate::instant::dynamics::response::Response;
use crate::instant::holding::blocks::{Row, Rows, least_answer, row_of_freedom, rows_of_contact};
use crate::instant::holding::elements::Elements;
use crate::instant::holding::touching::Touching;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use nalgebra::DMatrix;

/// Parts of combinations of length one below this are rounding.
const PART: f64 = 1e-6;

/// For each closed contact of a mode whether friction depends on how its forces are shared.
pub(super) fn shared_with_braked(
    whole: &Mechanism,
    elements: &Elements,
    touching: &Touching,
    mode: &Mode,
    response: &mut Response,
    state: &State,
) -> Vec<bool> {
    let brakes = |closed: &Closed| {
        let slides = closed.slides.is_some() && touching.pairs[closed.contact.pair].friction > 0.0;
        slides || closed.moments.brake()
    };
    let braked: Vec<bool> = mode.contacts.iter().map(brakes).collect();
    if !braked.contains(&true) {
        return braked;
    }
    let bodies = body_states(whole, state);
    let held = elements.joints.iter().zip(&mode.joints).filter(|(_, mode)| matches!(mode, JointMode::Held { .. }));
    let mut rows: Vec<Row> =
        held.map(|(joint, _)| row_of_freedom(whole.velocity_count, joint.coordinate.freedom, 1.0)).collect();
    let mut own = Vec::with_capacity(mode.contacts.len());
    for closed in &mode.contacts {
        let first = rows.len();
        rows.extend(rows_of_contact(whole, &bodies, &closed.contact.joint, closed.slides.is_none()));
        own.push(first..rows.len());
    }
    let mut shared = braked.clone();
    for part in parts_that_share(&Rows::new(response, state, rows).square) {
        // Friction follows the normal force, whose row is the first of a contact.
        if own.iter().zip(&braked).any(|(own, brakes)| *brakes && part.contains(&own.start)) {
            let members = own.iter().zip(&mut shared).filter(|(own, _)| part.iter().any(|row| own.contains(row)));
            members.for_each(|(_, shared)| *shared = true);
        }
    }
    shared
}

/// The rows of a response in parts that combinations without effect join: such a combination is one of rows that feel each other.
fn parts_that_share(square: &DMatrix<f64>) -> Vec<Vec<usize>> {
    let least = least_answer(square);
    let answers: Vec<usize> = (0..square.nrows()).filter(|&row| square[(row, row)] > least).collect();
    let (scaled, _) = with_unit_diagonal(square, &answers);
    let mut found = Vec::new();
    for rows in parts_of(&scaled) {
        let combinations = implied(sub_matrix(&scaled, &rows)).unwrap_or_default();
        let together = DMatrix::from_fn(rows.len(), rows.len(), |one, other| {
            let together: f64 = combinations.iter().map(|combination| combination[one] * combination[other]).sum();
            if together.abs() > PART { together } else { 0.0 }
        });
        found.extend(
            parts_of(&together).into_iter().map(|part| part.into_iter().map(|place| answers[rows[place]]).collect()),
        );
    }
    found
}
