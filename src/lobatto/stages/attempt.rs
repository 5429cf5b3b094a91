//! The request for a step and its result: when its iteration ends, its start and guess, and how the attempt ended.

/// Steps iterated further than this use the second half of the coefficients' digits. Coefficients rounded to a double belong to a scheme that is not
/// quite symplectic, and the energy drifts by 2e-16 of itself a step.
pub(crate) const REFINED_BELOW: f64 = 1e-14;

/// When to stop iterating and when to give up.
#[derive(Clone, Copy, Debug)]
pub struct StopRule {
    /// The iteration ends when no joint increment is larger than this (relative to 1 rad or 1 m).
    pub increment: f64,
    /// Increments below this that no longer fall are rounding: the iteration ends.
    pub rounding: f64,
    /// Larger increments end no iteration before they have been seen to fall (relative to 1 rad or 1 m).
    pub unproven: f64,
    /// Largest number of iterations.
    pub iterations: usize,
    /// An attempt whose top Legendre coefficient is well above this is not worth finishing.
    pub legendre: f64,
    /// Whether the first iterates, too, are asked whether that is so.
    pub early: bool,
    /// Whether first iterations may be in single precision ([`crate::solve::single_precision`]).
    pub rough: bool,
    /// Whether the exact Newton method follows where the simplified iteration does not converge.
    pub exactly: bool,
}

impl StopRule {
    /// Iterate to rounding.
    pub const ROUNDING: StopRule = StopRule {
        increment: 2e-16,
        rounding: 1e-11,
        unproven: f64::INFINITY,
        iterations: 60,
        legendre: f64::INFINITY,
        early: false,
        rough: false,
        exactly: true,
    };
}

/// How far the steps of a carried motion are iterated.
#[derive(Clone, Copy, Debug)]
pub struct Carrying {
    /// Distance of the starts (rad, m).
    pub apart: f64,
    /// The part of the distance of the motions that an iteration may leave.
    pub part: f64,
    /// Iterations after which the larger part `rest` suffices.
    pub most: usize,
    /// The larger part that an iteration may leave after `most` iterations.
    pub rest: f64,
    /// Whether the exact Newton method has made the step.
    pub exactly: bool,
    /// The truncation of the step (rad, m), which no iteration sees.
    pub truncation: f64,
}

/// How an attempt at a step ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Attempt {
    /// The stage equations are solved; `legendre` is `E`, the largest top Legendre coefficient of any joint displacement and of any body's rotation
    /// matrix over the step; zero if the rule does not limit it. `exact` if the exact Newton method solved them. `turn` is the largest rotation of a
    /// joint (rad), or zero if all are far from the largest representable one.
    Converged { iterations: usize, legendre: f64, turn: f64, exact: bool },
    /// The iteration was broken off, because the step is too long for the wanted accuracy.
    Inaccurate { iterations: usize, legendre: f64 },
    /// A rotation within the step is too large to be represented.
    TurnedTooFar { iterations: usize, freedom: usize },
    /// No convergence: the iterations spent, the degree of freedom that was worst, and its last increment.
    Failed { iterations: usize, freedom: usize, increment: f64 },
}

impl Attempt {
    /// The same attempt after iterations without result.
    pub fn after(mut self, spent: usize) -> Self {
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

/// The source of a guess.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Guess {
    /// The step before; without one, the velocities alone.
    Past,
    /// The velocities alone.
    Plain,
    /// The last attempt at this step, which was longer; its length (s).
    Longer(f64),
}
