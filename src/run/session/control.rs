//! A controller of a program: it computes efforts at fixed instants, which are held in between.
//!
//! ```text
//!     t_k = t₀ + k T,   τ(t) = u(t_k, q_k, v_k)   for t_k ≤ t < t_{k+1}         T: the period (s)
//! ```
//!
//! It corresponds to [`crate::simulation::Controller`], in the coordinates of programs, for runs that proceed step by step.

use crate::mechanism::motion::state::State;
use crate::session::error::{ControllerFailure, Error};
use crate::session::model::Model;
use crate::simulation::InputError;

/// A mechanism at one instant.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Moment {
    /// Time (s).
    pub time: f64,
    /// Positions ([`Coordinates`](crate::session::Coordinates)).
    pub q: Vec<f64>,
    /// Velocities.
    pub v: Vec<f64>,
}

type Law = Box<dyn FnMut(&Moment, &mut [f64]) -> Result<(), ControllerFailure> + Send>;

/// A controller, and the time of its next call.
pub(crate) struct Control {
    begin: f64,
    period: f64,
    asked: u64,
    law: Law,
    moment: Moment,
    efforts: Vec<f64>,
    of_state: Vec<f64>,
}

impl Control {
    /// A controller called from time `begin` (s) on, every `period` (s).
    pub fn new(model: &Model, begin: f64, period: f64, law: Law) -> Result<Self, Error> {
        if !(period > 0.0 && period.is_finite()) {
            let wanted = "give a finite time that is longer than zero";
            return Err(Error::Option { option: "the controller's period", value: period, wanted });
        }
        let places = model.coordinates();
        let (q, v) = (vec![0.0; places.q_count()], vec![0.0; places.v_count()]);
        let efforts = vec![0.0; places.v_count()];
        let of_state = efforts.clone();
        Ok(Control { begin, period, asked: 0, law, moment: Moment { time: begin, q, v }, efforts, of_state })
    }

    /// The time of the next call (s).
    pub fn next(&self) -> f64 {
        self.begin + self.asked as f64 * self.period
    }

    /// When it began to be asked (s), and how often it was.
    pub fn ticks(&self) -> (f64, u64) {
        (self.begin, self.asked)
    }

    /// Is asked next after so many periods from a time on (s).
    pub fn ask_from(&mut self, (begin, asked): (f64, u64)) {
        (self.begin, self.asked) = (begin, asked);
    }

    /// Whether the next call is due at this time.
    pub fn is_due(&self, time: f64) -> bool {
        time >= self.next()
    }

    /// Calls the controller with a state. Does not allocate if no joint is spherical or floating.
    pub fn ask(&mut self, model: &Model, state: &State) -> Result<(), Error> {
        let Control { law, moment, efforts, of_state, asked, .. } = self;
        moment.time = state.time;
        let places = model.coordinates();
        places.write(model.description(), &state.position, &state.velocity, &mut moment.q, &mut moment.v);
        efforts.fill(0.0);
        law(moment, efforts).map_err(|failure| Error::Controller { time: state.time, failure })?;
        if let Some(index) = efforts.iter().position(|effort| !effort.is_finite()) {
            let joint = places.joints().iter().find(|joint| joint.v.contains(&index));
            let joint = joint.map_or(String::new(), |joint| joint.name.clone());
            let failure = Box::new(InputError::NotFinite { joint, effort: efforts[index] });
            return Err(Error::Controller { time: state.time, failure });
        }
        places.efforts_of_state(model.description(), &state.position, efforts, of_state);
        *asked += 1;
        Ok(())
    }

    /// The efforts along the velocities of the state.
    pub fn of_state(&self) -> &[f64] {
        &self.of_state
    }
}
