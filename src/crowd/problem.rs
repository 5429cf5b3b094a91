//! The problem of an island: impulses of all its blocks, and the rates of its trees that they make.
//!
//! ```text
//!     M̃ (v − v_f) = Σ_k H_kᵀ r_k,      u_k = H_k v + b_k + c_k r_k,      K_k ∋ r_k ⊥ u_k + μ_k |u_kT| n ∈ K_k*
//! ```
//!
//! `v` (n) are the rates of the trees, `H_k` (3 × n or 1 × n) the rows of a block, `b_k` its bias [m/s or rad/s], `c_k` a compliance [m/s/(N s)] of a
//! motor. A block has entries for the freedoms on the way to its bodies alone. Blocks of one tree and the world stay in the diagonal block of the tree.

use crate::block_factors::Factors;
use crate::elimination::Pattern;
use crate::laws::Law;
use crate::rows::{Rows, Side};
use crate::trees::Trees;
use nalgebra::Vector3;

/// One block of an island.
#[derive(Clone, Copy)]
pub struct Block {
    pub law: Law,
    /// b.
    pub bias: Vector3<f64>,
    /// c.
    pub compliance: f64,
    /// ρ (kg): the mass that the block moves.
    pub rho: f64,
    sides: [Option<Side>; 2],
}

/// The data of a block.
#[derive(Clone, Copy)]
pub struct Given {
    /// The rows on its trees.
    pub sides: [Option<Side>; 2],
    /// Its law.
    pub law: Law,
    /// b.
    pub bias: Vector3<f64>,
    /// c.
    pub compliance: f64,
}

/// The blocks and trees of an island.
pub struct Problem<'p> {
    trees: &'p Trees,
    /// H; others may take their places if they have the same sides.
    pub rows: &'p Rows,
    members: &'p [usize],
    /// The place of each tree of the mechanism among the members.
    places: &'p [usize],
    pub pattern: Pattern,
    pub blocks: Vec<Block>,
    /// v_f.
    pub free: Vec<f64>,
    /// The largest impulse that is called for without impulses (N s).
    called_for: f64,
}

/// How well impulses and rates solve a problem.
#[derive(Clone, Copy)]
pub struct Merit {
    pub value: f64,
    /// Largest defect over the largest impulse.
    pub residual: f64,
}

impl<'p> Problem<'p> {
    /// The problem of these trees with rates `free` of all freedoms without impulses, for blocks: their sides, law, bias and compliance.
    pub fn new(
        trees: &'p Trees,
        rows: &'p Rows,
        [members, places]: [&'p [usize]; 2],
        free: &[f64],
        blocks: impl Iterator<Item = Given>,
    ) -> Self {
        let mut edges = Vec::new();
        let mut room = Vec::new();
        let blocks: Vec<Block> = blocks
            .map(|Given { sides, law, bias, compliance }| {
                if let [Some(a), Some(b)] = sides {
                    edges.push((places[a.tree], places[b.tree]));
                }
                let looked = if law.rows() == 3 { 2 } else { 1 };
                let mut mobility = 0.0;
                for side in sides.iter().flatten() {
                    let tree = &trees.trees[side.tree];
                    for row in 0..looked {
                        room.clear();
                        room.resize(tree.freedoms.len(), 0.0);
                        let (columns, entries) = rows.row(side, row);
                        columns.iter().zip(entries).for_each(|(&column, entry)| room[column] = *entry);
                        tree.solve_lower(&mut room);
                        mobility += room.iter().map(|x| x * x).sum::<f64>();
                    }
                }
                Block { law, bias, compliance, rho: looked as f64 / mobility.max(f64::MIN_POSITIVE), sides }
            })
            .collect();
        let sizes = members.iter().map(|&tree| trees.trees[tree].freedoms.len()).collect();
        let own = members.iter().flat_map(|&tree| trees.trees[tree].freedoms.iter().map(|&freedom| free[freedom]));
        let free: Vec<f64> = own.collect();
        let mut problem = Problem {
            pattern: Pattern::new(sizes, &edges),
            trees,
            rows,
            members,
            places,
            blocks,
            free,
            called_for: 0.0,
        };
        problem.set_scale();
        problem
    }

    /// Takes the scale of impulses from the rates without impulses.
    pub fn set_scale(&mut self) {
        let none = Vector3::zeros();
        let called = |number: usize| self.rate(number, &self.free, &none).norm() * self.blocks[number].rho;
        self.called_for = (0..self.blocks.len()).map(called).fold(0.0, f64::max);
    }

    /// H v of a block, without its bias.
    pub fn moved(&self, number: usize, v: &[f64]) -> Vector3<f64> {
        self.moved_of(&self.blocks[number], v)
    }

    fn moved_of(&self, block: &Block, v: &[f64]) -> Vector3<f64> {
        let mut rate = Vector3::zeros();
        for side in block.sides.iter().flatten() {
            let v = self.part(side, v);
            let (columns, entries) = self.rows.rows(side);
            if let (Ok(v), true) = (<&[f64; 6]>::try_from(v), side.free) {
                for (row, entries) in entries.chunks_exact(6).take(block.law.rows()).enumerate() {
                    let [a, b, c, d, e, f] = [0, 1, 2, 3, 4, 5].map(|place| entries[place] * v[place]);
                    rate[row] += (a + b) + (c + d) + (e + f);
                }
                continue;
            }
            for (row, entries) in entries.chunks_exact(side.count.max(1)).take(block.law.rows()).enumerate() {
                rate[row] += columns.iter().zip(entries).map(|(&column, entry)| entry * v[column]).sum::<f64>();
            }
        }
        rate
    }

    /// Whether a block that exerts no impulse presses or pulls at these rates, or parts more slowly than `nearly`.
    pub fn is_called(&self, block: &Block, v: &[f64], nearly: f64) -> bool {
        match block.law {
            Law::Interval(lower, _) if lower < 0.0 => true,
            Law::Interval(..) | Law::Cone(_) => self.moved_of(block, v).x + block.bias.x < nearly,
        }
    }

    /// The rates of the tree of a side.
    fn part<'v>(&self, side: &Side, v: &'v [f64]) -> &'v [f64] {
        let place = self.places[side.tree];
        let from = self.pattern.offsets[place];
        &v[from..from + self.pattern.sizes[place]]
    }

    /// u of a block.
    pub fn rate(&self, number: usize, v: &[f64], impulse: &Vector3<f64>) -> Vector3<f64> {
        let block = &self.blocks[number];
        let mut rate = self.moved(number, v) + block.bias;
        rate.x += block.compliance * impulse.x;
        rate
    }

    /// Adds Hᵀ r of a block to efforts.
    pub fn spread(&self, number: usize, impulse: &Vector3<f64>, efforts: &mut [f64]) {
        let block = &self.blocks[number];
        for side in block.sides.iter().flatten() {
            let place = self.places[side.tree];
            let from = self.pattern.offsets[place];
            let efforts = &mut efforts[from..from + self.pattern.sizes[place]];
            let (columns, entries) = self.rows.rows(side);
            let rows = entries.chunks_exact(side.count.max(1)).take(block.law.rows()).zip(impulse);
            if let (Ok(efforts), true) = (<&mut [f64; 6]>::try_from(&mut *efforts), side.free) {
                for (entries, impulse) in rows {
                    (0..6).for_each(|place| efforts[place] += entries[place] * impulse);
                }
                continue;
            }
            for (entries, impulse) in rows {
                columns.iter().zip(entries).for_each(|(&column, entry)| efforts[column] += entry * impulse);
            }
        }
    }

    /// The rates of the trees that impulses make.
    pub fn velocity(&self, impulses: &[Vector3<f64>], v: &mut Vec<f64>) {
        v.clear();
        v.resize(self.free.len(), 0.0);
        for (number, impulse) in impulses.iter().enumerate() {
            if *impulse != Vector3::zeros() {
                self.spread(number, impulse, v);
            }
        }
        for (place, &tree) in self.members.iter().enumerate() {
            let offset = self.pattern.offsets[place];
            self.trees.trees[tree].solve(&mut v[offset..offset + self.pattern.sizes[place]]);
        }
        v.iter_mut().zip(&self.free).for_each(|(rate, free)| *rate += free);
    }

    /// u of all blocks.
    pub fn rates(&self, v: &[f64], impulses: &[Vector3<f64>], rates: &mut Vec<Vector3<f64>>) {
        rates.clear();
        rates.extend(impulses.iter().enumerate().map(|(number, impulse)| self.rate(number, v, impulse)));
    }

    /// How well impulses and the rates u that they make solve the problem.
    pub fn merit(&self, impulses: &[Vector3<f64>], rates: &[Vector3<f64>]) -> Merit {
        self.merit_with(impulses, rates, 1.0)
    }

    /// The same, with the value for a ρ that is larger by a factor.
    pub(crate) fn merit_with(&self, impulses: &[Vector3<f64>], rates: &[Vector3<f64>], stiffer: f64) -> Merit {
        let (mut value, mut largest, mut scale) = (0.0, 0.0_f64, 0.0_f64);
        for ((block, impulse), rate) in self.blocks.iter().zip(impulses).zip(rates) {
            let defect = block.law.defect(impulse, rate, block.rho).norm_squared();
            value += if stiffer == 1.0 {
                defect / block.rho
            } else {
                let rho = stiffer * block.rho;
                block.law.defect(impulse, rate, rho).norm_squared() / rho
            };
            largest = if defect.is_nan() { f64::NAN } else { largest.max(defect) };
            scale = scale.max(impulse.norm_squared());
        }
        let scale = scale.sqrt().max(self.called_for);
        Merit { value, residual: if scale > 0.0 { largest.sqrt() / scale } else { largest } }
    }

    /// Sets the matrix to M̃.
    pub fn begin_matrix(&self, factors: &mut Factors) {
        factors.clear(&self.pattern);
        for (place, &tree) in self.members.iter().enumerate() {
            factors.block(&self.pattern, place, place).copy_from_slice(&self.trees.trees[tree].softened);
        }
    }

    /// Adds M̃ (v − v_f) to efforts.
    pub fn add_inertia(&self, v: &[f64], efforts: &mut [f64]) {
        let change: Vec<f64> = v.iter().zip(&self.free).map(|(v, free)| v - free).collect();
        self.multiply_inertia(&change, efforts);
    }

    /// Adds M̃ x to efforts.
    pub fn multiply_inertia(&self, change: &[f64], efforts: &mut [f64]) {
        for (place, &tree) in self.members.iter().enumerate() {
            let range = self.pattern.offsets[place]..self.pattern.offsets[place] + self.pattern.sizes[place];
            self.trees.trees[tree].add_softened(&change[range.clone()], &mut efforts[range]);
        }
    }

    /// Adds Hᵀ S H of a block to the matrix, S by rows.
    pub fn add_to_matrix(&self, number: usize, stiffness: &[[f64; 3]; 3], factors: &mut Factors) {
        let block = &self.blocks[number];
        let rows = block.law.rows();
        for other in block.sides.iter().flatten() {
            let right = self.rows.rows(other);
            let pulled = right.1.first_chunk::<18>().filter(|_| rows == 3 && other.free);
            let pulled = pulled.map(|right| pull_six(stiffness, right));
            for one in block.sides.iter().flatten() {
                let left = self.rows.rows(one);
                let (row, column) = (self.places[one.tree], self.places[other.tree]);
                let width = self.pattern.sizes[column];
                let target = factors.block(&self.pattern, row, column);
                let (high, wide) = (one.count, other.count);
                if rows == 1 {
                    for (&i, x) in left.0.iter().zip(left.1) {
                        let factor = x * stiffness[0][0];
                        let target = &mut target[i * width..(i + 1) * width];
                        right.0.iter().zip(right.1).for_each(|(&j, y)| target[j] += factor * y);
                    }
                    continue;
                }
                if let (true, Some(pulled), Ok(target)) = (one.free, &pulled, <&mut [f64; 36]>::try_from(&mut *target))
                    && let Some(left) = left.1.first_chunk::<18>()
                {
                    add_six(target, left, pulled);
                    continue;
                }
                for (place, &j) in right.0.iter().enumerate() {
                    let along = [0, 1, 2].map(|row| right.1[row * wide + place]);
                    let pulled = stiffness.map(|row| row[0] * along[0] + row[1] * along[1] + row[2] * along[2]);
                    for (place, &i) in left.0.iter().enumerate() {
                        target[i * width + j] += left.1[place] * pulled[0]
                            + left.1[high + place] * pulled[1]
                            + left.1[2 * high + place] * pulled[2];
                    }
                }
            }
        }
    }
}

/// S R of a free body with three rows.
fn pull_six(stiffness: &[[f64; 3]; 3], right: &[f64; 18]) -> [[f64; 6]; 3] {
    let mut pulled = [[0.0; 6]; 3];
    for (sums, factors) in pulled.iter_mut().zip(stiffness) {
        for (inner, factor) in factors.iter().enumerate() {
            (0..6).for_each(|place| sums[place] += factor * right[6 * inner + place]);
        }
    }
    pulled
}

/// Adds Lᵀ (S R) of two free bodies, each with three rows.
fn add_six(target: &mut [f64; 36], left: &[f64; 18], pulled: &[[f64; 6]; 3]) {
    for i in 0..6 {
        let [x, y, z] = [left[i], left[6 + i], left[12 + i]];
        (0..6).for_each(|j| target[6 * i + j] += x * pulled[0][j] + y * pulled[1][j] + z * pulled[2][j]);
    }
}
