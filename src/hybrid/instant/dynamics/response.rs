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
pub struct Response {
    mechanism: Arc<Mechanism>,
    /// On which tree, once a state has been asked for.
    way: Option<Way>,
    unit: Vec<f64>,
    trees: Arc<Trees>,
}

/// The trees of a mechanism, by their first bodies.
struct Trees {
    /// The tree of each degree of freedom.
    of_freedoms: Vec<usize>,
    /// The degrees of freedom of each tree; none for bodies that begin no tree.
    freedoms: Vec<Vec<usize>>,
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
        let mut roots: Vec<usize> = Vec::with_capacity(mechanism.bodies.len());
        let (bodies, count) = (mechanism.bodies.len(), mechanism.velocity_count);
        let mut trees = Trees { of_freedoms: vec![0; count], freedoms: vec![Vec::new(); bodies] };
        for (index, body) in mechanism.bodies.iter().enumerate() {
            roots.push(body.parent.map_or(index, |parent| roots[parent]));
            trees.of_freedoms[body.joint.velocity_range()].fill(roots[index]);
            trees.freedoms[roots[index]].extend(body.joint.velocity_range());
        }
        let trees = Arc::new(trees);
        Response { mechanism: Arc::new(mechanism.clone()), way: None, unit: vec![0.0; count], trees }
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

    /// Y Wᵀ (n × m) for rows W of efforts, at a state. Rows that act on different trees are answered together.
    pub fn answers(&mut self, state: &State, rows: &[impl Deref<Target = [f64]>]) -> DMatrix<f64> {
        self.place(state);
        let mut columns = DMatrix::zeros(self.unit.len(), rows.len());
        let mut column = vec![0.0; self.unit.len()];
        if !matches!(&self.way, Some(Way::OfFile(response)) if response.trees_are_apart(&self.trees.of_freedoms)) {
            for (index, row) in rows.iter().enumerate() {
                self.answer(row, &mut column);
                columns.column_mut(index).copy_from_slice(&column);
            }
            return columns;
        }
        let trees = self.trees.clone();
        let of_rows: Vec<Vec<usize>> = rows.iter().map(|row| acting(row, &trees.of_freedoms)).collect();
        let freedoms = |row: usize| of_rows[row].iter().flat_map(|&tree| trees.freedoms[tree].iter().copied());
        let mut efforts = std::mem::take(&mut self.unit);
        for group in groups(&of_rows, self.mechanism.bodies.len()) {
            efforts.fill(0.0);
            for &row in &group {
                freedoms(row).for_each(|freedom| efforts[freedom] = rows[row][freedom]);
            }
            self.answer(&efforts, &mut column);
            for &row in &group {
                freedoms(row).for_each(|freedom| columns[(freedom, row)] = column[freedom]);
            }
        }
        efforts.fill(0.0);
        self.unit = efforts;
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

/// The trees on which a row acts, in their order.
fn acting(row: &[f64], trees: &[usize]) -> Vec<usize> {
    let acting = row.iter().zip(trees).filter(|(entry, _)| **entry != 0.0).map(|(_, tree)| *tree);
    let mut acting: Vec<usize> = acting.collect();
    acting.sort_unstable();
    acting.dedup();
    acting
}

/// Rows in groups of which no two act on the same tree, of this number of bodies.
fn groups(of_rows: &[Vec<usize>], bodies: usize) -> Vec<Vec<usize>> {
    let mut next = vec![0; bodies];
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for (row, trees) in of_rows.iter().enumerate() {
        let group = trees.iter().map(|&tree| next[tree]).max().unwrap_or(0);
        trees.iter().for_each(|&tree| next[tree] = group + 1);
        groups.resize(groups.len().max(group + 1), Vec::new());
        groups[group].push(row);
    }
    groups
}

impl Elsewhere {
    /// Itself, if all joints move something that has inertia: if its answer to its efforts is finite.
    fn if_it_answers(mut self) -> Option<Self> {
        let Elsewhere { inside, own, efforts, answer, .. } = &mut self;
        inside.place(own);
        inside.answer(efforts, answer);
        answer.iter().all(|rate| rate.is_finite()).then_some(self)
    }
}

impl Way {
    /// The one with the least work; the axes of loop joints point as they do in a state.
    fn new(file: &Mechanism, state: &State) -> Self {
        // In space, as the projections are.
        let found = other_tree(file, &[], &[Rule::Planar]);
        let other = found.and_then(|(tree, _)| OtherTree::new(file, &tree, None, state).ok());
        let elsewhere = other.map(|mut other| {
            let freedoms = other.mechanism.velocity_count;
            let mut own = State::zero(&other.mechanism);
            other.take(file, state, &mut own);
            let inside = ResponseOnTree::new(&other.mechanism);
            let (efforts, answer) = (vec![1.0; freedoms], vec![0.0; freedoms]);
            Elsewhere { inside, state: State::zero(file), own, efforts, answer, other }
        });
        // A joint of the other tree may move a link without mass alone, which has no answer.
        let elsewhere = elsewhere.and_then(Elsewhere::if_it_answers);
        elsewhere.map_or_else(
            || Way::OfFile(Box::new(ResponseOnTree::new(file))),
            |elsewhere| Way::Elsewhere(Box::new(elsewhere)),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instant::cone::scenes::Random;
    use crate::mechanism::description::closure::{Coordinate, Mimic};
    use crate::mechanism::description::joint::{Joint, JointKind, Pose};
    use crate::mechanism::description::mechanism::Body;
    use crate::mechanism::description::target::Target;
    use nalgebra::Vector3;

    #[test]
    fn rows_on_different_trees_that_are_answered_together_are_answered_as_alone() {
        // Three trees of two bodies, with seven freedoms each.
        let body = |number: usize| {
            let kind = if number.is_multiple_of(2) { JointKind::Floating } else { JointKind::Revolute };
            let joint = Joint::new("joint", kind, Pose::translation(0.1, 0.2, 0.3), Pose::translation(0.0, -0.2, 0.1));
            let (mass, inertia) = (1.0 + number as f64, Vector3::new(0.1, 0.2, 0.25));
            Body { name: "body".into(), parent: (number % 2 == 1).then(|| number - 1), mass, inertia, joint }
        };
        let alone = Mechanism::new("trees", Vector3::zeros(), (0..6).map(body).collect()).expect("trees");
        // The joint inside the second tree is moved in time in the other case.
        let moved = Coordinate { body: 3, position: 15, freedom: 13 };
        let mut with_motion = alone.clone();
        with_motion.mimics = vec![Mimic::moved("moved".into(), moved, Target::constant(0.1))];
        let mut random = Random::new(7);
        // A row on each tree, one on each two, and one on none.
        let acts = [vec![0], vec![1], vec![2], vec![0, 1], vec![1, 2], vec![0, 2], vec![], vec![1]];
        let rows: Vec<Vec<f64>> = acts
            .iter()
            .map(|acts| {
                (0..21).map(|freedom| if acts.contains(&(freedom / 7)) { random.signed() } else { 0.0 }).collect()
            })
            .collect();
        for mechanism in [&alone, &with_motion] {
            let state = State::zero(mechanism);
            let mut response = Response::new(mechanism);
            let together = response.answers(&state, &rows);
            assert!(
                matches!(&response.way, Some(Way::OfFile(own)) if own.trees_are_apart(&response.trees.of_freedoms))
            );
            for (index, row) in rows.iter().enumerate() {
                let mut alone = vec![0.0; 21];
                response.answer(row, &mut alone);
                assert_eq!(together.column(index).as_slice(), alone.as_slice(), "row {index}");
                assert_eq!(alone.iter().any(|rate| *rate != 0.0), !acts[index].is_empty());
            }
        }
        let response = Response::new(&alone);
        let of_rows: Vec<Vec<usize>> = rows.iter().map(|row| acting(row, &response.trees.of_freedoms)).collect();
        assert_eq!(groups(&of_rows, 6), [vec![0, 1, 2, 6], vec![3], vec![4], vec![5, 7]]);
    }
}
