//! Places of other points of the same rim on a plane.

use crate::features::both::Candidate;
use crate::features::feature::{FeatureId, part, rim_point_towards};
use crate::features::meet::{Guess, meet};
use crate::features::place::{Bearer, TouchPlace, place};
use crate::pair::PairGeometry;
use crate::prepared_shape::First;
use crate::shapes::convex::Core;
use catena_mechanism::description::joint::Pose;
use nalgebra::{Matrix3, Vector3};

impl PairGeometry {
    /// The place of a point of the same rim, next to a direction in the world, if this one is a rim on a plane or a point of it. `None` if it is not.
    /// The other point may lie beside the face: [`PairGeometry::margin`] tells.
    pub fn rim_place(&self, known: &TouchPlace, towards: &Vector3<f64>, a: &Pose, b: &Pose) -> Option<TouchPlace> {
        self.renamed(known, [a, b], |core, name, rotation| rim_point(core, name, &(rotation * towards)))
    }

    /// The place of the point of the same rim at a part of a turn, from 0 to 1, from this one, if this is a point of a rim on a plane.
    pub fn turned_place(&self, known: &TouchPlace, part: f64, a: &Pose, b: &Pose) -> Option<TouchPlace> {
        self.renamed(known, [a, b], |_, name, _| turned(name, part))
    }

    /// A place on a plane whose other feature has another name: `rename` takes its core, its name and the rotation from the world to its body.
    fn renamed(
        &self,
        known: &TouchPlace,
        [a, b]: [&Pose; 2],
        rename: impl Fn(&Core, FeatureId, Matrix3<f64>) -> Option<FeatureId>,
    ) -> Option<TouchPlace> {
        let (first, in_first) = self.relative(a, b);
        let (rotation, translation) = &in_first;
        let mut names = [known.identity.a, known.identity.b];
        if self.exchanged {
            names.reverse();
        }
        let own = first.rotation.matrix().transpose();
        if let Some(name) = rename(&self.second.core, names[1], rotation.tr_mul(&own)) {
            names[1] = name;
        } else if let First::Convex(convex) = &self.first {
            names[0] = rename(&convex.core, names[0], own)?;
        } else {
            return None;
        }
        let (of_first, radius) = match &self.first {
            First::HalfSpace(half_space) => (half_space.part(), 0.0),
            First::Hollow(rope) => (rope.part(), 0.0),
            First::Mesh(mesh) => (mesh.part(names[0]), 0.0),
            First::Convex(convex) => (part(&convex.core, names[0]), convex.radius),
        };
        let of_second = part(&self.second.core, names[1]);
        let moved = of_second.moved(rotation, translation);
        let normal = first.rotation.inverse() * known.normal * if self.exchanged { -1.0 } else { 1.0 };
        let (normal, points) = meet(&of_first, &moved, &Guess { normal, point: *translation, at_point: false })?;
        let separation = normal.dot(&(points[1] - points[0]));
        let candidate = Candidate { normal, points, features: names, separation };
        let bearers = [Bearer { part: of_first, radius }, Bearer { part: of_second, radius: self.second.radius }];
        let found = place(&candidate, bearers, &in_first, first);
        Some(if self.exchanged { found.exchanged() } else { found })
    }
}

/// The name of a point of a rim, if this is the name of the rim, or of another point of it.
fn rim_point(core: &Core, name: FeatureId, towards: &Vector3<f64>) -> Option<FeatureId> {
    match (core, name) {
        (Core::Cylinder(cylinder), FeatureId::RimPoint { end, .. } | FeatureId::Rim(end)) => {
            Some(rim_point_towards(cylinder, end, towards))
        }
        _ => None,
    }
}

/// The name of the point of a rim at a part of a turn from this one, if this is the name of a point.
fn turned(name: FeatureId, part: f64) -> Option<FeatureId> {
    let FeatureId::RimPoint { end, turn } = name else { return None };
    let turn = f64::from_bits(turn) + part;
    Some(FeatureId::RimPoint { end, turn: (if turn < 1.0 { turn } else { turn - 1.0 }).to_bits() })
}
