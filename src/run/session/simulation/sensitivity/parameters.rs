//! The derivatives of a start and of all constant numbers by a parameter.
//!
//! Numbers of a scene reach the equations through the reader of files. The derivatives of masses, frames, springs and starts by such a number come
//! from eight models with other numbers, by differences of order eight: these functions are smooth and short, and the error is some 1e-13 of the
//! derivative. Four models are enough where two differences are the same. Masses and inertias of links need none ([`inertial`]). A start on closed
//! loops is assembled as often, because other joints follow. Floating bodies keep the axes of their frames in their links: principal axes have no part in derivatives.

use crate::derivatives::equations::figures::{Figures, frame_entries};
use crate::derivatives::equations::laws::Laws;
use crate::derivatives::events::parameter::{Parameter, TimeLaws, WEIGHTS, WIDTH};
use crate::derivatives::forward::between::motion_between;
use crate::derivatives::forward::failure::SensitivityError;
use crate::instant::holding::elements::Elements;
use crate::mechanism::description::contact::Shape;
use crate::mechanism::description::joint::{Pose, rotation_from_wxyz, wxyz_from_rotation};
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::state::State;
use crate::model::Model as Description;
use crate::scene::{Parameter as Number, Scene, UrdfJointKind};
use crate::session::error::Error;
use crate::session::model::{Model, number_of};
use crate::session::simulation::Simulation;
use crate::session::simulation::sensitivity::inertial;
use crate::session::simulation::sensitivity::starts::Bounds;
use crate::session::simulation::sensitivity::unknown::refuse;
use crate::session::tangents::Tangents;
use nalgebra::{DMatrix, DVector, Vector3};

/// Or by these parts of it, if they cannot vary as much.
const NARROWER: [f64; 2] = [1e-2, 1e-4];
/// Frames whose entries move by less than this, while a number varies by its width, stay: a few roundings (m, or 1 for axes).
const ROUNDINGS: f64 = 8.0 * f64::EPSILON;

/// All numbers of a scene.
pub(super) struct Numbers {
    pub scene: Scene,
    pub all: Vec<Number>,
    pub bounds: Bounds,
    /// Whether the start was not moved: masses have no part in it.
    pub is_as_wanted: bool,
    /// The frames of the bodies, and all figures.
    pub frames: Vec<Pose>,
    pub figures: Vec<f64>,
}

impl Numbers {
    pub fn of(simulation: &Simulation, start: &State) -> Result<Self, Error> {
        let scene = simulation.model.scene_with_numbers()?;
        let frames = frames(&simulation.model);
        let figures = listed(&simulation.model.description().mechanism, &frames);
        let (bounds, is_as_wanted) = (simulation.bounds_of_start(), simulation.is_as_wanted(start));
        Ok(Numbers { all: scene.parameters(), scene, bounds, is_as_wanted, frames, figures })
    }
}

/// A number of a scene that varies.
pub(super) struct Varying<'v> {
    pub key: &'v str,
    pub scene: &'v Scene,
    pub number: &'v Number,
    pub value: f64,
    pub bounds: Bounds,
    /// All figures of the model itself.
    pub figures: &'v [f64],
}

impl Simulation {
    /// The parameters of a key, with their names; `numbers` are all numbers of the scene, once they were asked for.
    pub(super) fn parameters(
        &self,
        key: &str,
        names: &[String],
        start: &State,
        numbers: &mut Option<Numbers>,
    ) -> Result<Vec<(String, Parameter)>, Error> {
        let n = names.len();
        let known = [("start.q", 0), ("start.v", 1), ("effort", 2)];
        let of = known.iter().find_map(|(word, of)| {
            let rest = key.strip_prefix(word)?;
            (rest.is_empty() && *of < 2 || rest.starts_with('.')).then_some((*of, *word, rest.trim_start_matches('.')))
        });
        let Some((of, word, joint)) = of else {
            let numbers = match numbers {
                Some(known) => known,
                none => none.insert(Numbers::of(self, start)?),
            };
            return Ok(vec![(key.to_string(), self.by_number(key, numbers, start)?)]);
        };
        let belongs = |name: &str| {
            joint.is_empty() || name == joint || name.strip_prefix(joint).is_some_and(|axis| axis.starts_with('.'))
        };
        let freedoms: Vec<usize> = (0..n).filter(|&freedom| belongs(&names[freedom])).collect();
        if freedoms.is_empty() {
            return Err(SensitivityError::Unknown { key: key.to_string() }.into());
        }
        let mechanism = &self.model.description().mechanism;
        if mechanism.has_closures() && of < 2 {
            let bounds = self.bounds_of_start();
            let of_start = |freedom: usize| {
                let parameter = self.by_start(freedom, of == 0, &names[freedom], start, bounds)?;
                Ok((format!("{word}.{}", names[freedom]), parameter))
            };
            return freedoms.into_iter().map(of_start).collect();
        }
        let tangents = Tangents::at(self.model.description(), start);
        let unit = |freedom: usize, which: usize| {
            let entry = |own: usize, row: usize| f64::from(u8::from(own == which && row == freedom));
            let [mut positions, mut velocities] = [0, 1].map(|own| DMatrix::from_fn(n, 1, |row, _| entry(own, row)));
            tangents.of_state(&mut positions, &mut velocities);
            let (mut constant_effort, mut none) = (DVector::from_fn(n, |row, _| entry(2, row)), DVector::zeros(n));
            tangents.pulled_back(&mut constant_effort, &mut none);
            let (position, velocity) = (positions.column(0).into_owned(), velocities.column(0).into_owned());
            Parameter { position, velocity, constant_effort, ..Parameter::none(n) }
        };
        Ok(freedoms.into_iter().map(|freedom| (format!("{word}.{}", names[freedom]), unit(freedom, of))).collect())
    }

    /// The parameter of a number by its key path.
    fn by_number(&self, key: &str, numbers: &Numbers, start: &State) -> Result<Parameter, Error> {
        let Numbers { scene, all, bounds, is_as_wanted, frames, figures } = numbers;
        let (number, value) = number_of(scene, all, key)?;
        let description = self.model.description();
        if let Some(slopes) =
            inertial::slopes(description, frames, scene, number, figures.len()).filter(|_| *is_as_wanted)
        {
            return Ok(Parameter { figures: slopes, ..Parameter::none(start.velocity.len()) });
        }
        let number = Varying { key, scene, number, value, bounds: *bounds, figures };
        // Some numbers are close to one that they cannot be.
        let mut tried = self.by_differences(&number, start, WIDTH);
        for narrower in NARROWER {
            if let Err(Error::Sensitivity(SensitivityError::Edge { .. })) = tried {
                tried = self.by_differences(&number, start, narrower * WIDTH).or(tried);
            }
        }
        tried
    }

    /// The same from models whose numbers differ by this part of the value, and by up to four times of it.
    pub(super) fn by_differences(&self, number: &Varying, start: &State, width: f64) -> Result<Parameter, Error> {
        let value = number.value;
        let width = if value == 0.0 { width } else { width * value.abs() };
        let arms = arms(self.model.description());
        let here = Seen { figures: number.figures.to_vec(), arms, ..Seen::of(&self.model, start, start) };
        let at = |count: f64| self.seen(number, value + count * width, start, &here.figures);
        let mut pairs = vec![(2, [at(2.0)?, at(-2.0)?]), (4, [at(4.0)?, at(-4.0)?])];
        let slopes = |(count, [plus, minus]): &(usize, [Seen; 2])| {
            let per = 0.5 / (*count as f64 * width);
            plus.numbers().zip(minus.numbers()).map(move |(plus, minus)| per * (plus - minus)).collect::<Vec<f64>>()
        };
        let rounding = |(number, (one, other)): (f64, (f64, f64))| {
            (one - other).abs() <= 4.0 * f64::EPSILON * number.abs().max(one.abs() * width) / width
        };
        let (near, far) = (slopes(&pairs[0]), slopes(&pairs[1]));
        let is_straight = here.numbers().zip(near.into_iter().zip(far)).all(rounding);
        let is_timeless = pairs.iter().flat_map(|(_, pair)| pair).all(|seen| seen.laws == here.laws);
        // The wider pair of numbers that go along straight lines or parabolas has the smaller rounding error.
        let weights: &[(usize, f64)] = if is_straight && is_timeless {
            &[(4, 0.125)]
        } else {
            pairs.extend([(1, [at(1.0)?, at(-1.0)?]), (3, [at(3.0)?, at(-3.0)?])]);
            &[(1, WEIGHTS[0]), (2, WEIGHTS[1]), (3, WEIGHTS[2]), (4, WEIGHTS[3])]
        };
        let mut parameter =
            Parameter { figures: vec![0.0; here.figures.len()], ..Parameter::none(start.velocity.len()) };
        for &(count, weight) in weights {
            let Some((_, pair)) = pairs.iter().find(|(known, _)| *known == count) else { continue };
            for (sign, seen) in [1.0, -1.0].into_iter().zip(pair) {
                let weight = sign * weight / width;
                parameter.figures.iter_mut().zip(&seen.figures).for_each(|(slope, figure)| *slope += weight * figure);
                parameter.position += weight * &seen.position;
                parameter.velocity += weight * &seen.velocity;
                parameter.arms += weight * &seen.arms;
                if !is_timeless {
                    parameter.others.push((weight, seen.laws.clone()));
                }
            }
        }
        // Frames that stay have the roundings of their composition, and no derivatives.
        for frame in frame_entries(self.model.description().mechanism.bodies.len()) {
            let size = here.figures[frame.clone()].iter().fold(1.0, |size: f64, entry| size.max(entry.abs()));
            let stays = |entry: usize| {
                let mut pairs = pairs.iter().map(|(_, [plus, minus])| plus.figures[entry] - minus.figures[entry]);
                pairs.all(|change| change.abs() <= ROUNDINGS * size)
            };
            if frame.clone().all(stays) {
                parameter.figures[frame].fill(0.0);
            }
        }
        Ok(parameter)
    }

    /// The model with another number.
    fn seen(&self, of: &Varying, other: f64, start: &State, here: &[f64]) -> Result<Seen, Error> {
        let (own, value) = (|| of.key.to_string(), of.value);
        let edge = |reason: String| SensitivityError::Edge { key: own(), value, other, reason };
        let model = self.model.of_numbers(of.scene, of.number, other).map_err(|error| edge(error.to_string()))?;
        let begun = self.begun(&model, [&self.positions, &self.velocities], of.bounds);
        let mut state = begun.map_err(|error| edge(error.to_string()))?;
        state.time = start.time;
        let mut other = model.description().mechanism.clone();
        // A belt that stands, say: its number has a derivative that the equations do not know.
        refuse(&other)?;
        let arms = in_same_frames([self.model.description(), model.description()], &mut other, &mut state);
        let mechanism = &self.model.description().mechanism;
        let figures = listed(&other, &frames(&model));
        let is_like = figures.len() == here.len()
            && state.position.len() == start.position.len()
            && given_shapes(&other).eq(given_shapes(mechanism));
        if !is_like {
            return Err(SensitivityError::Structure { key: own(), value }.into());
        }
        Ok(Seen { figures, arms, ..Seen::of(&model, start, &state) })
    }
}

/// What a number of a model decides.
struct Seen {
    /// All figures.
    figures: Vec<f64>,
    /// The start, as a motion from that of the model itself, and its velocities.
    position: DVector<f64>,
    velocity: DVector<f64>,
    /// The origins of the child links of floating joints in their bodies.
    arms: DVector<f64>,
    laws: TimeLaws,
}

impl Seen {
    /// A model and its start, without its figures and arms.
    fn of(model: &Model, from: &State, start: &State) -> Self {
        let mechanism = &model.description().mechanism;
        Seen {
            figures: Vec::new(),
            position: motion_between(mechanism, from, start),
            velocity: DVector::from_column_slice(&start.velocity),
            arms: DVector::zeros(start.velocity.len()),
            laws: TimeLaws::new(&Elements::new(mechanism).motors, &mechanism.forces),
        }
    }

    fn numbers(&self) -> impl Iterator<Item = f64> + '_ {
        self.figures.iter().chain(&self.position).chain(&self.velocity).chain(&self.arms).copied()
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

/// The floating joints of a model: their bodies, the first of their entries among the velocities and positions, and their links in their bodies.
fn floating(description: &Description) -> impl Iterator<Item = (usize, [usize; 2], Pose)> + '_ {
    description.joints.iter().filter(|record| record.kind == UrdfJointKind::Floating).filter_map(|record| {
        let body = record.body?;
        let joint = &description.mechanism.bodies[body].joint;
        Some((body, [joint.velocity_index, joint.position_index], record.child_link_in_body))
    })
}

/// The origins of the child links of floating joints in the frames of their bodies.
fn arms(description: &Description) -> DVector<f64> {
    let mut arms = DVector::zeros(description.mechanism.velocity_count);
    for (_, [first, _], link) in floating(description) {
        arms.rows_mut(first, 3).copy_from(&link.translation.vector);
    }
    arms
}

/// Turns the frames of the floating bodies of another model, and its state, to where a model has them in the links: they are at the centres of
/// mass of the other model, but principal axes turn with its numbers, and jump where moments are equal. Returns the arms of the other model.
///
/// With the link at `L₀` and at `L` in the bodies:  Q = R(L) R(L₀)ᵀ,  R ← R Q,  w ← Qᵀ w.
fn in_same_frames(of: [&Description; 2], mechanism: &mut Mechanism, state: &mut State) -> DVector<f64> {
    let mut arms = arms(of[1]);
    for ((body, [first, slot], link), (_, _, other)) in floating(of[0]).zip(floating(of[1])) {
        if link.rotation == other.rotation {
            continue;
        }
        let turn = other.rotation * link.rotation.inverse();
        let Some(own) = mechanism.bodies.get_mut(body) else { continue };
        own.joint.on_child *= turn;
        let rotation = rotation_from_wxyz(&state.position[slot + 3..slot + 7]) * turn.matrix();
        state.position[slot + 3..slot + 7].copy_from_slice(&wxyz_from_rotation(&rotation));
        let spin = Vector3::from_column_slice(&state.velocity[first + 3..first + 6]);
        state.velocity[first + 3..first + 6].copy_from_slice((turn.inverse() * spin).as_slice());
        let arm = turn.inverse() * other.translation.vector;
        arms.rows_mut(first, 3).copy_from(&arm);
    }
    arms
}

/// All figures of a mechanism and of its elements, in their order; zero for infinite bounds.
fn listed(mechanism: &Mechanism, frames: &[Pose]) -> Vec<f64> {
    let mut all = Vec::new();
    let mut take = |value| {
        all.push(value);
        value
    };
    let _: Figures<f64> = Figures::taken(mechanism, frames, &mut take);
    let _: Laws<f64> = Laws::taken(mechanism, &Elements::new(mechanism), frames, &mut take);
    all
}

/// The shapes whose features do not follow their numbers here, as points that are given one by one: no parameter may change these.
fn given_shapes(mechanism: &Mechanism) -> impl Iterator<Item = &Shape> {
    let shapes = mechanism.nonsmooth.colliders.iter().map(|collider| &collider.shape);
    shapes.filter(|shape| {
        matches!(shape, Shape::Ellipsoid { .. } | Shape::Hollow { .. } | Shape::Hull(_) | Shape::Mesh(_))
    })
}
