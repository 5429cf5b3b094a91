//! The features of a convex core: their names, which stay the same over time, and their shapes.
//!
//! | name | of | it is |
//! |---|---|---|
//! | face, edge, vertex | polytope | plane, line, point |
//! | edge point | polytope | point: the middle of what of an edge lies on a cap, where that is short |
//! | cap, side, rim | cylinder | plane, line with a radius, circle |
//! | side | ellipsoid | the ellipsoid |

use crate::shapes::convex::{Core, Cylinder, Ellipsoid};
use crate::shapes::plane::across;
use crate::shapes::polytope::Polytope;
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::TAU;

/// Name of a feature of a shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum FeatureId {
    /// A face of a polytope, a triangle of a mesh, the plane of a half space.
    Face(u32),
    /// The end of a cylinder: 0 at −z, 1 at z.
    Cap(u32),
    /// An edge of a polytope or a mesh, the core of a capsule.
    Edge(u32),
    /// The side of a cylinder, the surface of an ellipsoid.
    Side,
    /// The edge of an end of a cylinder.
    Rim(u32),
    /// A point that stands for the rim of an end that lies flat, together with others.
    RimPoint {
        /// 0 at −z, 1 at z.
        end: u32,
        /// The bits of its angle in turns, from 0 to 1.
        turn: u64,
    },
    /// A point of an edge that stands for its part on a cap, if that is short.
    EdgePoint {
        /// The number of the edge.
        edge: u32,
        /// The bits of its place as a part of the way from the first to the second end.
        part: u64,
    },
    /// A vertex of a polytope or a mesh, the centre of a sphere, the end of a capsule's core.
    Vertex(u32),
}

/// The geometry of a feature, in the frame of the first body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Part {
    /// A point (m).
    Point(Vector3<f64>),
    /// All points nearer than a radius (m) to the line through two points (m).
    Line([Vector3<f64>; 2], f64),
    /// A plane through a point (m), with its unit normal out of the body.
    Plane(Vector3<f64>, Vector3<f64>),
    /// A circle about a centre (m) with a unit axis and a radius (m).
    Circle(Vector3<f64>, Vector3<f64>, f64),
    /// The surface of an ellipsoid.
    Ellipsoid(Ellipsoid),
    /// A sphere about a centre (m) with a radius (m), from inside.
    Hollow(Vector3<f64>, f64),
}

impl Part {
    /// Makes a line, or the axis of a circle, point the other way.
    pub fn reverse(&mut self) {
        match self {
            Part::Line(ends, _) => ends.reverse(),
            Part::Circle(_, axis, _) => *axis = -*axis,
            Part::Point(_) | Part::Plane(..) | Part::Ellipsoid(_) | Part::Hollow(..) => {}
        }
    }

    /// The same in another frame.
    pub fn moved(self, rotation: &Matrix3<f64>, translation: &Vector3<f64>) -> Self {
        let point = |point: Vector3<f64>| rotation * point + translation;
        match self {
            Part::Point(at) => Part::Point(point(at)),
            Part::Line(ends, radius) => Part::Line(ends.map(point), radius),
            Part::Plane(at, normal) => Part::Plane(point(at), rotation * normal),
            Part::Circle(centre, axis, radius) => Part::Circle(point(centre), rotation * axis, radius),
            Part::Hollow(centre, radius) => Part::Hollow(point(centre), radius),
            Part::Ellipsoid(Ellipsoid { centre, axes, radii }) => {
                Part::Ellipsoid(Ellipsoid { centre: point(centre), axes: rotation * axes, radii })
            }
        }
    }
}

/// A feature of a core, in the frame of its body.
pub fn part(core: &Core, feature: FeatureId) -> Part {
    match (core, feature) {
        (Core::Polytope(polytope), FeatureId::Face(number)) => {
            let face = &polytope.faces[number as usize];
            Part::Plane(polytope.vertices[face.corners[0]], face.normal)
        }
        (Core::Polytope(polytope), FeatureId::Edge(number)) => {
            Part::Line(polytope.edges[number as usize].ends.map(|end| polytope.vertices[end]), 0.0)
        }
        (Core::Polytope(polytope), FeatureId::Vertex(number)) => Part::Point(polytope.vertices[number as usize]),
        (Core::Polytope(polytope), FeatureId::EdgePoint { edge, part }) => {
            let [from, to] = polytope.edges[edge as usize].ends.map(|end| polytope.vertices[end]);
            Part::Point(from + (to - from) * f64::from_bits(part))
        }
        (Core::Cylinder(cylinder), FeatureId::Cap(end)) => {
            Part::Plane(cylinder.rim_centre(end as usize), cylinder.cap_normal(end as usize))
        }
        (Core::Cylinder(cylinder), FeatureId::Rim(end)) => {
            Part::Circle(cylinder.rim_centre(end as usize), cylinder.axis, cylinder.radius)
        }
        (Core::Cylinder(cylinder), FeatureId::RimPoint { end, turn }) => {
            Part::Point(rim_point(cylinder, end as usize, f64::from_bits(turn)))
        }
        (Core::Cylinder(cylinder), _) => Part::Line([cylinder.rim_centre(0), cylinder.rim_centre(1)], cylinder.radius),
        (Core::Polytope(polytope), _) => Part::Point(polytope.vertices[0]),
        (Core::Ellipsoid(ellipsoid), _) => Part::Ellipsoid(*ellipsoid),
    }
}

/// The point of a rim at an angle in turns (m); at quarters of a turn exactly square to each other.
fn rim_point(cylinder: &Cylinder, end: usize, turn: f64) -> Vector3<f64> {
    let (x, y) = across(&cylinder.axis);
    let quarter = (4.0 * turn).floor();
    let (x, y) = [(x, y), (y, -x), (-x, -y), (-y, x)][quarter as usize % 4];
    let (sine, cosine) = (TAU * (turn - 0.25 * quarter)).sin_cos();
    let arm = if sine == 0.0 { x } else { x * cosine + y * sine };
    cylinder.rim_centre(end) + arm * cylinder.radius
}

/// The name of the point of a rim towards a direction in the frame of the body.
pub fn rim_point_towards(cylinder: &Cylinder, end: u32, direction: &Vector3<f64>) -> FeatureId {
    let (x, y) = across(&cylinder.axis);
    let turn = (y.dot(direction).atan2(x.dot(direction)) / TAU).rem_euclid(1.0);
    // A rounding below zero is a whole turn.
    FeatureId::RimPoint { end, turn: (if turn < 1.0 { turn } else { 0.0 }).to_bits() }
}

/// A point of a rim touches in its place while the tilt across it is less than this: the rim runs then.
const STRAIGHT: f64 = 1e-9;

/// How far the tilt of a cylinder is from leaving the plane through its axis and a point of its rim: the radius (m) where it is in that plane, and
/// zero where it is out of it by [`STRAIGHT`]; the plane that it touches has this normal in the frame of its body. Infinite for other features. In
/// lengths of the size of the cylinder, because the nearest border is the least of several: one that is always next to zero would hide the others
/// until they are crossed.
pub fn off_tilt(core: &Core, name: FeatureId, normal: &Vector3<f64>) -> f64 {
    match (core, name) {
        (Core::Cylinder(cylinder), FeatureId::RimPoint { end, turn }) => {
            let arm = rim_point(cylinder, end as usize, f64::from_bits(turn)) - cylinder.rim_centre(end as usize);
            cylinder.radius - cylinder.axis.cross(&arm).dot(normal).abs() / STRAIGHT
        }
        _ => f64::INFINITY,
    }
}

/// All features of a core.
pub fn features(core: &Core) -> impl Iterator<Item = FeatureId> {
    let (faces, edges, vertices, ends) = match core {
        Core::Polytope(polytope) => (polytope.faces.len(), polytope.edges.len(), polytope.vertices.len(), 0),
        Core::Cylinder(_) => (0, 0, 0, 2),
        Core::Ellipsoid(_) => (0, 0, 0, 0),
    };
    let is_round = !matches!(core, Core::Polytope(_));
    let polytope = (0..faces as u32).map(FeatureId::Face).chain((0..edges as u32).map(FeatureId::Edge));
    let polytope = polytope.chain((0..vertices as u32).map(FeatureId::Vertex));
    let cylinder = (0..ends).flat_map(|end| [FeatureId::Cap(end), FeatureId::Rim(end)]);
    polytope.chain(cylinder).chain(is_round.then_some(FeatureId::Side))
}

/// The end of a cylinder is flat on a plane if its rim rises by less than this part of its radius.
const FLAT: f64 = 1e-9;

/// The features that can touch a plane with this normal into it. If a whole rim lies within a depth (m) of its lowest point, the features are four of
/// its points, too. They tell when it comes down flat, and stand for it once it is flat.
pub fn contact_features(core: &Core, normal: &Vector3<f64>, depth: f64) -> impl Iterator<Item = FeatureId> {
    let (low, flat) = match core {
        Core::Cylinder(cylinder) => {
            let rises = 2.0 * cylinder.radius * cylinder.axis.cross(normal).norm();
            let end = u32::from(cylinder.axis.dot(normal) >= 0.0);
            ((rises < depth).then_some(end), rises < depth.min(FLAT * cylinder.radius))
        }
        Core::Polytope(_) | Core::Ellipsoid(_) => (None, false),
    };
    let point = |end, quarter| FeatureId::RimPoint { end, turn: (0.25 * f64::from(quarter)).to_bits() };
    let points = low.into_iter().flat_map(move |end| (0..4u8).map(move |quarter| point(end, quarter)));
    let rim = move |feature: &FeatureId| !(flat && matches!(feature, FeatureId::Rim(_)));
    features(core).filter(rim).chain(points)
}

/// The normals of the faces and caps of a core.
pub fn normals(core: &Core) -> impl Iterator<Item = Vector3<f64>> {
    features(core).filter_map(|feature| match part(core, feature) {
        Part::Plane(_, normal) => Some(normal),
        _ => None,
    })
}

/// Whether all of a feature lies within a depth (m) of the support plane `n · p = height` of its core.
pub fn lies_near(core: &Core, feature: FeatureId, normal: &Vector3<f64>, least: f64) -> bool {
    match (core, feature) {
        (Core::Polytope(polytope), FeatureId::Face(number)) => {
            let corners = &polytope.faces[number as usize].corners;
            corners.iter().all(|&corner| normal.dot(&polytope.vertices[corner]) >= least)
        }
        (Core::Polytope(polytope), FeatureId::Edge(number)) => {
            let ends = polytope.edges[number as usize].ends;
            ends.iter().all(|&end| normal.dot(&polytope.vertices[end]) >= least)
        }
        (Core::Polytope(polytope), FeatureId::Vertex(number)) => {
            normal.dot(&polytope.vertices[number as usize]) >= least
        }
        // A cylinder has few features, and a normal by GJK is a poor judge of them.
        _ => true,
    }
}

/// How far inside the bounds of a feature a point on it is (m); infinite where a feature has no bounds.
pub fn inside(core: &Core, feature: FeatureId, point: &Vector3<f64>) -> f64 {
    let between = |ends: [Vector3<f64>; 2]| {
        let along = (ends[1] - ends[0]).normalize();
        along.dot(&(point - ends[0])).min(along.dot(&(ends[1] - point)))
    };
    match (core, feature) {
        (Core::Polytope(polytope), FeatureId::Face(number)) => polytope.inside_face(number as usize, point),
        (Core::Polytope(polytope), FeatureId::Edge(number)) => {
            between(polytope.edges[number as usize].ends.map(|end| polytope.vertices[end]))
        }
        (Core::Cylinder(cylinder), FeatureId::Side) => between([cylinder.rim_centre(0), cylinder.rim_centre(1)]),
        (Core::Cylinder(cylinder), FeatureId::Cap(_)) => {
            cylinder.radius - cylinder.axis.cross(&(point - cylinder.centre)).norm()
        }
        _ => f64::INFINITY,
    }
}

/// How far inside the region of a polytope's edge or vertex a point off the polytope is, by the planes to its neighbours (m).
pub fn off_neighbours(polytope: &Polytope, feature: FeatureId, point: &Vector3<f64>) -> f64 {
    match feature {
        FeatureId::Edge(number) => {
            let edge = &polytope.edges[number as usize];
            let from = polytope.vertices[edge.ends[0]];
            let along = (polytope.vertices[edge.ends[1]] - from).normalize();
            let beside = |face: usize| {
                let face = &polytope.faces[face];
                let inward = face.normal.cross(&along);
                let third = face.corners.iter().find(|corner| !edge.ends.contains(corner));
                let towards = third.map_or(1.0, |&corner| inward.dot(&(polytope.vertices[corner] - from)).signum());
                -towards * inward.dot(&(point - from))
            };
            edge.faces.map_or(f64::INFINITY, |faces| beside(faces[0]).min(beside(faces[1])))
        }
        FeatureId::Vertex(number) => {
            let own = number as usize;
            let at = polytope.vertices[own];
            let edges = polytope.edges.iter().filter(|edge| edge.ends.contains(&own));
            let other = |ends: [usize; 2]| polytope.vertices[if ends[0] == own { ends[1] } else { ends[0] }];
            edges.map(|edge| -(other(edge.ends) - at).normalize().dot(&(point - at))).fold(f64::INFINITY, f64::min)
        }
        _ => f64::INFINITY,
    }
}
