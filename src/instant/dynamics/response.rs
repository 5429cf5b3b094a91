//! The response of a mechanism to efforts and impulses at one instant, with its closures, computed on the spanning tree with the least work.
//!
//! ```text
//!     a = a_free + Y τ          accelerations under efforts τ            a_free: without them
//!     v⁺ = v⁻ + Y P             velocities after impulses P
//! ```
//!
//! Y (n × n) is symmetric and positive semidefinite ([`crate::instant::dynamics::response_on_tree`]). On another tree with the rates `v = S v'` of
//! motions that the closures allow, efforts act as `τ' = Sᵀ τ`, so that `Y τ = S Y' Sᵀ τ` ([`crate::mechanism::structure::other_efforts`]).

use crate::instant::dynamics::response_on_tree::ResponseOnTree;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::description::rules::Rule;
use crate::mechanism::motion::state::State;
use crate::mechanism::structure::other_tree::OtherTree;
use crate::stepping::trees::other_tree::other_tree;
use nalgebra::DMatrix;
use std::ops::Deref;
use std::sync::Arc;

/// The workspace of one mechanism.
#[derive(Clone)]
pub(crate) struct Response {
    mechanism: Arc<Mechanism>,
    /// On which tree, once a state has been asked for.
    way: Option<Way>,
    unit: Vec<f64>,
}

#[derive(Clone)]
enum Way {
    OfFile(Box<ResponseOnTree>),
    Elsewhere(Box<Elsewhere>),
}

/// On another tree.
#[derive(Clone)]
struct Elsewhere {
    other: OtherTree,
    inside: ResponseOnTree,
    state: State,
    own: State,
    efforts: Vec<f64>,
    answer: Vec<f64>,
}

impl Response {
    /// For a mechanism with its forces.
    pub fn new(mechanism: &Mechanism) -> Self {
        Response { mechanism: Arc::new(mechanism.clone()), way: None, unit: vec![0.0; mechanism.velocity_count] }
    }

    /// The way, chosen in the first state that is asked for.
    fn way(&mut self, state: &State) -> (&Mechanism, &mut Way) {
        let Response { mechanism, way, .. } = self;
        (mechanism, way.get_or_insert_with(|| Way::new(mechanism, state)))
    }

    /// The accelerations of a state under its forces and these efforts, one entry a degree of freedom.
    pub fn accelerations(&mut self, state: &State, efforts: &[f64], out: &mut [f64]) {
        match self.way(state) {
            (_, Way::OfFile(response)) => response.accelerations(state, efforts, out),
            (file, Way::Elsewhere(elsewhere)) => {
                let Elsewhere { other, inside, own, efforts: own_efforts, answer, .. } = &mut **elsewhere;
                other.take(file, state, own);
                other.take_efforts(file, own, efforts, own_efforts);
                inside.accelerations(own, own_efforts, answer);
                other.give_accelerations(file, [state, own], answer, out);
            }
        }
    }

    /// Takes a state at which columns of Y are asked for.
    fn place(&mut self, state: &State) {
        match self.way(state) {
            (_, Way::OfFile(response)) => response.place(state),
            (file, Way::Elsewhere(elsewhere)) => {
                elsewhere.other.take(file, state, &mut elsewhere.own);
                elsewhere.inside.place(&elsewhere.own);
            }
        }
    }

    /// Y τ for efforts τ at the state that was taken last.
    fn answer(&mut self, efforts: &[f64], out: &mut [f64]) {
        let Response { mechanism: file, way, .. } = self;
        match way {
            None => {}
            Some(Way::OfFile(response)) => response.answer(efforts, out),
            Some(Way::Elsewhere(elsewhere)) => {
                let Elsewhere { other, inside, state, own, efforts: own_efforts, answer } = &mut **elsewhere;
                other.take_efforts(file, own, efforts, own_efforts);
                inside.answer(own_efforts, answer);
                other.give_coordinates(file, (&own.position, answer), &mut state.position, out);
            }
        }
    }

    /// The column of Y for one degree of freedom at the state that was taken last.
    fn column(&mut self, freedom: usize, out: &mut [f64]) {
        let mut unit = std::mem::take(&mut self.unit);
        unit[freedom] = 1.0;
        self.answer(&unit, out);
        unit[freedom] = 0.0;
        self.unit = unit;
    }

    /// Y Wᵀ (n × m) for rows W of efforts, at a state.
    pub fn answers(&mut self, state: &State, rows: &[impl Deref<Target = [f64]>]) -> DMatrix<f64> {
        self.place(state);
        let mut columns = DMatrix::zeros(self.unit.len(), rows.len());
        let mut column = vec![0.0; self.unit.len()];
        for (index, row) in rows.iter().enumerate() {
            self.answer(row, &mut column);
            columns.column_mut(index).copy_from_slice(&column);
        }
        columns
    }

    /// The entries on the diagonal of Y of some degrees of freedom at a state.
    pub fn diagonal(&mut self, state: &State, freedoms: impl Iterator<Item = usize>) -> Vec<f64> {
        self.place(state);
        let mut column = vec![0.0; self.unit.len()];
        let entries = freedoms.map(|freedom| {
            self.column(freedom, &mut column);
            column[freedom]
        });
        entries.collect()
    }

    /// Y for some degrees of freedom: their columns (n × m), and `D = W Y Wᵀ` (m × m), the rows of which they are.
    pub fn matrix(&mut self, state: &State, freedoms: &[usize]) -> (DMatrix<f64>, DMatrix<f64>) {
        self.place(state);
        let mut columns = DMatrix::zeros(self.unit.len(), freedoms.len());
        let mut column = vec![0.0; self.unit.len()];
        for (index, &freedom) in freedoms.iter().enumerate() {
            self.column(freedom, &mut column);
            columns.column_mut(index).copy_from_slice(&column);
        }
        let half = |row: usize, other: usize| columns[(freedoms[row], other)];
        let square = DMatrix::from_fn(freedoms.len(), freedoms.len(), |row, column| {
            // Symmetric to the last bit.
            0.5 * (half(row, column) + half(column, row))
        });
        (columns, square)
    }

    /// Brings velocities on the closures, with the least change in the metric of H.
    pub fn close_velocities(&mut self, state: &mut State) {
        match self.way(state) {
            (_, Way::OfFile(response)) => response.close_velocities(state),
            (file, Way::Elsewhere(elsewhere)) => {
                let Elsewhere { other, inside, state: room, own, .. } = &mut **elsewhere;
                other.take(file, state, own);
                inside.close_velocities(own);
                let coordinates = (&own.position[..], &own.velocity[..]);
                other.give_coordinates(file, coordinates, &mut room.position, &mut state.velocity);
            }
        }
    }
}

impl Way {
    /// The one with the least work; the axes of loop joints point as they do in a state.
    fn new(file: &Mechanism, state: &State) -> Self {
        // In space, as the projections are.
        let found = other_tree(file, &[], &[Rule::Planar]);
        let other = found.and_then(|(tree, _)| OtherTree::new(file, &tree, None, state).ok());
        let Some(other) = other else { return Way::OfFile(Box::new(ResponseOnTree::new(file))) };
        let freedoms = other.mechanism.velocity_count;
        Way::Elsewhere(Box::new(Elsewhere {
            inside: ResponseOnTree::new(&other.mechanism),
            state: State::zero(file),
            own: State::zero(&other.mechanism),
            efforts: vec![0.0; freedoms],
            answer: vec![0.0; freedoms],
            other,
        }))
    }
}
