//! The drawn geometry of colliders: obstacles, which are always shown, and the collision shapes of links, which are shown on request.
//!
//! The page draws the colliders of the model, so that it shows the shapes of the simulation; a model without contact has no colliders. A half space
//! `z ≤ 0` of its frame is drawn as a tile in its plane, whose size the page chooses. A mesh of a link is drawn as its convex hull, or as its convex
//! pieces.

use crate::geometry::hull_surface;
use crate::mechanism::description::contact::{Collider, Shape, Surface};
use crate::mechanism::ground::words::counted;
use crate::model::{Model, Owner};
use crate::output::log::sha256;
use crate::page::looks::Looks;
use crate::page::shared_meshes::{LooseTriangles, MeshContent, MeshData};
use crate::page::tree::pose_numbers;
use serde::Serialize;

/// An obstacle, or a collision shape of a link.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct DrawnCollider {
    /// The obstacle or link.
    pub name: String,
    /// The body that carries it; `None` is the world.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub body: Option<usize>,
    /// `half_space`, `box` (edges), `sphere` (radius), `cylinder` and `capsule` (radius, length; axis z), `mesh` (scale).
    pub kind: &'static str,
    /// Lengths (m) or factors, as the kind says.
    pub size: Vec<f64>,
    /// Its frame in the body, or in the world: x, y, z (m), then w, x, y, z.
    pub pose: [f64; 7],
    /// The mesh, by its number.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh: Option<usize>,
}

/// Gathers the obstacles of a model and the collision shapes of its links, and adds their meshes to the meshes of the robots; `with_meshes` false
/// leaves meshes out.
pub(crate) fn colliders(model: &Model, looks: &mut Looks, with_meshes: bool) -> [Vec<DrawnCollider>; 2] {
    let (mut left_out, mut drawn) = ([0; 2], [Vec::new(), Vec::new()]);
    for (collider, owner) in model.mechanism.nonsmooth.colliders.iter().zip(&model.contact.owners) {
        let of_link = usize::from(matches!(owner, Owner::Robot(_)));
        if matches!(owner, Owner::Rope(_) | Owner::RopeEnd(_)) {
            continue;
        }
        match drawn_collider(collider, looks, with_meshes) {
            Some(one) => drawn[of_link].push(one),
            None => left_out[of_link] += 1,
        }
    }
    let because = "not drawn, because --mesh-limit 0 leaves meshes out";
    for (count, one, more) in [
        (left_out[0], "obstacle is", "obstacles are"),
        (left_out[1], "collision shape of a link is", "collision shapes of links are"),
    ] {
        if count > 0 {
            looks.notes.push(format!("{} {because}", counted(count, one, more)));
        }
    }
    drawn
}

/// A collider, unless it is a mesh that is left out.
fn drawn_collider(collider: &Collider, looks: &mut Looks, with_meshes: bool) -> Option<DrawnCollider> {
    let mut mesh = None;
    let mut add = |surface: &Surface| {
        let added = if with_meshes { looks.meshes.add(mesh_data(surface)).ok() } else { None };
        mesh = added;
        added.map(|_| ("mesh", vec![1.0; 3]))
    };
    let (kind, size) = match &collider.shape {
        Shape::HalfSpace => ("half_space", Vec::new()),
        Shape::Sphere { radius } => ("sphere", vec![*radius]),
        Shape::Capsule { radius, half } => ("capsule", vec![*radius, 2.0 * half]),
        Shape::Cylinder { radius, half } => ("cylinder", vec![*radius, 2.0 * half]),
        Shape::Box { half } => ("box", half.iter().map(|half| 2.0 * half).collect()),
        Shape::Hollow { .. } | Shape::Point => return None,
        Shape::Ellipsoid { radii } => ("ellipsoid", radii.iter().copied().collect()),
        Shape::Mesh(surface) => add(surface)?,
        // Points without a hull touch no other shape.
        Shape::Hull(points) => add(&hull_surface(points).unwrap_or_default())?,
    };
    let (name, body, pose) = (collider.name.clone(), collider.body, pose_numbers(&collider.pose));
    Some(DrawnCollider { name, body, kind, size, pose, mesh })
}

/// The triangles of a surface, without a colour, told from others by their corners; those that name no vertex are left out.
fn mesh_data(surface: &Surface) -> MeshData {
    let corner = |index: &u32| surface.vertices.get(*index as usize).map(|vertex| (*vertex).into());
    let whole = surface.triangles.iter().filter_map(|[a, b, c]| Some([corner(a)?, corner(b)?, corner(c)?]));
    let part: LooseTriangles = (None, whole.flatten().collect());
    let key = sha256(&part.1.iter().flatten().copied().flat_map(f64::to_le_bytes).collect::<Vec<u8>>());
    MeshData { key, content: MeshContent::Log(vec![part]) }
}
