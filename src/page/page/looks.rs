//! The drawn geometry of links: primitives, meshes, and boxes for bodies without geometry.
//!
//! A mesh is read once however many visuals show it. Its colours come from its file, if that has any; else from the `<material>` of the visual, as in
//! RViz. [`Looks::notes`] names the visuals that cannot be drawn.

use crate::mechanism::description::joint::Pose;
use crate::mechanism::ground::words::counted;
use crate::model::{Model, PlacedRobot};
pub use crate::output::log::messages::standin::{STANDIN_COLOR, standins};
use crate::page::shared_meshes::{MeshContent, MeshData, SharedMeshes};
use crate::page::tree::pose_numbers;
use crate::scene::{Geometry, MeshFile, Shape};
use nalgebra::Vector3;
use serde::Serialize;

/// Gives the file of a mesh: of this link, the visual that is its so-manieth with a mesh, from 0.
///
/// The error is the reason of its absence, without the name of the file.
pub(crate) type MeshSource<'s> = dyn Fn(&str, usize, &MeshFile) -> Result<MeshData, String> + 's;

/// Something drawn on a link.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct DrawnShape {
    /// The link, by its number in the model.
    pub link: usize,
    /// `box` (edges), `sphere` (radius), `cylinder` and `capsule` (radius, length; axis z), `mesh` (scale).
    pub kind: &'static str,
    /// Lengths (m) or factors, as the kind says.
    pub size: Vec<f64>,
    /// The frame of the shape in the link frame: x, y, z (m), then w, x, y, z.
    pub pose: [f64; 7],
    /// Red, green, blue, opacity in 0..1; `null`: the page's own grey.
    pub color: Option<[f64; 4]>,
    /// The mesh, by its number.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh: Option<usize>,
    /// Whether its quarters about z have two colours in turn, so that its rolling is seen.
    #[serde(skip_serializing_if = "is_false")]
    pub seam: bool,
}

fn is_false(value: &bool) -> bool {
    !value
}

/// Everything that is drawn.
pub(crate) struct Looks {
    /// Shapes of all links.
    pub shapes: Vec<DrawnShape>,
    /// The meshes that they name.
    pub meshes: SharedMeshes,
    /// Visuals that are not drawn, or not as in the files, in sentences.
    pub notes: Vec<String>,
}

/// Gathers the looks of all robots of a model; `with_meshes` false leaves all meshes out.
pub(crate) fn looks(model: &Model, source: &MeshSource, with_meshes: bool) -> Looks {
    let mut looks = Looks { shapes: Vec::new(), meshes: SharedMeshes::default(), notes: Vec::new() };
    let mut missing: Vec<String> = Vec::new();
    let (mut left_out, mut boxes) = (0, 0);
    for placed in &model.robots {
        // Bodies without a drawable visual have boxes, like bodies without visuals.
        let mut drawable: PlacedRobot = placed.clone();
        for (number, link) in drawable.robot.links.iter_mut().enumerate() {
            let index = placed.links.start + number;
            let mut with_mesh = 0;
            let is_alone = link.visuals.len() == 1;
            link.visuals.retain(|visual| {
                let Geometry::Mesh(mesh) = &visual.geometry else {
                    looks.shapes.push(DrawnShape { seam: is_alone && rolls(visual), ..primitive(index, visual) });
                    return true;
                };
                with_mesh += 1;
                if !with_meshes {
                    left_out += 1;
                    return false;
                }
                let name = &model.links[index].name;
                let data = source(name, with_mesh - 1, mesh);
                let is_scaled = matches!(data, Ok(MeshData { content: MeshContent::Log(_), .. }));
                let scale = if is_scaled { Vector3::repeat(1.0) } else { mesh.scale };
                match data.and_then(|data| looks.meshes.add(data)) {
                    Ok(shared) => {
                        let mut drawn = shape(index, "mesh", scale.as_slice(), &visual.origin, visual.color);
                        drawn.mesh = Some(shared);
                        looks.shapes.push(drawn);
                        true
                    }
                    Err(reason) => {
                        missing.push(format!("{} of link {name}: {reason}", mesh.path));
                        false
                    }
                }
            });
        }
        for standin in standins(model, &drawable) {
            boxes += 1;
            let (index, color) = (placed.links.start + standin.link, Some(STANDIN_COLOR));
            looks.shapes.push(shape(index, "box", standin.size.as_slice(), &standin.pose, color));
        }
    }
    if left_out > 0 {
        looks.notes.push(format!("{} left out, as --mesh-limit 0 asks", counted(left_out, "mesh is", "meshes are")));
    }
    if let Some(first) = missing.first() {
        let others = match missing.len() - 1 {
            0 => String::new(),
            others => format!(" (and {} more)", counted(others, "mesh", "meshes")),
        };
        looks.notes.push(format!("mesh not drawn: {first}{others}"));
    }
    if boxes > 0 {
        let bodies = counted(boxes, "link is drawn as a blue box", "links are drawn as blue boxes");
        looks.notes.push(format!("{bodies} of the same mass and inertia, because nothing else can be drawn of them"));
    }
    looks
}

/// Whether a shape, which is all of its link, looks the same while it rolls: a ball, or a disc that is thinner than its radius.
fn rolls(visual: &Shape) -> bool {
    match visual.geometry {
        Geometry::Sphere { .. } => true,
        Geometry::Cylinder { radius, length } => length < radius,
        _ => false,
    }
}

fn primitive(link: usize, visual: &Shape) -> DrawnShape {
    let (kind, size): (_, &[f64]) = match &visual.geometry {
        Geometry::Box { size } => ("box", size.as_slice()),
        Geometry::Sphere { radius } => ("sphere", &[*radius]),
        Geometry::Cylinder { radius, length } => ("cylinder", &[*radius, *length]),
        Geometry::Capsule { radius, length } => ("capsule", &[*radius, *length]),
        Geometry::Ellipsoid { radii } => ("ellipsoid", radii.as_slice()),
        Geometry::Mesh(mesh) => ("mesh", mesh.scale.as_slice()),
    };
    shape(link, kind, size, &visual.origin, visual.color)
}

fn shape(link: usize, kind: &'static str, size: &[f64], origin: &Pose, color: Option<[f64; 4]>) -> DrawnShape {
    DrawnShape { link, kind, size: size.to_vec(), pose: pose_numbers(origin), color, mesh: None, seam: false }
}
