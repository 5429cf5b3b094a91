//! The tables and keys of a scene file, as `serde` reads them; `scene_file.rs` gives their meaning.

use crate::mechanism::description::course::Wave;
use crate::scene::robot::LoopType;
use crate::scene::scene_reading::body_schema::BodyTable;
use crate::scene::scene_reading::contact_schema::{ContactTable, LinkTable, ObstacleTable};
use crate::scene::scene_reading::joint_schema::{InterpolationKey, JointTable, MotionTable, MotorTable, TargetKey};
use crate::scene::scene_reading::scene_numbers::{
    Finite, Fraction, NotNegative, PoseTable, Positive, Quantity, VelocityTable,
};
use nalgebra::Vector3;
use serde::de::{Deserialize, Deserializer, Error, IntoDeserializer, SeqAccess, Visitor};
use std::collections::BTreeMap;
use std::fmt;
use toml::Spanned;

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FileTable {
    pub scene: Option<SceneTable>,
    #[serde(default)]
    pub robot: Vec<Spanned<RobotTable>>,
    #[serde(default)]
    pub body: Vec<Spanned<BodyTable>>,
    #[serde(default, rename = "loop")]
    pub loops: Vec<Spanned<LoopTable>>,
    #[serde(default)]
    pub spring: Vec<Spanned<SpringTable>>,
    #[serde(default)]
    pub rope: Vec<Spanned<RopeTable>>,
    #[serde(default)]
    pub load: Vec<Spanned<LoadTable>>,
    #[serde(default)]
    pub drag: Vec<Spanned<DragTable>>,
    #[serde(default)]
    pub coupling: Vec<Spanned<CouplingTable>>,
    #[serde(default)]
    pub motor: Vec<Spanned<MotorTable>>,
    #[serde(default)]
    pub motion: Vec<Spanned<MotionTable>>,
    #[serde(default)]
    pub joint: Vec<Spanned<JointTable>>,
    #[serde(default)]
    pub obstacle: Vec<Spanned<ObstacleTable>>,
    pub contact: Option<ContactTable>,
    #[serde(default)]
    pub link: Vec<Spanned<LinkTable>>,
    pub simulation: Option<Spanned<SimulationTable>>,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SceneTable {
    pub name: Option<String>,
    pub gravity: Option<[Finite; 3]>,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RobotTable {
    pub name: Option<Spanned<String>>,
    pub urdf: Spanned<String>,
    #[serde(default)]
    pub base: BaseKey,
    #[serde(default)]
    pub pose: PoseTable,
    pub velocity: Option<Spanned<VelocityTable>>,
    #[serde(default)]
    pub positions: BTreeMap<Spanned<String>, JointNumbers>,
    #[serde(default)]
    pub velocities: BTreeMap<Spanned<String>, JointNumbers>,
    pub count: Option<Spanned<usize>>,
    pub grid: Option<Spanned<[usize; 3]>>,
    pub spacing: Option<Spanned<[Finite; 3]>>,
}

#[derive(Clone, Copy, Default, PartialEq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum BaseKey {
    #[default]
    Fixed,
    Floating,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct LoopTable {
    pub name: Option<Spanned<String>>,
    #[serde(rename = "type")]
    pub kind: LoopType,
    pub a: Spanned<EndTable>,
    pub b: Spanned<EndTable>,
    pub length: Option<Spanned<Positive>>,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct EndTable {
    pub link: Spanned<String>,
    #[serde(default)]
    pub position: [Finite; 3],
    pub axis: Option<Spanned<[Finite; 3]>>,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SpringTable {
    pub name: Option<Spanned<String>>,
    pub a: Option<PointTable>,
    pub b: Option<PointTable>,
    pub joint: Option<Spanned<String>>,
    pub stiffness: Option<NotNegative>,
    pub damping: Option<NotNegative>,
    pub rest_length: Option<Spanned<NotNegative>>,
    pub rest: Option<Spanned<Quantity>>,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RopeTable {
    pub name: Option<Spanned<String>>,
    pub points: Spanned<Vec<PointTable>>,
    pub length: Spanned<TargetKey>,
    pub longest: Option<Spanned<Positive>>,
    pub restitution: Option<Fraction>,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PointTable {
    pub link: Spanned<String>,
    #[serde(default)]
    pub position: [Finite; 3],
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct LoadTable {
    pub joint: Option<Spanned<String>>,
    pub effort: Option<Spanned<Finite>>,
    pub link: Option<Spanned<String>>,
    pub position: Option<Spanned<[Finite; 3]>>,
    pub force: Option<Spanned<[Finite; 3]>>,
    pub torque: Option<Spanned<[Finite; 3]>>,
    pub frame: Option<LoadFrame>,
    pub factor: Option<Spanned<TargetKey>>,
    #[serde(default)]
    pub interpolation: InterpolationKey,
    pub wave: Option<WaveTable>,
    pub from: Option<Finite>,
    pub until: Option<Finite>,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct CouplingTable {
    pub name: Option<Spanned<String>>,
    pub joints: BTreeMap<Spanned<String>, Finite>,
    pub offset: Option<Finite>,
}

#[derive(Clone, Copy, PartialEq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum LoadFrame {
    World,
    Link,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct WaveTable {
    mean: Option<Finite>,
    amplitude: Option<Finite>,
    frequency: Finite,
    phase: Option<Finite>,
}

impl WaveTable {
    /// The wave; its amplitude is 1 where that is not given.
    pub fn wave(&self) -> Wave {
        let number = |given: Option<Finite>, otherwise: f64| given.map_or(otherwise, |given| given.0);
        Wave {
            mean: number(self.mean, 0.0),
            amplitude: number(self.amplitude, 1.0),
            frequency: self.frequency.0,
            phase: number(self.phase, 0.0),
        }
    }
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct DragTable {
    pub link: Spanned<String>,
    #[serde(default)]
    pub position: [Finite; 3],
    pub linear: Option<NotNegative>,
    pub quadratic: Option<NotNegative>,
    pub angular: Option<NotNegative>,
    pub angular_quadratic: Option<NotNegative>,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SimulationTable {
    pub duration: Option<Positive>,
    pub tolerance: Option<Spanned<Positive>>,
    pub estimate: Option<Spanned<bool>>,
    pub stages: Option<Spanned<usize>>,
    pub step: Option<Spanned<Positive>>,
    pub rate: Option<Spanned<Positive>>,
}

/// The numbers of a joint: one, or a list.
pub(crate) struct JointNumbers(pub Vec<Quantity>);

impl<'de> Deserialize<'de> for JointNumbers {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct OneOrMany;
        impl<'de> Visitor<'de> for OneOrMany {
            type Value = JointNumbers;

            fn expecting(&self, out: &mut fmt::Formatter) -> fmt::Result {
                out.write_str("a number or a list of numbers")
            }

            fn visit_f64<E: Error>(self, number: f64) -> Result<JointNumbers, E> {
                self.one(number.into_deserializer())
            }

            fn visit_i64<E: Error>(self, number: i64) -> Result<JointNumbers, E> {
                self.visit_f64(number as f64)
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<JointNumbers, E> {
                self.one(text.into_deserializer())
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<JointNumbers, A::Error> {
                let mut numbers = Vec::new();
                while let Some(number) = list.next_element::<Quantity>()? {
                    numbers.push(number);
                }
                Ok(JointNumbers(numbers))
            }
        }
        impl OneOrMany {
            fn one<'de, D: Deserializer<'de>>(self, number: D) -> Result<JointNumbers, D::Error> {
                Ok(JointNumbers(vec![Quantity::deserialize(number)?]))
            }
        }
        deserializer.deserialize_any(OneOrMany)
    }
}

/// Three numbers as a vector.
pub(crate) fn vector(numbers: &[Finite; 3]) -> Vector3<f64> {
    Vector3::from(numbers.map(|number| number.0))
}
