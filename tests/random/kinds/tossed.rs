//! One body of any shape, thrown at an obstacle of any shape.

use crate::draw::Draw;
use crate::scene::{Scene, Start};
use crate::shapes::Shape;
use crate::urdf::{Joint, Robot};
use nalgebra::Vector3;

/// The obstacle is tilted, or a convex hull that is a robot of its own, and there may be a floor below it.
pub fn tossed(draw: &mut Draw, mut scene: Scene) -> Scene {
    let size = draw.log(0.05, 0.4);
    let shape = Shape::of_link(draw, "body_body", size);
    let mut body = Robot::new("body");
    let extent = shape.extent();
    body.solid("body", draw.log(0.1, 5.0), shape);
    let (tilt, is_hull) = (draw.range(0.0, 0.4), draw.coin(0.15));
    let rpy = Vector3::new(tilt, 0.0, draw.range(-3.0, 3.0));
    let shape = if is_hull {
        Shape::octahedron("rock_rock", Vector3::new(0.5, 0.6, 0.4))
    } else {
        Shape::of_obstacle(draw, "obstacle", 1.2)
    };
    // The highest point of the obstacle is at most here, wherever it is tilted.
    let height = if shape.extent().is_finite() { shape.extent().min(shape.top() + 0.6 * tilt) } else { 0.3 * tilt };
    let above = height + extent + draw.range(0.02, 0.5);
    let side = draw.vector(0.1);
    let start = Start {
        floating: true,
        position: Vector3::new(side.x, side.y, above),
        rpy: draw.vector(1.5),
        linear: draw.vector(1.0) - Vector3::z() * draw.range(0.0, 3.0),
        angular: draw.vector(6.0),
        ..Start::fixed(Vector3::zeros())
    };
    scene.robot(&body, &start, is_hull);
    if is_hull {
        let mut rock = Robot::new("rock");
        rock.base("base");
        rock.solid("rock", 10.0, shape);
        rock.joint(&Joint::new("hold", "fixed", "base", "rock"));
        scene.robot(&rock, &Start { rpy, ..Start::fixed(Vector3::zeros()) }, true);
    } else {
        let is_plane = matches!(shape, Shape::HalfSpace);
        scene.obstacle(shape, Vector3::zeros(), rpy);
        if !is_plane && draw.coin(0.5) {
            scene.obstacle(Shape::HalfSpace, Vector3::new(0.0, 0.0, -1.0), Vector3::zeros());
        }
    }
    let (friction, restitution) = (if draw.coin(0.2) { 0.0 } else { draw.range(0.05, 1.0) }, draw.restitution());
    scene.contacts(is_hull, friction, restitution);
    scene.is_lossless = friction == 0.0 && restitution == 1.0;
    scene.duration = draw.range(0.3, 1.2);
    scene
}
