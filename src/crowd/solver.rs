//! The solver of an island: Newton's method, then proximal points, then interior points from several depths in the cones, then convex problems; the last two
//! finished by Newton's method.
//!
//! Blocks that exert no impulse and do not close are left out, until the others make them close.

use crate::centred::proximal_points;
use crate::convex::rounds;
use crate::effort::Effort;
use crate::interior::interior;
use crate::newton::{Parts, Workspace, newton};
use crate::problem::{Block, Problem};
use nalgebra::Vector3;

/// The residual at which an island counts as solved.
pub const TOLERANCE: f64 = 5e-9;
/// The residual of a coarse solution.
pub const COARSE: f64 = 1e-3;
/// Blocks that close more slowly than this part of the largest free rate, or part so slowly, take part from the start: those above falling ones.
const NEARLY: f64 = 1e-5;
/// Blocks are added this often at most.
const WIDENED: usize = 10;
/// The most iterations of Newton's method, of the same after blocks were added to a solution that had stalled, and of those that finish another one.
const NEWTON: f64 = 80.0;
const AGAIN: f64 = 20.0;
const FINISH: f64 = 40.0;
/// How far inside the cones interior points start, in units of the largest bias. Each is one more chance.
const DEPTHS: [f64; 3] = [10.0, 1e3, 0.1];

/// Solves the problem of an island from these impulses until its residual is below `tolerance`; returns the residual. Blocks that exert no impulse and do
/// not close are left out, until the others make them close: hundreds of points of a hull are near a floor, and few of them press. Which of them take
/// part is found out with a coarse solution. Without `hard`, Newton's method is the only one. A large island on which it stalls is content with 1e-6.
pub fn solve(
    problem: &mut Problem,
    impulses: &mut [Vector3<f64>],
    v: &mut Vec<f64>,
    (tolerance, hard): (f64, bool),
    room: &mut Workspace,
) -> f64 {
    let all = std::mem::take(&mut problem.blocks);
    let effort = Effort::of(all.len(), tolerance);
    let nearly = NEARLY * problem.free.iter().fold(0.0_f64, |most, rate| most.max(rate.abs()));
    let Parts { mut part, mut own, blocks } = std::mem::take(&mut room.parts);
    problem.blocks = blocks;
    part.clear();
    part.extend((0..all.len()).filter(|&number| {
        impulses[number] != Vector3::zeros() || problem.is_called(&all[number], &problem.free, nearly)
    }));
    let (mut residual, mut within, mut stalled) = (0.0, tolerance.max(COARSE), false);
    for _ in 0..WIDENED {
        problem.blocks.clear();
        problem.blocks.extend(part.iter().map(|&number| all[number]));
        own.clear();
        own.extend(part.iter().map(|&number| impulses[number]));
        let most = if stalled { AGAIN } else { NEWTON };
        residual = newton(problem, &mut own, v, [within, most], room);
        stalled = residual > within;
        let mut more = called(problem, &all, &part, v);
        if hard && more.is_empty() && within <= tolerance && residual > effort.residual && !own.is_empty() {
            residual = harder(problem, &mut own, residual, v, effort, room);
            more = called(problem, &all, &part, v);
        }
        part.iter().zip(&own).for_each(|(&number, impulse)| impulses[number] = *impulse);
        if more.is_empty() {
            if residual <= tolerance || within <= tolerance {
                break;
            }
            within = tolerance;
        }
        part.extend(more);
        part.sort_unstable();
    }
    let blocks = std::mem::replace(&mut problem.blocks, all);
    room.parts = Parts { part, own, blocks };
    residual
}

/// The blocks that take no part and close at these rates.
fn called(problem: &Problem, all: &[Block], part: &[usize], v: &[f64]) -> Vec<usize> {
    let mut inside = part.iter().copied().peekable();
    let others = (0..all.len()).filter(|number| inside.next_if_eq(number).is_none());
    others.filter(|&number| problem.is_called(&all[number], v, 0.0)).collect()
}

/// Goes on from impulses at which Newton's method has stalled, with this residual; returns the residual of the better ones.
fn harder(
    problem: &Problem,
    impulses: &mut [Vector3<f64>],
    mut residual: f64,
    v: &mut Vec<f64>,
    effort: Effort,
    room: &mut Workspace,
) -> f64 {
    residual = proximal_points(problem, impulses, residual, v, effort, room);
    let (tolerance, mut best) = (effort.residual, impulses.to_vec());
    for depth in DEPTHS {
        if residual <= effort.enough {
            break;
        }
        let mut near = impulses.to_vec();
        if interior(problem, &mut near, depth, room) {
            let found = newton(problem, &mut near, v, [tolerance, FINISH], room);
            if found < residual {
                (residual, best) = (found, near);
            }
        }
    }
    if residual > effort.enough {
        rounds(problem, impulses, (&mut residual, &mut best), v, tolerance, room);
    }
    impulses.copy_from_slice(&best);
    problem.velocity(impulses, v);
    residual
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::laws::Law;
    use crate::problem::Given;
    use crate::rows::Rows;
    use crate::trees::Trees;
    use catena_mechanism::description::joint::{Joint, JointKind, Pose};
    use catena_mechanism::description::mechanism::{Body, Mechanism};
    use catena_mechanism::motion::kinematics::body_states;
    use catena_mechanism::motion::state::State;

    #[test]
    fn a_problem_whose_residual_is_not_finite_is_given_up() {
        let joint = Joint::new("slide", JointKind::Prismatic, Pose::identity(), Pose::identity());
        let body = Body { name: "slide".into(), parent: None, mass: 1.0, inertia: Vector3::repeat(1.0), joint };
        let mechanism = Mechanism::new("slide", Vector3::zeros(), vec![body]).expect("a body that moves");
        let mut trees = Trees::new(&mechanism);
        trees.choose(&mechanism, &body_states(&mechanism, &State::zero(&mechanism)));
        let mut rows = Rows::default();
        // A row along which a unit impulse changes a rate by 1e-300 m/s calls for an impulse whose square is beyond all numbers.
        let sides = [Some(rows.of_freedom(0, 1e-150, &trees)), None];
        let bias = Vector3::new(-1.0, 0.0, 0.0);
        let block = Given { sides, law: Law::Interval(0.0, f64::INFINITY), bias, compliance: 0.0 };
        let (members, places) = ([0], [0]);
        let mut problem = Problem::new(&trees, &rows, [&members, &places], &[0.0], [block].into_iter());
        let (mut impulses, mut v) = (vec![Vector3::zeros()], Vec::new());
        let residual = solve(&mut problem, &mut impulses, &mut v, (TOLERANCE, true), &mut Workspace::default());
        assert!(!residual.is_finite(), "{residual:e}");
    }
}
