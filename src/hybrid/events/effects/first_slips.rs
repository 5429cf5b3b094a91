//! The directions in which contacts at rest begin to slide, where some of the contacts that stay closed imply others.
//!
//! Friction opposes the slip, and a slip that begins goes where it is accelerated:
//!
//! ```text
//!     a = b + D λ(t),    m_i · a_Ti = 0,  t_i · a_Ti > 0    of all contacts i that begin to slide    λ(t): [`crate::events::forces::closed_forces`]
//! ```
//!
//! with `m_i` across `t_i`, is solved by Newton's method in the angles of the directions, whose derivatives are differences. The fixed-point
//! iteration `t = a/|a|` alternates between two directions if friction exceeds the remaining acceleration. The law of the decision has many answers
//! there, with a pressure for each. Its direction belongs to another answer than the steps take: a slip that began in it would turn at once, or stop.

use crate::events::forces::chosen::Chosen;
use crate::instant::cone::problem::Law;
use crate::instant::holding::blocks::{Block, Of};
use nalgebra::{DMatrix, DVector};

/// Iterations, at most.
const ITERATIONS: usize = 20;
/// Directions that are off by less are found (rad), or by this part of the sizes of what the acceleration is the difference of.
const FOUND: f64 = 1e-12;
const ROUNDED: f64 = 1e-14;
/// Turn for a derivative, and the largest of an iteration (rad).
const TURN: f64 = 1e-6;
const LARGEST: f64 = 0.5;
/// Pressures above this part of the largest, below zero, are rounding.
const ROUNDING: f64 = 1e-10;

/// The blocks that a decision keeps closed or held.
#[derive(Debug, Default)]
pub(crate) struct Kept {
    blocks: Vec<Block>,
    /// The first row of each in the decision, and whether it is a contact that begins to slide.
    firsts: Vec<usize>,
    begins: Vec<bool>,
    /// Rows of joints that move, and their friction there [N m or N].
    pushes: Vec<(usize, f64)>,
}

/// The acceleration of a contact that begins to slide (m/s²): along its direction, across it to the left, and the size of the terms that cancel in
/// it.
struct Seen {
    along: f64,
    across: f64,
    size: f64,
}

impl Seen {
    fn is_found(&self) -> bool {
        self.across.abs() <= (FOUND * self.along.abs()).max(ROUNDED * self.size)
    }
}

impl Kept {
    /// Keeps a block; the law of a contact that slides has its direction.
    pub fn keep(&mut self, block: Block, row: usize, begins: bool) {
        self.blocks.push(block);
        self.firsts.push(row);
        self.begins.push(begins);
    }

    /// Takes the friction of a joint that moves.
    pub fn push(&mut self, row: usize, effort: f64) {
        self.pushes.push((row, effort));
    }

    /// The directions, in the tangents of each kept contact, of the contacts that begin to slide; empty if the forces are unique, so that the
    /// directions are right already, or if no directions fit.
    pub fn first_slips(mut self, mobility: &DMatrix<f64>, free: &[f64]) -> Vec<Option<[f64; 2]>> {
        if !self.begins.contains(&true) {
            return Vec::new();
        }
        let of_block = |(block, &first): (&Block, &usize)| first..first + block.rows.len();
        let rows: Vec<usize> = self.blocks.iter().zip(&self.firsts).flat_map(of_block).collect();
        let own = DMatrix::from_fn(rows.len(), rows.len(), |row, column| mobility[(rows[row], rows[column])]);
        let pushed =
            |row: usize| self.pushes.iter().map(|(other, effort)| mobility[(row, *other)] * effort).sum::<f64>();
        let free: Vec<f64> = rows.iter().map(|&row| free[row] + pushed(row)).collect();
        if Chosen::new(&self.blocks).is_unique(&own) {
            return Vec::new();
        }
        self.solve(&own, &free)
            .filter(|seen| seen.iter().all(|of| of.along > 0.0))
            .map_or_else(Vec::new, |_| self.directions())
    }

    /// Turns the directions until no contact is accelerated across its own; `None` if that fails.
    fn solve(&mut self, own: &DMatrix<f64>, free: &[f64]) -> Option<Vec<Seen>> {
        for _ in 0..ITERATIONS {
            let seen = self.look(own, free)?;
            if seen.iter().all(Seen::is_found) {
                return Some(seen);
            }
            let across = DVector::from_iterator(seen.len(), seen.iter().map(|of| of.across));
            let turns = self.derivative(own, free, &seen)?.lu().solve(&across)?;
            self.turn(|index| (-turns[index]).clamp(-LARGEST, LARGEST));
        }
        None
    }

    /// The derivatives of the accelerations across the directions by the angle of each direction (m/s²).
    fn derivative(&mut self, own: &DMatrix<f64>, free: &[f64], seen: &[Seen]) -> Option<DMatrix<f64>> {
        let mut derivative = DMatrix::zeros(seen.len(), seen.len());
        for turned in 0..seen.len() {
            self.turn(|index| if index == turned { TURN } else { 0.0 });
            let then = self.look(own, free)?;
            self.turn(|index| if index == turned { -TURN } else { 0.0 });
            for (row, (then, now)) in then.iter().zip(seen).enumerate() {
                derivative[(row, turned)] = (then.across - now.across) / TURN;
            }
        }
        Some(derivative)
    }

    /// The accelerations of the contacts that begin to slide along and across their directions; `None` if a contact would pull.
    fn look(&self, own: &DMatrix<f64>, free: &[f64]) -> Option<Vec<Seen>> {
        let forces = Chosen::new(&self.blocks).solve(own, free, false);
        let rates = own * DVector::from_column_slice(&forces) + DVector::from_column_slice(free);
        let least = -ROUNDING * forces.iter().fold(0.0_f64, |most, force| most.max(force.abs()));
        let (mut row, mut seen) = (0, Vec::new());
        for (block, begins) in self.blocks.iter().zip(&self.begins) {
            if let Law::Sliding { direction: [x, y], .. } = block.law {
                if forces[row] < least {
                    return None;
                }
                if *begins {
                    let [first, second] = [rates[row + 1], rates[row + 2]];
                    let size = |row: usize| {
                        let own = own.row(row);
                        let pushed = own.iter().zip(&forces).map(|(own, force)| (own * force).abs());
                        free[row].abs() + pushed.sum::<f64>()
                    };
                    let size = size(row + 1).hypot(size(row + 2));
                    seen.push(Seen { along: x * first + y * second, across: x * second - y * first, size });
                }
            }
            row += block.rows.len();
        }
        Some(seen)
    }

    /// Turns the directions of the contacts that begin to slide by these angles (rad).
    fn turn(&mut self, by: impl Fn(usize) -> f64) {
        let begins = self.blocks.iter_mut().zip(&self.begins).filter(|(_, begins)| **begins);
        let mut index = 0;
        for (block, _) in begins {
            if let Law::Sliding { direction, .. } = &mut block.law {
                let (sine, cosine) = by(index).sin_cos();
                let [x, y] = *direction;
                *direction = [cosine * x - sine * y, sine * x + cosine * y];
                index += 1;
            }
        }
    }

    fn directions(&self) -> Vec<Option<[f64; 2]>> {
        let direction = |(block, begins): (&Block, &bool)| match block.law {
            Law::Sliding { direction, .. } if *begins => Some(direction),
            _ => None,
        };
        let contacts = self.blocks.iter().zip(&self.begins).filter(|(block, _)| matches!(block.of, Of::Contact(_)));
        contacts.map(direction).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_found_where_friction_is_much_more_than_what_is_left_of_the_acceleration() {
        // One kilogram on two contacts at one place, pressed by 10 N and pulled by a thousandth more than friction holds. The fixed-point iteration t
        // = a/|a| would alternate if it began half a radian beside the pull.
        let (friction, pull) = (0.5, 5.0 * 1.001);
        let along: [f64; 2] = [0.6, 0.8];
        let mobility = DMatrix::from_fn(6, 6, |row, column| if row % 3 == column % 3 { 1.0 } else { 0.0 });
        let free = [-10.0, pull * along[0], pull * along[1]].repeat(2);
        let mut kept = Kept::default();
        for (row, beside) in [(0, 0.5_f64), (3, 0.3)] {
            let angle = along[1].atan2(along[0]) + beside;
            let law = Law::Sliding { friction, direction: [angle.cos(), angle.sin()] };
            kept.keep(Block { of: Of::Contact(row), law, rows: vec![Vec::new().into(); 3] }, row, true);
        }
        let found = kept.first_slips(&mobility, &free);
        assert_eq!(found.len(), 2);
        for direction in found {
            let [x, y] = direction.expect("a direction");
            // The acceleration, 5e-3 m/s², is the difference of two of 5 m/s².
            assert!((x - along[0]).hypot(y - along[1]) < 1e-11, "{x}, {y}");
        }
    }
}
