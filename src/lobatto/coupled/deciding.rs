//! What the start of a run decides about the closures, once: the rank of the run, the freedoms that cannot move, the inertia that is lent.
//!
//! ```text
//!     rank  = max(rank here, rank beside)        beside = the start displaced by some 1e-3 and put back on the closures, two of them
//!     still = freedoms without a part in the null space, here and beside:  a dead point is still here alone
//! ```
//!
//! A position is singular by as many equations as the rank here is less. Steps never count again: beside a singular position nothing changes of what
//! is decided here. A block whose rank is the number of its freedoms is locked, and needs no neighbours.

use crate::coupled::known::Known;
use crate::coupled::projection::Projection;
use crate::coupled::system::{Geometry, One};
use crate::stages::start::Start;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::motion::kinematics::body_states;
use catena_mechanism::motion::state::State;
use catena_mechanism::structure::ranks::counting::{ROUNDING, Ranks};
use catena_mechanism::structure::ranks::lending::lent_inertia;
use catena_mechanism::structure::ranks::rows::{mimic_rows, scales};

/// How far the neighbours are displaced (rad, and of a slide in lengths of its loops).
const ASIDE: f64 = 1e-3;
/// A neighbour with larger gaps [rad, and over the size of the loops] is not on the closures.
const CLOSED: f64 = 1e-11;

/// What the closures say at the start of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Decided {
    /// Where the rank is that of the run: here, or beside.
    pub ranks: Ranks,
    /// By how many equations the rank here is less than that of the run.
    pub singular: usize,
    /// For every freedom whether it cannot move.
    pub still: Vec<bool>,
}

impl Decided {
    /// For a mechanism in a state, which is on its closures.
    pub fn at(mechanism: &Mechanism, state: &State) -> Self {
        let here = Ranks::at(mechanism, state);
        let redundant = here.implied.iter().any(|(_, implied)| *implied);
        // With as many independent equations as freedoms there is nothing to be gained beside.
        if here.freedoms() == 0 || !(redundant || here.still.contains(&true)) {
            return Decided { singular: 0, still: here.still.clone(), ranks: here };
        }
        let beside: Vec<Ranks> = neighbours(mechanism, state, &here, &lent_inertia(mechanism, state, &here))
            .iter()
            .map(|neighbour| Ranks::at(mechanism, neighbour))
            .collect();
        let moves_nowhere = |freedom: &usize| beside.iter().all(|ranks| ranks.still[*freedom]) && !beside.is_empty();
        let still = (0..here.still.len())
            .map(|freedom| here.still[freedom] && (here.locked[freedom] || moves_nowhere(&freedom)));
        let still = still.collect();
        let rank = here.rank();
        let best = beside.into_iter().max_by_key(Ranks::rank).filter(|ranks| ranks.rank() > rank);
        let singular = best.as_ref().map_or(0, |best| best.rank() - rank);
        Decided { ranks: best.unwrap_or(here), singular, still }
    }
}

/// Two states beside one, back on the closures, with the inertia that is lent in that one; fewer where they could not be put there.
fn neighbours(mechanism: &Mechanism, state: &State, here: &Ranks, lent: &[f64]) -> Vec<State> {
    [0.4, 2.6].iter().filter_map(|&phase| neighbour(mechanism, state, here, lent, phase)).collect()
}

fn neighbour(mechanism: &Mechanism, state: &State, here: &Ranks, lent: &[f64], phase: f64) -> Option<State> {
    let aside: Vec<f64> = here
        .lengths
        .iter()
        .enumerate()
        .map(|(freedom, length)| ASIDE * length * (1.7 * freedom as f64 + phase).sin())
        .collect();
    let mut neighbour = state.clone();
    neighbour.displace(mechanism, &aside);
    let (mut projection, mut start) = (Projection::new(mechanism), Start::new(mechanism));
    let mut known = Known { lent: lent.to_vec(), ..Known::default() };
    projection.heed(known.clone());
    let first = projection.positions(mechanism, &mut start, &mut neighbour).gap;
    // Where much is redundant all equations alike leave roundings; where the position is singular those that are implied here are needed beside.
    known.implied = here.implied.iter().map(|(_, implied)| *implied).collect();
    projection.heed(known);
    let gap = if first <= CLOSED { first } else { projection.positions(mechanism, &mut start, &mut neighbour).gap };
    let length = here.lengths.iter().fold(1.0_f64, |most, &length| most.max(length));
    (gap <= CLOSED * length).then_some(neighbour)
}

/// What those need to know of the closures who ask for multipliers in a state or near it.
pub fn known(mechanism: &Mechanism, state: &State) -> Known {
    if !mechanism.has_closures() {
        return Known::default();
    }
    let here = Ranks::at(mechanism, state);
    let lent = lent_inertia(mechanism, state, &here);
    // The neighbours are asked only where a freedom is still here.
    let undecided = here.still.iter().zip(&here.locked).any(|(&still, &locked)| still && !locked);
    let still = if undecided { Decided::at(mechanism, state).still } else { here.still };
    let or_nothing = |flags: Vec<bool>| if flags.contains(&true) { flags } else { Vec::new() };
    Known { still: or_nothing(still), locked: or_nothing(here.locked), lent, ..Known::default() }
}

/// What steps from a state need to know of the closures: the equations of a geometry that the others imply, too, where most of them are
/// independent, here or beside.
pub fn known_of_steps<G: Geometry<One>>(
    mechanism: &Mechanism,
    state: &State,
    projection: &mut Projection<G>,
    start: &mut G::Start,
) -> Known {
    let mut known = known(mechanism, state);
    let mut ranks_at = |state: &State| {
        projection.place(mechanism, start, state);
        let (sizes, lengths) = scales(mechanism, &body_states(mechanism, state));
        let mut rows = projection.equations(start, &sizes, &lengths);
        rows.extend(mimic_rows(mechanism, state, &lengths));
        Ranks::of(&rows, lengths, ROUNDING)
    };
    let mut best = ranks_at(state);
    if best.implied.iter().any(|(_, implied)| *implied) {
        if best.freedoms() > 0 {
            for neighbour in neighbours(mechanism, state, &Ranks::at(mechanism, state), &known.lent) {
                let beside = ranks_at(&neighbour);
                best = if beside.rank() > best.rank() { beside } else { best };
            }
        }
        known.implied = best.implied.iter().map(|(_, implied)| *implied).collect();
    }
    known
}
