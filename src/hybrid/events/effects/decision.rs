//! The input and the result of a decision of elements at rest ([`crate::events::effects::deciding`]): the mechanism at an event, the elements that the
//! event has found at the end of their efforts, the contacts that touch, and the accelerations under the law.

use crate::events::finding::watched::Watched;
use crate::instant::dynamics::response::Response;
use crate::instant::holding::elements::Elements;
use crate::instant::holding::moments::Turning;
use crate::instant::holding::touching::{Contact, Touching};
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::contact_solvers::ContactSolvers;
use crate::mechanism::motion::event::Side;
use crate::mechanism::motion::kinematics::{BodyAcceleration, body_accelerations};
use crate::mechanism::motion::state::State;
use nalgebra::Vector3;

/// A mechanism at an event.
pub(crate) struct Scene<'s> {
    pub whole: &'s Mechanism,
    pub elements: &'s Elements,
    pub touching: &'s Touching,
    /// The pairs that may touch in the state of the event, in the order of their numbers.
    pub near: &'s [usize],
    pub response: &'s mut Response,
    /// Counts the contact solvers that its problems need.
    pub solvers: &'s mut ContactSolvers,
}

/// Elements that an event has found at the end of their efforts.
#[derive(Clone, Debug, Default)]
pub(crate) struct Yielding {
    /// Joints at an end of the efforts that can hold them, and the direction in which they go.
    pub joints: Vec<(usize, i8)>,
    /// All held joints and contacts together.
    pub all: bool,
    /// Closed contacts that press no more, and those that stick no more, by their numbers in the mode.
    pub opens: Vec<usize>,
    pub slides: Vec<usize>,
    /// Closed contacts whose slip stops, by their numbers in the mode.
    pub stops: Vec<usize>,
    /// The same whose rolling friction, or spinning friction if so, resists no more; and those whose turning stops.
    pub turns: Vec<(usize, bool)>,
    pub halts: Vec<(usize, bool)>,
    /// Pairs whose slips stop together.
    pub stops_together: Vec<usize>,
}

impl Yielding {
    /// The elements that the functions that are zero name.
    pub fn of(triggers: &[Watched]) -> Self {
        let mut yielding = Yielding::default();
        for trigger in triggers {
            match *trigger {
                // It needs less than the least that can act: it goes forward.
                Watched::Bears(index, Side::Lower) => yielding.joints.push((index, 1)),
                Watched::Bears(index, Side::Upper) => yielding.joints.push((index, -1)),
                Watched::Margin => yielding.all = true,
                Watched::Presses(contact) => yielding.opens.push(contact),
                Watched::Grips(contact) => yielding.slides.push(contact),
                Watched::Slips(contact) => yielding.stops.push(contact),
                Watched::SlipsTogether(pair) => yielding.stops_together.push(pair),
                Watched::Resists(contact, spinning) => yielding.turns.push((contact, spinning)),
                Watched::Turns(contact, spinning) => yielding.halts.push((contact, spinning)),
                _ => {}
            }
        }
        yielding
    }
}

/// A contact that touches, to be decided.
#[derive(Clone, Debug)]
pub(crate) struct Candidate {
    pub contact: Contact,
    /// The velocity of its slip in the world [m/s]; zero if it does not.
    pub slip: Vector3<f64>,
    /// Whether it has been seen to reach the end of what friction can hold, and whether the end of its pressure.
    pub slides: bool,
    pub opens: bool,
    /// How it turns against rolling and spinning friction; zero where it does not. And whether it has been seen to reach the end of what each of them
    /// can hold.
    pub turning: Turning,
    pub turns: [bool; 2],
}

/// Reasons for which accelerations alone decide no mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Undecided {
    /// A candidate that slides, by its number, has no consistent acceleration: an impulse must follow.
    Inconsistent(usize),
    /// The problem could not be solved.
    Unsolved,
}

/// What the decided accelerations are of.
#[derive(Clone, Debug)]
pub(crate) struct Decided {
    /// The residual of the law, as a part of the largest force: zero if it was solved to its accuracy; otherwise the best iterate is taken.
    pub off: f64,
    /// One entry a degree of freedom.
    pub accelerations: Vec<f64>,
    /// λ_N of every candidate (N), and the normal forces that would hold all of them; zero if no candidate is at the rim of a flat end.
    pub pressures: Vec<f64>,
    pub holding: Vec<f64>,
}

impl Decided {
    /// The accelerations of all bodies, in a state with these places and rates of theirs.
    pub fn of_bodies(&self, whole: &Mechanism, state: &State, bodies: &[BodyState]) -> Vec<BodyAcceleration> {
        let mut accelerations = vec![BodyAcceleration::default(); bodies.len()];
        body_accelerations(whole, bodies, &state.velocity, &self.accelerations, &mut accelerations);
        accelerations
    }
}
