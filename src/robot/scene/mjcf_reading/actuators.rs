//! Actuators of MJCF on joints and on fixed tendons, as motors.
//!
//! The force of an actuator with the gear G, the gain g, the biases b and the control u is
//!
//! ```text
//!     f = g u + b₀ + b₁ G q + b₂ G q̇        τ = G f = kp (r − q) − kd q̇,   kp = −b₁ G²,  kd = −b₂ G²,  kp r = G (g u + b₀)
//! ```
//!
//! in a joint at q [rad or m] with the velocity q̇, τ in N m or N. A `motor` has g = 1, a `position` g = kp, b₁ = −kp, b₂ = −kv, a `velocity` g = kv,
//! b₂ = −kv, a `cylinder` the area of its piston as gain, a `damper` b₂ = −kv u and no gain. Where an actuator has dynamics of its own, its activation
//! ([`super::activations`]) stands in the place of u. On a fixed tendon of the length `Σ c_i q_i` it drives each of its joints with the gear `c_i G`, or,
//! where it depends on a length whose joints follow one of them, this one alone. The damping of a `dampratio` is in [`super::tuning`].

use crate::scene::error::SceneError;
use crate::scene::mjcf_reading::activations::{Activation, Drive, Follows};
use crate::scene::mjcf_reading::parts::{Joint, Motor};
use crate::scene::mjcf_reading::reader::Reader;
use crate::scene::mjcf_reading::tree::Element;
use crate::scene::robot::UrdfJointKind;

impl Reader<'_> {
    /// All actuators of an `<actuator>`.
    pub fn actuators(&mut self, actuators: &Element) -> Result<(), SceneError> {
        for given in &actuators.children {
            let mut actuator = self.defaults.applied(given, None);
            // All kinds have the defaults of the general one.
            if given.name != "general" {
                let general = Element { name: "general".to_string(), ..actuator.clone() };
                actuator.attributes = self.defaults.applied(&general, None).attributes;
            }
            let number = self.controls;
            self.controls += 1;
            let motors = self.actuator(&actuator)?;
            self.motors.extend(motors.into_iter().map(|motor| (number, motor)));
        }
        Ok(())
    }

    fn actuator(&mut self, actuator: &Element) -> Result<Vec<Motor>, SceneError> {
        let number = |name: &str, otherwise: f64| Ok::<f64, SceneError>(actuator.number(name)?.unwrap_or(otherwise));
        let first = |name: &str, count: usize, otherwise: [f64; 3]| -> Result<[f64; 3], SceneError> {
            let given = actuator.list(name, 1, 10)?.unwrap_or_default();
            Ok([0, 1, 2]
                .map(|index| if index < count { given.get(index).copied().unwrap_or(otherwise[index]) } else { 0.0 }))
        };
        let (mut dynamics, mut brake) = ("none", 0.0);
        let (gain, bias) = match actuator.name.as_str() {
            "motor" => (1.0, [0.0; 3]),
            "damper" => {
                brake = number("kv", 1.0)?;
                (0.0, [0.0; 3])
            }
            "cylinder" => {
                dynamics = "filter";
                let diameter = actuator.number("diameter")?;
                let of_diameter = diameter.map(|diameter| std::f64::consts::FRAC_PI_4 * diameter * diameter);
                (of_diameter.map_or_else(|| number("area", 1.0), Ok)?, first("bias", 3, [0.0; 3])?)
            }
            "intvelocity" => {
                dynamics = "integrator";
                let kp = number("kp", 1.0)?;
                (kp, [0.0, -kp, -number("kv", 0.0)?])
            }
            "position" => {
                let kp = number("kp", 1.0)?;
                if number("timeconst", 0.0)? > 0.0 {
                    dynamics = "filterexact";
                }
                // A damping ratio stands where the damping stands, with the other sign.
                let ratio = number("dampratio", 0.0)?;
                (kp, [0.0, -kp, if ratio > 0.0 { ratio } else { -number("kv", 0.0)? }])
            }
            "velocity" => {
                let kv = number("kv", 1.0)?;
                (kv, [0.0, 0.0, -kv])
            }
            "general" => {
                let plain = |name: &str, plain: &[&str]| actuator.text(name).is_none_or(|given| plain.contains(&given));
                dynamics = actuator.text("dyntype").unwrap_or("none");
                if !plain("gaintype", &["fixed"]) || !plain("biastype", &["none", "affine"]) {
                    // Its activation is counted all the same.
                    if !matches!(self.dynamics(actuator, dynamics)?, Dynamics::Unread) {
                        let message = "actuators with a gaintype other than \"fixed\", or a biastype other than \"affine\", are not simulated";
                        self.not_simulated(actuator, message.to_string());
                    }
                    return Ok(Vec::new());
                }
                let is_affine = actuator.text("biastype") == Some("affine");
                let bias = if is_affine { first("biasprm", 3, [0.0; 3])? } else { [0.0; 3] };
                (first("gainprm", 1, [1.0, 0.0, 0.0])?[0], bias)
            }
            "muscle" => {
                dynamics = "muscle";
                (1.0, [0.0; 3])
            }
            other => {
                self.not_simulated(actuator, format!("actuators <{other}> are not simulated"));
                return Ok(Vec::new());
            }
        };
        let activation = match self.dynamics(actuator, dynamics)? {
            Dynamics::Absent => None,
            Dynamics::Own(activation) => Some(activation),
            Dynamics::Unread => return Ok(Vec::new()),
        };
        let gear = actuator.list("gear", 1, 6)?.map_or(1.0, |gear| gear[0]);
        let pulled = self.pulled(actuator);
        let [constant, per_position, mut per_rate] = bias;
        if per_rate > 0.0 && per_position < 0.0 && gain == -per_position {
            let joints: Vec<_> = pulled.iter().map(|(joint, own)| (joint.as_str(), gear * own)).collect();
            per_rate = -self.damping_of_ratio(actuator, gain, per_rate, &joints);
        }
        let driven = self.driven(actuator, pulled, per_position != 0.0 || per_rate != 0.0 || brake != 0.0)?;
        let bounded = |range: &str, flag: &str| -> Result<Option<(f64, f64)>, SceneError> {
            let given = actuator.list(range, 2, 2)?;
            let holds = actuator.flag(flag).unwrap_or(given.is_some() && self.auto_limits);
            Ok(given.filter(|_| holds).map(|range| (range[0], range[1])))
        };
        let (forces, mut control_range) =
            (bounded("forcerange", "forcelimited")?, bounded("ctrlrange", "ctrllimited")?);
        if let (Some(inherited), [only]) =
            (actuator.number("inheritrange")?.filter(|part| *part > 0.0), driven.as_slice())
        {
            control_range = self.range_of_joint(only).map(|(lower, upper)| {
                let (middle, half) = (0.5 * (lower + upper), 0.5 * (upper - lower));
                (middle - inherited * half, middle + inherited * half)
            });
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

    /// The dynamics `kind` of an actuator.
    pub fn dynamics(&mut self, actuator: &Element, kind: &str) -> Result<Dynamics, SceneError> {
        let follows = match kind {
            "none" => return Ok(Dynamics::Absent),
            "integrator" => Follows::Integrator,
            "filter" | "filterexact" => {
                let given = actuator.list("dynprm", 1, 10)?.and_then(|given| given.first().copied());
                let time = match actuator.number("timeconst")? {
                    Some(time) => time,
                    None => given.unwrap_or(1.0),
                };
                Follows::Filter(time)
            }
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
        let given = actuator.list("actrange", 2, 2)?;
        let holds = actuator.flag("actlimited").unwrap_or(given.is_some() && self.auto_limits);
        let range = given.filter(|_| holds).map(|range| (range[0], range[1]));
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
        let taken = |one: &Driven| self.motors.iter().any(|(_, motor)| motor.joint == one.joint);
        if let Some(Driven { joint, .. }) = driven.iter().find(|one| taken(one)) {
            self.not_simulated(actuator, format!("a second actuator on joint {joint:?} is not simulated"));
            return Ok(Vec::new());
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
