//! What a step is to those who string steps together: when its iteration ends, how an attempt at it ended, and what can be asked
//! of it. In space it is made by [`super::kernel`], in a plane by [`super::planar`].

use super::lanes::{Lanes, in_lanes};
use super::predictor::Guess;
use super::reversible::Pace;
use super::watch::{Mode, Transient};
use crate::forces::total::Exchange;
use crate::invariants::Energy;
use crate::model::Mechanism;
use crate::state::State;

/// Steps iterated further than this use the coefficients' second half of digits: rounded to a double they are
/// those of a scheme that is not quite symplectic, and the energy drifts by 2e-16 of itself a step.
pub(super) const REFINED_BELOW: f64 = 1e-14;

/// When to stop iterating and when to give up.
#[derive(Clone, Copy, Debug)]
pub struct StopRule {
    /// The iteration ends when no joint increment is larger than this (relative to 1 rad or 1 m).
    pub increment: f64,
    /// Increments below this that no longer fall are rounding: the iteration ends.
    pub rounding: f64,
    /// Largest number of iterations.
    pub iterations: usize,
    /// An attempt whose top Legendre coefficient is well above this is not worth finishing.
    pub legendre: f64,
    /// Whether the first iterates, too, are asked whether that is so.
    pub early: bool,
    /// Whether first iterations may be in single precision ([`super::first`]).
    pub rough: bool,
    /// Whether the exact Newton method follows where the simplified iteration does not converge.
    pub exactly: bool,
}

impl StopRule {
    /// Iterate to rounding.
    pub const ROUNDING: StopRule = StopRule {
        increment: 2e-16,
        rounding: 1e-11,
        iterations: 60,
        legendre: f64::INFINITY,
        early: false,
        rough: false,
        exactly: true,
    };
}

/// How an attempt at a step ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Attempt {
    /// The stage equations are solved; `legendre` is `E`, the largest top Legendre coefficient of any joint displacement
    /// and of any body's rotation matrix over the step; zero if the rule does not limit it.
    /// `exact` if it was the exact Newton method that solved them.
    /// `turn` is the largest rotation of a joint (rad), or zero if none is near what can be represented.
    Converged { iterations: usize, legendre: f64, turn: f64, exact: bool },
    /// The iteration was broken off, because the step is too long for the wanted accuracy.
    Inaccurate { iterations: usize, legendre: f64 },
    /// A rotation within the step is too large to be represented.
    TurnedTooFar { iterations: usize, freedom: usize },
    /// No convergence: the iterations spent, the degree of freedom that was worst, and its last increment.
    Failed { iterations: usize, freedom: usize, increment: f64 },
}

impl Attempt {
    /// The same attempt after iterations that led nowhere.
    pub(super) fn after(mut self, spent: usize) -> Self {
        match &mut self {
            Attempt::Converged { iterations, .. }
            | Attempt::Inaccurate { iterations, .. }
            | Attempt::TurnedTooFar { iterations, .. }
            | Attempt::Failed { iterations, .. } => *iterations += spent,
        }
        self
    }

    /// The iterations spent.
    pub fn iterations(&self) -> usize {
        match *self {
            Attempt::Converged { iterations, .. }
            | Attempt::Inaccurate { iterations, .. }
            | Attempt::TurnedTooFar { iterations, .. }
            | Attempt::Failed { iterations, .. } => iterations,
        }
    }
}

/// A step of the scheme for one number of lanes; what the integrator sees of it.
pub trait Step: Send {
    /// Steps iterated as far as `stop` (rad, m) are to come: makes room for what only they need.
    fn expect(&mut self, _mechanism: &Mechanism, _stop: f64) {}
    /// Takes a state as the start of the next step, when it is not where the last step ended.
    fn begin(&mut self, mechanism: &Mechanism, state: &State);
    /// Energy at the start of the step.
    fn energy(&self) -> Energy;
    /// Whether there is a step before this one to guess from: without, every guess is a plain one.
    fn has_past(&self) -> bool;
    /// Solves the stage equations of a step of length `step` from the start and a guess.
    fn attempt(&mut self, mechanism: &Mechanism, step: f64, rule: &StopRule, guess: Guess) -> Attempt;
    /// Projects the momentum at the end of the solved step (2.5.11h): moves `state` there; returns its energy.
    fn finish(&mut self, mechanism: &Mechanism, state: &mut State) -> Energy;
    /// Energy dissipated in the finished step, and work put into it, by the quadrature of the scheme (J).
    fn exchange(&self) -> Exchange;
    /// How many iterations have kept the factors of an earlier one since this was asked last.
    fn take_kept(&mut self) -> usize;
    /// Number of equations of the closures that the others imply at the end of the finished step; `None` without closures, and where
    /// nothing had to be projected there.
    fn redundant(&self) -> Option<usize>;
    /// Brings positions and velocities near the closures, if there are any, on them.
    fn close(&mut self, mechanism: &Mechanism, position: &mut [f64], velocity: &mut [f64]);
    /// Keeps the finished step: its end is the start of the next one.
    fn accept(&mut self);
    /// Of each degree of freedom two weighted sums of its displacements at the stages 2 … s of the last solved step.
    fn weigh_displacements(&self, weights: [&[f64]; 2], sums: &mut [[f64; 2]]);
    /// Displacement of a degree of freedom at the last stage of the last solved step.
    fn last_displacement(&self, freedom: usize) -> f64;
    /// The fastest mode at `state`, the start of the step, from some power iterations.
    fn fastest_mode(&mut self, mechanism: &Mechanism, state: &State, iterations: usize) -> Mode;
    /// What dampers are about to stop at `state`, the start of the step, if there is any to speak of.
    fn transient(&mut self, mechanism: &Mechanism, state: &State) -> Option<Transient>;
    /// Pace of the motion at `state`, the start of the step; `None` where forces and loops play a part that it does not know.
    fn pace(&mut self, mechanism: &Mechanism, state: &State) -> Option<Pace>;
    /// Rough second derivatives of the displacements at the start, from one iteration of a step of this length (s). Zero for the freedoms that
    /// need no iteration ([`Plan::known`](super::plan::Plan::known)): no step is shorter for these.
    fn accelerations(&mut self, step: f64, out: &mut [f64]);
}

/// E of the displacements alone: their largest top Legendre coefficient, of which `top` has the weights of the stages.
#[inline(always)]
pub(super) fn largest_coefficient<V: Lanes>(displacements: &[V], top: V) -> f64 {
    let mut largest = 0.0_f64;
    for displacement in displacements {
        largest = larger(largest, (*displacement * top).sum().abs());
    }
    largest
}

/// The larger of a number and another, which may be a NaN and then is not: `f64::max` asks whether the first is one, too.
#[inline(always)]
pub(super) fn larger(number: f64, other: f64) -> f64 {
    if other > number { other } else { number }
}

/// The degree of freedom with the largest increment; a NaN counts as largest.
pub(super) fn worst_freedom<V: Lanes>(increments: &[V]) -> usize {
    let size = |freedom: usize| increments[freedom].max_abs(V::zero()).largest();
    (0..increments.len()).max_by(|&a, &b| size(a).total_cmp(&size(b))).unwrap_or(0)
}

/// Values at the end of the step.
pub(super) fn write_ends<V: Lanes>(values: &[V], active: usize, ends: &mut [f64]) {
    in_lanes!(V, {
        for (end, &value) in ends.iter_mut().zip(values) {
            *end = at_end(value, active);
        }
    });
}

/// A value at the end of the step: the last of the `active` lanes.
#[inline(always)]
pub(super) fn at_end<V: Lanes>(value: V, active: usize) -> f64 {
    value.to_array().as_ref()[active - 1]
}

/// Two weighted sums over the stages for each degree of freedom.
pub(super) fn weigh<V: Lanes>(displacements: &[V], weights: [&[f64]; 2], sums: &mut [[f64; 2]]) {
    let weights = weights.map(V::from_slice);
    in_lanes!(V, {
        for (sums, &displacement) in sums.iter_mut().zip(displacements) {
            *sums = [(displacement * weights[0]).sum(), (displacement * weights[1]).sum()];
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lobatto::lanes::Portable;

    #[test]
    fn the_worst_freedom_is_the_one_that_is_no_number_or_else_the_largest() {
        let worst = |values: &[f64]| {
            let increments: Vec<Portable<4>> =
                values.iter().map(|&value| Portable::from_slice(&[0.0, value])).collect();
            worst_freedom(&increments)
        };
        assert_eq!(worst(&[1.0, -3.0, 2.0]), 1);
        for (values, at) in [([f64::NAN, 1.0, 2.0], 0), ([1.0, f64::NAN, 2.0], 1), ([1.0, 2.0, -f64::NAN], 2)] {
            assert_eq!(worst(&values), at);
        }
    }
}
