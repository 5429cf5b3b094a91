//! The blocks that close in a step of first order, and the contacts and limits that have pressed in it.
//!
//! ```text
//!     0 ≤ P_N ⊥ u_N + φ/h ≥ 0,   u = D P + W v_f
//!     for the blocks that come together, u_N + φ/h < 0 at P = 0, and the blocks that their impulses push together
//! ```
//!
//! φ is the gap of a block, P its impulses (N s), h the length of the step (s), v_f the velocities without impulses. Hundreds of points of a mesh are
//! near a floor, and few of them take part.

use crate::instant::cone::problem::{Law, Problem};
use crate::instant::cone::solve_roughly;
use crate::instant::holding::blocks::{Block, Of, Rows};
use crate::instant::holding::moments::{give_loads, have_moments};
use crate::instant::holding::touching::Contact;
use crate::mechanism::motion::event::Side;
use nalgebra::{DMatrix, DVector};

/// Rounds in which those that others push together are added, at most.
const ROUNDS: usize = 8;
/// Blocks that come together more slowly than this part of the largest rate do not close.
const APPROACHES: f64 = 1e-12;
/// Rounds in which moments of friction get the normal impulses that bound them.
const LOADS: usize = 4;
/// A contact is held by friction where it needs less than this part of what there is.
const HOLDS: f64 = 1.0 - 1e-9;

/// Blocks that may close or hold in a step, with their gaps (m or rad), and the contacts by their numbers in the blocks.
#[derive(Default)]
pub(super) struct Closing {
    pub blocks: Vec<Block>,
    pub gaps: Vec<f64>,
    pub contacts: Vec<Contact>,
    /// The limits that blocks are.
    pub sides: Vec<Option<Side>>,
}

/// A limit that has pressed in a step.
pub(super) struct Bearing {
    pub joint: usize,
    pub side: Side,
    /// Its gap where the step began (rad or m).
    pub gap: f64,
}

/// A contact that has pressed in a step.
pub(super) struct Pressed {
    pub contact: Contact,
    /// Its gap where the step began (m).
    pub gap: f64,
    /// Whether friction has held it.
    pub holds: bool,
}

/// The limits that have pressed with these impulses.
pub(super) fn limits_in(blocks: &[Block], gaps: &[f64], sides: &[Option<Side>], impulses: &[f64]) -> Vec<Bearing> {
    let (mut row, mut limits) = (0, Vec::new());
    for ((block, &gap), &side) in blocks.iter().zip(gaps).zip(sides) {
        if let (Of::Joint(joint), Some(side)) = (block.of, side)
            && impulses[row] > 0.0
        {
            limits.push(Bearing { joint, side, gap });
        }
        row += block.rows.len();
    }
    limits
}

/// The contacts that have pressed with these impulses.
pub(super) fn pressed_in(blocks: &[Block], gaps: &[f64], contacts: &[Contact], impulses: &[f64]) -> Vec<Pressed> {
    let (mut row, mut pressed) = (0, Vec::new());
    for (block, &gap) in blocks.iter().zip(gaps) {
        let own = &impulses[row..row + block.rows.len()];
        row += own.len();
        if let (Of::Contact(contact), [pressure, across @ ..]) = (block.of, own)
            && *pressure > 0.0
        {
            let holds = match (block.law, across) {
                (Law::Contact { friction }, [first, second]) => first.hypot(*second) < HOLDS * friction * pressure,
                _ => false,
            };
            pressed.push(Pressed { contact: contacts[contact].clone(), gap, holds });
        }
    }
    pressed
}

/// The impulses of blocks for these rates without them. Blocks that do not come together take part only if others push them together, because many
/// points of a mesh are near.
pub(super) fn impulses_among(rows: &Rows, rates: &[f64], blocks: &[Block]) -> Vec<f64> {
    let mut starts = Vec::with_capacity(blocks.len());
    let mut first = 0;
    for block in blocks {
        starts.push(first);
        first += block.rows.len();
    }
    // The moments of a contact are among the blocks if the contact is.
    let mut owners: Vec<usize> = Vec::with_capacity(blocks.len());
    for (index, block) in blocks.iter().enumerate() {
        let moment = matches!(block.of, Of::Moment { .. });
        owners.push(owners.last().copied().filter(|_| moment).unwrap_or(index));
    }
    let least = APPROACHES * rates.iter().fold(0.0_f64, |most, rate| most.max(rate.abs()));
    let approaches = |block: usize, rates: &[f64]| match blocks[block].law {
        Law::Interval { lower, .. } if lower < 0.0 => true,
        _ => rates[starts[owners[block]]] < -least,
    };
    let mut part: Vec<usize> = (0..blocks.len()).filter(|&block| approaches(block, rates)).collect();
    let mut impulses = vec![0.0; rates.len()];
    for _ in 0..ROUNDS {
        let own: Vec<usize> =
            part.iter().flat_map(|&block| starts[block]..starts[block] + blocks[block].rows.len()).collect();
        let mut mobility = DMatrix::from_fn(own.len(), own.len(), |i, j| rows.square[(own[i], own[j])]);
        let mut free: Vec<f64> = own.iter().map(|&row| rates[row]).collect();
        let laws: Vec<Law> = part.iter().map(|&block| blocks[block].law).collect();
        let of_part: Vec<Block> = part.iter().map(|&block| blocks[block].clone()).collect();
        let mut found = vec![0.0; own.len()];
        for _ in 0..if have_moments(&of_part) { LOADS } else { 1 } {
            give_loads(&of_part, &mut mobility, &mut free, &found);
            let answer = solve_roughly(&Problem { mobility: &mobility, free: &free, laws: &laws });
            found = answer.unwrap_or_else(|| vec![0.0; own.len()]);
        }
        impulses.fill(0.0);
        own.iter().zip(found).for_each(|(&row, impulse)| impulses[row] = impulse);
        let after = &rows.square * DVector::from_column_slice(&impulses) + DVector::from_column_slice(rates);
        let more: Vec<usize> =
            (0..blocks.len()).filter(|block| !part.contains(block) && approaches(*block, after.as_slice())).collect();
        if more.is_empty() {
            break;
        }
        part.extend(more);
        part.sort_unstable();
    }
    impulses
}
