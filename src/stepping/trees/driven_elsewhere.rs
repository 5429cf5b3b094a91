//! Efforts from outside for steps on another spanning tree than the file's ([`crate::trees::other_tree`]).
//!
//! They act along coordinates that both trees have, each with its own number. Let `E` and `E'` inject the m driven freedoms into the file's n and
//! into the n' here. The rates are `v = S v'`, and `v' = T v` for motions that the closures allow. A law f of the file's state becomes
//!
//! ```text
//!     f'(t, q', v') = f(t, q(q'), S v')       f'_q' = f_q S,   f'_v' = f_v S        Y' E' = T Y E
//! ```
//!
//! The derivative of S by the positions is left out of `f'_q'`, where errors cost no accuracy ([`Feedback`]).

use crate::trees::turns::Turns;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::ground::guarded::Guarded;
use catena_mechanism::motion::inputs::{ChangingEfforts, Feedback, Inputs};
use catena_mechanism::motion::state::State;
use catena_mechanism::structure::other_tree::OtherTree;
use nalgebra::DMatrix;

/// Inputs on the other tree, and room for them.
#[derive(Clone)]
pub(crate) struct Driven {
    /// Constant efforts, one entry a degree of freedom here [N m or N].
    efforts: Vec<f64>,
    /// The degrees of freedom along which others act.
    changing: Vec<usize>,
    following: Vec<usize>,
    /// Once there is a law.
    room: Option<Box<Guarded<Room>>>,
}

/// The state of the file where a law is asked, and one here.
#[derive(Clone)]
struct Room {
    other: OtherTree,
    state: State,
    own: State,
}

impl Driven {
    /// Inputs of zero.
    pub fn new(other: &OtherTree) -> Self {
        let efforts = vec![0.0; other.mechanism.velocity_count];
        Driven { efforts, changing: Vec::new(), following: Vec::new(), room: None }
    }

    /// Makes a step with the inputs of the file's tree. The driven joints are on both trees, and `turns` begin at the start of the step.
    pub fn within<R>(
        &mut self,
        file: &Mechanism,
        other: &OtherTree,
        turns: &Turns,
        inputs: Inputs,
        make: impl FnOnce(Inputs) -> R,
    ) -> R {
        if inputs.efforts.is_empty() {
            self.efforts.fill(0.0);
        } else {
            other.take_common_efforts(inputs.efforts, &mut self.efforts);
        }
        let numbers = |from: &[usize], into: &mut Vec<usize>| {
            into.clear();
            into.extend(from.iter().filter_map(|&freedom| other.freedom(freedom)));
        };
        numbers(inputs.changing.map_or(&[], ChangingEfforts::freedoms), &mut self.changing);
        numbers(inputs.feedback.map_or(&[], Feedback::freedoms), &mut self.following);
        let changing = inputs.changing.map(|law| Changing { law, freedoms: &self.changing });
        let following = inputs.feedback.map(|law| {
            let room = self.room.get_or_insert_with(|| {
                let (state, own) = (State::zero(file), State::zero(&other.mechanism));
                Box::new(Guarded::new(Room { other: other.clone(), state, own }))
            });
            Following { law, freedoms: &self.following, file, room, turns }
        });
        make(Inputs {
            efforts: &self.efforts,
            changing: changing.as_ref().map(|changing| changing as &dyn ChangingEfforts),
            feedback: following.as_ref().map(|following| following as &dyn Feedback),
        })
    }
}

/// Efforts that change in time, along the freedoms here.
#[derive(Clone)]
struct Changing<'d> {
    law: &'d dyn ChangingEfforts,
    freedoms: &'d [usize],
}

impl ChangingEfforts for Changing<'_> {
    fn freedoms(&self) -> &[usize] {
        self.freedoms
    }

    fn effort(&self, entry: usize, time: f64) -> f64 {
        self.law.effort(entry, time)
    }
}

/// Efforts that follow the state, along the freedoms here.
#[derive(Clone)]
struct Following<'d> {
    law: &'d dyn Feedback,
    freedoms: &'d [usize],
    file: &'d Mechanism,
    room: &'d Guarded<Room>,
    turns: &'d Turns,
}

impl Following<'_> {
    /// The state of the file for one here.
    fn place(&self, room: &mut Room, state: &State) {
        room.other.give(self.file, state, &mut room.state);
        self.turns.unwrap(state.time, &mut room.state.position, &room.state.velocity);
    }
}

impl Feedback for Following<'_> {
    fn freedoms(&self) -> &[usize] {
        self.freedoms
    }

    fn efforts(&self, state: &State, efforts: &mut [f64]) {
        let room = &mut *self.room.lock();
        self.place(room, state);
        self.law.efforts(&room.state, efforts);
    }

    fn derivatives(&self, state: &State, by_position: &mut DMatrix<f64>, by_rate: &mut DMatrix<f64>) {
        let room = &mut *self.room.lock();
        self.place(room, state);
        let (count, size) = (self.freedoms.len(), self.file.velocity_count);
        let [mut of_position, mut of_rate] = [(); 2].map(|()| DMatrix::zeros(count, size));
        self.law.derivatives(&room.state, &mut of_position, &mut of_rate);
        // S, column by column.
        let mut rates = DMatrix::zeros(size, state.velocity.len());
        let Room { other, own, state: of_file } = room;
        own.copy_from(state);
        own.velocity.fill(0.0);
        for freedom in 0..own.velocity.len() {
            own.velocity[freedom] = 1.0;
            other.give(self.file, own, of_file);
            rates.column_mut(freedom).copy_from_slice(&of_file.velocity);
            own.velocity[freedom] = 0.0;
        }
        *by_position += of_position * &rates;
        *by_rate += of_rate * rates;
    }

    fn mobility(&self, state: &State) -> DMatrix<f64> {
        let room = &mut *self.room.lock();
        self.place(room, state);
        let of_file = self.law.mobility(&room.state);
        let mut mobility = DMatrix::zeros(state.velocity.len(), of_file.ncols());
        for (entry, column) in of_file.column_iter().enumerate() {
            room.state.velocity.copy_from_slice(column.as_slice());
            room.other.take(self.file, &room.state, &mut room.own);
            mobility.column_mut(entry).copy_from_slice(&room.own.velocity);
        }
        mobility
    }
}
