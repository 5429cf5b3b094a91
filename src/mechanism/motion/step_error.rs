//! The reasons why a step fails.

use crate::ground::words::short;

/// Why a step could not be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StepError {
    /// The stage equations could not be solved, even after the step was shortened again and again.
    #[error(
        "at t = {} s the step from joint {joint:?} did not converge (last increment {increment:.1e}), not even with \
         a step of {step:.1e} s; choose a smaller --tolerance, or with --step a smaller one or more --stages",
        short(*.time)
    )]
    NotConverged { time: f64, step: f64, joint: String, increment: f64 },
    /// The stage equations could not be solved, and the step was beyond the limit of stability of the scheme.
    #[error(
        "at t = {} s a step of {step:.1e} s is beyond the stability limit of {stages} stages and does not converge; use \
         --step below {longest:.1e} s, more --stages, or --tolerance",
        short(*.time)
    )]
    Unstable { time: f64, step: f64, stages: usize, longest: f64 },
    /// A joint turns by more than half a revolution within the shortest step.
    #[error(
        "at t = {} s joint {joint:?} turns by more than half a revolution within a step of {step:.1e} s; choose a smaller --step, or --tolerance",
        short(*.time)
    )]
    TurnedTooFar { time: f64, step: f64, joint: String },
    /// Every step, however short, changes the energy by more than the tolerance allows, or to the energy of another motion.
    #[error(
        "at t = {} s no step is accurate enough, not even {step:.1e} s; choose a larger --tolerance, or with --step more --stages",
        short(*.time)
    )]
    NotAccurate { time: f64, step: f64 },
    /// The state is not finite any more.
    #[error(
        "at t = {} s the velocity of joint {joint:?} is not finite after a step of {step:.1e} s: the motion is too violent for it, or starts with more than doubles hold",
        short(*.time)
    )]
    NotFinite { time: f64, step: f64, joint: String },
    /// A controller that follows the state gives an effort that is no number.
    #[error("at t = {} s the controller's effort along joint {joint:?} is {effort}: make it finite in every state", short(*.time))]
    Effort { time: f64, joint: String, effort: f64 },
    /// A joint is outside its limits where the motion begins.
    #[error(
        "at t = {} s joint {joint:?} is {by:.3e} rad or m outside its limits; start within them, or run --without limits",
        short(*.time)
    )]
    OutsideLimit { time: f64, joint: String, by: f64 },
    /// A joint that is moved in time presses on a limit or an obstacle, and nothing can give way.
    #[error(
        "at t = {} s nothing can give way any more: {moved} presses on, and {between} cannot move apart; change the motion so that it ends before, or \
         drive the joint by a [[motor]] with max_effort instead",
        short(*.time)
    )]
    Blocked { time: f64, moved: String, between: String },
    /// The steps are of a kind that knows gravity alone, and now something else acts.
    #[error(
        "at t = {} s forces or efforts act, and {method} are for trees of joints under gravity alone; choose --tolerance, or --stages and --step alone",
        short(*.time)
    )]
    NotPlain { time: f64, method: &'static str },
}
