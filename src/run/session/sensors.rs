//! Sensors as robots have them, read at one instant of a run, and their noise.
//!
//! ```text
//!     gyroscope          Rᵀ ω                       R, ω: of the link in the world
//!     accelerometer      Rᵀ (ẍ − g)                 x: the place of the sensor; at rest it reads g upwards
//!     joint effort       axis · torque or force     what the joint passes on to the child along its freedom, friction and motor included
//!     force and torque   Rᵀ f, Rᵀ τ                 of the parent on the child, about the anchor of the joint, in the child link's frame
//!     contact            Σ f                        of all contacts of a link, on it, in the world
//!     with noise         y + b + σ n                n: normal, from a seed
//! ```
//!
//! Source of the normal numbers: G. E. P. Box and M. E. Muller, A note on the generation of random normal deviates, 1958.

use crate::events::first_contacts::first_contacts;
use crate::instant::exerting::reactions::Reactions;
use crate::mechanism::description::body_state::{BodyState, WORLD};
use crate::mechanism::description::joint::JointKind;
use crate::mechanism::motion::contact_point::ContactPoint;
use crate::mechanism::motion::event::JointStatus;
use crate::mechanism::motion::kinematics::{BodyAcceleration, body_states};
use crate::mechanism::motion::state::State;
use crate::output::report::pair_names;
use crate::reduced::Reaction;
use crate::session::error::Error;
use crate::session::model::Model;
use crate::session::running::under_efforts;
use nalgebra::{Vector3, Vector6};

/// What sensors measure at one instant.
#[derive(Clone, Debug)]
pub struct Sensed {
    model: Model,
    bodies: Vec<BodyState>,
    accelerations: Vec<BodyAcceleration>,
    reactions: Vec<Reaction>,
    contacts: Vec<ContactPoint>,
}

impl Sensed {
    /// In a state, under efforts along its velocities; motors and contacts as the steps know them, or else as they follow from the state.
    pub(crate) fn new(
        model: &Model,
        state: &State,
        efforts: Option<&[f64]>,
        statuses: Option<&[JointStatus]>,
        contacts: Option<Vec<ContactPoint>>,
    ) -> Self {
        let loaded = under_efforts(model, efforts);
        let mechanism = &loaded.mechanism;
        let motors = mechanism.nonsmooth.motors.iter().map(|motor| {
            let at = motor.coordinate;
            let known = statuses.and_then(|statuses| statuses[at.body].effort);
            known.unwrap_or_else(|| motor.effort(state.time, state.position[at.position], state.velocity[at.freedom]))
        });
        let motors: Vec<f64> = motors.collect();
        let mut carried = Reactions::new(mechanism);
        carried.clock(state.time);
        carried.drive(&motors);
        carried.touch(contacts.as_deref());
        let reactions = carried.at(&state.position, &state.velocity).0.to_vec();
        Sensed {
            model: model.clone(),
            bodies: body_states(mechanism, state),
            accelerations: carried.accelerated().to_vec(),
            reactions,
            contacts: contacts.unwrap_or_else(|| first_contacts(mechanism, state)),
        }
    }

    /// An inertial measurement unit at a place on a link, in the link's frame (m): what its accelerometer and its gyroscope read, in the link's frame
    /// [m/s², rad/s].
    ///
    /// # Errors
    /// An unknown link.
    pub fn imu(&self, link: &str, place: [f64; 3]) -> Result<Vector6<f64>, Error> {
        let link = self.model.link_index(link)?;
        let description = self.model.description();
        let seen = description.link_state(&self.bodies, link);
        let body = description.links[link].body;
        let (linear, angular) = body.map_or_else(Default::default, |body| self.accelerations[body]);
        let at = body.map_or(WORLD, |body| self.bodies[body]);
        let (arm, spin) = (seen.position + seen.rotation * Vector3::from(place) - at.position, at.angular_velocity);
        let felt = linear + angular.cross(&arm) + spin.cross(&spin.cross(&arm)) - description.mechanism.gravity;
        Ok(stacked(&seen.rotation.tr_mul(&felt), &seen.rotation.tr_mul(&spin)))
    }

    /// The effort that a joint of one freedom passes on along it, with its motor, friction, spring and damper [N m or N].
    ///
    /// # Errors
    /// An unknown joint, and one that has not one freedom.
    pub fn joint_effort(&self, joint: &str) -> Result<f64, Error> {
        let body = self.body_of(joint)?;
        let joint_of = &self.model.description().mechanism.bodies[body].joint;
        let axis = self.bodies[body].rotation * joint_of.on_child.rotation.matrix().column(2);
        let Reaction { force, torque, .. } = &self.reactions[body];
        match joint_of.kind {
            JointKind::Revolute => Ok(torque.dot(&axis)),
            JointKind::Prismatic => Ok(force.dot(&axis)),
            _ => Err(Error::NotOneFreedom(joint.to_string())),
        }
    }

    /// Force and torque of the parent on the child of a joint, about its anchor, in the frame of the child link [N, N m].
    ///
    /// # Errors
    /// An unknown joint.
    pub fn wrench(&self, joint: &str) -> Result<Vector6<f64>, Error> {
        let body = self.body_of(joint)?;
        let description = self.model.description();
        let record = description.joints.iter().find(|record| record.name == joint);
        let turn = match record.and_then(|record| record.body) {
            Some(body) => {
                let child = description.joints.iter().find(|record| record.body == Some(body));
                let frame = child.map_or_else(Default::default, |child| child.child_link_in_body);
                self.bodies[body].rotation * frame.rotation.matrix()
            }
            None => self.bodies[body].rotation,
        };
        let Reaction { force, torque, .. } = &self.reactions[body];
        Ok(stacked(&turn.tr_mul(force), &turn.tr_mul(torque)))
    }

    /// The force of all contacts of a link on it, in the world (N).
    ///
    /// # Errors
    /// An unknown link.
    pub fn contact_force(&self, link: &str) -> Result<Vector3<f64>, Error> {
        self.model.link_index(link)?;
        let mut sum = Vector3::zeros();
        for point in &self.contacts {
            let (a, b) = pair_names(self.model.description(), point.pair);
            sum += (f64::from(u8::from(a == link)) - f64::from(u8::from(b == link))) * point.force;
        }
        Ok(sum)
    }

    /// Whether a link touches anything.
    ///
    /// # Errors
    /// An unknown link.
    pub fn touches(&self, link: &str) -> Result<bool, Error> {
        self.model.link_index(link)?;
        let touches = |(a, b): (&str, &str)| a == link || b == link;
        Ok(self.contacts.iter().any(|point| touches(pair_names(self.model.description(), point.pair))))
    }

    /// The body that a joint moves.
    fn body_of(&self, joint: &str) -> Result<usize, Error> {
        let description = self.model.description();
        let body = description.joint(joint).and_then(|joint| description.joints[joint].body);
        body.ok_or_else(|| self.model.unknown_joint(joint))
    }
}

fn stacked(first: &Vector3<f64>, second: &Vector3<f64>) -> Vector6<f64> {
    Vector6::new(first.x, first.y, first.z, second.x, second.y, second.z)
}

/// Noise of a sensor: a bias and normal numbers from a seed, the same on every machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Noise {
    bias: f64,
    deviation: f64,
    random: u64,
    /// The second number of a pair.
    spare: Option<f64>,
}

impl Noise {
    /// With a bias, a standard deviation and a seed.
    pub fn new(bias: f64, deviation: f64, seed: u64) -> Self {
        Noise { bias, deviation, random: seed, spare: None }
    }

    /// Adds noise to readings.
    pub fn add(&mut self, readings: &mut [f64]) {
        for reading in readings {
            *reading += self.bias + self.deviation * self.normal();
        }
    }

    /// A normal number of variance one.
    fn normal(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        let radius = (-2.0 * self.uniform().ln()).sqrt();
        let (sine, cosine) = (std::f64::consts::TAU * self.uniform()).sin_cos();
        self.spare = Some(radius * sine);
        radius * cosine
    }

    /// A number above zero, and at most one (SplitMix64).
    fn uniform(&mut self) -> f64 {
        self.random = self.random.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.random;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^= bits >> 31;
        ((bits >> 11) + 1) as f64 / (1_u64 << 53) as f64
    }
}
