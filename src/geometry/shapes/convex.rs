//! A convex shape prepared for queries: a core and a radius about it, in the frame of its body.
//!
//! ```text
//!     shape = core ⊕ ball(r)          h(n) = h_core(n) + r |n|
//! ```
//!
//! | shape | core | r |
//! |---|---|---|
//! | sphere, capsule | point, segment | its radius |
//! | box, hull, triangle | polytope | 0 |
//! | cylinder | cylinder: centre c, unit axis k, radius ρ, half length h | 0 |
//! | ellipsoid | ellipsoid: centre c, axes e_i, semi-axes r_i; h(n) = n · c + √Σ r_i² (n · e_i)² | 0 |

use crate::shapes::error::GeometryError;
use crate::shapes::hull::{check_points, check_surface, convex_hull};
use crate::shapes::polytope::{Face, Polytope};
use crate::shapes::prepared::Prepared;
use catena_mechanism::description::contact::Shape;
use catena_mechanism::description::joint::Pose;
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;

/// The prepared hulls.
static HULLS: Prepared<Vec<Vector3<f64>>, Convex> = Prepared::new();

/// Farthest point of a shape from its origin (m): beyond it coordinates are rounded to more than 1e-10 m, and gaps count as closed up to more than
/// 1e-5 m.
const FARTHEST: f64 = 1e6;
/// Polytopes with more vertices are dense.
const DENSE: usize = 24;

/// A cylinder in the frame of its body.
#[derive(Clone, Debug, PartialEq)]
pub struct Cylinder {
    /// Its middle (m).
    pub centre: Vector3<f64>,
    /// Unit vector along its axis.
    pub axis: Vector3<f64>,
    /// ρ (m).
    pub radius: f64,
    /// Half its length (m).
    pub half: f64,
}

/// An ellipsoid in the frame of its body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipsoid {
    /// Its middle (m).
    pub centre: Vector3<f64>,
    /// Its axes, as columns.
    pub axes: Matrix3<f64>,
    /// Its semi-axes (m).
    pub radii: Vector3<f64>,
}

impl Ellipsoid {
    /// The point that is farthest along a direction (m), `c + Σ r_i² (n · e_i) e_i / √Σ r_i² (n · e_i)²`.
    pub fn support_point(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        let scaled = self.axes.tr_mul(direction).component_mul(&self.radii);
        match scaled.try_normalize(0.0) {
            Some(unit) => self.centre + self.axes * unit.component_mul(&self.radii),
            None => self.centre,
        }
    }

    /// `max n · p` (m).
    pub fn support(&self, normal: &Vector3<f64>) -> f64 {
        normal.dot(&self.centre) + self.axes.tr_mul(normal).component_mul(&self.radii).norm()
    }
}

/// The core of a convex shape: the shape without its radius.
#[derive(Clone, Debug, PartialEq)]
pub enum Core {
    /// Flat faces and straight edges, or less.
    Polytope(Polytope),
    /// Two discs and a side.
    Cylinder(Cylinder),
    /// A smooth surface.
    Ellipsoid(Ellipsoid),
}

/// A convex shape.
#[derive(Clone, Debug, PartialEq)]
pub struct Convex {
    /// Its core.
    pub core: Core,
    /// r (m).
    pub radius: f64,
    /// A point inside (m).
    pub centre: Vector3<f64>,
    /// Distance of its farthest point from the centre (m).
    pub size: f64,
    /// Radius of a ball about the centre that fits in the core (m): all pairs of a shape ask for it.
    inside: f64,
}

impl Cylinder {
    /// Centre of the rim at the end along the axis (`end` = 1) or against it (0) (m).
    pub fn rim_centre(&self, end: usize) -> Vector3<f64> {
        self.centre + self.axis * if end == 1 { self.half } else { -self.half }
    }

    /// Normal of a cap, out of the cylinder.
    pub fn cap_normal(&self, end: usize) -> Vector3<f64> {
        if end == 1 { self.axis } else { -self.axis }
    }

    /// The point that is farthest along a direction (m).
    pub fn support_point(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        let along = self.axis.dot(direction);
        let across = direction - self.axis * along;
        let norm = across.norm();
        let rim = if norm > 0.0 { across * (self.radius / norm) } else { Vector3::zeros() };
        self.rim_centre(usize::from(along >= 0.0)) + rim
    }

    /// `max n · p` (m).
    pub fn support(&self, normal: &Vector3<f64>) -> f64 {
        // The cross product, because 1 − (k · n)² loses half of the digits near the axis.
        let across = self.axis.cross(normal).norm();
        normal.dot(&self.centre) + self.half * self.axis.dot(normal).abs() + self.radius * across
    }
}

impl Core {
    /// `max n · p` over the core (m).
    pub fn support(&self, normal: &Vector3<f64>) -> f64 {
        match self {
            Core::Polytope(polytope) => polytope.support(normal),
            Core::Cylinder(cylinder) => cylinder.support(normal),
            Core::Ellipsoid(ellipsoid) => ellipsoid.support(normal),
        }
    }

    /// A point of the core that is farthest along a direction (m).
    pub fn support_point(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        match self {
            Core::Polytope(polytope) => polytope.vertices[polytope.support_vertex(direction)],
            Core::Cylinder(cylinder) => cylinder.support_point(direction),
            Core::Ellipsoid(ellipsoid) => ellipsoid.support_point(direction),
        }
    }
}

impl Convex {
    /// A polytope with a radius (m) about it.
    pub fn round(polytope: Polytope, radius: f64) -> Self {
        let count = polytope.vertices.len().max(1) as f64;
        let centre = polytope.vertices.iter().sum::<Vector3<f64>>() / count;
        let farthest = polytope.vertices.iter().map(|vertex| (vertex - centre).norm()).fold(0.0, f64::max);
        let depth = |face: &Face| face.normal.dot(&(polytope.vertices[face.corners[0]] - centre));
        let least = polytope.faces.iter().map(depth).fold(f64::INFINITY, f64::min);
        let inside = if least.is_finite() { least.max(0.0) } else { 0.0 };
        Convex { core: Core::Polytope(polytope), radius, centre, size: farthest + radius, inside }
    }

    /// Distance of its farthest point from the origin of the body (m), or a little more.
    pub fn reach(&self) -> f64 {
        match &self.core {
            Core::Polytope(polytope) => {
                polytope.vertices.iter().map(|vertex| vertex.norm()).fold(0.0, f64::max) + self.radius
            }
            Core::Cylinder(_) | Core::Ellipsoid(_) => self.centre.norm() + self.size,
        }
    }

    /// Whether its core is a point.
    pub fn is_ball(&self) -> bool {
        matches!(&self.core, Core::Polytope(polytope) if polytope.vertices.len() == 1)
    }

    /// Unit vector along the axis of a cylinder or capsule.
    pub fn axis(&self) -> Option<Vector3<f64>> {
        match &self.core {
            Core::Cylinder(cylinder) => Some(cylinder.axis),
            Core::Polytope(Polytope { vertices, .. }) if vertices.len() == 2 => {
                Some((vertices[1] - vertices[0]).normalize())
            }
            Core::Polytope(_) | Core::Ellipsoid(_) => None,
        }
    }

    /// Whether it has many vertices.
    pub fn is_dense(&self) -> bool {
        matches!(&self.core, Core::Polytope(polytope) if polytope.vertices.len() > DENSE)
    }

    /// Diameter of a ball that fits in about the centre (m): in every direction the shape is at least as wide.
    pub fn breadth(&self) -> f64 {
        2.0 * (self.inside + self.radius)
    }

    /// The same as [`Convex::new`], and the same hull for the same points and pose.
    pub fn shared(shape: &Shape, pose: &Pose) -> Result<Option<Arc<Self>>, GeometryError> {
        match shape {
            Shape::Hull(points) => HULLS.of(points, pose, || Convex::of_hull(points, pose)).map(Some),
            _ => Ok(Convex::new(shape, pose)?.map(Arc::new)),
        }
    }

    /// A convex shape with its pose in the body; `None` for half spaces, meshes and ropes.
    pub fn new(shape: &Shape, pose: &Pose) -> Result<Option<Self>, GeometryError> {
        let kind = kind(shape);
        check_pose(kind, pose)?;
        let positive = |what: &'static str, value: f64| match value > 0.0 && value < 1e150 {
            true => Ok(value),
            false => Err(GeometryError::Size { shape: kind, what, value }),
        };
        let origin = pose.translation.vector;
        let axis = pose.rotation * Vector3::z();
        Ok(Some(match shape {
            Shape::HalfSpace | Shape::Mesh(_) => return Ok(None),
            Shape::Hollow { radius } => {
                positive("length", *radius)?;
                return Ok(None);
            }
            Shape::Point => Convex::round(Polytope::point(origin), 0.0),
            Shape::Sphere { radius } => Convex::round(Polytope::point(origin), positive("radius", *radius)?),
            Shape::Capsule { radius, half } => {
                let (radius, half) = (positive("radius", *radius)?, positive("half length", *half)?);
                Convex::round(Polytope::segment([origin - axis * half, origin + axis * half]), radius)
            }
            Shape::Cylinder { radius, half } => {
                let (radius, half) = (positive("radius", *radius)?, positive("half length", *half)?);
                let cylinder = Cylinder { centre: origin, axis, radius, half };
                let (size, inside) = (radius.hypot(half), radius.min(half));
                Convex { core: Core::Cylinder(cylinder), radius: 0.0, centre: origin, size, inside }
            }
            Shape::Box { half } => {
                let half =
                    Vector3::new(positive("x size", half.x)?, positive("y size", half.y)?, positive("z size", half.z)?);
                Convex::round(cuboid(&half, pose), 0.0)
            }
            Shape::Ellipsoid { radii } => {
                let radii = Vector3::new(
                    positive("first radius", radii.x)?,
                    positive("second radius", radii.y)?,
                    positive("third radius", radii.z)?,
                );
                let ellipsoid = Ellipsoid { centre: origin, axes: *pose.rotation.matrix(), radii };
                let (size, inside) = (radii.max(), radii.min());
                Convex { core: Core::Ellipsoid(ellipsoid), radius: 0.0, centre: origin, size, inside }
            }
            Shape::Hull(points) => Convex::of_hull(points, pose)?,
        }))
    }

    /// The hull of points (m) with their pose in the body.
    fn of_hull(points: &[Vector3<f64>], pose: &Pose) -> Result<Self, GeometryError> {
        check_pose("convex hull", pose)?;
        check_points(points)?;
        let placed: Vec<Vector3<f64>> =
            points.iter().map(|point| pose.rotation * point + pose.translation.vector).collect();
        Ok(Convex::round(convex_hull(&placed)?, 0.0))
    }
}

/// Whether the entries of a pose are numbers.
fn check_pose(kind: &'static str, pose: &Pose) -> Result<(), GeometryError> {
    let entries = pose.translation.vector.iter().chain(pose.rotation.matrix()).all(|entry| entry.is_finite());
    if entries { Ok(()) } else { Err(GeometryError::Pose { shape: kind }) }
}

/// Whether a shape can be used in a pose.
///
/// # Errors
/// [`GeometryError`] for sizes that are no lengths, for points that have no hull, for meshes of too many points or with coordinates that are not
/// finite, and for shapes that reach too far from their origin.
pub fn check_shape(shape: &Shape, pose: &Pose) -> Result<(), GeometryError> {
    let farthest = |points: &[Vector3<f64>]| points.iter().map(|point| point.norm()).fold(0.0, f64::max);
    let reach = match shape {
        Shape::Mesh(surface) => {
            check_surface(surface)?;
            farthest(&surface.vertices)
        }
        // The hull of this pose is kept for the pairs of the shape.
        Shape::Hull(points) => Convex::shared(shape, pose).map(|_| farthest(points))?,
        _ => Convex::new(shape, &Pose::identity())?.map_or(0.0, |convex| convex.reach()),
    };
    if reach <= FARTHEST { Ok(()) } else { Err(GeometryError::TooFar { shape: kind(shape), reach, limit: FARTHEST }) }
}

/// A shape's kind in words.
pub fn kind(shape: &Shape) -> &'static str {
    match shape {
        Shape::HalfSpace => "half space",
        Shape::Sphere { .. } => "sphere",
        Shape::Capsule { .. } => "capsule",
        Shape::Cylinder { .. } => "cylinder",
        Shape::Box { .. } => "box",
        Shape::Ellipsoid { .. } => "ellipsoid",
        Shape::Hollow { .. } => "rope",
        Shape::Point => "point",
        Shape::Hull(_) => "convex hull",
        Shape::Mesh(_) => "triangle mesh",
    }
}

/// A box; vertex number 4 x + 2 y + z with 0 or 1 for each axis.
fn cuboid(half: &Vector3<f64>, pose: &Pose) -> Polytope {
    let sign = |bit: usize| if bit == 1 { 1.0 } else { -1.0 };
    let corner = |number: usize| Vector3::new(sign(number >> 2), sign(number >> 1 & 1), sign(number & 1));
    let vertices = (0..8).map(|number| pose.rotation * corner(number).component_mul(half) + pose.translation.vector);
    let face = |axis: usize, side: usize| {
        let (next, last) = ([2, 1, 0][(axis + 1) % 3], [2, 1, 0][(axis + 2) % 3]);
        let own = side << [2, 1, 0][axis];
        let mut corners = vec![own, own | 1 << next, own | 1 << next | 1 << last, own | 1 << last];
        if side == 0 {
            corners.reverse();
        }
        let normal = pose.rotation.matrix().column(axis) * sign(side);
        Face { normal, corners }
    };
    let faces = (0..6).map(|number| face(number / 2, number % 2)).collect();
    Polytope::of_faces(vertices.collect(), faces)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hull_is_made_once_for_the_check_of_its_points_and_for_its_pairs() {
        let corner =
            |number: u32| Vector3::new(f64::from(number & 1), f64::from(number >> 1 & 1), f64::from(number >> 2));
        let points = Arc::new((0..8).map(corner).collect::<Vec<_>>());
        let pose = Pose::new(Vector3::new(0.1, 0.2, 0.3), Vector3::new(0.3, -0.2, 0.1));
        let shape = Shape::Hull(points.clone());
        check_shape(&shape, &pose).expect("a cube");
        Convex::shared(&shape, &pose).expect("a hull");
        assert_eq!(HULLS.poses(&points), 1);
    }
}
