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
    /// Blows that came while elements would still bounce ([`omitted_flights`](crate::events::effects::omitted_flights)): finer runs see them.
    pub in_doubt: Doubt,
    /// Blows whose law could not be solved to its accuracy: finer runs may fail at the same.
    pub unsolved_blows: Doubt,
}

/// Velocities that blows may have changed otherwise: `Σ δv` [m/s] and `Σ δv t` (m).
#[derive(Clone, Copy, Default)]
pub(crate) struct Doubt([f64; 2]);

impl Doubt {
    /// Notes that a blow at an instant (s) may have changed velocities otherwise [m/s].
    pub fn add(&mut self, speed: f64, time: f64) {
        self.0 = [self.0[0] + speed, self.0[1] + speed * time];
    }

    /// The distance by which such blows can have moved bodies or joints up to an instant (s) (m or rad): `Σ δv (t − t_i)`.
    pub fn at(&self, time: f64) -> f64 {
        (self.0[0] * time - self.0[1]).max(0.0)
    }
}

impl Tally {
    /// The distance by which the ends of accumulating impacts, single steps of first order, and impacts whose law was not solved can have moved bodies or
    /// joints up to an instant (s) (m or rad).
    pub fn error_of_impacts(&self, time: f64) -> f64 {
        self.left_of_impacts + self.left_of_steps + self.unsolved_blows.at(time)
    }

    /// Notes rebounds that were left out before a state, and the energy that they would have given back (J), unless it is tiny beside the kinetic
    /// energy.
    pub fn leave_out(&mut self, rebounds: usize, energy: f64, whole: &Mechanism, state: &State) {
        if rebounds > 0 && energy > MATTERS * resting::energy(whole, state).kinetic {
            self.cut = (self.cut.0 + rebounds, self.cut.1 + energy);
        }
    }
}
