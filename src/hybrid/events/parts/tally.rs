//! The tally of a run with events: figures that are reported, and that no step depends on.
//!
//! Three entries wait for the next outcome that can carry them: `abandoned`, `lost_at_start` and `driven`.

use crate::events::effects::resting;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::forces::total::Exchange;
use crate::mechanism::motion::event::Event;
use crate::mechanism::motion::integrator::{ContactSolvers, Cost};
use crate::mechanism::motion::state::State;

/// Rebounds that are left out are told where they would have given back more than this part of the kinetic energy.
const MATTERS: f64 = 1e-9;

/// The figures of a run so far.
#[derive(Clone, Default)]
pub(crate) struct Tally {
    /// Number of steps, and how long they were together (s).
    pub steps: usize,
    pub stepped: f64,
    /// Steps of first order, and how long they were together (s).
    pub first_order: (usize, f64),
    /// Steps over slips, and how long they were together (s).
    pub over_slips: (usize, f64),
    /// How long bodies slept in steps of first order, in the mean over all bodies (s).
    pub asleep: f64,
    /// `Σ h²` of the steps over events and over slips among them (s²), and `Σ h` of those in the place of steps that jam (s): the errors that they add are in
    /// proportion to them.
    pub smeared: [f64; 2],
    /// The largest residual and the largest lift of steps over many impacts (m).
    pub crowd_figures: (f64, f64),
    /// The events since they were last taken.
    pub events: Vec<Event>,
    /// The cost of attempts that were thrown away, which no outcome has yet.
    pub abandoned: Cost,
    /// Energy lost in impacts at the start, and the work of driven surfaces and joints in them, which no outcome has yet.
    pub lost_at_start: Exchange,
    /// Number of laws of contact that could not be solved to their accuracy.
    pub unsolved: usize,
    /// How often each contact solver has solved a problem of an event.
    pub solvers: ContactSolvers,
    /// Number of rebounds left out in crowds of impacts and in steps of first order, and the energy that they would have given back (J).
    pub cut: (usize, f64),
    /// The distance by which the ends of accumulating impacts can have moved bodies or joints so far (m or rad).
    pub left_of_impacts: f64,
    /// The distance by which single steps of first order can have moved bodies otherwise so far (m).
    pub left_of_steps: f64,
    /// `Σ δv` [m/s] and `Σ δv t` (m) of blows that came while elements would still bounce
    /// ([`omitted_flights`](crate::events::effects::omitted_flights)).
    pub in_doubt: [f64; 2],
}

impl Tally {
    /// Notes that a blow at an instant (s) may have changed velocities otherwise [m/s].
    pub fn doubt(&mut self, speed: f64, time: f64) {
        self.in_doubt = [self.in_doubt[0] + speed, self.in_doubt[1] + speed * time];
    }

    /// The distance by which the ends of accumulating impacts, and single steps of first order, can have moved bodies or joints so far (m or rad).
    pub fn error_of_impacts(&self) -> f64 {
        self.left_of_impacts + self.left_of_steps
    }

    /// The distance by which blows in flights that are left out can have moved them up to an instant (s) (m or rad).
    pub fn doubt_of_blows(&self, time: f64) -> f64 {
        (self.in_doubt[0] * time - self.in_doubt[1]).max(0.0)
    }

    /// Notes rebounds that were left out before a state, and the energy that they would have given back (J), unless it is tiny beside the kinetic
    /// energy.
    pub fn leave_out(&mut self, rebounds: usize, energy: f64, whole: &Mechanism, state: &State) {
        if rebounds > 0 && energy > MATTERS * resting::energy(whole, state).kinetic {
            self.cut = (self.cut.0 + rebounds, self.cut.1 + energy);
        }
    }
}
