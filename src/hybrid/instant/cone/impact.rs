//! The law of impact: rounds of Newton's law among the approaching blocks; no round gains energy.
//!
//! ```text
//!     v_C: u = D P + b, all laws (plastic)         v_N: the same with b_N + e min(γ⁻, 0)
//!     P = P_C + σ (P_N − P_C),     σ the largest in [0, 1] with    ΔE = ½ (u⁻ + u⁺) · P ≤ 0
//! ```
//!
//! b = u⁻ are the rates before, γ⁻ the rates of normals and limits, e the restitution of each block, P impulses, energies in J. If any e > 0 a round
//! is made of the approaching blocks, and rounds follow until every block parts. If all are 0 there is one plastic impact of all. Blocks that do not feel
//! each other, directly or by others, are impacts of their own: a ball beside two bodies that collide does not change their impact. A light body
//! between heavy ones takes about as many rounds as its mass is less. If the last 50 rounds have lost more than a twentieth of the loss of a plastic
//! impact of all, that impact ends them, because such rounds tend to it. Elastic ones go on. If v_N does not exist, because contacts that pinch a
//! body cannot all rebound, σ = 0. If no solver reaches its accuracy, as for points that nearly coincide, the best impulses are taken
//! if they leave a millionth of the rates: of large impulses on a light body that may be a small residual of wrong rates.
//!
//! Source: B. Smith, D. Kaufman, E. Vouga, R. Tamstorf, E. Grinspun, Reflections on simultaneous impact, ACM Transactions on Graphics 31 (2012).

use crate::instant::cone::apart::parts_apart;
use crate::instant::cone::cascade::{left_of_rates, solve_counted};
use crate::instant::cone::problem::{Answer, Law, Problem, ROUGH, Unsolved};
use crate::instant::cone::sharing::solve_sharing;
use crate::mechanism::motion::contact_solvers::ContactSolvers;
use nalgebra::DMatrix;

/// Rounds after which a plastic impact may end them, if they tend to it.
const ROUNDS: usize = 50;
/// Rounds tend to a plastic impact if they have lost this part of its loss.
const TENDS: f64 = 0.05;
/// Most rounds, times the rows of the problem.
const MOST: usize = 30_000;
/// A block approaches if its rate is below minus this part of the largest rate before.
const APPROACHES: f64 = 1e-10;
/// Rate of approach that picks the impulse of a paradox, as part of the largest rate.
const APPROACH: f64 = 1e-6;
/// Rates below this part of the terms that they are the sum of are rounding.
const ROUNDING: f64 = 1e-13;

/// Rounds are late if less than this part of the rates is left.
const LATE: f64 = 1e-3;

/// The result of an impact.
#[derive(Clone, Debug, PartialEq)]
pub struct Impact {
    /// P (m), of all rounds together.
    pub impulses: Vec<f64>,
    /// u⁺ (m).
    pub rates: Vec<f64>,
    /// −ΔE ≥ 0, but for rounding.
    pub lost: f64,
    /// Number of rounds.
    pub rounds: usize,
    /// The energy that rebounds have not given back because there were too many rounds.
    pub cut: f64,
    /// Rounds that were plastic because v_N does not exist.
    pub without_rebound: usize,
    /// The largest part of the rates that plastic answers leave which no solver has brought to its accuracy; zero where all were.
    pub residual: f64,
}

impl Impact {
    /// No impulses.
    fn none(problem: &Problem) -> Self {
        let (impulses, rates) = (vec![0.0; problem.free.len()], problem.free.to_vec());
        Impact { impulses, rates, lost: 0.0, rounds: 0, cut: 0.0, without_rebound: 0, residual: 0.0 }
    }
}

/// A round: the blocks that take part, its plastic answer, the answer of Newton's law if there is one, and σ.
#[derive(Clone, Debug)]
pub struct Round {
    pub part: Vec<usize>,
    pub plastic: Answer,
    pub rebound: Option<Answer>,
    pub share: f64,
}

/// The impact of a problem whose free rates are the rates before, with a restitution for each block.
///
/// # Errors
/// The errors of [`solve`], and if there is not one restitution between 0 and 1 for each block.
pub(crate) fn impact(problem: &Problem, restitution: &[f64], solvers: &mut ContactSolvers) -> Result<Impact, Unsolved> {
    impact_in_rounds(problem, restitution, solvers, &mut None)
}

/// The same, with its rounds.
///
/// # Errors
/// The errors of [`impact`].
pub fn impact_in_rounds(
    problem: &Problem,
    restitution: &[f64],
    solvers: &mut ContactSolvers,
    rounds: &mut Option<Vec<Round>>,
) -> Result<Impact, Unsolved> {
    problem.check()?;
    let sound = |block: usize| restitution.get(block).is_some_and(|e| (0.0..=1.0).contains(e));
    if let Some(block) = (0..problem.laws.len()).find(|&block| !sound(block)) {
        return Err(Unsolved::Numbers { block });
    }
    let least = APPROACHES * largest(problem.free);
    let Some(parts) = parts_apart(problem) else {
        return impact_of_part(problem, restitution, least, solvers, rounds);
    };
    let mut whole = Impact::none(problem);
    for part in parts {
        let of_part: Vec<f64> = part.blocks.iter().map(|&block| restitution[block]).collect();
        let mut own = rounds.as_ref().map(|_| Vec::new());
        let found = impact_of_part(&part.problem(), &of_part, least, solvers, &mut own)?;
        for (place, &row) in part.rows.iter().enumerate() {
            (whole.impulses[row], whole.rates[row]) = (found.impulses[place], found.rates[place]);
        }
        whole.lost += found.lost;
        whole.cut += found.cut;
        whole.rounds += found.rounds;
        whole.without_rebound += found.without_rebound;
        whole.residual = whole.residual.max(found.residual);
        let in_whole = |round: Round| Round { part: round.part.iter().map(|&own| part.blocks[own]).collect(), ..round };
        if let (Some(rounds), Some(own)) = (rounds.as_mut(), own) {
            rounds.extend(own.into_iter().map(in_whole));
        }
    }
    Ok(whole)
}

/// The impact of blocks that feel each other; rates up to `least` [m/s or rad/s] are no approach.
fn impact_of_part(
    problem: &Problem,
    restitution: &[f64],
    least: f64,
    solvers: &mut ContactSolvers,
    rounds: &mut Option<Vec<Round>>,
) -> Result<Impact, Unsolved> {
    let starts = problem.starts();
    let before = problem.free;
    let mut state = Impact::none(problem);
    let all: Vec<usize> = (0..problem.laws.len()).collect();
    if restitution.iter().any(|e| *e > 0.0) {
        let (mut asked, mut lost) = (ROUNDS, 0.0);
        loop {
            if state.rounds == asked {
                let most = MOST / before.len().max(1);
                let mut plastic = state.clone();
                match round(problem, &starts, &all, None, &mut plastic, solvers, &mut None) {
                    Ok(()) => {
                        let left = plastic.lost - state.lost;
                        let tends = state.lost - lost >= TENDS * left;
                        if tends || state.rounds >= most {
                            plastic.cut = if tends { 0.0 } else { left };
                            return Ok(plastic);
                        }
                    }
                    // A light body that is fast between heavy ones: rounds among less go on.
                    Err(_) if state.rounds < most => {}
                    Err(error) => return Err(error),
                }
                (asked, lost) = (asked + ROUNDS, state.lost);
            }
            let approach = |block: &usize| approach_rate(&problem.laws[*block], state.rates[starts[*block]]) < -least;
            if !all.iter().any(approach) {
                return Ok(state);
            }
            // Blocks that hold both ways take part whenever another block approaches.
            let takes_part = |block: &usize| approach(block) || holds_both_ways(&problem.laws[*block]);
            let part: Vec<usize> = all.iter().copied().filter(takes_part).collect();
            round(problem, &starts, &part, Some(restitution), &mut state, solvers, rounds)?;
        }
    }
    round(problem, &starts, &all, None, &mut state, solvers, rounds)?;
    Ok(state)
}

/// The impulse of a contact that slides and has no consistent acceleration (Painlevé), without a collision: b_N of its block is 0.
///
/// No impulse at all fits the law as well. This is the limit of the answers for small rates of approach, which have to stop.
///
/// # Errors
/// The errors of [`solve`].
pub(crate) fn impulse_without_collision(
    problem: &Problem,
    block: usize,
    solvers: &mut ContactSolvers,
) -> Result<Answer, Unsolved> {
    problem.check()?;
    let Some(&row) = problem.starts().get(block) else { return Err(Unsolved::Numbers { block }) };
    let mut approaching = problem.free.to_vec();
    approaching[row] -= APPROACH * problem.free.iter().fold(0.0_f64, |most, rate| most.max(rate.abs()));
    let near = solve_counted(&Problem { free: &approaching, ..*problem }, None, solvers)?;
    solve_counted(problem, Some(&near.forces), solvers)
}

/// The rate with which a block comes together; 0 for a block that holds both ways.
fn approach_rate(law: &Law, rate: f64) -> f64 {
    match *law {
        Law::Contact { .. } | Law::Sliding { .. } => rate,
        Law::Interval { lower, upper } if lower == 0.0 && upper > 0.0 => rate,
        Law::Interval { lower, upper } if upper == 0.0 && lower < 0.0 => -rate,
        Law::Interval { .. } => 0.0,
    }
}

fn holds_both_ways(law: &Law) -> bool {
    matches!(*law, Law::Interval { lower, upper } if lower < 0.0 && upper > 0.0)
}

/// One round among some blocks; without restitution it is plastic.
fn round(
    problem: &Problem,
    starts: &[usize],
    part: &[usize],
    restitution: Option<&[f64]>,
    state: &mut Impact,
    solvers: &mut ContactSolvers,
    rounds: &mut Option<Vec<Round>>,
) -> Result<(), Unsolved> {
    let rows: Vec<usize> =
        part.iter().flat_map(|&block| starts[block]..starts[block] + problem.laws[block].rows()).collect();
    let mobility = DMatrix::from_fn(rows.len(), rows.len(), |row, column| problem.mobility[(rows[row], rows[column])]);
    let free: Vec<f64> = rows.iter().map(|&row| state.rates[row]).collect();
    // The part of a bound that earlier rounds have used is gone.
    let laws: Vec<Law> = part
        .iter()
        .map(|&block| match problem.laws[block] {
            Law::Interval { lower, upper } => {
                let used = state.impulses[starts[block]];
                let left = |bound: f64| if bound == 0.0 || bound.is_infinite() { bound } else { bound - used };
                Law::Interval { lower: left(lower), upper: left(upper) }
            }
            law => law,
        })
        .collect();
    let round = Problem { mobility: &mobility, free: &free, laws: &laws };
    // Late rounds have small rates, whose digits are roundings of the rates before the impact.
    let left = largest(&free) / largest(problem.free);
    let left = if left < LATE { left } else { 1.0 };
    let answer = match solve_sharing(&round, None, left, solvers) {
        Err(Unsolved::Stopped { best }) => {
            let of_rates = left_of_rates(&round, &best);
            // NaN is not enough, either.
            let is_enough = of_rates <= ROUGH;
            if !is_enough {
                return Err(Unsolved::Stopped { best });
            }
            state.residual = state.residual.max(of_rates);
            *best
        }
        other => other?,
    };
    let plastic = &answer.forces;
    let mut impulses = plastic.clone();
    let (mut rebound, mut reached) = (None, 0.0);
    if let Some(restitution) = restitution {
        let mut target = free.clone();
        for (&block, (law, start)) in part.iter().zip(laws.iter().zip(round.starts())) {
            let approach = approach_rate(law, free[start]).min(0.0);
            target[start] += restitution[block] * if free[start] < 0.0 { approach } else { -approach };
        }
        match solve_sharing(&Problem { free: &target, ..round }, Some(plastic), left, solvers) {
            Ok(newton) => {
                let share = largest_share(&round, plastic, &newton.forces);
                for (impulse, newton) in impulses.iter_mut().zip(&newton.forces) {
                    *impulse = if share == 1.0 { *newton } else { *impulse + share * (newton - *impulse) };
                }
                (rebound, reached) = (Some(newton), share);
            }
            // Contacts that pinch a body cannot all rebound: v_N does not exist, and the round is plastic.
            Err(Unsolved::Stopped { .. }) => state.without_rebound += 1,
            Err(other) => return Err(other),
        }
    }
    let after = round.rates(&impulses);
    state.lost -= impulses
        .iter()
        .zip(free.iter().zip(&after))
        .map(|(impulse, (one, other))| 0.5 * impulse * (one + other))
        .sum::<f64>();
    for (&row, impulse) in rows.iter().zip(&impulses) {
        state.impulses[row] += impulse;
    }
    state.rates = problem.rates(&state.impulses);
    clear_rounding(problem, state);
    state.rounds += 1;
    if let Some(rounds) = rounds {
        rounds.push(Round { part: part.to_vec(), plastic: answer, rebound, share: reached });
    }
    Ok(())
}

/// The largest size of some rates.
fn largest(rates: &[f64]) -> f64 {
    rates.iter().fold(0.0_f64, |most, rate| most.max(rate.abs()))
}

/// Sets rates to zero that are rounding of the terms that they are the sum of.
fn clear_rounding(problem: &Problem, state: &mut Impact) {
    let mut sizes: Vec<f64> = problem.free.iter().map(|free| free.abs()).collect();
    for (column, impulse) in problem.mobility.column_iter().zip(&state.impulses).filter(|(_, impulse)| **impulse != 0.0)
    {
        for (size, mobility) in sizes.iter_mut().zip(column.iter()) {
            *size += (mobility * impulse).abs();
        }
    }
    for (rate, size) in state.rates.iter_mut().zip(sizes) {
        if rate.abs() <= ROUNDING * size {
            *rate = 0.0;
        }
    }
}

/// σ: the largest part of the way from the plastic impulses to others that gains no energy.
fn largest_share(problem: &Problem, plastic: &[f64], newton: &[f64]) -> f64 {
    let change: Vec<f64> = newton.iter().zip(plastic).map(|(newton, plastic)| newton - plastic).collect();
    let dot = |one: &[f64], other: &[f64]| one.iter().zip(other).map(|(one, other)| one * other).sum::<f64>();
    let response = |impulses: &[f64]| {
        let rates = problem.rates(impulses);
        rates.iter().zip(problem.free).map(|(rate, free)| rate - free).collect::<Vec<f64>>()
    };
    // ΔE(σ) = constant + linear σ + ½ square σ².
    let of_plastic = response(plastic);
    let constant = dot(problem.free, plastic) + 0.5 * dot(plastic, &of_plastic);
    let linear = dot(problem.free, &change) + dot(&change, &of_plastic);
    let square = dot(&change, &response(&change));
    let size = dot(problem.free, plastic).abs() + dot(plastic, &of_plastic).abs() + dot(problem.free, &change).abs();
    let gain = constant + linear + 0.5 * square;
    if gain <= 4.0 * f64::EPSILON * size {
        return 1.0;
    }
    share_without_gain(constant, linear, square)
}

/// The largest σ in [0, 1] with `constant + linear σ + ½ square σ² ≤ 0` (J); a positive constant counts as 0.
pub(crate) fn share_without_gain(constant: f64, linear: f64, square: f64) -> f64 {
    // The larger root, written without cancellation for either sign of the linear term.
    let lost = constant.min(0.0);
    let root = (linear * linear - 2.0 * square * lost).sqrt();
    let share = if linear > 0.0 { -2.0 * lost / (linear + root) } else { (root - linear) / square };
    share.clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests;
