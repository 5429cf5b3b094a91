//! What pairs have in reserve: how far their gaps are from zero, by the looks at steps before.
//!
//! ```text
//!     φ(t₀ + τ) ≥ r,   r = φ(t₁) − Σ V_k h_k − V τ     t₁: when the gap was looked at last; h_k, V_k: the steps since then, and the bounds of their speeds
//! ```
//!
//! A pair whose reserve lasts to the end of a step cannot close in it, and is not looked at: bodies that stand beside each other are looked at seldom,
//! however short the steps are. Reserves belong to one mode, and to a motion without jumps: a state is known by its positions.
//!
//! Source: B. Mirtich, Impulse-based Dynamic Simulation, PhD thesis, Berkeley 1996, chapter 2 (a heap of times before which no pair can collide).

use crate::mechanism::motion::state::State;

/// The reserves of all pairs where the step in question begins, and where it ends.
#[derive(Clone, Debug, Default)]
pub(crate) struct Reserves {
    start: Reserve,
    end: Reserve,
}

/// The reserves at one instant.
#[derive(Clone, Debug, Default)]
struct Reserve {
    /// Whether they are reserves of the present mode.
    known: bool,
    /// Where and when (s).
    position: Vec<f64>,
    time: f64,
    /// One each pair (m); minus infinity where it is not known.
    gaps: Vec<f64>,
}

impl Reserves {
    /// Forgets all: another mode begins.
    pub fn forget(&mut self) {
        self.start.known = false;
        self.end.known = false;
    }

    /// A look at a step from a start to an end begins, for so many pairs; the same step may be looked at again with another end.
    pub fn begin(&mut self, start: &State, end: &State, pairs: usize) {
        if self.end.is_at(start) {
            std::mem::swap(&mut self.start, &mut self.end);
        }
        if !self.start.is_at(start) {
            self.start.take(start, pairs);
        }
        self.end.take(end, pairs);
    }

    /// Whether a pair that closes by no more than `closes` in the step keeps more than `least` of its reserve (m); the rest of it, if it does.
    pub fn lasts(&mut self, pair: usize, closes: f64, least: f64) -> Option<f64> {
        let rest = self.start.gaps[pair] - closes;
        if rest > least {
            self.end.gaps[pair] = rest;
            return Some(rest);
        }
        None
    }

    /// Takes the gap of a pair at the end of the step (m).
    pub fn note(&mut self, pair: usize, gap: f64) {
        self.end.gaps[pair] = gap;
    }
}

impl Reserve {
    fn is_at(&self, state: &State) -> bool {
        self.known && self.time == state.time && self.position == state.position
    }

    fn take(&mut self, state: &State, pairs: usize) {
        self.known = true;
        self.time = state.time;
        self.position.clear();
        self.position.extend_from_slice(&state.position);
        self.gaps.clear();
        self.gaps.resize(pairs, f64::NEG_INFINITY);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(time: f64, position: f64) -> State {
        State { time, position: vec![position], velocity: vec![0.0], compensation: vec![0.0] }
    }

    #[test]
    fn a_reserve_is_used_up_by_the_steps_that_are_made_and_not_by_repeated_looks_at_one() {
        let mut reserves = Reserves::default();
        reserves.begin(&at(0.0, 0.0), &at(1.0, 0.1), 2);
        assert_eq!(reserves.lasts(0, 0.0, 0.0), None);
        reserves.note(0, 1.0);
        // The step is looked at five times with other ends: each time it has what it had at the start.
        for end in [2.0, 1.8, 1.6, 1.4, 1.5] {
            reserves.begin(&at(1.0, 0.1), &at(end, 0.2 * end), 2);
            assert_eq!(reserves.lasts(0, 0.375, 0.0), Some(0.625));
            assert_eq!(reserves.lasts(1, 0.0, 0.0), None);
        }
        // Two steps more: the second one would leave nothing.
        reserves.begin(&at(1.5, 0.2 * 1.5), &at(2.0, 0.5), 2);
        assert_eq!(reserves.lasts(0, 0.375, 0.0), Some(0.25));
        reserves.begin(&at(2.0, 0.5), &at(2.5, 0.6), 2);
        assert_eq!(reserves.lasts(0, 0.25, 0.0), None);
    }

    #[test]
    fn a_reserve_is_not_that_of_a_state_to_which_bodies_were_moved_or_of_another_mode() {
        let mut reserves = Reserves::default();
        reserves.begin(&at(0.0, 0.0), &at(1.0, 0.1), 1);
        reserves.note(0, 1.0);
        let mut moved = reserves.clone();
        moved.begin(&at(1.0, 0.1 + 1e-15), &at(2.0, 0.3), 1);
        assert_eq!(moved.lasts(0, 0.0, 0.0), None);
        let mut later = reserves.clone();
        later.begin(&at(1.5, 0.1), &at(2.0, 0.3), 1);
        assert_eq!(later.lasts(0, 0.0, 0.0), None);
        reserves.forget();
        reserves.begin(&at(1.0, 0.1), &at(2.0, 0.3), 1);
        assert_eq!(reserves.lasts(0, 0.0, 0.0), None);
    }
}
