//! The iteration of one step: when it has converged, when it is hopeless, and when the step is too long.
//!
//! With the increments `δ` of an iteration and the largest displacement `|θ|` so far, in rad and m,
//!
//! ```text
//!     converged:    |δ_n| ≤ ε max(1, |θ|),   or   |δ_n| ≤ 10⁻¹¹ max(1, |θ|)  and  |δ_n| > ½ |δ_{n−1}|      (rounding)
//!     hopeless:     |δ_n| > 0.3 |δ_{n−5}|  after eight iterations
//!     too long:     E > 3 E_tol  after four iterations
//! ```
//!
//! What is iterated is the kernel's: [`super::step`] in space, [`super::planar`] in a plane.

use super::stage::MAX_TURN;
use super::step::{Attempt, StopRule};

/// The stage equations of a step, with a guess.
pub(super) trait Equations {
    /// One iteration from where the last left off: finds the increments, returns the largest. Where they are `settled`, the
    /// rounding of the coefficients counts.
    fn iterate(&mut self, settled: bool) -> f64;
    /// Takes the next iterate; returns the largest displacement.
    fn advance(&mut self) -> f64;
    /// Adds the increments to the displacements, and no more: the iteration has ended.
    fn complete(&mut self);
    /// E of the latest iterate.
    fn legendre(&self) -> f64;
    /// The degree of freedom with the largest increment.
    fn worst_freedom(&self) -> usize;
    /// The first degree of freedom whose rotation has left what the stage poses represent, if any is beyond [`MAX_TURN`].
    fn turned_too_far(&self) -> Option<usize>;
}

/// Iterates from the guess until the equations are solved, or it is clear that they will not be.
pub(super) fn solve(equations: &mut impl Equations, rule: &StopRule) -> Attempt {
    let mut recent = [f64::INFINITY; 5];
    let mut scale = 1.0_f64;
    for iteration in 1..=rule.iterations {
        let previous = recent[(iteration + 3) % 5];
        // The second half of the digits matters where the first is settled.
        let increment = equations.iterate(previous < 1e-13);
        let converged =
            increment <= rule.increment * scale || (increment <= rule.rounding * scale && increment > 0.5 * previous);
        if converged {
            equations.complete();
            // Fixed steps do not ask how accurate they are.
            let legendre = if rule.legendre.is_finite() { equations.legendre() } else { 0.0 };
            return Attempt::Converged { iterations: iteration, legendre };
        }
        // By then the iterate shows the shape of the motion to a digit or two.
        if iteration == 4 && rule.legendre.is_finite() {
            let legendre = equations.legendre();
            if legendre > 3.0 * rule.legendre {
                return Attempt::Inaccurate { iterations: iteration, legendre };
            }
        }
        let hopeless = iteration >= 8 && increment > 0.3 * recent[iteration % 5] && increment > 1e-9 * scale;
        if !increment.is_finite() || hopeless {
            return Attempt::Failed { iterations: iteration, freedom: equations.worst_freedom(), increment };
        }
        recent[(iteration + 4) % 5] = increment;
        let largest = equations.advance();
        scale = largest.max(1.0);
        if largest > MAX_TURN
            && let Some(freedom) = equations.turned_too_far()
        {
            return Attempt::TurnedTooFar { iterations: iteration, freedom };
        }
    }
    let increment = recent[(rule.iterations + 4) % 5];
    Attempt::Failed { iterations: rule.iterations, freedom: equations.worst_freedom(), increment }
}
