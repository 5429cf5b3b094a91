//! Whether anything can give way where limits and contacts close: joints that are moved in time may leave no velocity that is allowed.
//!
//! With the rows N of all limits and contacts that are met along their normals, `D = N Y Nᵀ` and their rates `u⁻`, velocities that keep them apart exist
//! if and only if no pushes y hold each other while they approach (Farkas):
//!
//! ```text
//!     ∃ P: D P + u⁻ ≥ 0     ⟺     no y ≥ 0 with D y = 0, yᵀ u⁻ < 0
//!     y = argmin  ½ yᵀ (D + ε d 1) y + u⁻ᵀ y,  y ≥ 0,  d = max Dᵢᵢ:      bounded where velocities exist, of the size 1/ε along such pushes otherwise
//! ```
//!
//! Friction needs nothing more: if the normals can part, Coulomb's law has a solution. Without moved joints rest is always allowed, and nothing is
//! looked at.

use crate::events::effects::decision::Scene;
use crate::events::effects::immobile::{ROUNDING, answers_of_tree};
use crate::events::effects::impact::Meeting;
use crate::events::effects::resting::energy;
use crate::instant::cone::bounded::minimise;
use crate::instant::holding::blocks::{Of, Row, Rows};
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::state::State;
use nalgebra::{DMatrix, DVector};

/// ε.
const SOFT: f64 = 1e-9;
/// Pushes hold each other if what they move is less than this part of what they would move alone.
const HOLDS: f64 = 1e-6;
/// Impulses that do more work than this times the kinetic energy may have met no mass.
const WILD: f64 = 1e6;
/// A rate that is this part of the fastest approach and cannot be stopped is no rounding.
const MISSED: f64 = 1e-3;

/// The limit or contact that still approaches most although all push, with the velocities before and after these impulses along the normals.
pub(crate) fn blocked(
    scene: &mut Scene,
    before: &[f64],
    after: &State,
    meetings: &[Meeting],
    impulses: &[f64],
) -> Option<Of> {
    if !scene.whole.moves_joints() {
        return None;
    }
    let rates: Vec<f64> = meetings.iter().map(|meeting| meeting.rate(before)).collect();
    let fastest = rates.iter().fold(0.0, |most: f64, rate| most.max(-rate));
    let kinetic = energy(scene.whole, &State { velocity: before.to_vec(), ..after.clone() }).kinetic;
    // NaN is not allowed: no row has answered.
    let parts = |meeting: &Meeting| meeting.rate(&after.velocity) >= -meeting.rest.max(MISSED * fastest);
    let is_tame = |(impulse, rate): (&f64, &f64)| (impulse * rate).abs() <= WILD * kinetic;
    let all_part = meetings.iter().all(parts);
    if all_part && impulses.iter().zip(&rates).all(is_tame) {
        return None;
    }
    let normals: Vec<Row> = meetings.iter().map(|meeting| meeting.block.rows[0].clone()).collect();
    let own = answers_without_moved(scene.whole, after, &normals);
    let mut square = Rows::new(scene.response, after, normals).square;
    let answers = |number: usize| square[(number, number)] > ROUNDING * own[number] && own[number] > 0.0;
    let still: Vec<usize> = (0..rates.len()).filter(|&number| !answers(number)).collect();
    // The impulses have found velocities that are allowed.
    if all_part && still.iter().all(|&number| rates[number] >= -MISSED * fastest) {
        return None;
    }
    for &number in &still {
        square.row_mut(number).fill(0.0);
        square.column_mut(number).fill(0.0);
    }
    let largest = square.diagonal().max().max(f64::MIN_POSITIVE);
    if let Some(&number) = still.iter().min_by(|one, other| rates[**one].total_cmp(&rates[**other]))
        && rates[number] < -MISSED * fastest
    {
        return Some(meetings[number].block.of);
    }
    let softened = &square + DMatrix::identity(rates.len(), rates.len()) * (SOFT * largest);
    let pushes = DVector::from_vec(minimise(&softened, &rates, &vec![(0.0, f64::INFINITY); rates.len()]).efforts);
    let most = pushes.amax();
    let approach = pushes.dot(&DVector::from_column_slice(&rates));
    let hold = (&square * &pushes).amax() <= HOLDS * largest * most && approach < -MISSED * fastest * most;
    // The one that approaches most is what the others press it on.
    let pressed = (0..rates.len()).filter(|&number| pushes[number] > MISSED * most);
    let fastest = pressed.min_by(|&one, &other| rates[one].total_cmp(&rates[other]));
    fastest.filter(|_| hold).map(|number| meetings[number].block.of)
}

/// An upper bound of the order of `N H⁻¹ Nᵀ` without closures and without the joints that are moved.
fn answers_without_moved(whole: &Mechanism, state: &State, rows: &[Row]) -> Vec<f64> {
    let mut of_freedoms = answers_of_tree(whole, state, 0..whole.velocity_count);
    for mimic in whole.mimics.iter().filter(|mimic| mimic.is_moved()) {
        of_freedoms[mimic.follower.freedom] = 0.0;
    }
    let answer = |row: &Row| row.iter().zip(&of_freedoms).map(|(entry, own)| entry * entry * own).sum();
    rows.iter().map(answer).collect()
}
