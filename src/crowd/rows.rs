//! The rows of contacts, limits, friction and motors on the trees.
//!
//! A row is the work of a unit force: one entry for each freedom on the way to the bodies, positive on the second body of a contact, negative on the
//! first.

use crate::trees::Trees;
use nalgebra::Vector3;

/// The rows of one block on one tree.
#[derive(Clone, Copy, Debug)]
pub struct Side {
    /// The tree.
    pub tree: usize,
    /// Number of freedoms.
    pub count: usize,
    /// Whether they are all six of a free body, in their order.
    pub free: bool,
    columns: usize,
    entries: usize,
}

/// The rows of many blocks.
#[derive(Clone, Default)]
pub struct Rows {
    columns: Vec<usize>,
    entries: Vec<f64>,
}

impl Rows {
    /// Forgets all rows.
    pub fn clear(&mut self) {
        self.columns.clear();
        self.entries.clear();
    }

    /// None, with room for as many.
    #[must_use]
    pub fn with_its_room(&self) -> Self {
        Rows { columns: Vec::with_capacity(self.columns.len()), entries: Vec::with_capacity(self.entries.len()) }
    }

    /// How many there are, by which they are forgotten from there on.
    pub fn mark(&self) -> [usize; 2] {
        [self.columns.len(), self.entries.len()]
    }

    /// Forgets the rows after a mark.
    pub fn go_back(&mut self, mark: [usize; 2]) {
        self.columns.truncate(mark[0]);
        self.entries.truncate(mark[1]);
    }

    /// The columns and entries of one row.
    pub fn row(&self, side: &Side, row: usize) -> (&[usize], &[f64]) {
        let from = side.entries + row * side.count;
        (&self.columns[side.columns..side.columns + side.count], &self.entries[from..from + side.count])
    }

    /// The columns and all rows, one after the other.
    pub fn rows(&self, side: &Side) -> (&[usize], &[f64]) {
        (&self.columns[side.columns..side.columns + side.count], &self.entries[side.entries..])
    }

    /// The row of one freedom of the mechanism.
    pub fn of_freedom(&mut self, freedom: usize, sign: f64, trees: &Trees) -> Side {
        let (tree, column) = trees.of_freedom[freedom];
        let (columns, entries) = (self.columns.len(), self.entries.len());
        match trees.trees[tree].ways() {
            None => {
                self.columns.push(column);
                self.entries.push(sign);
            }
            Some(ways) => {
                self.columns.extend(ways[column].iter().map(|(place, _)| place));
                self.entries.extend(ways[column].iter().map(|(_, part)| sign * part));
            }
        }
        Side { tree, count: self.columns.len() - columns, free: false, columns, entries }
    }

    /// The rows along these directions at a point, between two bodies. Freedoms that carry both move them together.
    pub fn between(
        &mut self,
        bodies: [Option<usize>; 2],
        point: &Vector3<f64>,
        along: &[Vector3<f64>],
        trees: &Trees,
    ) -> [Option<Side>; 2] {
        let tree_of = |body: Option<usize>| body.map(|body| trees.of_body[body]);
        let shared = match bodies {
            [Some(a), Some(b)] if trees.of_body[a] == trees.of_body[b] => {
                trees.paths[a].iter().zip(&trees.paths[b]).take_while(|(one, other)| one == other).count()
            }
            _ => 0,
        };
        let together = bodies[1].is_some() && tree_of(bodies[0]) == tree_of(bodies[1]);
        let mut sides = [None, None];
        let nothing = |rows: &Self| Side {
            tree: 0,
            count: 0,
            free: false,
            columns: rows.columns.len(),
            entries: rows.entries.len(),
        };
        let mut begin = nothing(self);
        for (number, body) in bodies.into_iter().enumerate() {
            let Some(body) = body else { continue };
            let path = &trees.paths[body][shared..];
            self.columns.extend_from_slice(path);
            let tree = trees.of_body[body];
            let free =
                !together && path.len() == 6 && trees.trees[tree].all.len() == 6 && trees.trees[tree].ways().is_none();
            begin = Side { tree, count: begin.count + path.len(), free, ..begin };
            if together && number == 0 {
                continue;
            }
            let own = if together { 0..2 } else { number..number + 1 };
            for direction in along {
                for side in own.clone() {
                    let sign = if side == 0 { -1.0 } else { 1.0 };
                    if let Some(body) = bodies[side] {
                        let entries = trees.row(body, point, direction).skip(shared);
                        self.entries.extend(entries.map(|entry| sign * entry));
                    }
                }
            }
            if let Some(ways) = trees.trees[tree].ways() {
                begin.count = self.follow(&begin, along.len(), ways);
            }
            sides[number] = Some(begin);
            begin = nothing(self);
        }
        sides
    }

    /// Makes rows of all freedoms, the last ones, rows of the independent freedoms: H E. Returns their number.
    fn follow(&mut self, side: &Side, rows: usize, ways: &[Vec<(usize, f64)>]) -> usize {
        let all = self.columns.split_off(side.columns);
        let entries = self.entries.split_off(side.entries);
        self.columns.extend(all.iter().flat_map(|&column| &ways[column]).map(|(place, _)| *place));
        self.columns[side.columns..].sort_unstable();
        let mut last = None;
        let mut kept = side.columns;
        for place in side.columns..self.columns.len() {
            if last != Some(self.columns[place]) {
                last = Some(self.columns[place]);
                self.columns[kept] = self.columns[place];
                kept += 1;
            }
        }
        self.columns.truncate(kept);
        let columns = &self.columns[side.columns..];
        self.entries.resize(side.entries + rows * columns.len(), 0.0);
        let sums = self.entries[side.entries..].chunks_exact_mut(columns.len().max(1));
        for (sums, entries) in sums.zip(entries.chunks_exact(all.len().max(1))) {
            for (entry, &column) in entries.iter().zip(&all) {
                for &(place, part) in &ways[column] {
                    if let Ok(at) = columns.binary_search(&place) {
                        sums[at] += entry * part;
                    }
                }
            }
        }
        columns.len()
    }
}
