//! How many equations of the closures are independent at a configuration, which of them are redundant, and which freedoms cannot move.
//!
//! Rank is kinematics. The gradient J of all equations ([`crate::structure::ranks::rows`]) is made dimensionless by lengths:
//!
//! ```text
//!     A_ix = J_ix · (1 / L_i of a row in m,  1 of a row in rad) · (L_x of a slide,  1 of a turn),      L = size of the loop (m)
//!     rank A  by row-pivoted QR (`row_pivoting`):  pivots above  first pivot · max(1e-10, 100 gap / L)
//! ```
//!
//! Tangents that friction holds beside friction that brakes come after the other rows: normal forces carry what they can, and friction bears the rest. If it
//! carried a part of the weight of a box that a ram pushes over a floor, the floor would brake the box less.
//!
//! No mass and no square of an entry enters, so that light links and the order of the loops do not matter. Rows that share freedoms form a block;
//! blocks are decided one by one. A freedom x is still at this configuration if the null space of A does not touch it, `|Z[x, :]| <= 1e-10`.
//!
//! The threshold has ten decades on either side: in random mechanisms of six links the smallest pivot that counts is 1e-5, and the largest that
//! must not 2e-15 (lengths spread by 1e6: 4e-10 and 8e-12). Source: P. Businger, G. Golub, Numerische Mathematik 7 (1965) 269, with rows for columns.

use crate::description::mechanism::Mechanism;
use crate::ground::disjoint_sets::DisjointSets;
use crate::motion::kinematics::body_states;
use crate::motion::state::State;
use crate::structure::ranks::rows::{Row, closure_rows};
use crate::structure::ranks::{insertion, row_pivoting};

/// A pivot below this part of the first one is rounding.
pub const ROUNDING: f64 = 1e-10;
/// Gaps of the closures show in the pivots with a factor of five; with a margin.
const PER_GAP: f64 = 100.0;
/// No gap makes more than this part of the first pivot rounding: a mechanism that is not closed yet still has most of its rank.
const COARSEST: f64 = 1e-4;
/// A freedom whose part in the null space is below this is still: rounding leaves 1e-13 of still freedoms, mechanics 9e-7 of the others.
const STILL: f64 = 1e-10;
/// Rows of a projection are independent if this part of the first is left; rounding leaves far less.
const PROJECTED: f64 = 1e-6;
/// Pivots below this part of the first are weak: some milliradians from a singular position.
pub const WEAK: f64 = 1e-2;
/// Blocks of more rows than this are decided by insertion, whose cost is linear in the number of loops.
const DENSE: usize = 300;

/// Ranks of the closures at one configuration.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ranks {
    /// For every equation its closure (the loops first, then the mimics), and whether the others imply it.
    pub implied: Vec<(usize, bool)>,
    /// For every equation whether friction would hold it, and the equations that friction does not hold imply it.
    pub borne: Vec<bool>,
    /// For every degree of freedom whether the equations forbid it to move.
    pub still: Vec<bool>,
    /// For every degree of freedom whether its block has as many independent equations as freedoms: that holds beside the configuration, too.
    pub locked: Vec<bool>,
    /// Orthonormal directions in which the mechanism can move, in the coordinates of the freedoms divided by `lengths`, of each the freedoms of its
    /// block; `None` if a block was too large for them.
    pub free: Option<Vec<Vec<(usize, f64)>>>,
    /// The length (m) of every slide, and one for every turn.
    pub lengths: Vec<f64>,
    /// The smallest pivot that counts, as a part of the first of its block; one without pivots.
    pub weakest: f64,
    /// Number of independent equations that are weak: their pivots are below [`WEAK`] of the first of their block.
    pub weak: usize,
}

impl Ranks {
    /// The ranks of the closures of a mechanism in a state.
    pub fn at(mechanism: &Mechanism, state: &State) -> Self {
        let (rows, lengths) = closure_rows(mechanism, state, &body_states(mechanism, state));
        Ranks::of(&rows, lengths, ROUNDING)
    }

    /// The ranks of equations that are dimensionless with the lengths of the freedoms; pivots below a part `rounding` of the first do not count.
    pub fn of(rows: &[Row], lengths: Vec<f64>, rounding: f64) -> Self {
        let count = lengths.len();
        let mut ranks = Ranks {
            implied: rows.iter().map(|row| (row.closure, true)).collect(),
            borne: vec![false; rows.len()],
            still: vec![false; count],
            locked: vec![false; count],
            free: Some(Vec::new()),
            lengths,
            weakest: 1.0,
            weak: 0,
        };
        for mut block in blocks(rows, count) {
            block.1.sort_by_key(|&row| rows[row].adheres);
            ranks.decide(rows, &block, rounding);
            if block.1.iter().any(|&row| rows[row].moves) {
                for &freedom in &block.0 {
                    (ranks.still[freedom], ranks.locked[freedom]) = (false, false);
                }
            }
        }
        ranks
    }

    /// Number of independent equations.
    pub fn rank(&self) -> usize {
        self.implied.iter().filter(|(_, implied)| !implied).count()
    }

    /// Number of degrees of freedom that the equations leave.
    pub fn freedoms(&self) -> usize {
        self.lengths.len().saturating_sub(self.rank())
    }

    /// Decides one block: its freedoms, and its rows.
    fn decide(&mut self, rows: &[Row], (freedoms, members): &(Vec<usize>, Vec<usize>), rounding: f64) {
        let gap = members.iter().fold(0.0_f64, |most, &row| most.max(rows[row].gap));
        let threshold = (PER_GAP * gap).min(COARSEST).max(rounding);
        let small = members.len() <= DENSE;
        let place = |freedom: usize| freedoms.binary_search(&freedom).unwrap_or(0);
        let independent = if small {
            let dense: Vec<Vec<f64>> = members
                .iter()
                .map(|&row| {
                    let mut entries = vec![0.0; freedoms.len()];
                    rows[row].entries.iter().for_each(|&(freedom, value)| entries[place(freedom)] = value);
                    entries
                })
                .collect();
            let preferred = members.partition_point(|&row| !rows[row].adheres);
            let found = row_pivoting::pivoted_preferring(preferred, dense, threshold);
            found.borne.iter().for_each(|&row| self.borne[members[row]] = true);
            let parts = found.null_parts(freedoms.len());
            for (&freedom, part) in freedoms.iter().zip(&parts) {
                self.still[freedom] = part.iter().map(|value| value * value).sum::<f64>().sqrt() <= STILL;
            }
            if let Some(free) = &mut self.free {
                let dimensions = freedoms.len() - found.order.len();
                for direction in row_pivoting::pivoted(parts, PROJECTED).basis.into_iter().take(dimensions) {
                    free.push(freedoms.iter().copied().zip(direction).collect());
                }
            }
            if let (Some(first), Some(last)) = (found.pivots.first(), found.pivots.last()) {
                self.weakest = self.weakest.min(last / first);
            }
            self.weak += found.order.len() - found.rank_above(threshold.max(WEAK));
            found.order
        } else {
            self.free = None;
            let members = || members.iter().map(|&row| &rows[row].entries[..]);
            let found = insertion::independent(members(), threshold);
            self.weak += found.len() - insertion::independent(members(), threshold.max(WEAK)).len();
            found
        };
        if independent.len() == freedoms.len() {
            freedoms.iter().for_each(|&freedom| (self.still[freedom], self.locked[freedom]) = (true, true));
        }
        for row in independent {
            self.implied[members[row]].1 = false;
        }
    }
}

/// The freedoms and the rows of every block of rows that share freedoms; a freedom in no row is a block alone.
fn blocks(rows: &[Row], count: usize) -> Vec<(Vec<usize>, Vec<usize>)> {
    let mut freedoms = DisjointSets::new(count);
    for row in rows {
        for pair in row.entries.windows(2) {
            freedoms.unite(pair[0].0, pair[1].0);
        }
    }
    let number = freedoms.clone().numbers();
    let mut blocks: Vec<(Vec<usize>, Vec<usize>)> =
        freedoms.parts().into_iter().map(|freedoms| (freedoms, Vec::new())).collect();
    for (index, row) in rows.iter().enumerate() {
        // A row without freedoms stays implied.
        if let Some(&(freedom, _)) = row.entries.first() {
            blocks[number[freedom]].1.push(index);
        }
    }
    blocks
}
