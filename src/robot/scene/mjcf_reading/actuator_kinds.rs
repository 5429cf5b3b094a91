//! Kinds of actuators of MJCF as the general one, and their defaults.
//!
//! All kinds of a class share one set of defaults, that of `general`. Each kind writes its own settings into it:
//!
//! | kind | gain g (fixed) | biases b₀, b₁, b₂ | dynamics |
//! |---|---|---|---|
//! | `motor` | 1 | 0, 0, 0 | – |
//! | `position` | kp | 0, −kp, −kv or the damping ratio | a filter, if it has a time constant |
//! | `intvelocity` | kp | 0, −kp, −kv or the damping ratio | an integrator |
//! | `velocity` | kv | 0, 0, −kv | – |
//! | `damper` | −kv of the velocity, times its control | 0, 0, 0 | – |
//! | `cylinder` | area | bias | a filter |
//!
//! kp, kv, area and time constant that an element does not say are those of the set. A set that another kind has written last
//! does not count: then the set of the nearest class around counts which that kind or `general` wrote last, or no defaults.
//!
//! Source: MuJoCo documentation, XML reference, `actuator`, and the numbers that MuJoCo 4.0 compiles.

use crate::scene::error::SceneError;
use crate::scene::mjcf_reading::tree::Element;

/// The kinds of actuators.
const KINDS: [&str; 13] = [
    GENERAL,
    "motor",
    "position",
    "intvelocity",
    "velocity",
    "damper",
    "cylinder",
    "muscle",
    "adhesion",
    "dcmotor",
    "pid",
    "orientation",
    "plugin",
];

/// The kind that any other one is.
const GENERAL: &str = "general";

/// The settings of an actuator that its kind is short for.
#[derive(Clone, Debug)]
pub(crate) struct ActuatorLaw {
    /// The kind that wrote it last.
    kind: String,
    pub dynamics: String,
    /// Time constant (s) of a filter.
    pub time: f64,
    pub gain_kind: String,
    /// g₀, g₁ and g₂ of `(g₀ + g₁ q + g₂ q̇) u`, of which a fixed gain has the first.
    pub gain: [f64; 3],
    pub bias_kind: String,
    pub bias: [f64; 3],
    /// The range of its control as a part of the range of its joint.
    pub inherited_range: f64,
}

impl Default for ActuatorLaw {
    fn default() -> Self {
        ActuatorLaw {
            kind: GENERAL.to_string(),
            dynamics: "none".to_string(),
            time: 1.0,
            gain_kind: "fixed".to_string(),
            gain: [1.0, 0.0, 0.0],
            bias_kind: "none".to_string(),
            bias: [0.0; 3],
            inherited_range: 0.0,
        }
    }
}

/// Whether elements of this name are actuators.
pub(crate) fn is_actuator(name: &str) -> bool {
    KINDS.contains(&name)
}

impl ActuatorLaw {
    /// Whether an actuator of a kind begins with this set.
    pub fn serves(&self, kind: &str) -> bool {
        kind == GENERAL || self.kind == GENERAL || self.kind == kind
    }

    /// The set with the settings of an element.
    pub fn with(mut self, element: &Element) -> Result<Self, SceneError> {
        let number = |name: &str| element.number(name);
        let put = |into: &mut [f64], name: &str| -> Result<(), SceneError> {
            let given = element.list(name, 1, 10)?.unwrap_or_default();
            into.iter_mut().zip(given).for_each(|(own, given)| *own = given);
            Ok(())
        };
        self.kind.clone_from(&element.name);
        let (mut gain_kind, mut bias_kind, mut dynamics) = ("fixed", "affine", "none");
        match element.name.as_str() {
            "motor" => {
                (self.gain[0], bias_kind) = (1.0, "none");
            }
            "position" | "intvelocity" => {
                let kp = number("kp")?.unwrap_or(self.gain[0]);
                (self.gain[0], self.bias[0], self.bias[1]) = (kp, 0.0, -kp);
                // A damping ratio stands where the damping stands, with the other sign.
                self.bias[2] = match (number("dampratio")?, number("kv")?) {
                    (Some(ratio), _) => ratio,
                    (None, Some(kv)) => -kv,
                    (None, None) => self.bias[2],
                };
                self.inherited_range = number("inheritrange")?.unwrap_or(self.inherited_range);
                let time = number("timeconst")?;
                self.time = time.unwrap_or(self.time);
                dynamics = match (element.name.as_str(), time) {
                    ("intvelocity", _) => "integrator",
                    (_, Some(time)) if time > 0.0 => "filterexact",
                    (_, None) if self.dynamics == "filterexact" => "filterexact",
                    _ => "none",
                };
            }
            "velocity" => {
                let kv = number("kv")?.unwrap_or(self.gain[0]);
                (self.gain[0], self.bias) = (kv, [0.0, 0.0, -kv]);
            }
            "damper" => {
                let own = if self.gain_kind == "affine" { -self.gain[2] } else { 0.0 };
                self.gain = [0.0, 0.0, -number("kv")?.unwrap_or(own)];
                (gain_kind, bias_kind) = ("affine", "none");
            }
            "cylinder" => {
                let area = number("area")?.unwrap_or(self.gain[0]);
                let of_diameter = |diameter: f64| std::f64::consts::FRAC_PI_4 * diameter * diameter;
                self.gain[0] = number("diameter")?.map_or(area, of_diameter);
                put(&mut self.bias, "bias")?;
                self.time = number("timeconst")?.unwrap_or(self.time);
                dynamics = "filter";
            }
            GENERAL => {
                put(std::slice::from_mut(&mut self.time), "dynprm")?;
                put(&mut self.gain, "gainprm")?;
                put(&mut self.bias, "biasprm")?;
                for (own, name) in [
                    (&mut self.dynamics, "dyntype"),
                    (&mut self.gain_kind, "gaintype"),
                    (&mut self.bias_kind, "biastype"),
                ] {
                    if let Some(given) = element.text(name) {
                        given.clone_into(own);
                    }
                }
                return Ok(self);
            }
            // They have a law of their own.
            other => (gain_kind, bias_kind, dynamics) = (other, other, other),
        }
        gain_kind.clone_into(&mut self.gain_kind);
        bias_kind.clone_into(&mut self.bias_kind);
        dynamics.clone_into(&mut self.dynamics);
        Ok(self)
    }
}
