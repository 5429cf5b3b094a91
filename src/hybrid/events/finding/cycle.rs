//! Events that repeat at one instant: one opens a contact that the next closes, and the other way round.
//!
//! An event is decided from the mode and the state alone. If both come back at one instant, up to roundings, all later events would come back as
//! well:
//!
//! ```text
//!     mode, (q, v)  ─event at the start of the step─▶  another mode  ─ … ─▶  the same mode, |Δv| ≤ 1e-12 of the fastest
//! ```
//!
//! This happens if a contact presses by less than the roundings of its force, and its gap closes by less than the roundings of the gap.

use crate::events::modes::mode::Mode;
use crate::mechanism::motion::state::State;

/// Velocities that differ by less than this part of the fastest are the same, and so are positions relative to one metre or radian.
const SAME: f64 = 1e-12;

/// Modes in which steps ended where they began, at one instant.
#[derive(Clone, Debug, Default)]
pub(crate) struct Cycle {
    seen: Vec<(Mode, State)>,
}

impl Cycle {
    /// The instant is another one.
    pub fn leave(&mut self) {
        self.seen.clear();
    }

    /// Takes the mode and the state before an event.
    pub fn see(&mut self, mode: &Mode, state: &State) {
        self.seen.push((mode.clone(), state.clone()));
    }

    /// Whether the mode and the state after it were seen before; `fastest` is the largest velocity of the run [m/s or rad/s].
    pub fn comes_back(&self, mode: &Mode, state: &State, fastest: f64) -> bool {
        let near = |one: &[f64], other: &[f64], most: f64| one.iter().zip(other).all(|(a, b)| (a - b).abs() <= most);
        self.seen.iter().any(|(known, at)| {
            at.time == state.time
                && known.is_like(mode)
                && near(&at.velocity, &state.velocity, SAME * fastest)
                && near(&at.position, &state.position, SAME)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::events::modes::mode::JointMode;

    #[test]
    fn a_mode_comes_back_only_in_the_same_state_at_the_same_instant() {
        let mode = |sliding| Mode {
            joints: vec![JointMode::Free { sliding }],
            motors: Vec::new(),
            contacts: Vec::new(),
            idle: Vec::new(),
            kept: Vec::new(),
            unpressed: Vec::new(),
            seams: Vec::new(),
        };
        let state =
            |time, velocity| State { time, position: vec![0.5], velocity: vec![velocity], compensation: vec![0.0] };
        let mut cycle = Cycle::default();
        assert!(!cycle.comes_back(&mode(1), &state(2.0, 3.0), 4.0), "nothing was seen");
        cycle.see(&mode(1), &state(2.0, 3.0));
        cycle.see(&mode(-1), &state(2.0, 3.0));
        // Roundings of a velocity of 4 are 1e-15.
        assert!(cycle.comes_back(&mode(1), &state(2.0, 3.0 + 1e-15), 4.0));
        assert!(!cycle.comes_back(&mode(0), &state(2.0, 3.0), 4.0), "another mode");
        assert!(!cycle.comes_back(&mode(1), &state(2.0, 3.0 + 1e-9), 4.0), "an impact");
        assert!(!cycle.comes_back(&mode(1), &state(2.0 + 1e-9, 3.0), 4.0), "later");
        cycle.leave();
        assert!(!cycle.comes_back(&mode(1), &state(2.0, 3.0), 4.0), "another instant");
    }
}
