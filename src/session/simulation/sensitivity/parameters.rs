//! The derivatives of a start and of all constant numbers by a parameter.
//!
//! Numbers of a scene reach the equations through the reader of files. The derivatives of masses, frames, springs and starts by such a number come
//! from eight models with other numbers, by differences of order eight: these functions are smooth and short, and the error is some 1e-13 of the
//! derivative. A start on closed loops is assembled as often, because other joints follow.

use crate::derivatives::equations::figures::Figures;
use crate::derivatives::equations::laws::Laws;
use crate::derivatives::events::parameter::{Parameter, TimeLaws, WEIGHTS};
use crate::derivatives::forward::failure::SensitivityError;
use crate::instant::holding::elements::Elements;
use crate::mechanism::description::contact::Shape;
use crate::mechanism::description::joint::{FreeRotation, Pose, rotation_from_wxyz};
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::state::State;
use crate::session::error::Error;
use crate::session::model::Model;
use crate::session::simulation::Simulation;
use nalgebra::{DVector, Matrix3, Vector3};

/// Numbers vary by this part of themselves, and up to four times of it; numbers that are zero by this much.
const WIDTH: f64 = 4e-3;

impl Simulation {
    /// The parameters of a key, with their names.
    pub(super) fn parameters(
        &self,
        key: &str,
        names: &[String],
        start: &State,
    ) -> Result<Vec<(String, Parameter)>, Error> {
        let n = names.len();
        let known = [("start.q", 0), ("start.v", 1), ("effort", 2)];
        let of = known.iter().find_map(|(word, of)| {
            let rest = key.strip_prefix(word)?;
            (rest.is_empty() && *of < 2 || rest.starts_with('.')).then_some((*of, *word, rest.trim_start_matches('.')))
        });
        let Some((of, word, joint)) = of else { return Ok(vec![(key.to_string(), self.by_number(key, start)?)]) };
        let belongs = |name: &str| {
            joint.is_empty() || name == joint || name.strip_prefix(joint).is_some_and(|axis| axis.starts_with('.'))
        };
        let freedoms: Vec<usize> = (0..n).filter(|&freedom| belongs(&names[freedom])).collect();
        if freedoms.is_empty() {
            return Err(SensitivityError::Unknown { key: key.to_string() }.into());
        }
        let mechanism = &self.model.description().mechanism;
        if mechanism.has_closures() && of < 2 {
            let of_start = |freedom: usize| {
                Ok((format!("{word}.{}", names[freedom]), self.by_start(freedom, of == 0, &names[freedom], start)?))
            };
            return freedoms.into_iter().map(of_start).collect();
        }
        let unit = |freedom: usize, which: usize| {
            let vector = |own: usize| DVector::from_fn(n, |row, _| f64::from(u8::from(own == which && row == freedom)));
            let (position, velocity, constant_effort) = (vector(0), vector(1), vector(2));
            Parameter { position, velocity, constant_effort, ..Parameter::none(n) }
        };
        Ok(freedoms.into_iter().map(|freedom| (format!("{word}.{}", names[freedom]), unit(freedom, of))).collect())
    }

    /// The parameter of a start on closures, which other joints follow: by differences of assembled starts.
    fn by_start(&self, freedom: usize, of_position: bool, name: &str, start: &State) -> Result<Parameter, Error> {
        let mechanism = &self.model.description().mechanism;
        let unknown = || SensitivityError::Unknown { key: name.to_string() };
        let joint = mechanism.body_of_freedom(freedom).map(|body| &mechanism.bodies[body].joint).ok_or_else(unknown)?;
        if joint.kind.rotation() == FreeRotation::Ball && of_position {
            let (part, advice) = ("starts of ball joints in closed loops", "name another joint of the loop");
            return Err(SensitivityError::Unsupported { part, advice }.into());
        }
        let range = if of_position { joint.position_range() } else { joint.velocity_range() };
        let own = if of_position { &start.position[range] } else { &start.velocity[range] };
        let mut parameter = Parameter::none(start.velocity.len());
        for (index, weight) in WEIGHTS.iter().enumerate() {
            for sign in [1.0, -1.0] {
                let mut numbers = own.to_vec();
                numbers[freedom - joint.velocity_index] += sign * (index + 1) as f64 * WIDTH;
                let [mut positions, mut velocities] = [self.positions.clone(), self.velocities.clone()];
                let given = if of_position { &mut positions } else { &mut velocities };
                given.retain(|(known, _)| *known != joint.name);
                given.push((joint.name.clone(), numbers));
                let state = self.model.loaded().assembled(&positions, &velocities, None)?.state;
                let weight = sign * weight / WIDTH;
                parameter.position += weight * motion_between(mechanism, start, &state);
                parameter.velocity += weight * DVector::from_column_slice(&state.velocity);
            }
        }
        Ok(parameter)
    }

    /// The parameter of a number by its key path.
    fn by_number(&self, key: &str, start: &State) -> Result<Parameter, Error> {
        let own = || key.to_string();
        let params = self.model.params()?;
        let matches = |name: &str| name == key || name.strip_suffix(key).is_some_and(|before| before.ends_with('.'));
        let mut found = params.iter().filter(|(name, _)| matches(name));
        let exact = params.iter().find(|(name, _)| name == key);
        let (_, value) = exact.or_else(|| found.next()).ok_or_else(|| SensitivityError::Unknown { key: own() })?;
        let value = value.filter(|value| value.is_finite()).ok_or_else(|| SensitivityError::NoValue { key: own() })?;
        let width = if value == 0.0 { WIDTH } else { WIDTH * value.abs() };
        let mechanism = &self.model.description().mechanism;
        let here = listed(&self.model);
        let mut parameter = Parameter { figures: vec![0.0; here.len()], ..Parameter::none(start.velocity.len()) };
        for (index, weight) in WEIGHTS.iter().enumerate() {
            for sign in [1.0, -1.0] {
                let other = value + sign * (index + 1) as f64 * width;
                let weight = sign * weight / width;
                let edge = |reason: String| SensitivityError::Edge { key: own(), value, other, reason };
                let model = self.model.with_params([(key, other)]).map_err(|error| edge(error.to_string()))?;
                let begun = model
                    .loaded()
                    .assembled(&self.positions, &self.velocities, None)
                    .map_err(|error| edge(error.to_string()))?;
                let mut state = begun.state;
                state.time = start.time;
                let other = &model.description().mechanism;
                let figures = listed(&model);
                let is_like = figures.len() == here.len()
                    && state.position.len() == start.position.len()
                    && given_shapes(other).eq(given_shapes(mechanism));
                if !is_like {
                    return Err(SensitivityError::Structure { key: own(), value }.into());
                }
                parameter.figures.iter_mut().zip(&figures).for_each(|(slope, figure)| *slope += weight * figure);
                parameter.position += weight * motion_between(mechanism, start, &state);
                parameter.velocity += weight * DVector::from_column_slice(&state.velocity);
                parameter.others.push((weight, TimeLaws::new(&Elements::new(other).motors, &other.forces)));
            }
        }
        Ok(parameter)
    }
}

/// The frames of the links that head the bodies, each in the frame of its body.
pub(super) fn frames(model: &Model) -> Vec<Pose> {
    let description = model.description();
    let of = |(index, body): (usize, &crate::mechanism::description::mechanism::Body)| {
        let head = description.links.iter().find(|link| link.body == Some(index) && link.name == body.name);
        head.map_or_else(Pose::identity, |link| link.in_body)
    };
    description.mechanism.bodies.iter().enumerate().map(of).collect()
}

/// All figures of a model and of its elements, in their order; zero for infinite bounds.
fn listed(model: &Model) -> Vec<f64> {
    let (mechanism, frames) = (&model.description().mechanism, frames(model));
    let mut all = Vec::new();
    let mut take = |value| {
        all.push(value);
        value
    };
    let _: Figures<f64> = Figures::taken(mechanism, &frames, &mut take);
    let _: Laws<f64> = Laws::taken(mechanism, &Elements::new(mechanism), &frames, &mut take);
    all
}

/// The shapes whose features do not follow their numbers here, as points that are given one by one and rims: no parameter may change these.
fn given_shapes(mechanism: &Mechanism) -> impl Iterator<Item = &Shape> {
    let shapes = mechanism.nonsmooth.colliders.iter().map(|collider| &collider.shape);
    shapes.filter(|shape| {
        matches!(
            shape,
            Shape::Cylinder { .. } | Shape::Ellipsoid { .. } | Shape::Hollow { .. } | Shape::Hull(_) | Shape::Mesh(_)
        )
    })
}

/// The motion from one state to another (n): turns of ball joints as rotation vectors about the axes of the child.
fn motion_between(mechanism: &Mechanism, from: &State, to: &State) -> DVector<f64> {
    let mut motion = DVector::zeros(mechanism.velocity_count);
    for body in &mechanism.bodies {
        let joint = &body.joint;
        let slides = joint.kind.translation_axes().len();
        let is_ball = joint.kind.rotation() == FreeRotation::Ball;
        let scalars = if is_ball { slides } else { joint.kind.velocity_count() };
        for offset in 0..scalars {
            let slot = joint.position_index + offset;
            motion[joint.velocity_index + offset] =
                (to.position[slot] - from.position[slot]) + (to.compensation[slot] - from.compensation[slot]);
        }
        if is_ball {
            let slot = joint.position_index + slides;
            let [from, to] = [from, to].map(|state| rotation_from_wxyz(&state.position[slot..slot + 4]));
            let turn = rotation_vector(&(from.transpose() * to));
            motion.rows_mut(joint.velocity_index + slides, 3).copy_from(&turn);
        }
    }
    motion
}

/// The rotation vector of a rotation by less than half a turn: `s (angle/|s|)` with `s = ½ vee(R − Rᵀ)`, zero for no rotation.
fn rotation_vector(rotation: &Matrix3<f64>) -> Vector3<f64> {
    let skew = rotation - rotation.transpose();
    let half = 0.5 * Vector3::new(skew[(2, 1)], skew[(0, 2)], skew[(1, 0)]);
    let sine = half.norm();
    if sine == 0.0 { half } else { half * (sine.atan2(0.5 * (rotation.trace() - 1.0)) / sine) }
}
