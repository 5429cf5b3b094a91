//! The lengths from which the tolerances of a pair are made.

use crate::PairGeometry;
use catena_mechanism::description::contact::{Collider, Shape};
use catena_mechanism::description::joint::Pose;
use nalgebra::{Translation3, UnitQuaternion, Vector3};

fn collider(body: Option<usize>, place: Vector3<f64>, shape: Shape) -> Collider {
    let pose = Pose::from_parts(Translation3::from(place), UnitQuaternion::identity().to_rotation_matrix());
    Collider::still("one", body, pose, shape)
}

#[test]
fn an_obstacle_is_no_larger_for_being_far_away() {
    let ball = collider(Some(0), Vector3::x() * 0.2, Shape::Sphere { radius: 0.1 });
    let block = |far: f64| collider(None, Vector3::x() * far, Shape::Box { half: Vector3::new(0.3, 0.4, 1.2) });
    for far in [0.0, 1e3] {
        for (a, b) in [(ball.clone(), block(far)), (block(far), ball.clone())] {
            let extents = PairGeometry::new(&a, &b).expect("shapes that are possible").extents();
            assert!((extents.larger - 1.3).abs() < 1e-12 && (extents.smaller - 0.3).abs() < 1e-15, "{extents:?}");
            // Some tens of ulps of a kilometre, 1.1e-13 m, but not ten thousand.
            let rounding = extents.within(0.0);
            assert!(rounding >= far * 1e-15 && rounding <= (far + 2.0) * 1e-13, "{extents:?}");
            assert!((extents.within(1e-9) - 1.3e-9 - rounding).abs() < 1e-20, "{extents:?}");
        }
    }
    // A plane has no size.
    let floor = collider(None, Vector3::zeros(), Shape::HalfSpace);
    let extents = PairGeometry::new(&floor, &ball).expect("shapes that are possible").extents();
    assert!((extents.larger - 0.3).abs() < 1e-15 && extents.smaller == extents.larger, "{extents:?}");
    assert_eq!(extents.farthest, 0.0);
}
