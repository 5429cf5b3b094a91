//! How far the derivatives of a run with events hold.
//!
//! ```text
//!     two events change their order     |δθ| = |t₂ − t₁| / |∂t₂/∂θ − ∂t₁/∂θ|
//!     an event is missed (grazing)      |δθ| = |φ̇| / (2 |φ̈| |∂t/∂θ|)               φ̈ of gaps at the event, of other functions over its step
//!     impacts at once come apart        |δθ| = 0                                    φ of one has a derivative at the impact of both
//!     a limit is met that was missed    |δθ| = φ / |∂φ/∂θ|                          where a joint turns back before it
//!     a slip starts the other way       |δθ| = |r| / |∂r/∂θ|                        its rate r at the start; zero from rest, and one side is told
//! ```
//!
//! Each is the change of one parameter at which the derivative ends, to first order: a size, no bound. The smallest is told for each parameter. The
//! margins of decisions are not among them: whether a joint that stops sticks, and whether a contact slides in an impact.

use crate::derivatives::forward::tangent::Tangent;
use crate::mechanism::motion::state::State;
use nalgebra::DVector;

/// An event with the derivatives of its time and of the state at it, before it jumps.
#[derive(Clone, Debug)]
pub(crate) struct MetEvent {
    /// s.
    pub time: f64,
    /// The element and its event in words.
    pub what: String,
    /// ∂t/∂θ (p).
    pub by: Vec<f64>,
    /// φ̇ at the event: small for events that graze [unit of the function per s].
    pub rate: f64,
    pub state: State,
    pub tangent: Tangent,
    /// The derivatives of the state by time, before it jumps (n × 1).
    pub along: Tangent,
}

/// The smallest change of each parameter at which the derivative ends.
#[derive(Clone, Debug)]
pub struct Validity {
    /// Infinite if no event bounds it (p).
    pub within: Vec<f64>,
    /// Its cause in words; empty if there is none (p).
    pub causes: Vec<String>,
}

impl Validity {
    /// Of p parameters, before any event.
    pub fn new(parameters: usize) -> Self {
        Validity { within: vec![f64::INFINITY; parameters], causes: vec![String::new(); parameters] }
    }

    fn see(&mut self, parameter: usize, size: f64, cause: impl FnOnce() -> String) {
        if size < self.within[parameter] {
            (self.within[parameter], self.causes[parameter]) = (size, cause());
        }
    }

    /// No change of a parameter at all keeps the derivative.
    pub fn none(&mut self, parameter: usize, cause: &str) {
        self.see(parameter, 0.0, || cause.to_string());
    }

    /// A change of this size ends it.
    pub fn within_of(&mut self, parameter: usize, size: f64, cause: &str) {
        self.see(parameter, size, || cause.to_string());
    }

    /// An event with φ̈, after another event.
    pub(crate) fn see_event(&mut self, event: &MetEvent, second: f64, last: Option<&MetEvent>) {
        for (parameter, by) in event.by.iter().enumerate() {
            if *by != 0.0 {
                let size = event.rate.abs() / (2.0 * second.abs() * by.abs());
                self.see(parameter, size, || format!("{} at {:.6} s is missed", event.what, event.time));
            }
            if let Some(last) = last {
                let apart = (by - last.by[parameter]).abs();
                let cause = || {
                    format!("{} at {:.6} s comes before {} at {:.6} s", event.what, event.time, last.what, last.time)
                };
                self.see(parameter, (event.time - last.time).abs() / apart, cause);
            }
        }
    }

    /// A limit that a joint turns back from, at this distance with these derivatives (p).
    pub fn see_near(&mut self, what: &str, time: f64, gap: f64, by: &DVector<f64>) {
        for (parameter, by) in by.iter().enumerate() {
            self.see(parameter, gap / by.abs(), || format!("{what} near {time:.6} s"));
        }
    }
}
