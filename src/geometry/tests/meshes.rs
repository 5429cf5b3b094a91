//! Meshes: the same as a half space where they are flat, and no ghost edges.

use super::scenes::{Numbers, at, at_origin, cuboid, floor, pair};
use crate::distances::mesh::Mesh;
use crate::shapes::convex::Convex;
use crate::{FeatureId, PairGeometry, Pieces, decompose};
use catena_mechanism::description::contact::{Collider, Shape, Surface};
use catena_mechanism::description::joint::Pose;
use nalgebra::{Rotation3, Translation3, Vector3};

fn shapes() -> [Shape; 4] {
    [
        Shape::Sphere { radius: 0.06 },
        cuboid(0.11, 0.07, 0.05),
        Shape::Capsule { radius: 0.05, half: 0.08 },
        Shape::Cylinder { radius: 0.05, half: 0.08 },
    ]
}

#[test]
fn over_a_flat_mesh_every_shape_is_as_far_as_over_a_half_space() {
    let mut numbers = Numbers::new(1);
    for shape in shapes() {
        let (mesh, plane) = (pair(floor(20, 0.1, |_, _| 0.0), shape.clone()), pair(Shape::HalfSpace, shape));
        let o = Pose::identity();
        for round in 0..200 {
            let mut b = numbers.pose(0.4);
            let first = plane.distance(&o, &b);
            let gap = [0.1, 1e-3, 1e-9, 0.0, -1e-9, -1e-6][round % 6];
            b.translation = Translation3::from(b.translation.vector + Vector3::z() * (gap - first.distance));
            let (one, other) = (mesh.distance(&o, &b), plane.distance(&o, &b));
            assert!((one.distance - other.distance).abs() <= 1e-14, "{:e} for {:e}", one.distance, other.distance);
            assert!((one.normal - Vector3::z()).norm() <= 1e-14, "{:?} at {gap:e}", one.normal);
            let (places, wanted) = (mesh.touches(&o, &b, 1e-6), plane.touches(&o, &b, 1e-6));
            assert_eq!(places.len(), wanted.len(), "at {gap:e}");
        }
    }
}

#[test]
fn a_slanted_box_on_a_flat_mesh_has_no_normal_but_that_of_the_floor() {
    let mesh = pair(floor(20, 0.1, |_, _| 0.0), cuboid(0.3, 0.3, 0.1));
    let tilt = Rotation3::new(Vector3::x() * 1e-3);
    let height = 0.1 * 1e-3f64.cos() + 0.3 * 1e-3f64.sin();
    let places =
        mesh.touches(&Pose::identity(), &Pose::from_parts(Translation3::new(0.013, 0.021, height), tilt), 1e-2);
    assert_eq!(places.len(), 4, "its corners");
    assert!(places.iter().all(|place| (place.normal - Vector3::z()).norm() <= 1e-15));
}

#[test]
fn only_borders_and_bends_of_a_mesh_can_be_touched() {
    let open = |shape: Shape| match shape {
        Shape::Mesh(surface) => Mesh::new(&surface, &Pose::identity()).expect("a mesh").open_edges(),
        _ => 0,
    };
    // 128 triangles with 208 edges: 32 at the border; a valley, which is a ridge from below, adds its own 8, and so does a ridge.
    assert_eq!(open(floor(8, 0.1, |_, _| 0.0)), 32);
    assert_eq!(open(floor(8, 0.1, |x, _| x.max(0.0) * 0.5)), 40);
    assert_eq!(open(floor(8, 0.1, |x, _| x.min(0.0) * 0.5)), 40);
}

#[test]
fn a_ball_touches_the_ridge_of_a_roof_but_not_the_bottom_of_a_valley() {
    let o = Pose::identity();
    let ball = || Shape::Sphere { radius: 0.05 };
    let roof = pair(floor(8, 0.1, |x, _| -x.abs()), ball());
    let ridge = roof.touches(&o, &at(0.0, 0.03, 0.05), 1e-9);
    assert_eq!(ridge.len(), 1);
    assert!(matches!(ridge[0].identity.a, FeatureId::Edge(_)), "{:?}", ridge[0].identity);
    let valley = pair(floor(8, 0.1, |x, _| x.abs()), ball());
    let sides = valley.touches(&o, &at(0.0, 0.03, 0.05 * 2f64.sqrt()), 1e-9);
    assert_eq!(sides.len(), 2, "one point on either side");
    assert!(sides.iter().all(|place| matches!(place.identity.a, FeatureId::Face(_))));
}

#[test]
fn a_corner_below_a_bowl_overlaps_it_however_near_it_is_to_the_sides_of_triangles() {
    // Four slopes that meet at the origin, in squares of 3 cm. A box dips one corner below them; the least overlap of a triangle alone is often across its
    // side, where the next one is in the way.
    let height = |x: f64, y: f64| 0.2 * x.abs() + 0.1 * y.abs();
    let bowl = pair(floor(20, 0.03, height), cuboid(0.03, 0.04, 0.05));
    let mut numbers = Numbers::new(5);
    let corner = Vector3::new(0.03, 0.04, 0.05);
    for _ in 0..400 {
        // The diagonal of the box is nearly upright.
        let lean = Rotation3::new(numbers.vector() * 0.2);
        let turn = lean * Rotation3::rotation_between(&corner, &-Vector3::z()).expect("a turn");
        let (x, y) = (0.05 * numbers.next(), 0.05 * numbers.next());
        let deep = 10f64.powf(-3.5 + 1.5 * numbers.next());
        let tip = Vector3::new(x, y, height(x, y) - deep);
        let pose = Pose::from_parts(Translation3::from(tip - turn * corner), turn);
        let least = bowl.touches(&Pose::identity(), &pose, 1e-3).iter().map(|place| place.gap).fold(1.0, f64::min);
        // Along the normal of the slope that it is below. Roundings are those of lengths of 0.3 m.
        let wanted = deep / 1.05_f64.sqrt();
        assert!((least + wanted).abs() <= 1e-15, "{least:e} at {x} {y}, {wanted:e} m below");
    }
}

#[test]
fn a_mesh_is_touched_on_both_sides_whatever_the_order_of_the_corners_of_its_triangles() {
    let mut numbers = Numbers::new(11);
    let heights: Vec<f64> = (0..400).map(|_| 0.08 * numbers.next()).collect();
    let hills = |x: f64, y: f64| heights[((x * 10.0 + 10.0).round() * 20.0 + (y * 10.0 + 10.0).round()) as usize % 400];
    let floor = floor(12, 0.1, hills);
    let Shape::Mesh(surface) = &floor else { panic!("a mesh") };
    let mut turned = (**surface).clone();
    turned.triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
    // Turned about x by half a turn, what is above is below. The corners of the triangles are those of the floor.
    let mut upside_down = (**surface).clone();
    upside_down.vertices.iter_mut().for_each(|vertex| *vertex = Vector3::new(vertex.x, -vertex.y, -vertex.z));
    let [turned, upside_down] = [turned, upside_down].map(|surface| Shape::Mesh(std::sync::Arc::new(surface)));
    let half_turn = Pose::from_parts(Translation3::identity(), Rotation3::new(Vector3::x() * std::f64::consts::PI));
    let o = Pose::identity();
    let (mut touched, mut below) = (0, 0);
    for shape in shapes() {
        let of = |mesh: &Shape| pair(mesh.clone(), shape.clone());
        let (one, other, third) = (of(&floor), of(&turned), of(&upside_down));
        for round in 0..300 {
            let mut b = numbers.pose(0.4);
            let away = if round % 2 == 0 { 1.0 } else { -1.0 };
            // Just off the surface, above or below it.
            b.translation.z = 0.3 * away;
            for _ in 0..12 {
                b.translation.z -= away * one.distance(&o, &b).distance;
            }
            let gaps = |mesh: &PairGeometry, at: &Pose| {
                let mut gaps: Vec<f64> = mesh.touches(&o, at, 0.03).iter().map(|place| place.gap).collect();
                gaps.sort_by(f64::total_cmp);
                gaps
            };
            let wanted = gaps(&one, &b);
            for (mesh, at) in [(&other, b), (&third, half_turn * b)] {
                let found = gaps(mesh, &at);
                assert_eq!(found.len(), wanted.len(), "{shape:?}, round {round}: {found:?} for {wanted:?}");
                // Roundings of lengths below 1 m.
                let most = found.iter().zip(&wanted).map(|(found, wanted)| (found - wanted).abs()).fold(0.0, f64::max);
                assert!(most <= 1e-14, "{shape:?}, round {round}: {most:e}");
            }
            touched += usize::from(wanted.first().is_some_and(|gap| gap.abs() < 1e-3));
            below += usize::from(away < 0.0 && !wanted.is_empty());
        }
    }
    assert!(touched > 1000 && below > 500, "{touched} touch, {below} from below");
}

/// An L of six by six by two, with the inner corner at the origin.
fn angle() -> Surface {
    let outline = [(-2.0, -2.0), (4.0, -2.0), (4.0, 0.0), (0.0, 0.0), (0.0, 4.0), (-2.0, 4.0)];
    let vertices = outline.iter().flat_map(|&(x, y)| [Vector3::new(x, y, 0.0), Vector3::new(x, y, 1.0)]).collect();
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    for side in 0..6u32 {
        let next = (side + 1) % 6;
        triangles.extend([[2 * side, 2 * next, 2 * next + 1], [2 * side, 2 * next + 1, 2 * side + 1]]);
    }
    for [a, b, c] in [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]] {
        triangles.extend([[2 * a + 1, 2 * b + 1, 2 * c + 1], [2 * a, 2 * c, 2 * b]]);
    }
    Surface { vertices, triangles }
}

#[test]
fn an_angle_falls_into_convex_pieces_that_leave_its_inside_corner_free() {
    let surface = angle();
    let pieces = decompose(&surface, 8).expect("pieces").hulls;
    assert!(pieces.len() >= 2, "{} pieces", pieces.len());
    for piece in &pieces {
        let hull = pair(Shape::Hull(std::sync::Arc::new(piece.clone())), Shape::Sphere { radius: 0.5 });
        // A ball of half a metre with its middle a metre and a half from the inner corner of a shape of six metres; voxels are 0.1 m.
        let distance = hull.distance(&Pose::identity(), &at(1.5, 1.5, 0.5)).distance;
        assert!(distance > 0.3, "{distance}");
    }
    let corner = Vector3::new(4.0, -2.0, 1.0);
    let nearest = pieces.iter().flatten().map(|point| (point - corner).norm()).fold(f64::INFINITY, f64::min);
    assert!(nearest < 0.2, "the pieces reach to the outer corners: {nearest}");
}

#[test]
fn a_convex_surface_is_its_own_piece_to_the_last_bit() {
    // The long limb of the angle: a box.
    let mut surface = angle();
    surface.vertices.iter_mut().for_each(|vertex| vertex.y = vertex.y.min(0.0));
    let wanted = Pieces { hulls: vec![surface.vertices.clone()], exact: true };
    assert_eq!(decompose(&surface, 8), Ok(wanted));
}

#[test]
fn a_ball_over_a_flat_valley_is_near_both_sides_before_it_touches_the_second() {
    // Sides that rise by 0.05: their normals differ by 0.1 rad, and both places have the centre of the ball as the point of its core.
    let valley = pair(floor(8, 0.1, |x, _| 0.05 * x.abs()), Shape::Sphere { radius: 0.05 });
    let cosine = 0.05f64.hypot(1.0).recip();
    // It touches the right side at x + 0.0025, and is over the left one as long as x < 0.0025.
    for right in [0.002, 5e-4] {
        let height = 0.05 / cosine + 0.05 * right;
        let places = valley.touches(&Pose::identity(), &at(right, 0.03, height), 0.01);
        let mut gaps: Vec<f64> = places.iter().map(|place| place.gap).collect();
        gaps.sort_by(f64::total_cmp);
        assert_eq!(gaps.len(), 2, "{right}: {places:?}");
        // (z + 0.05 x) cos - r, to some roundings of lengths of 0.4 m.
        assert!(gaps[0].abs() <= 1e-15, "{:e}", gaps[0]);
        assert!((gaps[1] - 0.1 * right * cosine).abs() <= 1e-15, "{:e}", gaps[1]);
    }
}

#[test]
fn a_ball_over_a_mesh_has_the_places_and_the_distance_of_the_general_search() {
    let mut numbers = Numbers::new(5);
    let identity = Pose::identity();
    let heights: Vec<f64> = (0..400).map(|_| 0.08 * numbers.next()).collect();
    let hills = |x: f64, y: f64| heights[((x * 10.0 + 10.0).round() * 20.0 + (y * 10.0 + 10.0).round()) as usize % 400];
    let bowl = |x: f64, y: f64| 0.4 * (x * x + y * y);
    let (mut kinds, mut several) = ([0; 3], 0);
    for (round, radius) in [0.02, 0.06, 0.15].into_iter().cycle().take(1200).enumerate() {
        let shape = if round % 2 == 0 { floor(12, 0.1, hills) } else { floor(12, 0.1, bowl) };
        let Shape::Mesh(surface) = &shape else { continue };
        let mesh = Mesh::new(surface, &identity).expect("a mesh");
        let ball = Convex::new(&Shape::Sphere { radius }, &identity).expect("possible").expect("convex");
        // Beside the mesh, too, and below it.
        let centre = Vector3::new(0.7 * numbers.next(), 0.7 * numbers.next(), 0.12 + 0.2 * numbers.next());
        let turned = *numbers.pose(1.0).rotation.matrix();
        let near = [0.3 * radius, 1e-3, 1e-9, 2.0 * radius][round / 3 % 4];
        let (found, places) = (mesh.nearest(&ball, &turned, &centre), mesh.manifold(&ball, &turned, &centre, near));
        let (wanted, all) = mesh.in_general(&ball, (&turned, &centre), near);
        let (found, wanted) = (found.expect("a distance"), wanted.expect("a distance"));
        let apart = (found.distance() - wanted.distance()).abs();
        assert!(apart <= 1e-15 && found.certificate() <= 1e-14, "round {round}: {apart:e}, {:e}", found.certificate());
        let names = |places: &[crate::features::both::Candidate]| -> Vec<FeatureId> {
            places.iter().map(|place| place.features[0]).collect()
        };
        assert_eq!(names(&places), names(&all), "round {round}: {centre:?}");
        for (place, wanted) in places.iter().zip(&all) {
            let off = (place.normal - wanted.normal).norm() + (place.points[0] - wanted.points[0]).norm();
            assert!(off <= 1e-14, "round {round}: {off:e}");
        }
        several += usize::from(places.len() > 1);
        for name in names(&places) {
            kinds[match name {
                FeatureId::Face(_) => 0,
                FeatureId::Edge(_) => 1,
                _ => 2,
            }] += 1;
        }
    }
    assert!(kinds.iter().all(|&count| count > 20) && several > 100, "{kinds:?} {several}");
}

#[test]
fn a_ball_comes_no_nearer_to_a_mesh_than_the_speed_at_its_closing_reach_allows() {
    let mut numbers = Numbers::new(8);
    let mesh = at_origin(floor(12, 0.1, |x, y| 0.3 * (x * x - y * x)));
    for offset in [0.0, 0.2] {
        let ball = Collider::still("ball", None, at(0.0, 0.0, offset), Shape::Sphere { radius: 0.05 });
        for exchanged in [false, true] {
            let (a, b) = if exchanged { (&ball, &mesh) } else { (&mesh, &ball) };
            let pair = PairGeometry::new(a, b).expect("shapes that are possible");
            let [own, of_mesh] = if exchanged { [0, 1] } else { [1, 0] };
            let reach = pair.closing_reach();
            // Differences of lengths of 0.25 m.
            assert!((reach[own] - offset).abs() < 1e-15 && reach[of_mesh] == pair.reach()[of_mesh], "{reach:?}");
            let gap = |pose: &Pose| match exchanged {
                true => pair.distance(pose, &Pose::identity()).distance,
                false => pair.distance(&Pose::identity(), pose).distance,
            };
            for _ in 0..200 {
                let (start, turn) = (numbers.pose(0.3), numbers.vector() * 0.1);
                let moved = Rotation3::new(turn) * start.rotation;
                let end = Pose::from_parts(start.translation, moved);
                let closed = (gap(&start) - gap(&end)).abs();
                assert!(closed <= turn.norm() * reach[own] + 1e-14, "{offset}: {closed:e}");
            }
        }
    }
}
