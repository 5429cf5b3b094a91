//! An MJCF file that was read, written as a scene file and its URDFs. Numbers have all their digits.

use crate::scene::mjcf_reading::activations::Driving;
use crate::scene::mjcf_reading::orientation::roll_pitch_yaw;
use crate::scene::mjcf_reading::parts::{
    Between, Closing, End, Form, Geom, Joint, Link, Motor, Relation, Rope, Spring, Tree,
};
use crate::scene::mjcf_reading::reader::Reader;
use crate::scene::robot::{Geometry, Pose, UrdfJointKind};
use crate::scene::urdf_reading::element::escaped;
use nalgebra::Vector3;
use std::fmt::Write;

/// A name or text of TOML in quotes.
pub(crate) fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for character in text.chars() {
        match character {
            '"' | '\\' => out.extend(['\\', character]),
            other if other.is_control() => out += &format!("\\u{:04X}", u32::from(other)),
            other => out.push(other),
        }
    }
    out + "\""
}

/// Numbers with spaces between, as in URDF.
fn spaced<'n>(numbers: impl IntoIterator<Item = &'n f64>) -> String {
    numbers.into_iter().map(f64::to_string).collect::<Vec<_>>().join(" ")
}

/// Numbers as a list of TOML, which has no number like `1e300` without a sign or point, but reads those that Rust writes.
fn list<'n>(numbers: impl IntoIterator<Item = &'n f64>) -> String {
    format!("[{}]", numbers.into_iter().map(number).collect::<Vec<_>>().join(", "))
}

/// A number of TOML.
fn number(number: &f64) -> String {
    format!("{number:?}")
}

pub(crate) fn pose(pose: &Pose) -> String {
    let rpy = roll_pitch_yaw(&pose.rotation);
    format!("{{ position = {}, rpy = {} }}", list(&pose.translation.vector), list(&rpy))
}

impl Reader<'_> {
    /// The URDF of a tree.
    pub fn urdf(&self, tree: &Tree) -> String {
        let mut text = format!("<robot name=\"{}\">\n", escaped(&tree.name));
        tree.links.iter().for_each(|link| write_link(link, &mut text));
        tree.joints
            .iter()
            .enumerate()
            .for_each(|(index, (between, joint))| write_joint(index, between, joint, &mut text));
        text + "</robot>\n"
    }

    /// The scene file; the URDF of tree i is called as `files` says. Warns of contacts that no scene file can say.
    pub fn toml(&mut self, files: &[String]) -> String {
        let mut text =
            format!("# Made by catena from {}\n[scene]\nname = {}\n", self.source_name(), quoted(&self.name));
        // Writing into a String cannot fail.
        let _ = writeln!(text, "gravity = {}", list(&self.gravity));
        for (index, (tree, file)) in self.trees.iter().zip(files).enumerate() {
            let base = if tree.floats { "floating" } else { "fixed" };
            let _ = writeln!(
                text,
                "\n[[robot]]\nname = {}\nurdf = {}\nbase = \"{base}\"",
                quoted(&self.robot_names[index]),
                quoted(file)
            );
            let _ = writeln!(text, "pose = {}", pose(&tree.pose));
            if let Some(velocity) = &tree.velocity {
                let (linear, angular) = velocity.split_at(3);
                let _ = writeln!(text, "velocity = {{ linear = {}, angular = {} }}", list(linear), list(angular));
            }
            for (what, all) in [("positions", &self.positions), ("velocities", &self.velocities)] {
                let own = all.iter().filter(|(tree, ..)| *tree == index);
                let own = own.map(|(_, joint, numbers)| format!("{} = {}", quoted(joint), list(numbers)));
                let own: Vec<String> = own.collect();
                if !own.is_empty() {
                    let _ = writeln!(text, "{what} = {{ {} }}", own.join(", "));
                }
            }
        }
        self.write_joints(&mut text);
        self.write_couplings(&mut text);
        let warnings = self.write_contact(&mut text);
        self.warnings.extend(warnings);
        text
    }

    /// Loops, and what became of tendons.
    fn write_couplings(&self, text: &mut String) {
        let point = |(body, point): &End| {
            let link = body.as_ref().map_or_else(|| "world".to_string(), |body| self.link_name(body));
            format!("{{ link = {}, position = {} }}", quoted(&link), list(point))
        };
        let named =
            |name: &Option<String>| name.as_ref().map_or(String::new(), |name| format!("name = {}\n", quoted(name)));
        for Closing { name, kind, ends: [a, b] } in &self.closings {
            let (name, a, b) = (named(name), point(a), point(b));
            let _ = writeln!(text, "\n[[loop]]\n{name}type = \"{kind}\"\na = {a}\nb = {b}");
        }
        for Rope { name, points, length } in &self.ropes {
            let points: Vec<String> = points.iter().map(point).collect();
            let (name, points) = (named(name), points.join(", "));
            let _ = writeln!(text, "\n[[rope]]\n{name}points = [{points}]\nlength = {length:?}");
        }
        for Spring { ends: [a, b], stiffness, damping, rest } in &self.springs {
            let (a, b) = (point(a), point(b));
            let _ = writeln!(text, "\n[[spring]]\na = {a}\nb = {b}\nstiffness = {stiffness:?}\ndamping = {damping:?}");
            let _ = writeln!(text, "rest_length = {rest:?}");
        }
        for Relation { name, joints, offset } in &self.relations {
            let tree = |joint: &String| self.references.get(joint).map_or(0, |(tree, _)| *tree);
            let joints =
                joints.iter().map(|(joint, own)| format!("{} = {own:?}", quoted(&self.called(tree(joint), joint))));
            let joints = joints.collect::<Vec<_>>().join(", ");
            let _ = writeln!(text, "\n[[coupling]]\n{}joints = {{ {joints} }}\noffset = {offset:?}", named(name));
        }
    }

    /// Springs, locked joints and motors, damping of bases, and weights that are held.
    fn write_joints(&self, text: &mut String) {
        for (index, tree) in self.trees.iter().enumerate() {
            if let Some(base) = tree.links.iter().find(|link| link.name == tree.name).filter(|_| tree.damping != 0.0) {
                let (name, damping) = (quoted(&self.called(index, &base.name)), tree.damping);
                let _ = writeln!(text, "\n[[drag]]\nlink = {name}\nlinear = {damping:?}\nangular = {damping:?}");
            }
            for link in tree.links.iter().filter(|link| link.held != 0.0) {
                let Some(of) = &link.mass else { continue };
                let (name, at) = (quoted(&self.called(index, &link.name)), list(&of.frame.translation.vector));
                let force = list(&(-of.mass * link.held * self.gravity));
                let _ = writeln!(text, "\n[[load]]\nlink = {name}\nposition = {at}\nforce = {force}");
            }
            for joint in tree.joints.iter().filter_map(|(_, joint)| joint.as_ref()) {
                let name = quoted(&self.called(index, &joint.name));
                if let Some((stiffness, rest)) = joint.spring {
                    let _ = writeln!(
                        text,
                        "\n[[spring]]\nname = {name}\njoint = {name}\nstiffness = {stiffness:?}\nrest = {rest:?}"
                    );
                }
                let locked = self.locked.iter().find(|(locked, _)| *locked == joint.name).map(|(_, at)| (*at, *at));
                let held = locked.or(joint.limit.filter(|limit| *limit == (0.0, 0.0)));
                if let Some((lower, upper)) = held {
                    let _ = writeln!(text, "\n[[joint]]\nname = {name}\nlimit = [{lower:?}, {upper:?}]");
                }
            }
        }
        for (number, (_, motor)) in self.motors.iter().enumerate() {
            let Some((tree, _)) = self.references.get(&motor.joint) else { continue };
            let own = |(_, other): &&(usize, Motor)| other.joint == motor.joint;
            if self.motors[..number].iter().any(|other| own(&other)) {
                continue;
            }
            let all = self.motors.iter().filter(own).map(|(_, motor)| motor);
            let (kind, drive, Driving { target, load }) = Motor::law(all);
            let name = quoted(&self.called(*tree, &motor.joint));
            let _ = writeln!(text, "\n[[motor]]\njoint = {name}\nkind = \"{kind}\"\ntarget = {target}");
            if target.starts_with('[') {
                *text += "interpolation = \"linear\"\n";
            }
            if kind == "position" {
                let _ = writeln!(text, "kp = {:?}", drive.kp);
            }
            if kind != "effort" {
                let _ = writeln!(text, "kd = {:?}", drive.kd);
            }
            if let Some(bound) = motor.max_effort {
                let _ = writeln!(text, "max_effort = {bound:?}");
            }
            if let Some((effort, factor)) = load {
                let _ = writeln!(text, "\n[[load]]\njoint = {name}\neffort = {effort:?}\nfactor = {factor}");
                *text += "interpolation = \"linear\"\n";
            }
        }
    }
}

/// The shape of an obstacle.
pub(crate) fn shape_of(geom: &Geom) -> Option<String> {
    Some(match &geom.form {
        Form::Plane => "{ type = \"half_space\" }".to_string(),
        Form::Other => return None,
        Form::Field(file) => format!("{{ type = \"mesh\", file = {} }}", quoted(file)),
        Form::Solid(Geometry::Box { size }) => format!("{{ type = \"box\", size = {} }}", list(size)),
        Form::Solid(Geometry::Sphere { radius }) => format!("{{ type = \"sphere\", radius = {radius:?} }}"),
        Form::Solid(Geometry::Cylinder { radius, length }) => {
            format!("{{ type = \"cylinder\", radius = {radius:?}, length = {length:?} }}")
        }
        Form::Solid(Geometry::Capsule { radius, length }) => {
            format!("{{ type = \"capsule\", radius = {radius:?}, length = {length:?} }}")
        }
        Form::Solid(Geometry::Ellipsoid { radii }) => format!("{{ type = \"ellipsoid\", radii = {} }}", list(radii)),
        Form::Solid(Geometry::Mesh(mesh)) => {
            format!("{{ type = \"mesh\", file = {}, scale = {} }}", quoted(&mesh.path), list(&mesh.scale))
        }
    })
}

fn write_link(link: &Link, text: &mut String) {
    let _ = writeln!(text, "<link name=\"{}\">", escaped(&link.name));
    if let Some(mass) = &link.mass {
        let i = &mass.inertia;
        let _ = writeln!(text, "<inertial>{}<mass value=\"{}\"/>", origin(&mass.frame), mass.mass);
        let moments = [("ixx", i.m11), ("iyy", i.m22), ("izz", i.m33), ("ixy", i.m12), ("ixz", i.m13), ("iyz", i.m23)];
        let moments: Vec<String> = moments.iter().map(|(name, moment)| format!("{name}=\"{moment}\"")).collect();
        let _ = writeln!(text, "<inertia {}/></inertial>", moments.join(" "));
    }
    for geom in &link.geoms {
        let Form::Solid(form) = &geom.form else { continue };
        let form = match form {
            Geometry::Box { size } => format!("<box size=\"{}\"/>", spaced(size)),
            Geometry::Sphere { radius } => format!("<sphere radius=\"{radius}\"/>"),
            Geometry::Cylinder { radius, length } => format!("<cylinder radius=\"{radius}\" length=\"{length}\"/>"),
            Geometry::Capsule { radius, length } => format!("<capsule radius=\"{radius}\" length=\"{length}\"/>"),
            Geometry::Ellipsoid { radii } => format!("<ellipsoid radii=\"{}\"/>", spaced(radii)),
            Geometry::Mesh(mesh) => {
                format!("<mesh filename=\"{}\" scale=\"{}\"/>", escaped(&mesh.path), spaced(&mesh.scale))
            }
        };
        let placed = format!("{}<geometry>{form}</geometry>", origin(&geom.pose));
        if geom.is_shown {
            let color = geom
                .color
                .map_or(String::new(), |rgba| format!("<material><color rgba=\"{}\"/></material>", spaced(&rgba)));
            let _ = writeln!(text, "<visual>{placed}{color}</visual>");
        }
        if geom.touches {
            let _ = writeln!(text, "<collision>{placed}</collision>");
        }
    }
    *text += "</link>\n";
}

fn write_joint(index: usize, between: &Between, joint: &Option<Joint>, text: &mut String) {
    let Between { parent, child, origin: at } = between;
    let fixed = || format!("{child}_fixed{index}");
    let (name, kind) = match joint {
        None => (fixed(), UrdfJointKind::Fixed),
        Some(joint) if joint.kind == UrdfJointKind::Revolute && joint.limit.is_none() => {
            (joint.name.clone(), UrdfJointKind::Continuous)
        }
        Some(joint) => (joint.name.clone(), joint.kind),
    };
    let _ = writeln!(text, "<joint name=\"{}\" type=\"{}\">{}", escaped(&name), kind.name(), origin(at));
    let _ = writeln!(text, "<parent link=\"{}\"/><child link=\"{}\"/>", escaped(parent), escaped(child));
    if let Some(joint) = joint {
        if kind != UrdfJointKind::Spherical {
            let _ = writeln!(text, "<axis xyz=\"{}\"/>", spaced(&joint.axis));
        }
        if matches!(kind, UrdfJointKind::Revolute | UrdfJointKind::Prismatic) {
            let (lower, upper) = joint.limit.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
            let _ = writeln!(text, "<limit lower=\"{lower}\" upper=\"{upper}\" effort=\"inf\" velocity=\"inf\"/>");
        }
        if joint.damping != 0.0 || joint.friction != 0.0 || joint.armature != 0.0 {
            let Joint { damping, friction, armature, .. } = joint;
            let _ = write!(text, "<dynamics damping=\"{damping}\" friction=\"{friction}\"");
            if *armature != 0.0 {
                let _ = write!(text, " armature=\"{armature}\"");
            }
            *text += "/>\n";
        }
        if let Some((leader, multiplier, offset)) = &joint.mimic {
            let _ = writeln!(
                text,
                "<mimic joint=\"{}\" multiplier=\"{multiplier}\" offset=\"{offset}\"/>",
                escaped(leader)
            );
        }
    }
    *text += "</joint>\n";
}

fn origin(pose: &Pose) -> String {
    let rpy = roll_pitch_yaw(&pose.rotation);
    let xyz: &Vector3<f64> = &pose.translation.vector;
    format!("<origin xyz=\"{}\" rpy=\"{}\"/>", spaced(xyz), spaced(&rpy))
}
