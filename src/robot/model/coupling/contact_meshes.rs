//! The collision shapes of links as shapes of the mechanism: sizes checked, meshes read.

use crate::geometry::{GeometryError, Pieces, check_shape, decompose};
use crate::mechanism::description::contact::Shape;
use crate::mechanism::description::joint::Pose;
use crate::meshes::{collision_surface, connected_parts};
use crate::model::description::coupling_error::{CouplingError, CouplingProblem};
use crate::model::description::model_error::ModelError;
use crate::scene::{
    Element, Geometry, LinkShapes, MeshFile, MeshSource, Robot, Shape as LinkShape, Warning, WarningGroup,
};
use nalgebra::Vector3;
use std::sync::Arc;

/// Most convex pieces of a connected part of a mesh where they are approximate.
const MOST_PIECES: u32 = 16;

/// Reads the collision shapes of links.
#[derive(Default)]
pub(crate) struct ShapeReader {
    /// The meshes that were read, each once for each robot.
    pub meshes: Vec<MeshSource>,
    /// Warnings of meshes that were not found, and of pieces that are approximate.
    pub warnings: Vec<Warning>,
}

impl ShapeReader {
    /// The shapes for a collision shape of a link of the robot of file `number`: several for a mesh in parts, zero and a warning for a mesh that is
    /// not found. The link is given by its names in the URDF and in the scene, the shape by its place among the shapes of the link; `pose` is its frame
    /// in the body.
    ///
    /// # Errors
    /// [`ModelError`] for shapes without size, and for meshes that are there and cannot be used: a run without them would be one of another robot.
    pub fn shapes(
        &mut self,
        (number, robot): (usize, &Robot),
        [link, touching]: [&str; 2],
        (place, given): (usize, &LinkShape),
        choice: LinkShapes,
        pose: &Pose,
    ) -> Result<Vec<Shape>, ModelError> {
        let refuse = |problem: CouplingProblem| {
            let (file, element) = (robot.path.clone(), Element::Link(link.to_string()));
            ModelError::Coupling(CouplingError { file, line: given.line, element, problem })
        };
        let positive = |what: &'static str, size: f64| match size > 0.0 {
            true => Ok(size),
            false => Err(refuse(CouplingProblem::ShapeSize { what, size })),
        };
        let shape = match &given.geometry {
            Geometry::Box { size } => {
                size.iter().try_for_each(|&edge| positive("size of its box", edge).map(drop))?;
                Shape::Box { half: 0.5 * size }
            }
            Geometry::Sphere { radius } => Shape::Sphere { radius: positive("radius of its sphere", *radius)? },
            Geometry::Cylinder { radius, length } => Shape::Cylinder {
                radius: positive("radius of its cylinder", *radius)?,
                half: 0.5 * positive("length of its cylinder", *length)?,
            },
            Geometry::Capsule { radius, length } => Shape::Capsule {
                radius: positive("radius of its capsule", *radius)?,
                half: 0.5 * positive("length of its capsule", *length)?,
            },
            Geometry::Ellipsoid { radii } => {
                radii.iter().try_for_each(|&radius| positive("semi-axis of its ellipsoid", radius).map(drop))?;
                Shape::Ellipsoid { radii: *radii }
            }
            Geometry::Mesh(mesh) => {
                let unusable = |problem: String| CouplingProblem::Mesh {
                    mesh: mesh.path.as_str().into(),
                    problem: problem.into(),
                    shape_of: Box::new((touching.to_string(), place)),
                };
                let Some(source) = self.source(number, mesh).map_err(|problem| refuse(unusable(problem)))? else {
                    let message =
                        format!("its collision mesh {:?} was not found, so this shape touches nothing", mesh.path);
                    self.warn(robot, link, given.line, message);
                    return Ok(Vec::new());
                };
                let (shapes, exact) = hulls(&source, mesh, choice, pose).map_err(|why| {
                    refuse(match why {
                        Unusable::Mesh(problem) => unusable(problem),
                        Unusable::Pieces(problem) => {
                            CouplingProblem::Pieces { mesh: mesh.path.clone(), problem: Box::new(problem) }
                        }
                    })
                })?;
                if !exact {
                    let message = format!(
                        "its collision mesh {:?} has too many planes to be cut exactly, so {} approximate pieces reach into its hollows",
                        mesh.path,
                        shapes.len()
                    );
                    self.warn(robot, link, given.line, message);
                }
                return Ok(shapes);
            }
        };
        check_shape(&shape, pose).map_err(|problem| refuse(CouplingProblem::Shape(problem)))?;
        Ok(vec![shape])
    }

    /// Warns of a mesh of a link.
    fn warn(&mut self, robot: &Robot, link: &str, line: usize, message: String) {
        let warning = Warning::odd(&robot.path, Some(line), Some(Element::Link(link.to_string())), message);
        self.warnings.push(warning.in_group(WarningGroup::NotSimulated));
    }

    /// The file of a mesh and its bytes, read once for each robot; `None` if there is no such file.
    fn source(&mut self, number: usize, mesh: &MeshFile) -> Result<Option<MeshSource>, String> {
        let name = format!("robot{}: {}", number + 1, mesh.path);
        if let Some(source) = self.meshes.iter().find(|source| source.name == name) {
            return Ok(Some(source.clone()));
        }
        let Some(read) = mesh.read() else { return Ok(None) };
        let (path, bytes) = read.map_err(|error| format!("it cannot be read: {error}"))?;
        let source = MeshSource { name, path, bytes };
        self.meshes.push(source.clone());
        Ok(Some(source))
    }
}

/// The convex hulls of a mesh and whether they are exact, or the reason why it cannot be used.
fn hulls(
    source: &MeshSource,
    mesh: &MeshFile,
    choice: LinkShapes,
    pose: &Pose,
) -> Result<(Vec<Shape>, bool), Unusable> {
    let surface = collision_surface(std::path::Path::new(&mesh.path), &source.bytes, &mesh.scale);
    let surface = surface.map_err(|error| Unusable::Mesh(error.to_string()))?;
    let mut exact = true;
    let parts: Vec<Vec<Vector3<f64>>> = match choice {
        LinkShapes::Decompose => {
            let parts = connected_parts(&surface);
            let pieces: Result<Vec<Pieces>, _> = parts.iter().map(|part| decompose(part, MOST_PIECES)).collect();
            let pieces = pieces.map_err(|error| match error {
                GeometryError::EnclosesNothing | GeometryError::Open { .. } => Unusable::Pieces(error),
                error => Unusable::Mesh(error.to_string()),
            })?;
            exact = pieces.iter().all(|part| part.exact);
            pieces.into_iter().flat_map(|part| part.hulls).collect()
        }
        LinkShapes::Hull | LinkShapes::None => vec![surface.vertices],
    };
    let shapes: Vec<Shape> = parts.into_iter().map(|part| Shape::Hull(Arc::new(part))).collect();
    let checked = shapes.iter().try_for_each(|shape| check_shape(shape, pose));
    checked.map_err(|problem| Unusable::Mesh(problem.to_string()))?;
    Ok((shapes, exact))
}

/// Why a mesh that is there has no shapes.
enum Unusable {
    /// In words.
    Mesh(String),
    /// The mesh cannot be cut into the requested pieces.
    Pieces(GeometryError),
}
