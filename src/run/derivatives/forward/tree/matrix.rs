//! The matrix of the equations of a step of a tree, block by block, and its factors.
//!
//! ```text
//!     ∂(row k)/∂δ_i = β_ki C_ki + [k = i] (K_k + U)        ∂(row s)/∂v̄ = C_ss          β_ki = B_ki, or −ω_i/h in the last rows
//!     C_ki   s_r(k) · ∫ (forces of the points that s_j(i) moves)       from  S_ki = ∫ q_k q_iᵀ dm
//!     K_k    the forces of stage k stay, their points and the axes move
//!     U      of the end alone: q̇(v̄) changes with the places
//! ```
//!
//! All integrals are over the bodies behind both freedoms; each matrix is a sum over such bodies of nine numbers, gathered from leaves to root. C of
//! two stages is the transpose of C of the same stages in the other order. The velocities at the end are in the last rows alone, so that the matrix is
//! a block triangle.

use crate::derivatives::forward::spatial::{Forces, Twist, inner, shifted, sum, trace, transposed};
use crate::derivatives::forward::tree::family::Freedom;
use crate::derivatives::forward::tree::step::TreeStep;
use crate::derivatives::forward::tree_factors::TreeFactors;
use crate::derivatives::forward::twelve::Twelve;
use crate::derivatives::numbers::vector::{Matrix, Vector};
use nalgebra::DMatrix;

/// The matrix of a step: the rows of the stages, and the last rows.
pub(in crate::derivatives::forward) struct TreeMatrix {
    /// Rows k = 1..s−1 by the displacements of the stages i = 2..s.
    stages: DMatrix<f64>,
    /// Rows of the end by the same displacements, and by v̄.
    end: DMatrix<f64>,
    masses: DMatrix<f64>,
}

/// The parts of a matrix of two stages, for a body and all behind it.
struct Behind<'b> {
    mass: f64,
    at_row: Vector<f64>,
    at_column: Vector<f64>,
    second: &'b Matrix<f64>,
}

impl Behind<'_> {
    /// `C s`: force and torque in the row's stage of a motion in the column's.
    #[inline]
    fn load(&self, motion: &Twist) -> [Vector<f64>; 2] {
        let Twist { turn, shift } = *motion;
        let force = shift.scaled(self.mass) + turn.cross(self.at_column);
        let torque = self.at_row.cross(shift) + turn.scaled(trace(self.second)) - transposed(self.second, turn);
        [force, torque]
    }

    /// `Cᵀ s`.
    #[inline]
    fn load_back(&self, motion: &Twist) -> [Vector<f64>; 2] {
        let Twist { turn, shift } = *motion;
        let force = shift.scaled(self.mass) + turn.cross(self.at_row);
        let torque = self.at_column.cross(shift) + turn.scaled(trace(self.second)) - self.second.apply(turn);
        [force, torque]
    }
}

impl TreeMatrix {
    /// Of a step.
    pub fn new(step: &TreeStep) -> Self {
        let (s, n) = (step.stages.len(), step.problem.mode.free.len());
        let mut stages = DMatrix::zeros((s - 1) * n, (s - 1) * n);
        let mut end = DMatrix::zeros(n, (s - 1) * n);
        let mut masses = DMatrix::zeros(n, n);
        let figures = &step.problem.figures.plain;
        let mut mass: Vec<f64> = figures.bodies.iter().map(|body| body.mass).collect();
        step.family.gather(&mut mass, |sum, own| *sum += own);
        // ∫ q dm of each body at each stage, and of it with all behind it; and the inner parts of S.
        let single: Vec<Vec<Vector<f64>>> = step
            .stages
            .iter()
            .map(|stage| {
                let bodies = figures.bodies.iter().zip(&stage.places);
                bodies.map(|(body, at)| at.origin.scaled(body.mass) + at.axes.apply(body.moment)).collect()
            })
            .collect();
        let first: Vec<Vec<Vector<f64>>> = single
            .iter()
            .map(|own| {
                let mut behind = own.clone();
                step.family.gather(&mut behind, |sum, own| *sum = *sum + *own);
                behind
            })
            .collect();
        let inside: Vec<Vec<Matrix<f64>>> = step
            .stages
            .iter()
            .map(|stage| figures.bodies.iter().zip(&stage.places).map(|(body, at)| inner(body, at)).collect())
            .collect();
        let weights: Vec<Vec<f64>> = (0..s).map(|k| step.weights(k)).collect();
        let mut second = Vec::with_capacity(figures.bodies.len());
        let (mut block, mut own) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
        // Stages are numbered from 0; no column belongs to the start.
        for k in 0..s {
            for i in k.max(1)..s {
                second.clear();
                for body in 0..figures.bodies.len() {
                    second.push(shifted(&step.stages[k].places[body], &inside[i][body], single[i][body]));
                }
                step.family.gather(&mut second, |of, own| *of = sum(of, own));
                block.fill(0.0);
                step.add_pair(&second, [k, i], &mass, [&first[k], &first[i]], &mut block);
                let to = if k + 1 == s { &mut end } else { &mut stages };
                let row = if k + 1 == s { 0 } else { k * n };
                add(to, [row, (i - 1) * n], &block, weights[k][i - 1], false);
                if i > k && k > 0 {
                    let to = if i + 1 == s { &mut end } else { &mut stages };
                    let row = if i + 1 == s { 0 } else { i * n };
                    add(to, [row, (k - 1) * n], &block, weights[i][k - 1], true);
                }
                if i == k {
                    own.fill(0.0);
                    step.add_own(k, &mut own);
                    if k + 1 == s {
                        masses.copy_from(&block);
                        step.add_rates(&second, &mass, &first[k], &mut own);
                    }
                    let to = if k + 1 == s { &mut end } else { &mut stages };
                    add(to, [row, (i - 1) * n], &own, 1.0, false);
                }
            }
            let (to, row) = if k + 1 == s { (&mut end, 0) } else { (&mut stages, k * n) };
            step.add_scalars(k, &weights[k], |freedom, i, by| to[(row + freedom, (i - 1) * n + freedom)] += by);
        }
        for (freedom, armature, _) in step.rotors() {
            if let Some(row) = step.row(freedom) {
                masses[(row, row)] += armature;
            }
        }
        TreeMatrix { stages, end, masses }
    }

    /// Its factors; `None` if it is singular.
    pub fn factors(self) -> Option<TreeFactors> {
        let TreeMatrix { stages, end, masses } = self;
        TreeFactors::new(&stages, end, &masses)
    }

    /// Copies it to the beginning of a matrix: displacements, then v̄.
    pub fn copy_to(&self, whole: &mut DMatrix<f64>) {
        let (many, n) = (self.stages.nrows(), self.masses.nrows());
        whole.view_mut((0, 0), (many, many)).copy_from(&self.stages);
        whole.view_mut((many, 0), (n, many)).copy_from(&self.end);
        whole.view_mut((many, many), (n, n)).copy_from(&self.masses);
    }
}

impl TreeStep<'_> {
    /// Adds C of two stages, row and column, from S of the bodies behind each body.
    fn add_pair(
        &self,
        of: &[Matrix<f64>],
        [k, i]: [usize; 2],
        mass: &[f64],
        first: [&[Vector<f64>]; 2],
        block: &mut DMatrix<f64>,
    ) {
        let (rows, columns) = (&self.stages[k].motions, &self.stages[i].motions);
        for body in 0..self.family.own.len() {
            let (own, before) = (&self.family.own[body], &self.family.before[body]);
            let behind =
                Behind { mass: mass[body], at_row: first[0][body], at_column: first[1][body], second: &of[body] };
            for freedom in own {
                let Some(own_row) = freedom.row else { continue };
                let [force, torque] = behind.load(&columns[freedom.index]);
                let mut add = |other: &Freedom| {
                    let Some(row) = other.row else { return };
                    block[(row, own_row)] += rows[other.index].power(force, torque);
                };
                before.iter().for_each(&mut add);
                own.iter().for_each(&mut add);
                let [force, torque] = behind.load_back(&rows[freedom.index]);
                for other in before {
                    let Some(column) = other.row else { continue };
                    block[(own_row, column)] += columns[other.index].power(force, torque);
                }
            }
        }
    }

    /// Adds K: what changes in a stage where its forces stay.
    fn add_own(&self, k: usize, block: &mut DMatrix<f64>) {
        let motions = &self.stages[k].motions;
        for body in 0..self.family.own.len() {
            let (own, before) = (&self.family.own[body], &self.family.before[body]);
            let forces: &Forces = &self.behind[k][body];
            let torque = forces.about();
            for freedom in own {
                let Some(own_row) = freedom.row else { continue };
                let motion = &motions[freedom.index];
                let turned = forces.carried(motion);
                for other in before.iter().chain(own) {
                    let Some(row) = other.row else { continue };
                    block[(row, own_row)] += motions[other.index].turn.dot(turned);
                }
                for other in own.iter().filter(|other| other.is_rotation) {
                    let Some(row) = other.row else { continue };
                    block[(row, own_row)] += motion.carries(&motions[other.index]).power(forces.force, torque);
                }
                for other in before {
                    let Some(column) = other.row else { continue };
                    let by = &motions[other.index];
                    block[(own_row, column)] +=
                        by.carries(motion).power(forces.force, torque) + motion.turn.dot(forces.carried(by));
                }
            }
        }
    }

    /// Adds U: how q̇(v̄) changes where the places at the end do.
    fn add_rates(&self, of: &[Matrix<f64>], mass: &[f64], first: &[Vector<f64>], block: &mut DMatrix<f64>) {
        let end = self.stages.len() - 1;
        let (figures, stage) = (&self.problem.figures.plain, &self.stages[end]);
        let bodies = figures.bodies.iter().zip(&stage.places).zip(&self.rates[1]);
        let mut momenta: Vec<Forces> =
            bodies.map(|((body, at), rate): (_, &Twelve<f64>)| Forces::on(body, at, rate)).collect();
        self.family.gather(&mut momenta, |sum, own| *sum = sum.plus(own));
        let carriers = self.carrier_speeds(1);
        for body in 0..self.family.own.len() {
            let (own, before) = (&self.family.own[body], &self.family.before[body]);
            let behind = Behind { mass: mass[body], at_row: first[body], at_column: first[body], second: &of[body] };
            let rate = &momenta[body];
            let load = |freedom: &Freedom| {
                let motion = &stage.motions[freedom.index];
                let [force, torque] = behind.load(&carriers[freedom.index].carries(motion));
                let turn = motion.turn;
                let turned = turn.scaled(trace(&rate.moments)) - transposed(&rate.moments, turn);
                [force + turn.cross(rate.force), torque + turned]
            };
            for freedom in own {
                let Some(own_row) = freedom.row else { continue };
                let [force, torque] = load(freedom);
                for other in before.iter().chain(own) {
                    let Some(row) = other.row else { continue };
                    block[(row, own_row)] += stage.motions[other.index].power(force, torque);
                }
            }
            for other in before {
                let Some(column) = other.row else { continue };
                let [force, torque] = load(other);
                for freedom in own {
                    let Some(row) = freedom.row else { continue };
                    block[(row, column)] += stage.motions[freedom.index].power(force, torque);
                }
            }
        }
    }

    /// Adds rotors, springs, dampers and motors of the rows of a stage: `add` gets the row, the stage of the column, and the entry.
    fn add_scalars(&self, k: usize, weights: &[f64], mut add: impl FnMut(usize, usize, f64)) {
        let (s, factor) = (self.stages.len(), self.factor(k));
        for (freedom, armature, _) in self.rotors() {
            let Some(row) = self.row(freedom) else { continue };
            (1..s).for_each(|i| add(row, i, armature * weights[i - 1]));
        }
        let of_rates = &self.problem.tableau.velocity[k * (s - 1)..][..s - 1];
        for (freedom, coefficient) in self.dampers() {
            let Some(row) = self.row(freedom) else { continue };
            (1..s).for_each(|i| add(row, i, factor * coefficient * of_rates[i - 1] / self.problem.step));
        }
        if k > 0 {
            for (freedom, coefficient) in self.springs() {
                let Some(row) = self.row(freedom) else { continue };
                add(row, k, factor * coefficient);
            }
        }
    }
}

/// Adds a multiple of a square block, or of its transpose, whose first row and column are given.
fn add(to: &mut DMatrix<f64>, at: [usize; 2], block: &DMatrix<f64>, weight: f64, is_transposed: bool) {
    let (n, rows) = (block.nrows(), to.nrows());
    let (to, block) = (to.as_mut_slice(), block.as_slice());
    for column in 0..n {
        let own = &mut to[(at[1] + column) * rows + at[0]..][..n];
        for row in 0..n {
            own[row] += weight * block[if is_transposed { row * n + column } else { column * n + row }];
        }
    }
}
