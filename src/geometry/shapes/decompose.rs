//! Convex pieces of a closed surface: exact ones, or the pieces of parry's VHACD.
//!
//! A surface is convex where it encloses as much as its hull, to 1e-6 of that, and is then its own piece, exactly. Another one is cut along its own
//! planes ([`crate::shapes::cells`]), if this gives few enough pieces. A surface with very many planes is cut along planes of voxels, of which the
//! longest side of the surface has 64, and each piece is the hull of the part of the surface in its voxels: such pieces are approximate, and reach
//! into hollows.
//!
//! Source: Mamou, Volumetric Hierarchical Approximate Convex Decomposition, Game Engine Gems 3, chapter 12.

use crate::shapes::cells::exact_pieces;
use crate::shapes::error::GeometryError;
use crate::shapes::hull::{check_surface, convex_hull};
use catena_mechanism::description::contact::Surface;
use nalgebra::Vector3;
use parry3d_f64::math::Vector;
use parry3d_f64::transformation::try_convex_hull;
use parry3d_f64::transformation::vhacd::{VHACD, VHACDParameters};
use std::collections::BTreeMap;

/// A surface that encloses less of its hull is not convex.
const CONVEX: f64 = 1.0 - 1e-6;
/// More exact pieces than this are not made.
const MOST_EXACT: usize = 64;

/// Convex pieces of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Pieces {
    /// The points of the hull of each (m).
    pub hulls: Vec<Vec<Vector3<f64>>>,
    /// Whether they enclose exactly the volume of the surface.
    pub exact: bool,
}

/// The convex pieces of a surface: exact ones, or approximate ones, about as many as wanted.
///
/// # Errors
/// [`GeometryError`] for a surface without an extent or triangles, with triangles of vertices that do not exist, or with coordinates that are not
/// finite; and for a flat or open surface, which has no inside.
pub fn decompose(surface: &Surface, most: u32) -> Result<Pieces, GeometryError> {
    check_surface(surface)?;
    let count = surface.vertices.len();
    if surface.triangles.is_empty() {
        return Err(GeometryError::EmptyMesh);
    }
    let middle = surface.vertices.iter().sum::<Vector3<f64>>() / count as f64;
    let size = surface.vertices.iter().map(|vertex| (vertex - middle).norm()).fold(0.0, f64::max);
    if size == 0.0 {
        return Err(GeometryError::EmptyMesh);
    }
    let hull = convex_hull(&surface.vertices).ok();
    if hull.as_ref().is_some_and(|hull| hull.faces.len() == 2) {
        return Err(GeometryError::EnclosesNothing);
    }
    check_closed(surface)?;
    let unit = |vertex: &Vector3<f64>| (vertex - middle) / size;
    let points: Vec<Vector> = surface.vertices.iter().map(unit).map(|p| Vector::new(p.x, p.y, p.z)).collect();
    if encloses(&points, &surface.triangles) >= CONVEX * volume_of_hull(&points) {
        return Ok(Pieces { hulls: vec![surface.vertices.clone()], exact: true });
    }
    if let Some(hulls) = hull.and_then(|hull| exact_pieces(surface, &hull, MOST_EXACT)) {
        return Ok(Pieces { hulls, exact: true });
    }
    let parameters = VHACDParameters { max_convex_hulls: most.max(1), ..VHACDParameters::default() };
    let parts = VHACD::decompose(&parameters, &points, &surface.triangles, true);
    let hulls = parts.compute_exact_convex_hulls(&points, &surface.triangles);
    let back = |point: &Vector| Vector3::new(point.x, point.y, point.z) * size + middle;
    let hulls = hulls.iter().map(|(vertices, _)| vertices.iter().map(back).collect());
    Ok(Pieces { hulls: hulls.filter(|hull: &Vec<_>| hull.len() > 3).collect(), exact: false })
}

/// Whether every edge has as many triangles on one side as on the other: a surface with a border has no inside.
fn check_closed(surface: &Surface) -> Result<(), GeometryError> {
    let mut balance: BTreeMap<[u32; 2], i32> = BTreeMap::new();
    for corners in &surface.triangles {
        for (place, &from) in corners.iter().enumerate() {
            let to = corners[(place + 1) % 3];
            *balance.entry([from.min(to), from.max(to)]).or_default() += if from < to { 1 } else { -1 };
        }
    }
    match balance.values().filter(|balance| **balance != 0).count() {
        0 => Ok(()),
        edges => Err(GeometryError::Open { edges }),
    }
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
