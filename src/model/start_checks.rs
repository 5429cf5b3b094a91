//! What a start can be that the numbers of every joint do not say: beyond what doubles hold, undefined, or outside limits.

use crate::mechanism::motion::energy::energy_with_forces;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use crate::model::model_error::ModelError;
use crate::model::robot_model::Model;
use crate::scene::{Element, Warning};

/// A joint may be beyond a limit by this much [rad or m]: what is left of closing loops.
const NEGLIGIBLE_EXCESS: f64 = 1e-9;

impl Model {
    /// Refuses places and velocities whose squares, and so energies, are infinite.
    ///
    /// # Errors
    /// [`ModelError::TooFarAway`] or [`ModelError::TooFast`] with the first link of which that is so, or else
    /// [`ModelError::InfiniteEnergy`].
    pub fn check_representable(&self, state: &State) -> Result<(), ModelError> {
        let states = body_states(&self.mechanism, state);
        let mut kinetic = 0.0;
        for (body, at) in self.mechanism.bodies.iter().zip(&states) {
            if !at.position.norm_squared().is_finite() {
                return Err(ModelError::TooFarAway { link: body.name.clone(), distance: at.position.amax() });
            }
            // At least the energy: a body may turn about any of its axes later.
            kinetic +=
                body.mass * at.velocity.norm_squared() + body.inertia.amax() * at.angular_velocity.norm_squared();
            if !f64::is_finite(kinetic) {
                return Err(ModelError::TooFast {
                    joint: body.joint.name.clone(),
                    link: body.name.clone(),
                    speed: at.velocity.amax(),
                    spin: at.angular_velocity.amax(),
                });
            }
        }
        let energy = energy_with_forces(&self.mechanism, &state.position, &states).total();
        if energy.is_finite() { Ok(()) } else { Err(ModelError::InfiniteEnergy) }
    }

    /// Refuses a start at which the force of a spring has no direction.
    ///
    /// # Errors
    /// [`ModelError::UndirectedSpring`] with its name.
    pub fn check_springs(&self, state: &State) -> Result<(), ModelError> {
        let states = body_states(&self.mechanism, state);
        match self.mechanism.forces.point_springs.iter().find(|spring| spring.is_undirected(&states)) {
            Some(spring) => {
                Err(ModelError::UndirectedSpring { spring: spring.name.clone(), rest_length: spring.rest_length })
            }
            None => Ok(()),
        }
    }

    /// What to say of joints that are outside their limits, which nothing will push back.
    pub fn limit_warning(&self, state: &State) -> Option<Warning> {
        let outside = self.mechanism.limits.iter().filter_map(|limit| {
            let position = state.position[limit.coordinate.position];
            let excess = (limit.lower - position).max(position - limit.upper);
            let joint = &self.mechanism.bodies[limit.coordinate.body].joint;
            let unit = joint.kind.unit(limit.coordinate.freedom - joint.velocity_index);
            (excess > NEGLIGIBLE_EXCESS).then(|| Warning {
                file: self.path().to_path_buf(),
                line: None,
                element: Some(Element::Joint(joint.name.clone())),
                message: format!(
                    "it starts at {position} {unit}, outside its limits {} to {} {unit}",
                    limit.lower, limit.upper
                ),
            })
        });
        Warning::of_kind(outside.collect(), "joint")
    }
}
