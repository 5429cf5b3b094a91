//! The bodies at the instants of the last step at which pairs are looked at.
//!
//! All pairs are looked at at the ends of a step, and many in its middle and quarters. To place all bodies for each look of each pair would take the
//! product of pairs and bodies.

use crate::events::modes::instants::Inside;
use crate::mechanism::description::body_state::BodyState;

/// Instants that are kept at most: ends, samples, and halves of halves between them.
const KEPT: usize = 32;

/// Placed bodies at some instants of one step.
#[derive(Clone, Debug, Default)]
pub(crate) struct InsideBodies {
    /// The piece and the number of its step.
    of: Option<(usize, u64)>,
    /// The instants with their bodies; those beyond `count` are room.
    known: Vec<(Inside, Vec<BodyState>)>,
    count: usize,
    /// The place of the next instant once all places are used.
    oldest: usize,
}

impl InsideBodies {
    /// Forgets all: the step is another.
    pub fn forget(&mut self) {
        (self.of, self.count, self.oldest) = (None, 0, 0);
    }

    /// The number of an instant of this step, if its bodies are known.
    pub fn find(&self, of: (usize, u64), instant: Inside) -> Option<usize> {
        let known = || self.known[..self.count].iter().position(|(at, _)| *at == instant);
        if self.of == Some(of) { known() } else { None }
    }

    /// The bodies of an instant by its number.
    pub fn bodies(&self, number: usize) -> &[BodyState] {
        &self.known[number].1
    }

    /// Keeps the bodies of an instant of this step; returns its number. Allocates only until there is room for all.
    pub fn keep(&mut self, of: (usize, u64), instant: Inside, bodies: &[BodyState]) -> usize {
        if self.of != Some(of) {
            self.forget();
            self.of = Some(of);
        }
        let number = if self.count < KEPT { self.count } else { self.oldest };
        if self.count < KEPT {
            self.count += 1;
        } else {
            self.oldest = (self.oldest + 1) % KEPT;
        }
        match self.known.get_mut(number) {
            Some((at, room)) => {
                *at = instant;
                room.clear();
                room.extend_from_slice(bodies);
            }
            None => self.known.push((instant, bodies.to_vec())),
        }
        number
    }
}
