//! Parts of a mesh: vertices without doubles, and boxes along the axes, by which its tree finds triangles.

use crate::shapes::convex::Convex;
use catena_mechanism::description::joint::Pose;
use nalgebra::Vector3;
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::Vector;
use std::collections::BTreeMap;

/// Vertices in the frame of the body, vertices at the same place once, and the new number of each.
pub fn merged(vertices: &[Vector3<f64>], pose: &Pose) -> (Vec<Vector3<f64>>, Vec<usize>) {
    let mut numbers: BTreeMap<[u64; 3], usize> = BTreeMap::new();
    let mut kept = Vec::new();
    let mut of = Vec::with_capacity(vertices.len());
    for vertex in vertices {
        // Adding zero makes both zeros the same.
        let key = [0, 1, 2].map(|axis| (vertex[axis] + 0.0).to_bits());
        let number = *numbers.entry(key).or_insert_with(|| {
            kept.push(pose.rotation * vertex + pose.translation.vector);
            kept.len() - 1
        });
        of.push(number);
    }
    (kept, of)
}

/// The box of the core of a shape.
pub fn bounds(shape: &Convex) -> Aabb {
    let corner = |sign: f64| {
        let along = |axis: Vector3<f64>| sign * shape.core.support(&(axis * sign));
        Vector::new(along(Vector3::x()), along(Vector3::y()), along(Vector3::z()))
    };
    Aabb::new(corner(-1.0), corner(1.0))
}

/// A box about a point (m).
pub fn about(centre: &Vector3<f64>, half: f64) -> Aabb {
    let middle = Vector::new(centre.x, centre.y, centre.z);
    Aabb::new(middle - Vector::splat(half), middle + Vector::splat(half))
}
