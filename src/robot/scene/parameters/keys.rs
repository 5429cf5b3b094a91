//! The key paths of all numbers of a scene.

use crate::mechanism::description::contact::Shape;
use crate::mechanism::description::formula::Formula;
use crate::mechanism::description::nonsmooth::MotorLaw;
use crate::scene::body::{SceneBody, Weight};
use crate::scene::coupling::{JointReference, SpringPlace};
use crate::scene::description::{Scene, SceneRobot};
use crate::scene::parameters::place::{BodyNumber, MotorNumber, Place, ShapeNumber, SpringNumber};
use crate::scene::parameters::{Parameter, Range};
use crate::scene::robot::{Geometry, LoopType, UrdfJointKind};

const AXES: [&str; 3] = ["x", "y", "z"];
const ANGLES: [&str; 3] = ["roll", "pitch", "yaw"];
const MOMENTS: [(&str, usize, usize); 6] =
    [("ixx", 0, 0), ("ixy", 0, 1), ("ixz", 0, 2), ("iyy", 1, 1), ("iyz", 1, 2), ("izz", 2, 2)];

/// Keys of the lengths of rolling and of spinning friction.
pub(crate) const MOMENT_LENGTHS: [&str; 2] = ["rolling_friction", "spinning_friction"];

/// All parameters of a scene, without what the files say.
pub(crate) fn all(scene: &Scene) -> Vec<Parameter> {
    let mut keys = Keys { all: Vec::new() };
    keys.vector("scene", "gravity", Range::Finite, Place::Gravity);
    for (index, robot) in scene.robots.iter().enumerate() {
        // A winch follows from its rope.
        if scene.ropes.iter().any(|rope| rope.winch.as_ref().is_some_and(|winch| winch.robot == index)) {
            continue;
        }
        keys.start(index, robot, scene);
        if let Some(body) = &robot.body {
            keys.body(index, robot, body);
            continue;
        }
        keys.links(index, robot);
        keys.joints(index, robot);
        keys.urdf_loops(index, robot);
    }
    keys.drives(scene);
    keys.motions(scene);
    keys.couplings(scene);
    keys.relations(scene);
    keys.loads(scene);
    keys.contact(scene);
    keys.put("simulation", "duration", Range::Positive, Place::Duration);
    if scene.simulation.fixed.is_some() {
        keys.put("simulation", "stages", Range::Stages, Place::Stages);
        keys.put("simulation", "step", Range::Positive, Place::Step);
    } else {
        keys.put("simulation", "tolerance", Range::Positive, Place::Tolerance);
    }
    keys.put("simulation", "rate", Range::Positive, Place::Rate);
    keys.all
}

pub(crate) struct Keys {
    all: Vec<Parameter>,
}

impl Keys {
    /// A number of the key path `head.rest`, of which `rest` is enough where it is the only one.
    pub(crate) fn put(&mut self, head: &str, rest: &str, range: Range, place: Place) {
        self.all.push(Parameter { key: format!("{head}.{rest}"), short: rest.to_string(), place, range, said: None });
    }

    pub(crate) fn vector(&mut self, head: &str, rest: &str, range: Range, place: impl Fn(usize) -> Place) {
        for (index, axis) in AXES.iter().enumerate() {
            self.put(head, &format!("{rest}.{axis}"), range, place(index));
        }
    }

    fn angles(&mut self, head: &str, rest: &str, place: impl Fn(usize) -> Place) {
        for (index, angle) in ANGLES.iter().enumerate() {
            self.put(head, &format!("{rest}.{angle}"), Range::Finite, place(index));
        }
    }

    /// The radius of a sphere; of a cylinder or capsule the length, too.
    fn round(&mut self, head: &str, rest: &str, long: bool, place: impl Fn(ShapeNumber) -> Place) {
        self.put(head, &format!("{rest}.radius"), Range::Positive, place(ShapeNumber::Radius));
        if long {
            self.put(head, &format!("{rest}.length"), Range::Positive, place(ShapeNumber::Length));
        }
    }

    /// The semi-axes of an ellipsoid.
    fn radii(&mut self, head: &str, rest: &str, place: impl Fn(ShapeNumber) -> Place) {
        self.vector(head, &format!("{rest}.radii"), Range::Positive, |axis| place(ShapeNumber::Radii(axis)));
    }

    /// The edges of a box.
    fn sizes(&mut self, head: &str, rest: &str, place: impl Fn(ShapeNumber) -> Place) {
        self.vector(head, &format!("{rest}.size"), Range::Positive, |axis| place(ShapeNumber::Size(axis)));
    }

    /// The scale of a mesh.
    fn scales(&mut self, head: &str, rest: &str, place: impl Fn(ShapeNumber) -> Place) {
        self.vector(head, &format!("{rest}.scale"), Range::Finite, |axis| place(ShapeNumber::Scale(axis)));
    }

    /// Where a robot starts.
    fn start(&mut self, robot: usize, of: &SceneRobot, scene: &Scene) {
        // The short key path of a body has its name, the short key path of a robot has not.
        let (head, own) = match of.body {
            Some(_) => ("body".to_string(), format!("{}.", of.name)),
            None => (format!("robot.{}", of.name), String::new()),
        };
        let called = |what: &str| format!("{own}{what}");
        let place = |axis| Place::BasePosition { robot, axis };
        self.vector(&head, &called("pose.position"), Range::Finite, place);
        self.angles(&head, &called("pose.rpy"), |angle| Place::BaseTurn { robot, angle });
        if of.floating {
            let place = |number| Place::BaseVelocity { robot, number };
            self.vector(&head, &called("velocity.linear"), Range::Finite, place);
            self.vector(&head, &called("velocity.angular"), Range::Finite, |axis| place(3 + axis));
        }
        // A joint that is moved in time starts where it is then.
        let is_moved = |name: &str| scene.motions.iter().any(|one| one.joint.robot == robot && one.joint.joint == name);
        for one in of.robot.joints.iter().filter(|one| !is_moved(&one.name)) {
            let joint = || one.name.clone();
            let (positions, velocities) = coordinates(one.kind);
            for (number, name) in positions.iter().enumerate() {
                let place = Place::Position { robot, joint: joint(), number, count: positions.len() };
                self.put(&head, &with("positions", &one.name, name), Range::Finite, place);
            }
            for (number, name) in velocities.iter().enumerate() {
                let place = Place::Velocity { robot, joint: joint(), number, count: velocities.len() };
                self.put(&head, &with("velocities", &one.name, name), Range::Finite, place);
            }
        }
    }

    /// What a body is made from.
    fn body(&mut self, robot: usize, of: &SceneRobot, body: &SceneBody) {
        let called = |what: &str| format!("{}.{what}", of.name);
        let (head, shape) = ("body", &called("shape"));
        let place = |what| Place::Body { robot, what };
        self.put(head, &called("friction"), Range::Friction, Place::LinkFriction { robot, link: 0 });
        self.put(head, &called("restitution"), Range::Fraction, Place::LinkRestitution { robot, link: 0 });
        self.moments(head, &of.name, |of| Place::LinkMoment { robot, link: 0, of });
        let place_of_velocity = |axis| Place::LinkSurface { robot, link: 0, axis };
        self.vector(head, &called("surface_velocity"), Range::Finite, place_of_velocity);
        let weight = if let Weight::Density(_) = body.weight { "density" } else { "mass" };
        self.put(head, &called(weight), Range::Positive, place(BodyNumber::Weight));
        let of_shape = |what| place(BodyNumber::Shape(what));
        match body.shape {
            Geometry::Sphere { .. } => self.round(head, shape, false, of_shape),
            Geometry::Cylinder { .. } | Geometry::Capsule { .. } => self.round(head, shape, true, of_shape),
            Geometry::Box { .. } => self.sizes(head, shape, of_shape),
            Geometry::Ellipsoid { .. } => self.radii(head, shape, of_shape),
            Geometry::Mesh(_) => {}
        }
    }

    fn links(&mut self, robot: usize, of: &SceneRobot) {
        for (link, one) in of.robot.links.iter().enumerate() {
            let name = called(of, &one.name);
            self.put("link", &format!("{name}.mass"), Range::NotNegative, Place::Mass { robot, link });
            self.surface_of_link(robot, link, &name, one);
            let place = |axis| Place::CenterOfMass { robot, link, axis };
            self.vector("link", &format!("{name}.center_of_mass"), Range::Finite, place);
            for (moment, row, column) in MOMENTS {
                let place = Place::Inertia { robot, link, row, column };
                self.put("link", &format!("{name}.inertia.{moment}"), Range::Finite, place);
            }
            self.angles("link", &format!("{name}.inertia"), |angle| Place::InertiaTurn { robot, link, angle });
            for (shape, given) in one.collisions.iter().enumerate() {
                let head = format!("{name}.collision.{}", shape + 1);
                let place = |what| Place::Collision { robot, link, shape, what };
                match given.geometry {
                    Geometry::Sphere { .. } => self.round("link", &head, false, place),
                    Geometry::Cylinder { .. } | Geometry::Capsule { .. } => self.round("link", &head, true, place),
                    Geometry::Box { .. } => self.sizes("link", &head, place),
                    Geometry::Ellipsoid { .. } => self.radii("link", &head, place),
                    Geometry::Mesh(_) => self.scales("link", &head, place),
                }
                self.surface_of_shape(&head, &given.surface, place);
                let origin = format!("{head}.origin");
                self.vector("link", &origin, Range::Finite, |axis| place(ShapeNumber::Position(axis)));
                self.angles("link", &origin, |angle| place(ShapeNumber::Turn(angle)));
            }
        }
    }

    fn joints(&mut self, robot: usize, of: &SceneRobot) {
        for (joint, one) in of.robot.joints.iter().enumerate() {
            let name = called(of, &one.name);
            self.vector("joint", &format!("{name}.origin"), Range::Finite, |axis| Place::Origin { robot, joint, axis });
            self.angles("joint", &format!("{name}.origin"), |angle| Place::OriginTurn { robot, joint, angle });
            if one.kind.has_axis() {
                self.vector("joint", &format!("{name}.axis"), Range::Finite, |axis| Place::Axis { robot, joint, axis });
            }
            if one.mimic.is_some() {
                let (multiplier, offset) =
                    (Place::MimicMultiplier { robot, joint }, Place::MimicOffset { robot, joint });
                self.put("joint", &format!("{name}.mimic.multiplier"), Range::Finite, multiplier);
                self.put("joint", &format!("{name}.mimic.offset"), Range::Finite, offset);
            }
            if coordinates(one.kind).0.len() != 1 {
                continue;
            }
            self.put("joint", &format!("{name}.limit.effort"), Range::Bound, Place::EffortBound { robot, joint });
            self.put("joint", &format!("{name}.limit.velocity"), Range::Bound, Place::SpeedBound { robot, joint });
            let reference = || JointReference { robot, joint: one.name.clone() };
            self.put("joint", &format!("{name}.limit.lower"), Range::Limit, Place::LowerLimit(reference()));
            self.put("joint", &format!("{name}.limit.upper"), Range::Limit, Place::UpperLimit(reference()));
            self.put("joint", &format!("{name}.restitution"), Range::Fraction, Place::Restitution(reference()));
            self.put("joint", &format!("{name}.friction"), Range::NotNegative, Place::Friction(reference()));
            self.put("joint", &format!("{name}.damping"), Range::NotNegative, Place::Damping(reference()));
            self.put("joint", &format!("{name}.armature"), Range::NotNegative, Place::Armature(reference()));
        }
    }

    /// The loops of a robot's own file.
    fn urdf_loops(&mut self, robot: usize, of_robot: &SceneRobot) {
        for (of, one) in of_robot.robot.loops.iter().enumerate() {
            let name = called(of_robot, &one.name);
            if one.kind.needs_axes() {
                let place = |axis| Place::UrdfLoopAxis { robot, of, axis };
                self.vector("loop", &format!("{name}.axis"), Range::Finite, place);
            }
            for (end, b) in [("a", false), ("b", true)] {
                let place = |axis| Place::UrdfLoopEnd { robot, of, b, axis };
                self.vector("loop", &format!("{name}.{end}.position"), Range::Finite, place);
                let place = |angle| Place::UrdfLoopTurn { robot, of, b, angle };
                self.angles("loop", &format!("{name}.{end}.rpy"), place);
            }
        }
    }

    fn drives(&mut self, scene: &Scene) {
        for (motor, one) in scene.motors.iter().enumerate() {
            let mut put = |name: &str, range, what| {
                self.put("motor", &format!("{}.{name}", one.on), range, Place::Motor { motor, what })
            };
            if one.frequency.is_none() && matches!(one.law, MotorLaw::Position { .. }) {
                put("kp", Range::NotNegative, MotorNumber::Kp);
            }
            if one.frequency.is_none() && matches!(one.law, MotorLaw::Position { .. } | MotorLaw::Velocity { .. }) {
                put("kd", Range::NotNegative, MotorNumber::Kd);
            }
            if one.table.is_none() && !one.at_start && one.target.as_formula().is_none() {
                put("target", Range::Finite, MotorNumber::Target);
            }
            put("max_effort", Range::Bound, MotorNumber::MaxEffort);
            put("period", Range::NotNegative, MotorNumber::Period);
            put("gravity_compensation", Range::NotNegative, MotorNumber::GravityCompensation);
            let parameters = one.target.as_formula().map_or(&[][..], Formula::parameters);
            for (index, (parameter, _)) in parameters.iter().enumerate() {
                let key = format!("{}.target.{parameter}", one.on);
                self.put("motor", &key, Range::Finite, Place::TargetParameter { motor, index });
            }
            for entry in 0..one.table.as_ref().map_or(0, |table| table.points.len()) {
                let called = |what: &str| format!("{}.target.{}.{what}", one.on, entry + 1);
                self.put("motor", &called("time"), Range::Finite, Place::TargetTime { motor, entry });
                self.put("motor", &called("value"), Range::Finite, Place::TargetValue { motor, entry });
            }
        }
    }

    /// Joints that are moved in time.
    fn motions(&mut self, scene: &Scene) {
        for (motion, one) in scene.motions.iter().enumerate() {
            let rope = scene.ropes.iter().find(|rope| rope.winch.as_ref() == Some(&one.joint));
            let (group, of) = match rope {
                Some(rope) => ("rope", format!("{}.length", rope.name)),
                None => ("motion", format!("{}.position", one.on)),
            };
            let mut put = |what: &str, place| self.put(group, &format!("{of}{what}"), Range::Finite, place);
            let entries = one.table.as_ref().map_or(0, |table| table.points.len());
            for entry in 0..entries {
                put(&format!(".{}.time", entry + 1), Place::MotionTime { motion, entry });
                put(&format!(".{}.value", entry + 1), Place::MotionValue { motion, entry });
            }
            match one.position.as_formula() {
                Some(formula) => {
                    for (index, (parameter, _)) in formula.parameters().iter().enumerate() {
                        put(&format!(".{parameter}"), Place::MotionParameter { motion, index });
                    }
                }
                None if entries == 0 => put("", Place::MotionPosition(motion)),
                None => {}
            }
        }
    }

    fn couplings(&mut self, scene: &Scene) {
        for (spring, one) in scene.springs.iter().enumerate() {
            let mut put = |name: &str, range, what| {
                self.put("spring", &format!("{}.{name}", one.name), range, Place::Spring { spring, what })
            };
            put("stiffness", Range::NotNegative, SpringNumber::Stiffness);
            put("damping", Range::NotNegative, SpringNumber::Damping);
            if let SpringPlace::Joint { .. } = one.place {
                put("rest", Range::Finite, SpringNumber::Rest);
                continue;
            }
            put("rest_length", Range::NotNegative, SpringNumber::Rest);
            for (end, b) in [("a", false), ("b", true)] {
                let rest = format!("{}.{end}.position", one.name);
                self.vector("spring", &rest, Range::Finite, |axis| Place::SpringEnd { spring, b, axis });
            }
        }
        for (rope, one) in scene.ropes.iter().enumerate() {
            if one.winch.is_none() {
                self.put("rope", &format!("{}.length", one.name), Range::Positive, Place::RopeLength(rope));
            }
            self.put("rope", &format!("{}.restitution", one.name), Range::Fraction, Place::RopeRestitution(rope));
            if one.points.len() > 2 {
                self.put("rope", &format!("{}.stop", one.name), Range::NotNegative, Place::RopeStop(rope));
            }
            // A winch has a point before the first.
            let before = usize::from(one.winch.is_some());
            for end in before..one.points.len() {
                let rest = format!("{}.points.{}.position", one.name, end + 1 - before);
                self.vector("rope", &rest, Range::Finite, |axis| Place::RopeEnd { rope, end, axis });
            }
        }
        for (of, one) in scene.loops.iter().enumerate() {
            if one.kind == LoopType::Distance {
                self.put("loop", &format!("{}.length", one.name), Range::Positive, Place::LoopLength(of));
            }
            for (end, b) in [("a", false), ("b", true)] {
                let rest = format!("{}.{end}.position", one.name);
                self.vector("loop", &rest, Range::Finite, |axis| Place::LoopEnd { of, b, axis });
                if (if b { &one.b } else { &one.a }).axis.is_some() {
                    let rest = format!("{}.{end}.axis", one.name);
                    self.vector("loop", &rest, Range::Finite, |axis| Place::LoopAxis { of, b, axis });
                }
            }
        }
    }

    fn contact(&mut self, scene: &Scene) {
        for (obstacle, one) in scene.contact.obstacles.iter().enumerate() {
            let called = |what: &str| format!("{}.{what}", one.name);
            self.put("obstacle", &called("friction"), Range::Friction, Place::ObstacleFriction(obstacle));
            self.put("obstacle", &called("restitution"), Range::Fraction, Place::ObstacleRestitution(obstacle));
            self.moments("obstacle", &one.name, |of| Place::ObstacleMoment { obstacle, of });
            let velocity = |axis| Place::ObstacleSurface { obstacle, axis };
            self.vector("obstacle", &called("surface_velocity"), Range::Finite, velocity);
            let place = |axis| Place::ObstaclePosition { obstacle, axis };
            self.vector("obstacle", &called("pose.position"), Range::Finite, place);
            self.angles("obstacle", &called("pose.rpy"), |angle| Place::ObstacleTurn { obstacle, angle });
            let (head, place) = (called("shape"), |what| Place::ObstacleShape { obstacle, what });
            match &one.shape {
                Shape::Sphere { .. } => self.round("obstacle", &head, false, place),
                Shape::Capsule { .. } | Shape::Cylinder { .. } => self.round("obstacle", &head, true, place),
                Shape::Box { .. } => self.sizes("obstacle", &head, place),
                Shape::Ellipsoid { .. } => self.radii("obstacle", &head, place),
                Shape::Mesh(_) => self.scales("obstacle", &head, place),
                Shape::HalfSpace => {
                    let place = |axis| Place::ObstacleNormal { obstacle, axis };
                    self.vector("obstacle", &called("shape.normal"), Range::Finite, place);
                }
                _ => {}
            }
        }
        self.put("contact", "friction", Range::Friction, Place::ContactFriction);
        self.put("contact", "restitution", Range::Fraction, Place::ContactRestitution);
        for (of, key) in MOMENT_LENGTHS.into_iter().enumerate() {
            self.put("contact", key, Range::NotNegative, Place::ContactMoment(of));
        }
        self.put("contact", "self_contact", Range::Flag, Place::SelfContact);
        for rule in 0..scene.contact.rules.len() {
            let called = |what: &str| format!("pair.{}.{what}", rule + 1);
            self.put("contact", &called("friction"), Range::Friction, Place::PairFriction(rule));
            self.put("contact", &called("restitution"), Range::Fraction, Place::PairRestitution(rule));
            self.moments("contact", &format!("pair.{}", rule + 1), |of| Place::PairMoment { rule, of });
        }
    }
}

/// The name of a link or joint as scene files write it.
fn called(robot: &SceneRobot, name: &str) -> String {
    format!("{}{name}", robot.prefix)
}

/// `positions.JOINT`, and of joints of several freedoms `positions.JOINT.NUMBER`.
fn with(what: &str, joint: &str, number: &str) -> String {
    if number.is_empty() { format!("{what}.{joint}") } else { format!("{what}.{joint}.{number}") }
}

/// The names of a joint's positions and velocities as users give them; empty for the only one.
fn coordinates(kind: UrdfJointKind) -> (&'static [&'static str], &'static [&'static str]) {
    match kind {
        UrdfJointKind::Revolute | UrdfJointKind::Continuous | UrdfJointKind::Prismatic => (&[""], &[""]),
        UrdfJointKind::Fixed => (&[], &[]),
        UrdfJointKind::Planar => (&["x", "y", "angle"], &["vx", "vy", "rate"]),
        UrdfJointKind::Spherical => (&ANGLES, &["wx", "wy", "wz"]),
        UrdfJointKind::Floating => (&["x", "y", "z", "roll", "pitch", "yaw"], &["vx", "vy", "vz", "wx", "wy", "wz"]),
    }
}
