//! The visual geometry of robots as markers, fixed to the frames of their links.
//!
//! Boxes, spheres, cylinders and capsules become primitives with the colour of their material. Mesh files become triangles in the log, up
//! to a limit, so that it shows the robot on any machine, or their addresses. Bodies without looks have a
//! stand-in ([`crate::output::log::messages::standin`]).

use crate::mechanism::ground::words::counted;
use crate::meshes::{Surface, read_file};
use crate::output::log::encoding::markers::{Marker, MarkerShape, primitives};
use crate::output::log::messages::options::Meshes;
use crate::output::log::messages::standin::{STANDIN_COLOR, Standin};
use crate::scene::{Geometry, Link, MeshFile, Shape};
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// Visuals without a material are drawn in this grey.
const PLAIN: [f64; 4] = [0.7, 0.7, 0.72, 1.0];

/// Most triangles of all meshes of looks in a log together, and of all collision meshes.
pub(crate) const MOST_TRIANGLES: usize = 2_000_000;

/// The drawn geometry of all robots.
pub(crate) struct Looks {
    /// The markers, link after link.
    pub markers: Vec<Marker>,
    meshes: Meshes,
    /// Surfaces by their files; `None` of those that cannot be in the log.
    surfaces: BTreeMap<PathBuf, Option<Rc<Surface>>>,
    triangles: usize,
    missing: Vec<String>,
}

impl Looks {
    /// Looks without a robot.
    pub(crate) fn new(meshes: Meshes) -> Self {
        Looks { markers: Vec::new(), meshes, surfaces: BTreeMap::new(), triangles: 0, missing: Vec::new() }
    }

    /// Warnings of missing looks: one line for all meshes that are not in the log for the same kind of reason.
    pub(crate) fn warnings(&self) -> Vec<String> {
        let Some(first) = self.missing.first() else { return Vec::new() };
        match self.missing.len() {
            1 => vec![first.clone()],
            count => vec![format!("{first}; and {} more", counted(count - 1, "mesh", "meshes"))],
        }
    }

    /// The surfaces that are in the log, by their files.
    pub(crate) fn surfaces(&self) -> impl Iterator<Item = (&Path, &Surface)> {
        self.surfaces.iter().filter_map(|(file, surface)| Some((file.as_path(), surface.as_deref()?)))
    }

    /// Adds the links of a robot that have looks or a stand-in, with `prefix` before their names.
    pub(crate) fn add(&mut self, links: &[Link], prefix: &str, standins: &[Standin]) {
        for (index, link) in links.iter().enumerate() {
            let frame = format!("{prefix}{}", link.name);
            for (number, visual) in (0..).zip(&link.visuals) {
                self.add_visual((&frame, number), visual);
            }
            for standin in standins.iter().filter(|standin| standin.link == index) {
                let (pose, scale) = (standin.pose, standin.size.into());
                let (frame, namespace) = (frame.clone(), frame.clone());
                let (visual, color, shape) = (link.visuals.len() as u32, STANDIN_COLOR, MarkerShape::Cube);
                self.markers.push(Marker { frame, namespace, visual, pose, scale, color, shape });
            }
        }
    }

    fn add_visual(&mut self, (frame, number): (&str, u32), visual: &Shape) {
        if let Geometry::Mesh(mesh) = &visual.geometry {
            return self.add_mesh((frame, number), visual, mesh);
        }
        let color = visual.color.unwrap_or(PLAIN);
        for (pose, scale, shape) in primitives(&visual.geometry, &visual.origin) {
            let (frame, namespace) = (frame.to_string(), frame.to_string());
            self.markers.push(Marker { frame, namespace, visual: number, pose, scale, color, shape });
        }
    }

    fn add_mesh(&mut self, (frame, number): (&str, u32), visual: &Shape, mesh: &MeshFile) {
        // A file that was not found is a warning of the robot already.
        let surface = mesh.resolved.as_ref().filter(|_| self.meshes == Meshes::Embed);
        let Some(surface) = surface.and_then(|file| self.surface(file)) else {
            let address = mesh.resolved.as_deref().map_or_else(|| mesh.path.clone(), address);
            let (color, shape) = (visual.color.unwrap_or(PLAIN), MarkerShape::Mesh(address, visual.color.is_none()));
            let (pose, scale) = (visual.origin, mesh.scale.into());
            let (frame, namespace) = (frame.to_string(), frame.to_string());
            self.markers.push(Marker { frame, namespace, visual: number, pose, scale, color, shape });
            return;
        };
        for part in &surface.parts {
            let color = visual.color.unwrap_or_else(|| part.shown_color().map(f64::from));
            let shape = MarkerShape::Triangles(scaled(&part.corners, &mesh.scale).into());
            let (frame, namespace, pose) = (frame.to_string(), frame.to_string(), visual.origin);
            self.markers.push(Marker { frame, namespace, visual: number, pose, scale: [1.0; 3], color, shape });
        }
    }

    /// The surface of a mesh file, if it can be in the log.
    fn surface(&mut self, file: &Path) -> Option<Rc<Surface>> {
        if let Some(known) = self.surfaces.get(file) {
            return known.clone();
        }
        let surface = match read_file(file) {
            Ok(surface) if self.triangles + surface.triangle_count() > MOST_TRIANGLES => {
                self.missing.push(format!(
                    "the mesh {} is not in the log: all meshes together have more than {MOST_TRIANGLES} triangles; \
                     use simpler meshes or --meshes link",
                    file.display()
                ));
                None
            }
            Ok(surface) => {
                self.triangles += surface.triangle_count();
                Some(Rc::new(surface))
            }
            Err(error) => {
                self.missing.push(format!("the mesh {} is not in the log: {error}", file.display()));
                None
            }
        };
        self.surfaces.insert(file.to_path_buf(), surface.clone());
        surface
    }
}

/// The address of a file.
pub(crate) fn address(file: &Path) -> String {
    format!("file://{}", std::path::absolute(file).unwrap_or_else(|_| file.to_path_buf()).display())
}

/// Corners times the factors of a URDF; triangles that this mirrors stay counter-clockwise seen from outside.
fn scaled(corners: &[[f64; 3]], scale: &Vector3<f64>) -> Vec<[f32; 3]> {
    let factors: [f64; 3] = (*scale).into();
    let stretch = |corner: &[f64; 3]| [0, 1, 2].map(|axis| (corner[axis] * factors[axis]) as f32);
    let mut all: Vec<[f32; 3]> = corners.iter().map(stretch).collect();
    if factors.iter().product::<f64>() < 0.0 {
        all.chunks_exact_mut(3).for_each(|triangle| triangle.swap(1, 2));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::scaled;
    use nalgebra::Vector3;

    #[test]
    fn mirrored_triangles_still_look_outwards() {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        for scale in [Vector3::new(-2.0, 1.0, 1.0), Vector3::new(2.0, 3.0, 1.0), Vector3::new(-1.0, -1.0, 1.0)] {
            let [a, b, c] = scaled(&corners, &scale)[..] else { panic!("three corners") };
            let [a, b, c] = [a, b, c].map(Vector3::from);
            assert!((b - a).cross(&(c - a)).z > 0.0, "{scale}");
        }
    }
}
