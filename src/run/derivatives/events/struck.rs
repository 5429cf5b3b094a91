//! The answers of an impact at their active sets, solved to rounding in doubles, with the factors of their matrix.
//!
//! ```text
//!     unknowns (v, P, Λ)      | M    −Wᵀ   −Gᵀ |        rows of laws     W_N                          closed
//!                             | ∂law/∂v  ∂P  0 |                         W_T                          sticks
//!                             | G      0     0 |                         1/|u_T| μ P_N (1 − t tᵀ) W_T,  μ t,  1     slides, t = u_T/|u_T|
//! ```
//!
//! M, W and G do not depend on the unknowns: they are found once.

use crate::derivatives::events::impulse_factors::ImpulseFactors;
use crate::derivatives::events::instant::Instant;
use crate::derivatives::events::meet::{Meet, Met};
use crate::instant::cone::impact::Round;
pub use crate::instant::cone::problem::{Answer, BlockState};
use nalgebra::{DMatrix, DVector};

/// Iterations; two or three are made.
const ITERATIONS: usize = 30;
/// Corrections below this part of the velocities that do not shrink any more are rounding.
const ROUNDING: f64 = 1e-10;

/// An answer.
pub(super) struct Struck {
    pub states: Vec<BlockState>,
    /// Whether restitution counts.
    pub rebounds: bool,
    /// v (n), P, and Λ of independent closures.
    pub velocities: Vec<f64>,
    pub impulses: Vec<f64>,
    pub multipliers: Vec<f64>,
    /// M (n × n).
    pub mass: DMatrix<f64>,
    pub factors: ImpulseFactors,
}

/// The answers of a round.
pub(super) struct StruckRound {
    /// The blocks that take part.
    pub part: Vec<usize>,
    pub plastic: Struck,
    pub rebound: Option<Struck>,
    /// σ.
    pub share: f64,
}

/// The matrices of the blocks that take part.
struct Linear<'l> {
    mass: &'l DMatrix<f64>,
    closures: &'l DMatrix<f64>,
    /// W.
    rows: DMatrix<f64>,
    /// μ and e of each block, with the number of its rows.
    laws: Vec<(f64, f64, usize)>,
}

/// All rounds of an impact; `None` if the equations of one are singular. `closures` are the independent rows of G.
pub(super) fn struck(
    at: &Instant<f64>,
    met: &[Met<f64>],
    closures: &DMatrix<f64>,
    before: &[f64],
    rounds: &[Round],
) -> Option<(Vec<f64>, Vec<StruckRound>)> {
    let n = before.len();
    let unit = |freedom: usize| -> Vec<f64> { (0..n).map(|own| f64::from(u8::from(own == freedom))).collect() };
    let columns = |of: &dyn Fn(&[f64]) -> Vec<f64>| {
        let columns: Vec<DVector<f64>> = (0..n).map(|freedom| DVector::from_vec(of(&unit(freedom)))).collect();
        if columns.is_empty() { DMatrix::zeros(0, 0) } else { DMatrix::from_columns(&columns) }
    };
    let mass = columns(&|velocities| at.momenta(velocities));
    let mut velocities = before.to_vec();
    let mut found = Vec::with_capacity(rounds.len());
    for round in rounds {
        let meet = Meet { at, met, part: &round.part };
        let places = meet.in_place();
        let law = |&block: &usize| {
            let (friction, restitution) = met[block].law();
            (friction, restitution, met[block].rows())
        };
        let linear = Linear {
            mass: &mass,
            closures,
            rows: columns(&|velocities| meet.moving(&places, velocities).rates),
            laws: round.part.iter().map(law).collect(),
        };
        let plastic = linear.answer(&velocities, &round.plastic, false)?;
        let rebound = match &round.rebound {
            None => None,
            Some(answer) => Some(linear.answer(&velocities, answer, true)?),
        };
        velocities = match &rebound {
            None => plastic.velocities.clone(),
            Some(rebound) if round.share == 1.0 => rebound.velocities.clone(),
            Some(rebound) => meet.shared(&velocities, &plastic.velocities, &rebound.velocities, round.share)?,
        };
        found.push(StruckRound { part: round.part.clone(), plastic, rebound, share: round.share });
    }
    Some((velocities, found))
}

impl Linear<'_> {
    fn answer(&self, before: &[f64], answer: &Answer, rebounds: bool) -> Option<Struck> {
        let (n, impulses) = (before.len(), answer.forces.len());
        let count = n + impulses + self.closures.nrows();
        let before = DVector::from_column_slice(before);
        let mut unknowns = DVector::zeros(count);
        unknowns.rows_mut(0, n).copy_from(&before);
        unknowns.rows_mut(n, impulses).copy_from_slice(&answer.forces);
        if answer.states.contains(&BlockState::Slips) {
            self.move_off(&mut unknowns)?;
        }
        let speed = before.amax().max(f64::MIN_POSITIVE);
        let mut last = f64::INFINITY;
        for _ in 0..ITERATIONS {
            let (matrix, residual) = self.equations(&before, &unknowns, &answer.states, rebounds);
            let factors = ImpulseFactors::of(matrix)?;
            let correction = factors.solve(&residual)?;
            unknowns -= &correction.column(0);
            let size = correction.rows(0, n).amax() / speed;
            if !size.is_finite() {
                return None;
            }
            if size < ROUNDING && size >= 0.25 * last || size == 0.0 {
                let part = |first: usize, count: usize| unknowns.rows(first, count).iter().copied().collect();
                return Some(Struck {
                    states: answer.states.clone(),
                    rebounds,
                    velocities: part(0, n),
                    impulses: part(n, impulses),
                    multipliers: part(n + impulses, self.closures.nrows()),
                    mass: self.mass.clone(),
                    factors,
                });
            }
            last = size;
        }
        None
    }

    /// Begins with the velocities that the impulses of the answer give, because a direction of slip is needed.
    fn move_off(&self, unknowns: &mut DVector<f64>) -> Option<()> {
        let (n, m) = (self.mass.nrows(), self.closures.nrows());
        let mut whole = DMatrix::zeros(n + m, n + m);
        whole.view_mut((0, 0), (n, n)).copy_from(self.mass);
        whole.view_mut((n, 0), (m, n)).copy_from(self.closures);
        whole.view_mut((0, n), (n, m)).copy_from(&self.closures.transpose());
        let impulses = unknowns.rows(n, self.rows.nrows());
        let found = whole.lu().solve(&self.rows.tr_mul(&impulses).resize_vertically(n + m, 0.0))?;
        (0..n).for_each(|row| unknowns[row] += found[row]);
        Some(())
    }

    /// The matrix of the equations, and their residuals.
    fn equations(
        &self,
        before: &DVector<f64>,
        unknowns: &DVector<f64>,
        states: &[BlockState],
        rebounds: bool,
    ) -> (DMatrix<f64>, DMatrix<f64>) {
        let (n, impulses, m) = (before.len(), self.rows.nrows(), self.closures.nrows());
        let (velocities, pushes) = (unknowns.rows(0, n), unknowns.rows(n, impulses));
        let multipliers = unknowns.rows(n + impulses, m);
        let mut matrix = DMatrix::zeros(unknowns.len(), unknowns.len());
        let mut residual = DMatrix::zeros(unknowns.len(), 1);
        matrix.view_mut((0, 0), (n, n)).copy_from(self.mass);
        matrix.view_mut((0, n), (n, impulses)).copy_from(&-self.rows.transpose());
        matrix.view_mut((0, n + impulses), (n, m)).copy_from(&-self.closures.transpose());
        matrix.view_mut((n + impulses, 0), (m, n)).copy_from(self.closures);
        let momenta =
            self.mass * (velocities - before) - self.rows.tr_mul(&pushes) - self.closures.tr_mul(&multipliers);
        residual.rows_mut(0, n).copy_from(&momenta);
        residual.rows_mut(n + impulses, m).copy_from(&(self.closures * velocities));
        let (after, before) = (&self.rows * velocities, &self.rows * before);
        let mut first = 0;
        for (&(friction, restitution, count), &state) in self.laws.iter().zip(states) {
            let own = first..first + count;
            first = own.end;
            let normal = own.start;
            for row in own.clone() {
                if matches!(state, BlockState::Open | BlockState::AtLower | BlockState::AtUpper) {
                    matrix[(n + row, n + row)] = 1.0;
                    residual[n + row] = pushes[row];
                } else if row == normal || state == BlockState::Sticks {
                    matrix.view_mut((n + row, 0), (1, n)).copy_from(&self.rows.row(row));
                    let rebound = if rebounds && row == normal { restitution * before[row].min(0.0) } else { 0.0 };
                    residual[n + row] = after[row] + rebound;
                }
            }
            if state == BlockState::Slips {
                let slip = [after[normal + 1], after[normal + 2]];
                let speed = slip[0].hypot(slip[1]);
                let along = slip.map(|part| part / speed);
                for axis in 0..2 {
                    let row = normal + 1 + axis;
                    residual[n + row] = pushes[row] + friction * pushes[normal] * along[axis];
                    matrix[(n + row, n + row)] = 1.0;
                    matrix[(n + row, n + normal)] = friction * along[axis];
                    for other in 0..2 {
                        let turn = f64::from(u8::from(axis == other)) - along[axis] * along[other];
                        let share = friction * pushes[normal] / speed * turn;
                        let by = self.rows.row(normal + 1 + other) * share;
                        let mut to = matrix.view_mut((n + row, 0), (1, n));
                        to += by;
                    }
                }
            }
        }
        (matrix, residual)
    }
}
