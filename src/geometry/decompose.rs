//! Convex pieces of a surface, by parry's VHACD.
//!
//! A surface is convex where it encloses as much as its hull, to 1e-6 of that, and is then its own piece, exactly; so is a flat one. Another one is cut along
//! planes of voxels, of which the longest side of the surface has 64. Each piece is the hull of the part of the surface in its voxels, so cuts
//! are exact to the size of a voxel. For that reason a decomposition is made only on request.
//!
//! Source: Mamou, Volumetric Hierarchical Approximate Convex Decomposition, Game Engine Gems 3, chapter 12.

use crate::error::GeometryError;
use crate::hull::{check_points, convex_hull};
use catena_mechanism::description::contact::Surface;
use nalgebra::Vector3;
use parry3d_f64::math::Vector;
use parry3d_f64::transformation::try_convex_hull;
use parry3d_f64::transformation::vhacd::{VHACD, VHACDParameters};

/// A surface that encloses less of its hull is not convex.
const CONVEX: f64 = 1.0 - 1e-6;

/// The points of the hulls of the convex pieces (m), at most as many pieces as wanted.
///
/// # Errors
/// [`GeometryError`] for a surface without an extent or triangles, with triangles of vertices that do not exist, or with coordinates that are not
/// finite.
pub fn decompose(surface: &Surface, most: u32) -> Result<Vec<Vec<Vector3<f64>>>, GeometryError> {
    check_points(&surface.vertices)?;
    let count = surface.vertices.len();
    for (triangle, corners) in surface.triangles.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|&&corner| corner as usize >= count) {
            return Err(GeometryError::Index { triangle, vertex, count });
        }
    }
    if surface.triangles.is_empty() {
        return Err(GeometryError::EmptyMesh);
    }
    let middle = surface.vertices.iter().sum::<Vector3<f64>>() / count as f64;
    let size = surface.vertices.iter().map(|vertex| (vertex - middle).norm()).fold(0.0, f64::max);
    if size == 0.0 {
        return Err(GeometryError::EmptyMesh);
    }
    // What is flat encloses nothing, and is its own piece.
    if convex_hull(&surface.vertices).is_ok_and(|hull| hull.faces.len() == 2) {
        return Ok(vec![surface.vertices.clone()]);
    }
    let unit = |vertex: &Vector3<f64>| (vertex - middle) / size;
    let points: Vec<Vector> = surface.vertices.iter().map(unit).map(|p| Vector::new(p.x, p.y, p.z)).collect();
    if encloses(&points, &surface.triangles) >= CONVEX * volume_of_hull(&points) {
        return Ok(vec![surface.vertices.clone()]);
    }
    let parameters = VHACDParameters { max_convex_hulls: most.max(1), ..VHACDParameters::default() };
    let parts = VHACD::decompose(&parameters, &points, &surface.triangles, true);
    let hulls = parts.compute_exact_convex_hulls(&points, &surface.triangles);
    let back = |point: &Vector| Vector3::new(point.x, point.y, point.z) * size + middle;
    Ok(hulls
        .iter()
        .map(|(vertices, _)| vertices.iter().map(back).collect())
        .filter(|hull: &Vec<_>| hull.len() > 3)
        .collect())
}

/// Volume that triangles enclose: the sum of a · (b × c) / 6 over their corners.
fn encloses(points: &[Vector], triangles: &[[u32; 3]]) -> f64 {
    let sixfold = |[a, b, c]: [Vector; 3]| a.dot(b.cross(c));
    triangles.iter().map(|corners| sixfold(corners.map(|corner| points[corner as usize]))).sum::<f64>().abs() / 6.0
}

/// Volume of the hull of points; infinite where no hull is found.
fn volume_of_hull(points: &[Vector]) -> f64 {
    try_convex_hull(points).map_or(f64::INFINITY, |(vertices, triangles)| encloses(&vertices, &triangles))
}
