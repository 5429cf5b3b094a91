//! Collision shapes: as files write them, and as the set of points that they are.

use crate::draw::Draw;
use nalgebra::Vector3;

/// A shape in its own frame (m).
#[derive(Clone, Debug)]
pub enum Shape {
    /// All points with z ≤ 0.
    HalfSpace,
    Sphere {
        radius: f64,
    },
    /// Edges along x, y, z.
    Box {
        size: Vector3<f64>,
    },
    /// Along z.
    Cylinder {
        radius: f64,
        length: f64,
    },
    /// Along z, `length` without its round ends.
    Capsule {
        radius: f64,
        length: f64,
    },
    /// A convex polytope, written as a mesh of this name.
    Polytope {
        name: String,
        corners: Vec<Vector3<f64>>,
        faces: Vec<[usize; 3]>,
    },
    /// A surface of triangles over the plane: solid below, down to `bottom`. Written as an open mesh of this name, with the fronts of its triangles
    /// up or down: a mesh is touched on both sides.
    Hills {
        name: String,
        corners: Vec<Vector3<f64>>,
        faces: Vec<[usize; 3]>,
        bottom: f64,
    },
}

impl Shape {
    /// A shape of a link, some `size` (m) large. `name` is the name of its mesh, if it has one.
    pub fn of_link(draw: &mut Draw, name: &str, size: f64) -> Self {
        let mut edge = |low: f64| draw.range(low, 1.0) * size;
        let (a, b, c) = (edge(0.3), edge(0.3), edge(0.3));
        match draw.index(5) {
            0 => Shape::Sphere { radius: 0.5 * a },
            1 => Shape::Box { size: Vector3::new(a, b, c) },
            2 => Shape::Cylinder { radius: 0.5 * a, length: b },
            3 => Shape::Capsule { radius: 0.3 * a, length: b },
            _ => Shape::octahedron(name, 0.6 * Vector3::new(a, b, c)),
        }
    }

    /// A shape of an obstacle, some `size` (m) large and as thin as some centimetres.
    pub fn of_obstacle(draw: &mut Draw, name: &str, size: f64) -> Self {
        let thin = draw.log(0.02, 0.5);
        match draw.index(8) {
            0 => Shape::HalfSpace,
            1 => Shape::Sphere { radius: 0.4 * size },
            2 => Shape::Box { size: Vector3::new(size, size, thin) },
            3 => Shape::Cylinder { radius: 0.5 * size, length: thin },
            4 => Shape::Capsule { radius: 0.15 * size, length: size },
            5 => Shape::octahedron(name, 0.5 * Vector3::new(size, size, 0.5 * size)),
            6 => Shape::block(name, Vector3::new(size, size, thin)),
            _ => Shape::hills(draw, name, size),
        }
    }

    /// Six corners on the axes, at these distances from the middle.
    pub fn octahedron(name: &str, half: Vector3<f64>) -> Self {
        let corners = (0..3).flat_map(|axis| [1.0, -1.0].map(|sign| Vector3::ith(axis, sign * half[axis]))).collect();
        let faces = vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
        Shape::Polytope { name: format!("{name}.obj"), corners, faces }
    }

    /// A box as twelve triangles.
    pub fn block(name: &str, size: Vector3<f64>) -> Self {
        let corner = |k: usize| Vector3::from_fn(|axis, _| size[axis] * if k >> axis & 1 == 1 { 0.5 } else { -0.5 });
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let faces = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
        Shape::Polytope { name: format!("{name}.obj"), corners: (0..8).map(corner).collect(), faces }
    }

    /// Hills on a square of this edge.
    fn hills(draw: &mut Draw, name: &str, size: f64) -> Self {
        let count = 4;
        let place = |k: usize| size * (k as f64 / (count - 1) as f64 - 0.5);
        let mut corners = Vec::new();
        for row in 0..count {
            for column in 0..count {
                corners.push(Vector3::new(place(column), place(row), draw.range(-0.06, 0.06) * size));
            }
        }
        let mut faces = Vec::new();
        for row in 0..count - 1 {
            for column in 0..count - 1 {
                let a = row * count + column;
                faces.extend([[a, a + 1, a + count + 1], [a, a + count + 1, a + count]]);
            }
        }
        // Decided without a draw, so that the scenes of all seeds stay what they were.
        if corners[0].z.to_bits() % 2 == 1 {
            faces.iter_mut().for_each(|face| face.swap(1, 2));
        }
        Shape::Hills { name: format!("{name}.obj"), corners, faces, bottom: -0.5 * size }
    }

    /// Its geometry in a URDF.
    pub fn urdf(&self) -> String {
        match self {
            Shape::Sphere { radius } => format!("<sphere radius=\"{radius}\"/>"),
            Shape::Box { size } => format!("<box size=\"{} {} {}\"/>", size.x, size.y, size.z),
            Shape::Cylinder { radius, length } => format!("<cylinder radius=\"{radius}\" length=\"{length}\"/>"),
            Shape::Capsule { radius, length } => format!("<capsule radius=\"{radius}\" length=\"{length}\"/>"),
            Shape::Polytope { name, .. } | Shape::Hills { name, .. } => format!("<mesh filename=\"{name}\"/>"),
            Shape::HalfSpace => unreachable!("no link is a half space"),
        }
    }

    /// Its `shape` in a scene file.
    pub fn toml(&self) -> String {
        match self {
            Shape::HalfSpace => "{ type = \"half_space\" }".to_string(),
            Shape::Sphere { radius } => format!("{{ type = \"sphere\", radius = {radius:?} }}"),
            Shape::Box { size } => format!("{{ type = \"box\", size = [{:?}, {:?}, {:?}] }}", size.x, size.y, size.z),
            Shape::Cylinder { radius, length } => {
                format!("{{ type = \"cylinder\", radius = {radius:?}, length = {length:?} }}")
            }
            Shape::Capsule { radius, length } => {
                format!("{{ type = \"capsule\", radius = {radius:?}, length = {length:?} }}")
            }
            Shape::Polytope { name, .. } | Shape::Hills { name, .. } => {
                format!("{{ type = \"mesh\", file = {name:?} }}")
            }
        }
    }

    /// The mesh file that it needs: name and text.
    pub fn file(&self) -> Option<(String, String)> {
        let (Shape::Polytope { name, corners, faces } | Shape::Hills { name, corners, faces, .. }) = self else {
            return None;
        };
        let corners = corners.iter().map(|corner| format!("v {:?} {:?} {:?}\n", corner.x, corner.y, corner.z));
        let faces = faces.iter().map(|[a, b, c]| format!("f {} {} {}\n", a + 1, b + 1, c + 1));
        Some((name.clone(), corners.chain(faces).collect()))
    }

    /// The height of its highest point above its origin (m).
    pub fn top(&self) -> f64 {
        match self {
            Shape::HalfSpace => 0.0,
            Shape::Sphere { radius } => *radius,
            Shape::Box { size } => 0.5 * size.z,
            Shape::Cylinder { length, .. } => 0.5 * length,
            Shape::Capsule { radius, length } => 0.5 * length + radius,
            Shape::Polytope { corners, .. } | Shape::Hills { corners, .. } => {
                corners.iter().map(|corner| corner.z).fold(f64::NEG_INFINITY, f64::max)
            }
        }
    }

    /// The largest distance of its points from the origin (m).
    pub fn extent(&self) -> f64 {
        match self {
            Shape::HalfSpace => f64::INFINITY,
            Shape::Sphere { radius } => *radius,
            Shape::Box { size } => 0.5 * size.norm(),
            Shape::Cylinder { radius, length } => radius.hypot(0.5 * length),
            Shape::Capsule { radius, length } => radius + 0.5 * length,
            Shape::Polytope { corners, .. } => corners.iter().map(|corner| corner.norm()).fold(0.0, f64::max),
            Shape::Hills { corners, bottom, .. } => {
                corners.iter().map(|corner| corner.norm()).fold(0.0, f64::max) - bottom
            }
        }
    }
}
