//! A robot whose legs and trunk touch each other.

use crate::draw::Draw;
use crate::scene::{Scene, Start};
use crate::shapes::Shape;
use crate::urdf::{Joint, Robot};
use nalgebra::Vector3;

/// A trunk with two to four legs of two links each, in space or above a floor. The legs start apart and move fast.
pub fn robot(draw: &mut Draw, mut scene: Scene) -> Scene {
    let mut robot = Robot::new("r");
    let legs = 2 + draw.index(3);
    robot.solid("trunk", draw.log(1.0, 8.0), Shape::Box { size: Vector3::new(0.6, 0.2, 0.1) });
    let mut start = Start::floating(Vector3::new(0.0, 0.0, draw.range(0.7, 1.0)));
    (start.rpy, start.linear, start.angular) = (draw.vector(0.4), draw.vector(0.5), draw.vector(2.0));
    for leg in 0..legs {
        let [thigh, shank] = ["thigh", "shank"].map(|part| format!("{part}{leg}"));
        robot.solid(&thigh, draw.log(0.3, 1.0), Shape::Capsule { radius: 0.03, length: 0.14 });
        let foot = if draw.coin(0.5) {
            Shape::Sphere { radius: 0.04 }
        } else {
            Shape::Box { size: Vector3::new(0.06, 0.05, draw.range(0.05, 0.15)) }
        };
        robot.solid(&shank, draw.log(0.2, 0.6), foot);
        let (friction, damping) = (if draw.coin(0.3) { 0.1 } else { 0.0 }, if draw.coin(0.5) { 0.02 } else { 0.0 });
        for (name, parent, child, origin, most) in [
            (format!("hip{leg}"), "trunk", &thigh, Vector3::new(-0.24 + 0.16 * leg as f64, 0.0, -0.06), 1.4),
            (format!("knee{leg}"), thigh.as_str(), &shank, Vector3::new(0.0, 0.0, -0.12), 2.7),
        ] {
            // Links are about their origins: each hangs on a stem without mass below its joint.
            let stem = format!("{name}_stem");
            robot.base(&stem);
            robot.joint(&Joint {
                origin,
                axis: Vector3::y(),
                limit: Some((-most, most)),
                damping,
                friction,
                ..Joint::new(&name, "revolute", parent, &stem)
            });
            let below = Vector3::new(0.0, 0.0, -0.12);
            robot.joint(&Joint { origin: below, ..Joint::new(&format!("{name}_hold"), "fixed", &stem, child) });
            start.positions.push((name.clone(), draw.range(-0.05, 0.05)));
            start.velocities.push((name, draw.range(-8.0, 8.0)));
        }
        scene.itself.push(["trunk".to_string(), shank.clone()]);
        for other in 0..leg {
            for own in [&thigh, &shank] {
                scene.itself.extend(["thigh", "shank"].map(|part| [own.clone(), format!("{part}{other}")]));
            }
        }
    }
    scene.robot(&robot, &start, false);
    if draw.coin(0.7) {
        scene.obstacle(Shape::HalfSpace, Vector3::zeros(), Vector3::zeros());
    } else {
        scene.gravity(Vector3::zeros());
    }
    let (friction, restitution) = (draw.range(0.0, 1.0), draw.restitution());
    scene.contacts(false, friction, restitution);
    scene.duration = draw.range(0.2, 0.6);
    scene
}
