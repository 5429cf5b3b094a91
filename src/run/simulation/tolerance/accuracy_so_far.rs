//! The accuracy of a run up to the present step.

use crate::mechanism::motion::integrator::Integrator;
use crate::mechanism::motion::state::State;

/// The accuracy of a run up to an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AccuracySoFar {
    /// That instant (s).
    pub time: f64,
    /// The tolerance of positions (m).
    pub wanted: f64,
    /// The largest estimated error up to that instant (m). It is infinite after a chaotic motion has amplified rounding errors to the size of the
    /// mechanism, because no estimate is possible then.
    pub estimate: f64,
    /// The last instant up to which the estimated error meets the tolerance (s); `time` as long as it does.
    pub holds_until: f64,
}

impl AccuracySoFar {
    /// Whether the estimated error still meets the tolerance.
    pub fn holds(&self) -> bool {
        self.holds_until >= self.time
    }

    /// Combines the accuracies of the islands of a run; `None` without islands.
    pub(crate) fn together(parts: impl Iterator<Item = AccuracySoFar>) -> Option<Self> {
        parts.reduce(|one, other| AccuracySoFar {
            // An island that exceeds the tolerance may not be estimated any more.
            time: match (one.holds(), other.holds()) {
                (true, true) => one.time.min(other.time),
                _ => one.time.max(other.time),
            },
            wanted: one.wanted,
            estimate: one.estimate.max(other.estimate),
            holds_until: one.holds_until.min(other.holds_until),
        })
    }
}

/// An integrator that may tell its accuracy during a run.
pub(crate) trait Tells {
    /// The accuracy so far, if it is known.
    fn so_far(&self) -> Option<AccuracySoFar> {
        None
    }

    /// A bound of the overlap of shapes in the steps so far (m), where it is known.
    fn overlap(&self) -> f64 {
        0.0
    }

    /// Whether forces inside their cones are known to hold all closed contacts in the state at the end of the last step.
    fn holds_all(&self, _state: &State) -> bool {
        false
    }
}

impl Tells for dyn Integrator + '_ {}

#[cfg(test)]
mod tests {
    use super::*;

    const CALM: AccuracySoFar = AccuracySoFar { time: 2.0, wanted: 1e-6, estimate: 1e-9, holds_until: 2.0 };

    #[test]
    fn parts_together_hold_as_long_as_the_first_of_them_that_does_not() {
        let lost = AccuracySoFar { time: 1.5, estimate: f64::INFINITY, holds_until: 1.25, ..CALM };
        let together = AccuracySoFar::together([CALM, lost].into_iter()).expect("parts");
        assert_eq!(together, AccuracySoFar { time: 2.0, ..lost });
        assert!(CALM.holds() && !together.holds());
    }

    #[test]
    fn parts_that_hold_are_told_together_up_to_the_first_of_them() {
        let behind = AccuracySoFar { time: 1.5, estimate: 1e-8, holds_until: 1.5, ..CALM };
        assert_eq!(AccuracySoFar::together([CALM, behind].into_iter()), Some(behind));
        assert_eq!(AccuracySoFar::together(std::iter::empty()), None);
    }
}
