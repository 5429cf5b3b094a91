//! Shapes that are no shapes, and poses that are no poses.

use super::scenes::{Numbers, at, at_origin, collider, cuboid, floor, pair};
use crate::{GeometryError, PairGeometry, check_shape, decompose};
use catena_mechanism::description::contact::{Shape, Surface};
use catena_mechanism::description::joint::Pose;
use nalgebra::Vector3;
use std::sync::Arc;

fn error(shape: Shape) -> String {
    let found = PairGeometry::new(&at_origin(shape), &at_origin(cuboid(1.0, 1.0, 1.0)));
    found.expect_err("a shape that is not possible").to_string()
}

fn hull(points: &[[f64; 3]]) -> Shape {
    Shape::Hull(Arc::new(points.iter().map(|&point| Vector3::from(point)).collect()))
}

fn mesh(vertices: &[[f64; 3]], triangles: &[[u32; 3]]) -> Shape {
    let vertices = vertices.iter().map(|&vertex| Vector3::from(vertex)).collect();
    Shape::Mesh(Arc::new(Surface { vertices, triangles: triangles.to_vec() }))
}

#[test]
fn every_impossible_shape_is_refused_with_what_to_do() {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.5, 0.5, 1e-9]];
    let table = [
        (Shape::Sphere { radius: 0.0 }, "the radius of the sphere is 0 m: give a positive length below 1e150 m"),
        (Shape::Sphere { radius: 1e300 }, "the radius of the sphere is 1e300 m: give a positive length below 1e150 m"),
        (Shape::Sphere { radius: -1e-9 }, "the radius of the sphere is -1e-9 m: give a positive length below 1e150 m"),
        (Shape::Sphere { radius: f64::NAN }, "the radius of the sphere is NaN m: give a positive length below 1e150 m"),
        (
            Shape::Capsule { radius: 1.0, half: -1.0 },
            "the half length of the capsule is -1 m: give a positive length below 1e150 m",
        ),
        (
            Shape::Cylinder { radius: f64::INFINITY, half: 1.0 },
            "the radius of the cylinder is inf m: give a positive length below 1e150 m",
        ),
        (cuboid(1.0, 0.0, 1.0), "the y size of the box is 0 m: give a positive length below 1e150 m"),
        (
            hull(&corners[..2]),
            "a convex hull of 2 points has no area: give at least 3 points that do not lie on one line",
        ),
        (
            hull(&[[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]),
            "all points lie within 0.0e0 m of one plane or on a line: give the hull a thickness, or make it flat",
        ),
        (hull(&[[f64::NAN; 3]; 5]), "coordinate x of vertex 0 is NaN: give a finite number"),
        (mesh(&corners, &[]), "the mesh has no triangle with an area: export it again with its faces"),
        (mesh(&corners, &[[0, 1, 1]]), "the mesh has no triangle with an area: export it again with its faces"),
        (mesh(&corners, &[[0, 1, 7]]), "triangle 0 names vertex 7, but there are 5 vertices: export the mesh again"),
    ];
    for (shape, words) in table {
        assert_eq!(error(shape.clone()), words);
        // Only the reader of a mesh knows the properties of its triangles.
        if !matches!(shape, Shape::Mesh(_)) {
            assert_eq!(check_shape(&shape, &Pose::identity()).expect_err(words).to_string(), words);
        }
    }
    assert!(error(hull(&corners)).contains("m of one plane"), "thinner than 1e-7 of its size");
    assert!(error(hull(&[[0.3, 0.2, 0.1]; 9])).contains("of one plane"), "all at one place");
    assert!(error(Shape::Sphere { radius: 1e200 }).contains("below 1e150 m"));
    let two = PairGeometry::new(&at_origin(Shape::HalfSpace), &at_origin(floor(1, 1.0, |_, _| 0.0)));
    assert_eq!(two.expect_err("two obstacles"), GeometryError::Obstacles { a: "half space", b: "triangle mesh" });
    let ball = at_origin(Shape::Sphere { radius: 1.0 });
    let two = PairGeometry::new(&ball, &at_origin(Shape::Ellipsoid { radii: Vector3::repeat(1.0) }));
    assert_eq!(two.expect_err("an ellipsoid and a ball"), GeometryError::Ellipsoid { other: "sphere" });
    assert_eq!(decompose(&Surface::default(), 4), Err(GeometryError::EmptyMesh));
    let mut turned = at_origin(cuboid(1.0, 1.0, 1.0));
    turned.pose = at(f64::NAN, 0.0, 0.0);
    let words = PairGeometry::new(&turned, &at_origin(Shape::HalfSpace)).expect_err("a pose").to_string();
    assert_eq!(words, "the pose of the box is not finite: give finite positions and angles");
}

#[test]
fn points_of_a_grid_and_points_given_twice_make_the_hull_of_a_box() {
    let place = |number: usize| [number % 4, number / 4 % 4, number / 16].map(|entry| entry as f64 / 3.0 - 0.5);
    let points: Vec<[f64; 3]> = (0..128).map(|number| place(number % 64)).collect();
    let floor = pair(Shape::HalfSpace, hull(&points));
    let places = floor.touches(&Pose::identity(), &at(0.0, 0.0, 0.5), 1e-9);
    assert!((floor.distance(&Pose::identity(), &at(0.0, 0.0, 0.7)).distance - 0.2).abs() <= 1e-15);
    assert_eq!(places.len(), 4);
    let on_box = pair(cuboid(1.0, 1.0, 0.5), hull(&points));
    assert_eq!(on_box.touches(&Pose::identity(), &at(0.0, 0.0, 1.0), 1e-9).len(), 4);
}

#[test]
fn poses_that_are_not_finite_and_poses_far_away_are_answered() {
    let mut numbers = Numbers::new(2);
    let kinds = ["sphere", "capsule", "box", "hull", "cylinder"];
    let obstacles = [Shape::HalfSpace, floor(3, 0.1, |x, _| x.abs()), cuboid(0.1, 0.1, 0.1)];
    for (kind, obstacle) in kinds.iter().flat_map(|kind| obstacles.iter().map(move |obstacle| (kind, obstacle))) {
        let pair = PairGeometry::new(&collider(kind, 1.0, &mut numbers), &at_origin(obstacle.clone())).expect("a pair");
        for far in [f64::NAN, f64::INFINITY, 1e300] {
            let found = pair.distance(&at(far, 0.0, 0.0), &Pose::identity());
            assert!(found.distance.is_nan() || found.distance.abs() < 1e301);
            let places = pair.touches(&at(far, 0.0, far), &Pose::identity(), 1e-3);
            assert!(places.iter().all(|place| place.gap < 1e-3), "{kind}");
        }
        for far in [1e6, 1e12] {
            let found = pair.distance(&at(0.0, 0.0, far), &Pose::identity()).distance;
            assert!((found / far - 1.0).abs() < 1e-5, "{kind}: {found:e} at {far:e}");
        }
    }
}

#[test]
fn points_in_one_plane_make_a_plate_that_touches_with_its_corners_and_is_touched_on_both_sides() {
    // A square with a point in the middle of a side and one inside, somewhere in space.
    let turn = at(0.3, -0.2, 0.1) * Pose::rotation(Vector3::new(0.4, -0.7, 0.2));
    let flat = [[0.5, 0.5], [-0.5, 0.5], [-0.5, -0.5], [0.5, -0.5], [0.0, 0.5], [0.1, 0.2]];
    let points = |pose: &Pose| flat.map(|[x, y]| pose.transform_point(&Vector3::new(x, y, 0.0).into()).coords.into());
    let floor = pair(Shape::HalfSpace, hull(&points(&Pose::identity())));
    assert_eq!(floor.touches(&Pose::identity(), &at(0.0, 0.0, 0.0), 1e-9).len(), 4);
    let plate = pair(hull(&points(&turn)), Shape::Sphere { radius: 0.2 });
    for side in [1.0, -1.0] {
        let over = |x: f64, height: f64| turn * at(x, 0.1, side * height);
        let found = plate.distance(&Pose::identity(), &over(0.2, 0.3));
        assert!((found.distance - 0.1).abs() <= 1e-15 && found.certificate <= 1e-15, "{found:?}");
        assert!((found.normal - turn.rotation * Vector3::z() * side).norm() <= 1e-15, "{found:?}");
        // Outside its edge, the distance is the hypotenuse of 0.3 and 0.4.
        let found = plate.distance(&Pose::identity(), &over(0.8, 0.4));
        assert!((found.distance - 0.3).abs() <= 1e-15 && found.certificate <= 1e-15, "{found:?}");
        assert_eq!(plate.touches(&Pose::identity(), &over(0.2, 0.2), 1e-9).len(), 1);
    }
    let boxes = pair(hull(&points(&Pose::identity())), cuboid(0.1, 0.1, 0.1));
    assert_eq!(boxes.touches(&Pose::identity(), &at(0.3, 0.1, 0.1), 1e-9).len(), 4);
}

#[test]
fn what_reaches_too_far_or_has_too_many_triangles_is_refused_before_it_is_in_a_scene() {
    let refused = |shape: &Shape| check_shape(shape, &Pose::identity()).err().map(|error| error.to_string());
    let corners = |size: f64| [[0.0; 3], [size, 0.0, 0.0], [0.0, size, 0.0], [0.0, 0.0, size]];
    for (size, is_refused) in [(9.9e5, false), (1.01e6, true)] {
        let shapes = [
            Shape::Sphere { radius: size },
            Shape::Capsule { radius: 0.5 * size, half: 0.5 * size },
            Shape::Cylinder { radius: 0.6 * size, half: 0.8 * size },
            cuboid(size, 0.01, 0.01),
            hull(&corners(size)),
            mesh(&corners(size), &[[0, 2, 1]]),
        ];
        for shape in &shapes {
            let said = refused(shape);
            assert_eq!(said.is_some(), is_refused, "{shape:?}: {said:?}");
            assert!(said.is_none_or(|said| said.contains("farther than 1e6 m: give lengths in metres")), "{shape:?}");
        }
    }
    assert_eq!(refused(&Shape::HalfSpace), None);
    let many = refused(&mesh(&corners(1.0), &vec![[0, 2, 1]; 2_000_001]));
    assert!(many.is_some_and(|said| said.starts_with("2000001 triangles are more than 2000000: simplify the shape")));
    let nowhere = refused(&mesh(&corners(1.0), &[[0, 2, 4]]));
    assert!(nowhere.is_some_and(|said| said.starts_with("triangle 0 names vertex 4")));
}
