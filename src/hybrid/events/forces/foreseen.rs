//! The forces of closed contacts as the multipliers of a step show them: enough, far inside their cones, to know that the mode lasts.
//!
//! ```text
//!     φ at the stages c_k h, k = 1 … s − 1        λ_N of a contact;  μ λ_N − |λ_T| of one that sticks        (N)
//!     calm          min φ > 4 (max φ − min φ)                                  then φ stays positive up to the end of the step
//!     left          min φ − 2 (max φ − min φ)                                  at the end, where few stages show no force
//!     a jump Δτ     |Δλ| ≤ |A Δτ| + ¼ |A| |Δτ|,   A = −D̃⁻¹ W Y                 of a state at most 0.1 (rad, m) away
//! ```
//!
//! with D̃, W and Y as in [`crate::events::forces::closed_forces`]. A force that is not calm, or not left after a jump, is worked out from the state
//! instead. To work out all forces takes as long as half a step of three stages.

use crate::events::forces::chosen::Chosen;
use crate::events::forces::closed_forces::Closing;
use crate::instant::holding::blocks::Of;
use crate::mechanism::motion::state::State;
use nalgebra::{DMatrix, DVector};

/// A force is calm if it exceeds its change over the stages by this factor.
const CALM: f64 = 4.0;
/// Up to the end it may change by this many times as much.
const ON: f64 = 2.0;
/// A is taken for states that are no farther from its own (rad, m), and with this part of its entries as its error.
const NEAR: f64 = 0.1;
const ERROR: f64 = 0.25;

/// The forces of the closed contacts of one mode after a step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Foreseen {
    /// Room for the forces at the stages (N).
    forces: Vec<[f64; 3]>,
    /// The pressure and the grip that each contact has left at the end of the last step (N); empty if they are not known.
    left: Vec<[f64; 2]>,
    /// When it ended (s).
    ended: f64,
    /// The efforts in it, one entry a degree of freedom.
    efforts: Vec<f64>,
    /// The change of efforts that was met last.
    jump: Vec<f64>,
    answer: Option<Answer>,
    /// Whether a jump was worked out from the state in this mode before.
    asked: bool,
}

/// A in a state.
#[derive(Clone, Debug)]
struct Answer {
    position: Vec<f64>,
    /// Three rows a contact, one column a degree of freedom.
    matrix: DMatrix<f64>,
}

impl Foreseen {
    /// A step begins under these constant efforts: nothing is known of it.
    pub fn begin(&mut self, efforts: &[f64]) {
        self.left.clear();
        self.efforts.clear();
        self.efforts.extend_from_slice(efforts);
    }

    /// Looks at the forces that a step up to `end` (s) has found: `write` writes those of its closures, stage after stage of each, in the order of
    /// `of`, which has for each closure the number of its contact, its normal and μ; `None` for μ if the contact slides.
    pub fn see(
        &mut self,
        count: usize,
        end: f64,
        write: impl FnOnce(&mut Vec<[f64; 3]>) -> bool,
        of: impl Iterator<Item = (usize, [f64; 3], Option<f64>)>,
    ) {
        self.left.clear();
        if count == 0 || !write(&mut self.forces) {
            return;
        }
        self.ended = end;
        self.left.resize(count, [f64::NEG_INFINITY; 2]);
        let stages = self.forces.len() / count;
        for ((contact, normal, friction), forces) in of.zip(self.forces.chunks_exact(stages)) {
            let dot = |force: &[f64; 3]| normal.iter().zip(force).map(|(n, f)| n * f).sum::<f64>();
            let grip = |force: &[f64; 3]| {
                let pressure = dot(force);
                let across = normal.iter().zip(force).map(|(n, f)| (f - pressure * n).powi(2)).sum::<f64>().sqrt();
                friction.map_or(f64::INFINITY, |friction| {
                    if friction > 0.0 { friction * pressure - across } else { f64::INFINITY }
                })
            };
            self.left[contact] = [left(forces.iter().map(dot)), left(forces.iter().map(grip))];
        }
    }

    /// Whether the pressure, or the grip if so, of a contact stays positive over the whole step.
    pub fn is_calm(&self, contact: usize, grips: bool) -> bool {
        self.left.get(contact).is_some_and(|left| left[usize::from(grips)] > 0.0)
    }

    /// Forgets the forces: the efforts are others.
    pub fn forget_all(&mut self) {
        self.left.clear();
    }

    /// Forgets what is left of a contact.
    pub fn forget(&mut self, contact: usize) {
        if let Some(left) = self.left.get_mut(contact) {
            *left = [f64::NEG_INFINITY; 2];
        }
    }

    /// Whether the forces of all contacts are inside their cones at the end of the step, which is this time (s).
    pub fn holds_all_at(&self, time: f64) -> bool {
        self.ended == time && !self.left.is_empty() && self.left.iter().flatten().all(|left| *left > 0.0)
    }

    /// Whether other constant efforts at the end of the step in this state leave them there; `friction` has μ of each contact.
    pub fn takes(&mut self, state: &State, efforts: &[f64], friction: impl Iterator<Item = f64>) -> bool {
        let Some(Answer { matrix, .. }) = self.answer.as_ref().filter(|answer| answer.is_near(&state.position)) else {
            return false;
        };
        if !self.holds_all_at(state.time) || matrix.nrows() != 3 * self.left.len() {
            return false;
        }
        self.jump.clear();
        self.jump.extend(efforts.iter().zip(&self.efforts).map(|(now, before)| now - before));
        let change = |row: usize| {
            let (sum, size) = matrix.row(row).iter().zip(&self.jump).fold((0.0, 0.0), |(sum, size), (answer, jump)| {
                let change: f64 = answer * jump;
                (sum + change, size + change.abs())
            });
            f64::abs(sum) + ERROR * size
        };
        for (contact, (left, friction)) in self.left.iter_mut().zip(friction).enumerate() {
            let [pressure, along, across] = [0, 1, 2].map(|row: usize| change(3 * contact + row));
            *left = [left[0] - pressure, left[1] - friction * pressure - along.hypot(across)];
        }
        self.efforts.copy_from_slice(efforts);
        self.holds_all_at(state.time)
    }

    /// Takes A of the state in which forces were worked out after a jump, if they are unique: of the second such state in a mode.
    pub fn learn(&mut self, position: &[f64], held: &Closing) {
        if !std::mem::replace(&mut self.asked, true)
            || self.answer.as_ref().is_some_and(|answer| answer.is_near(position))
        {
            return;
        }
        self.answer = Some(Answer { position: position.to_vec(), matrix: answers(held) });
    }
}

impl Answer {
    /// Whether A is good in a position.
    fn is_near(&self, position: &[f64]) -> bool {
        self.position.iter().zip(position).all(|(own, other)| (own - other).abs() <= NEAR)
    }
}

/// The rest, at the end of a step, of a function with these values at its stages; −∞ if it is not calm.
fn left(values: impl Iterator<Item = f64>) -> f64 {
    let (least, most) =
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), value| (least.min(value), most.max(value)));
    let change = if least == f64::INFINITY { 0.0 } else { most - least };
    if least > CALM * change { least - ON * change } else { f64::NEG_INFINITY }
}

/// A: the forces of contacts, three rows each, that unit efforts along the freedoms are answered with.
fn answers(held: &Closing) -> DMatrix<f64> {
    let (chosen, rows) = (Chosen::new(&held.blocks), held.rows());
    let mut first = 0;
    let starts = held.blocks.iter().filter_map(|block| {
        let start = first;
        first += block.rows.len();
        matches!(block.of, Of::Contact(_)).then_some((start, block.rows.len()))
    });
    let starts: Vec<(usize, usize)> = starts.collect();
    let columns = rows.columns();
    let mut matrix = DMatrix::zeros(3 * starts.len(), columns.nrows());
    for freedom in 0..columns.nrows() {
        let offset = DVector::from_iterator(columns.ncols(), columns.row(freedom).iter().copied());
        let forces = chosen.solve(&rows.square, offset.as_slice(), true);
        for (contact, &(start, count)) in starts.iter().enumerate() {
            (0..count).for_each(|row| matrix[(3 * contact + row, freedom)] = forces[start + row]);
        }
    }
    matrix
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(position: f64) -> State {
        State { time: 0.0, position: vec![position], velocity: vec![0.0], compensation: vec![0.0] }
    }

    const UP: [f64; 3] = [0.0, 0.0, 1.0];

    fn seen(forces: &[[f64; 3]], friction: Option<f64>) -> Foreseen {
        let mut foreseen = Foreseen::default();
        let write = |room: &mut Vec<[f64; 3]>| {
            room.clear();
            room.extend_from_slice(forces);
            true
        };
        foreseen.see(1, 0.0, write, std::iter::once((0, UP, friction)));
        foreseen
    }

    #[test]
    fn a_force_that_may_leave_its_cone_before_the_end_of_the_step_is_not_calm() {
        // Pressures of 10 N that fall by 1 N over half the step are 8 N at its end; those that fall by 3 N may be anything.
        assert!(seen(&[[0.0, 0.0, 10.0], [0.0, 0.0, 9.0]], Some(0.5)).holds_all_at(0.0));
        assert!(!seen(&[[0.0, 0.0, 10.0], [0.0, 0.0, 7.0]], Some(0.5)).is_calm(0, false));
        // 4.9 N along the plane of 5 N that friction bears are 0.1 N left, and 5.1 N too many.
        assert!(seen(&[[4.9, 0.0, 10.0]; 2], Some(0.5)).is_calm(0, true));
        assert!(!seen(&[[0.0, 5.1, 10.0]; 2], Some(0.5)).is_calm(0, true));
        assert!(!seen(&[[0.0, 0.0, -1.0]; 2], Some(0.5)).is_calm(0, false));
        // A contact that slides, and one without friction, have no grip to lose.
        assert!(
            seen(&[[5.0, 0.0, 10.0]; 2], None).holds_all_at(0.0)
                && seen(&[[0.0, 0.0, 10.0]; 2], Some(0.0)).holds_all_at(0.0)
        );
    }

    #[test]
    fn a_jump_of_efforts_is_taken_while_it_leaves_the_forces_inside_their_cones() {
        let at = |effort: f64| {
            let mut foreseen = seen(&[[0.0, 0.0, 10.0]; 2], Some(0.5));
            foreseen.efforts = vec![1.0];
            let matrix = DMatrix::from_column_slice(3, 1, &[-2.0, 1.0, 0.0]);
            foreseen.answer = Some(Answer { position: vec![0.3], matrix });
            foreseen.takes(&state(0.35), &[effort], std::iter::once(0.5))
        };
        // 1 N m takes 2.5 N of pressure with its error, and with them 1.25 N and 1.25 N of grip: 5 N last for less than 2 N m.
        assert!(at(1.0) && at(2.9) && !at(3.1));
        let mut far = seen(&[[0.0, 0.0, 10.0]; 2], Some(0.5));
        far.efforts = vec![1.0];
        far.answer = Some(Answer { position: vec![0.3], matrix: DMatrix::zeros(3, 1) });
        assert!(
            far.takes(&state(0.3), &[1.0], std::iter::once(0.5))
                && !far.takes(&state(0.41), &[1.0], std::iter::once(0.5))
        );
    }
}
