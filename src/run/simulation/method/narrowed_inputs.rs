//! Efforts from outside, restricted to the joints that are not locked.
//!
//! The injection `S` takes the rates v' of the joints that move to all rates v. An effort τ along all freedoms acts as `Sᵀ τ`, and a law f of the
//! state as
//!
//! ```text
//!     f'(t, q', v') = Eᵀ f(t, q, S v')        q: locked joints are in their places; E: the entries of f that act on joints that move
//!     f'_q = Eᵀ f_q S,   f'_v = Eᵀ f_v S
//! ```
//!
//! Efforts on locked joints do no work; they only change the forces of the limits.

use crate::instant::dynamics::response::Response;
use crate::instant::holding::held::Held;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::inputs::{ChangingEfforts, Feedback, Inputs};
use crate::mechanism::motion::state::State;
use nalgebra::DMatrix;
use std::cell::RefCell;

/// Room for the efforts of one step after another.
pub(crate) struct NarrowedInputs {
    /// Constant efforts, one entry a degree of freedom that moves [N m or N].
    efforts: Vec<f64>,
    /// Entries of the laws that act on joints that move, and their degrees of freedom there.
    changing: (Vec<usize>, Vec<usize>),
    following: (Vec<usize>, Vec<usize>),
    /// Once there is a law of the state.
    room: Option<Box<RefCell<Room>>>,
}

/// A copy has no room yet: it makes its own with the next law of the state.
impl Clone for NarrowedInputs {
    fn clone(&self) -> Self {
        let NarrowedInputs { efforts, changing, following, .. } = self;
        NarrowedInputs {
            efforts: efforts.clone(),
            changing: changing.clone(),
            following: following.clone(),
            room: None,
        }
    }
}

struct Room {
    /// Of the whole.
    state: State,
    /// All entries of the law.
    efforts: Vec<f64>,
    /// Of the joints that move.
    response: Response,
}

impl NarrowedInputs {
    /// For the joints of a mechanism that are not held.
    pub fn new(whole: &Mechanism, held: &Held) -> Self {
        let efforts = vec![0.0; held.mechanism.velocity_count];
        debug_assert!(efforts.len() <= whole.velocity_count);
        NarrowedInputs { efforts, changing: Default::default(), following: Default::default(), room: None }
    }

    /// Makes a step from a state of the whole under the efforts of these inputs on joints that move.
    pub fn within<R>(
        &mut self,
        whole: &Mechanism,
        held: &Held,
        inputs: Inputs,
        start: &State,
        make: impl FnOnce(Inputs) -> R,
    ) -> R {
        self.efforts.fill(0.0);
        if !inputs.efforts.is_empty() {
            held.gather_velocities(whole, inputs.efforts, &mut self.efforts);
        }
        let split = |freedoms: &[usize], (entries, own): &mut (Vec<usize>, Vec<usize>)| {
            entries.clear();
            own.clear();
            for (entry, &freedom) in freedoms.iter().enumerate() {
                if let Some(freedom) = held.freedom(whole, freedom) {
                    entries.push(entry);
                    own.push(freedom);
                }
            }
        };
        split(inputs.changing.map_or(&[], ChangingEfforts::freedoms), &mut self.changing);
        split(inputs.feedback.map_or(&[], Feedback::freedoms), &mut self.following);
        let changing = inputs.changing.filter(|_| !self.changing.0.is_empty());
        let changing = changing.map(|law| Changing { law, entries: &self.changing.0, freedoms: &self.changing.1 });
        let law = inputs.feedback.filter(|_| !self.following.0.is_empty());
        let following = law.map(|law| {
            let room = self.room.get_or_insert_with(|| {
                let (state, response) = (State::zero(whole), Response::new(&held.mechanism));
                Box::new(RefCell::new(Room { state, efforts: Vec::new(), response }))
            });
            let within = room.get_mut();
            within.state.copy_from(start);
            within.efforts.resize(law.freedoms().len(), 0.0);
            Following { law, entries: &self.following.0, freedoms: &self.following.1, whole, held, room }
        });
        make(Inputs {
            efforts: if inputs.efforts.is_empty() { &[] } else { &self.efforts },
            changing: changing.as_ref().map(|changing| changing as &dyn ChangingEfforts),
            feedback: following.as_ref().map(|following| following as &dyn Feedback),
        })
    }
}

/// Efforts that change in time, on joints that move.
struct Changing<'n> {
    law: &'n dyn ChangingEfforts,
    entries: &'n [usize],
    freedoms: &'n [usize],
}

impl ChangingEfforts for Changing<'_> {
    fn freedoms(&self) -> &[usize] {
        self.freedoms
    }

    fn effort(&self, entry: usize, time: f64) -> f64 {
        self.law.effort(self.entries[entry], time)
    }
}

/// Efforts that follow the state, on joints that move.
struct Following<'n> {
    law: &'n dyn Feedback,
    entries: &'n [usize],
    freedoms: &'n [usize],
    whole: &'n Mechanism,
    held: &'n Held,
    room: &'n RefCell<Room>,
}

impl Feedback for Following<'_> {
    fn freedoms(&self) -> &[usize] {
        self.freedoms
    }

    fn efforts(&self, state: &State, efforts: &mut [f64]) {
        let Room { state: of_whole, efforts: all, .. } = &mut *self.room.borrow_mut();
        self.held.spread(self.whole, state, of_whole);
        self.law.efforts(of_whole, all);
        for (effort, &entry) in efforts.iter_mut().zip(self.entries) {
            *effort = all[entry];
        }
    }

    fn derivatives(&self, state: &State, by_position: &mut DMatrix<f64>, by_rate: &mut DMatrix<f64>) {
        let Room { state: of_whole, efforts: all, .. } = &mut *self.room.borrow_mut();
        self.held.spread(self.whole, state, of_whole);
        let size = (all.len(), self.whole.velocity_count);
        let (mut of_position, mut of_rate) = (DMatrix::zeros(size.0, size.1), DMatrix::zeros(size.0, size.1));
        self.law.derivatives(of_whole, &mut of_position, &mut of_rate);
        for freedom in 0..self.whole.velocity_count {
            let Some(own) = self.held.freedom(self.whole, freedom) else { continue };
            for (row, &entry) in self.entries.iter().enumerate() {
                by_position[(row, own)] += of_position[(entry, freedom)];
                by_rate[(row, own)] += of_rate[(entry, freedom)];
            }
        }
    }

    fn mobility(&self, state: &State) -> DMatrix<f64> {
        self.room.borrow_mut().response.matrix(state, self.freedoms).0
    }
}
