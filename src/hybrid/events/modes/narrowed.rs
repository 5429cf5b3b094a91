//! Efforts of a controller that reads the whole state, restricted to the degrees of freedom that move in a mode.
//!
//! The injection `S` takes the rates of the reduced mechanism to the rates of the whole (held joints have zero). A law `f` of the whole and its
//! derivatives become
//!
//! ```text
//!     f̃(t, q̃, ṽ) = Eᵀ f(t, q, S ṽ) + e(t)         q: what is held stays where it is; E: the entries of f that act on what moves
//!     f̃_q = Eᵀ f_q S,   f̃_v = Eᵀ f_v S            e: motors whose efforts change in time, one entry a freedom with those of f
//! ```
//!
//! Efforts on held joints only change the constraint forces.

use crate::events::modes::drives::Drives;
use crate::instant::dynamics::response::Response;
use crate::instant::holding::held::Held;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::ground::guarded::Guarded;
use crate::mechanism::motion::inputs::{ChangingEfforts, Feedback, Inputs};
use crate::mechanism::motion::state::State;
use nalgebra::DMatrix;

/// The workspace of a piece for a law: the places where its entries act, and room.
#[derive(Clone)]
pub(crate) struct Room {
    /// Degrees of freedom of the reduced mechanism, each once.
    freedoms: Vec<usize>,
    /// Entries of the law that act on the reduced mechanism, with their places among the freedoms, and the entries of the motors that change in time.
    of_law: Vec<(usize, usize)>,
    of_drives: Vec<usize>,
    within: Guarded<Within>,
}

#[derive(Clone)]
struct Within {
    /// The state of the whole.
    state: State,
    /// The efforts of the law, one entry after the other.
    efforts: Vec<f64>,
    /// The response of the reduced mechanism.
    response: Response,
}

impl Room {
    /// The workspace for a law of the whole, and for the motors that act on the reduced mechanism.
    pub fn new(law: &dyn Feedback, whole: &Mechanism, moving: &Held, drives: &Drives) -> Self {
        let mut freedoms: Vec<usize> = Vec::new();
        let mut place = |freedom: usize| {
            freedoms.iter().position(|&known| known == freedom).unwrap_or_else(|| {
                freedoms.push(freedom);
                freedoms.len() - 1
            })
        };
        let entries = law.freedoms().iter().enumerate();
        let of_law = entries.filter_map(|(entry, &freedom)| Some((entry, place(moving.freedom(whole, freedom)?))));
        let of_law = of_law.collect();
        let of_drives = drives.freedoms().iter().map(|&freedom| place(freedom)).collect();
        let within = Within {
            state: State::zero(whole),
            efforts: vec![0.0; law.freedoms().len()],
            response: Response::new(&moving.mechanism),
        };
        Room { freedoms, of_law, of_drives, within: Guarded::new(within) }
    }

    /// A step begins in a state of the whole: held joints stay there.
    pub fn begin(&mut self, start: &State) {
        self.within.get_mut().state.copy_from(start);
    }
}

/// The law of the reduced mechanism.
pub(crate) struct Narrowed<'n> {
    law: &'n dyn Feedback,
    whole: &'n Mechanism,
    moving: &'n Held,
    drives: &'n Drives,
    room: &'n Room,
}

impl<'n> Narrowed<'n> {
    /// `None` if no law acts on the reduced mechanism.
    pub fn of(
        law: Option<&'n dyn Feedback>,
        whole: &'n Mechanism,
        moving: &'n Held,
        drives: &'n Drives,
        room: Option<&'n Room>,
    ) -> Option<Self> {
        let room = room.filter(|room| !room.of_law.is_empty())?;
        Some(Narrowed { law: law?, whole, moving, drives, room })
    }
}

impl Feedback for Narrowed<'_> {
    fn freedoms(&self) -> &[usize] {
        &self.room.freedoms
    }

    fn efforts(&self, state: &State, efforts: &mut [f64]) {
        let within = &mut *self.room.within.lock();
        self.moving.spread(self.whole, state, &mut within.state);
        self.law.efforts(&within.state, &mut within.efforts);
        efforts.fill(0.0);
        for &(entry, place) in &self.room.of_law {
            efforts[place] += within.efforts[entry];
        }
        for (entry, &place) in self.room.of_drives.iter().enumerate() {
            efforts[place] += self.drives.effort(entry, state.time);
        }
    }

    fn derivatives(&self, state: &State, by_position: &mut DMatrix<f64>, by_rate: &mut DMatrix<f64>) {
        let within = &mut *self.room.within.lock();
        self.moving.spread(self.whole, state, &mut within.state);
        let size = (within.efforts.len(), self.whole.velocity_count);
        let (mut of_position, mut of_rate) = (DMatrix::zeros(size.0, size.1), DMatrix::zeros(size.0, size.1));
        self.law.derivatives(&within.state, &mut of_position, &mut of_rate);
        for freedom in 0..self.whole.velocity_count {
            let Some(own) = self.moving.freedom(self.whole, freedom) else { continue };
            for &(entry, place) in &self.room.of_law {
                by_position[(place, own)] += of_position[(entry, freedom)];
                by_rate[(place, own)] += of_rate[(entry, freedom)];
            }
        }
    }

    fn mobility(&self, state: &State) -> DMatrix<f64> {
        self.room.within.lock().response.matrix(state, &self.room.freedoms).0
    }
}

/// The efforts that follow the state at both ends of the last step, for those who ask for forces when the law is no more there.
#[derive(Clone, Debug, Default)]
pub(crate) struct Felt {
    /// Start and end (s), with the efforts of the whole; empty without a law.
    times: [f64; 2],
    efforts: [Vec<f64>; 2],
}

impl Felt {
    /// Takes note of a step.
    pub fn see(&mut self, inputs: Inputs, start: &State, end: &State) {
        for (at, state) in [start, end].into_iter().enumerate() {
            self.times[at] = state.time;
            self.efforts[at].clear();
            if inputs.feedback.is_some() {
                self.efforts[at].resize(state.velocity.len(), 0.0);
                inputs.add_feedback(state, &mut self.efforts[at]);
            }
        }
    }

    /// Adds those at a time of the step (s): exactly at its ends, on a line between them inside.
    pub fn add(&self, time: f64, efforts: &mut [f64]) {
        let [start, end] = self.times;
        let part = if time < end && end > start { (time - start) / (end - start) } else { 1.0 };
        for (effort, (from, to)) in efforts.iter_mut().zip(self.efforts[0].iter().zip(&self.efforts[1])) {
            *effort += from + part * (to - from);
        }
    }
}
