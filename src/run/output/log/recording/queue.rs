//! The queue between a run and the thread that encodes its log: samples, figures and events, in their order.

use crate::lobatto::instants::snapshot::INSTANTS;
use crate::mechanism::motion::contact_point::ContactPoint;
use crate::mechanism::motion::event::Event;
use crate::output::log::messages::figures::Figures;

/// Bytes of a piece that is large.
const LARGE: usize = 1 << 16;

/// Bytes of one that is too large.
const TOO_LARGE: usize = 1 << 19;

/// Samples, and the figures and events logged between them.
#[derive(Default)]
pub(crate) struct Piece {
    /// Times of the samples (s), their positions and their velocities, one after the other.
    pub times: Vec<f64>,
    pub positions: Vec<f64>,
    pub velocities: Vec<f64>,
    /// The efforts that sampled motors hold at the samples, an entry a motor; empty where the run does not tell them.
    pub held: Vec<Option<f64>>,
    /// The items before the sample of this number, or after the last.
    pub between: Vec<(usize, Between)>,
    /// How many events are among that.
    events: usize,
}

/// An item logged between samples.
pub(crate) enum Between {
    /// The figures of a step, at a time in nanoseconds.
    Figures(u64, Figures),
    /// An event, at a time in nanoseconds.
    Event(u64, Event),
    /// The contacts of the sample before, at its time in nanoseconds.
    Contacts(u64, Vec<ContactPoint>),
    /// The derivatives of this number at a time in nanoseconds.
    Derivatives(u64, usize),
    /// A line of `/log`, encoded.
    Line(u64, Vec<u8>),
}

impl Piece {
    /// Adds a sample.
    pub(crate) fn push(&mut self, time: f64, position: &[f64], velocity: &[f64]) {
        self.times.push(time);
        self.positions.extend_from_slice(position);
        self.velocities.extend_from_slice(velocity);
    }

    /// The efforts that motors hold at the samples from this one on; empty where they are not known.
    pub(crate) fn held_at(&self, first: usize) -> &[Option<f64>] {
        let motors = self.held.len().checked_div(self.times.len()).unwrap_or(0);
        &self.held[first * motors..]
    }

    /// The contacts of the samples, each with the number of its sample, for those that have them.
    pub(crate) fn contacts(&self) -> impl Iterator<Item = (usize, &[ContactPoint])> {
        self.between.iter().filter_map(|(after, what)| match what {
            Between::Contacts(_, points) => Some((after - 1, points.as_slice())),
            _ => None,
        })
    }

    /// Adds an item before the next sample.
    pub(crate) fn push_between(&mut self, what: Between) {
        self.between.push((self.times.len(), what));
    }

    /// Adds an event before the next sample.
    pub(crate) fn push_event(&mut self, nanoseconds: u64, event: Event) {
        self.push_between(Between::Event(nanoseconds, event));
        self.events += 1;
    }

    /// Whether it is worth while to take it.
    pub(crate) fn is_large(&self) -> bool {
        self.size() >= LARGE && self.times.len() >= INSTANTS
    }

    /// Whether it must be taken before more is added. The messages of an arm are twenty times as large.
    pub(crate) fn is_too_large(&self) -> bool {
        self.size() > TOO_LARGE && self.times.len() > 4 * INSTANTS
    }

    /// Size of the numbers and events in bytes; figures are few.
    fn size(&self) -> usize {
        let numbers = self.times.len() + self.positions.len() + self.velocities.len();
        8 * numbers + size_of::<(usize, Between)>() * self.events
    }

    /// Forgets everything and keeps the memory.
    pub(crate) fn clear(&mut self) {
        self.times.clear();
        self.positions.clear();
        self.velocities.clear();
        self.held.clear();
        self.between.clear();
        self.events = 0;
    }
}
