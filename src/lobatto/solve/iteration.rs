//! The iteration of one step: when it has converged, when it diverges, and when the step is too long.
//!
//! Let `δ` be the increments of an iteration and `|θ|` the largest displacement so far, in rad and m:
//!
//! ```text
//!     converged:    |δ_n| ≤ ε max(1, |θ|),   or   |δ_n| ≤ 10⁻¹¹ max(1, |θ|)  and  |δ_n| > ½ |δ_{n−1}|      (rounding)
//!                   |δ_n|, |δ_{n−1}| ≤ 10⁻⁹ max(1, |θ|)  after fifteen iterations, exact method alone      (beside a singular position)
//!                   and, where something closes, |δ_1| ≤ 10⁻¹³,  |δ_2| ≤ 10⁻¹¹ max(1, |θ|) or |δ_2| ≤ ½ |δ_1|
//!                   and, where contacts slide, no more than 10⁻³, 10⁻² and 10⁻² of how far the slowest of them slides in the step
//!     hopeless:     |δ_n| > 0.3 |δ_{n−4}|  and  |δ_n| > 10⁻⁹ max(1, |θ|)  after eight iterations
//!     too long:     E > 20, 4, 2, 1.5, 1.1 times the largest that is kept, after one, two … five iterations,
//!                   or E > 3 times it after four, where early iterates are not asked:
//!                   E of bodies and joints after the fourth, and of joints, which cost less to ask, after the others
//! ```
//!
//! A hopeless attempt is repeated with a plain guess, and then by the exact Newton method if the rule says so. The equations of an iteration are in
//! the kernel: [`crate::step::kernel`].

use crate::numbers::rotations::EACH;
use crate::stages::attempt::{Attempt, Guess, StopRule};
use crate::stages::pose::{MAX_TURN, Turn};
use catena_mechanism::description::mechanism::Mechanism;

/// The stage equations of a step, with a guess.
pub(crate) trait Equations {
    /// One iteration from where the last left off: finds the increments, returns the largest. If they are `settled`, the rounding of the coefficients
    /// counts.
    fn iterate(&mut self, settled: bool) -> f64;
    /// Whether the second half of the coefficients' digits is used in settled iterations only.
    fn refines(&self) -> bool {
        false
    }
    /// Whether this is the exact method, behind which there is no other.
    fn is_exact(&self) -> bool {
        false
    }
    /// Takes the next iterate; returns the largest displacement.
    fn advance(&mut self) -> f64;
    /// Adds the increments to the displacements, and no more: the iteration has ended.
    fn complete(&mut self);
    /// How far the slowest contact that slides does so in the step (m); infinite without friction.
    fn slowest_slide(&self) -> f64 {
        f64::INFINITY
    }
    /// E of the latest iterate.
    fn legendre(&self) -> f64;
    /// E of its joint displacements alone, which is not larger and may cost less.
    fn joint_legendre(&self) -> f64;
    /// The degree of freedom with the largest increment.
    fn worst_freedom(&self) -> usize;
    /// The joint that has turned furthest; beyond [`MAX_TURN`] the stage poses cannot represent it.
    fn furthest_turn(&self) -> Turn;
}

/// Stage equations that the exact Newton method can solve where the simplified one does not converge.
pub(crate) trait Guarded: Equations {
    /// Takes a guess.
    fn guess(&mut self, guess: Guess);
    /// Forgets earlier iterates.
    fn restart(&mut self);
    /// The exact method, from the guess at hand.
    fn solve_exactly(&mut self, mechanism: &Mechanism, rule: &StopRule) -> Attempt;
    /// For how many more steps the exact method comes first.
    fn exact_for(&mut self) -> &mut usize;
}

/// A kernel whose stage equations the exact Newton method is solving.
pub(crate) trait Coupling: Guarded {
    /// One iteration of the exact method from where the last left off: finds the increments, returns the largest.
    fn couple(&mut self) -> f64;
    /// Adds the increments to the displacements; returns the largest displacement.
    fn add_increments(&mut self) -> f64;
}

/// The exact Newton method.
pub(crate) struct Exact<'k, K>(pub &'k mut K);

impl<K: Coupling> Equations for Exact<'_, K> {
    fn iterate(&mut self, _: bool) -> f64 {
        self.0.couple()
    }

    fn is_exact(&self) -> bool {
        true
    }

    fn advance(&mut self) -> f64 {
        self.0.add_increments()
    }

    fn slowest_slide(&self) -> f64 {
        self.0.slowest_slide()
    }

    fn complete(&mut self) {
        self.0.complete();
    }

    fn legendre(&self) -> f64 {
        self.0.legendre()
    }

    fn joint_legendre(&self) -> f64 {
        self.0.joint_legendre()
    }

    fn worst_freedom(&self) -> usize {
        self.0.worst_freedom()
    }

    fn furthest_turn(&self) -> Turn {
        self.0.furthest_turn()
    }
}

/// Steps of mechanisms with loops are iterated at least this far, so that the gaps are at rounding whatever the tolerance: an iteration leaves gaps
/// of the order of its increment times the one before.
const CLOSED: f64 = 1e-10;
/// The bound for mechanisms with closed contacts: if contacts slide, the method is not quite Newton's, and gaps are of the order of the increment
/// itself.
const TOUCHED: f64 = 1e-12;

/// A mechanism with closures ends its first iteration only at an increment of at most this. The multipliers of a step begin at zero, and the proximal
/// term leaves ε times their increments of the gaps. So the first iteration, from however good a guess, moves away from the closures by as much, and
/// the second moves back.
const UNPROVEN: f64 = 1e-13;
/// The second iteration removes 99 % of that error. So it may end with an increment larger by this factor, or if increments have fallen.
const TAKEN_BACK: f64 = 100.0;

/// The rule by which the exact method stops. Trees use it in unusual steps only, as beside a gimbal lock, and their first iterates may be unusual for
/// that reason.
pub(crate) fn exact_rule(mechanism: &Mechanism, rule: &StopRule) -> StopRule {
    if mechanism.has_closures() {
        let closed = if mechanism.touches.is_empty() { CLOSED } else { TOUCHED };
        StopRule {
            increment: rule.increment.min(closed),
            rounding: rule.rounding.min(CLOSED),
            unproven: UNPROVEN,
            ..*rule
        }
    } else {
        StopRule { early: false, ..*rule }
    }
}

/// Once the exact Newton method was needed, it comes first for this number of steps, because the reason seldom ends at once.
const EXACT_STEPS: usize = 50;

/// For how many steps the exact Newton method comes first from the start of a motion: with closures it always does.
pub(crate) fn exact_at_first(mechanism: &Mechanism) -> usize {
    if mechanism.has_closures() { usize::MAX } else { 0 }
}

/// Beside a singular position the roundings of gaps, 10⁻¹⁶ m, move a mechanism by up to this (rad, m) along directions that the loops hardly
/// determine. Increments of the exact method that stay below this are rounding.
const SLACK: f64 = 1e-9;

/// Number of iterations after which increments count as staying.
const PATIENCE: usize = 15;

/// The direction of friction is known to these parts where increments are of such parts of a slide: of one that falls, and of one that stays.
const OF_SLIDE: f64 = 1e-3;
const OF_SLIDE_STAYING: f64 = 1e-2;
/// Increments need not be below these (rad, m): roundings of positions, and of their products.
const NO_FINER: f64 = 1e-16;
const NO_FINER_STAYING: f64 = 1e-14;

/// A step is too long where E is larger than the largest that is kept by this factor after one, two … iterations: early iterates show the
/// shape of the motion to a factor, later ones to a hundredth.
const TOO_LONG: [f64; 5] = [20.0, 4.0, 2.0, 1.5, 1.1];

/// The same where early iterates are not asked.
const TOO_LONG_LATE: f64 = 3.0;

/// After this iteration the rotations of bodies are looked at, too, and after the others the joints alone.
const SHAPED: usize = 4;

/// After an increment below this (over the largest displacement), the digits that follow belong to the second half.
const SETTLED: f64 = 1e-13;
/// They also do if the next increment is forecast below this: smaller than the last by the factor between the last two.
const ROUNDED: f64 = 1e-15;

/// Up to this displacement no rotation vector is beyond [`MAX_TURN`]. A solution is asked how long it is; an iterate beyond is not, because it is
/// no worse for some digits less.
const ASKED: f64 = EACH * MAX_TURN;

/// Solves the stage equations, with the exact method as the last resort.
pub(crate) fn attempt(equations: &mut impl Guarded, mechanism: &Mechanism, rule: &StopRule, guess: Guess) -> Attempt {
    let mut spent = 0;
    if *equations.exact_for() == 0 {
        equations.guess(guess);
        equations.restart();
        let attempt = solve(equations, rule);
        // The exact method is dear: the other guess comes first.
        if !matches!(attempt, Attempt::Failed { .. }) || guess != Guess::Plain || !rule.exactly {
            return attempt;
        }
        spent = attempt.iterations();
    }
    equations.guess(guess);
    let attempt = equations.solve_exactly(mechanism, rule).after(spent);
    if matches!(attempt, Attempt::Converged { .. }) && !mechanism.has_closures() {
        let steps = equations.exact_for();
        *steps = if spent > 0 { EXACT_STEPS } else { steps.saturating_sub(1) };
    }
    attempt
}

/// Iterates from the guess until the equations are solved, or it is clear that they will not be.
pub(crate) fn solve(equations: &mut impl Equations, rule: &StopRule) -> Attempt {
    let mut recent = [f64::INFINITY; 5];
    let mut scale = 1.0_f64;
    // The error of the guess is unknown.
    let mut largest = f64::INFINITY;
    let refines = equations.refines();
    for iteration in 1..=rule.iterations {
        let previous = recent[(iteration + 3) % 5];
        let earlier = recent[(iteration + 2) % 5];
        // The second half of the coefficients' digits matters once the first half of the solution's digits is settled, or will be after the next
        // increment if it falls as the last one did. A step to rounding never ends without them.
        let settled =
            previous < SETTLED * scale || (earlier.is_finite() && previous * previous < ROUNDED * scale * earlier);
        let increment = equations.iterate(settled);
        let slide = equations.slowest_slide();
        let (falls, stays) = ((OF_SLIDE * slide).max(NO_FINER), (OF_SLIDE_STAYING * slide).max(NO_FINER_STAYING));
        let rounds =
            iteration >= PATIENCE && equations.is_exact() && previous.max(increment) <= SLACK.min(stays) * scale;
        let closed = match iteration {
            1 => increment <= rule.unproven * scale,
            2 => increment <= TAKEN_BACK * rule.unproven * scale || increment <= 0.5 * previous,
            _ => true,
        };
        let converged = (settled || !refines)
            && closed
            && (increment <= rule.increment.min(falls) * scale
                || (increment <= rule.rounding.min(stays) * scale && increment > 0.5 * previous)
                || rounds);
        if converged {
            equations.complete();
            let turn = if largest > ASKED { equations.furthest_turn() } else { Turn::default() };
            if turn.angle > MAX_TURN {
                return Attempt::TurnedTooFar { iterations: iteration, freedom: turn.freedom };
            }
            // Fixed steps do not ask how accurate they are.
            let legendre = if rule.legendre.is_finite() { equations.legendre() } else { 0.0 };
            return Attempt::Converged {
                iterations: iteration,
                legendre,
                turn: turn.angle,
                exact: equations.is_exact(),
            };
        }
        let excess = match iteration {
            _ if rule.legendre == f64::INFINITY => None,
            _ if rule.early => TOO_LONG.get(iteration - 1).copied(),
            SHAPED => Some(TOO_LONG_LATE),
            _ => None,
        };
        if let Some(excess) = excess {
            let legendre = if iteration == SHAPED { equations.legendre() } else { equations.joint_legendre() };
            if legendre > excess * rule.legendre {
                // The next attempt, a shorter one, begins from here.
                equations.complete();
                return Attempt::Inaccurate { iterations: iteration, legendre };
            }
        }
        let hopeless = iteration >= 8 && increment > 0.3 * recent[iteration % 5] && increment > 1e-9 * scale;
        if !increment.is_finite() || hopeless {
            return Attempt::Failed { iterations: iteration, freedom: equations.worst_freedom(), increment };
        }
        recent[(iteration + 4) % 5] = increment;
        largest = equations.advance();
        scale = largest.max(1.0);
        if largest > MAX_TURN {
            let turn = equations.furthest_turn();
            if turn.angle > MAX_TURN {
                return Attempt::TurnedTooFar { iterations: iteration, freedom: turn.freedom };
            }
        }
    }
    let increment = recent[(rule.iterations + 4) % 5];
    Attempt::Failed { iterations: rule.iterations, freedom: equations.worst_freedom(), increment }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Equations whose increments fall to some rounding and stay there.
    struct Rounding {
        floor: f64,
        exact: bool,
        iterations: i32,
    }

    impl Equations for Rounding {
        fn iterate(&mut self, _: bool) -> f64 {
            self.iterations += 1;
            // Never below half of the one before for long, as roundings are.
            self.floor * if self.iterations % 2 == 0 { 1.0 } else { 1.6 } + 0.01_f64.powi(self.iterations)
        }

        fn is_exact(&self) -> bool {
            self.exact
        }

        fn advance(&mut self) -> f64 {
            0.1
        }

        fn complete(&mut self) {}

        fn legendre(&self) -> f64 {
            0.0
        }

        fn joint_legendre(&self) -> f64 {
            0.0
        }

        fn worst_freedom(&self) -> usize {
            7
        }

        fn furthest_turn(&self) -> Turn {
            Turn { angle: 3.0, freedom: 2 }
        }
    }

    #[test]
    fn a_guess_that_needs_no_second_iteration_is_asked_how_far_it_turns() {
        let rule = StopRule { increment: 0.1, ..StopRule::ROUNDING };
        let solved = solve(&mut Rounding { floor: 0.0, exact: false, iterations: 0 }, &rule);
        assert_eq!(solved, Attempt::Converged { iterations: 1, legendre: 0.0, turn: 3.0, exact: false });
    }

    /// Equations with these increments.
    struct Given {
        increments: &'static [f64],
        next: usize,
    }

    impl Equations for Given {
        fn iterate(&mut self, _: bool) -> f64 {
            self.next += 1;
            self.increments[self.next - 1]
        }

        fn advance(&mut self) -> f64 {
            0.1
        }

        fn complete(&mut self) {}

        fn legendre(&self) -> f64 {
            0.0
        }

        fn joint_legendre(&self) -> f64 {
            0.0
        }

        fn worst_freedom(&self) -> usize {
            0
        }

        fn furthest_turn(&self) -> Turn {
            Turn::default()
        }
    }

    #[test]
    fn where_something_closes_no_iteration_is_the_last_before_gaps_have_been_closed() {
        let iterations = |increments: &'static [f64], unproven| {
            let rule = StopRule { increment: 1e-10, rounding: 1e-10, unproven, ..StopRule::ROUNDING };
            solve(&mut Given { increments, next: 0 }, &rule).iterations()
        };
        // Gaps that the proximal term leaves in the first iteration, and that the second closes.
        let back = &[9e-11, 9e-11, 6e-13, 4e-15];
        assert_eq!(iterations(back, UNPROVEN), 3);
        assert_eq!(iterations(back, f64::INFINITY), 1);
        assert_eq!(iterations(&[1e-6, 9e-11, 1e-15], UNPROVEN), 2);
        assert_eq!(iterations(&[9e-12, 9e-12, 6e-14], UNPROVEN), 2);
        assert_eq!(iterations(&[8e-14, 8e-14, 1e-15], UNPROVEN), 1);
    }

    #[test]
    fn roundings_beside_a_singular_position_end_the_exact_method_and_no_other() {
        let solved = |floor, exact| solve(&mut Rounding { floor, exact, iterations: 0 }, &StopRule::ROUNDING);
        assert!(matches!(solved(2e-12, false), Attempt::Converged { iterations: ..=8, .. }));
        assert_eq!(
            solved(2e-11, true),
            Attempt::Converged { iterations: PATIENCE, legendre: 0.0, turn: 0.0, exact: true }
        );
        assert!(matches!(solved(2e-11, false), Attempt::Failed { iterations: 60, freedom: 7, .. }));
        assert!(matches!(solved(2e-9, true), Attempt::Failed { .. }));
    }
}
