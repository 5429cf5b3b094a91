//! The portfolio of solvers in its order: each starts where the last one failed, until the law holds.
//!
//! | way | start | equations | ε |
//! |---|---|---|---|
//! | warm | the forces that were handed over | Alart–Curnier | 1e-8 |
//! | cold | 10 sweeps from zero | Alart–Curnier | 1e-8 |
//! | soft | zero | Alart–Curnier | the natural map over the largest force, between 1e-8 and 0.1 |
//! | interior | an interior point, from several depths in the cones, and from more where its forces are not large | both | 1e-8 |
//! | compliant | zero, with a compliance in each block that is 1e-2, 1e-4, 1e-6 and 0 in turn | both | 1e-8 |
//! | rounds | rounds of convex problems, by clarabel, from zero and from the best so far | both | 1e-8 |
//!
//! If contacts pinch a body the problem may be infeasible: forces diverge, so that their relative residual looks small. The soft way finds such
//! forces more often than others; the residual of its answers is at most 1e-10 of the free rates.
//!
//! Decisions solve a problem that falls apart part by part. The same problem and start give the same answer, bit for bit.

use crate::instant::cone::apart::{forces_apart, parts_apart};
use crate::instant::cone::interior::interior;
use crate::instant::cone::laws::Form;
use crate::instant::cone::newton::{Settings, improve};
use crate::instant::cone::oracle::convex_rounds;
use crate::instant::cone::problem::{Answer, BlockState, Law, Problem, ROUGH, Unsolved};
use crate::instant::cone::scaled::Scaled;
use crate::instant::cone::settling::settle;
use crate::instant::cone::sweeps::sweep;
use crate::mechanism::motion::contact_solvers::{ContactSolver, ContactSolvers, DEPTHS};
use nalgebra::{DMatrix, DVector};

/// Residuals up to this are solutions.
pub(super) const ACCEPTED: f64 = 1e-10;
/// Residuals up to this end the cascade: less, because settling the states may add some times the residual.
const SOLVED: f64 = 1e-11;
/// The largest residual of free rates that are roundings of larger ones.
const ROUNDED: f64 = 1e-3;
/// Proximal compliance, in units of the mobility of a block.
const COMPLIANCE: f64 = 1e-8;
/// Compliances that vanish, in the same units.
const COMPLIANCES: [f64; 3] = [1e-2, 1e-4, 1e-6];
/// Sweeps before Newton's method.
const SWEEPS: usize = 10;
/// A free rate below this part of the terms of its sum is zero.
const IMPLIED: f64 = 1e-9;
/// The first of the depths of interior points ([`DEPTHS`]); the others are tried if those fail: each is one more chance, at a fiftieth of the cost of
/// a convex programme.
const FIRST_DEPTHS: usize = 6;
/// Scaled forces above this many times the largest free rate pinch a body.
const LARGE: f64 = 1e4;
/// Such forces are an answer if the natural map is below this part of the largest free rate: forces of 1e8 that a light body under a heavy one bears
/// have roundings of 1e-8.
const LEFT: f64 = 1e-7;
/// Iterations of Newton's method with a compliance that follows the map.
const SOFT_ITERATIONS: usize = 300;
/// Newton iterations of one round.
const ITERATIONS: usize = 25;

/// Newton's method of Alart and Curnier.
pub(super) const EVERYDAY: Settings =
    Settings { form: Form::AlartCurnier, compliance: COMPLIANCE, follows: false, iterations: ITERATIONS };
/// The same with a compliance that follows the map.
pub(super) const SOFT: Settings = Settings { follows: true, iterations: SOFT_ITERATIONS, ..EVERYDAY };
const NATURAL: Settings = Settings { form: Form::Natural, ..EVERYDAY };

/// The best forces so far.
struct Best {
    forces: Vec<f64>,
    /// The sum of squares of the natural map: unlike the residual it does not praise large forces.
    merit: f64,
    residual: f64,
    /// The entry that has found them.
    by: ContactSolver,
    /// Residuals up to this are solutions.
    enough: f64,
}

impl Best {
    /// No forces, before any have been found.
    fn none(count: usize, enough: f64) -> Self {
        let (merit, residual) = (f64::INFINITY, f64::INFINITY);
        Best { forces: vec![0.0; count], merit, residual, by: ContactSolver::Unsolved, enough }
    }

    /// Takes forces that an entry has found, if they are better; says whether the problem is solved. Large forces solve it if they leave a small part of
    /// the free rates, too: the roundings of a singular mobility times forces without end can be any rates.
    fn take(&mut self, scaled: &Scaled, by: ContactSolver, forces: Vec<f64>) -> bool {
        let mut rates = vec![0.0; forces.len()];
        scaled.rates(&forces, &mut rates);
        let (merit, residual) = (scaled.merit(&forces, &rates), scaled.residual(&forces, &rates));
        let is_solved =
            residual <= self.enough && (is_small(scaled, &forces) || merit.sqrt() <= LEFT * fastest(scaled));
        if merit < self.merit || is_solved {
            (self.forces, self.merit, self.residual, self.by) = (forces, merit, residual, by);
        }
        is_solved
    }
}

/// Solves a problem, from forces of a similar one if there are any.
///
/// # Errors
/// As of [`solve_counted`].
pub(crate) fn solve(problem: &Problem, start: Option<&[f64]>) -> Result<Answer, Unsolved> {
    solve_counted(problem, start, &mut ContactSolvers::default())
}

/// The same; counts which entry has solved it.
///
/// # Errors
/// If the problem is malformed, if a contact that slides has no solution, or if no solver reaches a residual of 1e-10; the best answer is then in
/// the error.
pub(crate) fn solve_counted(
    problem: &Problem,
    start: Option<&[f64]>,
    solvers: &mut ContactSolvers,
) -> Result<Answer, Unsolved> {
    solve_to_part(problem, start, 1.0, solvers)
}

/// The same where free rates are the small rest of larger ones, of which they are this part: their digits are roundings of those, and the residual may
/// be larger by as much.
///
/// # Errors
/// As of [`solve_counted`].
pub(super) fn solve_to_part(
    problem: &Problem,
    start: Option<&[f64]>,
    part: f64,
    solvers: &mut ContactSolvers,
) -> Result<Answer, Unsolved> {
    problem.check()?;
    let scaled = Scaled::new(problem);
    let count = problem.free.len();
    let within = |residual: f64| (residual / part).clamp(residual, ROUNDED);
    let mut best = Best::none(count, within(SOLVED));
    let start = start.filter(|start| start.len() == count && start.iter().all(|force| force.is_finite()));
    let from = |forces: Vec<f64>, settings: Settings| improved(&scaled, forces, settings);
    let (warm, cold) = (ContactSolver::Warm, ContactSolver::Cold);
    let solved = start.is_some_and(|start| best.take(&scaled, warm, from(scaled.scale(start), EVERYDAY)))
        || best.take(&scaled, cold, from(swept(&scaled), EVERYDAY));
    let solved = solved || soft(&scaled).is_some_and(|forces| best.take(&scaled, ContactSolver::Soft, forces));
    // If Newton's method has stopped short of an answer, the blocks that it holds closed may be a paradox of their own.
    if !solved && let Some((block, mobility)) = paradox(problem, &settle(problem, &scaled, &best.forces)) {
        return Err(Unsolved::Inconsistent { block, mobility });
    }
    let solved = solved || {
        // Each start is made only if those before it have failed.
        let both = |(by, near): (ContactSolver, Vec<f64>)| {
            [EVERYDAY, NATURAL].into_iter().map(move |settings| (by, from(near.clone(), settings)))
        };
        let inside = |depth: usize| {
            let near = interior(&scaled, DEPTHS[depth]).map(|near| (ContactSolver::Interior(depth), near));
            near.into_iter().flat_map(both)
        };
        let interiors = (0..FIRST_DEPTHS).flat_map(inside);
        let more = (FIRST_DEPTHS..DEPTHS.len()).flat_map(inside);
        let softened = std::iter::once_with(|| (ContactSolver::Compliant, compliant(&scaled))).flat_map(both);
        let starts =
            [(ContactSolver::RoundsFromZero, None), (ContactSolver::RoundsFromBest, Some(best.forces.clone()))];
        let near = starts.iter().filter_map(|(by, start)| Some((*by, convex_rounds(&scaled, start.as_deref())?)));
        let rounds = near.flat_map(both);
        // Forces of the last ways that grow without end are no answers.
        let last = more.chain(softened).chain(rounds).filter(|(_, forces)| is_small(&scaled, forces));
        interiors.chain(last).any(|(by, forces)| best.take(&scaled, by, forces))
    };
    let answer = settle(problem, &scaled, &best.forces);
    // The residual of large forces is a small part of them, and may be large beside the free rates.
    let accepted = answer.residual <= within(ACCEPTED) && (solved || is_small(&scaled, &best.forces));
    solvers.count(if accepted { best.by } else { ContactSolver::Unsolved });
    if accepted { Ok(answer) } else { Err(Unsolved::Stopped { best: Box::new(answer) }) }
}

/// The same part by part of a problem that falls apart, without a start.
///
/// # Errors
/// As of [`solve_counted`].
pub(crate) fn solve_apart(problem: &Problem, solvers: &mut ContactSolvers) -> Result<Answer, Unsolved> {
    problem.check()?;
    let Some(parts) = parts_apart(problem) else { return solve_counted(problem, None, solvers) };
    let count = problem.free.len();
    let states = vec![BlockState::Open; problem.laws.len()];
    let mut answer = Answer { forces: vec![0.0; count], rates: vec![0.0; count], states, residual: 0.0 };
    let mut stopped = false;
    for part in &parts {
        let found = match solve_counted(&part.problem(), None, solvers) {
            Ok(found) => found,
            Err(Unsolved::Stopped { best }) => {
                stopped = true;
                *best
            }
            Err(Unsolved::Inconsistent { block, mobility }) => {
                return Err(Unsolved::Inconsistent { block: part.blocks[block], mobility });
            }
            Err(other) => return Err(other),
        };
        part.put_into(&mut answer, &found);
    }
    if stopped { Err(Unsolved::Stopped { best: Box::new(answer) }) } else { Ok(answer) }
}

/// Forces for a step of first order: the quick ways and an interior point look for a residual of [`ROUGH`], otherwise the best iterate is taken.
/// `None` if the problem is malformed.
pub(crate) fn solve_roughly(problem: &Problem) -> Option<Vec<f64>> {
    problem.check().ok()?;
    Some(forces_apart(problem, roughly))
}

/// The same of a sound problem that does not fall apart.
fn roughly(problem: &Problem) -> Vec<f64> {
    let scaled = Scaled::new(problem);
    let mut best = Best::none(problem.free.len(), SOLVED);
    best.take(&scaled, ContactSolver::Cold, improved(&scaled, swept(&scaled), EVERYDAY));
    if best.residual > ROUGH
        && let Some(forces) = soft(&scaled)
    {
        best.take(&scaled, ContactSolver::Soft, forces);
    }
    for (depth, &spread) in DEPTHS[..FIRST_DEPTHS].iter().enumerate() {
        if best.residual <= ROUGH {
            break;
        }
        if let Some(near) = interior(&scaled, spread) {
            let by = ContactSolver::Interior(depth);
            best.take(&scaled, by, near.clone());
            best.take(&scaled, by, improved(&scaled, near, EVERYDAY));
        }
    }
    settle(problem, &scaled, &best.forces).forces
}

/// Forces after Newton's method.
fn improved(scaled: &Scaled, mut forces: Vec<f64>, settings: Settings) -> Vec<f64> {
    improve(scaled, &mut forces, settings);
    forces
}

/// Newton's method with a compliance that follows the map, from zero; `None` if the residual of the law exceeds a part of the free rates.
pub(super) fn soft(scaled: &Scaled) -> Option<Vec<f64>> {
    let forces = improved(scaled, vec![0.0; scaled.free.len()], SOFT);
    let mut rates = vec![0.0; forces.len()];
    scaled.rates(&forces, &mut rates);
    (scaled.merit(&forces, &rates).sqrt() <= ACCEPTED * fastest(scaled)).then_some(forces)
}

/// What an answer leaves of the law, as a part of the largest free rate: unlike the residual it does not praise large forces.
pub(super) fn left_of_rates(problem: &Problem, answer: &Answer) -> f64 {
    let scaled = Scaled::new(problem);
    let forces = scaled.scale(&answer.forces);
    let mut rates = vec![0.0; forces.len()];
    scaled.rates(&forces, &mut rates);
    scaled.merit(&forces, &rates).sqrt() / fastest(&scaled)
}

/// The largest free rate.
fn fastest(scaled: &Scaled) -> f64 {
    scaled.free.iter().fold(0.0_f64, |most, rate| most.max(rate.abs()))
}

/// Whether forces have not begun to grow without end.
fn is_small(scaled: &Scaled, forces: &[f64]) -> bool {
    let large = LARGE * fastest(scaled);
    forces.iter().all(|force| force.abs() <= large)
}

/// Some sweeps from zero.
fn swept(scaled: &Scaled) -> Vec<f64> {
    let mut forces = vec![0.0; scaled.free.len()];
    sweep(scaled, &mut forces, SWEEPS);
    forces
}

/// Newton's method with compliances that vanish, each from the forces of the last one.
pub(super) fn compliant(scaled: &Scaled) -> Vec<f64> {
    let mut forces = vec![0.0; scaled.free.len()];
    for compliance in COMPLIANCES {
        improve(&scaled.softened(compliance), &mut forces, EVERYDAY);
    }
    forces
}

/// A contact that slides, must be pushed and cannot: `p = n D (n − μ t) ≤ 0` and a free rate below zero, all other closed blocks holding their rows.
fn paradox(problem: &Problem, answer: &Answer) -> Option<(usize, f64)> {
    let starts = problem.starts();
    // The effect of a unit force of each block that holds its row: (row, direction of the force).
    let direction = |block: usize, row: usize| {
        let mut direction = DVector::zeros(problem.free.len());
        direction[starts[block] + row] = 1.0;
        if let Law::Sliding { friction, direction: [x, y] } = problem.laws[block] {
            (direction[starts[block] + 1], direction[starts[block] + 2]) = (-friction * x, -friction * y);
        }
        direction
    };
    let held = |other: usize| match (answer.states[other], problem.laws[other]) {
        (BlockState::Inside, _) | (BlockState::Slips, _) => 1,
        (BlockState::Sticks, _) => 3,
        _ => 0,
    };
    let free = DVector::from_column_slice(problem.free);
    problem.laws.iter().enumerate().filter(|(_, law)| matches!(law, Law::Sliding { .. })).find_map(|(block, _)| {
        let own = direction(block, 0);
        let mut others = Vec::new();
        for other in (0..problem.laws.len()).filter(|&other| other != block) {
            others.extend((0..held(other)).map(|row| (starts[other] + row, direction(other, row))));
        }
        let respond = |force: &DVector<f64>| problem.mobility * force;
        let size = others.len();
        let mut matrix = DMatrix::zeros(size, size);
        for (column, (_, force)) in others.iter().enumerate() {
            let rates = respond(force);
            for (row, (at, _)) in others.iter().enumerate() {
                matrix[(row, column)] = rates[*at];
            }
        }
        let own_rates = respond(&own);
        let right = DMatrix::from_fn(
            size,
            2,
            |row, column| if column == 0 { own_rates[others[row].0] } else { free[others[row].0] },
        );
        let largest = matrix.amax();
        let solution = if size == 0 { right } else { matrix.svd(true, true).solve(&right, 1e-11 * largest).ok()? };
        let row = starts[block];
        let (mut mobility, mut rate, mut terms) = (own_rates[row], free[row], free[row].abs());
        for (index, (_, force)) in others.iter().enumerate() {
            let at = respond(force)[row];
            mobility -= at * solution[(index, 0)];
            rate -= at * solution[(index, 1)];
            terms += (at * solution[(index, 1)]).abs();
        }
        // A row that the others imply is held by them: its mobility and its rate are roundings.
        (mobility <= 0.0 && rate < -IMPLIED * terms).then_some((block, mobility))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instant::cone::scenes::{Body, Random, Scene};
    use nalgebra::Vector3;

    #[test]
    fn points_that_others_imply_are_no_paradox_though_their_mobility_is_a_rounding() {
        // A can that slides on six points of its rim, under any load: three of them say all. Of six, some have next to no mobility of either sign.
        let random = &mut Random::new(5);
        for _ in 0..200 {
            let mut can = Body::cuboid(0.5, [0.1, 0.1, 0.27], Vector3::new(0.0, 0.0, 0.136));
            let push = Vector3::from_fn(|_, _| random.signed());
            (can.velocity, can.spin) = (Vector3::new(0.0, 0.0, -9.81) + push, push);
            let mut scene = Scene::new(vec![can]);
            let slide = random.direction();
            let length = slide.x.hypot(slide.y);
            for point in 0..6 {
                let angle = f64::from(point) + 0.3 * random.signed();
                let place = Vector3::new(0.073 * angle.cos(), 0.073 * angle.sin(), 0.0);
                let direction = [slide.x / length, slide.y / length];
                scene.touch(0, None, place, Vector3::z(), Law::Sliding { friction: 0.1, direction });
            }
            let scene = scene.build(0.0);
            let problem = scene.problem();
            let scaled = Scaled::new(&problem);
            // All of them closed, as where Newton's method has stopped.
            let states = vec![BlockState::Slips; 6];
            let closed = Answer { states, ..settle(&problem, &scaled, &[0.0; 18]) };
            assert_eq!(paradox(&problem, &closed), None, "{push}");
        }
    }
}
