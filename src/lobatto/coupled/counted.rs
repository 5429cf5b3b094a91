//! The ranks of the closures in one state, counted once, for the assembly, for the decisions of a run, and for the kernels.

use crate::coupled::known::Known;
use crate::coupled::projection::Projection;
use crate::plan::spanning::spanning_tree;
use crate::stages::start::Start;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::motion::state::State;
use catena_mechanism::structure::other_tree::OtherTree;
use catena_mechanism::structure::ranks::counting::Ranks;
use catena_mechanism::structure::ranks::lending::lent_inertia;
use catena_mechanism::structure::spanning_tree::Graph;
use std::sync::OnceLock;

/// How far the neighbours are displaced (rad, and of a slide in lengths of its loops).
const ASIDE: f64 = 1e-3;
/// A neighbour with larger gaps [rad, and over the size of the loops] is not on the closures.
const CLOSED: f64 = 1e-11;
/// A state that is farther away than this is no neighbour, in the unit of [`ASIDE`]: closures may lead from a redundant position to another one, as two
/// cards that lean on each other to two that lie flat, which have other ranks.
const FAR: f64 = 100.0 * ASIDE;

/// The ranks in a state and beside it, and the inertia lent to light freedoms there.
#[derive(Clone, Debug)]
pub struct Counted {
    /// The state.
    pub(crate) state: State,
    /// The ranks in it.
    pub(crate) ranks: Ranks,
    /// Inertia lent to every freedom [kg m² or kg]; empty if it is zero.
    pub(crate) lent: Vec<f64>,
    neighbours: OnceLock<Vec<State>>,
    beside: OnceLock<Vec<Ranks>>,
}

impl Counted {
    /// Counts in a state, on the closures or near them.
    pub fn at(mechanism: &Mechanism, state: &State) -> Self {
        let ranks = Ranks::at(mechanism, state);
        let lent = lent_inertia(mechanism, state, &ranks);
        Counted { state: state.clone(), ranks, lent, neighbours: OnceLock::new(), beside: OnceLock::new() }
    }

    /// Whether it was counted at these positions. Velocities do not matter.
    pub fn is_at(&self, state: &State) -> bool {
        self.state.position == state.position && self.state.compensation == state.compensation
    }

    /// Ranks and flags for a state that is not on the closures yet.
    pub fn known_nearby(&self) -> Known {
        Known { lent: self.lent.clone(), ..Known::default() }
    }

    /// Two states beside this one, back on the closures; fewer where they could not be put there.
    pub(crate) fn neighbours(&self, mechanism: &Mechanism) -> &[State] {
        let both = || {
            let mut projection = Projection::new(mechanism);
            [0.4, 2.6].iter().filter_map(|&phase| self.neighbour(mechanism, phase, &mut projection)).collect()
        };
        self.neighbours.get_or_init(|| self.neighbours_elsewhere(mechanism).unwrap_or_else(both))
    }

    /// The same by way of another spanning tree, if that is less work.
    fn neighbours_elsewhere(&self, mechanism: &Mechanism) -> Option<Vec<State>> {
        let tree = spanning_tree(&Graph::new(mechanism, None))?;
        let mut other = OtherTree::new(mechanism, &tree, None, &self.state).ok()?;
        let mut own = State::zero(&other.mechanism);
        other.take(mechanism, &self.state, &mut own);
        let there = Counted::at(&other.mechanism, &own).neighbours(&other.mechanism).to_vec();
        let here = |neighbour: &State| {
            let mut state = self.state.clone();
            other.give(mechanism, neighbour, &mut state);
            state
        };
        Some(there.iter().map(here).collect())
    }

    /// The ranks in the neighbours.
    pub(crate) fn beside(&self, mechanism: &Mechanism) -> &[Ranks] {
        let all = || self.neighbours(mechanism).iter().map(|neighbour| Ranks::at(mechanism, neighbour)).collect();
        self.beside.get_or_init(all)
    }

    fn neighbour(&self, mechanism: &Mechanism, phase: f64, projection: &mut Projection) -> Option<State> {
        let lengths = &self.ranks.lengths;
        let aside = |(freedom, length): (usize, &f64)| ASIDE * length * (1.7 * freedom as f64 + phase).sin();
        let aside: Vec<f64> = lengths.iter().enumerate().map(aside).collect();
        let mut neighbour = self.state.clone();
        neighbour.displace(mechanism, &aside);
        let displaced = neighbour.clone();
        let length = lengths.iter().fold(1.0_f64, |most, &length| most.max(length));
        let is_near = |state: &State| {
            let moved = state.position.iter().zip(&self.state.position).map(|(one, other)| (one - other).abs());
            moved.fold(0.0, f64::max) <= FAR * length
        };
        let mut start = Start::new(mechanism);
        let mut known = self.known_nearby();
        projection.heed(known.clone());
        let first = projection.positions(mechanism, &mut start, &mut neighbour).gap;
        let went_far = !is_near(&neighbour);
        if went_far {
            neighbour = displaced;
        }
        // If all equations are treated alike, a very redundant mechanism leaves roundings of the gaps. At a singular position, equations that are
        // implied only there are needed beside it.
        known.implied = self.ranks.implied.iter().map(|(_, implied)| *implied).collect();
        projection.heed(known);
        let is_done = first <= CLOSED && !went_far;
        let gap = if is_done { first } else { projection.positions(mechanism, &mut start, &mut neighbour).gap };
        (gap <= CLOSED * length && is_near(&neighbour)).then_some(neighbour)
    }
}
