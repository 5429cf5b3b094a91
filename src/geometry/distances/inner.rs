//! Places inside the hull of others in one plane, which those decide about.

use crate::features::both::Candidate;
use crate::shapes::plane::{across, corners};
use nalgebra::{Matrix3, Vector3};

/// Leaves the corners of the hull of places whose normals agree and whose gaps are linear over the plane, to within a length (m).
pub fn without_inner(found: &mut Vec<Candidate>, rounding: f64) {
    if found.len() < 3 {
        return;
    }
    let normal = found[0].normal;
    let (x, y) = across(&normal);
    let flat = |candidate: &Candidate| Vector3::new(x.dot(&candidate.points[0]), y.dot(&candidate.points[0]), 1.0);
    let places: Vec<Vector3<f64>> = found.iter().map(flat).collect();
    let middle = places.iter().sum::<Vector3<f64>>() / places.len() as f64;
    let spread = places.iter().map(|place| (place - middle).norm()).fold(0.0, f64::max);
    let offset = |place: &Vector3<f64>| (place - middle) / spread;
    let square: Matrix3<f64> =
        places.iter().map(|place| offset(place) + Vector3::z()).map(|row| row * row.transpose()).sum();
    let right: Vector3<f64> =
        places.iter().zip(found.iter()).map(|(place, one)| (offset(place) + Vector3::z()) * one.distance()).sum();
    // Places on one line have no plane of their own.
    let linear = square.try_inverse().filter(|inverse| inverse.amax() < 1e6).is_none_or(|inverse| {
        let plane = inverse * right;
        let misses = |(place, one): (&Vector3<f64>, &Candidate)| {
            (plane.dot(&(offset(place) + Vector3::z())) - one.distance()).abs()
                > rounding.max(1e-9 * one.distance().abs())
        };
        !places.iter().zip(found.iter()).any(misses)
    });
    if !linear || found.iter().any(|one| one.normal.dot(&normal) < 1.0 - 1e-9) {
        return;
    }
    let corners = corners(&places, 1e-9 * spread);
    let mut number = 0;
    found.retain(|_| {
        number += 1;
        corners.contains(&(number - 1))
    });
}
