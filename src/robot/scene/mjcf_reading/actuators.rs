//! Actuators of MJCF on joints and on fixed tendons, as motors.
//!
//! The force of an actuator with the gear G, the gain g, the biases b and the control u is
//!
//! ```text
//!     f = g u + b₀ + b₁ G q + b₂ G q̇        τ = G f = kp (r − q) − kd q̇,   kp = −b₁ G²,  kd = −b₂ G²,  kp r = G (g u + b₀)
//! ```
//!
//! in a joint at q [rad or m] with the velocity q̇, τ in N m or N. The numbers of each kind of actuator are in [`super::actuator_kinds`]; one whose gain
//! depends on the velocity, as that of a `damper`, has b₂ = g₂ u. Where an actuator has dynamics of its own, its activation ([`super::activations`]) stands
//! in the place of u. On a fixed tendon of the length `Σ c_i q_i` it drives each of its joints with the gear `c_i G`, or, where it depends on a length
//! whose joints follow one of them, this one alone. The damping of a `dampratio` is in [`super::tuning`].

use crate::scene::error::SceneError;
use crate::scene::mjcf_reading::activations::{Activation, Drive, Follows};
use crate::scene::mjcf_reading::actuator_kinds::{ActuatorLaw, is_actuator};
use crate::scene::mjcf_reading::parts::{Joint, Motor};
use crate::scene::mjcf_reading::reader::Reader;
use crate::scene::mjcf_reading::tree::Element;
use crate::scene::robot::UrdfJointKind;

impl Reader<'_> {
    /// All actuators of an `<actuator>`.
    pub fn actuators(&mut self, actuators: &Element) -> Result<(), SceneError> {
        for given in &actuators.children {
            let (actuator, law) = self.defaults.actuator(given)?;
            let number = self.controls;
            self.controls += 1;
            let motors = self.actuator(&actuator, &law)?;
            match motors.iter().find(|motor| !self.joins(motor)) {
                Some(Motor { joint, .. }) => {
                    let message = "with a range of its force or dynamics of its own on either is not simulated";
                    self.not_simulated(&actuator, format!("a second actuator on joint {joint:?} {message}"));
                }
                None => self.motors.extend(motors.into_iter().map(|motor| (number, motor))),
            }
        }
        Ok(())
    }

    fn actuator(&mut self, actuator: &Element, law: &ActuatorLaw) -> Result<Vec<Motor>, SceneError> {
        if !is_actuator(&actuator.name) {
            self.unknown(actuator, "actuator");
            return Ok(Vec::new());
        }
        let mut activation = match self.dynamics(actuator, law)? {
            Dynamics::Absent => None,
            Dynamics::Own(activation) => Some(activation),
            Dynamics::Unread => return Ok(Vec::new()),
        };
        let forces = self.bounds(actuator, "forcerange", "forcelimited")?;
        // The range of a damper bounds its control, whatever the compiler infers.
        let mut control_range = match actuator.name.as_str() {
            "damper" => actuator.list("ctrlrange", 2, 2)?.map(|range| (range[0], range[1])),
            _ => self.bounds(actuator, "ctrlrange", "ctrllimited")?,
        };
        let [gain, per_length, per_velocity] = law.gain;
        let brake = match law.gain_kind.as_str() {
            "fixed" => 0.0,
            // Its control has one sign, so that it never drives on.
            "affine"
                if activation.is_none()
                    && per_length == 0.0
                    && per_velocity <= 0.0
                    && control_range.is_some_and(|(lower, _)| lower >= 0.0) =>
            {
                -per_velocity
            }
            _ => return Ok(self.unread_law(actuator)),
        };
        let bias = match law.bias_kind.as_str() {
            "none" => [0.0; 3],
            "affine" => law.bias,
            _ => return Ok(self.unread_law(actuator)),
        };
        let gear = actuator.list("gear", 1, 6)?.map_or(1.0, |gear| gear[0]);
        let pulled = self.pulled(actuator);
        let [constant, per_position, mut per_rate] = bias;
        if per_rate > 0.0 && per_position < 0.0 && gain == -per_position {
            let joints: Vec<_> = pulled.iter().map(|(joint, own)| (joint.as_str(), gear * own)).collect();
            per_rate = -self.damping_of_ratio(actuator, gain, per_rate, &joints);
        }
        let driven = self.driven(actuator, pulled, per_position != 0.0 || per_rate != 0.0 || brake != 0.0)?;
        if let (true, [only]) = (law.inherited_range > 0.0, driven.as_slice()) {
            let inherited = self.range_of_joint(only).map(|(lower, upper)| {
                let (middle, half) = (0.5 * (lower + upper), 0.5 * (upper - lower) * law.inherited_range);
                (middle - half, middle + half)
            });
            // The control follows the joint, or its integral does: that one has the range of the joint.
            match activation.as_mut().filter(|own| matches!(own.follows, Follows::Integrator)) {
                Some(integral) => integral.range = inherited,
                None => control_range = inherited,
            }
        }
        if let Some((lower, upper)) = forces.filter(|(lower, upper)| -lower != *upper) {
            self.odd(
                actuator,
                format!("its forcerange {lower} to {upper} is read as the larger one in both directions"),
            );
        }
        if per_position > 0.0 || per_rate > 0.0 {
            self.not_simulated(actuator, "actuators that push away from rest are not simulated".to_string());
            return Ok(Vec::new());
        }
        let integrates =
            activation.as_ref().is_some_and(|own| own.range.is_some() && matches!(own.follows, Follows::Integrator));
        if integrates && per_position < 0.0 && per_rate < 0.0 && forces.is_some() {
            self.odd(actuator, "its forcerange does not bound the part of its activation".to_string());
        }
        if !self.clamps_controls {
            match brake > 0.0 {
                true => self.odd(actuator, "the control of a damper stays in its ctrlrange all the same".to_string()),
                false => control_range = None,
            }
        }
        let motor = |Driven { joint, reference, coefficient }: Driven| {
            let gear = gear * coefficient;
            Motor {
                joint,
                drive: Drive {
                    kp: -per_position * gear * gear,
                    kd: -per_rate * gear * gear,
                    // Positions are counted from the reference of the joint here.
                    constant: gear * (constant + per_position * gear * reference),
                    gain: gear * gain,
                },
                brake: brake * gear * gear,
                control: 0.0,
                control_range,
                activation: activation.clone(),
                max_effort: forces.map(|(lower, upper)| gear.abs() * lower.abs().max(upper.abs())),
            }
        };
        Ok(driven.into_iter().map(motor).collect())
    }

    /// Whether the motors of a joint are one motor together: without bounds of their own, and one activation at most.
    fn joins(&self, motor: &Motor) -> bool {
        let others = || self.motors.iter().map(|(_, other)| other).filter(|other| other.joint == motor.joint);
        let all = || others().chain([motor]);
        let activations = all().filter(|one| one.activation.is_some()).count();
        others().next().is_none() || (activations <= 1 && all().all(|one| one.max_effort.is_none()))
    }

    /// Warns of an actuator whose law has no counterpart: no motors.
    fn unread_law(&mut self, actuator: &Element) -> Vec<Motor> {
        let message =
            "actuators whose gain is not fixed, but for dampers, or whose bias is not affine, are not simulated";
        self.not_simulated(actuator, message.to_string());
        Vec::new()
    }

    /// The dynamics of an actuator.
    fn dynamics(&mut self, actuator: &Element, law: &ActuatorLaw) -> Result<Dynamics, SceneError> {
        let follows = match law.dynamics.as_str() {
            "none" => return Ok(Dynamics::Absent),
            "integrator" => Follows::Integrator,
            "filter" | "filterexact" => Follows::Filter(law.time),
            // It has no activation.
            "adhesion" => return Ok(Dynamics::Absent),
            other => {
                let dimension = actuator.number("actdim")?.filter(|own| *own > 0.0);
                self.activations += dimension.map_or(1, |own| own as usize);
                let message = format!("actuators with the dynamics {other:?} are not simulated");
                self.not_simulated(actuator, message);
                return Ok(Dynamics::Unread);
            }
        };
        let number = self.activations;
        self.activations += 1;
        // A filter without a time constant follows at once.
        if matches!(follows, Follows::Filter(time) if time <= 0.0) {
            return Ok(Dynamics::Absent);
        }
        let range = self.bounds(actuator, "actrange", "actlimited")?;
        if range.is_some() && matches!(follows, Follows::Filter(_)) {
            self.odd(actuator, "actrange of a filter bounds its activation at the start alone".to_string());
        }
        Ok(Dynamics::Own(Activation { number, follows, start: 0.0, range }))
    }

    /// The joints in the length of an actuator with their coefficients: its own, or those of its fixed tendon.
    fn pulled(&self, actuator: &Element) -> Vec<(String, f64)> {
        match (actuator.text("joint").or_else(|| actuator.text("jointinparent")), actuator.text("tendon")) {
            (Some(joint), _) => vec![(joint.to_string(), 1.0)],
            (None, Some(tendon)) => self.fixed_tendons.get(tendon).cloned().unwrap_or_default(),
            (None, None) => Vec::new(),
        }
    }

    /// The joints that an actuator drives; an empty list, with a warning, if it cannot be simulated. One that depends on its length drives one joint,
    /// which all others in its length follow.
    fn driven(
        &mut self,
        actuator: &Element,
        pulled: Vec<(String, f64)>,
        is_sprung: bool,
    ) -> Result<Vec<Driven>, SceneError> {
        let mut driven = Vec::with_capacity(pulled.len());
        for (joint, coefficient) in pulled {
            let Some(&(_, reference)) = self.references.get(&joint) else {
                if self.free_names.contains(&joint) {
                    self.not_simulated(actuator, "actuators on free joints are not simulated".to_string());
                    return Ok(Vec::new());
                }
                return Err(actuator.error("joint", "there is no such joint".to_string()));
            };
            if self.joint_of(&joint).is_some_and(|joint| joint.kind == UrdfJointKind::Spherical) {
                self.not_simulated(actuator, "actuators on ball joints are not simulated".to_string());
                return Ok(Vec::new());
            }
            driven.push(Driven { joint, reference, coefficient });
        }
        if driven.is_empty() {
            let message = "actuators that drive neither a joint nor a fixed tendon are not simulated";
            self.not_simulated(actuator, message.to_string());
        }
        if is_sprung && driven.len() > 1 {
            driven = self.led(&driven).into_iter().collect();
            if driven.is_empty() {
                let message = "actuators that depend on the length of a tendon of independent joints are not simulated";
                self.not_simulated(actuator, message.to_string());
            }
        }
        Ok(driven)
    }

    /// The one joint that all joints of a length follow, with its coefficient in the length: `Σ c_i (m_i q + o_i + r_i) = C (q + r)`.
    fn led(&self, driven: &[Driven]) -> Option<Driven> {
        let (mut leader, mut sum, mut constant) = (None, 0.0, 0.0);
        for Driven { joint, reference, coefficient } in driven {
            let (own, multiplier, offset) = match &self.joint_of(joint)?.mimic {
                Some((leader, multiplier, offset)) => (leader.clone(), *multiplier, *offset),
                None => (joint.clone(), 1.0, 0.0),
            };
            if leader.get_or_insert(own.clone()) != &own {
                return None;
            }
            sum += coefficient * multiplier;
            constant += coefficient * (offset + reference);
        }
        let joint = leader.filter(|_| sum != 0.0)?;
        Some(Driven { joint, reference: constant / sum, coefficient: sum })
    }

    /// The joint of a name.
    fn joint_of(&self, name: &str) -> Option<&Joint> {
        let (tree, _) = self.references.get(name)?;
        self.trees[*tree].joints.iter().filter_map(|(_, joint)| joint.as_ref()).find(|joint| joint.name == name)
    }

    /// The range of a joint that is driven alone, counted as in the file.
    fn range_of_joint(&self, driven: &Driven) -> Option<(f64, f64)> {
        let (lower, upper) = self.joint_of(&driven.joint)?.limit?;
        Some((lower + driven.reference, upper + driven.reference))
    }
}

/// The dynamics of an actuator.
pub(crate) enum Dynamics {
    /// It follows its control at once.
    Absent,
    Own(Activation),
    /// It has no counterpart, as a warning says.
    Unread,
}

/// A joint that an actuator drives: the position at which it is counted as zero here, and its coefficient in the length of the actuator.
struct Driven {
    joint: String,
    reference: f64,
    coefficient: f64,
}
