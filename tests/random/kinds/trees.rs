//! Random trees: limits with any restitution, friction, damping, motors, followers, floors and floating bases.

use crate::draw::Draw;
use crate::scene::{Scene, Start};
use crate::shapes::Shape;
use crate::urdf::{Joint, Robot};
use nalgebra::Vector3;

/// What trees have.
#[derive(Clone, Copy, Default)]
pub struct Parts {
    pub joints: usize,
    /// Probabilities.
    pub limit: f64,
    pub friction: f64,
    pub damping: f64,
    pub motor: f64,
    pub mimic: f64,
    pub shape: f64,
}

/// A joint of a tree, and what the scene says of it.
struct Drawn {
    name: String,
    position: f64,
    tables: Vec<String>,
}

/// A random tree whose root is `l0`, its start, and the tables about its joints; `prefix` is before names of joints in tables.
pub fn tree(draw: &mut Draw, name: &str, parts: Parts, prefix: &str) -> (Robot, Start, Vec<String>) {
    let mut robot = Robot::new(name);
    let mut start = Start::fixed(Vector3::zeros());
    let has_shape = draw.coin(parts.shape);
    robot.random_link(draw, "l0", 0.3, has_shape);
    let mut tables = Vec::new();
    let mut drawn: Vec<Drawn> = Vec::new();
    let mut leaders: Vec<usize> = Vec::new();
    for index in 1..=parts.joints {
        let (joint, link) = (format!("j{index}"), format!("l{index}"));
        let parent = if draw.coin(0.75) { index - 1 } else { draw.index(index) };
        let has_shape = draw.coin(parts.shape);
        robot.random_link(draw, &link, 0.25, has_shape);
        let parent = format!("l{parent}");
        let kind = draw.pick(&["revolute", "revolute", "revolute", "continuous", "prismatic"]);
        let reach = if kind == "prismatic" { 0.1 } else { 1.0 };
        let position = draw.range(-reach, reach);
        let mut new = Drawn { name: joint.clone(), position, tables: Vec::new() };
        let limit = (kind != "continuous" && draw.coin(parts.limit)).then(|| {
            let mut side = || reach * if draw.coin(0.15) { 0.0 } else { draw.log(1e-3, 1.0) };
            (position - side(), position + side() + 1e-4 * reach)
        });
        let full = format!("{prefix}{joint}");
        if limit.is_some() {
            let restitution = draw.restitution();
            new.tables.push(format!("[[joint]]\nname = \"{full}\"\nrestitution = {restitution:?}"));
        }
        let axis =
            if draw.coin(0.5) { Vector3::ith(draw.index(3), 1.0) } else { draw.vector(1.0) + Vector3::x() * 0.01 };
        let (friction, damping) = (draw.log(1e-2, 2.0), draw.log(1e-3, 1.0));
        let (has_friction, has_damping) = (draw.coin(parts.friction), draw.coin(parts.damping));
        let rpy = if draw.coin(0.5) { Vector3::zeros() } else { draw.vector(1.2) };
        let mut made = Joint {
            origin: draw.vector(0.25),
            rpy,
            axis,
            limit,
            friction: if has_friction { friction } else { 0.0 },
            damping: if has_damping { damping } else { 0.0 },
            ..Joint::new(&joint, kind, &parent, &link)
        };
        let mut velocity = draw.range(-2.0, 2.0) * reach;
        let leader = (draw.coin(parts.mimic) && !leaders.is_empty()).then(|| draw.pick(&leaders));
        let (multiplier, offset) = (draw.range(-2.0, 2.0), draw.range(-0.2, 0.2));
        let leader_name = leader.map(|leader| drawn[leader].name.clone());
        if let (Some(leader), Some(leader_name)) = (leader, &leader_name) {
            made.mimic = Some((leader_name, multiplier, offset));
            // Its limits have room for the start.
            new.position = multiplier * drawn[leader].position + offset;
            made.limit = limit.map(|(low, high)| (low - position + new.position, high - position + new.position));
            (made.friction, velocity) = (0.0, 0.0);
            new.tables.clear();
        } else if kind != "continuous" || draw.coin(0.5) {
            leaders.push(index - 1);
        }
        robot.joint(&made);
        if leader.is_none() {
            start.positions.push((joint.clone(), position));
            if draw.coin(0.7) {
                start.velocities.push((joint.clone(), velocity));
            }
            if draw.coin(parts.motor) {
                new.tables.push(motor(draw, &full, position, reach));
            }
        }
        tables.append(&mut new.tables);
        drawn.push(new);
    }
    (robot, start, tables)
}

/// A motor of any kind, with a table as its target, a bound, and sometimes a period.
pub fn motor(draw: &mut Draw, joint: &str, position: f64, reach: f64) -> String {
    let mut target = |size: f64, middle: f64| {
        let instants = (0..3).map(|k| format!("[{:?}, {:?}]", 0.15 * f64::from(k), middle + draw.range(-size, size)));
        format!("[{}]", instants.collect::<Vec<_>>().join(", "))
    };
    let targets = [target(0.4 * reach, position), target(2.0 * reach, 0.0), target(3.0, 0.0)];
    let (kp, kd, bound) = (draw.log(5.0, 100.0), draw.log(0.3, 20.0), draw.log(0.5, 50.0));
    let period = if draw.coin(0.25) { 0.01 } else { 0.0 };
    let law = match draw.index(3) {
        0 => format!("kind = \"position\"\ntarget = {}\nkp = {kp:?}\nkd = {kd:?}", targets[0]),
        1 => format!("kind = \"velocity\"\ntarget = {}\nkd = {kd:?}", targets[1]),
        _ => format!("kind = \"effort\"\ntarget = {}", targets[2]),
    };
    let interpolation = draw.pick(&["hold", "linear", "cubic"]);
    format!(
        "[[motor]]\njoint = \"{joint}\"\n{law}\ninterpolation = \"{interpolation}\"\nmax_effort = {bound:?}\nperiod = {period:?}"
    )
}

fn finish(draw: &mut Draw, mut scene: Scene, parts: Parts) -> Scene {
    let gravity = draw.vector(6.0) - 3.0 * Vector3::z();
    scene.gravity(gravity);
    let (robot, start, tables) = tree(draw, "r0", parts, "");
    scene.robot(&robot, &start, false);
    tables.into_iter().for_each(|table| scene.table(table));
    // Without a floor shapes touch nothing.
    scene.solids.clear();
    scene.duration = draw.range(0.3, 1.0);
    scene
}

/// Limits, some of them narrow, with any restitution.
pub fn with_limits(draw: &mut Draw, scene: Scene) -> Scene {
    let joints = 1 + draw.index(10);
    let parts = Parts { joints, limit: 0.8, friction: 0.3, damping: 0.3, ..Parts::default() };
    finish(draw, scene, parts)
}

/// Motors at their bounds, with friction, followers and limits.
pub fn with_motors(draw: &mut Draw, scene: Scene) -> Scene {
    let joints = 1 + draw.index(8);
    let parts = Parts { joints, limit: 0.4, friction: 0.4, damping: 0.5, motor: 0.7, mimic: 0.3, ..Parts::default() };
    finish(draw, scene, parts)
}

/// A tree that lies in the air above a floor, fixed to the world or floating.
pub fn on_a_floor(draw: &mut Draw, mut scene: Scene) -> Scene {
    let joints = draw.index(6);
    let parts = Parts { joints, limit: 0.6, friction: 0.3, damping: 0.4, motor: 0.3, shape: 0.7, ..Parts::default() };
    let (robot, mut start, tables) = tree(draw, "r0", parts, "");
    let reach = 0.3 + 0.35 * joints as f64;
    start.floating = draw.coin(0.7);
    start.position = Vector3::new(0.0, 0.0, draw.range(0.3, 1.0) * reach);
    start.rpy = draw.vector(1.5);
    if start.floating {
        (start.linear, start.angular) = (draw.vector(1.0), draw.vector(2.0));
    }
    scene.robot(&robot, &start, false);
    tables.into_iter().for_each(|table| scene.table(table));
    scene.obstacle(Shape::HalfSpace, Vector3::zeros(), Vector3::zeros());
    if draw.coin(0.3) {
        let block = Shape::of_obstacle(draw, "block", 0.4);
        let at = Vector3::new(draw.range(-0.4, 0.4), draw.range(-0.4, 0.4), -0.1);
        scene.obstacle(block, at, Vector3::zeros());
    }
    let (friction, restitution) = (draw.range(0.0, 1.0), draw.restitution());
    scene.contacts(false, friction, restitution);
    scene.duration = draw.range(0.3, 0.8);
    scene
}

/// Three hinges with massless links between them, limits on the outer ones; the middle one may pass 90°.
pub fn gimbal(draw: &mut Draw, mut scene: Scene) -> Scene {
    let mut robot = Robot::new("neck");
    robot.base("base");
    robot.base("first");
    robot.base("second");
    let (mass, size) = (draw.range(0.5, 5.0), draw.vector(0.2).abs() + Vector3::repeat(0.05));
    robot.link("head", mass, size * (0.1 * mass), draw.vector(0.15), None);
    let mut start = Start::fixed(Vector3::zeros());
    let links = ["base", "first", "second", "head"];
    let mut tables = Vec::new();
    for (index, name) in ["z", "x", "y"].into_iter().enumerate() {
        let axis = [Vector3::z(), Vector3::x(), Vector3::y()][index];
        let position = draw.range(-1.2, 1.2);
        let (low, high) = (position - draw.log(1e-2, 1.0), position + draw.log(1e-2, 1.0));
        let limit = draw.coin(if index == 1 { 0.3 } else { 0.8 }).then_some((low, high));
        let (kind, restitution) = (if limit.is_some() { "revolute" } else { "continuous" }, draw.restitution());
        robot.joint(&Joint { axis, limit, ..Joint::new(name, kind, links[index], links[index + 1]) });
        start.positions.push((name.to_string(), position));
        start.velocities.push((name.to_string(), draw.range(-8.0, 8.0)));
        if limit.is_some() {
            tables.push(format!("[[joint]]\nname = \"{name}\"\nrestitution = {restitution:?}"));
        }
    }
    scene.robot(&robot, &start, false);
    tables.into_iter().for_each(|table| scene.table(table));
    scene.duration = draw.range(0.2, 0.5);
    scene
}
