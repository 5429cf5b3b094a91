//! Robots of random scenes, as URDF.

use crate::draw::Draw;
use crate::shapes::Shape;
use nalgebra::Vector3;

/// A robot as it is written.
pub struct Robot {
    pub name: String,
    parts: Vec<String>,
    /// The links with a shape: link and shape, which is about the origin of the link.
    pub shapes: Vec<(String, Shape)>,
    /// Joints with limits: lower and upper.
    pub limits: Vec<(String, f64, f64)>,
}

/// A joint of a robot, as it is written.
pub struct Joint<'j> {
    pub name: &'j str,
    pub kind: &'j str,
    pub parent: &'j str,
    pub child: &'j str,
    pub origin: Vector3<f64>,
    pub rpy: Vector3<f64>,
    pub axis: Vector3<f64>,
    pub limit: Option<(f64, f64)>,
    pub damping: f64,
    pub friction: f64,
    /// Leader, multiplier and offset.
    pub mimic: Option<(&'j str, f64, f64)>,
}

impl<'j> Joint<'j> {
    /// A joint about z without limits, friction and damping.
    pub fn new(name: &'j str, kind: &'j str, parent: &'j str, child: &'j str) -> Self {
        let (origin, rpy, axis) = (Vector3::zeros(), Vector3::zeros(), Vector3::z());
        Joint { name, kind, parent, child, origin, rpy, axis, limit: None, damping: 0.0, friction: 0.0, mimic: None }
    }
}

fn three(v: &Vector3<f64>) -> String {
    format!("{:?} {:?} {:?}", v.x, v.y, v.z)
}

impl Robot {
    pub fn new(name: &str) -> Self {
        Robot { name: name.to_string(), parts: Vec::new(), shapes: Vec::new(), limits: Vec::new() }
    }

    /// A link without mass.
    pub fn base(&mut self, name: &str) {
        self.parts.push(format!("<link name=\"{name}\"/>"));
    }

    /// A link with principal moments of inertia (kg m²) about its centre of mass.
    pub fn link(&mut self, name: &str, mass: f64, inertia: Vector3<f64>, centre: Vector3<f64>, shape: Option<Shape>) {
        self.turned_link(name, (mass, inertia, centre), shape, &Vector3::zeros());
    }

    /// The same with a shape that is turned by these roll, pitch and yaw (rad). Overlaps are judged without the turn.
    fn turned_link(
        &mut self,
        name: &str,
        (mass, inertia, centre): (f64, Vector3<f64>, Vector3<f64>),
        shape: Option<Shape>,
        turned: &Vector3<f64>,
    ) {
        let origin =
            if *turned == Vector3::zeros() { String::new() } else { format!("<origin rpy=\"{}\"/>", three(turned)) };
        let collision = shape.as_ref().map_or(String::new(), |shape| {
            format!("<collision>{origin}<geometry>{}</geometry></collision>", shape.urdf())
        });
        self.parts.push(format!(
            "<link name=\"{name}\"><inertial><origin xyz=\"{}\"/><mass value=\"{mass:?}\"/><inertia ixx=\"{:?}\" iyy=\"{:?}\" izz=\"{:?}\" \
             ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>{collision}</link>",
            three(&centre),
            inertia.x,
            inertia.y,
            inertia.z
        ));
        self.shapes.extend(shape.map(|shape| (name.to_string(), shape)));
    }

    /// A link that is a solid shape about its origin.
    pub fn solid(&mut self, name: &str, mass: f64, shape: Shape) {
        self.link(name, mass, inertia(mass, &shape), Vector3::zeros(), Some(shape));
    }

    /// The same with a shape that is turned by a little (rad).
    pub fn turned_solid(&mut self, name: &str, mass: f64, shape: Shape, turned: &Vector3<f64>) {
        self.turned_link(name, (mass, inertia(mass, &shape), Vector3::zeros()), Some(shape), turned);
    }

    /// A link of some size (m) with a random mass, centre and inertia, with or without a random shape.
    pub fn random_link(&mut self, draw: &mut Draw, name: &str, size: f64, has_shape: bool) {
        let mass = draw.log(0.2, 5.0);
        let mesh = format!("{}_{name}", self.name);
        let shape = Shape::of_link(draw, &mesh, size);
        let inertia = inertia(mass, &shape);
        if has_shape {
            self.solid(name, mass, shape);
        } else {
            let centre = draw.vector(0.3 * size);
            self.link(name, mass, inertia, centre, None);
        }
    }

    pub fn joint(&mut self, joint: &Joint) {
        let Joint { name, kind, parent, child, origin, rpy, axis, .. } = joint;
        let (lower, upper) = joint.limit.unwrap_or((-1e3, 1e3));
        let limit = match *kind {
            "revolute" | "prismatic" => {
                format!("<limit lower=\"{lower:?}\" upper=\"{upper:?}\" effort=\"1000\" velocity=\"1000\"/>")
            }
            _ => String::new(),
        };
        let mimic = joint.mimic.map_or(String::new(), |(leader, multiplier, offset)| {
            format!("<mimic joint=\"{leader}\" multiplier=\"{multiplier:?}\" offset=\"{offset:?}\"/>")
        });
        let axis = match *kind {
            "fixed" | "spherical" => String::new(),
            _ => format!("<axis xyz=\"{}\"/>", three(axis)),
        };
        let dynamics = match (joint.damping, joint.friction) {
            (0.0, 0.0) => String::new(),
            (damping, friction) => format!("<dynamics damping=\"{damping:?}\" friction=\"{friction:?}\"/>"),
        };
        self.parts.push(format!(
            "<joint name=\"{name}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"{child}\"/><origin xyz=\"{}\" rpy=\"{}\"/>\
             {axis}{limit}{dynamics}{mimic}</joint>",
            three(origin),
            three(rpy)
        ));
        if !limit.is_empty() {
            self.limits.push((name.to_string(), lower, upper));
        }
    }

    /// The text of its URDF.
    pub fn text(&self) -> String {
        format!("<robot name=\"{}\">\n{}\n</robot>\n", self.name, self.parts.join("\n"))
    }
}

/// Principal moments of inertia (kg m²) of a solid shape. A polytope has the moments of a box of the same extent.
pub fn inertia(mass: f64, shape: &Shape) -> Vector3<f64> {
    let cuboid = |size: &Vector3<f64>| {
        let square = size.component_mul(size) * (mass / 12.0);
        Vector3::new(square.y + square.z, square.x + square.z, square.x + square.y)
    };
    match shape {
        Shape::HalfSpace => Vector3::repeat(mass),
        Shape::Sphere { radius } => Vector3::repeat(0.4 * mass * radius * radius),
        Shape::Box { size } => cuboid(size),
        Shape::Cylinder { radius, length } | Shape::Capsule { radius, length } => {
            let across = mass * (0.25 * radius * radius + length * length / 12.0);
            Vector3::new(across, across, 0.5 * mass * radius * radius)
        }
        Shape::Polytope { corners, .. } | Shape::Hills { corners, .. } => {
            let reach = Vector3::from_fn(|axis, _| corners.iter().map(|corner| corner[axis].abs()).fold(0.0, f64::max));
            cuboid(&(1.2 * reach))
        }
    }
}
