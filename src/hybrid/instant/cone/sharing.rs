//! Impulses on contacts of which some imply others: those of equal springs below all that press, in the limit of infinite stiffness.
//!
//! If the normals of contacts imply each other, `zᵀ W_N = 0`, they can share an impulse in many ways. Each of them has another
//! friction: another motion behind a blow with slips, and slips or none at all. Impulses that press a body from two sides could hold it anywhere. The
//! law is `zᵀ P_N = 0` for every z of the contacts that press, as of sliding contacts in a step, and springs do not pull. With an orthonormal basis of
//! all z
//!
//! ```text
//!     D' = D + ε d Σ_z z zᵀ        on the rows of the normals; d: the mean of their D_ii
//! ```
//!
//! has this solution for every ε, because the added term vanishes. Springs do not pull: contacts without an impulse leave the springs, and the z of
//! the others alone follow. Such a contact presses again if the motion brings it down, or if the springs of the others would press there:
//! `P' = Σ c_i P_i > 0` with its gradient `r = Σ c_i r_i`.
//!
//! Normals that are independent may still have several impulses where contacts slip and rows of friction imply others: a cart that meets a step
//! squarely with both front wheels has a motion straight on, and two that are mirror images of each other. Compliances in all blocks that vanish
//! together, from impulses of zero on, lead to the first: every step of Newton's method treats mirror images alike, and sweeps do not.

use crate::instant::cone::apart::{parts_apart, parts_of, sub_matrix, with_unit_diagonal};
use crate::instant::cone::cascade::{ACCEPTED, EVERYDAY, compliant, solve_to_part};
use crate::instant::cone::least_norm::{least_norm, spread};
use crate::instant::cone::newton::improve;
use crate::instant::cone::problem::{Answer, BlockState, Law, Problem, Unsolved};
use crate::instant::cone::scaled::Scaled;
use crate::instant::cone::settling::settle;
use crate::mechanism::motion::contact_solvers::ContactSolvers;
use nalgebra::{DMatrix, DVector};

/// Held rows whose response is singular to this part are redundant.
const SINGULAR: f64 = 1e-10;
/// ε.
const BEARS: f64 = 1.0;
/// The rate at which contacts leave that springs would pull, as part of the largest: the others hold their gaps closed, and they would press at random.
const LIFTED: f64 = 1e-7;
/// A row is implied by others that leave this part of its mobility.
const IMPLIED: f64 = 1e-9;
/// Springs of other contacts press if they do so with more than this part of all impulses.
const PRESSES: f64 = 1e-9;
/// Rates that differ by less than this part of the largest are of one motion.
const ALIKE: f64 = 1e-8;
/// Rounds in which contacts may open or press again.
const ROUNDS: usize = 12;

/// Solves a problem as [`solve_to_part`] does; with the impulses of equal springs where friction acts, if these can be found
/// and fit the law as well as the others.
pub(super) fn solve_sharing(
    problem: &Problem,
    start: Option<&[f64]>,
    part: f64,
    solvers: &mut ContactSolvers,
) -> Result<Answer, Unsolved> {
    let solved = solve_to_part(problem, start, part, solvers)?;
    let rubs = |(law, state): (&Law, &BlockState)| law.rows() > 1 && *state != BlockState::Open;
    if !problem.laws.iter().zip(&solved.states).any(rubs) {
        return Ok(solved);
    }
    let enough = solved.residual.max(ACCEPTED);
    let shared = shared(problem, part).filter(|found| found.residual <= enough);
    Ok(shared.or_else(|| of_vanishing_compliance(problem, &solved, fastest(problem))).unwrap_or(solved))
}

/// The answer behind those with a compliance in each block that vanishes, where it moves otherwise than the one that was found, or more contacts bear, and
/// the one that was found elsewhere: part by part of a problem that falls apart.
pub(crate) fn with_vanishing_compliance(problem: &Problem, mut solved: Answer) -> Answer {
    let largest = fastest(problem);
    let Some(parts) = parts_apart(problem) else {
        return of_vanishing_compliance(problem, &solved, largest).unwrap_or(solved);
    };
    for part in parts {
        if let Some(found) = of_vanishing_compliance(&part.problem(), &part.answer_in(&solved), largest) {
            part.put_into(&mut solved, &found);
        }
    }
    solved
}

/// The largest free rate of a problem.
fn fastest(problem: &Problem) -> f64 {
    problem.free.iter().fold(0.0_f64, |most, rate| most.max(rate.abs()))
}

/// The same of a problem as a whole, which is beside or among others with free rates up to `largest`; `None` if it is no other, or if there is one answer:
/// with fewer than two contacts, where all stick, or where no rows imply others.
fn of_vanishing_compliance(problem: &Problem, solved: &Answer, largest: f64) -> Option<Answer> {
    let contacts = |answer: &Answer| {
        let states = problem.laws.iter().zip(&answer.states).filter(|(law, _)| law.rows() > 1);
        states.map(|(_, state)| *state).collect::<Vec<BlockState>>()
    };
    let states = contacts(solved);
    if states.len() < 2 || states.iter().all(|state| *state == BlockState::Sticks) {
        return None;
    }
    let rows: Vec<usize> = (0..problem.free.len()).filter(|&row| problem.mobility[(row, row)] > 0.0).collect();
    implied(with_unit_diagonal(problem.mobility, &rows).0).filter(|columns| !columns.is_empty())?;
    let scaled = Scaled::new(problem);
    let mut forces = compliant(&scaled);
    improve(&scaled, &mut forces, EVERYDAY);
    let found = settle(problem, &scaled, &forces);
    let moves_alike = found.rates.iter().zip(&solved.rates).all(|(one, other)| (one - other).abs() <= ALIKE * largest);
    let open = |states: &[BlockState]| states.iter().filter(|state| **state == BlockState::Open).count();
    let is_other = !moves_alike || open(&contacts(&found)) < open(&states);
    (is_other && found.residual <= solved.residual.max(ACCEPTED)).then_some(found)
}

/// The answer of equal springs; `None` if no normals imply others, or if it is not found.
fn shared(problem: &Problem, part: f64) -> Option<Answer> {
    let solvers = &mut ContactSolvers::default();
    let starts = problem.starts();
    let presses = |law: &Law| match *law {
        Law::Interval { lower, upper } => lower == 0.0 && upper == f64::INFINITY,
        Law::Contact { .. } | Law::Sliding { .. } => true,
    };
    let normals = starts.iter().zip(problem.laws).filter(|(_, law)| presses(law)).map(|(row, _)| *row);
    let normals: Vec<usize> = normals.filter(|&row| problem.mobility[(row, row)] > 0.0).collect();
    let lifted = LIFTED * fastest(problem);
    let mut bearing = normals.clone();
    let mut near = None::<Vec<f64>>;
    for _ in 0..ROUNDS {
        let springs = on_equal_springs(problem.mobility, &bearing, BEARS);
        if springs.is_none() && near.is_none() {
            return None;
        }
        let mobility = springs.as_ref().unwrap_or(problem.mobility);
        let mut free = problem.free.to_vec();
        normals.iter().filter(|row| !bearing.contains(row)).for_each(|&row| free[row] += lifted);
        let lifting = Problem { mobility, free: &free, ..*problem };
        let found = solve_to_part(&lifting, near.as_deref(), part, solvers).ok()?;
        let mut pressed: Vec<usize> = normals.iter().copied().filter(|&row| found.forces[row] > 0.0).collect();
        if pressed == bearing {
            let off: Vec<usize> = normals.iter().copied().filter(|row| !bearing.contains(row)).collect();
            let pressed_again = pressed_by_others(problem.mobility, &bearing, &off, &found.forces)?;
            if pressed_again.is_empty() {
                let scaled = Scaled::new(problem);
                return Some(settle(problem, &scaled, &scaled.scale(&found.forces)));
            }
            pressed.extend(pressed_again);
            pressed.sort_unstable();
        }
        (bearing, near) = (pressed, Some(found.forces));
    }
    None
}

/// The rows off the springs that the springs of others would press; `None` if a number is not finite.
fn pressed_by_others(mobility: &DMatrix<f64>, bearing: &[usize], off: &[usize], forces: &[f64]) -> Option<Vec<usize>> {
    let among = DMatrix::from_fn(bearing.len(), bearing.len(), |i, j| mobility[(bearing[i], bearing[j])]);
    let total: f64 = bearing.iter().map(|&row| forces[row]).sum();
    let mut pressed = Vec::new();
    for &row in off {
        let along = DVector::from_fn(bearing.len(), |i, _| mobility[(bearing[i], row)]);
        let (parts, _) = least_norm(&among, &along)?;
        let own = mobility[(row, row)];
        let is_implied = own - parts.dot(&along) <= IMPLIED * own;
        let pressure: f64 = parts.iter().zip(bearing).map(|(part, &other)| part * forces[other]).sum();
        if is_implied && pressure > PRESSES * total {
            pressed.push(row);
        }
    }
    Some(pressed)
}

/// D' for the rows of some normals; `None` if none of them imply others.
pub(crate) fn on_equal_springs(mobility: &DMatrix<f64>, normals: &[usize], gives: f64) -> Option<DMatrix<f64>> {
    let count = normals.len();
    if count < 2 {
        return None;
    }
    let (scaled, scales) = with_unit_diagonal(mobility, normals);
    let implied = implied(scaled).filter(|columns| !columns.is_empty())?;
    let mean = normals.iter().map(|&row| mobility[(row, row)]).sum::<f64>() / count as f64;
    let basis = DMatrix::from_fn(count, implied.len(), |i, column| implied[column][i] * scales[i]).qr().q();
    let springs = &basis * basis.transpose() * (gives * mean);
    let mut shared = mobility.clone();
    for (i, &row) in normals.iter().enumerate() {
        for (j, &column) in normals.iter().enumerate() {
            shared[(row, column)] += springs[(i, j)];
        }
    }
    Some(shared)
}

/// The vanishing combinations of rows, of length one, of a symmetric response with a unit diagonal, part by part; `None` if a number is not finite.
pub(crate) fn implied(scaled: DMatrix<f64>) -> Option<Vec<DVector<f64>>> {
    if !scaled.iter().all(|value| value.is_finite()) {
        return None;
    }
    let mut all = Vec::new();
    for part in parts_of(&scaled) {
        let eigen = sub_matrix(&scaled, &part).symmetric_eigen();
        let least = SINGULAR * eigen.eigenvalues.max();
        let of_implied = (0..eigen.eigenvalues.len()).filter(|&index| eigen.eigenvalues[index] <= least);
        all.extend(of_implied.map(|index| spread(&part, eigen.eigenvectors.column(index).iter(), scaled.nrows())));
    }
    Some(all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instant::cone::impact::impact;
    use crate::instant::cone::scenes::{Body, Random, Scene};
    use nalgebra::Vector3;

    /// A box of any height that lands flat on points while it slides and turns, with these of them in this order.
    fn landing(seed: u64, points: &[[f64; 2]], order: &[usize]) -> Scene {
        let random = &mut Random::new(seed);
        let height = random.between(0.04, 0.9);
        let mut body = Body::cuboid(1.3, [0.24, 0.26, height], Vector3::new(0.0, 0.0, 0.5 * height));
        body.velocity = Vector3::new(random.signed(), random.signed(), -1.0);
        body.spin = Vector3::new(4.0 * random.signed(), 4.0 * random.signed(), 6.0 * random.signed());
        let friction = random.between(0.05, 0.6);
        let mut scene = Scene::new(vec![body]);
        for &index in order {
            let [x, y] = points[index];
            scene.touch(0, None, Vector3::new(x, y, 0.0), Vector3::z(), Law::Contact { friction });
        }
        scene.build(0.0)
    }

    #[test]
    fn a_box_that_lands_flat_while_it_slides_moves_on_alike_in_any_order_of_its_points() {
        let points = [[0.12, 0.13], [-0.12, 0.13], [-0.12, -0.13], [0.12, -0.13], [0.12, 0.02]];
        let orders = [[0, 1, 2, 3, 4], [2, 3, 0, 1, 4], [4, 3, 2, 1, 0], [1, 0, 4, 3, 2]];
        let (mut all_press, mut some_open) = (0, 0);
        for seed in 0..200 {
            let mut first = None::<Vec<[f64; 3]>>;
            for order in &orders {
                let scene = landing(seed, &points, order);
                let found = impact(&scene.problem(), &[0.0; 5], &mut ContactSolvers::default()).expect("an impact");
                assert!(found.lost >= 0.0, "seed {seed}: {:e} J lost", found.lost);
                let mut rates = vec![[0.0; 3]; 5];
                for (place, &index) in order.iter().enumerate() {
                    rates[index] = [0, 1, 2].map(|row| found.rates[3 * place + row]);
                }
                let first = first.get_or_insert_with(|| rates.clone());
                let off = rates.iter().flatten().zip(first.iter().flatten()).map(|(one, other)| (one - other).abs());
                let off = off.fold(0.0, f64::max);
                assert!(off < 1e-10, "seed {seed}, {order:?}: rates {off:e} m/s apart");
                let normal: Vec<f64> = (0..5).map(|index| found.impulses[3 * index]).collect();
                let slips = rates.iter().any(|[_, one, other]| one.hypot(*other) > 1e-9);
                if slips && normal.iter().all(|impulse| *impulse > 0.0) {
                    all_press += 1;
                    // Impulses lie on a plane over the points.
                    let of = |index: usize| normal[order.iter().position(|own| *own == index).expect("a point")];
                    let off = of(0) - of(1) + of(2) - of(3);
                    assert!(off.abs() < 1e-9 * normal.iter().sum::<f64>(), "seed {seed}, {order:?}: {off:e} N s");
                }
                some_open += usize::from(slips && normal.contains(&0.0));
            }
        }
        assert!(all_press > 40 && some_open > 40, "{all_press} with all, {some_open} with some");
    }
}
