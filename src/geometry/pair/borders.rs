//! The borders of a place of contact: how far it is inside its features, and how far all other features are from its tangent plane.

use crate::distances::beyond::{Place, height, height_of_moved};
use crate::features::crossing::off_crossing;
use crate::features::feature::{FeatureId, Part, inside, off_neighbours, off_tilt, part};
use crate::features::meet::{Guess, meet};
use crate::features::place::{PlaceId, TouchPlace};
use crate::features::rims::{Meeting, off_rim};
use crate::pair::PairGeometry;
use crate::prepared_shape::First;
use crate::shapes::convex::Core;
use catena_mechanism::description::joint::Pose;
use nalgebra::Vector3;

/// Two rims are at the same place up to this part of their radii.
const CROSSES: f64 = 1e-6;

/// A stand-in keeps the place of its features until they are farther apart, or deeper in each other, than this part of the size of the pair.
const STANDS_IN: f64 = 5e-12;

/// Triangles that rise over the plane of a contact by no more than this part of the size of the pair are in that plane.
const FLAT: f64 = 1e-12;

/// A mesh that is not flat as far as the other shape is large may be flat as far as this part of that.
const NEARBY: f64 = 0.05;

impl PairGeometry {
    /// How far the place is inside the borders of its features (m): the distance of its points from the sides of faces, the ends of edges and the
    /// planes to neighbours; of a point of a rim, how far the tilt is from leaving its plane; of a stand-in, how far the shapes are from where it
    /// says they are. Zero where another feature takes over, negative beyond; infinite if there are no borders.
    pub fn margin(&self, place: &TouchPlace, a: &Pose, b: &Pose) -> f64 {
        if place.is_stand_in() {
            return self.extents.within(STANDS_IN) - self.distance(a, b).distance.abs();
        }
        let (first, (rotation, translation)) = self.relative(a, b);
        let names = [place.identity.a, place.identity.b];
        let names = if self.exchanged { [names[1], names[0]] } else { names };
        let of_first = match &self.first {
            First::HalfSpace(half_space) => half_space.part(),
            // A taut rope has no borders.
            First::Hollow(_) => return f64::INFINITY,
            First::Mesh(mesh) => mesh.part(names[0]),
            First::Convex(convex) => part(&convex.core, names[0]),
        };
        let on_second = part(&self.second.core, names[1]).moved(&rotation, &translation);
        let own = |point: &Vector3<f64>| rotation.tr_mul(&(point - translation));
        // The planes to neighbours count where a rounded partner rolls over an edge; of sharp ones the neighbours' own gaps tell.
        let rounded = self.is_rounded();
        let parts = [&of_first, &on_second];
        let (points, form) = match self.rim_meets(place, [a, b]) {
            Some(Meeting { normal, points, off_form }) => {
                let reach = |part: &Part| match part {
                    Part::Circle(_, _, rim) if (points[1] - points[0]).norm() < CROSSES * rim => *rim,
                    _ => (points[1] - points[0]).norm(),
                };
                let off = |side: usize, normal: Vector3<f64>| {
                    off_rim(parts[side], names[side], &points[side], &normal, reach(parts[side]))
                };
                (points, off_form.min(off(0, normal)).min(off(1, -normal)))
            }
            None => {
                let side = if self.exchanged { -1.0 } else { 1.0 };
                let point = first.inverse_transform_point(&place.points[usize::from(!self.exchanged)].into()).coords;
                let guess = Guess { normal: first.rotation.inverse() * place.normal * side, point, at_point: false };
                let Some((normal, points)) = meet(&of_first, &on_second, &guess) else { return f64::NEG_INFINITY };
                let normals = [rotation.tr_mul(&normal), -normal];
                let leaves = off_tilt(&self.second.core, names[1], &normals[0]).min(match &self.first {
                    First::Convex(convex) => off_tilt(&convex.core, names[0], &normals[1]),
                    First::HalfSpace(_) | First::Hollow(_) | First::Mesh(_) => f64::INFINITY,
                });
                (points, leaves.min(off_crossing(&place.features, names, parts, &points)))
            }
        };
        let off = |core: &Core, feature: FeatureId, point: &Vector3<f64>| match core {
            Core::Polytope(polytope) if rounded => off_neighbours(polytope, feature, point),
            _ => f64::INFINITY,
        };
        let of_first = match &self.first {
            First::HalfSpace(_) | First::Hollow(_) => f64::INFINITY,
            First::Mesh(mesh) => {
                let beside = if rounded { mesh.off_neighbours(names[0], &points[1]) } else { f64::INFINITY };
                mesh.inside(names[0], &points[0]).min(beside)
            }
            First::Convex(convex) => {
                inside(&convex.core, names[0], &points[0]).min(off(&convex.core, names[0], &points[1]))
            }
        };
        let second = &self.second.core;
        form.min(of_first).min(inside(second, names[1], &own(&points[1]))).min(off(second, names[1], &own(&points[0])))
    }

    /// The distance of all features outside `closed` from the tangent plane of one of these places, which has this normal, from collider a to
    /// collider b, and this point (m), in the world. The shapes do not overlap elsewhere while it is not negative. Distances above `within` (m) may be
    /// less than the true ones. `None` for a half space, for the inside of a shape, and where a mesh is not flat near the other shape.
    pub fn beyond(
        &self,
        place: &PlaceId,
        closed: &[PlaceId],
        [normal, point]: [&Vector3<f64>; 2],
        [a, b]: [&Pose; 2],
        within: f64,
    ) -> Option<f64> {
        let side = |first: bool, place: &PlaceId| match first != self.exchanged {
            true => Place { own: place.a, other: place.b },
            false => Place { own: place.b, other: place.a },
        };
        let (first, (rotation, translation)) = self.relative(a, b);
        let normal = first.rotation.inverse() * normal * if self.exchanged { -1.0 } else { 1.0 };
        let point = first.inverse_transform_point(&(*point).into()).coords;
        let of = |first: bool| closed.iter().map(|place| side(first, place)).collect::<Vec<_>>();
        let of_first = match &self.first {
            First::HalfSpace(_) | First::Hollow(_) => return None,
            First::Mesh(mesh) => {
                // Off its faces the tangent plane does not lie on it.
                let FeatureId::Face(_) = side(true, place).own else { return None };
                let most = self.extents.within(FLAT);
                let at = (&rotation, &translation);
                let is_flat = |within: f64| mesh.is_below(&self.second, at, [&normal, &point], [within, most]);
                let far = within.min(self.second.size);
                [far, NEARBY * far].into_iter().find(|&within| is_flat(within))?
            }
            First::Convex(convex) => {
                let plane = [&-normal, &(point - normal * convex.radius)];
                height(convex, side(true, place), &of(true), plane)
            }
        };
        let plane = [&normal, &(point + normal * self.second.radius)];
        let own = side(false, place);
        Some(of_first.min(height_of_moved(&self.second, own, &of(false), plane, &rotation, &translation)))
    }

    /// The least gap of a ball and a mesh, up to `within` (m), without these places; `None` for other shapes.
    pub fn ball_beside(&self, closed: &[PlaceId], a: &Pose, b: &Pose, within: f64) -> Option<f64> {
        let First::Mesh(mesh) = &self.first else { return None };
        if !self.second.is_ball() {
            return None;
        }
        let (_, (rotation, translation)) = self.relative(a, b);
        let is_closed =
            |name: FeatureId| closed.iter().any(|place| name == if self.exchanged { place.b } else { place.a });
        let places = mesh.manifold(&self.second, &rotation, &translation, within).into_iter();
        let open = places.filter(|place| !is_closed(place.features[0]));
        Some(open.map(|place| place.distance() - self.second.radius).fold(within, f64::min))
    }

    /// The least height over a half space of the vertices that are not part of `closed` places (m); `None` unless one shape is a half space and the
    /// other has flat faces.
    pub fn lowest_beside(&self, closed: &[PlaceId], a: &Pose, b: &Pose) -> Option<f64> {
        let First::HalfSpace(half_space) = &self.first else { return None };
        let (_, (rotation, translation)) = self.relative(a, b);
        let names = closed.iter().map(|place| if self.exchanged { place.a } else { place.b });
        half_space.lowest_but(&self.second, names, &rotation, &translation)
    }

    /// The angle (rad) up to which the two may turn about these vertices on a half space before any other vertex touches it, at least; `None` unless
    /// one shape is a half space and the other touches it with vertices of flat faces alone.
    pub fn turns_at_least(&self, closed: impl Iterator<Item = PlaceId> + Clone, a: &Pose, b: &Pose) -> Option<f64> {
        let First::HalfSpace(half_space) = &self.first else { return None };
        let (_, (rotation, _)) = self.relative(a, b);
        let exchanged = self.exchanged;
        let names = closed.map(move |place| if exchanged { place.a } else { place.b });
        half_space.least_slope_beside(&self.second, names, &rotation)
    }
}
