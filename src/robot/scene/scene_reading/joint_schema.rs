//! The tables `[[motor]]` and `[[joint]]` of a scene file, as `serde` reads them.

use crate::mechanism::description::target::Interpolation;
use crate::scene::joint_settings::LimitChoice;
use crate::scene::scene_reading::scene_numbers::{Bound, Finite, Fraction, NotNegative, Quantity};
use serde::de::{Deserialize, Deserializer, Error, IntoDeserializer, MapAccess, SeqAccess, Visitor};
use std::fmt;
use toml::Spanned;

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct MotorTable {
    pub joint: OneOrMore,
    pub kind: MotorKind,
    pub target: Spanned<TargetKey>,
    #[serde(default)]
    pub interpolation: InterpolationKey,
    pub kp: Option<Spanned<NotNegative>>,
    pub kd: Option<Spanned<NotNegative>>,
    pub max_effort: Option<Bound>,
    pub period: Option<NotNegative>,
    pub gravity_compensation: Option<Part>,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct MotionTable {
    pub joint: Spanned<String>,
    pub position: Spanned<TargetKey>,
}

/// A part of a whole: `true` for all, `false` for nothing, or a number that is not negative.
#[derive(Clone, Copy)]
pub(crate) struct Part(pub f64);

impl<'de> Deserialize<'de> for Part {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct FlagOrNumber;
        impl Visitor<'_> for FlagOrNumber {
            type Value = Part;

            fn expecting(&self, out: &mut fmt::Formatter) -> fmt::Result {
                out.write_str("true, false, or the part of the weight that it holds")
            }

            fn visit_bool<E: Error>(self, all: bool) -> Result<Part, E> {
                Ok(Part(f64::from(u8::from(all))))
            }

            fn visit_f64<E: Error>(self, number: f64) -> Result<Part, E> {
                NotNegative::try_from(number).map(|part| Part(part.0)).map_err(E::custom)
            }

            fn visit_i64<E: Error>(self, number: i64) -> Result<Part, E> {
                self.visit_f64(number as f64)
            }
        }
        deserializer.deserialize_any(FlagOrNumber)
    }
}

#[derive(Clone, Copy, PartialEq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum MotorKind {
    Position,
    Velocity,
    Effort,
}

#[derive(Clone, Copy, Default, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum InterpolationKey {
    Hold,
    #[default]
    Linear,
    Cubic,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct JointTable {
    pub name: Spanned<String>,
    pub limit: Option<LimitKey>,
    pub restitution: Option<Spanned<Fraction>>,
    pub friction: Option<NotNegative>,
    pub damping: Option<NotNegative>,
    pub armature: Option<NotNegative>,
}

/// A name or a list of names, each with its place.
pub(crate) struct OneOrMore(pub Vec<Spanned<String>>);

impl<'de> Deserialize<'de> for OneOrMore {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let whole = Spanned::<Names>::deserialize(deserializer)?;
        let span = whole.span();
        Ok(OneOrMore(match whole.into_inner() {
            Names::One(name) => vec![Spanned::new(span, name)],
            Names::Several(names) => names,
        }))
    }
}

/// The same before the place of one name is known.
enum Names {
    One(String),
    Several(Vec<Spanned<String>>),
}

impl<'de> Deserialize<'de> for Names {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NameOrList;
        impl<'de> Visitor<'de> for NameOrList {
            type Value = Names;

            fn expecting(&self, out: &mut fmt::Formatter) -> fmt::Result {
                out.write_str("the name of a joint or a list of names")
            }

            fn visit_str<E: Error>(self, name: &str) -> Result<Names, E> {
                Ok(Names::One(name.to_string()))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Names, A::Error> {
                let mut names = Vec::new();
                while let Some(name) = list.next_element()? {
                    names.push(name);
                }
                if names.is_empty() {
                    return Err(A::Error::custom("the list is empty; give at least one joint"));
                }
                Ok(Names::Several(names))
            }
        }
        deserializer.deserialize_any(NameOrList)
    }
}

/// A target: a number, `"start"`, entries `[time, value]` with their places in the file, the name of a CSV file, or a formula with its parameters.
pub(crate) enum TargetKey {
    Number(Quantity),
    Start,
    Entries(Vec<Spanned<Vec<Quantity>>>),
    File(String),
    Formula { text: Spanned<String>, parameters: Vec<(String, f64)> },
}

/// `[lower, upper]` or `"none"`.
pub(crate) enum LimitKey {
    Unlimited,
    Range([Limiting; 2]),
}

/// A limit, perhaps infinite.
#[derive(Clone, Copy)]
pub(crate) struct Limiting(pub Quantity);

impl From<InterpolationKey> for Interpolation {
    fn from(key: InterpolationKey) -> Self {
        match key {
            InterpolationKey::Hold => Interpolation::Hold,
            InterpolationKey::Linear => Interpolation::Linear,
            InterpolationKey::Cubic => Interpolation::Cubic,
        }
    }
}

impl<'de> Deserialize<'de> for TargetKey {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct AnyTarget;
        impl<'de> Visitor<'de> for AnyTarget {
            type Value = TargetKey;

            fn expecting(&self, out: &mut fmt::Formatter) -> fmt::Result {
                out.write_str(
                    "a number, a list of [time, value], the name of a CSV file of time,value, { formula = \"…\" }, or \"start\"",
                )
            }

            fn visit_f64<E: Error>(self, number: f64) -> Result<TargetKey, E> {
                Quantity::deserialize(number.into_deserializer()).map(TargetKey::Number)
            }

            fn visit_i64<E: Error>(self, number: i64) -> Result<TargetKey, E> {
                self.visit_f64(number as f64)
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<TargetKey, E> {
                if text == "start" {
                    return Ok(TargetKey::Start);
                }
                let number = Quantity::parse(text).map(TargetKey::Number);
                Ok(number.unwrap_or_else(|_| TargetKey::File(text.to_string())))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<TargetKey, A::Error> {
                let mut entries = Vec::new();
                while let Some(entry) = list.next_element()? {
                    entries.push(entry);
                }
                Ok(TargetKey::Entries(entries))
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<TargetKey, A::Error> {
                let (mut text, mut parameters) = (None, Vec::new());
                while let Some(key) = map.next_key::<String>()? {
                    if key == "formula" {
                        text = Some(map.next_value::<Spanned<String>>()?);
                    } else {
                        parameters.push((key, map.next_value::<Finite>()?.0));
                    }
                }
                let text = text.ok_or_else(|| A::Error::missing_field("formula"))?;
                Ok(TargetKey::Formula { text, parameters })
            }
        }
        deserializer.deserialize_any(AnyTarget)
    }
}

impl<'de> Deserialize<'de> for Limiting {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Quantity::deserialize_any_number(deserializer).map(Limiting)
    }
}

impl<'de> Deserialize<'de> for LimitKey {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct RangeOrNone;
        impl<'de> Visitor<'de> for RangeOrNone {
            type Value = LimitKey;

            fn expecting(&self, out: &mut fmt::Formatter) -> fmt::Result {
                out.write_str("[lower, upper] or \"none\"")
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<LimitKey, E> {
                match text {
                    "none" => Ok(LimitKey::Unlimited),
                    other => Err(E::custom(format!("{other:?} is no limit; give [lower, upper] or \"none\""))),
                }
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<LimitKey, A::Error> {
                let mut numbers: Vec<Limiting> = Vec::new();
                while let Some(number) = list.next_element()? {
                    numbers.push(number);
                }
                let &[lower, upper] = numbers.as_slice() else {
                    return Err(A::Error::custom(format!("{} numbers; give [lower, upper]", numbers.len())));
                };
                LimitChoice::between(lower.0.number, upper.0.number).map_err(A::Error::custom)?;
                Ok(LimitKey::Range([lower, upper]))
            }
        }
        deserializer.deserialize_any(RangeOrNone)
    }
}
