//! The table `[[body]]` of a scene file, as `serde` reads it.

use crate::scene::scene_reading::contact_schema::ShapeTable;
use crate::scene::scene_reading::scene_numbers::{
    Finite, Fraction, Friction, NotNegative, PoseTable, Positive, VelocityTable,
};
use toml::Spanned;

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct BodyTable {
    pub name: Option<Spanned<String>>,
    pub shape: Spanned<ShapeTable>,
    pub density: Option<Spanned<Positive>>,
    pub mass: Option<Spanned<Positive>>,
    pub friction: Option<Friction>,
    pub restitution: Option<Fraction>,
    pub rolling_friction: Option<NotNegative>,
    pub spinning_friction: Option<NotNegative>,
    pub surface_velocity: Option<[Finite; 3]>,
    pub color: Option<Spanned<Vec<Fraction>>>,
    #[serde(default)]
    pub pose: PoseTable,
    pub velocity: Option<Spanned<VelocityTable>>,
    pub count: Option<Spanned<usize>>,
    pub grid: Option<Spanned<[usize; 3]>>,
    pub spacing: Option<Spanned<[Finite; 3]>>,
}
