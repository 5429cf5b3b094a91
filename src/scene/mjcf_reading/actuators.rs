//! Actuators of MJCF on joints and on fixed tendons, as motors.
//!
//! The force of an actuator with the gear G, the gain g, the biases b and the control u is
//!
//! ```text
//!     f = g u + b₀ + b₁ G q + b₂ G q̇        τ = G f = kp (r − q) − kd q̇,   kp = −b₁ G²,  kd = −b₂ G²,  kp r = G (g u + b₀)
//! ```
//!
//! in a joint at q [rad or m] with the velocity q̇, τ in N m or N. A `motor` has g = 1, a `position` g = kp, b₁ = −kp, b₂ = −kv, a `velocity` g = kv,
//! b₂ = −kv. On a fixed tendon of the length `Σ c_i q_i` it drives each of its joints with the gear `c_i G`.

use crate::scene::error::SceneError;
use crate::scene::mjcf_reading::parts::Motor;
use crate::scene::mjcf_reading::reader::Reader;
use crate::scene::mjcf_reading::tree::Element;
use crate::scene::robot::UrdfJointKind;

impl Reader<'_> {
    /// All actuators of an `<actuator>`.
    pub fn actuators(&mut self, actuators: &Element) -> Result<(), SceneError> {
        for given in &actuators.children {
            let mut actuator = self.defaults.applied(given, None);
            // Defaults of all kinds are those of the general one.
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
        let (gain, bias) = match actuator.name.as_str() {
            "motor" => (1.0, [0.0; 3]),
            "position" => {
                let kp = number("kp", 1.0)?;
                if actuator.text("dampratio").is_some() || actuator.text("timeconst").is_some() {
                    self.odd(actuator, "its dampratio and timeconst are not read; give kv".to_string());
                }
                (kp, [0.0, -kp, -number("kv", 0.0)?])
            }
            "velocity" => {
                let kv = number("kv", 1.0)?;
                (kv, [0.0, 0.0, -kv])
            }
            "general" => {
                let plain = |name: &str, plain: &[&str]| actuator.text(name).is_none_or(|given| plain.contains(&given));
                if !plain("dyntype", &["none"])
                    || !plain("gaintype", &["fixed"])
                    || !plain("biastype", &["none", "affine"])
                {
                    self.not_simulated(actuator, "actuators with dynamics of their own are not simulated".to_string());
                    return Ok(Vec::new());
                }
                let is_affine = actuator.text("biastype") == Some("affine");
                let bias = if is_affine { first("biasprm", 3, [0.0; 3])? } else { [0.0; 3] };
                (first("gainprm", 1, [1.0, 0.0, 0.0])?[0], bias)
            }
            other => {
                self.not_simulated(actuator, format!("actuators <{other}> are not simulated"));
                return Ok(Vec::new());
            }
        };
        let driven = self.driven(actuator, bias[1] != 0.0 || bias[2] != 0.0)?;
        let gear = actuator.list("gear", 1, 6)?.map_or(1.0, |gear| gear[0]);
        let bounded = |range: &str, flag: &str| -> Result<Option<(f64, f64)>, SceneError> {
            let given = actuator.list(range, 2, 2)?;
            let holds = actuator.flag(flag).unwrap_or(given.is_some() && self.auto_limits);
            Ok(given.filter(|_| holds).map(|range| (range[0], range[1])))
        };
        let (forces, control_range) = (bounded("forcerange", "forcelimited")?, bounded("ctrlrange", "ctrllimited")?);
        if let Some((lower, upper)) = forces.filter(|(lower, upper)| -lower != *upper) {
            self.odd(
                actuator,
                format!("its forcerange {lower} to {upper} is read as the larger one in both directions"),
            );
        }
        let [constant, per_position, per_rate] = bias;
        if per_position > 0.0 || per_rate > 0.0 {
            self.not_simulated(actuator, "actuators that push away from rest are not simulated".to_string());
            return Ok(Vec::new());
        }
        let motor = |(joint, reference, coefficient): (String, f64, f64)| {
            let gear = gear * coefficient;
            Motor {
                joint,
                kp: -per_position * gear * gear,
                kd: -per_rate * gear * gear,
                // Positions are counted from the reference of the joint here.
                constant: gear * (constant + per_position * gear * reference),
                per_control: gear * gain,
                control: 0.0,
                control_range,
                max_effort: forces.map(|(lower, upper)| gear.abs() * lower.abs().max(upper.abs())),
            }
        };
        Ok(driven.into_iter().map(motor).collect())
    }

    /// The joints that an actuator drives, with their references and their coefficients in its length; none, with a warning, if it cannot be simulated.
    fn driven(&mut self, actuator: &Element, is_sprung: bool) -> Result<Vec<(String, f64, f64)>, SceneError> {
        let joints = match (actuator.text("joint").or_else(|| actuator.text("jointinparent")), actuator.text("tendon"))
        {
            (Some(joint), _) => vec![(joint.to_string(), 1.0)],
            (None, Some(tendon)) => self.fixed_tendons.get(tendon).cloned().unwrap_or_default(),
            (None, None) => Vec::new(),
        };
        let problem = match joints.len() {
            0 => "actuators that drive neither a joint nor a fixed tendon are not simulated",
            1 => "",
            _ if is_sprung => "actuators of fixed tendons that depend on their length are not simulated",
            _ => "",
        };
        if !problem.is_empty() {
            self.not_simulated(actuator, problem.to_string());
            return Ok(Vec::new());
        }
        let mut driven = Vec::with_capacity(joints.len());
        for (joint, coefficient) in joints {
            let Some(&(tree, reference)) = self.references.get(&joint) else {
                if self.free_names.contains(&joint) {
                    self.not_simulated(actuator, "actuators on free joints are not simulated".to_string());
                    return Ok(Vec::new());
                }
                return Err(actuator.error("joint", "there is no such joint".to_string()));
            };
            let joints = self.trees[tree].joints.iter().filter_map(|(_, joint)| joint.as_ref());
            if joints.into_iter().any(|own| own.name == joint && own.kind == UrdfJointKind::Spherical) {
                self.not_simulated(actuator, "actuators on ball joints are not simulated".to_string());
                return Ok(Vec::new());
            }
            if self.motors.iter().any(|(_, motor)| motor.joint == joint) {
                self.not_simulated(actuator, format!("a second actuator on joint {joint:?} is not simulated"));
                return Ok(Vec::new());
            }
            driven.push((joint, reference, coefficient));
        }
        Ok(driven)
    }
}
