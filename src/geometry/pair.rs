//! All queries about two colliders: their distance, their places of contact and the borders of these.
//!
//! All is computed in the frame of the body of one of them and handed out in the world; a place has its frames in the body frames.

use crate::distances::axes::{Found, places};
use crate::distances::few::few;
use crate::distances::hollow::Hollow;
use crate::distances::manifold::manifold;
use crate::distances::nearest::{distance_unless_deep, nearest};
use crate::distances::otherwise::manifolds;
use crate::features::both::{Both, Candidate};
use crate::features::feature::{FeatureId, part};
use crate::features::place::{Bearer, TouchPlace, place};
use crate::features::rims::{Joined, Meeting};
use crate::prepared_shape::{First, PreparedShape};
use crate::shapes::convex::Convex;
use crate::shapes::error::GeometryError;
use crate::shapes::extents::{Extents, Lengths};
use catena_mechanism::description::contact::Collider;
use catena_mechanism::description::joint::Pose;
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;

/// The relative rounding error of a lower bound of a distance.
const ROUNDED: f64 = 1e-13;

mod borders;
mod turned;

/// Two colliders, prepared for questions.
#[derive(Clone, Debug)]
pub struct PairGeometry {
    first: First,
    second: Arc<Convex>,
    /// Whether `first` is collider b.
    exchanged: bool,
    reach: [f64; 2],
    extents: Extents,
}

/// A shape of revolution, in the frame of its body: turning about its axis leaves it where it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Revolved {
    /// The middle of the shape (m).
    pub centre: Vector3<f64>,
    /// Unit vector along its axis; `None` for a ball, which has them all.
    pub axis: Option<Vector3<f64>>,
    /// Distance of its farthest point from the middle (m).
    pub reach: f64,
}

/// The distance of two colliders at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// m; of shapes that overlap minus the depth, the least motion that separates them.
    pub distance: f64,
    /// Unit normal from a to b, in the world.
    pub normal: Vector3<f64>,
    /// The nearest points on a and b (m), in the world.
    pub points: [Vector3<f64>; 2],
    /// An upper bound of the error of the distance (m).
    pub certificate: f64,
}

/// What a pair was like a moment ago.
#[derive(Clone, Copy, Debug, Default)]
pub struct Before {
    /// Whether there were places.
    pub touches: bool,
    /// The normal from the first shape to the second that GJK found last, in the frame of the first: what it separates is apart.
    normal: Option<Vector3<f64>>,
}

impl PairGeometry {
    /// Prepares two colliders; their shapes and their poses in the bodies count, and for tolerances whether they are obstacles.
    pub fn new(a: &Collider, b: &Collider) -> Result<Self, GeometryError> {
        let (a, b) = (PreparedShape::new(a)?, PreparedShape::new(b)?);
        a.may_touch(&b)?;
        Ok(PairGeometry::of(&a, &b))
    }

    /// The same of two prepared colliders that may touch: a shape is shared by all its pairs. Of two obstacles the second counts as a point.
    pub fn of(a: &PreparedShape, b: &PreparedShape) -> Self {
        let exchanged = a.convex().is_some() && b.convex().is_none();
        let (first, second) = if exchanged { (b, a) } else { (a, b) };
        let second = second.convex().cloned().unwrap_or_else(PreparedShape::point);
        let first = first.side.clone();
        let mut reach = [first.reach(), second.reach()];
        let mut standing = [first.lengths(), Lengths::of_convex(&second)];
        if exchanged {
            reach.reverse();
            standing.reverse();
        }
        let lengths = |side: usize, moves: bool| if moves { Lengths::of_moving(reach[side]) } else { standing[side] };
        let mut extents = Extents::new([lengths(0, a.moves), lengths(1, b.moves)]);
        if let First::Hollow(Hollow { length, .. }) = &first {
            extents = Extents { larger: *length, smaller: *length, whole: *length, ..extents };
        }
        PairGeometry { first, second, exchanged, reach, extents }
    }

    /// Distance of the farthest point of each shape from the origin of its body (m); infinite for half spaces.
    pub fn reach(&self) -> [f64; 2] {
        self.reach
    }

    /// The same of the points whose speeds bound the rate of the distance (m): a ball over a mesh turns about its centre without coming nearer. In general a
    /// radius counts, too, as it does where surfaces slide.
    pub fn closing_reach(&self) -> [f64; 2] {
        let mut reach = self.reach;
        if matches!(self.first, First::Mesh(_)) && self.second.is_ball() {
            let ball = &mut reach[usize::from(!self.exchanged)];
            *ball = (*ball - self.second.radius).max(0.0);
        }
        reach
    }

    /// Whether one of the shapes is rounded, as a ball or a capsule is.
    pub fn is_rounded(&self) -> bool {
        let first = matches!(&self.first, First::Convex(convex) if convex.radius > 0.0);
        first || self.second.radius > 0.0
    }

    /// The shapes of revolution among the two.
    pub fn revolved(&self) -> [Option<Revolved>; 2] {
        let of = |convex: &Convex| {
            let axis = convex.axis();
            (axis.is_some() || convex.is_ball()).then_some(Revolved { centre: convex.centre, axis, reach: convex.size })
        };
        let first = match &self.first {
            First::Convex(convex) => of(convex),
            First::HalfSpace(_) | First::Mesh(_) => None,
            First::Hollow(_) => return [None; 2],
        };
        let second = of(&self.second);
        if self.exchanged { [second, first] } else { [first, second] }
    }

    /// Unit normal out of the half space among the two, in the frame of its body, and which of the two it is.
    pub fn half_space(&self) -> Option<(usize, Vector3<f64>)> {
        let First::HalfSpace(plane) = &self.first else { return None };
        Some((usize::from(self.exchanged), plane.normal))
    }

    /// Lower bound of the translations (m) along which the shapes overlap from start to end while one of them passes through the other: the sum of
    /// their least widths. A mesh is a shell of width zero; the width of a half space is infinite.
    pub fn breadth(&self) -> f64 {
        let of_first = match &self.first {
            First::HalfSpace(_) | First::Hollow(_) => f64::INFINITY,
            First::Mesh(_) => 0.0,
            First::Convex(convex) => convex.breadth(),
        };
        of_first + self.second.breadth()
    }

    /// Whether the shapes have one pair of features at most, wherever they are: two balls, and a ball over a half space.
    pub fn has_one_place(&self) -> bool {
        let first = match &self.first {
            First::HalfSpace(_) => true,
            First::Convex(convex) => convex.is_ball(),
            First::Hollow(_) | First::Mesh(_) => false,
        };
        first && self.second.is_ball()
    }

    /// Whether two convex shapes have many vertices: GJK alone is much less work than the exact distance.
    pub fn is_dense(&self) -> bool {
        matches!(&self.first, First::Convex(convex) if convex.is_dense() || self.second.is_dense())
    }

    /// The lengths from which tolerances are made.
    pub fn extents(&self) -> Extents {
        self.extents
    }

    /// A lower bound of the distance (m): by the balls about the shapes, and of dense hulls by GJK if that is not more than `enough`; not a number if a
    /// pose is not finite.
    pub fn least_distance(&self, a: &Pose, b: &Pose, enough: f64) -> f64 {
        let (_, in_first) = self.relative(a, b);
        let (by_balls, rounded) = self.by_balls(&in_first);
        match &self.first {
            First::Convex(convex) if by_balls <= enough && self.is_dense() => {
                let both = both(convex, &self.second, &in_first);
                let along = |normal: Vector3<f64>| along(&both, &normal, rounded);
                both.hint(&Vector3::zeros()).map(along).map_or(by_balls, |apart| apart.max(by_balls))
            }
            _ => by_balls,
        }
    }

    /// The same by the balls alone, and the rounding error of such a bound (m).
    fn by_balls(&self, (rotation, translation): &(Matrix3<f64>, Vector3<f64>)) -> (f64, f64) {
        let centre = rotation * self.second.centre + translation;
        let (apart, scale) = match &self.first {
            First::HalfSpace(half_space) => {
                let from = centre - half_space.point;
                (half_space.normal.dot(&from) - self.second.size, from.norm())
            }
            First::Hollow(rope) => {
                let from = (centre - rope.centre).norm();
                (rope.length - from, from + rope.length)
            }
            First::Mesh(_) => (f64::NEG_INFINITY, 0.0),
            First::Convex(convex) => {
                let from = (centre - convex.centre).norm();
                (from - convex.size - self.second.size, from + convex.size)
            }
        };
        let rounded = ROUNDED * (scale + self.second.size + translation.norm());
        (apart - rounded, rounded)
    }

    /// The distance of the two for these poses of their bodies; not a number if a pose is not finite.
    pub fn distance(&self, a: &Pose, b: &Pose) -> Distance {
        let (first, in_first) = self.relative(a, b);
        let (rotation, translation) = &in_first;
        let found = match &self.first {
            First::HalfSpace(half_space) => Some((half_space.nearest(&self.second, rotation, translation), 0.0)),
            First::Hollow(rope) => Some((rope.nearest(&(rotation * self.second.centre + translation)), 0.0)),
            First::Mesh(mesh) => mesh.nearest(&self.second, rotation, translation).map(|found| (found, 0.0)),
            First::Convex(convex) => {
                nearest(&both(convex, &self.second, &in_first)).map(|found| (found, convex.radius))
            }
        };
        let Some((found, radius)) = found.filter(|(found, _)| found.distance().is_finite()) else {
            let nowhere = Vector3::repeat(f64::NAN);
            return Distance { distance: f64::NAN, normal: nowhere, points: [nowhere; 2], certificate: f64::NAN };
        };
        let world = |point: Vector3<f64>| first.rotation * point + first.translation.vector;
        let normal = found.normal;
        let points = [world(found.points[0] + normal * radius), world(found.points[1] - normal * self.second.radius)];
        let normal = first.rotation * normal;
        let exchanged = self.exchanged;
        Distance {
            distance: found.distance() - radius - self.second.radius,
            normal: if exchanged { -normal } else { normal },
            points: if exchanged { [points[1], points[0]] } else { points },
            certificate: found.certificate(),
        }
    }

    /// The distance for a search of roots (m): of hulls that overlap by more than a ten thousandth of their size a lower bound, below that.
    pub fn distance_unless_deep(&self, a: &Pose, b: &Pose) -> f64 {
        let First::Convex(convex) = &self.first else { return self.distance(a, b).distance };
        let (_, in_first) = self.relative(a, b);
        let found = distance_unless_deep(&both(convex, &self.second, &in_first));
        found.filter(|found| found.is_finite()).map_or(f64::NAN, |found| found - convex.radius - self.second.radius)
    }

    /// All places where the gap is below a bound (m), for these poses of the bodies.
    pub fn touches(&self, a: &Pose, b: &Pose, near: f64) -> Vec<TouchPlace> {
        let (first, in_first) = self.relative(a, b);
        let (rotation, translation) = &in_first;
        let found = match &self.first {
            First::HalfSpace(half_space) => half_space.manifold(&self.second, rotation, translation, near),
            First::Hollow(rope) => {
                let found = rope.nearest(&(rotation * self.second.centre + translation));
                Some(found).filter(|found| found.distance() < near).into_iter().collect()
            }
            First::Mesh(mesh) => mesh.manifold(&self.second, rotation, translation, near),
            First::Convex(convex) => manifold(&both(convex, &self.second, &in_first), near),
        };
        self.placed(&found, &in_first, first)
    }

    /// The places where the gap is below a bound (m) along each face normal that separates two convex shapes that touch, if there are several, as at
    /// an edge on an edge.
    pub fn touches_otherwise(&self, a: &Pose, b: &Pose, alike: f64, near: f64) -> Vec<Vec<TouchPlace>> {
        let First::Convex(convex) = &self.first else { return Vec::new() };
        let (first, in_first) = self.relative(a, b);
        let found = manifolds(&both(convex, &self.second, &in_first), alike, near);
        found.iter().map(|found| self.placed(found, &in_first, first)).collect()
    }

    /// The same places in a way that is quicker, and a lower bound of the distance (m) where there are none. Two small polytopes have the same places to
    /// rounding, perhaps under other names. Shapes with many vertices have a few of their places, the nearest among them. `before` is known from a moment
    /// ago.
    pub fn touches_soon(&self, a: &Pose, b: &Pose, near: f64, before: &mut Before) -> (Vec<TouchPlace>, f64) {
        let (first, in_first) = self.relative(a, b);
        let (apart, rounded) = self.by_balls(&in_first);
        let likely = std::mem::take(&mut before.touches);
        if apart > near {
            return (Vec::new(), apart);
        }
        let found = match &self.first {
            First::Convex(convex) if apart <= near && self.is_dense() => {
                let both = both(convex, &self.second, &in_first);
                // Two supports tell whether the normal still separates the shapes.
                let still = before.normal.map_or(f64::NEG_INFINITY, |normal| along(&both, &normal, rounded));
                if still > near {
                    return (Vec::new(), still);
                }
                before.normal = both.hint(&Vector3::zeros());
                let apart = before.normal.map_or(apart, |normal| along(&both, &normal, rounded).max(apart));
                if apart > near {
                    return (Vec::new(), apart);
                }
                match places(&both, near) {
                    Found::Unknown => few(&both, before.normal, near),
                    found => found,
                }
            }
            First::Convex(convex) => places(&both(convex, &self.second, &in_first), near),
            First::HalfSpace(half_space) => {
                let (rotation, translation) = &in_first;
                half_space.few(&self.second, rotation, translation, near).map_or(Found::Unknown, Found::Places)
            }
            First::Mesh(_) | First::Hollow(_) => Found::Unknown,
        };
        match found {
            Found::Apart(distance) => return (Vec::new(), distance),
            Found::Places(found) => {
                before.touches = !found.is_empty();
                return (self.placed(&found, &in_first, first), f64::NEG_INFINITY);
            }
            Found::Unknown => {}
        }
        if !likely {
            let distance = self.distance(a, b).distance;
            if distance > near {
                return (Vec::new(), distance);
            }
        }
        let found = self.touches(a, b, near);
        before.touches = !found.is_empty();
        (found, f64::NEG_INFINITY)
    }

    /// The places of what was found in the frame of the first.
    fn placed(&self, found: &[Candidate], in_first: &(Matrix3<f64>, Vector3<f64>), first: &Pose) -> Vec<TouchPlace> {
        let of = |convex: &Convex, feature| Bearer { part: part(&convex.core, feature), radius: convex.radius };
        let sharp = |part| Bearer { part, radius: 0.0 };
        let on_first = |feature: FeatureId| match &self.first {
            First::HalfSpace(half_space) => sharp(half_space.part()),
            First::Hollow(rope) => sharp(rope.part()),
            First::Mesh(mesh) => sharp(mesh.part(feature)),
            First::Convex(convex) => of(convex, feature),
        };
        let exchanged = |place: TouchPlace| if self.exchanged { place.exchanged() } else { place };
        let placed = |one: &Candidate| {
            place(one, [on_first(one.features[0]), of(&self.second, one.features[1])], in_first, first)
        };
        found.iter().map(placed).map(exchanged).collect()
    }

    /// The place at which a rim touches a round feature, or another rim, as the joint has it: with the normal and the points from the first body to
    /// the second, in the frame of the first.
    fn rim_meets(&self, place: &TouchPlace, poses: [&Pose; 2]) -> Option<Meeting> {
        let of = |feature: usize| {
            let pose = poses[usize::from((feature == 1) != place.swapped)] * place.frames[feature];
            [pose.translation.vector, pose.rotation * Vector3::z()]
        };
        let joined = Joined { features: place.features, side: place.side, placed: [of(0), of(1)] };
        let Meeting { normal, points, off_form } = joined.meeting()?;
        let first = poses[usize::from(self.exchanged)];
        let [near, far] = points.map(|point| first.inverse_transform_point(&point.into()).coords);
        let normal = first.rotation.inverse() * normal;
        Some(match place.swapped != self.exchanged {
            true => Meeting { normal: -normal, points: [far, near], off_form },
            false => Meeting { normal, points: [near, far], off_form },
        })
    }

    /// Pose of the first body, and rotation and translation of the second in it.
    fn relative<'p>(&self, a: &'p Pose, b: &'p Pose) -> (&'p Pose, (Matrix3<f64>, Vector3<f64>)) {
        let (first, second) = if self.exchanged { (b, a) } else { (a, b) };
        let rotation = first.rotation.matrix().tr_mul(second.rotation.matrix());
        let translation = first.rotation.matrix().tr_mul(&(second.translation.vector - first.translation.vector));
        (first, (rotation, translation))
    }
}

/// A lower bound of the distance of two convex shapes by a normal (m), with this rounding error (m).
fn along(both: &Both, normal: &Vector3<f64>, rounded: f64) -> f64 {
    both.separation(normal) - both.a.radius - both.b.radius - rounded
}

/// Two convex shapes, given the pose of the second body in the first.
fn both<'a>(a: &'a Convex, b: &'a Convex, in_first: &(Matrix3<f64>, Vector3<f64>)) -> Both<'a> {
    Both { a, b, rotation: in_first.0, translation: in_first.1 }
}
