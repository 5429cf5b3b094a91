//! Joints that cannot move, beside the same robot with fixed joints; and followers that were not given.

use crate::draw::Draw;
use crate::kinds::trees::motor;
use crate::scene::{Answer, Scene, Start};
use crate::urdf::{Joint, Robot};
use nalgebra::Vector3;

/// A chain with one joint that cannot move (limits that coincide, friction that cannot be overcome, or limits of a follower), and the same
/// chain with that joint fixed.
pub fn locked(draw: &mut Draw, mut scene: Scene) -> Scene {
    let count = 2 + draw.index(3);
    let which = draw.index(count);
    let how = draw.index(2);
    let seed: Vec<_> = (0..count)
        .map(|_| (draw.log(0.3, 3.0), draw.vector(0.15), draw.vector(0.25), draw.index(3), draw.range(-1.0, 1.0)))
        .collect();
    let rates: Vec<f64> = (0..count).map(|_| draw.range(-3.0, 3.0)).collect();
    let limits: Vec<_> = (0..count).map(|_| (draw.coin(0.4), draw.log(1e-2, 0.5), draw.restitution())).collect();
    let make = |is_fixed: bool| {
        let mut robot = Robot::new("chain");
        robot.base("l0");
        let mut start = Start::fixed(Vector3::zeros());
        let mut tables = Vec::new();
        for (index, (mass, centre, origin, axis, position)) in seed.iter().enumerate() {
            let (name, parent, link) = (format!("j{index}"), format!("l{index}"), format!("l{}", index + 1));
            let inertia = Vector3::new(1.0, 1.3, 1.6) * (0.01 * mass);
            robot.link(&link, *mass, inertia, *centre, None);
            let axis = Vector3::ith(*axis, 1.0);
            let plain = Joint { origin: *origin, axis, ..Joint::new(&name, "continuous", &parent, &link) };
            if index == which && is_fixed {
                robot.joint(&Joint { rpy: axis * *position, kind: "fixed", ..plain });
                continue;
            }
            start.positions.push((name.clone(), *position));
            let joint = match (index == which, how) {
                (true, 0) => Joint { kind: "revolute", limit: Some((*position, *position)), ..plain },
                (true, _) => Joint { friction: 1e5, ..plain },
                (false, _) => {
                    start.velocities.push((name.clone(), rates[index]));
                    let (has_limit, room, restitution) = limits[index];
                    if has_limit {
                        tables.push(format!("[[joint]]\nname = \"{name}\"\nrestitution = {restitution:?}"));
                        Joint { kind: "revolute", limit: Some((position - room, position + room)), ..plain }
                    } else {
                        plain
                    }
                }
            };
            robot.joint(&joint);
        }
        (robot, start, tables)
    };
    scene.duration = draw.range(0.3, 0.8);
    let duration = scene.duration;
    let fill = |scene: &mut Scene, (robot, start, tables): (Robot, Start, Vec<String>)| {
        scene.robot(&robot, &start, false);
        tables.into_iter().for_each(|table| scene.table(table));
    };
    let mut twin = Scene::new("", duration);
    let (mut robot, start, tables) = make(true);
    robot.name = "fixed".to_string();
    let text = robot.text();
    fill(&mut twin, (robot, start, tables));
    fill(&mut scene, make(false));
    scene.file("fixed.urdf", text);
    scene.twin = Some(("fixed.toml".to_string(), twin.text()));
    scene
}

/// A chain of followers whose leader alone is given a position: they start where the leader says. Sometimes a motor drives the leader.
pub fn followers(draw: &mut Draw, mut scene: Scene) -> Scene {
    let count = 1 + draw.index(3);
    let mut robot = Robot::new("gears");
    robot.base("l0");
    let leads = draw.range(-1.0, 1.0);
    let mut at = leads;
    let is_chain = draw.coin(0.5);
    for index in 0..=count {
        let (name, parent, link) = (format!("j{index}"), format!("l{index}"), format!("l{}", index + 1));
        let mass = draw.log(0.1, 3.0);
        robot.link(&link, mass, Vector3::repeat(0.01 * mass), draw.vector(0.1), None);
        let leader = if is_chain && index > 0 { format!("j{}", index - 1) } else { "j0".to_string() };
        let (multiplier, offset) = (draw.pick(&[-1.0, 0.5, 2.0, 10.0, 100.0]), draw.pick(&[0.0, 0.1, -0.3]));
        let mimic = (index > 0).then_some((leader.as_str(), multiplier, offset));
        if mimic.is_some() {
            at = multiplier * if is_chain { at } else { leads } + offset;
        }
        let axis = Vector3::ith(draw.index(3), 1.0);
        robot.joint(&Joint {
            origin: draw.vector(0.2),
            axis,
            mimic,
            ..Joint::new(&name, "continuous", &parent, &link)
        });
        scene.answers.push(Answer::Start { joint: name, right: at });
    }
    let start = Start { positions: vec![("j0".to_string(), leads)], ..Start::fixed(Vector3::zeros()) };
    scene.robot(&robot, &start, false);
    if draw.coin(0.5) {
        let table = motor(draw, "j0", leads, 0.3);
        scene.table(table);
    }
    scene.duration = draw.range(0.1, 0.3);
    scene
}
