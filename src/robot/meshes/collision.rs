//! The surfaces of shapes that touch, from mesh files: with shared vertices and the scale of a URDF or scene file.
//!
//! Corners of triangles with the same coordinates, bit for bit, become one vertex, in the order in which they come. Triangles with two equal corners
//! are left out. The scale s has one factor for each axis: a vertex p lies at (s₁ p₁, s₂ p₂, s₃ p₃). If s₁ s₂ s₃ < 0, the scale mirrors, and the
//! triangles are turned round so that they stay counterclockwise from outside.

use crate::mechanism::description::contact::Surface;
use crate::mechanism::ground::disjoint_sets::DisjointSets;
use crate::meshes::error::MeshError;
use crate::meshes::{ending_of, read_surface};
use nalgebra::Vector3;
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};
use std::path::Path;

/// Twice the area below which a triangle is degenerate, relative to the square of its longest side.
const NO_AREA: f64 = 1e-12;

/// A hash of coordinates: their bits, multiplied by an odd number with as many ones as zeros, one after the other.
#[derive(Default)]
struct OfBits(u64);

impl Hasher for OfBits {
    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|byte| self.write_u64(u64::from(*byte)));
    }

    fn write_u64(&mut self, bits: u64) {
        // The high bits of a product depend on all bits of its factor, and the next factor has them below.
        self.0 = (self.0.rotate_left(32) ^ bits).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    }

    fn finish(&self) -> u64 {
        self.0 ^ (self.0 >> 32)
    }
}

/// The surface in the bytes of a mesh file, scaled along the axes (m). The ending of the path says which format it has.
///
/// # Errors
/// [`MeshError`] if it is no mesh, or one without triangles that have an area.
pub fn collision_surface(path: &Path, bytes: &[u8], scale: &Vector3<f64>) -> Result<Surface, MeshError> {
    let read = read_surface(&ending_of(path), bytes, &|_| None)?;
    let corners = read.parts.iter().flat_map(|part| part.corners.chunks_exact(3));
    surface(corners.map(|corners| [0, 1, 2].map(|corner| Vector3::from(corners[corner]))), scale)
}

/// The surface of triangles, scaled along the axes.
fn surface(triangles: impl Iterator<Item = [Vector3<f64>; 3]>, scale: &Vector3<f64>) -> Result<Surface, MeshError> {
    let mirrors = scale.iter().filter(|factor| **factor < 0.0).count() % 2 == 1;
    let mut surface = Surface::default();
    let mut known: HashMap<(u64, u64, u64), u32, BuildHasherDefault<OfBits>> = HashMap::default();
    for corners in triangles {
        let mut numbers = [0; 3];
        for (number, corner) in numbers.iter_mut().zip(&corners) {
            // A zero has no sign here.
            let place = corner.component_mul(scale).map(|coordinate| coordinate + 0.0);
            if !place.iter().all(|coordinate| coordinate.is_finite()) {
                return Err(MeshError::NotFinite);
            }
            *number = *known.entry((place.x.to_bits(), place.y.to_bits(), place.z.to_bits())).or_insert_with(|| {
                surface.vertices.push(place);
                (surface.vertices.len() - 1) as u32
            });
        }
        if mirrors {
            numbers.swap(1, 2);
        }
        let [a, b, c] = numbers;
        if a != b && b != c && c != a {
            surface.triangles.push(numbers);
        }
    }
    if surface.triangles.is_empty() {
        return Err(MeshError::Empty);
    }
    let has_area = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|corner| surface.vertices[corner as usize]);
        let longest = (b - a).norm_squared().max((c - b).norm_squared()).max((a - c).norm_squared());
        (b - a).cross(&(c - a)).norm() > NO_AREA * longest
    };
    if surface.triangles.iter().any(has_area) { Ok(surface) } else { Err(MeshError::NoArea) }
}

/// The connected parts of a surface, in the order of their first vertices.
pub fn connected_parts(surface: &Surface) -> Vec<Surface> {
    let mut joined = DisjointSets::new(surface.vertices.len());
    for corners in &surface.triangles {
        let [a, b, c] = corners.map(|corner| corner as usize);
        joined.unite(a, b);
        joined.unite(a, c);
    }
    let mut parts: Vec<Surface> = Vec::new();
    // Part and number in the part of each vertex.
    let mut places: Vec<(usize, u32)> = Vec::with_capacity(surface.vertices.len());
    for (part, point) in joined.numbers().into_iter().zip(&surface.vertices) {
        if part == parts.len() {
            parts.push(Surface::default());
        }
        places.push((part, parts[part].vertices.len() as u32));
        parts[part].vertices.push(*point);
    }
    for corners in &surface.triangles {
        let part = places[corners[0] as usize].0;
        parts[part].triangles.push(corners.map(|corner| places[corner as usize].1));
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tetrahedron(at: f64) -> Vec<[Vector3<f64>; 3]> {
        let [o, x, y, z] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
            .map(|[x, y, z]| Vector3::new(x + at, y, z));
        vec![[o, y, x], [o, x, z], [o, z, y], [x, y, z]]
    }

    /// Six times the volume that triangles enclose.
    fn volume(surface: &Surface) -> f64 {
        let corner = |index: u32| surface.vertices[index as usize];
        surface.triangles.iter().map(|&[a, b, c]| corner(a).dot(&corner(b).cross(&corner(c)))).sum()
    }

    #[test]
    fn corners_are_merged_and_a_scale_that_mirrors_keeps_the_outside_outside() {
        for (scale, expected) in [([1.0, 1.0, 1.0], 1.0), ([2.0, -1.0, 0.5], 1.0), ([-1.0, -1.0, 3.0], 3.0)] {
            let surface = surface(tetrahedron(0.0).into_iter(), &Vector3::from(scale)).unwrap();
            assert_eq!((surface.vertices.len(), surface.triangles.len()), (4, 4));
            assert_eq!(volume(&surface), expected, "{scale:?}");
        }
    }

    #[test]
    fn what_encloses_nothing_or_is_nowhere_is_refused() {
        let one = Vector3::repeat(1.0);
        let line = [[Vector3::zeros(), one, one]];
        assert!(matches!(surface(line.into_iter(), &one), Err(MeshError::Empty)));
        assert!(matches!(surface(std::iter::empty(), &one), Err(MeshError::Empty)));
        let far = [[Vector3::zeros(), Vector3::x(), Vector3::repeat(1e300)]];
        assert!(matches!(surface(far.into_iter(), &Vector3::repeat(1e300)), Err(MeshError::NotFinite)));
        let unknown = collision_surface(Path::new("a.ply"), b"", &one);
        assert!(matches!(unknown, Err(MeshError::UnknownKind { ending }) if ending == "ply"));
    }

    #[test]
    fn parts_that_share_no_vertex_are_told_apart() {
        let both = [tetrahedron(0.0), tetrahedron(5.0)].concat();
        let surface = surface(both.into_iter(), &Vector3::repeat(1.0)).unwrap();
        let parts = connected_parts(&surface);
        for (part, at) in parts.iter().zip([0.0, 5.0]) {
            assert_eq!((part.vertices.len(), part.triangles.len()), (4, 4));
            assert!(part.vertices.iter().all(|point| (at..=at + 1.0).contains(&point.x)));
            // Their triangles name their own vertices.
            assert_eq!(volume(part), 1.0);
        }
        assert_eq!(parts.len(), 2);
    }
}
