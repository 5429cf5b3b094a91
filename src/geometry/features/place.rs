//! A place where two colliders touch, or nearly: features with their frames in the body frames, ready to be a joint.

use crate::features::both::Candidate;
use crate::features::feature::{FeatureId, Part};
use crate::features::forms::form;
use crate::features::rims::Form;
use crate::shapes::convex::Ellipsoid;
use crate::shapes::plane::across;
use catena_mechanism::description::contact::Feature;
use catena_mechanism::description::joint::Pose;
use nalgebra::{Matrix3, Rotation3, Translation3, Vector3};

/// The names of the features of a place, by which it is found again at another instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct PlaceId {
    /// On collider a.
    pub a: FeatureId,
    /// On collider b.
    pub b: FeatureId,
}

/// Two features that touch, or nearly.
#[derive(Clone, Debug, PartialEq)]
pub struct TouchPlace {
    /// The name by which it is found again.
    pub identity: PlaceId,
    /// In the order that a joint wants; see `swapped`.
    pub features: [Feature; 2],
    /// The sign of n of lines and rims, or which place of a rim and a line it is: [`catena_mechanism::description::contact::Touch::side`].
    pub side: f64,
    /// The frames of the features, each in the frame of its body, in the order of `features`.
    pub frames: [Pose; 2],
    /// Whether the first feature belongs to collider b.
    pub swapped: bool,
    /// φ (m), negative if the two overlap.
    pub gap: f64,
    /// Normal from collider a to collider b, in the world.
    pub normal: Vector3<f64>,
    /// The points on the surfaces of a and b (m), in the world.
    pub points: [Vector3<f64>; 2],
    /// False if no kind of joint has these features: then a point and its tangent plane stand for them, which has the right gap and
    /// the right rate at this instant, but not the right second rate.
    pub exact: bool,
}

/// The frame at a point (m) with a unit z axis.
pub fn frame(origin: Vector3<f64>, z: &Vector3<f64>) -> Pose {
    let (x, y) = across(z);
    let rotation = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, y, *z]));
    Pose::from_parts(Translation3::from(origin), rotation)
}

/// A part of a shape with a radius (m) about it, as a feature of a joint and its frame.
pub fn feature_frame(part: &Part, radius: f64) -> (Feature, Pose) {
    match part {
        Part::Point(at) => (Feature::Point { radius }, frame(*at, &Vector3::z())),
        Part::Line(ends, own) => {
            let along = (ends[1] - ends[0]).normalize();
            (Feature::Line { radius: radius + own }, frame(ends[0], &along))
        }
        Part::Plane(at, normal) => (Feature::Plane, frame(*at, normal)),
        Part::Circle(centre, axis, own) => (Feature::Rim { radius: *own }, frame(*centre, axis)),
        Part::Hollow(centre, own) => (Feature::Hollow { radius: *own }, frame(*centre, &Vector3::z())),
        Part::Ellipsoid(Ellipsoid { centre, axes, radii }) => {
            let rotation = Rotation3::from_matrix_unchecked(*axes);
            let pose = Pose::from_parts(Translation3::from(*centre), rotation);
            (Feature::Ellipsoid { radii: (*radii).into() }, pose)
        }
    }
}

/// One of the two features of a place.
pub struct Bearer {
    /// The feature, in the frame of its body.
    pub part: Part,
    /// Radius of its core (m).
    pub radius: f64,
}

/// The place of a candidate in the frame of the first body, given the pose of the second body in it and the pose of the first in the world.
pub fn place(
    candidate: &Candidate,
    bearers: [Bearer; 2],
    in_first: &(Matrix3<f64>, Vector3<f64>),
    a: &Pose,
) -> TouchPlace {
    let (rotation, translation) = in_first;
    let normal = candidate.normal;
    let radii = [bearers[0].radius, bearers[1].radius];
    let surface = [candidate.points[0] + normal * radii[0], candidate.points[1] - normal * radii[1]];
    let gap = candidate.distance() - radii[0] - radii[1];
    let [part_a, mut part_b] = bearers.map(|bearer| bearer.part);
    let mut part_a = part_a;
    let found = form([&part_a, &part_b.moved(rotation, translation)], radii, &surface, &normal, gap);
    let Form { swapped, reversed, side } = found.unwrap_or(Form::plain(false));
    for (part, reversed) in [&mut part_a, &mut part_b].into_iter().zip(reversed) {
        if reversed {
            part.reverse();
        }
    }
    let (of_a, frame_a) = feature_frame(&part_a, radii[0]);
    let (of_b, frame_b) = feature_frame(&part_b, radii[1]);
    let (features, frames) = match (found, swapped) {
        (Some(_), false) => ([of_a, of_b], [frame_a, frame_b]),
        (Some(_), true) => ([of_b, of_a], [frame_b, frame_a]),
        (None, _) => {
            let point = rotation.tr_mul(&(surface[1] - translation));
            (
                [Feature::Plane, Feature::Point { radius: 0.0 }],
                [frame(surface[0], &normal), frame(point, &Vector3::z())],
            )
        }
    };
    let world = |point: Vector3<f64>| a.rotation * point + a.translation.vector;
    TouchPlace {
        identity: PlaceId { a: candidate.features[0], b: candidate.features[1] },
        features,
        side,
        frames,
        swapped,
        gap,
        normal: a.rotation * normal,
        points: surface.map(world),
        exact: found.is_some()
            && !candidate
                .features
                .iter()
                .any(|name| matches!(name, FeatureId::RimPoint { .. } | FeatureId::EdgePoint { .. })),
    }
}

impl TouchPlace {
    /// Whether a point and its tangent plane stand for features that no kind of joint has.
    pub fn is_stand_in(&self) -> bool {
        let names = [self.identity.a, self.identity.b];
        !self.exact
            && !names.iter().any(|name| matches!(name, FeatureId::RimPoint { .. } | FeatureId::EdgePoint { .. }))
    }

    /// The same place of the same colliders in the other order.
    pub fn exchanged(self) -> Self {
        TouchPlace {
            identity: PlaceId { a: self.identity.b, b: self.identity.a },
            swapped: !self.swapped,
            normal: -self.normal,
            points: [self.points[1], self.points[0]],
            ..self
        }
    }
}
