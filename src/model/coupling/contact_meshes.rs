//! The collision shapes of links as shapes of the mechanism: sizes checked, meshes read.

use crate::geometry::{GeometryError, Pieces, check_shape, decompose};
use crate::mechanism::description::contact::Shape;
use crate::meshes::{MeshError, collision_surface, connected_parts};
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
    /// Of meshes that were left out.
    pub warnings: Vec<Warning>,
}

impl ShapeReader {
    /// The shapes that a collision shape of a link of robot `number` stands for: several of a mesh in parts, none of a mesh that cannot be
    /// read, of which there is a warning.
    pub fn shapes(
        &mut self,
        (number, robot): (usize, &Robot),
        link: &str,
        given: &LinkShape,
        choice: LinkShapes,
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
            Geometry::Mesh(mesh) => {
                let reason = match self.hulls(number, mesh, choice) {
                    Ok((shapes, exact)) => {
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
                    Err(Unusable::Pieces(problem)) => {
                        return Err(refuse(CouplingProblem::Pieces {
                            mesh: mesh.path.clone(),
                            problem: Box::new(problem),
                        }));
                    }
                    Err(Unusable::Mesh(reason)) => reason,
                };
                let message = format!("its collision mesh {:?} {reason}, so this shape touches nothing", mesh.path);
                self.warn(robot, link, given.line, message);
                return Ok(Vec::new());
            }
        };
        check_shape(&shape).map_err(|problem| refuse(CouplingProblem::Shape(problem)))?;
        Ok(vec![shape])
    }

    /// Warns of a mesh of a link.
    fn warn(&mut self, robot: &Robot, link: &str, line: usize, message: String) {
        let warning = Warning::odd(&robot.path, Some(line), Some(Element::Link(link.to_string())), message);
        self.warnings.push(warning.in_group(WarningGroup::NotSimulated));
    }

    /// The convex hulls of a mesh and whether they are what was asked for exactly, or why there are none.
    fn hulls(&mut self, number: usize, mesh: &MeshFile, choice: LinkShapes) -> Result<(Vec<Shape>, bool), Unusable> {
        let unusable = |error: MeshError| format!("cannot be used: {error}");
        let name = format!("robot{}: {}", number + 1, mesh.path);
        let source = match self.meshes.iter().find(|source| source.name == name) {
            Some(source) => source,
            None => {
                let (path, bytes) = mesh.read()?;
                self.meshes.push(MeshSource { name, path, bytes });
                &self.meshes[self.meshes.len() - 1]
            }
        };
        let surface =
            collision_surface(std::path::Path::new(&mesh.path), &source.bytes, &mesh.scale).map_err(unusable)?;
        let mut exact = true;
        let parts: Vec<Vec<Vector3<f64>>> = match choice {
            LinkShapes::Decompose => {
                let parts = connected_parts(&surface);
                let pieces: Result<Vec<Pieces>, _> = parts.iter().map(|part| decompose(part, MOST_PIECES)).collect();
                let refused = |error| match error {
                    GeometryError::EnclosesNothing | GeometryError::Open { .. } => Unusable::Pieces(error),
                    error => Unusable::Mesh(format!("cannot be used: {error}")),
                };
                let pieces = pieces.map_err(refused)?;
                exact = pieces.iter().all(|part| part.exact);
                pieces.into_iter().flat_map(|part| part.hulls).collect()
            }
            LinkShapes::Hull | LinkShapes::None => vec![surface.vertices],
        };
        let shapes: Vec<Shape> = parts.into_iter().map(|part| Shape::Hull(Arc::new(part))).collect();
        match shapes.iter().try_for_each(check_shape) {
            Ok(()) => Ok((shapes, exact)),
            Err(problem) => Err(Unusable::Mesh(format!("cannot be used: {problem}"))),
        }
    }
}

/// Why a mesh has no shapes.
enum Unusable {
    /// In words: the mesh is left out.
    Mesh(String),
    /// Pieces were asked for of what has none: an error.
    Pieces(GeometryError),
}

impl From<String> for Unusable {
    fn from(reason: String) -> Self {
        Unusable::Mesh(reason)
    }
}
