//! The triangles of a robot and its obstacles, each with the body that carries it.
//!
//! The shapes, meshes and obstacles are those of the page (`page/looks.rs`, `page/colliders.rs`); half spaces are planes of the background.

use crate::mechanism::description::joint::{Pose, rotation_from_wxyz};
use crate::model::{Model, RopeRecord};
use crate::output::film::camera::Bounds;
use crate::output::film::canvas::{Linear, linear};
use crate::output::film::normals::creased;
use crate::output::film::primitives::{Corner, Triangles, capsule, cuboid, cylinder, quarters, sphere};
use crate::output::page::colliders::{DrawnCollider, colliders};
use crate::output::page::looks::{DrawnShape, MeshSource, looks};
use crate::output::page::shared_meshes::IndexedPart;
use nalgebra::{Rotation3, Translation3, Vector3};
use std::f64::consts::PI;

/// The grey of shapes without a colour, that of obstacles, and the opacity of these, as in the page.
const GREY: [f64; 4] = [0.72, 0.73, 0.75, 1.0];
const OBSTACLE: [f64; 4] = [0.761, 0.659, 0.471, 0.55];
/// The colour of ropes, as in the page.
const ROPE: [f64; 4] = [0.541, 0.416, 0.231, 1.0];

/// Triangles of one colour in one body.
pub(super) struct Part {
    /// The body; `None` is the world.
    pub body: Option<usize>,
    /// Corners and normals in the frame of the body.
    pub triangles: Triangles,
    /// Its colour in linear light.
    pub color: Linear,
    /// From 0 to 1.
    pub opacity: f32,
    /// The box around it in the frame of the body.
    pub bounds: Bounds,
}

/// Triangles of a mesh, with its own colour, if it has one.
type Colored = (Option<[f64; 4]>, Triangles);

/// Everything that a film shows.
#[derive(Default)]
pub(super) struct Parts {
    /// Triangles of links.
    pub links: Vec<Part>,
    /// Triangles of obstacles that are no half spaces.
    pub obstacles: Vec<Part>,
    /// Frames of half spaces.
    pub planes: Vec<Pose>,
    /// The points of each rope, in their bodies (m).
    pub ropes: Vec<Vec<(Option<usize>, Vector3<f64>)>>,
    /// The origins of links in their bodies (m), around which the camera looks, too.
    pub origins: Vec<(Option<usize>, Vector3<f64>)>,
    /// Shapes that are not drawn, or not as in their files, in sentences.
    pub notes: Vec<String>,
}

impl Parts {
    /// The box around the links and ropes: around their shapes, origins and points.
    pub(super) fn bounds(&self, poses: &[Pose]) -> Bounds {
        let mut bounds = Bounds::NONE;
        for part in &self.links {
            bounds = bounds.joined(&part.bounds_at(poses));
        }
        for (body, origin) in self.origins.iter().chain(self.ropes.iter().flatten()) {
            let place = body.map_or(*origin, |body| poses[body].rotation * origin + poses[body].translation.vector);
            bounds.add(&place);
        }
        bounds
    }

    /// The ropes with the bodies at these poses, as rods of this radius (m), each with its place.
    pub(super) fn rods(&self, poses: &[Pose], radius: f64) -> Vec<(Part, Pose)> {
        let place = |&(body, point): &(Option<usize>, Vector3<f64>)| {
            body.map_or(point, |body| poses[body].rotation * point + poses[body].translation.vector)
        };
        let mut rods = Vec::new();
        for rope in &self.ropes {
            let places: Vec<Vector3<f64>> = rope.iter().map(place).collect();
            for ends in places.windows(2) {
                let along = ends[1] - ends[0];
                if along.norm() > 0.0 {
                    // Half a turn about x where the rod points down.
                    let turn = Rotation3::rotation_between(&Vector3::z(), &along);
                    let turn = turn.unwrap_or_else(|| Rotation3::from_axis_angle(&Vector3::x_axis(), PI));
                    let at = Pose::from_parts(Translation3::from(0.5 * (ends[0] + ends[1])), turn);
                    rods.push((part(None, &Pose::identity(), &cylinder(radius, along.norm()), ROPE), at));
                }
            }
        }
        rods
    }

    /// Gathers the parts of a model, with at most about `mesh_limit` triangles of meshes.
    pub(super) fn of(model: &Model, source: &MeshSource, mesh_limit: usize) -> Self {
        let mut drawn = looks(model, source, mesh_limit > 0);
        let [obstacles, _] = colliders(model, &mut drawn, mesh_limit > 0);
        let (meshes, simplified) = drawn.meshes.indexed(mesh_limit);
        let colored =
            |part: &IndexedPart| (part.color.map(|own| own.map(f64::from)), creased(&part.corners, &part.triangles));
        let meshes: Vec<Vec<Colored>> = meshes.iter().map(|parts| parts.iter().map(colored).collect()).collect();
        let mut parts = Parts { notes: drawn.notes.into_iter().chain(simplified).collect(), ..Parts::default() };
        let seen = model.contact.ropes.iter().filter(|_| !model.contact.owners.is_empty());
        let points = |rope: &RopeRecord| {
            rope.seen_points().iter().map(|point| (point.body, point.frame.translation.vector)).collect()
        };
        parts.ropes = seen.map(points).collect();
        parts.origins = model.links.iter().map(|link| (link.body, link.in_body.translation.vector)).collect();
        for shape in &drawn.shapes {
            let link = &model.links[shape.link];
            let drawn = of_shape(shape, link.body, &link.in_body, &meshes);
            // A box around nothing has no corners.
            parts.links.extend(drawn.into_iter().filter(|part| !part.triangles.is_empty()));
        }
        for obstacle in &obstacles {
            if obstacle.kind == "half_space" {
                parts.planes.push(pose_of(&obstacle.pose));
            } else {
                let drawn = of_obstacle(obstacle, &meshes);
                parts.obstacles.extend(drawn.into_iter().filter(|part| !part.triangles.is_empty()));
            }
        }
        parts
    }
}

impl Part {
    /// The pose of its body.
    pub(super) fn pose(&self, poses: &[Pose]) -> Pose {
        self.body.map_or_else(Pose::identity, |body| poses[body])
    }

    /// The box around its own box at this pose.
    pub(super) fn bounds_at(&self, poses: &[Pose]) -> Bounds {
        let (pose, mut bounds) = (self.pose(poses), Bounds::NONE);
        for corner in self.bounds.corners() {
            bounds.add(&(pose.rotation * corner + pose.translation.vector));
        }
        bounds
    }
}

/// The parts of a shape; of a ball with a seam, one for each of its two colours.
fn of_shape(shape: &DrawnShape, body: Option<usize>, link: &Pose, meshes: &[Vec<Colored>]) -> Vec<Part> {
    let place = link * pose_of(&shape.pose);
    let color = shape.color.unwrap_or(GREY);
    if let Some(mesh) = shape.mesh {
        let scale = Vector3::new(shape.size[0], shape.size[1], shape.size[2]);
        let stretched =
            |(own, triangles): &Colored| part(body, &place, &scaled(triangles, &scale), own.unwrap_or(color));
        return meshes[mesh].iter().map(stretched).collect();
    }
    let triangles = of_primitive(shape.kind, &shape.size);
    if !shape.seam {
        return vec![part(body, &place, &triangles, color)];
    }
    let [light, dark] = quarters(triangles);
    vec![part(body, &place, &light, color), part(body, &place, &dark, seam_color(color))]
}

/// The second colour of a ball: darker, or lighter than a dark one.
fn seam_color([red, green, blue, opacity]: [f64; 4]) -> [f64; 4] {
    let brightness = 0.2126 * red + 0.7152 * green + 0.0722 * blue;
    let other = |part: f64| if brightness > 0.25 { 0.6 * part } else { part + 0.45 * (1.0 - part) };
    [other(red), other(green), other(blue), opacity]
}

fn of_obstacle(obstacle: &DrawnCollider, meshes: &[Vec<Colored>]) -> Vec<Part> {
    let place = pose_of(&obstacle.pose);
    match obstacle.mesh {
        Some(mesh) => {
            meshes[mesh].iter().map(|(_, triangles)| part(obstacle.body, &place, triangles, OBSTACLE)).collect()
        }
        None => vec![part(obstacle.body, &place, &of_primitive(obstacle.kind, &obstacle.size), OBSTACLE)],
    }
}

fn of_primitive(kind: &str, size: &[f64]) -> Triangles {
    match (kind, size) {
        ("box", &[x, y, z]) => cuboid([x, y, z]),
        ("sphere", &[radius]) => sphere(radius),
        ("cylinder", &[radius, length]) => cylinder(radius, length),
        ("capsule", &[radius, length]) => capsule(radius, length),
        _ => Triangles::new(),
    }
}

/// Triangles stretched along the axes; normals stay square on them.
fn scaled(triangles: &Triangles, scale: &Vector3<f64>) -> Triangles {
    let one = |(place, normal): &Corner| {
        let square = normal.component_div(scale).try_normalize(f64::MIN_POSITIVE);
        (place.component_mul(scale), square.unwrap_or(*normal))
    };
    triangles.iter().map(|corners| [0, 1, 2].map(|k| one(&corners[k]))).collect()
}

fn part(body: Option<usize>, place: &Pose, triangles: &Triangles, [red, green, blue, opacity]: [f64; 4]) -> Part {
    let mut bounds = Bounds::NONE;
    let moved =
        |&(corner, normal): &Corner| (place.rotation * corner + place.translation.vector, place.rotation * normal);
    let triangles: Triangles = triangles.iter().map(|corners| [0, 1, 2].map(|k| moved(&corners[k]))).collect();
    triangles.iter().flatten().for_each(|(corner, _)| bounds.add(corner));
    Part { body, triangles, color: linear([red, green, blue]), opacity: opacity as f32, bounds }
}

/// The pose of seven numbers of the page.
pub(super) fn pose_of([x, y, z, qw, qx, qy, qz]: &[f64; 7]) -> Pose {
    let rotation = Rotation3::from_matrix_unchecked(rotation_from_wxyz(&[*qw, *qx, *qy, *qz]));
    Pose::from_parts(Translation3::new(*x, *y, *z), rotation)
}
