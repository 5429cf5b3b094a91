//! The law of impact: rounds of Newton's law among the approaching blocks; no round gains energy.
//!
//! ```text
//!     v_C: u = D P + b, all laws (plastic)         v_N: the same with b_N + e min(γ⁻, 0)
//!     P = P_C + σ (P_N − P_C),     σ the largest in [0, 1] with    ΔE = ½ (u⁻ + u⁺) · P ≤ 0
//! ```
//!
//! b = u⁻ are the rates before, γ⁻ the rates of normals and limits, e the restitution of each block, P impulses, energies in J. If any e > 0 a round
//! is made of the approaching blocks, and rounds follow until every block parts. If all are 0 there is one plastic impact of all. A light body
//! between heavy ones takes about as many rounds as its mass is less. If the last 50 rounds have lost more than a twentieth of the loss of a plastic
//! impact of all, that impact ends them, because such rounds tend to it. Elastic ones go on. If v_N does not exist, because contacts that pinch a
//! body cannot all rebound, σ = 0.
//!
//! Source: B. Smith, D. Kaufman, E. Vouga, R. Tamstorf, E. Grinspun, Reflections on simultaneous impact, ACM Transactions on Graphics 31 (2012).

use crate::instant::cone::cascade::{solve_counted, solve_to_part};
use crate::instant::cone::problem::{Answer, Law, Problem, Unsolved};
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
    let starts = problem.starts();
    let before = problem.free;
    let (impulses, rates) = (vec![0.0; before.len()], before.to_vec());
    let mut state = Impact { impulses, rates, lost: 0.0, rounds: 0, cut: 0.0, without_rebound: 0 };
    let all: Vec<usize> = (0..problem.laws.len()).collect();
    let least = APPROACHES * largest(before);
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
    let answer = solve_to_part(&round, None, left, solvers)?;
    let plastic = &answer.forces;
    let mut impulses = plastic.clone();
    let (mut rebound, mut reached) = (None, 0.0);
    if let Some(restitution) = restitution {
        let mut target = free.clone();
        for (&block, (law, start)) in part.iter().zip(laws.iter().zip(round.starts())) {
            let approach = approach_rate(law, free[start]).min(0.0);
            target[start] += restitution[block] * if free[start] < 0.0 { approach } else { -approach };
        }
        match solve_to_part(&Problem { free: &target, ..round }, Some(plastic), left, solvers) {
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
    // The larger root, written without cancellation for either sign of the linear term.
    let root = (linear * linear - 2.0 * square * constant.min(0.0)).sqrt();
    let share = if linear > 0.0 { -2.0 * constant.min(0.0) / (linear + root) } else { (root - linear) / square };
    share.clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instant::cone::cascade::solve;
    use crate::instant::cone::problem::outside_cone;
    use crate::instant::cone::scenes::{Body, Random, Scene, random, stack};
    use nalgebra::Vector3;

    /// Balls of mass 1 in a row along x that touch, with these velocities.
    fn cradle(velocities: &[f64]) -> Scene {
        let bodies = velocities.iter().enumerate().map(|(index, &velocity)| {
            let mut ball = Body::cuboid(1.0, [0.1; 3], Vector3::new(0.2 * index as f64, 0.0, 0.0));
            ball.velocity.x = velocity;
            ball
        });
        let mut scene = Scene::new(bodies.collect());
        for index in 1..velocities.len() {
            let point = Vector3::new(0.2 * index as f64 - 0.1, 0.0, 0.0);
            scene.touch(index, Some(index - 1), point, Vector3::x(), Law::Contact { friction: 0.0 });
        }
        scene.build(0.0)
    }

    /// Velocities of the balls after an impact.
    fn after(velocities: &[f64], found: &Impact) -> Vec<f64> {
        let mut after = velocities.to_vec();
        for (contact, impulse) in found.impulses.chunks(3).enumerate() {
            after[contact] -= impulse[0];
            after[contact + 1] += impulse[0];
        }
        after
    }

    #[test]
    fn the_last_balls_of_a_cradle_leave() {
        for (before, wanted) in [
            ([1.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 1.0]),
            ([1.0, 1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0, 1.0]),
        ] {
            let scene = cradle(&before);
            let found = impact(&scene.problem(), &[1.0; 4], &mut ContactSolvers::default()).expect("an impact");
            let after = after(&before, &found);
            assert!(after.iter().zip(wanted).all(|(found, wanted)| (found - wanted).abs() < 1e-14), "{after:?}");
            assert!(found.lost.abs() < 1e-15);
        }
        let before = [1.0, 0.0, 0.0, 0.0, 0.0];
        let scene = cradle(&before);
        let plastic = impact(&scene.problem(), &[0.0; 4], &mut ContactSolvers::default()).expect("an impact");
        assert!(after(&before, &plastic).iter().all(|v| (v - 0.2).abs() < 1e-15));
        let half = impact(&scene.problem(), &[0.5; 4], &mut ContactSolvers::default()).expect("an impact");
        let after = after(&before, &half);
        let energy: f64 = after.iter().map(|v| 0.5 * v * v).sum();
        assert!(after.windows(2).all(|pair| pair[0] <= pair[1] + 1e-10), "{after:?}");
        assert!((0.1..=0.5).contains(&energy) && (after.iter().sum::<f64>() - 1.0).abs() < 1e-14);
    }

    #[test]
    fn an_elastic_impact_of_a_heavy_body_on_a_light_one_before_a_wall_keeps_its_energy_however_many_rounds_it_takes() {
        // ⌊π √(M/m)⌋ collisions in all: G. Galperin, Playing pool with π, Regular and Chaotic Dynamics 8 (2003).
        for (heavy, collisions) in [(1e2, 31), (1e4, 314), (1e6, 3141)] {
            let mut first = Body::cuboid(heavy, [0.1; 3], Vector3::zeros());
            first.velocity.x = 1.0;
            let mut scene = Scene::new(vec![first, Body::cuboid(1.0, [0.1; 3], Vector3::new(0.2, 0.0, 0.0))]);
            let law = Law::Contact { friction: 0.0 };
            scene.touch(1, Some(0), Vector3::new(0.1, 0.0, 0.0), Vector3::x(), law);
            scene.touch(1, None, Vector3::new(0.3, 0.0, 0.0), -Vector3::x(), law);
            let scene = scene.build(0.0);
            let found = impact(&scene.problem(), &[1.0; 2], &mut ContactSolvers::default()).expect("an impact");
            // It turns round but for what the light body keeps, a speed no larger than its own: 1 − v² ≤ m/M.
            let after = 1.0 - found.impulses[0] / heavy;
            println!("{heavy}: {} rounds, {after}, {:e} lost", found.rounds, found.lost);
            assert!(found.rounds == collisions && found.cut == 0.0, "{} rounds", found.rounds);
            assert!((after + 1.0).abs() < 1.0 / heavy, "{after}");
            // Each round has the roundings of a few terms of the energy.
            assert!(
                found.lost.abs() <= 1e-15 * collisions as f64 * 0.5 * heavy,
                "{:e} J of {} J",
                found.lost,
                0.5 * heavy
            );
        }
    }

    #[test]
    fn a_rocking_block_keeps_housners_part_of_its_rotation() {
        // A block of half width b and half height h turns about its left edge and lands on its right one: C8 has b/h = 1/3.
        for (half_width, half_height, wanted) in [(0.1, 0.3, 0.85), (0.25, 0.3, 0.385_245_901_639_344_3)] {
            let centre = Vector3::new(0.0, 0.0, half_height);
            let mut block = Body::cuboid(1.3, [2.0 * half_width, 0.2, 2.0 * half_height], centre);
            let spin = Vector3::new(0.0, 1.0, 0.0);
            block.velocity = spin.cross(&(centre - Vector3::new(-half_width, 0.0, 0.0)));
            block.spin = spin;
            let mut scene = Scene::new(vec![block]);
            for (x, y) in [(-1.0, -0.1), (-1.0, 0.1), (1.0, -0.1), (1.0, 0.1)] {
                let point = Vector3::new(x * half_width, y, 0.0);
                scene.touch(0, None, point, Vector3::z(), Law::Contact { friction: 0.8 });
            }
            let scene = scene.build(0.0);
            let found = impact(&scene.problem(), &[0.0; 4], &mut ContactSolvers::default()).expect("an impact");
            // About the right edge, that is the rate at which the left one rises, 2 b ω.
            let after = found.rates[0] / (2.0 * half_width);
            assert!((after - wanted).abs() < 1e-14, "{after} instead of {wanted}");
        }
    }

    #[test]
    fn the_share_of_rebound_ends_where_no_energy_is_gained() {
        let mut cut = 0;
        for seed in 0..400 {
            let scene = random(1 + seed as usize % 3, 1, 0.0, (0.5, 1.5), seed);
            let problem = scene.problem();
            let mut target = scene.free.clone();
            problem.starts().iter().for_each(|&start| target[start] += target[start].min(0.0));
            let plastic = solve(&problem, None).expect("a plastic impact").forces;
            let Ok(newton) = solve(&Problem { free: &target, ..problem }, None) else { continue };
            // Contacts that pinch the body have forces whose rounding is as large as the energy: they gain no energy, but the root is rough.
            let pinched = newton.forces.iter().any(|force| force.abs() > 1e6);
            let share = largest_share(&problem, &plastic, &newton.forces);
            // ΔE at a share, and the size of its terms.
            let gain = |share: f64| {
                let mixed = plastic.iter().zip(&newton.forces);
                let impulses: Vec<f64> = mixed.map(|(plastic, newton)| plastic + share * (newton - plastic)).collect();
                let after = problem.rates(&impulses);
                let terms = impulses.iter().zip(scene.free.iter().zip(&after));
                terms.fold((0.0, 0.0), |(sum, size), (impulse, (one, other))| {
                    (sum + 0.5 * impulse * (one + other), size + (impulse * one).abs() + (impulse * other).abs())
                })
            };
            let (found, size) = gain(share);
            assert!(found <= 1e-14 * size, "seed {seed}: gains {found:e} at {share}");
            if share < 1.0 && !pinched {
                cut += 1;
                assert!(gain((share + 1e-6).min(1.0)).0 > found, "seed {seed}: {share} is not the largest");
                assert!(found.abs() <= 1e-13 * size, "seed {seed}: {found:e} is left at {share}");
            }
        }
        assert!(cut > 0, "Newton's law gains energy in none of these impacts");
    }

    #[test]
    fn no_random_impact_gains_energy() {
        let mut random_numbers = Random::new(11);
        let (mut most, mut rounds, mut without_rebound) = (0.0_f64, 0, 0);
        for seed in 0..200 {
            let scene = match seed % 4 {
                0 => random(3, 1, 2.0, (0.05, 1.2), seed),
                1 => random(8, 3, 2.0, (0.05, 1.2), seed),
                2 => random(4, 3, 4.0, (0.0, 1.2), seed),
                _ => stack(&[1.0, 10.0, 0.1], 0.4, 1.0),
            };
            let restitution: Vec<f64> = scene.laws.iter().map(|_| random_numbers.between(-0.3, 1.0).max(0.0)).collect();
            let found = impact(&scene.problem(), &restitution, &mut ContactSolvers::default()).expect("an impact");
            let rates = scene.problem().rates(&found.impulses);
            let terms = found.impulses.iter().zip(scene.free.iter().zip(&rates));
            let gained: f64 = terms.clone().map(|(impulse, (one, other))| 0.5 * impulse * (one + other)).sum();
            let size: f64 = terms.map(|(impulse, (one, other))| 0.5 * (impulse * (one + other)).abs()).sum();
            most = most.max(gained / size.max(f64::MIN_POSITIVE));
            rounds = rounds.max(found.rounds);
            without_rebound += found.without_rebound;
            assert!(
                (gained + found.lost).abs() <= 1e-12 * size,
                "seed {seed}: {gained:e} gained, {:e} lost",
                found.lost
            );
            let fastest = scene.free.iter().fold(0.0_f64, |most, rate| most.max(rate.abs()));
            for (law, start) in scene.laws.iter().zip(scene.problem().starts()) {
                let Law::Contact { friction } = *law else { continue };
                let impulse = &found.impulses[start..start + 3];
                let beyond = outside_cone(friction, [impulse[0], impulse[1], impulse[2]]);
                assert!(beyond <= 1e-12 * found.impulses.iter().fold(0.0, |most, p| p.abs().max(most)), "seed {seed}");
                assert!(rates[start] >= -2.0 * APPROACHES * fastest, "seed {seed}: {:e} approaches", rates[start]);
            }
        }
        println!("most energy gained {most:e}, most rounds {rounds}, without rebound {without_rebound}");
        assert!(most <= 2e-15, "{most:e}");
    }

    #[test]
    fn a_contact_with_fewer_freedoms_than_rows_gets_impulses_of_the_size_of_the_momentum() {
        // Two freedoms and three rows: D has rank 2, and rates with a part along its null vector are no rates of the mechanism. Newton's law asks for
        // such rates, and roundings of D times impulses of 1e12 would give them.
        let mut random_numbers = Random::new(7);
        for round in 0..2000 {
            let rows = DMatrix::from_fn(3, 2, |_, _| random_numbers.signed());
            let mobility = &rows * rows.transpose();
            let momentum = nalgebra::DVector::from_fn(2, |_, _| random_numbers.signed());
            let before = &rows * &momentum;
            let laws = [Law::Contact { friction: random_numbers.between(0.05, 1.5) }];
            let problem = Problem { mobility: &mobility, free: before.as_slice(), laws: &laws };
            let found = impact(&problem, &[random_numbers.between(0.0, 1.0)], &mut ContactSolvers::default())
                .expect("an impact");
            let kinetic = 0.5 * momentum.norm_squared();
            let after =
                (&rows.transpose() * nalgebra::DVector::from_vec(found.impulses.clone()) + &momentum).norm_squared();
            let normal = rows.row(0).norm();
            // Friction that nearly jams has impulses that are larger than the momentum; laws are solved to 1e-11 of impulses that are not larger than 100.
            assert!(found.impulses[0] <= 1e6 * kinetic.sqrt() / normal, "round {round}: {:?}", found.impulses);
            assert!((0.5 * after - (kinetic - found.lost)).abs() <= 1e-9 * kinetic, "round {round}: {after}");
            assert!(
                found.lost >= -1e-9 * kinetic && found.lost <= (1.0 + 1e-9) * kinetic,
                "round {round}: {:e}",
                found.lost
            );
        }
    }
}
