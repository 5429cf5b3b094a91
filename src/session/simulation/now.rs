//! Where a run is now: time, coordinates, links, energy. Before its first step that is its start, and after its end its end.

use crate::mechanism::description::joint::Pose;
use crate::mechanism::motion::energy::{Energy, energy_with_forces};
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use crate::model::LinkState;
use crate::session::error::Error;
use crate::session::model::pose_of;
use crate::session::simulation::Simulation;

impl Simulation {
    /// Time (s).
    pub fn time(&self) -> f64 {
        match (&self.running, &self.ended) {
            (Some(running), _) => running.engine.with(|simulation| simulation.state().time).unwrap_or(self.begin),
            (_, Some(over)) => over.state.time,
            _ => self.begin,
        }
    }

    /// When it ends (s).
    pub fn end(&self) -> f64 {
        match &self.running {
            Some(running) => running.end,
            None => self.time(),
        }
    }

    /// q and v now ([`Coordinates`](crate::session::Coordinates)).
    ///
    /// # Errors
    /// A start that cannot be.
    pub fn coordinates(&self) -> Result<(Vec<f64>, Vec<f64>), Error> {
        self.look(|state| self.model.flat(state))
    }

    /// Position of a joint now: as many numbers as a report gives (rad, m).
    ///
    /// # Errors
    /// An unknown joint, and a start that cannot be.
    pub fn position(&self, joint: &str) -> Result<Vec<f64>, Error> {
        let place = self.place(joint)?;
        Ok(self.coordinates()?.0[place].to_vec())
    }

    /// Velocity of a joint now [rad/s, m/s].
    ///
    /// # Errors
    /// An unknown joint, and a start that cannot be.
    pub fn velocity(&self, joint: &str) -> Result<Vec<f64>, Error> {
        self.place(joint)?;
        let place = self.model.coordinates().joint(joint).map_or(0..0, |place| place.v.clone());
        Ok(self.coordinates()?.1[place].to_vec())
    }

    /// Pose of a link frame in the world now.
    ///
    /// # Errors
    /// An unknown link, and a start that cannot be.
    pub fn pose(&self, link: &str) -> Result<Pose, Error> {
        self.link(link).map(|link| pose_of(&link))
    }

    /// Pose and motion of a link in the world now.
    ///
    /// # Errors
    /// An unknown link, and a start that cannot be.
    pub fn link(&self, link: &str) -> Result<LinkState, Error> {
        self.look(|state| self.model.link_at(link, state))?
    }

    /// The energy now (J).
    ///
    /// # Errors
    /// A start that cannot be.
    pub fn energy(&self) -> Result<Energy, Error> {
        let mechanism = &self.model.description().mechanism;
        self.look(|state| energy_with_forces(mechanism, &state.position, &body_states(mechanism, state)))
    }

    /// Looks at the state of now.
    pub(super) fn look<R>(&self, look: impl FnOnce(&State) -> R) -> Result<R, Error> {
        match (&self.running, &self.ended) {
            (Some(running), _) => {
                let seen = running.engine.with(|simulation| look(simulation.state()));
                seen.ok_or(Error::Over(self.begin))
            }
            (_, Some(over)) => Ok(look(&over.state)),
            _ => Ok(look(&self.started()?.state)),
        }
    }

    fn place(&self, joint: &str) -> Result<std::ops::Range<usize>, Error> {
        match self.model.coordinates().joint(joint) {
            Some(place) => Ok(place.q.clone()),
            None => {
                let known: Vec<String> = self.model.joint_names().into_iter().map(str::to_string).collect();
                Err(crate::model::ModelError::UnknownJoint { joint: joint.to_string(), known }.into())
            }
        }
    }
}
