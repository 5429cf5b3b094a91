//! Obstacles far from the origin of the world, and huge ones: what is let go above them falls onto them, however small the gap.

use crate::exact::near;
use crate::mechanisms::{GRAVITY, of_kind, run};
use catena::mechanism::description::contact::{Collider, ContactPair, Shape, Surface};
use catena::mechanism::description::joint::{Joint, JointKind, Pose};
use catena::mechanism::description::mechanism::{Body, Mechanism};
use catena::mechanism::motion::event::EventKind;
use catena::mechanism::motion::state::State;
use catena::simulation::StepChoice;
use nalgebra::{Translation3, Vector3};

/// Half a micrometre (m).
const GAP: f64 = 5e-7;
/// Radius of the ball (m).
const RADIUS: f64 = 0.1;

/// A ball that is let go above an obstacle in this place, whose highest plane is at this height over it (m).
fn let_go(shape: Shape, place: Vector3<f64>, height: f64) -> (Mechanism, State) {
    let joint = Joint::new("free", JointKind::Floating, Pose::identity(), Pose::identity());
    let body = Body { name: "ball".into(), parent: None, mass: 1.0, inertia: Vector3::repeat(4e-3), joint };
    let mut mechanism = Mechanism::new("ball", Vector3::z() * -GRAVITY, vec![body]).expect("one body");
    let nonsmooth = &mut mechanism.nonsmooth;
    let pose = Pose::from_parts(Translation3::from(place), Pose::identity().rotation);
    nonsmooth.colliders.push(Collider::still("block", None, pose, shape));
    let shape = Shape::Sphere { radius: RADIUS };
    nonsmooth.colliders.push(Collider::still("ball", Some(0), Pose::identity(), shape));
    nonsmooth.pairs.push(ContactPair::without_moments(0, [0, 1], 0.5, 0.0));
    let mut start = State::zero(&mechanism);
    let at = place + Vector3::new(0.2, 0.3, height + RADIUS + GAP);
    start.position[..3].copy_from_slice(at.as_slice());
    (mechanism, start)
}

#[test]
fn a_ball_let_go_half_a_micrometre_above_an_obstacle_falls_onto_it_wherever_that_is_and_however_large() {
    let block = |half: f64| Shape::Box { half: Vector3::repeat(half) };
    // A square of 4 m, of two triangles.
    let corner = |x: f64, y: f64| Vector3::new(2.0 * x, 2.0 * y, 0.0);
    let vertices = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let square = || Shape::Mesh(Surface { vertices: vertices.clone(), triangles: vec![[0, 1, 2], [0, 2, 3]] }.into());
    let far = Vector3::new(1e3, -2e3, 0.0);
    // Gaps are known to some ulps of 800 m, 1e-13 m, which is 2e-7 of half a micrometre.
    for (shape, place, height, exact) in [
        (block(0.5), Vector3::zeros(), 0.5, 1e-12),
        (block(0.5), far, 0.5, 1e-12),
        (block(0.5), Vector3::new(600.0, 0.0, 800.0), 0.5, 1e-9),
        (block(5e3), Vector3::new(0.0, 0.0, -5e3), 5e3, 1e-9),
        (square(), far, 0.0, 1e-12),
    ] {
        let (mechanism, start) = let_go(shape, place, height);
        let finished = run(&mechanism, &start, 0.5, StepChoice::Tolerance(1e-6));
        let impacts = of_kind(&finished, EventKind::ContactImpact);
        assert_eq!(impacts.len(), 1, "{place}: {:?}", finished.events);
        let gap = start.position[2] - place.z - height - RADIUS;
        near(impacts[0].time, (2.0 * gap / GRAVITY).sqrt(), exact);
        assert_eq!(finished.state.velocity, vec![0.0; 6], "{place}");
        near(finished.state.position[2], start.position[2] - gap, 1e-6 * exact.max(1e-9));
    }
}
