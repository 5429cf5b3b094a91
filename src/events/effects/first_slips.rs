//! The directions in which contacts at rest begin to slide, where some of the contacts that stay closed imply others.
//!
//! Friction opposes the slip, and a slip that begins goes where it is accelerated:
//!
//! ```text
//!     a = b + D λ(t),    t_i = a_Ti/|a_Ti|   of all contacts i that begin to slide       λ(t): [`crate::events::forces::closed_forces`]
//! ```
//!
//! solved by repeating it. The law of the decision has many answers there, with a pressure for each, and its direction is that of another one than
//! steps take: a slip that began in it would turn at once, or stop.

use crate::events::forces::closed_forces::Chosen;
use crate::instant::blocks::{Block, Of};
use crate::instant::cone::problem::Law;
use nalgebra::{DMatrix, DVector};

/// Repetitions, at most.
const ROUNDS: usize = 50;
/// Directions that change by less are found (rad).
const FOUND: f64 = 1e-12;
/// Pressures above this part of the largest, below zero, are rounding.
const ROUNDING: f64 = 1e-10;

/// What a decision keeps closed or held.
#[derive(Debug, Default)]
pub(crate) struct Kept {
    blocks: Vec<Block>,
    /// The first row of each in the decision, and whether it is a contact that begins to slide.
    firsts: Vec<usize>,
    begins: Vec<bool>,
    /// Rows of joints that move, and their friction there [N m or N].
    pushes: Vec<(usize, f64)>,
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

    /// The directions, in the tangents of each kept contact, of those that begin to slide; none where the forces are unique, so that the directions are
    /// right, or where no directions fit.
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
        for _ in 0..ROUNDS {
            let forces = Chosen::new(&self.blocks).solve(&own, &free, false);
            let rates = &own * DVector::from_column_slice(&forces) + DVector::from_column_slice(&free);
            match self.turn(&forces, rates.as_slice()) {
                Some(turned) if turned <= FOUND => return self.directions(),
                Some(_) => {}
                None => return Vec::new(),
            }
        }
        Vec::new()
    }

    /// Turns the directions to the accelerations, and says by how much (rad); nothing where a contact would pull, or does not begin.
    fn turn(&mut self, forces: &[f64], rates: &[f64]) -> Option<f64> {
        let least = -ROUNDING * forces.iter().fold(0.0_f64, |most, force| most.max(force.abs()));
        let (mut row, mut turned) = (0, 0.0_f64);
        for (block, begins) in self.blocks.iter_mut().zip(&self.begins) {
            if let Law::Sliding { direction, .. } = &mut block.law {
                let along = [rates[row + 1], rates[row + 2]];
                let size = along[0].hypot(along[1]);
                if forces[row] < least || *begins && size == 0.0 {
                    return None;
                }
                if *begins {
                    let next = along.map(|part| part / size);
                    turned = turned.max((next[0] - direction[0]).hypot(next[1] - direction[1]));
                    *direction = next;
                }
            }
            row += block.rows.len();
        }
        Some(turned)
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
