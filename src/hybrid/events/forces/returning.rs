//! Contacts without pressure that closed ones keep at their places, as a corner that a load elsewhere lifts out of the share: when they press again.
//!
//! Redundant normal forces are those of equal springs ([`crate::events::forces::closed_forces`]), which push only. A corner that pulls opens, but the
//! others keep its gap at zero. Its spring is pressed again if the plane of the pressures says so:
//!
//! ```text
//!     r_u = Σ_i c_i r_i,   D_cc c = D_cu           r: gradients of gaps,  D = R Y Rᵀ,  c the closed contacts, u the one without pressure
//!     λ_u' = Σ_i c_i λ_i   (N)                     u presses again when λ_u' > 0;  implied if D_uu − D_uc c ≤ 1e-10 D_uu
//! ```
//!
//! With equal springs `λ_i = −k r_i · x` for a displacement x, so that λ_u' is what the spring of u has.

use crate::instant::cone::least_norm::least_norm;
use crate::instant::dynamics::response::Response;
use crate::instant::holding::blocks::{Row, Rows, rows_of_contact};
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::contact::TouchJoint;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::state::State;
use nalgebra::DVector;

/// A gap whose answer beside closed contacts is this part of its own is one that they imply.
const IMPLIED: f64 = 1e-10;

/// c for each of the contacts that may press again, one entry a closed contact; `None` where the closed ones leave it free.
pub(crate) fn shares<'c>(
    whole: &Mechanism,
    response: &mut Response,
    state: &State,
    bodies: &[BodyState],
    closed: impl Iterator<Item = &'c TouchJoint>,
    open: impl Iterator<Item = &'c TouchJoint>,
) -> Vec<Option<DVector<f64>>> {
    let normal = |joint: &TouchJoint| rows_of_contact(whole, bodies, joint, false);
    let mut rows: Vec<Row> = closed.flat_map(normal).collect();
    let count = rows.len();
    rows.extend(open.flat_map(normal));
    let square = Rows::new(response, state, rows).square;
    let held = square.view((0, 0), (count, count)).into_owned();
    let share = |own: usize| {
        let right: DVector<f64> = square.view((0, own), (count, 1)).column(0).into_owned();
        let (share, _) = least_norm(&held, &right)?;
        let left = square[(own, own)] - right.dot(&share);
        (left <= IMPLIED * square[(own, own)]).then_some(share)
    };
    (count..square.nrows()).map(share).collect()
}
