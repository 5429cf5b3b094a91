//! The present state of a run: time, coordinates, links, energy. Before the first step it is the start; after the end, the end.

use crate::mechanism::description::joint::Pose;
use crate::mechanism::motion::energy::{Energy, energy_with_forces};
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use crate::model::LinkState;
use crate::session::error::Error;
use crate::session::held_start::{HeldTargets, held_targets};
use crate::session::model::pose_of;
use crate::session::sensors::Sensed;
use crate::session::simulation::Simulation;

impl Simulation {
    /// Time (s).
    pub fn time(&self) -> f64 {
        match (&self.running, &self.ended) {
            (Some(running), _) => running.simulation.state().time,
            (_, Some(over)) => over.state.time,
            _ => self.begin,
        }
    }

    /// The end of the run (s).
    pub fn end(&self) -> f64 {
        match &self.running {
            Some(running) => running.end,
            None => self.time(),
        }
    }

    /// The present q and v ([`Coordinates`](crate::session::Coordinates)).
    ///
    /// # Errors
    /// An invalid start.
    pub fn coordinates(&self) -> Result<(Vec<f64>, Vec<f64>), Error> {
        self.look(|state| self.model.flat(state))
    }

    /// Writes the present q and v into these slices, without allocating; [`Simulation::coordinates`] returns the same numbers.
    ///
    /// # Errors
    /// Lengths that differ from the lengths of q and v, or an invalid start.
    pub fn write_coordinates(&self, q: &mut [f64], v: &mut [f64]) -> Result<(), Error> {
        let (places, model) = (self.model.coordinates(), self.model.description());
        places.check_lengths(q, v)?;
        self.look(|state| places.write(model, &state.position, &state.velocity, q, v))
    }

    /// The present position of a joint: one number per coordinate, as in reports (rad, m).
    ///
    /// # Errors
    /// An unknown joint, or an invalid start.
    pub fn position(&self, joint: &str) -> Result<Vec<f64>, Error> {
        let place = self.place_of(joint)?;
        Ok(self.coordinates()?.0[place].to_vec())
    }

    /// The present velocity of a joint [rad/s, m/s].
    ///
    /// # Errors
    /// An unknown joint, or an invalid start.
    pub fn velocity(&self, joint: &str) -> Result<Vec<f64>, Error> {
        self.place_of(joint)?;
        let place = self.model.coordinates().joint(joint).map_or(0..0, |place| place.v.clone());
        Ok(self.coordinates()?.1[place].to_vec())
    }

    /// The present pose of a link frame in the world.
    ///
    /// # Errors
    /// An unknown link, or an invalid start.
    pub fn pose(&self, link: &str) -> Result<Pose, Error> {
        self.link(link).map(|link| pose_of(&link))
    }

    /// The present pose and velocity of a link in the world.
    ///
    /// # Errors
    /// An unknown link, or an invalid start.
    pub fn link(&self, link: &str) -> Result<LinkState, Error> {
        self.look(|state| self.model.link_at(link, state))?
    }

    /// The efforts that sampled motors hold until their next ticks [N m or N]: an entry a motor, in the order of
    /// [`Model::motor_names`](crate::session::Model::motor_names), `None` for continuous ones and before it is known.
    pub fn held_efforts(&self) -> Vec<Option<f64>> {
        match (&self.running, &self.ended) {
            (Some(running), _) => running.simulation.held_efforts(),
            (_, Some(over)) => over.held.clone(),
            _ => self.held.clone(),
        }
    }

    /// The targets of the motors that hold their joints at the start of the run.
    pub fn held_targets(&self) -> HeldTargets {
        let has_begun = self.running.is_some() || self.ended.is_some();
        if has_begun { held_targets(self.model.description()) } else { self.held_at.clone() }
    }

    /// The present energy (J).
    ///
    /// # Errors
    /// An invalid start.
    pub fn energy(&self) -> Result<Energy, Error> {
        let mechanism = &self.model.description().mechanism;
        self.look(|state| energy_with_forces(mechanism, &state.position, &body_states(mechanism, state)))
    }

    /// What sensors measure now: all forces and accelerations are worked out once, for any number of readings.
    ///
    /// # Errors
    /// An invalid start.
    pub fn sense(&self) -> Result<Sensed, Error> {
        let efforts = match &self.control {
            Some(control) => Some(control.of_state()),
            None => self.efforts.as_deref(),
        };
        let simulation = self.running.as_ref().map(|running| &running.simulation);
        let (statuses, contacts) = (simulation.map(|run| run.joint_statuses()), simulation.map(|run| run.contacts()));
        self.look(|state| Sensed::new(&self.model, state, efforts, statuses.as_deref(), contacts))
    }

    /// Calls a function with the present state.
    pub(super) fn look<R>(&self, look: impl FnOnce(&State) -> R) -> Result<R, Error> {
        match (&self.running, &self.ended) {
            (Some(running), _) => Ok(look(running.simulation.state())),
            (_, Some(over)) => Ok(look(&over.state)),
            _ => Ok(look(&self.started()?.state)),
        }
    }

    fn place_of(&self, joint: &str) -> Result<std::ops::Range<usize>, Error> {
        match self.model.coordinates().joint(joint) {
            Some(place) => Ok(place.q.clone()),
            None => Err(self.model.unknown_joint(joint)),
        }
    }
}
