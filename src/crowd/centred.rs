//! Proximal points: problems with a compliance around the last impulses, each solved by Newton's method, which lead to the impulses of the problem itself.
//!
//! ```text
//!     u' = u + (ε/ρ)(r − r₀),    K ∋ r ⊥ u' + μ|u'_T| n ∈ K*,    r₀ ← r        until the natural map of u is small
//! ```
//!
//! Contacts that hold at places which do not fit together have impulses of any size without changing a rate: in Newton's method alone they leap along such
//! directions, and a contact that slips by 1e-8 of the other rates turns by any angle. The compliance bounds both, and its error vanishes at the fixed point.
//! ε falls after a problem that took few iterations, and grows after one that failed. The equations take ρ larger by a factor, `y = r − f ρ u'`: the slip
//! decides the direction of friction there, and not the friction of the last iteration. Problems that fail are tried with another factor first.
//!
//! Source: R. T. Rockafellar, Monotone operators and the proximal point algorithm, SIAM Journal on Control and Optimization 14 (1976); P. Alart, A. Curnier
//! (1991) for the freedom in ρ.

use crate::effort::Effort;
use crate::newton::{Centre, Workspace, newton};
use crate::problem::Problem;
use nalgebra::Vector3;

/// The first ε, and the factor by which it changes.
const FIRST: f64 = 1e-3;
const LESS: f64 = 0.3;
const BOUNDS: [f64; 2] = [1e-9, 1.0];
/// f, one after the other.
const STIFFER: [f64; 2] = [1e4, 1e2];
/// The residual of a centred problem as a part of the last residual of the problem itself and of its tolerance.
const INNER: [f64; 2] = [0.01, 0.1];
/// Most iterations of one centred problem, and of quick ones.
const MOST: f64 = 40.0;
const QUICK: usize = 8;
/// Most iterations of all: this number of rates, within bounds.
const RATES: usize = 100_000;
const ALL: [usize; 2] = [150, 1000];
/// The most failures in a row with each f.
const FAILURES: usize = 3;

/// Goes on from impulses with a residual, to better ones if there are any; returns their residual.
pub(crate) fn proximal_points(
    problem: &Problem,
    impulses: &mut [Vector3<f64>],
    mut residual: f64,
    v: &mut Vec<f64>,
    effort: Effort,
    room: &mut Workspace,
) -> f64 {
    let first = room.iterations;
    let most = (RATES / problem.free.len().max(1)).clamp(ALL[0], ALL[1]);
    let (mut here, mut last) = (impulses.to_vec(), residual);
    let (mut proximal, mut failed) = (FIRST, 0);
    let mut rates = Vec::new();
    let tolerance = effort.residual;
    let (mut halved, mut since) = (residual, first);
    // Problems that take no iteration, as where the residual is not finite, are work, too.
    let mut idle = 0;
    while residual > tolerance && room.iterations - first + idle < most && failed < FAILURES * STIFFER.len() {
        let stiffer = STIFFER[failed % STIFFER.len()];
        room.centre = Some(Centre { proximal, stiffer, impulses: here.clone() });
        let (mut near, before) = (here.clone(), room.iterations);
        let within = (INNER[0] * last).max(INNER[1] * tolerance);
        let inner = newton(problem, &mut near, v, [within, MOST], room);
        room.centre = None;
        idle += usize::from(room.iterations == before);
        problem.rates(v, &near, &mut rates);
        let found = problem.merit(&near, &rates).residual;
        if found < residual {
            residual = found;
            impulses.copy_from_slice(&near);
        }
        if residual < 0.5 * halved {
            (halved, since) = (residual, room.iterations);
        }
        if room.iterations - since > effort.patience || room.is_interrupted() {
            break;
        }
        if inner <= within {
            (here, last, failed) = (near, found, 0);
            if room.iterations - before <= QUICK {
                proximal = (proximal * LESS).max(BOUNDS[0]);
            }
            continue;
        }
        failed += 1;
        if failed % STIFFER.len() == 0 {
            proximal = (proximal / LESS).min(BOUNDS[1]);
        }
        if found < last {
            (here, last) = (near, found);
        }
    }
    residual
}
