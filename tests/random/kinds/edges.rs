//! A box that slides off a table and tips about its edge.

use crate::draw::Draw;
use crate::kinds::GRAVITY;
use crate::scene::{Answer, Scene, Start};
use crate::shapes::Shape;
use crate::urdf::Robot;
use nalgebra::Vector3;

/// Steps of Runge and Kutta's method while it tips.
const STEPS: usize = 4000;

/// The place of the centre and the angle, and their rates, from the edge on: (x, z, θ) [m, m, rad].
type Tipping = [f64; 6];

/// The change of a box of this length and height (m) whose lower face slides over the edge at the origin with friction. With its normal n, the slip
/// along t, and the arm r from the centre to the edge, `n · (a + ω̇ × r − ω² r) + 2 ω t · v = 0` for a force (n − μ t) N.
fn slope(length: f64, height: f64, friction: f64, y: &Tipping) -> Tipping {
    let [x, z, angle, vx, vz, rate] = *y;
    let (sin, cos) = angle.sin_cos();
    let inertia = (length * length + height * height) / 12.0;
    let (normal, along, arm) = ([sin, cos], [cos, -sin], [-x, -z]);
    let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
    let force = [normal[0] - friction * along[0], normal[1] - friction * along[1]];
    let turning = (arm[1] * force[0] - arm[0] * force[1]) / inertia;
    let carried = -GRAVITY * normal[1] + 2.0 * rate * dot(along, [vx, vz]) + rate * rate * dot(normal, arm);
    let pressure = -carried / (dot(normal, force) - turning * dot(along, arm));
    [vx, vz, rate, pressure * force[0], pressure * force[1] - GRAVITY, pressure * turning]
}

/// A step of Runge and Kutta's method.
fn step(of: impl Fn(&Tipping) -> Tipping, y: &Tipping, h: f64) -> Tipping {
    let moved = |by: &Tipping, h: f64| std::array::from_fn(|index| y[index] + h * by[index]);
    let first = of(y);
    let second = of(&moved(&first, 0.5 * h));
    let third = of(&moved(&second, 0.5 * h));
    let last = of(&moved(&third, h));
    std::array::from_fn(|index| {
        y[index] + h / 6.0 * (first[index] + 2.0 * second[index] + 2.0 * third[index] + last[index])
    })
}

/// A box slides over the edge of a table and begins to tip where its weight and the friction have no moment about the edge, at x = −μ h/2. It ends while
/// it slides over the edge.
pub fn over_an_edge(draw: &mut Draw, mut scene: Scene) -> Scene {
    let (length, depth, height) = (draw.range(0.15, 0.3), draw.range(0.1, 0.2), draw.range(0.05, 0.15));
    let (friction, speed, from) = (draw.range(0.05, 0.2), draw.range(1.0, 2.0), -0.2);
    let mut body = Robot::new("box");
    body.solid("box", draw.range(0.3, 30.0), Shape::Box { size: Vector3::new(length, depth, height) });
    let start = Start::floating(Vector3::new(from, 0.0, 0.5 * height));
    scene.robot(&body, &Start { linear: Vector3::new(speed, 0.0, 0.0), ..start }, false);
    let thick = draw.range(0.03, 0.5);
    let table = Shape::Box { size: Vector3::new(1.0, 1.0, thick) };
    scene.obstacle(table, Vector3::new(-0.5, 0.0, -0.5 * thick), Vector3::zeros());
    scene.contacts(false, friction, 0.0);
    let (braking, way) = (friction * GRAVITY, -0.5 * friction * height - from);
    let tips = (speed - (speed * speed - 2.0 * braking * way).sqrt()) / braking;
    let rest = 0.3 * length / speed;
    let mut y = [-0.5 * friction * height, 0.5 * height, 0.0, speed - braking * tips, 0.0, 0.0];
    for _ in 0..STEPS {
        y = step(|y| slope(length, height, friction, y), &y, rest / STEPS as f64);
    }
    scene.duration = tips + rest;
    // Contacts that part late leave 1e-6 m; a run at 1e-6 m is a tenth of that off.
    for (axis, right) in [(0, y[0]), (2, y[1])] {
        scene.answers.push(Answer::Place { link: "box".to_string(), axis, right, bound: 2e-7 });
    }
    scene.is_calm = true;
    scene
}
