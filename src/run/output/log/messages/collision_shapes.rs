//! The colliders of a model as the message of `/collision_shapes`: one `visualization_msgs/msg/MarkerArray` that never changes
//! ([`crate::output::log::encoding::markers`]).
//!
//! The shapes are the ones of the simulation: each shape of a link in the frame of its link with the namespace of its link, and obstacles in the
//! world with their own names. They are translucent, so that looks are seen through them: shapes of links violet, obstacles brown.
//!
//! | shape | marker |
//! |---|---|
//! | box, sphere, cylinder, capsule | as of looks |
//! | mesh of a link | the triangles of its convex hull, or of its convex pieces; with `--meshes link` the address of its file |
//! | mesh of an obstacle | its triangles; with `--meshes link` the address of its file |
//! | half space | a `CUBE` of 20 m by 20 m by 1 cm below its plane, about the origin of its frame |
//!
//! In a model without possible contacts, the shapes of links are in a log only if the user names the topic.

use crate::geometry::hull_surface;
use crate::mechanism::description::contact::{Collider, Shape, Surface};
use crate::mechanism::description::joint::Pose;
use crate::mechanism::ground::words::counted;
use crate::model::{LinkFrame, Model};
use crate::output::log::encoding::markers::{Marker, MarkerShape, primitives};
use crate::output::log::messages::options::{LogOptions, Meshes};
use crate::output::log::messages::transforms::world_frame;
use crate::output::log::messages::visual::{MOST_TRIANGLES, address};
use crate::scene::{Geometry, LinkReference, LinkShapes};
use nalgebra::{Translation3, Vector3};
use std::path::Path;

/// The topic.
pub(crate) const TOPIC: &str = "/collision_shapes";

/// The colours of shapes of links and of obstacles.
const OF_LINKS: [f64; 4] = [0.62, 0.32, 0.75, 0.4];
const OF_OBSTACLES: [f64; 4] = [0.76, 0.66, 0.47, 0.4];

/// Edges of a half space (m).
const TILE: Vector3<f64> = Vector3::new(20.0, 20.0, 0.01);

/// The markers of everything that may touch.
pub(crate) struct CollisionShapes {
    /// Links in their order, then obstacles.
    pub markers: Vec<Marker>,
    /// Shapes that viewers do not see, in sentences.
    pub warnings: Vec<String>,
    meshes: Meshes,
    world: &'static str,
    triangles: usize,
    left_out: usize,
}

impl CollisionShapes {
    /// The shapes of a model; empty if the log lacks the topic or the model has no colliders.
    pub(crate) fn new(model: &Model, options: &LogOptions) -> Self {
        let mut shapes = CollisionShapes {
            markers: Vec::new(),
            warnings: Vec::new(),
            meshes: options.meshes,
            world: world_frame(&model.links),
            triangles: 0,
            left_out: 0,
        };
        if options.meshes == Meshes::None || !options.topics.has(TOPIC) {
            return shapes;
        }
        let touching = &model.mechanism.nonsmooth.colliders;
        if !touching.is_empty() {
            touching.iter().for_each(|collider| shapes.add(model, collider));
            shapes.add_addresses(model);
        } else if options.topics.names(TOPIC) {
            match model.shapes_of_links() {
                Ok((colliders, warnings)) => {
                    colliders.iter().for_each(|collider| shapes.add(model, collider));
                    shapes.warnings.extend(warnings.iter().map(ToString::to_string));
                    shapes.add_addresses(model);
                }
                Err(error) => shapes.warnings.push(format!("{TOPIC} is not in the log: {error}")),
            }
        }
        if shapes.left_out > 0 {
            let meshes = counted(shapes.left_out, "collision mesh is", "collision meshes are");
            shapes.warnings.push(format!(
                "{meshes} not in {TOPIC}: all together have more than {MOST_TRIANGLES} triangles; use simpler meshes or --meshes link"
            ));
        }
        shapes
    }

    /// Adds a collider; a mesh only if the log has triangles.
    fn add(&mut self, model: &Model, collider: &Collider) {
        let place = match model.link(&collider.name) {
            Some(link) => Place::of_link(&model.links[link], collider.pose),
            None => Place { frame: self.world.to_string(), pose: collider.pose, color: OF_OBSTACLES },
        };
        let pieces = match &collider.shape {
            Shape::HalfSpace => {
                let below = place.pose * Translation3::new(0.0, 0.0, -0.5 * TILE.z);
                primitives(&Geometry::Box { size: TILE }, &below)
            }
            Shape::Sphere { radius } => primitives(&Geometry::Sphere { radius: *radius }, &place.pose),
            Shape::Capsule { radius, half } => {
                primitives(&Geometry::Capsule { radius: *radius, length: 2.0 * half }, &place.pose)
            }
            Shape::Cylinder { radius, half } => {
                primitives(&Geometry::Cylinder { radius: *radius, length: 2.0 * half }, &place.pose)
            }
            Shape::Box { half } => primitives(&Geometry::Box { size: 2.0 * half }, &place.pose),
            Shape::Hollow { .. } | Shape::Point => return,
            Shape::Ellipsoid { radii } => primitives(&Geometry::Ellipsoid { radii: *radii }, &place.pose),
            Shape::Hull(_) | Shape::Mesh(_) if self.meshes == Meshes::Link => return,
            // Points without a hull touch no other shape.
            Shape::Hull(points) => self.triangles(&hull_surface(points).unwrap_or_default(), place.pose),
            Shape::Mesh(surface) => self.triangles(surface, place.pose),
        };
        self.push(&collider.name, &place, pieces);
    }

    /// The triangles of a surface, without the ones that name no vertex; empty beyond the most triangles of a log.
    fn triangles(&mut self, surface: &Surface, pose: Pose) -> Vec<(Pose, [f64; 3], MarkerShape)> {
        let corner =
            |index: &u32| surface.vertices.get(*index as usize).map(|at| [0, 1, 2].map(|axis| at[axis] as f32));
        let whole = surface.triangles.iter().filter_map(|[a, b, c]| Some([corner(a)?, corner(b)?, corner(c)?]));
        let corners: Vec<[f32; 3]> = whole.flatten().collect();
        if self.triangles + corners.len() / 3 > MOST_TRIANGLES {
            self.left_out += 1;
            return Vec::new();
        }
        self.triangles += corners.len() / 3;
        if corners.is_empty() { Vec::new() } else { vec![(pose, [1.0; 3], MarkerShape::Triangles(corners.into()))] }
    }

    /// Adds the markers of one more shape of a link or obstacle.
    fn push(&mut self, name: &str, place: &Place, pieces: Vec<(Pose, [f64; 3], MarkerShape)>) {
        let last = self.markers.iter().rev().find(|marker| marker.namespace == name);
        let visual = last.map_or(0, |last| last.visual + 1);
        for (pose, scale, shape) in pieces {
            let (frame, namespace, color) = (place.frame.clone(), name.to_string(), place.color);
            self.markers.push(Marker { frame, namespace, visual, pose, scale, color, shape });
        }
    }

    /// Adds the addresses of mesh files, with their own scales, if the log has no triangles.
    fn add_addresses(&mut self, model: &Model) {
        if self.meshes != Meshes::Link {
            return;
        }
        let settings = &model.contact.settings;
        for (number, placed) in model.robots.iter().enumerate() {
            for (index, link) in placed.robot.links.iter().enumerate() {
                let reference = LinkReference::Link { robot: number, link: index };
                let frame = &model.links[placed.links.start + index];
                for (shape, given) in link.collisions.iter().enumerate() {
                    if settings.choice(reference, shape + 1) == LinkShapes::None {
                        continue;
                    }
                    if let Geometry::Mesh(mesh) = &given.geometry
                        && let Some(file) = &mesh.resolved
                    {
                        let place = Place::of_link(frame, frame.in_body * given.origin);
                        self.push_address(&frame.name, &place, file, &mesh.scale);
                    }
                }
            }
        }
        let touches = !model.mechanism.nonsmooth.colliders.is_empty();
        for obstacle in settings.obstacles.iter().filter(|_| touches) {
            if let Some(mesh) = &obstacle.mesh {
                let place = Place { frame: self.world.to_string(), pose: obstacle.pose, color: OF_OBSTACLES };
                self.push_address(&obstacle.name, &place, &mesh.path, &obstacle.scale);
            }
        }
    }

    fn push_address(&mut self, name: &str, place: &Place, file: &Path, scale: &Vector3<f64>) {
        let mesh = MarkerShape::Mesh(address(file), false);
        self.push(name, place, vec![(place.pose, (*scale).into(), mesh)]);
    }
}

/// The place of the shapes of a link or obstacle.
struct Place {
    frame: String,
    /// The frame of the shape in it.
    pose: Pose,
    color: [f64; 4],
}

impl Place {
    /// The place of a shape of a link, from its place in the body.
    fn of_link(link: &LinkFrame, in_body: Pose) -> Self {
        Place { frame: link.name.clone(), pose: link.in_body.inverse() * in_body, color: OF_LINKS }
    }
}
