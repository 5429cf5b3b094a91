//! Joints of MJCF: hinges, slides and balls, each about its own point of its body.

use crate::scene::error::SceneError;
use crate::scene::mjcf_reading::parts::Joint;
use crate::scene::mjcf_reading::reader::Reader;
use crate::scene::mjcf_reading::tree::Element;
use crate::scene::robot::UrdfJointKind;
use nalgebra::Vector3;

/// Attributes that are not simulated, and what they say.
const UNSIMULATED: [(&str, &str); 3] = [
    ("actuatorfrcrange", "the bound of its actuators together"),
    ("actuatorgravcomp", "its gravity compensation"),
    ("fluidcoef", "its drag"),
];

impl Reader<'_> {
    /// A joint, number `number` of a body.
    pub fn joint(
        &mut self,
        given: &Element,
        inherited: Option<&str>,
        (body, number): (&str, usize),
    ) -> Result<Joint, SceneError> {
        let joint = self.defaults.applied(given, inherited);
        let kind = match joint.text("type").unwrap_or("hinge") {
            "hinge" => UrdfJointKind::Revolute,
            "slide" => UrdfJointKind::Prismatic,
            "ball" => UrdfJointKind::Spherical,
            other => {
                let reason =
                    format!("{other:?} is none of hinge, slide and ball; free joints are for children of the world");
                return Err(joint.error("type", reason));
            }
        };
        let unit = if kind == UrdfJointKind::Prismatic { 1.0 } else { self.angles.unit };
        let number_of = |name: &str, otherwise: f64| Ok::<f64, SceneError>(joint.number(name)?.unwrap_or(otherwise));
        let reference = unit * number_of("ref", 0.0)?;
        let range = self.bounds(&joint, "range", "limited")?;
        let mut limit = range.map(|(lower, upper)| (unit * lower - reference, unit * upper - reference));
        let mut spring = None;
        let stiffness = self.linear(&joint, "stiffness")?.unwrap_or(0.0);
        let rest = unit * number_of("springref", 0.0)? - reference;
        if stiffness > 0.0 {
            spring = Some((stiffness, rest));
        }
        let mut spring_damper = match joint.list("springdamper", 2, 2)?.as_deref() {
            Some(&[time, ratio]) if time > 0.0 && ratio > 0.0 => Some([time, ratio, rest]),
            _ => None,
        };
        if kind == UrdfJointKind::Spherical {
            if limit.take().is_some() {
                self.not_simulated(&joint, "limits of ball joints are not simulated".to_string());
            }
            if spring.take().is_some() || spring_damper.take().is_some() {
                self.not_simulated(&joint, "stiffness of ball joints is not simulated".to_string());
            }
        }
        let mut armature = number_of("armature", 0.0)?;
        if kind == UrdfJointKind::Spherical && armature != 0.0 {
            self.not_simulated(&joint, "armature of ball joints is not simulated".to_string());
            armature = 0.0;
        }
        for (attribute, what) in UNSIMULATED {
            let is_said = joint.text(attribute).is_some_and(|text| {
                text.split_whitespace()
                    .any(|word| word.parse::<f64>().is_ok_and(|number| number != 0.0) || word == "true")
            });
            if is_said {
                self.not_simulated(&joint, format!("{attribute} of joints is not simulated: {what}"));
            }
        }
        let own = joint.text("name").filter(|name| !name.trim().is_empty()).map(str::to_string);
        let otherwise = || if number == 0 { format!("{body}_joint") } else { format!("{body}_joint{}", number + 1) };
        let axis = joint.vector("axis")?.unwrap_or(Vector3::z());
        if axis == Vector3::zeros() && kind != UrdfJointKind::Spherical {
            return Err(joint.error("axis", "it has no direction".to_string()));
        }
        Ok(Joint {
            name: own.unwrap_or_else(otherwise),
            kind,
            place: joint.vector("pos")?.unwrap_or_default(),
            // Viewers and programs expect axes of length one.
            axis: axis.try_normalize(0.0).unwrap_or(Vector3::z()),
            reference,
            limit,
            damping: self.linear(&joint, "damping")?.unwrap_or(0.0),
            friction: number_of("frictionloss", 0.0)?,
            armature,
            spring,
            spring_damper,
            rest,
            mimic: None,
            line: joint.line,
        })
    }
}
