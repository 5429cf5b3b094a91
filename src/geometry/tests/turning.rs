//! Turning about vertices that touch a half space: how far until another one touches.

use super::scenes::{Numbers, pair};
use catena_mechanism::description::contact::Shape;
use catena_mechanism::description::joint::Pose;
use nalgebra::{Rotation3, Translation3, Unit, Vector3};
use std::sync::Arc;

/// A pose with its lowest vertex, and where that is, on the plane z = 0.
fn lowered(points: &[Vector3<f64>], turn: Rotation3<f64>) -> (Pose, Vector3<f64>) {
    let lowest = points.iter().map(|point| turn * point).min_by(|a, b| a.z.total_cmp(&b.z)).expect("points");
    (Pose::from_parts(Translation3::new(0.0, 0.0, -lowest.z), turn), turn.inverse() * lowest)
}

#[test]
fn a_hull_that_turns_about_its_vertex_by_less_than_the_angle_touches_with_no_other_and_by_little_more_may() {
    let mut numbers = Numbers::new(7);
    let mut touched = 0;
    // With neighbours that are known, and without.
    for count in [8, 30, 200, 600].repeat(10) {
        let points: Vec<Vector3<f64>> = (0..count).map(|_| numbers.vector().normalize() * 0.1).collect();
        let on_floor = pair(Shape::HalfSpace, Shape::Hull(Arc::new(points.clone())));
        let (pose, vertex) = lowered(&points, numbers.pose(0.0).rotation);
        let places = on_floor.touches(&Pose::identity(), &pose, 1e-12);
        let closed = places.iter().map(|place| place.identity);
        let least = on_floor.turns_at_least(closed, &Pose::identity(), &pose).expect("a vertex on a plane");
        assert!(least > 0.0);
        let turned_about = |axis: &Vector3<f64>, angle: f64| {
            let turn = Rotation3::from_axis_angle(&Unit::new_normalize(*axis), angle) * pose.rotation;
            let others = points.iter().filter(|point| (*point - vertex).norm() > 1e-12);
            others.map(|point| (turn * (point - vertex)).z).fold(f64::INFINITY, f64::min)
        };
        for _ in 0..100 {
            let axis = numbers.vector();
            assert!(turned_about(&axis, least) > -1e-15, "{count}: {}", turned_about(&axis, least));
        }
        // Straight down along the steepest line of the lowest neighbour it gets there at asin of the slope.
        let slope = |point: &Vector3<f64>| {
            let line = pose.rotation * (point - vertex);
            line.z / line.norm()
        };
        let others = points.iter().filter(|point| (*point - vertex).norm() > 1e-12);
        let first = others.min_by(|a, b| slope(a).total_cmp(&slope(b))).expect("another vertex");
        assert!((slope(first) - least).abs() < 1e-12, "{count}: {} {least}", slope(first));
        let axis = (pose.rotation * (first - vertex)).cross(&-Vector3::z());
        touched += usize::from(turned_about(&axis, 1.01 * least.asin()) < 0.0);
    }
    assert_eq!(touched, 40);
}
