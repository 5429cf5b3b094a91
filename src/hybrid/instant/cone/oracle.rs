//! The interior-point method of clarabel with De Saxcé's shift as a fixed point: slow and inexact, but always near the solution.
//!
//! ```text
//!     minimise  ½ rᵀ D r + (b + s)ᵀ r    subject to  r in the cones and intervals,       s_N = μ |u_T| of the last round
//! ```
//!
//! For given s this is convex. A contact that slides in a known direction has the friction of the last round. The shift is advanced by the secant
//! rule (Anderson's with one column) along the change of s. It ends at 1e-9 … 1e-7 and must be followed by Newton's method.
//!
//! Source: V. Acary, F. Cadoux, C. Lemaréchal, J. Malick, A formulation of the linear discrete Coulomb friction problem via convex optimization,
//! ZAMM 91 (2011).

use crate::instant::cone::problem::Law;
use crate::instant::cone::scaled::Scaled;
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SupportedConeT};

/// Most rounds of the fixed point.
const ROUNDS: usize = 25;
/// Rounds that may pass without halving the residual.
const PATIENCE: usize = 6;

/// Scaled forces near a solution, from the forces of a start or from zero; `None` if clarabel fails.
pub(super) fn convex_rounds(problem: &Scaled, start: Option<&[f64]>) -> Option<Vec<f64>> {
    let count = problem.free.len();
    let mut forces = start.map_or_else(|| vec![0.0; count], <[f64]>::to_vec);
    let mut rates = vec![0.0; count];
    problem.rates(&forces, &mut rates);
    let programme = Programme::new(problem);
    let mut shift = if start.is_some() { shifts(problem, &forces, &rates) } else { vec![0.0; 2 * problem.laws.len()] };
    let mut last: Option<(Vec<f64>, Vec<f64>)> = None;
    let mut nearest: Option<(f64, Vec<f64>)> = None;
    let mut idle = 0;
    for _ in 0..ROUNDS {
        let Some(found) = programme.solve(problem, &shift) else { break };
        forces = found;
        problem.rates(&forces, &mut rates);
        let residual = problem.residual(&forces, &rates);
        let least = nearest.as_ref().map_or(f64::INFINITY, |(least, _)| *least);
        idle = if residual < 0.5 * least { 0 } else { idle + 1 };
        if nearest.is_none() || residual < least {
            nearest = Some((residual, forces.clone()));
        }
        if idle == PATIENCE {
            break;
        }
        let image = shifts(problem, &forces, &rates);
        let off: Vec<f64> = image.iter().zip(&shift).map(|(image, shift)| image - shift).collect();
        let size = image.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        if off.iter().all(|off| off.abs() <= 1e-9 * size) {
            break;
        }
        let next = match &last {
            Some((image_before, off_before)) => {
                let change: Vec<f64> = off.iter().zip(off_before).map(|(now, before)| now - before).collect();
                let square: f64 = change.iter().map(|change| change * change).sum();
                let along: f64 = change.iter().zip(&off).map(|(change, off)| change * off).sum();
                let part = if square > 0.0 { (along / square).clamp(-2.0, 2.0) } else { 0.0 };
                let pairs = image.iter().zip(image_before);
                pairs.map(|(now, before)| now - part * (now - before)).collect()
            }
            None => image.clone(),
        };
        last = Some((image, off));
        shift = next;
        // A normal shift and a normal force that friction follows are never negative.
        shift.iter_mut().for_each(|shift| *shift = shift.max(0.0));
    }
    nearest.map(|(_, forces)| forces)
}

/// For each block μ |u_T|, and the normal force that known friction follows.
fn shifts(problem: &Scaled, forces: &[f64], rates: &[f64]) -> Vec<f64> {
    let of_block = |(start, law): (usize, Law)| match law {
        Law::Contact { friction } => [friction * rates[start + 1].hypot(rates[start + 2]), 0.0],
        Law::Sliding { .. } => [0.0, forces[start]],
        Law::Interval { .. } => [0.0, 0.0],
    };
    problem.blocks().flat_map(of_block).collect()
}

/// The parts of the programme that are the same in all rounds.
struct Programme {
    quadratic: CscMatrix<f64>,
    rows: CscMatrix<f64>,
    cones: Vec<SupportedConeT<f64>>,
}

impl Programme {
    fn new(problem: &Scaled) -> Self {
        let count = problem.free.len();
        let upper = |row: usize, column: usize| if column >= row { problem.mobility[(row, column)] } else { 0.0 };
        let square: Vec<Vec<f64>> =
            (0..count).map(|row| (0..count).map(|column| upper(row, column)).collect()).collect();
        let (mut rows, mut cones) = (Vec::new(), Vec::new());
        let mut push = |row: usize, factor: f64| {
            let mut entries = vec![0.0; count];
            entries[row] = factor;
            rows.push(entries);
        };
        for (start, law) in problem.blocks() {
            match law {
                Law::Interval { lower, upper } => {
                    for _ in [(-1.0, lower), (1.0, upper)]
                        .into_iter()
                        .filter(|(_, bound)| bound.is_finite())
                        .map(|(factor, _)| push(start, factor))
                    {
                        cones.push(SupportedConeT::NonnegativeConeT(1));
                    }
                }
                Law::Contact { friction } if friction > 0.0 => {
                    [(0, -friction), (1, -1.0), (2, -1.0)]
                        .into_iter()
                        .for_each(|(row, factor)| push(start + row, factor));
                    cones.push(SupportedConeT::SecondOrderConeT(3));
                }
                Law::Contact { .. } | Law::Sliding { .. } => {
                    [(0, -1.0), (1, 1.0), (2, 1.0)].into_iter().for_each(|(row, factor)| push(start + row, factor));
                    cones.extend([SupportedConeT::NonnegativeConeT(1), SupportedConeT::ZeroConeT(2)]);
                }
            }
        }
        if rows.is_empty() {
            rows.push(vec![0.0; count]);
            cones.push(SupportedConeT::NonnegativeConeT(1));
        }
        Programme { quadratic: CscMatrix::from(&square), rows: CscMatrix::from(&rows), cones }
    }

    /// The minimum for given shifts.
    fn solve(&self, problem: &Scaled, shift: &[f64]) -> Option<Vec<f64>> {
        let mut linear = problem.free.clone();
        let mut limits = Vec::new();
        for ((start, law), shift) in problem.blocks().zip(shift.chunks(2)) {
            linear[start] += shift[0];
            match law {
                Law::Interval { lower, upper } => {
                    limits.extend([-lower, upper].into_iter().filter(|bound| bound.is_finite()))
                }
                Law::Contact { .. } => limits.extend([0.0; 3]),
                Law::Sliding { friction, direction: [x, y] } => {
                    limits.extend([0.0, -friction * shift[1] * x, -friction * shift[1] * y]);
                }
            }
        }
        limits.resize(self.rows.m, 0.0);
        let tight = 1e-13;
        let settings = DefaultSettings {
            verbose: false,
            max_threads: 1,
            max_iter: 60,
            tol_gap_abs: tight,
            tol_gap_rel: tight,
            tol_feas: tight,
            ..DefaultSettings::default()
        };
        let mut solver =
            DefaultSolver::new(&self.quadratic, &linear, &self.rows, &limits, &self.cones, settings).ok()?;
        solver.solve();
        let found = &solver.solution.x;
        found.iter().all(|force| force.is_finite()).then(|| found.clone())
    }
}
