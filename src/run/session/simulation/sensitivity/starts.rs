//! How the start of a run follows its numbers, where other joints follow them.
//!
//! ```text
//!     wanted start of θ ± k w ─ closures ─▶ start        ∂start/∂θ by differences of order eight
//! ```
//!
//! Limits and shapes have no part in it, unless they moved the start of the run itself: a start between narrow limits varies by less than the width of
//! differences, which would be pushed back.

use crate::derivatives::events::parameter::{Parameter, WEIGHTS, WIDTH};
use crate::derivatives::forward::between::motion_between;
use crate::derivatives::forward::failure::SensitivityError;
use crate::mechanism::description::joint::{FreeRotation, rotation_from_wxyz, wxyz_from_rotation};
use crate::mechanism::motion::state::State;
use crate::session::error::Error;
use crate::session::model::Model;
use crate::session::simulation::Simulation;
use nalgebra::{DVector, Rotation3, Vector3};

/// Starts this close to each other are the same (rad or m, per s): closing loops leaves as much.
const SAME: f64 = 1e-10;

/// Starts this close to each other differ by a few roundings (rad or m, per s; or by this part of them).
const ROUNDINGS: f64 = 4.0 * f64::EPSILON;

/// Whether limits and other shapes moved a start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Bounds {
    Moved,
    Kept,
}

/// Positions and velocities of joints, by name.
type Given<'g> = [&'g [(String, Vec<f64>)]; 2];

impl Simulation {
    /// Whether limits and other shapes moved the start of the run.
    pub(super) fn bounds_of_start(&self) -> Bounds {
        let given: Given = [&self.positions, &self.velocities];
        let same = |one: &[f64], other: &[f64]| one.iter().zip(other).all(|(one, other)| (one - other).abs() <= SAME);
        match [Bounds::Moved, Bounds::Kept].map(|bounds| self.begun(&self.model, given, bounds)) {
            [Ok(one), Ok(other)] if same(&one.position, &other.position) && same(&one.velocity, &other.velocity) => {
                Bounds::Kept
            }
            _ => Bounds::Moved,
        }
    }

    /// Whether closures, limits and shapes left the start where it was wanted.
    pub(super) fn is_as_wanted(&self, start: &State) -> bool {
        let same = |one: &[f64], other: &[f64]| {
            one.iter().zip(other).all(|(one, other)| (one - other).abs() <= ROUNDINGS * other.abs().max(1.0))
        };
        let wanted = self.model.loaded().given(0.0, &self.positions, &self.velocities, None);
        wanted
            .is_ok_and(|(wanted, _)| same(&start.position, &wanted.position) && same(&start.velocity, &wanted.velocity))
    }

    /// The start of a model.
    pub(super) fn begun(&self, model: &Model, [positions, velocities]: Given, bounds: Bounds) -> Result<State, Error> {
        match bounds {
            Bounds::Moved => Ok(model.loaded().assembled(positions, velocities, None)?.state),
            Bounds::Kept => model.loaded().assembled_on_closures(positions, velocities),
        }
    }

    /// The parameter of a start on closures, which other joints follow: by differences of assembled starts.
    pub(super) fn by_start(
        &self,
        freedom: usize,
        of_position: bool,
        name: &str,
        start: &State,
        bounds: Bounds,
    ) -> Result<Parameter, Error> {
        let mechanism = &self.model.description().mechanism;
        let unknown = || SensitivityError::Unknown { key: name.to_string() };
        let joint = mechanism.body_of_freedom(freedom).map(|body| &mechanism.bodies[body].joint).ok_or_else(unknown)?;
        let (q, v) = self.model.flat(start);
        let place = self.model.coordinates().joint(&joint.name).ok_or_else(unknown)?;
        let entry = freedom - joint.velocity_index;
        let slides = joint.kind.translation_axes().len();
        let mut parameter = Parameter::none(start.velocity.len());
        for (index, weight) in WEIGHTS.iter().enumerate() {
            for sign in [1.0, -1.0] {
                let by = sign * (index + 1) as f64 * WIDTH;
                let mut numbers = if of_position { q[place.q.clone()].to_vec() } else { v[place.v.clone()].to_vec() };
                if of_position && joint.kind.rotation() == FreeRotation::Ball && entry >= slides {
                    turn_about(entry - slides, by, &mut numbers[slides..]);
                } else {
                    numbers[entry] += by;
                }
                let [mut positions, mut velocities] = [self.positions.clone(), self.velocities.clone()];
                let given = if of_position { &mut positions } else { &mut velocities };
                given.retain(|(known, _)| *known != joint.name);
                given.push((joint.name.clone(), numbers));
                let state = self.begun(&self.model, [&positions, &velocities], bounds)?;
                let weight = sign * weight / WIDTH;
                parameter.position += weight * motion_between(mechanism, start, &state);
                parameter.velocity += weight * DVector::from_column_slice(&state.velocity);
            }
        }
        Ok(parameter)
    }
}

/// Turns a quaternion w, x, y, z about an axis of the parent by an angle (rad).
fn turn_about(axis: usize, angle: f64, quaternion: &mut [f64]) {
    let mut by = Vector3::zeros();
    by[axis] = angle;
    let rotation = Rotation3::new(by).matrix() * rotation_from_wxyz(quaternion);
    quaternion.copy_from_slice(&wxyz_from_rotation(&rotation));
}
