//! Convex pieces of a surface that is not convex, by parry's VHACD.
//!
//! The pieces are hulls of voxels or of what of the surface lies in them: together they cover the shape up to the size of a voxel. They are
//! as exact as that, so a decomposition is asked for, never made by itself.

use crate::error::GeometryError;
use crate::hull::check_points;
use catena_mechanism::description::contact::Surface;
use nalgebra::Vector3;
use parry3d_f64::math::Vector;
use parry3d_f64::transformation::vhacd::{VHACD, VHACDParameters};

/// The points of the hulls of the convex pieces (m), at most as many pieces as wanted.
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
    let unit = |vertex: &Vector3<f64>| (vertex - middle) / size;
    let points: Vec<Vector> = surface.vertices.iter().map(unit).map(|p| Vector::new(p.x, p.y, p.z)).collect();
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
