//! Newton's method for the problem of an island in the rates of its trees.
//!
//! ```text
//!     F_k + A_k H_k dv + (B_k + (ε/ρ_k) A_k) dr_k = 0          ε = clamp(k residual, 1e-8, 0.1);   laws.rs gives dr_k = −f_k − S_k H_k dv
//!     (M̃ + Σ H_kᵀ S_k H_k) dv = −Σ H_kᵀ f_k                    one LU factorisation an iteration
//! ```
//!
//! ε is a proximal part: without it contacts that stick at places that do not fit together have no bounded impulses. A step is halved until the sum of
//! the squared natural maps is below the largest of the last ones: a sum that has to fall in each step ends where redundant contacts change their states in
//! turn. Because `M̃ dv = Σ H_kᵀ dr_k`, rates and impulses change by the same part of it. If five halvings do not help, ε is ten times as large, up to five
//! times, because redundant contacts pull against each other; then the full step is taken once. The best impulses of all iterations are the answer.
//!
//! A centred problem (`centred.rs`) has u' in the place of u, an ε of its own, and a ρ that is larger by a factor.
//!
//! Source: P. Alart, A. Curnier (1991), as in `laws.rs`; A. M. Castro, F. N. Permenter, X. Han, An unconstrained convex formulation of compliant
//! contact, IEEE Transactions on Robotics 39 (2023) for the sparsity; L. Grippo, F. Lampariello, S. Lucidi, A nonmonotone line search technique for
//! Newton's method, SIAM Journal on Numerical Analysis 23 (1986).

use crate::block_factors::Factors;
use crate::laws::Response;
use crate::problem::{Block, Merit, Problem};
use crate::stall::Stall;
use nalgebra::Vector3;
use std::borrow::Borrow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The proximal part lies between these.
const PROXIMAL: [f64; 2] = [1e-8, 1.0];
/// The merit has to fall to this part of the largest of the last ones at a step that counts as a success.
const FALLS: f64 = 0.9;
const LAST: usize = 40;
/// Iterations in which the least residual has not halved are the last ones.
const STALLED: usize = 30;
const HALVINGS: usize = 5;
/// k grows by this factor after a step without success, this often in a row, and falls by its root after a success.
const FIRMER: f64 = 10.0;
const FIRM: usize = 5;
/// Then full steps without success are taken this often in a row, if the merit grows by this factor at most.
const UNSUCCESSFUL: usize = 1;
const GROWS: f64 = 100.0;

/// A problem that is centred: ε, f and r₀.
#[derive(Clone)]
pub(crate) struct Centre {
    pub proximal: f64,
    pub stiffer: f64,
    pub impulses: Vec<Vector3<f64>>,
}

/// A flag that is set from outside when the result is not wanted any more.
pub type Interrupt = Arc<dyn Borrow<AtomicBool> + Send + Sync>;

/// The blocks of an island that take part, and their numbers and impulses.
#[derive(Clone, Default)]
pub(crate) struct Parts {
    pub part: Vec<usize>,
    pub own: Vec<Vector3<f64>>,
    pub blocks: Vec<Block>,
}

/// Room for the iterations of any island, and their count.
#[derive(Clone, Default)]
pub struct Workspace {
    pub factors: Factors,
    pub iterations: usize,
    /// Once it is set, iterations end, wherever they are.
    pub interrupt: Option<Interrupt>,
    pub(crate) parts: Parts,
    pub(crate) direction: Vec<f64>,
    /// u, and the changes of u and r of a whole step.
    pub(crate) rates: Vec<Vector3<f64>>,
    pub(crate) turned: Vec<Vector3<f64>>,
    changes: Vec<Vector3<f64>>,
    responses: Vec<Response>,
    trial: [Vec<Vector3<f64>>; 2],
    best: Vec<Vector3<f64>>,
    merits: Vec<f64>,
    /// The centre of a centred problem.
    pub(crate) centre: Option<Centre>,
}

impl Workspace {
    /// Whether what is iterated is not wanted any more.
    pub fn is_interrupted(&self) -> bool {
        self.interrupt.as_ref().is_some_and(|flag| (**flag).borrow().load(Ordering::Relaxed))
    }

    /// Takes the rates u, or u', of impulses.
    fn see(&mut self, problem: &Problem, v: &[f64], impulses: &[Vector3<f64>]) -> Merit {
        problem.rates(v, impulses, &mut self.rates);
        let Some(centre) = &self.centre else { return problem.merit(impulses, &self.rates) };
        let parts = impulses.iter().zip(&centre.impulses).zip(&problem.blocks);
        for (rate, ((impulse, middle), block)) in self.rates.iter_mut().zip(parts) {
            *rate += (impulse - middle) * (centre.proximal / block.rho);
        }
        problem.merit_with(impulses, &self.rates, centre.stiffer)
    }
}

/// Iterates on impulses and rates until the residual is below `tolerance`, with a largest number of iterations; returns the residual at the end.
pub fn newton(
    problem: &Problem,
    impulses: &mut [Vector3<f64>],
    v: &mut Vec<f64>,
    [tolerance, most]: [f64; 2],
    room: &mut Workspace,
) -> f64 {
    problem.velocity(impulses, v);
    let mut merit = room.see(problem, v, impulses);
    let mut best = merit.residual;
    room.best.clear();
    room.best.extend_from_slice(impulses);
    room.merits.clear();
    room.merits.push(merit.value);
    let (mut unsuccessful, mut firm) = (0, 1.0_f64);
    let mut stall = Stall::new(merit.residual);
    for _ in 0..most as usize {
        if merit.residual <= tolerance || stall.lasts(STALLED) || room.is_interrupted() {
            break;
        }
        direction(problem, impulses, [firm, merit.residual], room);
        let Workspace { rates, turned, changes, trial: [trial, moved], merits, centre, .. } = room;
        let stiffer = centre.as_ref().map_or(1.0, |centre| centre.stiffer);
        let largest = merits.iter().rev().take(LAST).fold(0.0_f64, |largest, merit| largest.max(*merit));
        let (mut part, mut falls) = (1.0, false);
        let mut found = merit;
        for halving in 0..=HALVINGS {
            // After all halvings the whole step.
            part = if halving == HALVINGS { 1.0 } else { part };
            let along = |from: &[Vector3<f64>], change: &[Vector3<f64>], to: &mut Vec<Vector3<f64>>| {
                to.clear();
                to.extend(from.iter().zip(change).map(|(from, change)| from + change * part));
            };
            along(impulses, changes, trial);
            along(rates, turned, moved);
            found = problem.merit_with(trial, moved, stiffer);
            falls = found.value.is_finite() && found.value < FALLS * largest;
            if falls {
                break;
            }
            part *= 0.5;
        }
        if falls {
            firm = (firm / FIRMER.sqrt()).max(1.0);
        } else if unsuccessful < FIRM {
            (unsuccessful, firm) = (unsuccessful + 1, firm * FIRMER);
            continue;
        }
        if !found.value.is_finite() || (!falls && found.value > GROWS * merit.value) {
            break;
        }
        unsuccessful = if falls { 0 } else { unsuccessful + 1 };
        impulses.copy_from_slice(trial);
        problem.velocity(impulses, v);
        merit = room.see(problem, v, impulses);
        room.merits.push(merit.value);
        stall.see(merit.residual);
        if merit.residual < best {
            best = merit.residual;
            room.best.copy_from_slice(impulses);
        }
        if unsuccessful >= FIRM + UNSUCCESSFUL {
            break;
        }
    }
    if best < merit.residual || merit.residual.is_nan() {
        impulses.copy_from_slice(&room.best);
        problem.velocity(impulses, v);
    }
    // No contact pulls, however little: a part of a step may leave a part of an impulse.
    let mut pulled = false;
    for (impulse, block) in impulses.iter_mut().zip(&problem.blocks) {
        if block.law.pulls(impulse) {
            (*impulse, pulled) = (block.law.project(impulse), true);
        }
    }
    if pulled {
        problem.velocity(impulses, v);
        best = room.see(problem, v, impulses).residual;
    }
    best
}

/// The changes of rates and impulses of a whole step.
fn direction(problem: &Problem, impulses: &[Vector3<f64>], [firm, residual]: [f64; 2], room: &mut Workspace) {
    let Workspace { factors, direction, rates, turned, changes, responses, iterations, centre, .. } = room;
    *iterations += 1;
    direction.clear();
    direction.resize(problem.free.len(), 0.0);
    responses.clear();
    problem.begin_matrix(factors);
    let (proximal, stiffer, compliance) = match centre {
        None => ((firm * residual).clamp(PROXIMAL[0], PROXIMAL[1]), 1.0, 0.0),
        Some(Centre { proximal, stiffer, .. }) => {
            let (proximal, stiffer) = (*proximal, *stiffer);
            let more = if firm > 1.0 { (firm * residual).min(PROXIMAL[1]) } else { 0.0 };
            (stiffer * proximal.max(more), stiffer, proximal)
        }
    };
    for (number, (block, (impulse, rate))) in problem.blocks.iter().zip(impulses.iter().zip(&*rates)).enumerate() {
        let response = block.law.respond(impulse, rate, [stiffer * block.rho, block.compliance, proximal]);
        if response.shift != Vector3::zeros() {
            problem.spread(number, &-response.shift, direction);
        }
        if let Some(slope) = &response.slope {
            problem.add_to_matrix(number, slope, factors);
        }
        responses.push(response);
    }
    factors.factor(&problem.pattern);
    factors.solve(&problem.pattern, direction);
    turned.clear();
    changes.clear();
    for (number, (block, Response { shift, slope })) in problem.blocks.iter().zip(&*responses).enumerate() {
        let mut turn = problem.moved(number, direction);
        let mut change = -shift;
        if let Some(slope) = slope {
            for (entry, row) in change.iter_mut().zip(slope) {
                *entry -= row[0] * turn.x + row[1] * turn.y + row[2] * turn.z;
            }
        }
        turn.x += block.compliance * change.x;
        if compliance > 0.0 {
            turn += change * (compliance / block.rho);
        }
        turned.push(turn);
        changes.push(change);
    }
}
