//! Borders between features: the margin is zero where another feature takes over.

use super::scenes::{Numbers, at, collider, cuboid, floor, pair};
use crate::{FeatureId, PairGeometry};
use catena_mechanism::description::contact::Shape;
use catena_mechanism::description::joint::Pose;
use nalgebra::{Rotation3, Translation3, Vector3};

#[test]
fn a_ball_leaves_the_face_of_a_box_where_the_margin_changes_its_sign() {
    let (pair, o) = (pair(cuboid(0.1, 0.1, 0.1), Shape::Sphere { radius: 0.05 }), Pose::identity());
    let on_face = pair.touches(&o, &at(0.0, 0.0, 0.15), 1e-9).remove(0);
    let over = |x: f64| at(x, 0.02, if x <= 0.1 { 0.15 } else { 0.1 + (0.05f64.powi(2) - (x - 0.1).powi(2)).sqrt() });
    let on_edge = pair.touches(&o, &over(0.11), 1e-9).remove(0);
    assert!(matches!((on_face.identity.a, on_edge.identity.a), (FeatureId::Face(_), FeatureId::Edge(_))));
    for step in -50..=50 {
        let x = 0.1 + 1e-4 * step as f64;
        let (b, near) = (over(x), pair.touches(&o, &over(x), 1e-9));
        // Both are the same distance from the border, on either side of it; coordinates of 0.1 m have roundings of 1e-17.
        assert!((pair.margin(&on_face, &o, &b) - (0.1 - x)).abs() <= 1e-16, "at {x}");
        assert!((pair.margin(&on_edge, &o, &b) - (x - 0.1)).abs() <= 1e-16, "at {x}");
        if step != 0 {
            let expected = if step < 0 { on_face.identity } else { on_edge.identity };
            assert_eq!(near.iter().map(|place| place.identity).collect::<Vec<_>>(), [expected], "at {x}");
        }
    }
}

#[test]
fn a_ball_leaves_an_edge_at_its_end_and_a_vertex_at_its_planes() {
    let (pair, o) = (pair(cuboid(0.1, 0.1, 0.1), Shape::Sphere { radius: 0.05 }), Pose::identity());
    let away = 0.05 / 2f64.sqrt();
    let edge = pair.touches(&o, &at(0.1 + away, 0.09, 0.1 + away), 1e-9).remove(0);
    let vertex = pair.touches(&o, &at(0.1 + away, 0.1 + 1e-3, 0.1 + away), 1e-3).remove(0);
    assert!(matches!((edge.identity.a, vertex.identity.a), (FeatureId::Edge(_), FeatureId::Vertex(_))));
    for y in [0.05, 0.0999, 0.1001, 0.12] {
        let b = at(0.1 + away, y, 0.1 + away);
        assert!((pair.margin(&edge, &o, &b) - (0.1 - y).min(away)).abs() <= 1e-15, "edge at {y}");
        assert!((pair.margin(&vertex, &o, &b) - (y - 0.1).min(away)).abs() <= 1e-15, "vertex at {y}");
    }
}

#[test]
fn crossing_edges_leave_at_their_ends_and_a_vertex_leaves_a_face_at_its_side() {
    let (pair, o) = (pair(cuboid(0.1, 0.1, 0.1), cuboid(0.05, 0.05, 0.05)), Pose::identity());
    let vertex = pair.touches(&o, &at(0.0, 0.0, 0.15), 1e-9).remove(0);
    for x in [0.0, 0.049, 0.051, 0.06] {
        let margin = pair.margin(&vertex, &o, &at(-x, 0.0, 0.15));
        assert!((margin - (0.05 - x)).abs() <= 1e-15, "vertex at {x}: {margin}");
    }
    // An edge of b along y + z over an edge of a along x.
    let turn = Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_4);
    let away = |x: f64| {
        let turned = Rotation3::from_axis_angle(&Vector3::z_axis(), std::f64::consts::FRAC_PI_2) * turn;
        Pose::from_parts(Translation3::new(x, 0.1, 0.1 + 0.05 * 2f64.sqrt()), turned)
    };
    let places = pair.touches(&o, &away(0.0), 1e-9);
    let crossing = places.iter().find(|place| matches!(place.identity.a, FeatureId::Edge(_)));
    let crossing = crossing.expect("the edge of b lies across that of a");
    for x in [0.0, 0.0999, 0.1001] {
        let margin = pair.margin(crossing, &o, &away(x));
        assert!((margin - (0.1 - x).min(0.05)).abs() <= 1e-15, "edges at {x}: {margin}");
    }
}

#[test]
fn a_ball_on_a_mesh_leaves_a_triangle_at_its_sides() {
    let (pair, o) = (pair(floor(2, 0.2, |_, _| 0.0), Shape::Sphere { radius: 0.05 }), Pose::identity());
    let place = pair.touches(&o, &at(0.15, 0.05, 0.05), 1e-9).remove(0);
    for x in [0.12, 0.06, 0.04, 0.01] {
        // The diagonal of the square is its border: y = x.
        let margin = pair.margin(&place, &o, &at(x, 0.05, 0.05));
        let wanted = ((x - 0.05) / 2f64.sqrt()).min(0.05).min(0.2 - x);
        assert!((margin - wanted).abs() <= 1e-15, "at {x}: {margin} for {wanted}");
    }
}

#[test]
fn a_ball_leaves_the_cap_of_a_cylinder_for_its_rim_and_the_rim_for_its_side() {
    let (pair, o) =
        (pair(Shape::Cylinder { radius: 0.1, half: 0.2 }, Shape::Sphere { radius: 0.05 }), Pose::identity());
    // In every direction from the axis.
    for angle in [0.0, 0.7, 3.0] {
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), angle);
        let at = |x: f64, z: f64| Pose::from_parts(Translation3::from(turn * Vector3::new(x, 0.0, z)), turn);
        let around = |out: f64| at(0.1 + out, 0.2 + (0.05f64.powi(2) - out * out).sqrt());
        let on_cap = pair.touches(&o, &at(0.09, 0.25), 1e-9).remove(0);
        let on_rim = pair.touches(&o, &around(0.01), 1e-9).remove(0);
        let on_side = pair.touches(&o, &at(0.15, 0.19), 1e-9).remove(0);
        let names = [&on_cap, &on_rim, &on_side].map(|place| place.identity.a);
        assert_eq!(names, [FeatureId::Cap(1), FeatureId::Rim(1), FeatureId::Side]);
        for out in [0.001, 0.02, 0.049] {
            let b = around(out);
            // The height over the side, or the distance from the axis beyond the rim, whichever is less.
            let up = (0.05f64.powi(2) - out * out).sqrt();
            assert!((pair.margin(&on_rim, &o, &b) - out.min(up)).abs() <= 1e-15, "rim at {out}");
            assert!((pair.margin(&on_cap, &o, &b) + out).abs() <= 1e-15, "cap at {out}");
            assert!((pair.margin(&on_side, &o, &b) + up).abs() <= 1e-15, "side at {out}");
        }
        assert!((pair.margin(&on_rim, &o, &at(0.099, 0.25)) + 0.001).abs() <= 1e-15);
    }
}

#[test]
fn an_edge_that_crosses_a_rim_in_its_plane_is_not_taken_for_one_that_leaves_it_by_roundings() {
    // A can flat on a box, and over two of its edges; turned and moved within the plane their places go along, far from any border.
    let pair = pair(cuboid(0.12, 0.141, 0.0325), Shape::Cylinder { radius: 0.136, half: 0.1145 });
    let (o, top) = (Pose::identity(), 0.0325 + 0.1145);
    let on_top =
        |x: f64, turn: f64| Pose::from_parts(Translation3::new(x, 0.004, top), Rotation3::new(Vector3::z() * turn));
    let crosses = |place: &&crate::TouchPlace| {
        let is = |feature: &FeatureId| matches!(feature, FeatureId::Edge(_));
        is(&place.identity.a) || is(&place.identity.b)
    };
    let first = pair.touches(&o, &on_top(0.01, 0.3), 1e-9);
    let crossings: Vec<_> = first.iter().filter(crosses).collect();
    assert!(!crossings.is_empty(), "{:?}", first.iter().map(|place| place.identity).collect::<Vec<_>>());
    for step in 0..200 {
        let moved = on_top(0.01 + 1e-5 * f64::from(step), 0.3 + 7e-3 * f64::from(step));
        for place in &crossings {
            let margin = pair.margin(place, &o, &moved);
            assert!(margin > 1e-3, "{:?} at {step}: {margin:e}", place.identity);
        }
    }
}

#[test]
fn balls_and_a_ball_over_a_half_space_touch_in_one_place_at_most_and_other_shapes_may_touch_in_several() {
    let mut numbers = Numbers::new(11);
    let kinds = ["half space", "sphere", "capsule", "cylinder", "ellipsoid", "box", "hull"];
    for (one, a) in kinds.iter().enumerate() {
        for b in &kinds[one.max(1)..] {
            let colliders = [a, b].map(|kind| collider(kind, 1.0, &mut numbers));
            for [a, b] in [[0, 1], [1, 0]].map(|order| order.map(|index: usize| &colliders[index])) {
                // Ellipsoids meet a half space alone.
                let Ok(pair) = PairGeometry::new(a, b) else { continue };
                let ball = |shape: &Shape| matches!(shape, Shape::Sphere { .. });
                let still = |shape: &Shape| matches!(shape, Shape::HalfSpace);
                let alone = (ball(&a.shape) || still(&a.shape)) && (ball(&b.shape) || still(&b.shape));
                assert_eq!(pair.has_one_place(), alone, "{:?} {:?}", a.shape, b.shape);
                for _ in 0..if alone { 500 } else { 0 } {
                    let places = pair.touches(&numbers.pose(0.3), &numbers.pose(0.3), 0.2);
                    assert!(places.len() <= 1, "{places:?}");
                }
            }
        }
    }
}
