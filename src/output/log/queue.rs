//! What a run has shown, on its way to the thread that makes messages of it: numbers as they are, in their order.

use crate::lobatto::instants::snapshot::INSTANTS;

/// Bytes of a piece that is large.
const LARGE: usize = 1 << 16;

/// Bytes of one that is too large.
const TOO_LARGE: usize = 1 << 19;

/// Samples, and what is logged between them.
#[derive(Default)]
pub(crate) struct Piece {
    /// Times of the samples (s), their positions and their velocities, one after the other.
    pub times: Vec<f64>,
    pub positions: Vec<f64>,
    pub velocities: Vec<f64>,
    /// What comes before the sample of this number, or after the last.
    pub between: Vec<(usize, Between)>,
}

/// What is logged between samples.
pub(crate) enum Between {
    /// The figures of a step, at a time in nanoseconds.
    Figures(u64, Figures),
    /// A line of `/log`, encoded.
    Line(u64, Vec<u8>),
}

/// The numbers of `/energy`, `/constraint` and `/solver`.
pub(crate) struct Figures {
    pub energies: [f64; 5],
    pub violation: [f64; 2],
    pub work: [f64; 5],
}

impl Piece {
    /// Adds a sample.
    pub(crate) fn push(&mut self, time: f64, position: &[f64], velocity: &[f64]) {
        self.times.push(time);
        self.positions.extend_from_slice(position);
        self.velocities.extend_from_slice(velocity);
    }

    /// Adds what comes before the next sample.
    pub(crate) fn push_between(&mut self, what: Between) {
        self.between.push((self.times.len(), what));
    }

    /// Whether it is worth while to take it.
    pub(crate) fn is_large(&self) -> bool {
        self.size() >= LARGE && self.times.len() >= INSTANTS
    }

    /// Whether nothing more should be added before it is taken. The messages of an arm are twenty times as large.
    pub(crate) fn is_too_large(&self) -> bool {
        self.size() > TOO_LARGE && self.times.len() > 4 * INSTANTS
    }

    /// Size of the numbers in bytes; figures are few.
    fn size(&self) -> usize {
        8 * (self.times.len() + self.positions.len() + self.velocities.len())
    }

    /// Forgets everything and keeps the memory.
    pub(crate) fn clear(&mut self) {
        self.times.clear();
        self.positions.clear();
        self.velocities.clear();
        self.between.clear();
    }
}
