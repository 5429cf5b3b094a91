//! Single bodies with closed forms: balls that bounce, blocks that slide, balls that roll, and rows of balls that pass on a blow.

use crate::draw::Draw;
use crate::kinds::GRAVITY;
use crate::scene::{Answer, Scene, Start};
use crate::shapes::Shape;
use crate::urdf::{Joint, Robot};
use nalgebra::Vector3;

/// The height (m) after `time` of a ball that falls from `height` and rebounds with this restitution, and the number of its impacts.
pub fn bounced(height: f64, restitution: f64, time: f64) -> (f64, usize) {
    let fall = (2.0 * height / GRAVITY).sqrt();
    if time <= fall {
        return (height - 0.5 * GRAVITY * time * time, 0);
    }
    let (mut speed, mut left, mut count) = ((2.0 * GRAVITY * height).sqrt() * restitution, time - fall, 1);
    while speed > 1e-9 && left > 2.0 * speed / GRAVITY {
        left -= 2.0 * speed / GRAVITY;
        speed *= restitution;
        count += 1;
    }
    (if speed > 1e-9 { speed * left - 0.5 * GRAVITY * left * left } else { 0.0 }, count)
}

/// A ball is dropped on the middle of an obstacle.
pub fn bounces(draw: &mut Draw, mut scene: Scene) -> Scene {
    let (radius, height, restitution) = (draw.range(0.02, 0.3), draw.range(0.05, 2.0), draw.restitution());
    scene.duration = draw.range(0.5, 5.0);
    let mut ball = Robot::new("ball");
    ball.solid("ball", draw.range(0.1, 5.0), Shape::Sphere { radius });
    let thin = draw.log(0.01, 1.0);
    let shape = match draw.index(6) {
        0 => Shape::HalfSpace,
        1 => Shape::Cylinder { radius: 1.0, length: thin },
        2 => Shape::Sphere { radius: thin },
        3 => Shape::block("plate", Vector3::new(2.0, 1.5, thin)),
        _ => Shape::Box { size: Vector3::new(2.0, 2.0, thin) },
    };
    scene.robot(&ball, &Start::floating(Vector3::new(0.0, 0.0, radius + height)), false);
    let below = shape.top();
    scene.obstacle(shape, Vector3::new(0.0, 0.0, -below), Vector3::zeros());
    scene.contacts(false, 0.5, restitution);
    let (right, impacts) = bounced(height, restitution, scene.duration);
    scene.answers.push(Answer::Place { link: "ball".to_string(), axis: 2, right: right + radius, bound: 1e-5 });
    if restitution == 1.0 {
        scene.answers.push(Answer::Impacts { right: impacts });
        scene.is_lossless = true;
    }
    scene
}

/// A block slides on a floor until it stops, after v²/(2 μ g).
pub fn slides(draw: &mut Draw, mut scene: Scene) -> Scene {
    let (friction, speed) = (draw.range(0.05, 0.9), draw.range(0.3, 4.0));
    let mut size = Vector3::from_fn(|_, _| draw.range(0.1, 0.5));
    size.z = 0.5 * size.min();
    let mut block = Robot::new("block");
    block.solid("block", draw.range(0.2, 8.0), Shape::Box { size });
    let velocity = Vector3::new(speed, 0.0, 0.0);
    scene.robot(&block, &Start { linear: velocity, ..Start::floating(Vector3::new(0.0, 0.0, 0.5 * size.z)) }, false);
    let (floor, below) = match draw.index(3) {
        0 => (Shape::HalfSpace, 0.0),
        1 => (Shape::block("floor", Vector3::new(60.0, 60.0, 1.0)), 0.5),
        _ => (Shape::Box { size: Vector3::new(60.0, 60.0, 1.0) }, 0.5),
    };
    scene.obstacle(floor, Vector3::new(0.0, 0.0, -below), Vector3::zeros());
    scene.contacts(false, friction, 0.0);
    scene.duration = speed / (friction * GRAVITY) + 0.5;
    let right = speed * speed / (2.0 * friction * GRAVITY);
    scene.answers.push(Answer::Place { link: "block".to_string(), axis: 0, right, bound: 1e-5 });
    scene.is_calm = true;
    scene
}

/// A block falls flat, bounces with its friction, and slides until it stops, after v²/(2 μ g) + μ h from where it was let go, whatever its restitution.
pub fn lands(draw: &mut Draw, mut scene: Scene) -> Scene {
    let (friction, restitution, height) = (draw.range(0.05, 0.9), draw.range(0.0, 0.3), draw.range(0.001, 0.02));
    let falls = (2.0 * height / GRAVITY).sqrt();
    // It slides on after the last bounce.
    let bounces = friction * GRAVITY * falls * (1.0 + 2.0 * restitution / (1.0 - restitution));
    let speed = bounces + draw.range(0.1, 3.0);
    let mut size = Vector3::from_fn(|_, _| draw.range(0.1, 0.5));
    size.z = 0.5 * size.min();
    let mut block = Robot::new("block");
    block.solid("block", draw.range(0.2, 8.0), Shape::Box { size });
    let velocity = Vector3::new(speed, 0.0, 0.0);
    let place = Vector3::new(0.0, 0.0, 0.5 * size.z + height);
    scene.robot(&block, &Start { linear: velocity, ..Start::floating(place) }, false);
    scene.obstacle(Shape::HalfSpace, Vector3::zeros(), Vector3::zeros());
    scene.contacts(false, friction, restitution);
    scene.duration = speed / (friction * GRAVITY) + 0.5;
    let right = speed * speed / (2.0 * friction * GRAVITY) + friction * height;
    scene.answers.push(Answer::Place { link: "block".to_string(), axis: 0, right, bound: 2e-6 });
    scene.is_calm = true;
    scene
}

/// A ball rolls down a slope that is steep enough for 5/14 g sin α t², and not too steep for its friction.
pub fn rolls(draw: &mut Draw, mut scene: Scene) -> Scene {
    let (radius, mass, slope) = (draw.range(0.03, 0.3), draw.range(0.2, 5.0), draw.range(0.05, 0.5));
    let friction = 2.0 / 7.0 * slope.tan() * draw.range(1.2, 3.0);
    scene.duration = draw.range(0.3, 2.0);
    let mut ball = Robot::new("ball");
    ball.solid("ball", mass, Shape::Sphere { radius });
    scene.gravity(GRAVITY * Vector3::new(slope.sin(), 0.0, -slope.cos()));
    scene.robot(&ball, &Start::floating(Vector3::new(0.0, 0.0, radius)), false);
    let (floor, below) = match draw.index(2) {
        0 => (Shape::HalfSpace, 0.0),
        _ => (Shape::Box { size: Vector3::new(60.0, 60.0, 1.0) }, 0.5),
    };
    scene.obstacle(floor, Vector3::new(0.0, 0.0, -below), Vector3::zeros());
    scene.contacts(false, friction, draw.restitution());
    let right = 5.0 / 14.0 * GRAVITY * slope.sin() * scene.duration.powi(2);
    scene.answers.push(Answer::Place { link: "ball".to_string(), axis: 0, right, bound: 1e-5 });
    scene.is_calm = true;
    scene
}

/// Equal balls in a row on slides, with or without gaps: the last one leaves with the velocity of the first.
pub fn cradle(draw: &mut Draw, mut scene: Scene) -> Scene {
    let (count, radius, mass) = (2 + draw.index(4), draw.range(0.01, 0.1), draw.range(0.1, 3.0));
    let (speed, run_up) = (draw.range(0.2, 2.0), draw.range(0.01, 0.3));
    let touches = draw.coin(0.5);
    let mut at = 0.0;
    let mut gaps = 0.0;
    for index in 0..count {
        let mut ball = Robot::new(&format!("b{index}"));
        ball.base("base");
        ball.solid("ball", mass, Shape::Sphere { radius });
        ball.joint(&Joint { axis: Vector3::x(), ..Joint::new("rail", "prismatic", "base", "ball") });
        let mut start = Start::fixed(Vector3::new(at, 0.0, 0.0));
        if index == 0 {
            start.velocities.push(("rail".to_string(), speed));
        }
        scene.robot(&ball, &start, true);
        let gap = match index {
            0 => run_up,
            _ if touches => 0.0,
            _ => draw.log(1e-5, 0.05),
        };
        at += 2.0 * radius + gap;
        gaps += if index + 1 < count { gap } else { 0.0 };
    }
    scene.contacts(true, 0.0, 1.0);
    scene.duration = gaps / speed + draw.range(0.1, 0.5);
    let last = format!("b{}/rail", count - 1);
    let right = speed * (scene.duration - gaps / speed);
    scene.answers.push(Answer::Joint { joint: last, right, bound: 1e-5 });
    let middle = (1..count - 1).map(|index| (index, 0.0));
    if touches {
        let still = middle.map(|(index, right)| Answer::Joint { joint: format!("b{index}/rail"), right, bound: 1e-5 });
        scene.answers.extend(still);
        scene.answers.push(Answer::FewEvents { most: 10 * count });
    }
    scene.is_lossless = true;
    scene
}
