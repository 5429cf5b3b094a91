//! Decisions about the closures at the start of a run, made once: the rank of the run, the freedoms that cannot move, the inertia that is lent.
//!
//! ```text
//!     rank  = max(rank here, rank beside)        beside = the start displaced by some 1e-3 and put back on the closures, two of them
//!     still = freedoms without a part in the null space, here and beside:  a dead point is still here alone
//! ```
//!
//! A position is singular by as many equations as the rank here is less. Steps never count again: the decisions of the start hold beside a singular
//! position, too. A block whose rank is the number of its freedoms is locked, and needs no neighbours.

use crate::coupled::counted::Counted;
use crate::coupled::known::Known;
use crate::coupled::projection::Projection;
use crate::coupled::system::{Geometry, One};
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::motion::kinematics::body_states;
use catena_mechanism::motion::state::State;
use catena_mechanism::structure::ranks::counting::{ROUNDING, Ranks};
use catena_mechanism::structure::ranks::rows::{Row, mimic_rows, scales, tell_what_adheres};

/// Decisions about the closures at the start of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Decided {
    /// The ranks at the position with the rank of the run: here, or beside.
    pub ranks: Ranks,
    /// The rank of the run less the rank here.
    pub singular: usize,
    /// For every freedom whether it cannot move.
    pub still: Vec<bool>,
}

impl Decided {
    /// For a mechanism in the state that was counted in, which is on its closures.
    pub fn from(counted: &Counted, mechanism: &Mechanism) -> Self {
        let here = &counted.ranks;
        let redundant = here.implied.iter().any(|(_, implied)| *implied);
        // If every freedom is determined by an independent equation, the neighbours cannot have a larger rank.
        if here.freedoms() == 0 || !(redundant || here.still.contains(&true)) {
            return Decided { singular: 0, still: here.still.clone(), ranks: here.clone() };
        }
        let beside = counted.beside(mechanism);
        let moves_nowhere = |freedom: &usize| beside.iter().all(|ranks| ranks.still[*freedom]) && !beside.is_empty();
        let still = (0..here.still.len())
            .map(|freedom| here.still[freedom] && (here.locked[freedom] || moves_nowhere(&freedom)));
        let still = still.collect();
        let rank = here.rank();
        let best = beside.iter().max_by_key(|ranks| ranks.rank()).filter(|ranks| ranks.rank() > rank);
        let singular = best.map_or(0, |best| best.rank() - rank);
        Decided { ranks: best.unwrap_or(here).clone(), singular, still }
    }
}

/// The flags of the closures for callers that compute multipliers in the counted state, or near it.
pub fn known(counted: &Counted, mechanism: &Mechanism) -> Known {
    let here = &counted.ranks;
    // The neighbours are asked only where a freedom is still here.
    let undecided = here.still.iter().zip(&here.locked).any(|(&still, &locked)| still && !locked);
    let still = if undecided { Decided::from(counted, mechanism).still } else { here.still.clone() };
    let or_nothing = |flags: Vec<bool>| if flags.contains(&true) { flags } else { Vec::new() };
    let (still, locked) = (or_nothing(still), or_nothing(here.locked.clone()));
    Known { still, locked, weak: here.weak, ..counted.known_nearby() }
}

/// The ranks of equations without the turnings that contacts hold, which count as implied. A flat end stands on its points, whose forces press, and
/// needs no moments; equations of velocities agree with gaps of places to truncation alone, and give way to them.
fn ranks_without_turnings(mechanism: &Mechanism, mut rows: Vec<Row>, lengths: Vec<f64>) -> Ranks {
    for (number, joint) in mechanism.touches.iter().enumerate() {
        let closure = mechanism.loops.len() + number;
        let own = rows.iter_mut().rev().filter(|row| row.closure == closure);
        own.take(joint.moments.rows()).for_each(|row| row.entries.clear());
    }
    Ranks::of(&rows, lengths, ROUNDING)
}

/// The flags of the closures for steps from the counted state: also the equations of a geometry that the others imply, in the position (here or
/// beside) with the larger rank.
pub fn known_of_steps<G: Geometry<One>>(
    counted: &Counted,
    mechanism: &Mechanism,
    projection: &mut Projection<G>,
    start: &mut G::Start,
) -> Known {
    let mut known = known(counted, mechanism);
    let mut ranks_at = |state: &State| {
        projection.place(mechanism, start, state);
        let (sizes, lengths) = scales(mechanism, &body_states(mechanism, state));
        let mut rows = projection.equations(start, &sizes, &lengths);
        rows.extend(mimic_rows(mechanism, state, &lengths));
        tell_what_adheres(mechanism, &mut rows);
        ranks_without_turnings(mechanism, rows, lengths)
    };
    let mut best = ranks_at(&counted.state);
    if best.implied.iter().any(|(_, implied)| *implied) {
        if best.freedoms() > 0 {
            for neighbour in counted.neighbours(mechanism) {
                let beside = ranks_at(neighbour);
                best = if beside.rank() > best.rank() { beside } else { best };
            }
        }
        known.implied = best.implied.iter().map(|(_, implied)| *implied).collect();
        known.borne = best.borne;
    }
    known
}
