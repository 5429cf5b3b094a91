//! Frames and outlines in a plane.
//!
//! Source of the outline: A. M. Andrew, Another efficient algorithm for convex hulls in two dimensions, Information Processing Letters 9 (1979).

use nalgebra::Vector3;

/// Two unit vectors that make a right-handed frame with a third one as its z axis.
pub fn across(axis: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
    let other = if axis.x.abs() < 0.6 { Vector3::x() } else { Vector3::y() };
    let x = (other - axis * axis.dot(&other)).normalize();
    (x, axis.cross(&x))
}

/// The corners of the convex hull of points in the plane (x, y), without points within a length of a side: Andrew's monotone chain.
pub fn corners(places: &[Vector3<f64>], same: f64) -> Vec<usize> {
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_by(|&one, &other| {
        places[one].x.total_cmp(&places[other].x).then(places[one].y.total_cmp(&places[other].y))
    });
    let turns_left = |chain: &[usize], next: usize| {
        let (from, by, to) = (places[chain[chain.len() - 2]], places[chain[chain.len() - 1]], places[next]);
        let (first, second) = (by - from, to - from);
        first.x * second.y - first.y * second.x > same * second.norm()
    };
    let half = |order: &mut dyn Iterator<Item = usize>| {
        let mut chain: Vec<usize> = Vec::new();
        for next in order {
            while chain.len() >= 2 && !turns_left(&chain, next) {
                chain.pop();
            }
            chain.push(next);
        }
        chain.pop();
        chain
    };
    let mut lower = half(&mut order.iter().copied());
    lower.extend(half(&mut order.iter().rev().copied()));
    lower
}
