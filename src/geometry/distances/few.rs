//! A few of the places where two shapes with many vertices nearly touch: the ones that small turns make the deepest.
//!
//! ```text
//!     place k = argmin_i (gap_i + θ e_k · p_i)        e_k: eight directions across the normal,   θ = near/size, an eighth of it, and 1e-6 [rad]
//! ```
//!
//! The hull of a mesh has thousands of vertices within a centimetre of another. A gap is linear in a small turn, so a place that is the deepest after
//! none of the turns touches only after others. The nearest place is always there, and every place is one of all: no pair is held apart too early. A
//! place that is left out may overlap before the others stop it, by about the height of the surface between two of them. A step that ends so is made
//! again with the overlapping place.
//!
//! Shapes that are farther apart than a tenth of the smaller one have the nearest place alone: they turn and slide before they meet, so that other features
//! touch than the ones beside it now.
//!
//! The search looks at the parts of both shapes near the support planes: flat places are there, and the places to which round bodies roll in a step.

use crate::distances::axes::Found;
use crate::distances::manifold::places_in_slabs;
use crate::distances::nearest::nearest_soon;
use crate::features::both::{Both, Candidate};
use crate::shapes::plane::across;
use nalgebra::Vector3;

/// So many places, and so many vertices on a half space, stay as they are.
pub const MOST: usize = 24;
/// The depth of the slab below a support plane that is looked at, relative to the size of the smaller shape. A turn by up to its root, 0.01 rad, leaves
/// the nearest place of round bodies in it.
const SLAB: f64 = 1e-4;
/// Shapes that are farther apart than this part of the size of the smaller one have one place.
const FAR: f64 = 0.1;
/// The largest turn (rad), smaller ones as parts of it, and the least (rad).
const LARGEST: f64 = 0.5;
const PART: f64 = 0.125;
const LEAST: f64 = 1e-6;
/// The directions of turns, and the angle of the first (rad): edges of robots go along their axes.
const DIRECTIONS: u32 = 8;
const FIRST: f64 = 0.1;

/// A few of the places of two convex shapes whose gap is below a bound (m), with the normal of GJK.
pub fn few(both: &Both, hint: Option<Vector3<f64>>, near: f64) -> Found {
    let Some(closest) = nearest_soon(both, hint) else { return Found::Places(Vec::new()) };
    let gap = closest.distance() - both.a.radius - both.b.radius;
    if gap.is_nan() {
        return Found::Places(Vec::new());
    }
    if gap >= near {
        return Found::Apart(gap);
    }
    let smaller = both.a.size.min(both.b.size);
    if gap > FAR * smaller {
        return Found::Places(vec![closest]);
    }
    let mut found = places_in_slabs(both, closest, near, SLAB * smaller);
    leave_few(&mut found, &closest.normal, near, both.size());
    Found::Places(found)
}

/// Leaves the places that small turns make the deepest, of shapes of a size (m) that are nearer than `near` (m).
fn leave_few(found: &mut Vec<Candidate>, normal: &Vector3<f64>, near: f64, size: f64) {
    if found.len() <= MOST {
        return;
    }
    let mut kept = vec![false; found.len()];
    for tilt in tilts(normal, near, size) {
        let height = |one: &Candidate| one.distance() + tilt.dot(&one.points[0]);
        let heights = found.iter().map(height).enumerate();
        if let Some((number, _)) = heights.min_by(|one, other| one.1.total_cmp(&other.1)) {
            kept[number] = true;
        }
    }
    let mut kept = kept.into_iter();
    found.retain(|_| kept.next().unwrap_or(true));
}

/// The turns θ e_k of shapes of a size (m) that are nearer than `near` (m), each as a vector across a normal; no turn comes first.
pub fn tilts(normal: &Vector3<f64>, near: f64, size: f64) -> impl Iterator<Item = Vector3<f64>> {
    let (x, y) = across(normal);
    let largest = (near / size).clamp(LEAST, LARGEST);
    let turned = move |turn: f64| {
        (0..DIRECTIONS).map(move |number| {
            let angle = FIRST + std::f64::consts::TAU * f64::from(number) / f64::from(DIRECTIONS);
            (x * angle.cos() + y * angle.sin()) * turn
        })
    };
    let turns = [largest, PART * largest, LEAST].into_iter();
    std::iter::once(Vector3::zeros()).chain(turns.flat_map(turned))
}
