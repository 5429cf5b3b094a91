//! The tables `[[obstacle]]`, `[contact]`, `[[contact.pair]]` and `[[link]]` of a scene file, as `serde` reads them.

use crate::scene::contact_settings::{LinkShapes, Touching};
use crate::scene::scene_reading::scene_numbers::{Finite, Fraction, Friction, NotNegative, PoseTable, Positive};
use toml::Spanned;

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ObstacleTable {
    pub name: Option<Spanned<String>>,
    pub shape: Spanned<ShapeTable>,
    #[serde(default)]
    pub pose: PoseTable,
    pub friction: Option<Friction>,
    pub restitution: Option<Fraction>,
    pub rolling_friction: Option<NotNegative>,
    pub spinning_friction: Option<NotNegative>,
    pub surface_velocity: Option<[Finite; 3]>,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ShapeTable {
    #[serde(rename = "type")]
    pub kind: ShapeKind,
    pub normal: Option<Spanned<[Finite; 3]>>,
    pub size: Option<Spanned<[Positive; 3]>>,
    pub radius: Option<Spanned<Positive>>,
    pub radii: Option<Spanned<[Positive; 3]>>,
    pub length: Option<Spanned<Positive>>,
    pub file: Option<Spanned<String>>,
    pub scale: Option<Spanned<[Finite; 3]>>,
}

#[derive(Clone, Copy, PartialEq, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum ShapeKind {
    HalfSpace,
    Box,
    Sphere,
    Cylinder,
    Capsule,
    Ellipsoid,
    Mesh,
}

#[derive(Default, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct ContactTable {
    pub pairs: Option<Touching>,
    pub self_contact: Option<bool>,
    pub friction: Option<Friction>,
    pub restitution: Option<Fraction>,
    pub rolling_friction: Option<NotNegative>,
    pub spinning_friction: Option<NotNegative>,
    pub combine: CombineKey,
    pub pair: Vec<Spanned<PairTable>>,
}

#[derive(Clone, Copy, Default, PartialEq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum CombineKey {
    #[default]
    Smaller,
    Larger,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PairTable {
    pub a: String,
    pub b: String,
    pub friction: Option<Friction>,
    pub restitution: Option<Fraction>,
    pub rolling_friction: Option<NotNegative>,
    pub spinning_friction: Option<NotNegative>,
    pub ignore: Option<bool>,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct LinkTable {
    pub name: Spanned<String>,
    pub shape: Option<Spanned<usize>>,
    pub collision: Option<LinkShapes>,
    pub friction: Option<Spanned<Friction>>,
    pub restitution: Option<Spanned<Fraction>>,
    pub rolling_friction: Option<Spanned<NotNegative>>,
    pub spinning_friction: Option<Spanned<NotNegative>>,
    pub surface_velocity: Option<Spanned<[Finite; 3]>>,
}
