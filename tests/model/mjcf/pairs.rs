//! Robots that exist as URDF and as MJCF move alike: the same masses, inertias and limits, and the same free motion.
//!
//! The MJCF is written here from the numbers of the URDF with all their digits, without any of the code that reads MJCF. Models of public packages are
//! read from the folders that the variables `CATENA_ROBOTS` (URDF) and `CATENA_MJCF` name, separated by colons; without these the tests skip them.

use crate::common::{scratch, stem, urdf_files};
use catena::scene::{Robot, UrdfJoint, UrdfJointKind, robot_without_meshes};
use catena::session::{Model, Simulation};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Numbers with all their digits.
fn listed(numbers: &[f64]) -> String {
    numbers.iter().map(|number| format!("{number:?}")).collect::<Vec<_>>().join(" ")
}

/// A turn as w, x, y, z.
fn quaternion(turn: &Rotation3<f64>) -> String {
    let turn = UnitQuaternion::from_rotation_matrix(turn);
    listed(&[turn.w, turn.i, turn.j, turn.k])
}

/// A link with everything beyond it.
fn write_body(robot: &Robot, link: usize, above: Option<&UrdfJoint>, text: &mut String) {
    let pose = above.map(|joint| joint.origin).unwrap_or_default();
    let (place, turn) = (listed(pose.translation.vector.as_slice()), quaternion(&pose.rotation));
    write!(text, "<body name=\"{}\" pos=\"{place}\" quat=\"{turn}\">", robot.links[link].name).expect("text");
    if let Some(joint) = above.filter(|joint| joint.kind != UrdfJointKind::Fixed) {
        let kind = match joint.kind {
            UrdfJointKind::Prismatic => "slide",
            UrdfJointKind::Spherical => "ball",
            _ => "hinge",
        };
        let (name, axis) = (&joint.name, listed(joint.axis.as_slice()));
        write!(text, "<joint name=\"{name}\" type=\"{kind}\" axis=\"{axis}\"").expect("text");
        if let Some((lower, upper)) = joint.own_limits().filter(|(lower, upper)| lower.is_finite() && upper.is_finite())
        {
            write!(text, " range=\"{lower:?} {upper:?}\"").expect("text");
        }
        let (damping, friction) = joint.dynamics.map_or((0.0, 0.0), |dynamics| (dynamics.damping, dynamics.friction));
        write!(text, " damping=\"{damping:?}\" frictionloss=\"{friction:?}\"/>").expect("text");
    }
    if let Some(inertial) = robot.links[link].inertial.as_ref().filter(|inertial| inertial.mass > 0.0) {
        let turn = inertial.origin.rotation.matrix();
        let i: Matrix3<f64> = turn * inertial.inertia * turn.transpose();
        let place = listed(inertial.origin.translation.vector.as_slice());
        let full = listed(&[i[(0, 0)], i[(1, 1)], i[(2, 2)], i[(0, 1)], i[(0, 2)], i[(1, 2)]]);
        write!(text, "<inertial pos=\"{place}\" mass=\"{:?}\" fullinertia=\"{full}\"/>", inertial.mass).expect("text");
    }
    for joint in robot.joints.iter().filter(|joint| joint.parent == robot.links[link].name) {
        let child = robot.links.iter().position(|link| link.name == joint.child).expect("a link");
        write_body(robot, child, Some(joint), text);
    }
    text.push_str("</body>\n");
}

/// A robot as MJCF; `None` if it has joints that MJCF has not.
fn as_mjcf(robot: &Robot) -> Option<String> {
    let known = |joint: &UrdfJoint| {
        use UrdfJointKind::{Continuous, Fixed, Prismatic, Revolute, Spherical};
        matches!(joint.kind, Fixed | Revolute | Continuous | Prismatic | Spherical)
    };
    if !robot.joints.iter().all(known) || !robot.loops.is_empty() {
        return None;
    }
    let root = robot.links.iter().position(|link| robot.joints.iter().all(|joint| joint.child != link.name))?;
    let mut text =
        format!("<mujoco model=\"{}\"><compiler angle=\"radian\" autolimits=\"true\"/>\n<worldbody>\n", robot.name);
    write_body(robot, root, None, &mut text);
    text += "</worldbody>\n<equality>\n";
    for joint in &robot.joints {
        if let Some(mimic) = &joint.mimic {
            let coefficients = listed(&[mimic.offset, mimic.multiplier, 0.0, 0.0, 0.0]);
            let (name, leader) = (&joint.name, &mimic.joint);
            writeln!(text, "<joint joint1=\"{name}\" joint2=\"{leader}\" polycoef=\"{coefficients}\"/>").expect("text");
        }
    }
    Some(text + "</equality></mujoco>\n")
}

/// Whether a robot moves as its MJCF does; `None` if it has none.
fn moves_alike(urdf: &Path, folder: &Path) -> Option<()> {
    let name = stem(urdf);
    let robot = robot_without_meshes(&std::fs::read_to_string(urdf).ok()?, urdf).ok()?;
    // A model of MuJoCo without joints moves nothing.
    if robot.joints.is_empty() {
        return None;
    }
    let other = folder.join(format!("{name}.xml"));
    std::fs::write(&other, as_mjcf(&robot)?).expect("a model");
    let one = Model::loader().without(catena::prelude::Left::Contact).load(urdf).ok()?;
    let other = Model::load(&other).unwrap_or_else(|error| panic!("{name}: {error}"));
    let [a, b] = [&one, &other].map(|model| &model.description().mechanism);
    assert_eq!(one.joint_names(), other.joint_names(), "{name}");
    for (a, b) in a.bodies.iter().zip(&b.bodies) {
        let size = a.inertia.amax().max(1e-300);
        assert!((a.mass - b.mass).abs() <= 1e-12 * a.mass, "{name}: {} has {} and {} kg", a.name, a.mass, b.mass);
        // Principal moments in any order: both rotate the same numbers in another way.
        let sorted = |body: &catena::mechanism::description::mechanism::Body| {
            let mut moments: [f64; 3] = body.inertia.into();
            moments.sort_by(f64::total_cmp);
            moments
        };
        let apart = sorted(a).iter().zip(sorted(b)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart <= 1e-12 * size, "{name}: {}: {:?} and {:?}", a.name, a.inertia, b.inertia);
    }
    assert_eq!(a.nonsmooth.limits.len(), b.nonsmooth.limits.len(), "{name}");
    // The files list joints in orders of their own.
    let [of_a, of_b] = [a, b].map(|mechanism| {
        let mut limits: Vec<_> = mechanism.nonsmooth.limits.iter().collect();
        limits.sort_by_key(|limit| limit.coordinate.freedom);
        limits
    });
    for (a, b) in of_a.into_iter().zip(of_b) {
        assert_eq!(a.coordinate, b.coordinate, "{name}");
        assert!((a.lower - b.lower).abs() < 1e-12 && (a.upper - b.upper).abs() < 1e-12, "{name}: {a:?} {b:?}");
    }
    let ends = [&one, &other].map(|model| {
        let mut simulation = Simulation::new(model).tolerance(1e-8).without_estimate();
        simulation = simulation.duration(0.3);
        simulation.run().unwrap_or_else(|error| panic!("{name}: {error}"));
        simulation.finish().expect("a report")
    });
    for (joint, a) in &ends[0].joints {
        let (_, b) = ends[1].joints.iter().find(|(name, _)| name == joint).expect("the same joint");
        let numbers = |of: &catena::report::Numbers| match of {
            catena::report::Numbers::One(number) => vec![*number],
            catena::report::Numbers::Many(numbers) => numbers.clone(),
        };
        let apart =
            numbers(&a.position).iter().zip(numbers(&b.position)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // The tolerance; the roundings of both leave far less.
        assert!(apart < 1e-8, "{name}: {joint} is {apart:.1e} off");
    }
    Some(())
}

#[test]
fn robots_of_this_repository_move_alike_as_urdf_and_as_mjcf() {
    let folder = scratch("pairs");
    let robots = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots");
    let all: Vec<PathBuf> =
        ["", "parts", "classics/parts"].iter().flat_map(|part| urdf_files(&robots.join(part))).collect();
    let alike: Vec<&str> =
        all.iter().filter(|urdf| moves_alike(urdf, &folder).is_some()).map(|urdf| stem(urdf)).collect();
    println!("{} of {} move alike: {}", alike.len(), all.len(), alike.join(", "));
    // All but those with planar and floating joints, and single bodies without a joint.
    assert!(alike.len() >= 40, "{alike:?}");
}

/// The files with an ending in the folders that a variable names, and below them; empty, with the reason printed, without it.
fn files_of(variable: &str, ending: &str) -> Vec<PathBuf> {
    let Some(folders) = std::env::var_os(variable) else {
        println!("skipped: {variable} names no folders with models of public packages");
        return Vec::new();
    };
    let mut open: Vec<PathBuf> = std::env::split_paths(&folders).collect();
    let mut files = Vec::new();
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(&folder).into_iter().flatten().flatten() {
            let path = entry.path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|extension| extension == ending) {
                files.push(path);
            }
        }
    }
    files.sort();
    files
}

#[test]
fn robots_of_public_packages_move_alike_as_urdf_and_as_mjcf() {
    let all = files_of("CATENA_ROBOTS", "urdf");
    if all.is_empty() {
        return;
    }
    let folder = scratch("public");
    let alike: Vec<&str> =
        all.iter().filter(|urdf| moves_alike(urdf, &folder).is_some()).map(|urdf| stem(urdf)).collect();
    println!("{} of {} move alike: {}", alike.len(), all.len(), alike.join(", "));
    assert!(alike.len() >= 10);
}

#[test]
fn models_of_public_packages_are_read_or_refused_with_one_line() {
    let all = files_of("CATENA_MJCF", "xml");
    if all.is_empty() {
        return;
    }
    let mut read = 0;
    for file in &all {
        match Model::load(file) {
            Ok(_) => read += 1,
            Err(error) => {
                let error = error.to_string();
                println!("{error}");
                assert_eq!(error.lines().count(), 1, "{error}");
            }
        }
    }
    println!("{read} of {} models read", all.len());
    assert!(read >= 30, "{read}");
}
