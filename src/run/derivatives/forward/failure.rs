//! The reasons for which a run has no derivatives.

use crate::events::MovingError;

/// Why a run has no derivatives.
#[derive(Debug, thiserror::Error)]
pub enum SensitivityError {
    /// There is no such parameter.
    #[error(
        "there is no parameter {key:?}: give start.q, start.v, start.q.JOINT, start.v.JOINT, effort.JOINT, or a key path of `catena model INPUT --parameters`"
    )]
    Unknown { key: String },
    /// The number cannot vary in both directions.
    #[error("{key}: there is no derivative by it at {value}, because it cannot be {other}: {reason}")]
    Edge { key: String, value: f64, other: f64, reason: String },
    /// No file has a value for the number.
    #[error("{key}: no file says this number; set it with --set or with_params first")]
    NoValue { key: String },
    /// The structure changes with the number.
    #[error(
        "{key}: other values than {value} change the structure of the mechanism, or an ellipsoid, rope or mesh that may touch, so that there is no derivative by it"
    )]
    Structure { key: String, value: f64 },
    /// An event whose function has no derivative here.
    #[error(
        "{what} at t = {time} s: derivatives through this kind of event are not offered; end the run before it, or leave its cause out (--without)"
    )]
    Event { time: f64, what: String },
    /// A function that does not cross zero at an event.
    #[error("{what} at t = {time} s without speed: the time of this event has no derivative; start a little elsewhere")]
    Graze { time: f64, what: String },
    /// An impact that is not the law of impacts at one active set.
    #[error(
        "the impact at t = {time} s has no single active set (a slip without direction, or many impacts in one instant), so that there is no derivative; end the run before it"
    )]
    Impact { time: f64 },
    /// A contact that stays closed.
    #[error(
        "{contact} stay closed from t = {time} s on with features whose derivatives are not known; end the run before it"
    )]
    Closed { time: f64, contact: String },
    /// Ticks that fall together and move apart.
    #[error(
        "ticks of two motors fall together at t = {time} s, and move apart with the period of one: there is no derivative by it; give periods without common ticks, or end the run before"
    )]
    Ticks { time: f64 },
    /// No step of the scheme was made.
    #[error(
        "the run makes steps of first order over many events at t = {time} s, which have no derivative; end the run before it"
    )]
    FirstOrder { time: f64 },
    /// Parts of mechanisms that are not known here.
    #[error("derivatives of runs do not know {part}: {advice}")]
    Unsupported { part: &'static str, advice: &'static str },
    /// A sample outside the run.
    #[error(
        "a sample at t = {time} s is not in the run, which goes from {start} s to {end} s; give times after its start"
    )]
    Sample { time: f64, start: f64, end: f64 },
    /// A sample beside an event of the run at which no repeated step ends.
    #[error("a sample at t = {time} s is beside an event at which no step ends; give a time 1e-6 s or more from it")]
    Beside { time: f64 },
    /// A step was not solved again.
    #[error(
        "the step at t = {time} s could not be solved to rounding again: take fixed steps, shorter ones, with two stages or more, or another --tolerance"
    )]
    Step { time: f64 },
    /// The repeated steps do not end where the run ended.
    #[error(
        "the repeated steps end {apart:.1e} rad or m away from the run: take a finer --tolerance, or fixed steps that converge"
    )]
    Apart { apart: f64 },
    /// The mode of the start cannot be told.
    #[error(transparent)]
    Moving(#[from] MovingError),
}
