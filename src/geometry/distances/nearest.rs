//! The distance of two convex cores by their features, exact to rounding.
//!
//! Every pair of features proposes its normal and points ([`crate::features::meet`]); the one of the largest separation is the distance, and its
//! certificate proves it. GJK says where to look first: features within δ of its support planes; δ grows until the certificate holds. If cores
//! overlap or nearly touch, GJK's normal is meaningless: there the normals of the faces and of crossing edges are tried.

use crate::distances::best::Best;
use crate::distances::deepest::deepest;
use crate::features::both::{Both, Candidate};
use crate::features::feature::{FeatureId, Part, inside, normals, part};
use crate::features::guesses::{guesses, is_beyond};
use crate::features::meet::{Guess, meet};
use crate::features::slab::lying;
use crate::shapes::convex::{Core, Cylinder};
use crate::shapes::polytope::{Face, Polytope};
use nalgebra::Vector3;

/// How far from the support planes features are looked for, relative to the size, one after the other.
const DEPTHS: [f64; 4] = [1e-9, 1e-6, 1e-3, 0.05];
/// The same of shapes with thousands of features, which have too many of them deeper.
const THIN: [f64; 3] = [1e-9, 1e-6, 1e-5];
/// Overlaps up to this part of the size are shallow.
const SHALLOW: f64 = 1e-4;
/// At the same place by rounding, relative to the size.
const COINCIDENT: f64 = 2e-14;
/// The faces of a polytope with at most this many are looked through.
const FEW_FACES: usize = 24;
/// All pairs of edges are tried if they are not more.
const MOST_PAIRS: usize = 50_000;
/// They are tried wherever they are not more than this, as the pairs of two boxes.
const FEW_PAIRS: usize = 500;
/// Outside of a feature by rounding, relative to the size.
const ROUNDING: f64 = 1e-12;

/// The nearest points of two cores, or the points of the least depth; `None` only if a pose is not finite.
pub fn nearest(both: &Both) -> Option<Candidate> {
    if !is_finite(both) {
        return None;
    }
    if let Some(found) = of_a_point(both) {
        return Some(found);
    }
    nearest_along(both, both.hint(&Vector3::zeros()))
}

/// Whether the pose is finite.
fn is_finite(both: &Both) -> bool {
    both.translation.iter().chain(&both.rotation).all(|entry| entry.abs() < 1e150)
}

/// The same of two cores with a finite pose, neither of which is a point beside a point or in front of a face, with the normal of GJK.
fn nearest_along(both: &Both, hint: Option<Vector3<f64>>) -> Option<Candidate> {
    let mut best = Best::new(both);
    if let Some(normal) = hint {
        search(&mut best, both, &normal, &DEPTHS);
    }
    if best.is_global() {
        return best.found();
    }
    if both.a.is_dense() || both.b.is_dense() {
        // Thousands of normals are tried only if the ones beside are not proved to be the one.
        let mut soon = Best::new(both);
        soon.try_normal(&both.centres());
        search_apart(&mut soon, both, &THIN);
        if soon.is_global() {
            return soon.found();
        }
    }
    try_normals(&mut best, both);
    search_apart(&mut best, both, &DEPTHS);
    if best.is_global() {
        return best.found();
    }
    try_crossings(&mut best, both);
    let start = best.steepest().1;
    search(&mut best, both, &start, &DEPTHS);
    if !best.is_exact() {
        search_apart(&mut best, both, &DEPTHS);
    }
    let bound = supports(both, best.steepest());
    best.found().filter(|found| best.error(found) <= bound.certificate()).or(Some(bound))
}

/// The same for shapes with thousands of faces, with the normal of GJK; not all of their normals are tried while the two overlap by little, or touch.
///
/// Of shapes that overlap an exact depth δ among the normals that were tried is the least one up to δ, which is small here. Those that do not are at a
/// distance that is exact.
pub fn nearest_soon(both: &Both, hint: Option<Vector3<f64>>) -> Option<Candidate> {
    if is_finite(both) {
        let mut best = Best::new(both);
        if let Some(normal) = hint {
            search(&mut best, both, &normal, &THIN);
        }
        if !best.is_global() {
            best.try_normal(&both.centres());
            search_apart(&mut best, both, &THIN);
        }
        if best.is_exact() && best.steepest().0 >= -SHALLOW * both.size() {
            return best.found();
        }
    }
    nearest(both)
}

/// The distance of two cores for a search of roots (m): of polytopes with many edges that overlap by more than a ten thousandth of their size a lower bound,
/// below that. Whether their depth is the least one is decided by thousands of normals, and a root is elsewhere. `None` only if a pose is not finite.
pub fn distance_unless_deep(both: &Both) -> Option<f64> {
    let edges = |core: &Core| if let Core::Polytope(polytope) = core { polytope.edges.len() } else { 0 };
    if edges(&both.a.core) * edges(&both.b.core) <= FEW_PAIRS {
        return nearest(both).map(|found| found.distance());
    }
    if !is_finite(both) {
        return None;
    }
    let hint = both.hint(&Vector3::zeros());
    if hint.is_none() {
        let mut best = Best::new(both);
        best.try_normal(&both.centres());
        search_apart(&mut best, both, &THIN);
        let (separation, _) = best.steepest();
        if separation < -SHALLOW * both.size() {
            return Some(separation);
        }
    }
    nearest_along(both, hint).map(|found| found.distance())
}

/// The nearest points of a point, or of the centre of a ball, and another one, or a polytope with few faces, if a face is nearest: the one that the point
/// is farthest in front of.
fn of_a_point(both: &Both) -> Option<Candidate> {
    let (Core::Polytope(a), Core::Polytope(b)) = (&both.a.core, &both.b.core) else { return None };
    let farthest = |polytope: &Polytope, point: Vector3<f64>| {
        let height = |face: &Face| face.normal.dot(&(point - polytope.vertices[face.corners[0]]));
        let faces = polytope.faces.iter().map(height).enumerate();
        let (face, _) = faces.max_by(|(_, one), (_, other)| one.total_cmp(other))?;
        Some(FeatureId::Face(face as u32))
    };
    let point = FeatureId::Vertex(0);
    let pair = match (&a.vertices[..], &b.vertices[..]) {
        ([_], [_]) => [point; 2],
        (_, [of_b]) if a.faces.len() <= FEW_FACES => [farthest(a, both.of_b(of_b))?, point],
        ([of_a], _) if b.faces.len() <= FEW_FACES => {
            [point, farthest(b, both.rotation.tr_mul(&(of_a - both.translation)))?]
        }
        _ => return None,
    };
    let on_b = part(&both.b.core, pair[1]).moved(&both.rotation, &both.translation);
    let guess = Guess { normal: both.centres(), point: both.of_b(&both.b.centre), at_point: false };
    let (normal, points) = meet(&part(&both.a.core, pair[0]), &on_b, &guess)?;
    let mut best = Best::new(both);
    if lie_on(both, pair, &points) {
        best.offer(normal, points, pair);
    }
    best.found().filter(|_| best.is_global())
}

/// Moves the two apart along the best normal, runs GJK there, and searches along its normal: the normal of a small depth.
fn search_apart(best: &mut Best, both: &Both, depths: &[f64]) {
    for apart in [0.1, 1e-2, 1e-3, 1e-4] {
        let (separation, normal) = best.steepest();
        if let Some(normal) = both.hint(&(normal * (apart * both.size() - separation))) {
            best.try_normal(&normal);
        }
    }
    let start = best.steepest().1;
    search(best, both, &start, depths);
}

/// Offers the features within these depths of the support planes of a normal, until the best is exact.
fn search(best: &mut Best, both: &Both, normal: &Vector3<f64>, depths: &[f64]) {
    for &depth in depths {
        offer_features(best, both, normal, depth * both.size(), false);
        if best.is_exact() {
            return;
        }
    }
}

/// Tries the normals across two edges, or across parts of a cylinder that are like edges.
fn try_crossings(best: &mut Best, both: &Both) {
    let (a, b) = (&both.a.core, &both.b.core);
    let (Core::Polytope(one), Core::Polytope(other)) = (a, b) else {
        let start = best.steepest().1;
        return offer_features(best, both, &start, f64::INFINITY, true);
    };
    if one.edges.len() * other.edges.len() > MOST_PAIRS {
        return;
    }
    for edge in &one.edges {
        let own = both.rotation.tr_mul(&(one.vertices[edge.ends[1]] - one.vertices[edge.ends[0]]));
        let arc = edge.faces.map(|faces| faces.map(|face| both.rotation.tr_mul(&one.faces[face].normal)));
        for partner in &other.edges {
            let opposite = partner.faces.map(|faces| faces.map(|face| -other.faces[face].normal));
            if !arcs_cross(&arc, &opposite) {
                continue;
            }
            let across = own.cross(&(other.vertices[partner.ends[1]] - other.vertices[partner.ends[0]]));
            if let Some(across) = both.turned(&across).try_normalize(1e-12 * both.size() * both.size()) {
                best.try_normal(&across);
                best.try_normal(&-across);
            }
        }
    }
}

/// Tries the normals of faces and caps, and the normals straight out of the sides of cylinders.
fn try_normals(best: &mut Best, both: &Both) {
    let towards = both.centres();
    let radial = |core: &Core, towards: Vector3<f64>| match core {
        Core::Cylinder(Cylinder { axis, .. }) => (towards - axis * axis.dot(&towards)).try_normalize(1e-9),
        Core::Polytope(_) | Core::Ellipsoid(_) => None,
    };
    let of_a = normals(&both.a.core).chain(radial(&both.a.core, towards));
    let of_b = normals(&both.b.core).chain(radial(&both.b.core, -both.rotation.tr_mul(&towards)));
    for normal in of_a.chain(of_b.map(|normal| -both.turned(&normal))).chain([towards]) {
        best.try_normal(&normal);
    }
}

/// Offers the pairs of features that lie within a depth (m) of the support planes of a normal; looked for at the normal alone, or everywhere.
fn offer_features(best: &mut Best, both: &Both, normal: &Vector3<f64>, depth: f64, everywhere: bool) {
    let (a, b) = (&both.a.core, &both.b.core);
    let own = both.rotation.tr_mul(normal);
    let (least_a, least_b) = (a.support(normal) - depth, b.support(&-own) - depth);
    let guess = Guess { normal: *normal, point: both.of_b(&b.support_point(&-own)), at_point: false };
    // The points found so far lie on both, so no pair that is farther apart is nearer, or less deep.
    let reach = if everywhere { best.reach() } else { f64::INFINITY };
    let of_b = lying(b, &-own, least_b);
    for one in lying(a, normal, least_a) {
        let on_a = part(a, one);
        for &other in &of_b {
            let on_b = part(b, other).moved(&both.rotation, &both.translation);
            if is_beyond(&on_a, &on_b, reach) {
                continue;
            }
            if everywhere && let Some((found, points)) = deepest(&on_a, &on_b, &guess) {
                best.offer(found, points, [one, other]);
            }
            for guess in guesses(&on_a, &on_b, guess).take(if everywhere { usize::MAX } else { 1 }) {
                let Some((found, points)) = meet(&on_a, &on_b, &guess) else { continue };
                if lie_on(both, [one, other], &points) {
                    best.offer(found, points, [one, other]);
                    // A guess of a place does not determine the side of the normal.
                    if guess.at_point {
                        best.offer(-found, points, [one, other]);
                    }
                    // Between points that coincide every normal that separates will do.
                    if (points[1] - points[0]).norm() <= COINCIDENT * both.size() {
                        best.offer(*normal, points, [one, other]);
                    }
                } else if spans_plane(&on_a, &on_b) {
                    best.try_normal(&found);
                }
            }
        }
    }
}

/// Whether points (m) lie on a pair of features.
pub fn lie_on(both: &Both, pair: [FeatureId; 2], points: &[Vector3<f64>; 2]) -> bool {
    let least = -ROUNDING * both.size();
    let own = both.rotation.tr_mul(&(points[1] - both.translation));
    inside(&both.a.core, pair[0], &points[0]) >= least && inside(&both.b.core, pair[1], &own) >= least
}

/// Whether the normal of a pair of features stays certain as their distance goes to zero.
pub fn spans_plane(a: &Part, b: &Part) -> bool {
    let sharp = |part: &Part| match part {
        Part::Point(_) => 0,
        Part::Line(_, radius) if *radius == 0.0 => 1,
        Part::Circle(..) => 1,
        Part::Line(..) | Part::Plane(..) | Part::Ellipsoid(_) | Part::Hollow(..) => 2,
    };
    sharp(a) + sharp(b) >= 2
}

/// Whether the product of two edges can be a normal of both shapes: the arc of normals of one and the opposite arc of the other cross. Segments have
/// no arcs, and arcs of plates are half circles, for which the test cannot decide.
fn arcs_cross(one: &Option<[Vector3<f64>; 2]>, other: &Option<[Vector3<f64>; 2]>) -> bool {
    let (Some([n, m]), Some([u, v])) = (one, other) else { return true };
    if n.dot(m) < -0.999_999 || u.dot(v) < -0.999_999 {
        return true;
    }
    let (arc, opposite) = (m.cross(n), v.cross(u));
    let (ua, va, no, mo) = (u.dot(&arc), v.dot(&arc), n.dot(&opposite), m.dot(&opposite));
    ua * va <= ROUNDING && no * mo <= ROUNDING && ua * mo >= -ROUNDING
}

/// The support points of a normal and its separation (m): a lower bound of the distance, whose certificate says that it is not exact.
pub fn supports(both: &Both, (separation, normal): (f64, Vector3<f64>)) -> Candidate {
    let own = -both.rotation.tr_mul(&normal);
    let feature = |core: &Core, direction: &Vector3<f64>| match core {
        Core::Polytope(polytope) => FeatureId::Vertex(polytope.support_vertex(direction) as u32),
        Core::Cylinder(cylinder) => FeatureId::Rim(u32::from(cylinder.axis.dot(direction) >= 0.0)),
        Core::Ellipsoid(_) => FeatureId::Side,
    };
    let (a, b) = (&both.a.core, &both.b.core);
    let points = [a.support_point(&normal), both.of_b(&b.support_point(&own))];
    Candidate { normal, points, features: [feature(a, &normal), feature(b, &own)], separation }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distances::manifold::{manifold, places_in_slabs};
    use crate::shapes::convex::Convex;
    use crate::tests::scenes::{Numbers, cuboid};
    use catena_mechanism::description::contact::Shape;
    use catena_mechanism::description::joint::Pose;

    #[test]
    fn a_ball_in_front_of_a_face_of_a_box_is_as_far_from_it_as_the_search_says_to_the_last_bit() {
        let convex = |shape: &Shape| Convex::new(shape, &Pose::identity()).expect("possible").expect("convex");
        let (solid, ball) = (convex(&cuboid(0.3, 0.2, 0.1)), convex(&Shape::Sphere { radius: 0.05 }));
        let mut numbers = Numbers::new(7);
        let (mut faces, mut others) = (0, 0);
        for round in 0..400 {
            let pose = numbers.pose(0.6);
            let (rotation, translation) = (*pose.rotation.matrix(), pose.translation.vector);
            let (a, b) = if round % 2 == 0 { (&solid, &ball) } else { (&ball, &solid) };
            let both = Both { a, b, rotation, translation };
            let mut best = Best::new(&both);
            if let Some(normal) = both.hint(&Vector3::zeros()) {
                search(&mut best, &both, &normal, &DEPTHS);
            }
            let searched = best.found().filter(|_| best.is_global());
            match (of_a_point(&both), searched) {
                (Some(found), Some(searched)) => {
                    faces += 1;
                    assert_eq!(found.features, searched.features, "round {round}");
                    assert_eq!((found.normal, found.points), (searched.normal, searched.points), "round {round}");
                }
                // Edges and corners are nearest, or the centre is inside.
                (None, _) => others += 1,
                (Some(found), None) => panic!("round {round}: {found:?}"),
            }
        }
        assert!(faces > 60 && others > 60, "{faces} {others}");
    }

    #[test]
    fn two_balls_have_the_distance_and_the_place_of_the_search_to_the_last_bit() {
        let ball = |radius: f64| {
            let at = Pose::translation(0.01, -0.02, 0.03);
            Convex::new(&Shape::Sphere { radius }, &at).expect("possible").expect("convex")
        };
        let (a, b) = (&ball(0.1), &ball(0.3));
        let mut numbers = Numbers::new(8);
        for round in 0..200 {
            let pose = numbers.pose(0.6);
            let both = Both { a, b, rotation: *pose.rotation.matrix(), translation: pose.translation.vector };
            let mut best = Best::new(&both);
            let normal = both.hint(&Vector3::zeros()).expect("centres are apart");
            search(&mut best, &both, &normal, &DEPTHS);
            let searched = best.found().expect("two points");
            let found = of_a_point(&both).expect("two points");
            let values = |found: &Candidate| (found.normal, found.points, found.features, found.separation);
            assert_eq!(values(&found), values(&searched), "round {round}");
            let near = found.distance() + 1e-3;
            let places = [manifold(&both, near), places_in_slabs(&both, found, near, f64::INFINITY)];
            for places in places {
                assert_eq!(places.iter().map(values).collect::<Vec<_>>(), [values(&found)], "round {round}");
            }
        }
    }

    #[test]
    fn distances_far_from_the_origin_are_known_by_the_features_that_are_looked_at_first_as_those_near_it_are() {
        let boxes = |size: [f64; 3], offset: Vector3<f64>| {
            let pose = Pose::translation(offset.x, offset.y, offset.z);
            Convex::new(&cuboid(size[0], size[1], size[2]), &pose).expect("possible").expect("convex")
        };
        let mut numbers = Numbers::new(11);
        let (mut near, mut far) = (0, 0);
        for _ in 0..400 {
            let pose = numbers.pose(0.6);
            let known = |offset: Vector3<f64>| {
                // An obstacle is in the frame of the world.
                let (obstacle, body) = (boxes([0.3, 0.2, 0.1], offset), boxes([0.1, 0.06, 0.08], Vector3::zeros()));
                let (rotation, translation) = (*pose.rotation.matrix(), pose.translation.vector + offset);
                let both = Both { a: &obstacle, b: &body, rotation, translation };
                let mut best = Best::new(&both);
                if let Some(normal) = both.hint(&Vector3::zeros()) {
                    search(&mut best, &both, &normal, &DEPTHS);
                }
                (best.is_global(), nearest(&both).expect("a distance").distance())
            };
            let ((here, distance), (there, same)) = (known(Vector3::zeros()), known(Vector3::new(100.0, -40.0, 3.0)));
            (near, far) = (near + usize::from(here), far + usize::from(there));
            // Places at 108 m are rounded by 1.4e-14 m.
            assert!((distance - same).abs() < 1e-13, "{distance} {same}");
        }
        // Where boxes overlap there is no hint.
        assert!(near > 250 && near == far, "{near} near the origin, {far} far from it");
    }
}
