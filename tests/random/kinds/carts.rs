//! Carts on four cylinder wheels that speed up or roll on, with axes that files have rounded.
//!
//! ```text
//!     ẍ = 4 τ/ρ / (M + 4 m + 4 I/ρ²)          z = d + ρ cos ε + h |sin ε|
//! ```
//!
//! with the torque τ of each wheel, its radius ρ, half its width h, its moment I about its axle, the camber ε and the depth d of the axles.

use crate::draw::Draw;
use crate::kinds::GRAVITY;
use crate::scene::{Answer, Scene, Start};
use crate::shapes::Shape;
use crate::urdf::{Joint, Robot, inertia};
use nalgebra::Vector3;
use std::f64::consts::FRAC_PI_2;

/// Cambers of axles (rad): none, those of right angles of 7, 5 and 3 digits, and one that is meant.
const CAMBERS: [f64; 5] = [0.0, 3.3e-7, -3.7e-6, 8e-4, 0.05];

/// A cart that starts at rest with a torque in each wheel, or that rolls on without.
pub fn cart(draw: &mut Draw, mut scene: Scene) -> Scene {
    let (radius, length, below) = (draw.range(0.05, 0.2), draw.range(0.02, 0.1), draw.range(0.02, 0.1));
    let (body, mass) = (draw.range(2.0, 20.0), draw.range(0.1, 1.0));
    let wheel = Shape::Cylinder { radius, length };
    let about = inertia(mass, &wheel).z;
    let rolling = body + 4.0 * mass + 4.0 * about / (radius * radius);
    let speeds_up = draw.coin(0.6);
    let (speed, acceleration) = if speeds_up { (0.0, draw.range(0.2, 1.0)) } else { (draw.range(0.2, 2.0), 0.0) };
    let camber = draw.pick(&CAMBERS);
    let height = below + radius * camber.cos() + 0.5 * length * camber.sin().abs();
    let mut robot = Robot::new("cart");
    robot.link("chassis", body, Vector3::new(0.05, 0.1, 0.1) * body, Vector3::zeros(), None);
    let mut start = Start::floating(Vector3::new(0.0, 0.0, height));
    start.linear = Vector3::x() * speed;
    let mut motors = Vec::new();
    for (name, x, y) in [("fl", 0.3, 0.2), ("fr", 0.3, -0.2), ("rl", -0.3, 0.2), ("rr", -0.3, -0.2)] {
        // The shape is turned on its axle by the rounding of seven digits and more.
        let (off, towards) = (draw.log(1e-10, 1e-7), draw.range(0.0, 6.0));
        let turned = Vector3::new(off * towards.cos(), off * towards.sin(), 0.0);
        robot.turned_solid(name, mass, wheel.clone(), &turned);
        let axle = format!("axle_{name}");
        let (origin, rpy) = (Vector3::new(x, y, -below), Vector3::new(camber - FRAC_PI_2, 0.0, 0.0));
        robot.joint(&Joint { origin, rpy, ..Joint::new(&axle, "continuous", "chassis", name) });
        start.velocities.push((axle.clone(), speed / radius));
        let torque = 0.25 * acceleration * radius * rolling;
        motors.push(format!("[[motor]]\njoint = \"{axle}\"\nkind = \"effort\"\ntarget = {torque:?}"));
    }
    scene.robot(&robot, &start, false);
    motors.into_iter().filter(|_| speeds_up).for_each(|motor| scene.table(motor));
    scene.obstacle(Shape::HalfSpace, Vector3::zeros(), Vector3::zeros());
    // No wheel slips: it pulls with less than a fifth of its load.
    scene.contacts(false, draw.range(0.5, 1.0).max(2.0 * acceleration / GRAVITY), 0.0);
    scene.duration = draw.range(0.5, 2.0);
    let way = speed * scene.duration + 0.5 * acceleration * scene.duration * scene.duration;
    for (axis, right) in [way, 0.0, height].into_iter().enumerate() {
        scene.answers.push(Answer::Place { link: "chassis".to_string(), axis, right, bound: 1e-5 });
    }
    scene.answers.push(Answer::FewEvents { most: 40 });
    scene.is_calm = true;
    scene
}
