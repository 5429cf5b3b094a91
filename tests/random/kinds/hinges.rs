//! Joints with closed forms, and arms that are held, which must not be called chaotic.

use crate::draw::Draw;
use crate::kinds::balls::bounced;
use crate::scene::{Answer, Scene, Start};
use crate::urdf::{Joint, Robot};
use nalgebra::Vector3;

/// A hinge with a spring and a damper, of any damping ratio. It is a position motor half of the time.
pub fn settles(draw: &mut Draw, mut scene: Scene) -> Scene {
    let (inertia, stiffness, ratio) = (draw.log(0.01, 2.0), draw.log(3.0, 1e4), draw.log(0.1, 20.0));
    let damping = 2.0 * ratio * (inertia * stiffness).sqrt();
    let from = draw.range(-1.0, 1.0);
    scene.duration = draw.range(0.5, 8.0);
    let mut robot = Robot::new("hinge");
    robot.base("base");
    robot.link("arm", 1.0, Vector3::repeat(inertia), Vector3::zeros(), None);
    robot.joint(&Joint::new("j", "continuous", "base", "arm"));
    let start = Start { positions: vec![("j".to_string(), from)], ..Start::fixed(Vector3::zeros()) };
    scene.robot(&robot, &start, false);
    scene.table(if draw.coin(0.5) {
        format!("[[spring]]\njoint = \"j\"\nstiffness = {stiffness:?}\ndamping = {damping:?}\nrest = 0.0")
    } else {
        format!("[[motor]]\njoint = \"j\"\nkind = \"position\"\ntarget = 0.0\nkp = {stiffness:?}\nkd = {damping:?}\nmax_effort = 1e6")
    });
    let (rate, time) = ((stiffness / inertia).sqrt(), scene.duration);
    let right = if ratio < 1.0 {
        let turn = rate * (1.0 - ratio * ratio).sqrt();
        let (sine, cosine) = (turn * time).sin_cos();
        from * (-ratio * rate * time).exp() * (cosine + ratio * rate / turn * sine)
    } else {
        let root = (ratio * ratio - 1.0).sqrt().max(1e-9);
        let (slow, fast) = (-rate * (ratio - root), -rate * (ratio + root));
        from * (fast * (slow * time).exp() - slow * (fast * time).exp()) / (fast - slow)
    };
    scene.answers.push(Answer::Joint { joint: "j".to_string(), right, bound: 2e-5 });
    scene.is_calm = true;
    scene.stored = 0.5 * stiffness * from * from;
    scene.pull = stiffness * from.abs();
    scene
}

/// Up to three hinges under gravity, held by position motors that damp more than critically.
pub fn arm(draw: &mut Draw, mut scene: Scene) -> Scene {
    let count = 1 + draw.index(3);
    let mut robot = Robot::new("arm");
    robot.base("l0");
    let mut start = Start::fixed(Vector3::zeros());
    let (names, links): (Vec<_>, Vec<_>) = (0..count).map(|k| (format!("j{k}"), format!("l{}", k + 1))).unzip();
    for index in 0..count {
        let (mass, length) = (draw.range(0.5, 3.0), draw.range(0.2, 0.5));
        let inertia = Vector3::new(0.1, 1.0, 1.0) * (mass * length * length / 12.0);
        robot.link(&links[index], mass, inertia, Vector3::new(0.5 * length, 0.0, 0.0), None);
        let parent = if index == 0 { "l0" } else { &links[index - 1] };
        let origin = Vector3::new(if index == 0 { 0.0 } else { 0.3 }, 0.0, 0.0);
        let joint = Joint::new(&names[index], "continuous", parent, &links[index]);
        robot.joint(&Joint { origin, axis: Vector3::y(), ..joint });
        start.positions.push((names[index].clone(), draw.range(-0.5, 0.5)));
    }
    scene.robot(&robot, &start, false);
    for (name, (_, at)) in names.iter().zip(&start.positions) {
        let (kp, kd) = (draw.log(60.0, 1000.0), draw.log(20.0, 200.0));
        let target = at + draw.range(-0.2, 0.2);
        scene.stored += 0.5 * kp * (target - at).powi(2);
        scene.pull += kp * (target - at).abs();
        scene.table(format!(
            "[[motor]]\njoint = \"{name}\"\nkind = \"position\"\ntarget = {target:?}\nkp = {kp:?}\nkd = {kd:?}\nmax_effort = 1e5"
        ));
    }
    scene.duration = draw.range(0.5, 6.0);
    scene.is_calm = true;
    scene
}

/// A slide bounces on its lower limit.
pub fn limit(draw: &mut Draw, mut scene: Scene) -> Scene {
    let (restitution, height) = (draw.restitution(), draw.range(0.1, 1.5));
    scene.duration = draw.range(0.5, 5.0);
    let mut robot = Robot::new("slide");
    robot.base("base");
    robot.link("cart", draw.range(0.1, 10.0), Vector3::repeat(1.0), Vector3::zeros(), None);
    robot.joint(&Joint { limit: Some((0.0, 5.0)), ..Joint::new("j", "prismatic", "base", "cart") });
    let start = Start { positions: vec![("j".to_string(), height)], ..Start::fixed(Vector3::zeros()) };
    scene.robot(&robot, &start, false);
    scene.table(format!("[[joint]]\nname = \"j\"\nrestitution = {restitution:?}"));
    let (right, _) = bounced(height, restitution, scene.duration);
    scene.answers.push(Answer::Joint { joint: "j".to_string(), right, bound: 1e-5 });
    scene.is_lossless = restitution == 1.0;
    scene
}
