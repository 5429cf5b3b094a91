//! The drawn geometry of obstacles: the shapes of the world that links may touch.
//!
//! Drawn are the colliders that the model has of its obstacles, so that the page shows what the simulation knows: none where contact is left
//! out. A half space `z ≤ 0` of its frame is drawn as a tile in its plane, whose size the page chooses.

use crate::mechanism::description::contact::{Shape, Surface};
use crate::mechanism::ground::words::counted;
use crate::model::{Model, Owner};
use crate::output::page::looks::Looks;
use crate::output::page::shared_meshes::LooseTriangles;
use crate::output::page::tree::pose_numbers;
use serde::Serialize;

/// An obstacle.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct DrawnObstacle {
    name: String,
    /// `half_space`, `box` (edges), `sphere` (radius), `cylinder` and `capsule` (radius, length; axis z), `mesh` (scale).
    kind: &'static str,
    /// Lengths (m) or factors, as the kind says.
    size: Vec<f64>,
    /// Its frame in the world: x, y, z (m), then w, x, y, z.
    pose: [f64; 7],
    /// The mesh, by its number.
    #[serde(skip_serializing_if = "Option::is_none")]
    mesh: Option<usize>,
}

/// Gathers the obstacles of a model, and adds their meshes to those of the robots; `with_meshes` false leaves meshes out.
pub(super) fn obstacles(model: &Model, looks: &mut Looks, with_meshes: bool) -> Vec<DrawnObstacle> {
    let colliders = model.mechanism.nonsmooth.colliders.iter().zip(&model.contact.owners);
    let mut left_out = 0;
    let mut drawn = Vec::new();
    for (collider, _) in colliders.filter(|(_, owner)| matches!(owner, Owner::Obstacle(_))) {
        let mut mesh = None;
        let (kind, size) = match &collider.shape {
            Shape::HalfSpace => ("half_space", Vec::new()),
            Shape::Sphere { radius } => ("sphere", vec![*radius]),
            Shape::Capsule { radius, half } => ("capsule", vec![*radius, 2.0 * half]),
            Shape::Cylinder { radius, half } => ("cylinder", vec![*radius, 2.0 * half]),
            Shape::Box { half } => ("box", half.iter().map(|half| 2.0 * half).collect()),
            Shape::Mesh(surface) if with_meshes => {
                mesh = Some(looks.meshes.add_surface(&[part(surface)]));
                ("mesh", vec![1.0; 3])
            }
            // Readers make hulls of links alone.
            Shape::Mesh(_) | Shape::Hull(_) => {
                left_out += 1;
                continue;
            }
        };
        drawn.push(DrawnObstacle { name: collider.name.clone(), kind, size, pose: pose_numbers(&collider.pose), mesh });
    }
    if left_out > 0 {
        let meshes = counted(left_out, "obstacle is", "obstacles are");
        looks.notes.push(format!("{meshes} not drawn, because --mesh-limit 0 leaves meshes out"));
    }
    drawn
}

/// The triangles of a surface, without a colour; those that name no vertex are left out.
fn part(surface: &Surface) -> LooseTriangles {
    let corner = |index: &u32| surface.vertices.get(*index as usize).map(|vertex| (*vertex).into());
    let whole = surface.triangles.iter().filter_map(|[a, b, c]| Some([corner(a)?, corner(b)?, corner(c)?]));
    (None, whole.flatten().collect())
}
