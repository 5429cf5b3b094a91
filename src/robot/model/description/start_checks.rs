//! Checks of a start as a whole: numbers that doubles cannot hold, undefined forces, joints outside their limits.

use crate::mechanism::description::closure::{Coordinate, JointLimit};
use crate::mechanism::ground::words::decimals;
use crate::mechanism::motion::energy::energy_with_forces;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use crate::model::description::model_error::ModelError;
use crate::model::description::robot_model::Model;
use crate::scene::{Element, Warning};

/// A joint may be beyond a limit by this much [rad or m]: the error that remains after closing loops.
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
        if self.mechanism.forces.point_springs.is_empty() {
            return Ok(());
        }
        let states = body_states(&self.mechanism, state);
        match self.mechanism.forces.point_springs.iter().find(|spring| spring.is_undirected(&states)) {
            Some(spring) => {
                Err(ModelError::UndirectedSpring { spring: spring.name.clone(), rest_length: spring.rest_length })
            }
            None => Ok(()),
        }
    }

    /// The warning of joints outside limits that are not simulated.
    pub fn limit_warning(&self, state: &State) -> Option<Warning> {
        let outside = self.mechanism.limits.iter().filter_map(|limit| self.outside(limit, state));
        Warning::of_kind(outside.collect(), "joint", "joints")
    }

    /// The warning of joints whose wanted positions were outside simulated limits, and that start inside.
    pub fn moved_in_warning(&self, wanted: &State, start: &State) -> Option<Warning> {
        let limits = &self.mechanism.nonsmooth.limits;
        let moved = |limit: &JointLimit| -> Option<Warning> {
            let mut warning = self.outside(limit, wanted)?;
            let place = limit.coordinate.position;
            let moved = start.position[place] - wanted.position[place];
            let moved = if moved.abs() < 1e-3 { format!("{moved:.1e}") } else { decimals(moved) };
            warning.message += &format!(": moved by {moved} {}", self.unit(limit.coordinate));
            Some(warning)
        };
        let mut first = Warning::of_kind(limits.iter().filter_map(moved).collect(), "joint", "joints")?;
        let is_outside = |slot: usize| {
            limits.iter().any(|limit| limit.coordinate.position == slot && self.outside(limit, wanted).is_some())
        };
        let others = (0..start.position.len()).filter(|&slot| !is_outside(slot));
        let change = others.map(|slot| (start.position[slot] - wanted.position[slot]).abs()).fold(0.0, f64::max);
        if change > NEGLIGIBLE_EXCESS {
            first.message +=
                &format!("; other positions moved by up to {change:.1e} rad or m, which is the least motion");
        }
        Some(first)
    }

    /// Warning of joints that were given a velocity, although their limits leave one position.
    pub fn locked_warning(&self, wanted: &State) -> Option<Warning> {
        let limits = self.mechanism.nonsmooth.limits.iter().filter(|limit| limit.lower == limit.upper);
        let given = limits.filter_map(|limit| {
            let (velocity, unit) = (wanted.velocity[limit.coordinate.freedom], self.unit(limit.coordinate));
            let joint = Element::Joint(self.mechanism.bodies[limit.coordinate.body].joint.name.clone());
            let at = limit.lower;
            let message =
                format!("its limits leave one position, {at} {unit}, so it starts at rest, not at {velocity} {unit}/s");
            (velocity != 0.0).then(|| Warning::odd(self.path(), None, Some(joint), message))
        });
        Warning::of_kind(given.collect(), "joint", "joints")
    }

    /// That a joint is outside a limit, if it is.
    fn outside(&self, limit: &JointLimit, state: &State) -> Option<Warning> {
        let position = state.position[limit.coordinate.position];
        let excess = (limit.lower - position).max(position - limit.upper);
        let unit = self.unit(limit.coordinate);
        (excess > NEGLIGIBLE_EXCESS).then(|| {
            let joint = Element::Joint(self.mechanism.bodies[limit.coordinate.body].joint.name.clone());
            let (lower, upper) = (limit.lower, limit.upper);
            let message = format!("it starts at {position} {unit}, outside its limits {lower} to {upper} {unit}");
            Warning::odd(self.path(), None, Some(joint), message)
        })
    }

    /// The unit of a coordinate.
    fn unit(&self, coordinate: Coordinate) -> &'static str {
        let joint = &self.mechanism.bodies[coordinate.body].joint;
        joint.kind.unit(coordinate.freedom - joint.velocity_index)
    }
}
