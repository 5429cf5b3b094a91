//! How many stages the steps of a tolerance have.
//!
//! Nine, on every processor. All stages of trees are solved side by side in the lanes of a vector, so that an iteration costs the same with few
//! stages as with a full vector: nine with AVX-512. Two vectors of four lanes do not take twice as long as one either: in a plane arithmetic waits
//! for arithmetic, and in space the first iterations are in single precision, eight lanes at once ([`catena_lobatto::solve::single_precision`]),
//! which five stages do not have. Five stages with coarse tolerances would save time on some trees with AVX2, but truncation is no less than the
//! error of the iteration there, and the companion of a run does not see it: 32 of 1856 runs reported their accuracy as reached wrongly
//! (doc/decisions/002-stages-for-a-tolerance.md).
//!
//! Closed loops have five where their tolerance is not fine: all stages are coupled there, and an iteration with nine costs twice as much. Nine
//! stages make steps so long that Newton's method limits them, not the accuracy. One or two four-bars, which pass singular positions, need much
//! shorter steps with five, and keep nine; and so do springs and dampers so stiff that the stability of the scheme limits the step, which nine stages
//! extend to twice the length: a run sees that in its first steps (`simulation::tolerance::error_estimate`).
//!
//! The table has the time with nine stages over the time with five, at the same tolerance (m), least and most of the scenes of each kind:
//!
//! | | 1e-2 | 1e-3 | 1e-4 | 1e-5 | 1e-6 | 1e-7 | 1e-8 | 1e-9 |
//! |---|---|---|---|---|---|---|---|---|
//! | loops in space, AVX-512 | 1.3–2.2 | 1.2–1.8 | 1.3–2.0 | 1.2–2.1 | 1.2–2.0 | 1.0–1.7 | 0.9–1.4 | |
//! | the same in a plane, six bodies or more | 1.2–1.9 | 1.1–1.6 | 1.1–1.7 | 0.9–1.5 | 0.9–1.5 | 0.7–1.3 | 0.7–1.2 | 0.9–1.0 |
//! | one or two four-bars | 1.0–1.5 | 0.9–1.1 | 0.8–1.0 | 0.7–1.2 | 0.8–1.0 | 0.6–1.1 | 0.5–0.9 | |
//! | coupled by stiff springs or dampers | 0.8–1.0 | 0.9–1.0 | 0.9–1.1 | 0.9 | 0.8–0.9 | 0.9–1.1 | 0.9–1.0 | 0.7–0.8 |
//! | trees, AVX-512 | 0.7–1.4 | 0.8–1.1 | 0.5–1.0 | 0.5–0.9 | 0.5–0.9 | 0.4–0.7 | 0.4–0.8 | 0.3–0.6 |
//! | one body in space, AVX2 | 0.6–1.1 | 0.5–1.0 | 0.4–1.1 | 0.3–1.1 | 0.3–0.9 | 0.2–0.8 | 0.3–0.7 | 0.2 |
//! | two or three, AVX2 | 1.2 | 1.0 | 1.0 | 1.0 | 1.2 | 1.1 | 0.9 | 0.8 |
//! | larger trees in space, AVX2 | 1.0–1.4 | 0.8–1.5 | 0.6–1.4 | 0.6–1.6 | 0.4–1.5 | 0.4–1.6 | 0.4–1.0 | 0.6–0.9 |
//! | trees of three bodies at most in a plane, AVX2 | | 0.6–1.1 | 0.8–1.1 | 0.7–1.1 | 0.6–1.0 | 0.6–0.8 | 0.5–0.7 | |
//! | larger trees in a plane, AVX2 | | 0.9–2.5 | 0.7–2.6 | 0.6–2.0 | 0.5–2.5 | 0.4–1.3 | 0.4–2.6 | 0.3–0.8 |
//! | loops, AVX2 | 1.2–3.6 | 1.4–3.1 | 1.3–3.4 | 1.2–3.3 | 1.1–3.1 | 1.1–2.7 | 0.7–2.4 | |
//!
//! Figures below one in the second row belong to long rows of four-bars, where nine stages end ten times further off; for the same error both take
//! the same time there.

use catena_lobatto::tableau::butcher::Tableau;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::structure::plane::Plane;

/// The finest tolerance at which loops have few stages (m), with a margin for rounding.
const FEW_DOWN_TO: f64 = 0.99e-6;
/// In a plane loops of fewer bodies than these have nine stages.
const SMALLEST_IN_A_PLANE: usize = 6;

/// The choice of the number of stages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StageChoice {
    /// Three, in spans that given instants bound ([`crate::spans`]).
    Fewest,
    /// Five, in such spans.
    Fewer,
    /// Five.
    Few,
    /// Nine.
    Many,
}

impl StageChoice {
    /// The choice for a mechanism and a tolerance (m).
    pub fn of(mechanism: &Mechanism, tolerance: f64) -> Self {
        let bodies = mechanism.bodies.len();
        let in_a_plane = Plane::of(mechanism).is_some();
        if !mechanism.loops.is_empty() && tolerance >= FEW_DOWN_TO && (bodies >= SMALLEST_IN_A_PLANE || !in_a_plane) {
            StageChoice::Few
        } else {
            StageChoice::Many
        }
    }

    /// The number of stages.
    pub fn count(self) -> usize {
        match self {
            StageChoice::Fewest => 3,
            StageChoice::Fewer | StageChoice::Few => 5,
            StageChoice::Many => 9,
        }
    }

    /// The scheme.
    pub fn tableau(self) -> &'static Tableau {
        Tableau::of(self.count()).expect("three, five and nine stages are in range")
    }

    /// `c = E_tol / √ε` of the step control ([`crate::length::control`]). On closed loops Newton's method leaves no error of the iteration, and where
    /// a motion passes singular positions truncation is well above `E²`: with c = 1 four-bars ended up to two tolerances off, with ½ within one, for
    /// the same time. Steps of nine stages are so sensitive that a tenth of a step is a decade of E². So a small c is cheap, and leaves truncation
    /// well below the error of the iteration (chain of ten links: of 68 runs two end more than ten tolerances off, with c = 0.3 eight).
    pub(crate) fn wanted_share(self) -> f64 {
        match self {
            // No companion sees the truncation of such spans. It is less than E²/100 in each (a landing quadruped: E²/800), so that ten
            // thousand of them leave 3 % of the tolerance. That of five stages is smaller still for the same E.
            StageChoice::Fewest | StageChoice::Fewer => 0.34,
            StageChoice::Few => 0.5,
            StageChoice::Many => 0.03,
        }
    }
}
