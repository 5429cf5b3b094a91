//! The contact settings of a scene, from the tables `[[obstacle]]`, `[contact]` and `[[link]]`: names resolved, keys that belong together checked,
//! meshes read.

use crate::geometry::check_shape;
use crate::mechanism::description::contact::Shape;
use crate::meshes::collision_surface;
use crate::scene::contact_settings::{ContactSettings, MeshSource, Obstacle, PairRule, SceneLink, Touching};
use crate::scene::coupling::LinkReference;
use crate::scene::error::{Element, Problem, SceneError};
use crate::scene::numbers::{normalised, turn, turn_of_z};
use crate::scene::robot::{Pose, Surface};
use crate::scene::scene_reading::contact_schema::{
    CombineKey, ContactTable, LinkTable, ObstacleTable, PairTable, ShapeKind, ShapeTable,
};
use crate::scene::scene_reading::coupling_reader::CouplingReader;
use crate::scene::scene_reading::scene_files::SceneFiles;
use crate::scene::scene_reading::scene_numbers::{Finite, PoseTable, Positive};
use crate::scene::scene_reading::scene_schema::vector;
use crate::scene::world::WORLD_LINK;
use nalgebra::{Rotation3, Translation3, Vector3};
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;
use toml::Spanned;

impl CouplingReader<'_> {
    /// All that the file says of contact, in a scene with or without `bodies`; the meshes of obstacles are read.
    pub fn contact(
        &self,
        bodies: bool,
        table: Option<ContactTable>,
        obstacles: Vec<Spanned<ObstacleTable>>,
        links: Vec<Spanned<LinkTable>>,
        files: &mut dyn SceneFiles,
    ) -> Result<ContactSettings, SceneError> {
        let defaults = ContactSettings::default();
        let table = table.unwrap_or_default();
        let rules = table.pair.into_iter().map(|pair| self.pair_rule(pair)).collect::<Result<_, _>>()?;
        Ok(ContactSettings {
            // Free bodies are there to touch each other.
            touching: table.pairs.or(bodies.then_some(Touching::All)),
            self_contact: table.self_contact,
            friction: table.friction.map_or(defaults.friction, |friction| friction.0),
            restitution: table.restitution.map_or(defaults.restitution, |restitution| restitution.0),
            moments: [&table.rolling_friction, &table.spinning_friction]
                .map(|length| length.as_ref().map_or(0.0, |length| length.0)),
            larger: table.combine == CombineKey::Larger,
            rules,
            obstacles: self.obstacles(obstacles, files)?,
            links: self.scene_links(links)?,
        })
    }

    fn pair_rule(&self, table: Spanned<PairTable>) -> Result<PairRule, SceneError> {
        let span = table.span();
        let PairTable { a, b, friction, restitution, rolling_friction, spinning_friction, ignore } = table.into_inner();
        let moments = [rolling_friction, spinning_friction].map(|length| length.map(|length| length.0));
        if friction.is_none() && restitution.is_none() && moments == [None; 2] && ignore.is_none() {
            let problem = Problem::Keys(
                "give its friction, its restitution, its rolling_friction, its spinning_friction or ignore",
            );
            return Err(self.text.error(&span, Some(Element::Pair(format!("{a:?} and {b:?}"))), problem));
        }
        let (friction, restitution) = (friction.map(|friction| friction.0), restitution.map(|number| number.0));
        Ok(PairRule { a, b, friction, restitution, moments, ignore, line: self.text.line(&span) })
    }

    fn obstacles(
        &self,
        tables: Vec<Spanned<ObstacleTable>>,
        files: &mut dyn SceneFiles,
    ) -> Result<Vec<Obstacle>, SceneError> {
        let mut obstacles: Vec<Obstacle> = Vec::with_capacity(tables.len());
        for (index, table) in tables.into_iter().enumerate() {
            let span = table.span();
            let ObstacleTable {
                name,
                shape,
                pose,
                friction,
                restitution,
                rolling_friction,
                spinning_friction,
                surface_velocity,
            } = table.into_inner();
            let place = name.as_ref().map_or(span, Spanned::span);
            let name = name.map_or_else(|| format!("obstacle{}", index + 1), Spanned::into_inner);
            let owner = Element::Obstacle(name.clone());
            if name.is_empty() || name == WORLD_LINK || name.contains(['|', '*']) {
                return Err(self.text.error(&place, Some(owner), Problem::ObstacleName));
            }
            let line = Some(self.text.line(&place));
            if let Some(first) = obstacles.iter().find(|other| other.name == name) {
                let first_line = first.line.unwrap_or_default();
                return Err(self.text.error(&place, Some(owner), Problem::DuplicateName { first_line }));
            }
            let given = |numbers: &Option<Spanned<[Finite; 3]>>| numbers.as_ref().map(|given| vector(given.get_ref()));
            let normal = given(&shape.get_ref().normal).unwrap_or(Vector3::z());
            let scale = given(&shape.get_ref().scale).unwrap_or(Vector3::repeat(1.0));
            let span = shape.span();
            let (shape, turn, mesh) = self.shape(shape, &owner, files)?;
            let in_world = placed(&pose) * turn;
            if let Err(problem) = check_shape(&shape, &in_world) {
                let problem = Problem::Toml { key: Some("obstacle.shape".to_string()), message: problem.to_string() };
                return Err(self.text.error(&span, Some(owner), problem));
            }
            obstacles.push(Obstacle {
                name,
                shape,
                pose: in_world,
                rpy: pose.angles(),
                turn,
                normal,
                friction: friction.map(|friction| friction.0),
                restitution: restitution.map(|restitution| restitution.0),
                moments: [rolling_friction, spinning_friction].map(|length| length.map(|length| length.0)),
                surface_velocity: surface_velocity.as_ref().map_or(Vector3::zeros(), vector),
                mesh,
                scale,
                line,
            });
        }
        Ok(obstacles)
    }

    /// A shape, its frame relative to the obstacle, and the mesh it was read from.
    pub fn shape(
        &self,
        table: Spanned<ShapeTable>,
        owner: &Element,
        files: &mut dyn SceneFiles,
    ) -> Result<(Shape, Rotation3<f64>, Option<MeshSource>), SceneError> {
        let whole = table.span();
        let table = table.into_inner();
        let ShapeTable { kind, normal, size, radius, radii, length, file, scale } = &table;
        let refuse =
            |span: &Range<usize>, message| Err(self.text.error(span, Some(owner.clone()), Problem::Keys(message)));
        if let Some((span, message)) = foreign_key(&table) {
            return refuse(&span, message);
        }
        let number = |given: &Option<Spanned<_>>| given.as_ref().map(Spanned::get_ref).map(half_of);
        let shape = match kind {
            ShapeKind::HalfSpace => {
                let normal = normal.as_ref().map_or((whole, Vector3::z()), |n| (n.span(), vector(n.get_ref())));
                let Some(unit) = normalised(&normal.1) else {
                    return refuse(&normal.0, "the normal of a half space must not be zero");
                };
                return Ok((Shape::HalfSpace, turn_of_z(&unit), None));
            }
            ShapeKind::Box => match size {
                Some(size) => {
                    let [x, y, z] = size.get_ref().map(|number| 0.5 * number.0);
                    Shape::Box { half: Vector3::new(x, y, z) }
                }
                None => return refuse(&whole, "a box needs its size"),
            },
            ShapeKind::Sphere => match radius {
                Some(radius) => Shape::Sphere { radius: radius.get_ref().0 },
                None => return refuse(&whole, "a sphere needs its radius"),
            },
            ShapeKind::Cylinder | ShapeKind::Capsule => match (radius, number(length)) {
                (Some(radius), Some(half)) if *kind == ShapeKind::Cylinder => {
                    Shape::Cylinder { radius: radius.get_ref().0, half }
                }
                (Some(radius), Some(half)) => Shape::Capsule { radius: radius.get_ref().0, half },
                _ => return refuse(&whole, "cylinders and capsules need a radius and a length"),
            },
            ShapeKind::Ellipsoid => match radii {
                Some(radii) => Shape::Ellipsoid { radii: Vector3::from(radii.get_ref().map(|radius| radius.0)) },
                None => return refuse(&whole, "an ellipsoid needs its radii along x, y and z"),
            },
            ShapeKind::Mesh => {
                let Some(file) = file else { return refuse(&whole, "a mesh needs its file") };
                let scale =
                    scale.as_ref().map_or((file.span(), Vector3::repeat(1.0)), |s| (s.span(), vector(s.get_ref())));
                if scale.1.iter().any(|factor| *factor == 0.0) {
                    return refuse(&scale.0, "the scale of a mesh must not be zero");
                }
                let (shape, source) = self.mesh(file, &scale.1, owner, files)?;
                return Ok((shape, Rotation3::identity(), Some(source)));
            }
        };
        Ok((shape, Rotation3::identity(), None))
    }

    /// The surface of a mesh file.
    fn mesh(
        &self,
        file: &Spanned<String>,
        scale: &Vector3<f64>,
        owner: &Element,
        files: &mut dyn SceneFiles,
    ) -> Result<(Shape, MeshSource), SceneError> {
        let path = self.text.file.parent().unwrap_or(Path::new("")).join(file.get_ref());
        let refuse = |message: String| {
            let problem = Problem::Toml { key: Some("obstacle.shape.file".to_string()), message };
            self.text.error(&file.span(), Some(owner.clone()), problem)
        };
        let bytes = files.bytes(&path).map_err(|error| refuse(error.to_string()))?;
        let surface =
            collision_surface(&path, &bytes, scale).map_err(|error| refuse(format!("{}: {error}", path.display())))?;
        let source = MeshSource { name: file.get_ref().clone(), path, bytes: Arc::new(bytes) };
        Ok((Shape::Mesh(Arc::new(surface)), source))
    }

    fn scene_links(&self, tables: Vec<Spanned<LinkTable>>) -> Result<Vec<SceneLink>, SceneError> {
        let mut links: Vec<SceneLink> = Vec::with_capacity(tables.len());
        for table in tables {
            let span = table.span();
            let LinkTable {
                name,
                shape,
                collision,
                friction,
                restitution,
                rolling_friction,
                spinning_friction,
                surface_velocity,
            } = table.into_inner();
            let owner = Element::Link(name.get_ref().clone());
            let point = self.point(&name, &Default::default(), &owner)?;
            let count = match point.link {
                LinkReference::World => 0,
                LinkReference::Link { robot, link } => self.robots[robot].robot.links[link].collisions.len(),
            };
            if count == 0 {
                let problem = Problem::Keys("it has no collision shape, so there is nothing to choose; leave it out");
                return Err(self.text.error(&name.span(), Some(owner), problem));
            }
            if let Some(shape) = shape.as_ref().filter(|shape| !(1..=count).contains(shape.get_ref())) {
                let problem = Problem::NoCollisionShape { number: *shape.get_ref(), count };
                return Err(self.text.error(&shape.span(), Some(owner), problem));
            }
            let refuse = |span: Range<usize>, message| {
                Err(self.text.error(&span, Some(Element::Link(name.get_ref().clone())), Problem::Keys(message)))
            };
            let of_surface = friction.as_ref().map(Spanned::span).or(restitution.as_ref().map(Spanned::span));
            let of_surface = of_surface.or(surface_velocity.as_ref().map(Spanned::span));
            let moments = [&rolling_friction, &spinning_friction];
            let of_surface = of_surface.or(moments.into_iter().flatten().map(Spanned::span).next());
            if collision.is_none() && of_surface.is_none() {
                let keys = "give its collision, friction, restitution, rolling_friction, spinning_friction or \
                            surface_velocity";
                return refuse(span, keys);
            }
            let surface = Surface {
                friction: friction.map(|friction| friction.get_ref().0),
                restitution: restitution.map(|restitution| restitution.get_ref().0),
                moments: [rolling_friction, spinning_friction].map(|length| length.map(|length| length.get_ref().0)),
                velocity: surface_velocity.map(|velocity| vector(velocity.get_ref())),
            };
            let shape = shape.map(Spanned::into_inner);
            if let Some(first) = links.iter().find(|other| other.link == point.link && other.shape == shape) {
                let problem = Problem::SecondLink { first_line: first.line };
                return Err(self.text.error(&name.span(), Some(owner), problem));
            }
            let line = self.text.line(&name.span());
            links.push(SceneLink { link: point.link, name: point.name, shape, shapes: collision, surface, line });
        }
        Ok(links)
    }
}

/// The place of a key that a shape of this kind has not, and what to say of it.
fn foreign_key(table: &ShapeTable) -> Option<(Range<usize>, &'static str)> {
    let ShapeTable { kind, normal, size, radius, radii, length, file, scale } = table;
    let round = matches!(kind, ShapeKind::Cylinder | ShapeKind::Capsule);
    let is = |wanted| *kind == wanted;
    let span = |has: bool, given: Option<Range<usize>>, message| given.filter(|_| !has).map(|span| (span, message));
    let of = |given: &Option<Spanned<_>>| given.as_ref().map(Spanned::span);
    span(is(ShapeKind::HalfSpace), normal.as_ref().map(Spanned::span), "only a half space has a normal")
        .or(span(is(ShapeKind::Box), size.as_ref().map(Spanned::span), "only a box has a size"))
        .or(span(is(ShapeKind::Ellipsoid), radii.as_ref().map(Spanned::span), "only an ellipsoid has radii"))
        .or(span(round || is(ShapeKind::Sphere), of(radius), "only spheres, cylinders and capsules have a radius"))
        .or(span(round, of(length), "only cylinders and capsules have a length"))
        .or(span(is(ShapeKind::Mesh), file.as_ref().map(Spanned::span), "only a mesh has a file"))
        .or(span(is(ShapeKind::Mesh), scale.as_ref().map(Spanned::span), "only a mesh has a scale"))
}

fn half_of(number: &Positive) -> f64 {
    0.5 * number.0
}

fn placed(table: &PoseTable) -> Pose {
    Pose::from_parts(Translation3::from(vector(&table.position)), turn(table.angles()))
}
