//! A body that a scene file describes by its shape: a robot of one link that floats.
//!
//! ```text
//!     sphere     V = 4/3 π r³          I = 2/5 m r²
//!     box        V = a b c             Ixx = m (b² + c²)/12, and so on
//!     cylinder   V = π r² l            Izz = m r²/2        Ixx = m (3 r² + l²)/12
//!     ellipsoid  V = 4/3 π a b c       Ixx = m (b² + c²)/5, and so on
//!     capsule    V = π r² (l + 4/3 r)  Izz = mc r²/2 + ms 2/5 r²
//!                                      Ixx = mc (3 r² + l²)/12 + ms (2/5 r² + l²/4 + 3/8 l r)
//! ```
//!
//! with the volume V (m³), the mass m = ρ V (kg) of a density ρ (kg/m³), the inertia I about the centre (kg m²), radius r, length l and edges or semi-axes
//! a, b, c (m). The length of a capsule is the length of its cylinder; mc is the mass of the cylinder and ms the mass of both half spheres.

use crate::scene::robot::{Geometry, Surface};
use nalgebra::Vector3;
use std::f64::consts::PI;

/// A `[[body]]`: uniform matter in a shape.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneBody {
    /// Its shape, about the origin of its frame; no mesh.
    pub shape: Geometry,
    /// How heavy it is.
    pub weight: Weight,
    /// Red, green, blue, opacity in 0..1.
    pub color: Option<[f64; 4]>,
    /// How it touches.
    pub surface: Surface,
}

/// How heavy a body is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Weight {
    /// Its density [kg/m³].
    Density(f64),
    /// Its mass (kg).
    Mass(f64),
}

impl SceneBody {
    /// Volume (m³).
    pub fn volume(&self) -> f64 {
        match self.shape {
            Geometry::Sphere { radius } => 4.0 / 3.0 * PI * radius.powi(3),
            Geometry::Box { size } => size.x * size.y * size.z,
            Geometry::Cylinder { radius, length } => PI * radius * radius * length,
            Geometry::Capsule { radius, length } => PI * radius * radius * (length + 4.0 / 3.0 * radius),
            Geometry::Ellipsoid { radii } => 4.0 / 3.0 * PI * radii.product(),
            Geometry::Mesh(_) => 0.0,
        }
    }

    /// Mass (kg).
    pub fn mass(&self) -> f64 {
        match self.weight {
            Weight::Density(density) => density * self.volume(),
            Weight::Mass(mass) => mass,
        }
    }

    /// Moments of inertia about the axes of its frame [kg m²].
    pub fn moments(&self) -> Vector3<f64> {
        let mass = self.mass();
        let round = |across: f64, along: f64| Vector3::new(across, across, along);
        match self.shape {
            Geometry::Sphere { radius } => Vector3::repeat(0.4 * mass * radius * radius),
            Geometry::Box { size } => {
                let squares = size.component_mul(&size);
                let [x, y, z] = [squares.x, squares.y, squares.z];
                mass / 12.0 * Vector3::new(y + z, z + x, x + y)
            }
            Geometry::Ellipsoid { radii } => {
                let squares = radii.component_mul(&radii);
                let [x, y, z] = [squares.x, squares.y, squares.z];
                mass / 5.0 * Vector3::new(y + z, z + x, x + y)
            }
            Geometry::Cylinder { radius, length } => {
                let (square, long) = (radius * radius, length * length);
                round(mass * (3.0 * square + long) / 12.0, 0.5 * mass * square)
            }
            Geometry::Capsule { radius, length } => {
                let (square, long) = (radius * radius, length * length);
                let of_cylinder = mass * length / (length + 4.0 / 3.0 * radius);
                let of_ends = mass - of_cylinder;
                let across = of_cylinder * (3.0 * square + long) / 12.0
                    + of_ends * (0.4 * square + 0.25 * long + 0.375 * length * radius);
                round(across, 0.5 * of_cylinder * square + 0.4 * of_ends * square)
            }
            Geometry::Mesh(_) => Vector3::zeros(),
        }
    }
}
