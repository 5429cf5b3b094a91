//! Reads a table `[[body]]` as robots of one link: its shape, its weight, its copies.

use crate::mechanism::description::contact::Shape;
use crate::scene::body::{SceneBody, Weight};
use crate::scene::contact_settings::Obstacle;
use crate::scene::description::SceneRobot;
use crate::scene::error::{Element, Problem, SceneError};
use crate::scene::numbers::turn;
use crate::scene::robot::{Geometry, Pose, Surface};
use crate::scene::scene_reading::base_velocity::base_velocity;
use crate::scene::scene_reading::body_schema::BodyTable;
use crate::scene::scene_reading::contact_schema::ShapeKind;
use crate::scene::scene_reading::copies::{CopyKeys, copies};
use crate::scene::scene_reading::coupling_reader::CouplingReader;
use crate::scene::scene_reading::scene_files::SceneFiles;
use crate::scene::scene_reading::scene_numbers::Fraction;
use crate::scene::scene_reading::scene_schema::vector;
use crate::scene::world::WORLD_LINK;
use nalgebra::Translation3;
use toml::Spanned;

impl CouplingReader<'_> {
    /// The bodies of a table, which is number `index` from 0.
    pub fn bodies(
        &self,
        table: Spanned<BodyTable>,
        index: usize,
        files: &mut dyn SceneFiles,
    ) -> Result<Vec<SceneRobot>, SceneError> {
        let span = table.span();
        let table = table.into_inner();
        let place = table.name.as_ref().map_or(span.clone(), Spanned::span);
        let name = table.name.map_or_else(|| format!("body{}", index + 1), Spanned::into_inner);
        let owner = Element::Body(name.clone());
        if name.is_empty() || name == WORLD_LINK || name == Obstacle::FLOOR || name.contains(['/', '|', '*']) {
            return Err(self.text.error(&place, Some(owner), Problem::BodyName));
        }
        let refuse = |span, message| Err(self.text.error(&span, Some(owner.clone()), Problem::Keys(message)));
        if matches!(table.shape.get_ref().kind, ShapeKind::HalfSpace | ShapeKind::Mesh) {
            return refuse(
                table.shape.span(),
                "a body is a sphere, box, cylinder, capsule or ellipsoid; of others write a URDF",
            );
        }
        let (shape, _, _) = self.shape(table.shape, &owner, files)?;
        let shape = match shape {
            Shape::Sphere { radius } => Geometry::Sphere { radius },
            Shape::Box { half } => Geometry::Box { size: 2.0 * half },
            Shape::Cylinder { radius, half } => Geometry::Cylinder { radius, length: 2.0 * half },
            Shape::Capsule { radius, half } => Geometry::Capsule { radius, length: 2.0 * half },
            Shape::Ellipsoid { radii } => Geometry::Ellipsoid { radii },
            _ => {
                return refuse(span, "a body is a sphere, box, cylinder, capsule or ellipsoid; of others write a URDF");
            }
        };
        let weight = match (table.density, table.mass) {
            (Some(density), None) => Weight::Density(density.get_ref().0),
            (None, Some(mass)) => Weight::Mass(mass.get_ref().0),
            (None, None) => return refuse(span, "a body needs its density [kg/m³] or its mass [kg]"),
            (Some(_), Some(mass)) => return refuse(mass.span(), "give either the density or the mass of a body"),
        };
        let color = match table.color {
            None => None,
            Some(color) => match color.get_ref().as_slice() {
                [Fraction(red), Fraction(green), Fraction(blue)] => Some([*red, *green, *blue, 1.0]),
                [Fraction(red), Fraction(green), Fraction(blue), Fraction(opacity)] => {
                    Some([*red, *green, *blue, *opacity])
                }
                _ => {
                    return refuse(
                        color.span(),
                        "a color is [red, green, blue] or [red, green, blue, opacity], each 0 to 1",
                    );
                }
            },
        };
        let surface = Surface {
            friction: table.friction.map(|friction| friction.0),
            restitution: table.restitution.map(|restitution| restitution.0),
            moments: [&table.rolling_friction, &table.spinning_friction]
                .map(|length| length.as_ref().map(|length| length.0)),
            velocity: table.surface_velocity.as_ref().map(vector),
        };
        let body = SceneBody { shape, weight, color, surface };
        let line = self.text.line(&span);
        let rpy = table.pose.angles();
        let keys = CopyKeys { count: &table.count, grid: &table.grid, spacing: &table.spacing };
        let mut bodies = Vec::new();
        for (number, displacement) in copies(self.text, &keys, &owner)? {
            let name = format!("{name}{number}");
            let translation = Translation3::from(vector(&table.pose.position) + displacement);
            bodies.push(SceneRobot {
                robot: body.robot(&name, self.text.file, line)?,
                name,
                prefix: String::new(),
                body: Some(body.clone()),
                copy: false,
                floating: true,
                pose: Pose::from_parts(translation, turn(rpy)),
                rpy,
                velocity: table.velocity.as_ref().map(|velocity| base_velocity(self.text, velocity)),
                positions: Vec::new(),
                velocities: Vec::new(),
                line,
            });
        }
        Ok(bodies)
    }
}
