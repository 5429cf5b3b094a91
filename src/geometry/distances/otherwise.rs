//! The places of two shapes that touch, along each of the face normals that separate them: at an edge on an edge there are several.
//!
//! ```text
//!     N = {n: sep(n) ≥ d − ε}      n: normals of faces of either, d the distance, ε what counts as touching (m)
//! ```
//!
//! All of N are the normal of the distance but for roundings. Geometry alone cannot choose among them; the motion can. Flat faces alone are looked at:
//! rims have one normal at each of their points.

use crate::distances::manifold::manifold_along;
use crate::distances::nearest::nearest;
use crate::features::both::{Both, Candidate};
use crate::features::feature::normals;
use crate::shapes::convex::Core;

/// Normals that agree to this are one.
const AGREE: f64 = 1.0 - 1e-9;

/// The places along each normal of N, with a gap below a bound (m), if N has more than one.
pub fn manifolds(both: &Both, alike: f64, near: f64) -> Vec<Vec<Candidate>> {
    let (Core::Polytope(_), Core::Polytope(_), Some(closest)) = (&both.a.core, &both.b.core, nearest(both)) else {
        return Vec::new();
    };
    let least = closest.distance() - alike;
    let of_b = normals(&both.b.core).map(|normal| -both.turned(&normal));
    let mut along = vec![closest.normal];
    for normal in normals(&both.a.core).chain(of_b).filter(|normal| both.separation(normal) >= least) {
        if along.iter().all(|known| known.dot(&normal) < AGREE) {
            along.push(normal);
        }
    }
    if along.len() < 2 {
        return Vec::new();
    }
    let separated = |normal| Candidate { normal, separation: both.separation(&normal), ..closest };
    let each = along.into_iter().map(|normal| manifold_along(both, separated(normal), near));
    each.filter(|found| !found.is_empty()).collect()
}
