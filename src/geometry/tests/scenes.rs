//! Shapes and poses for tests.

use crate::PairGeometry;
use catena_mechanism::description::contact::{Collider, Shape, Surface};
use catena_mechanism::description::joint::Pose;
use nalgebra::{Quaternion, Translation3, UnitQuaternion, Vector3};
use std::sync::Arc;

/// Reproducible numbers (xorshift64*).
pub struct Numbers(u64);

impl Numbers {
    pub fn new(seed: u64) -> Self {
        Numbers(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    /// Between −1 and 1.
    pub fn next(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    pub fn vector(&mut self) -> Vector3<f64> {
        Vector3::new(self.next(), self.next(), self.next())
    }

    /// A pose whose place is within a length of the origin in each direction.
    pub fn pose(&mut self, within: f64) -> Pose {
        let turn = loop {
            let quaternion = Quaternion::new(self.next(), self.next(), self.next(), self.next());
            if quaternion.norm() > 0.1 && quaternion.norm() < 1.0 {
                break UnitQuaternion::from_quaternion(quaternion);
            }
        };
        Pose::from_parts(Translation3::from(self.vector() * within), turn.to_rotation_matrix())
    }
}

/// A shape by its kind, about 0.1 to 0.3 times a size, somewhere in its body.
pub fn collider(kind: &str, size: f64, numbers: &mut Numbers) -> Collider {
    let mut length = || (0.2 + 0.1 * numbers.next()) * size;
    let shape = match kind {
        "half space" => Shape::HalfSpace,
        "sphere" => Shape::Sphere { radius: length() },
        "capsule" => Shape::Capsule { radius: length(), half: length() },
        "cylinder" => Shape::Cylinder { radius: length(), half: length() },
        "ellipsoid" => Shape::Ellipsoid { radii: Vector3::new(length(), length(), length()) },
        "box" => Shape::Box { half: Vector3::new(length(), length(), length()) },
        _ => Shape::Hull(Arc::new((0..40).map(|_| numbers.vector().normalize() * 0.2 * size).collect())),
    };
    Collider::still(kind, None, numbers.pose(0.1 * size), shape)
}

/// A collider at the origin of its body.
pub fn at_origin(shape: Shape) -> Collider {
    Collider::still("", None, Pose::identity(), shape)
}

/// A pair at the origins of their bodies.
pub fn pair(a: Shape, b: Shape) -> PairGeometry {
    PairGeometry::new(&at_origin(a), &at_origin(b)).expect("shapes that are possible")
}

/// A box.
pub fn cuboid(x: f64, y: f64, z: f64) -> Shape {
    Shape::Box { half: Vector3::new(x, y, z) }
}

/// A pose without rotation.
pub fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::translation(x, y, z)
}

/// A floor of squares of two triangles each about the origin, at these heights over x and y.
pub fn floor(count: usize, square: f64, height: impl Fn(f64, f64) -> f64) -> Shape {
    let half = count as f64 * square / 2.0;
    let place = |i: usize| i as f64 * square - half;
    let row = count + 1;
    let vertices = (0..row * row).map(|number| {
        let (x, y) = (place(number % row), place(number / row));
        Vector3::new(x, y, height(x, y))
    });
    let square = |number: usize| {
        let corner = (number / count * row + number % count) as u32;
        let above = corner + row as u32;
        [[corner, corner + 1, above + 1], [corner, above + 1, above]]
    };
    let triangles = (0..count * count).flat_map(square).collect();
    Shape::Mesh(Arc::new(Surface { vertices: vertices.collect(), triangles }))
}

/// `max n · p` (m) over a shape with a pose in the world, from its description alone.
pub fn support(shape: &Shape, pose: &Pose, normal: &Vector3<f64>) -> f64 {
    let n = pose.rotation.inverse() * normal;
    let flat = n.x.hypot(n.y);
    let own = match shape {
        Shape::Sphere { radius } => *radius,
        Shape::Capsule { radius, half } => radius + half * n.z.abs(),
        Shape::Cylinder { radius, half } => radius * flat + half * n.z.abs(),
        Shape::Box { half } => half.dot(&n.abs()),
        Shape::Ellipsoid { radii } => radii.component_mul(&n).norm(),
        Shape::Hull(points) => points.iter().map(|point| point.dot(&n)).fold(f64::NEG_INFINITY, f64::max),
        Shape::Point => 0.0,
        Shape::HalfSpace | Shape::Mesh(_) | Shape::Hollow { .. } => f64::INFINITY,
    };
    own + normal.dot(&pose.translation.vector)
}
