//! A collider that is prepared for questions: one shape, shared by all pairs that it belongs to.

use crate::distances::half_space::HalfSpace;
use crate::distances::hollow::Hollow;
use crate::distances::mesh::Mesh;
use crate::shapes::convex::{Convex, kind};
use crate::shapes::error::GeometryError;
use crate::shapes::extents::Lengths;
use crate::shapes::polytope::Polytope;
use crate::shapes::prepared::Prepared;
use catena_mechanism::description::contact::{Collider, Shape, Surface};
use nalgebra::Vector3;
use std::sync::Arc;

/// The prepared surfaces of triangles.
static MESHES: Prepared<Surface, Mesh> = Prepared::new();

/// A prepared collider.
#[derive(Clone, Debug)]
pub struct PreparedShape {
    pub(crate) side: First,
    /// Whether it belongs to a body.
    pub(crate) moves: bool,
    is_ellipsoid: bool,
    kind: &'static str,
}

/// The collider in whose frame the questions about a pair are answered.
#[derive(Clone, Debug)]
pub(crate) enum First {
    HalfSpace(HalfSpace),
    Hollow(Hollow),
    Mesh(Arc<Mesh>),
    Convex(Arc<Convex>),
}

impl PreparedShape {
    /// Prepares a collider; its shape and its pose in the body count, and for tolerances whether it is an obstacle.
    pub fn new(collider: &Collider) -> Result<Self, GeometryError> {
        let side = match Convex::shared(&collider.shape, &collider.pose)? {
            Some(convex) => First::Convex(convex),
            None => match &collider.shape {
                Shape::Mesh(surface) => {
                    First::Mesh(MESHES.of(surface, &collider.pose, || Mesh::new(surface, &collider.pose))?)
                }
                Shape::Hollow { radius } => {
                    First::Hollow(Hollow { centre: collider.pose.translation.vector, length: *radius })
                }
                _ => First::HalfSpace(HalfSpace {
                    point: collider.pose.translation.vector,
                    normal: collider.pose.rotation * Vector3::z(),
                }),
            },
        };
        let is_ellipsoid = matches!(collider.shape, Shape::Ellipsoid { .. });
        Ok(PreparedShape { side, moves: collider.body.is_some(), is_ellipsoid, kind: kind(&collider.shape) })
    }

    /// In the place of a collider whose shape is impossible: the origin of its body.
    pub fn stand_in(collider: &Collider) -> Self {
        let moves = collider.body.is_some();
        PreparedShape { side: First::Convex(PreparedShape::point()), moves, is_ellipsoid: false, kind: "point" }
    }

    pub(crate) fn point() -> Arc<Convex> {
        Arc::new(Convex::round(Polytope::point(Vector3::zeros()), 0.0))
    }

    /// The shape, if it is convex and bounded.
    pub(crate) fn convex(&self) -> Option<&Arc<Convex>> {
        match &self.side {
            First::Convex(convex) => Some(convex),
            First::HalfSpace(_) | First::Hollow(_) | First::Mesh(_) => None,
        }
    }

    /// Distance of its farthest point from the origin of its body (m), if it is convex and bounded.
    pub fn reach(&self) -> Option<f64> {
        self.convex().map(|convex| convex.reach())
    }

    /// Whether it may touch every other shape that says the same of itself.
    pub fn is_plain(&self) -> bool {
        self.convex().is_some() && !self.is_ellipsoid
    }

    /// Whether questions about it and another shape have answers.
    ///
    /// # Errors
    /// [`GeometryError`] for two obstacles, and for ellipsoids with anything but half spaces.
    pub fn may_touch(&self, other: &PreparedShape) -> Result<(), GeometryError> {
        for [own, other] in [[self, other], [other, self]] {
            if own.is_ellipsoid && !matches!(other.side, First::HalfSpace(_)) {
                return Err(GeometryError::Ellipsoid { other: other.kind });
            }
        }
        let [first, second] = if self.convex().is_some() { [other, self] } else { [self, other] };
        let Some(second) = second.convex() else {
            return Err(GeometryError::Obstacles { a: self.kind, b: other.kind });
        };
        if matches!(first.side, First::Hollow(_)) && second.size > 0.0 {
            return Err(GeometryError::Obstacles { a: self.kind, b: other.kind });
        }
        Ok(())
    }
}

impl First {
    /// Distance of its farthest point from the origin of the body (m).
    pub fn reach(&self) -> f64 {
        match self {
            First::HalfSpace(_) => f64::INFINITY,
            First::Hollow(rope) => rope.centre.norm(),
            First::Mesh(mesh) => mesh.reach(),
            First::Convex(convex) => convex.reach(),
        }
    }

    /// Its lengths as an obstacle.
    pub fn lengths(&self) -> Lengths {
        match self {
            First::HalfSpace(half_space) => Lengths::of_plane(&half_space.point),
            First::Hollow(rope) => {
                Lengths { place: rope.centre.norm() + rope.length, whole: rope.length, part: rope.length }
            }
            First::Mesh(mesh) => mesh.lengths(),
            First::Convex(convex) => Lengths::of_convex(convex),
        }
    }
}
