//! The horizon of a motion with events: the time from which runs that differ by roundings meet other events. No steps carry a run beyond it.
//!
//! Distances of runs grow, and a finer stop postpones the instant at which they part:
//!
//! ```text
//!     gained so far:    G = ln(ε₁/ε₂)/Λ = t₂ − t₁        two beginnings with stops ε₁ > ε₂ that met other events than their companions at t₁ and t₂
//!     or by its looks:  Λ = ln(e₂/e₁)/(t₂ − t₁)          e: distances of the run from its companion at the last two looks (m)
//!     the finest stop:  t* − t = ln(ε/ε_f)/Λ             what one more beginning gains (s), ε_f: the stop at rounding
//! ```
//!
//! A beginning that gains less than an eighth of the run is not made: it costs as much as the run so far.

use crate::simulation::tolerance::forecast::FINEST;

/// A beginning is worth its time if it carries the accuracy on by this part of the run.
const WORTH: f64 = 1.0 / 8.0;
/// Distances that grow by less than this factor between two looks do not show how fast they grow.
const GROWS: f64 = 10.0;

/// The horizon of a run, as far as it is known from all its beginnings.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Horizon {
    /// The time at which an earlier beginning met other events than its companion (s), and its stop.
    before: Option<(f64, f64)>,
    /// The time (s) and the distance (m) of the last two looks of this beginning.
    looks: [Option<(f64, f64)>; 2],
}

impl Horizon {
    /// Takes the distance of the run from its companion at a time (s), or a distance from which on they have parted (m).
    pub fn see(&mut self, time: f64, apart: f64) {
        self.looks = [self.looks[1], Some((time, apart))];
    }

    /// Another beginning follows one that met other events than its companion at a time (s) with this stop.
    pub fn begin_again(&mut self, differ: Option<(f64, f64)>) {
        *self = Horizon { before: differ, looks: [None; 2] };
    }

    /// Whether a finer run is worth its time, for a run of this duration (s) that met other events than its companion at `differ` (s).
    pub fn is_worth(&self, differ: f64, stop: f64, duration: f64) -> bool {
        let finer = (stop / FINEST).max(1.0).ln();
        let gains = match (self.before, self.looks) {
            (Some((time, coarser)), _) if coarser > stop => (differ - time).max(0.0) * finer / (coarser / stop).ln(),
            (_, [Some((from, near)), Some((to, far))]) if near > 0.0 && far >= GROWS * near && to > from => {
                finer * (to - from) / (far / near).ln()
            }
            _ => f64::INFINITY,
        };
        gains >= WORTH * duration
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_beginning_that_gains_as_little_as_the_one_before_is_not_made() {
        // Stops of 1e-5 and 1e-9 parted at 0.294 s and 0.296 s: seven more decades gain 3.5 ms of 1 s.
        let mut horizon = Horizon::default();
        assert!(horizon.is_worth(0.294, 1e-5, 1.0), "unknown");
        horizon.begin_again(Some((0.294, 1e-5)));
        assert!(!horizon.is_worth(0.296, 1e-9, 1.0));
        // Four decades have gained 0.2 s: seven gain 0.35 s.
        assert!(horizon.is_worth(0.494, 1e-9, 1.0));
        // 0.07 s: seven gain 0.1225 s, and 0.08 s gain 0.14 s.
        assert!(!horizon.is_worth(0.364, 1e-9, 1.0));
        assert!(horizon.is_worth(0.374, 1e-9, 1.0));
        // One that has not met other events is no measure.
        horizon.begin_again(None);
        assert!(horizon.is_worth(0.296, 1e-9, 1.0));
    }

    #[test]
    fn distances_that_grow_tenfold_in_a_millisecond_show_that_no_stop_gains_an_eighth_of_a_second() {
        let mut horizon = Horizon::default();
        horizon.see(0.1, 1e-7);
        assert!(horizon.is_worth(0.2, 1e-5, 1.0), "one look");
        horizon.see(0.101, 1e-6);
        // Eleven decades are 11 ms.
        assert!(!horizon.is_worth(0.2, 1e-5, 1.0));
        assert!(horizon.is_worth(0.2, 1e-5, 0.08));
        // As much in a second.
        horizon.see(1.101, 1e-5);
        assert!(horizon.is_worth(1.2, 1e-5, 10.0));
        // They do not grow.
        horizon.see(1.102, 2e-5);
        assert!(horizon.is_worth(1.2, 1e-5, 10.0));
    }
}
