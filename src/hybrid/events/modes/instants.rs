//! States inside the last step of a piece, kept by their times.
//!
//! Every watched function is looked at at the same samples of a step. On closed contacts each state of the dense output is a projection on the
//! closures, which takes longer than all evaluations in it.

/// States that are kept at most: the samples of a step, and the states in which one root is looked for.
const KEPT: usize = 32;

/// An instant of the last step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Inside {
    /// s.
    pub time: f64,
    /// Whether the state is as interpolated, so that closures are off by as much as interpolation errs. Bringing it on them takes ten times as long.
    pub roughly: bool,
}

impl Inside {
    /// An instant with a state on all closures.
    pub fn at(time: f64) -> Self {
        Inside { time, roughly: false }
    }

    /// An instant with a state as interpolated.
    pub fn roughly(time: f64) -> Self {
        Inside { time, roughly: true }
    }
}

/// The evaluated functions of the sample of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Evaluated {
    /// The instant, and the number of the attempt at the step; `None` if it is not evaluated.
    pub at: Option<(Inside, u64)>,
    /// Whether the bodies are placed there.
    pub bodies: bool,
    /// Whether the forces belong to this instant.
    pub efforts: bool,
    /// Whether the margin belongs to this instant.
    pub margin: bool,
}

/// Positions and velocities at some times of one step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Instants {
    times: Vec<f64>,
    /// One state after the other.
    positions: Vec<f64>,
    velocities: Vec<f64>,
    /// Place of the next state once all places are used.
    oldest: usize,
    /// Number of steps so far, repeated attempts included.
    makings: u64,
}

impl Instants {
    /// Forgets all: the step is another.
    pub fn forget(&mut self) {
        self.times.clear();
        self.positions.clear();
        self.velocities.clear();
        self.oldest = 0;
        self.makings += 1;
    }

    /// A number that is another one after each step, and each time that one is made again.
    pub fn makings(&self) -> u64 {
        self.makings
    }

    /// Writes the state at a time (s), if it is known.
    pub fn recall(&self, time: f64, position: &mut [f64], velocity: &mut [f64]) -> bool {
        let Some(index) = self.times.iter().position(|known| *known == time) else { return false };
        let (positions, velocities) = (position.len(), velocity.len());
        position.copy_from_slice(&self.positions[index * positions..][..positions]);
        velocity.copy_from_slice(&self.velocities[index * velocities..][..velocities]);
        true
    }

    /// Keeps a state; the oldest makes room. Allocates only until there is room for all.
    pub fn keep(&mut self, time: f64, position: &[f64], velocity: &[f64]) {
        if self.times.len() < KEPT {
            self.times.push(time);
            self.positions.extend_from_slice(position);
            self.velocities.extend_from_slice(velocity);
            return;
        }
        let index = self.oldest;
        self.times[index] = time;
        self.positions[index * position.len()..][..position.len()].copy_from_slice(position);
        self.velocities[index * velocity.len()..][..velocity.len()].copy_from_slice(velocity);
        self.oldest = (index + 1) % KEPT;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_latest_states_are_known_and_none_of_another_step() {
        let mut instants = Instants::default();
        let (mut position, mut velocity) = ([0.0; 2], [0.0; 1]);
        let state = |time: f64| ([time, 2.0 * time], [-time]);
        for count in 0..3 * KEPT {
            let time = count as f64;
            let (q, v) = state(time);
            assert!(!instants.recall(time, &mut position, &mut velocity));
            instants.keep(time, &q, &v);
            for known in count.saturating_sub(KEPT - 1)..=count {
                assert!(instants.recall(known as f64, &mut position, &mut velocity), "{known} of {count}");
                assert_eq!((position, velocity), state(known as f64));
            }
        }
        instants.forget();
        assert!((0..3 * KEPT).all(|time| !instants.recall(time as f64, &mut position, &mut velocity)));
        instants.keep(7.0, &[7.0, 14.0], &[-7.0]);
        assert!(instants.recall(7.0, &mut position, &mut velocity));
        assert_eq!((position, velocity), state(7.0));
    }
}
