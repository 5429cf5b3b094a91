//! The certificate of a step: for each pair that may touch, the stretches of time in which it is known not to overlap, without a hole.
//!
//! ```text
//!     [t₀, t₁] ∪ [t₁, t₂] ∪ … = the step,      on each   φ₁ + φ₂ ≥ V τ,   or the least φ of a stretch shorter than a resolution was searched
//! ```
//!
//! φ is the gap of the pair at the ends of a stretch of length τ (s), V the most by which it can close (m/s). A stretch that is missing is a hole,
//! through which a body could pass unseen. The step is not accepted then.

use std::cell::Cell;

thread_local! {
    /// Whether steps of this thread are also asked at many instants if their certificates are true.
    static CHECKED: Cell<bool> = const { Cell::new(false) };
}

/// Asks every step of this thread from now on at many instants whether its certificates are true, and panics if one is not: for tests.
pub fn check_certificates() {
    CHECKED.set(true);
}

/// Whether it is.
pub(crate) fn are_checked() -> bool {
    CHECKED.get()
}

/// The covered part of a step, from its start on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cover {
    /// Covered up to this time (s).
    pub until: f64,
    /// The least gap that was seen in the covered part (m).
    pub least: f64,
}

impl Cover {
    /// The empty cover of a step from this time on (s).
    pub fn from(start: f64) -> Self {
        Cover { until: start, least: f64::INFINITY }
    }

    /// Takes in a stretch (s), whose least gap (m) is known; one that leaves a hole before it does not count.
    pub fn take(&mut self, [from, to]: [f64; 2], least: f64) {
        if from <= self.until {
            self.until = self.until.max(to);
            self.least = self.least.min(least);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_lies_beyond_a_hole_is_not_covered() {
        let mut cover = Cover::from(1.0);
        cover.take([1.0, 1.5], 0.2);
        cover.take([1.6, 2.0], -0.1);
        assert_eq!(cover, Cover { until: 1.5, least: 0.2 });
        cover.take([1.5, 1.7], 0.1);
        cover.take([1.6, 2.0], 0.3);
        assert_eq!(cover, Cover { until: 2.0, least: 0.1 });
    }
}
