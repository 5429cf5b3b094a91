//! A surface of triangles that stands still for convex shapes to touch, without ghost edges.
//!
//! Vertices at the same place are one. n₁ and n₂ are the normals of the triangles beside an edge. Its class is the class of the opposite vertex of
//! one triangle against the plane of the other:
//!
//! | class | opposite vertex | can be touched with normals |
//! |---|---|---|
//! | flat | in the plane, to 1e-9 of the size | never |
//! | concave | in front | from behind, between −n₁ and −n₂ |
//! | convex | behind | between n₁ and n₂ |
//! | border | none | on the open side |
//!
//! A vertex can be touched if one of its edges can. Triangles are found by parry's tree of boxes; each is asked as a polytope, and of balls in closed form
//! ([`crate::distances::mesh_and_point`]). A point on a common edge belongs to the triangle of the lower number.
//!
//! The surface is a shell without thickness that is touched on both sides, so that nothing depends on the order of the corners of a triangle. Of `T`
//! triangles, the front of triangle `k`, where its normal points, is the face `k`, and its back is the face `T + k`.

use crate::distances::doubles::take_doubles;
use crate::distances::inner::without_inner;
use crate::distances::manifold::manifold_along;
use crate::distances::mesh_and_point::{ALONG, Ball, Facet};
use crate::distances::mesh_parts::{about, bounds, merged};
use crate::distances::nearest::{nearest, supports};
use crate::features::both::{Both, Candidate};
use crate::features::feature::{FeatureId, Part, inside, normals};
use crate::shapes::convex::{Convex, Core};
use crate::shapes::error::GeometryError;
use crate::shapes::extents::Lengths;
use crate::shapes::hull::check_surface;
use catena_mechanism::description::contact::Surface;
use catena_mechanism::description::joint::Pose;
use nalgebra::{Matrix3, Vector3};
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Flat, relative to the size of the triangles.
const FLAT: f64 = 1e-9;

/// A surface of triangles in the frame of its body.
#[derive(Clone)]
pub struct Mesh {
    parts: Arc<Parts>,
}

struct Parts {
    vertices: Vec<Vector3<f64>>,
    triangles: Vec<Triangle>,
    edges: Vec<MeshEdge>,
    /// Numbers of the edges at each vertex, and whether one of them can be touched.
    around: Vec<Vec<usize>>,
    open: Vec<bool>,
    tree: Bvh,
    reach: f64,
}

struct Triangle {
    corners: [usize; 3],
    facet: Facet,
    /// Numbers of the sides among the edges of the mesh.
    edges: [usize; 3],
}

struct MeshEdge {
    ends: [usize; 2],
    /// The triangles beside it, one at a border.
    beside: Vec<usize>,
    /// Whether it can be touched.
    open: bool,
}

impl std::fmt::Debug for Mesh {
    fn fmt(&self, to: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(to, "Mesh of {} triangles", self.parts.triangles.len())
    }
}

impl Mesh {
    /// A surface with its pose in the body.
    pub fn new(surface: &Surface, pose: &Pose) -> Result<Self, GeometryError> {
        check_surface(surface)?;
        if !pose.translation.vector.iter().chain(pose.rotation.matrix()).all(|entry| entry.is_finite()) {
            return Err(GeometryError::Pose { shape: "triangle mesh" });
        }
        let (vertices, of) = merged(&surface.vertices, pose);
        let mut triangles = Vec::new();
        let mut beside: BTreeMap<[usize; 2], Vec<usize>> = BTreeMap::new();
        for corners in &surface.triangles {
            let corners = corners.map(|corner| of[corner as usize]);
            let [a, b, c] = corners.map(|corner| vertices[corner]);
            let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
            let doubled = (b - a).cross(&(c - a));
            // A triangle without area has no side, and its neighbours cover it.
            if doubled.norm() <= 1e-12 * longest * longest {
                continue;
            }
            let normal = doubled.normalize();
            for side in 0..3 {
                let ends = [corners[side], corners[(side + 1) % 3]];
                beside.entry([ends[0].min(ends[1]), ends[0].max(ends[1])]).or_default().push(triangles.len());
            }
            triangles.push(Triangle { corners, facet: Facet::new([a, b, c], normal), edges: [0; 3] });
        }
        if triangles.is_empty() {
            return Err(GeometryError::EmptyMesh);
        }
        let mut edges: Vec<MeshEdge> = Vec::new();
        let mut around = vec![Vec::new(); vertices.len()];
        for (ends, beside) in beside {
            let edge = MeshEdge { ends, open: is_open(&ends, &beside, &triangles, &vertices), beside };
            for &triangle in &edge.beside {
                let Triangle { corners, facet, edges: own } = &mut triangles[triangle];
                if let Core::Polytope(polytope) = &mut facet.shape.core {
                    let same = |local: [usize; 2]| local.map(|end| corners[end]).iter().all(|end| ends.contains(end));
                    let place = polytope.edges.iter().position(|edge| same(edge.ends)).unwrap_or(0);
                    polytope.edges[place].open = edge.open;
                    own[place] = edges.len();
                }
            }
            ends.iter().for_each(|&end| around[end].push(edges.len()));
            edges.push(edge);
        }
        let boxes: Vec<Aabb> = triangles.iter().map(|triangle| bounds(&triangle.facet.shape)).collect();
        let tree = Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes);
        let reach = vertices.iter().map(|vertex| vertex.norm()).fold(0.0, f64::max);
        let open = around.iter().map(|edges_at| edges_at.iter().any(|&edge| edges[edge].open)).collect();
        Ok(Mesh { parts: Arc::new(Parts { vertices, triangles, edges, around, open, tree, reach }) })
    }

    /// Distance of its farthest vertex from the origin of the body (m).
    pub fn reach(&self) -> f64 {
        self.parts.reach
    }

    /// Its lengths as an obstacle.
    pub fn lengths(&self) -> Lengths {
        let Parts { vertices, triangles, reach, .. } = &*self.parts;
        let middle = vertices.iter().sum::<Vector3<f64>>() / vertices.len() as f64;
        let whole = vertices.iter().map(|vertex| (vertex - middle).norm()).fold(0.0, f64::max);
        let part = triangles.iter().map(|triangle| triangle.facet.shape.size).fold(0.0, f64::max);
        Lengths { place: *reach, whole, part }
    }

    /// A feature, in the frame of its body; features are numbered through the whole mesh.
    pub fn part(&self, feature: FeatureId) -> Part {
        let parts = &self.parts;
        match feature {
            FeatureId::Edge(number) => {
                Part::Line(parts.edges[number as usize].ends.map(|end| parts.vertices[end]), 0.0)
            }
            FeatureId::EdgePoint { edge, part } => {
                let [from, to] = parts.edges[edge as usize].ends.map(|end| parts.vertices[end]);
                Part::Point(from + (to - from) * f64::from_bits(part))
            }
            FeatureId::Vertex(number) => Part::Point(parts.vertices[number as usize]),
            FeatureId::Face(number) => {
                let (triangle, normal) = self.face(number);
                Part::Plane(parts.vertices[triangle.corners[0]], normal)
            }
            _ => Part::Point(parts.vertices[0]),
        }
    }

    /// The triangle of a face, and the unit normal out of that side of it.
    fn face(&self, number: u32) -> (&Triangle, Vector3<f64>) {
        let triangles = &self.parts.triangles;
        let (number, count) = (number as usize, triangles.len());
        let triangle = &triangles[number % count];
        (triangle, if number < count { triangle.facet.normal } else { -triangle.facet.normal })
    }

    /// How far inside the bounds of a feature a point on it is (m).
    pub fn inside(&self, feature: FeatureId, point: &Vector3<f64>) -> f64 {
        match feature {
            FeatureId::Face(number) => inside(&self.face(number).0.facet.shape.core, FeatureId::Face(0), point),
            FeatureId::Edge(number) => {
                let [from, to] = self.parts.edges[number as usize].ends.map(|end| self.parts.vertices[end]);
                let along = (to - from).normalize();
                along.dot(&(point - from)).min(along.dot(&(to - point)))
            }
            _ => f64::INFINITY,
        }
    }

    /// How far inside the region of an edge a point off the mesh is, by the planes to the triangles beside it (m).
    pub fn off_neighbours(&self, feature: FeatureId, point: &Vector3<f64>) -> f64 {
        let FeatureId::Edge(number) = feature else { return f64::INFINITY };
        let edge = &self.parts.edges[number as usize];
        let beside = |&triangle: &usize| -self.inward(edge, triangle).dot(&(point - self.parts.vertices[edge.ends[0]]));
        edge.beside.iter().map(beside).fold(f64::INFINITY, f64::min)
    }

    /// The unit vector in the plane of a triangle from its edge inward.
    fn inward(&self, edge: &MeshEdge, triangle: usize) -> Vector3<f64> {
        let triangle = &self.parts.triangles[triangle];
        let from = self.parts.vertices[edge.ends[0]];
        let across = triangle.facet.normal.cross(&(self.parts.vertices[edge.ends[1]] - from)).normalize();
        let third = triangle.corners.iter().find(|corner| !edge.ends.contains(corner));
        let towards = third.map_or(1.0, |&third| across.dot(&(self.parts.vertices[third] - from)).signum());
        across * towards
    }

    /// The nearest points of the surface and a convex core whose frame has this rotation and translation (m) in the frame of the mesh.
    pub fn nearest(&self, b: &Convex, rotation: &Matrix3<f64>, translation: &Vector3<f64>) -> Option<Candidate> {
        self.nearest_of(b, rotation, translation, Ball::of(b, rotation, translation))
    }

    /// The same, of a ball in closed form if it is known to be one.
    fn nearest_of(
        &self,
        b: &Convex,
        rotation: &Matrix3<f64>,
        translation: &Vector3<f64>,
        ball: Option<Ball>,
    ) -> Option<Candidate> {
        if !translation.iter().chain(rotation).all(|entry| entry.abs() < 1e150) {
            return None;
        }
        let centre = rotation * b.centre + translation;
        let mut best: Option<Candidate> = None;
        // Boxes that grow about the shape until one holds a triangle that is nearer than its border.
        let mut margin = 0.1 * b.size;
        loop {
            let region = about(&centre, b.size + margin);
            let mut all: Vec<u32> = self.parts.tree.intersect_aabb(&region).collect();
            all.sort_unstable();
            for number in all.iter().map(|&number| number as usize) {
                let candidate = match (&ball, best) {
                    (Some(ball), _) => {
                        let most = best.map_or(f64::INFINITY, |found| found.distance());
                        let found = ball.nearest(&self.parts.triangles[number].facet, most);
                        found.map(|candidate| self.named(number, candidate))
                    }
                    (None, Some(found)) if self.gap_over(number, b, rotation, translation) > found.distance() => None,
                    (None, _) => self.ask(number, b, rotation, translation),
                };
                let Some(candidate) = candidate else { continue };
                if best.is_none_or(|found| candidate.distance() < found.distance()) {
                    best = Some(candidate);
                }
            }
            let reached = best.is_some_and(|found| found.distance() <= margin + b.radius);
            if reached || all.len() == self.parts.triangles.len() {
                return best;
            }
            margin *= 4.0;
        }
    }

    /// All places of the surface and a convex shape whose gap is below a bound (m).
    pub fn manifold(
        &self,
        b: &Convex,
        rotation: &Matrix3<f64>,
        translation: &Vector3<f64>,
        near: f64,
    ) -> Vec<Candidate> {
        self.manifold_of(b, (rotation, translation), near, Ball::of(b, rotation, translation))
    }

    /// The same, of a ball in closed form if it is known to be one.
    fn manifold_of(
        &self,
        b: &Convex,
        (rotation, translation): (&Matrix3<f64>, &Vector3<f64>),
        near: f64,
        ball: Option<Ball>,
    ) -> Vec<Candidate> {
        let centre = rotation * b.centre + translation;
        let region = about(&centre, b.size + near.max(0.0));
        let mut all: Vec<u32> = self.parts.tree.intersect_aabb(&region).collect();
        all.sort_unstable();
        let mut found = Vec::new();
        if let Some(ball) = ball {
            for number in all.into_iter().map(|number| number as usize) {
                self.add_places_of_ball(number, &ball, near, &mut found);
            }
            return self.distinct(found, b);
        }
        for number in all {
            if self.gap_over(number as usize, b, rotation, translation) - b.radius >= near {
                continue;
            }
            let triangle = &self.parts.triangles[number as usize];
            let both = Both { a: &triangle.facet.shape, b, rotation: *rotation, translation: *translation };
            let Some(closest) = nearest(&both) else { continue };
            let named = |candidate: Candidate| self.named(number as usize, candidate);
            let along = |closest: Candidate| -> Vec<Candidate> {
                let places = manifold_along(&both, closest, near).into_iter().map(named);
                places.filter(|candidate| self.may_touch(candidate)).collect()
            };
            let mut places = along(closest);
            // A corner that is deeper behind a triangle than it is away from its side leaves it soonest across that side, where the neighbour is in its way.
            if places.is_empty() && closest.distance() < -FLAT * both.size() {
                let through = through_face(&both, &closest);
                places = along(through);
                if places.is_empty() {
                    places.push(named(through));
                }
            }
            found.append(&mut places);
        }
        self.distinct(found, b)
    }

    /// Adds the places of a triangle and a ball whose gap is below a bound (m).
    fn add_places_of_ball(&self, number: usize, ball: &Ball, near: f64, found: &mut Vec<Candidate>) {
        let Triangle { corners, facet, edges } = &self.parts.triangles[number];
        let is_open = |feature: FeatureId| match feature {
            FeatureId::Edge(side) => self.parts.edges[edges[side as usize]].open,
            FeatureId::Vertex(vertex) => self.parts.open[corners[vertex as usize]],
            _ => true,
        };
        ball.places(facet, near, is_open, |candidate| {
            let candidate = self.named(number, candidate);
            found.extend(Some(candidate).filter(|candidate| self.may_touch(candidate)));
        });
    }

    /// Places without doubles and without the inner ones, faces first, and of overlaps the deepest.
    fn distinct(&self, mut found: Vec<Candidate>, b: &Convex) -> Vec<Candidate> {
        let deep = |one: &Candidate| one.distance().min(-FLAT * b.size);
        let is_face = |one: &Candidate| matches!(one.features[0], FeatureId::Face(_));
        found.sort_by(|one, other| is_face(other).cmp(&is_face(one)).then(deep(one).total_cmp(&deep(other))));
        take_doubles(&mut found, 1e-7 * b.size, [0.0, b.radius]);
        without_inner(&mut found, 1e-12 * b.size);
        found
    }

    /// Whether no triangle that may be nearer to a convex core than `within` (m) rises over a plane, with this normal and through `foot`, by more than
    /// `most` (m).
    pub fn is_below(
        &self,
        b: &Convex,
        (rotation, translation): (&Matrix3<f64>, &Vector3<f64>),
        [normal, foot]: [&Vector3<f64>; 2],
        [within, most]: [f64; 2],
    ) -> bool {
        let centre = rotation * b.centre + translation;
        let Parts { vertices, triangles, tree, .. } = &*self.parts;
        let region = about(&centre, b.size + within);
        let mut corners = tree.intersect_aabb(&region).flat_map(|number| triangles[number as usize].corners);
        corners.all(|corner| normal.dot(&(vertices[corner] - foot)) <= most)
    }

    /// A length that a triangle and a core are at least apart (m): the largest separation along its normal and straight out of its sides.
    fn gap_over(&self, number: usize, b: &Convex, rotation: &Matrix3<f64>, translation: &Vector3<f64>) -> f64 {
        let triangle = &self.parts.triangles[number];
        let both = Both { a: &triangle.facet.shape, b, rotation: *rotation, translation: *translation };
        let [one, two, three] = triangle.corners.map(|corner| self.parts.vertices[corner]);
        let sides = [two - one, three - two, one - three].map(|side| side.cross(&triangle.facet.normal).normalize());
        let normals = [triangle.facet.normal, -triangle.facet.normal].into_iter().chain(sides);
        normals.map(|normal| both.separation(&normal)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// The nearest points of one triangle and a convex core.
    fn ask(&self, number: usize, b: &Convex, rotation: &Matrix3<f64>, translation: &Vector3<f64>) -> Option<Candidate> {
        let triangle = &self.parts.triangles[number];
        let both = Both { a: &triangle.facet.shape, b, rotation: *rotation, translation: *translation };
        nearest(&both).map(|candidate| self.named(number, candidate))
    }

    /// A candidate of one triangle with the name that its feature has in the whole mesh.
    fn named(&self, number: usize, candidate: Candidate) -> Candidate {
        let triangle = &self.parts.triangles[number];
        let name = match candidate.features[0] {
            FeatureId::Edge(edge) => FeatureId::Edge(triangle.edges[edge as usize] as u32),
            FeatureId::EdgePoint { edge, part } => self.named_point(triangle, edge as usize, f64::from_bits(part)),
            FeatureId::Vertex(vertex) => FeatureId::Vertex(triangle.corners[vertex as usize] as u32),
            FeatureId::Face(side) => FeatureId::Face((number + side as usize * self.parts.triangles.len()) as u32),
            other => other,
        };
        Candidate { features: [name, candidate.features[1]], ..candidate }
    }

    /// The name in the whole mesh of the point at a part of an edge of a triangle.
    fn named_point(&self, triangle: &Triangle, edge: usize, part: f64) -> FeatureId {
        let number = triangle.edges[edge];
        let start = triangle.corners[triangle.facet.ends[edge][0]];
        let part = if self.parts.edges[number].ends[0] == start { part } else { 1.0 - part };
        FeatureId::EdgePoint { edge: number as u32, part: part.to_bits() }
    }

    /// Whether the surface can be touched there with that normal.
    fn may_touch(&self, candidate: &Candidate) -> bool {
        let normal = &candidate.normal;
        match candidate.features[0] {
            FeatureId::Face(number) => normal.dot(&self.face(number).1) > 0.0,
            FeatureId::Edge(number) | FeatureId::EdgePoint { edge: number, .. } => {
                let edge = &self.parts.edges[number as usize];
                edge.open && edge.beside.iter().all(|&triangle| self.inward(edge, triangle).dot(normal) <= ALONG)
            }
            FeatureId::Vertex(number) => {
                let own = number as usize;
                let edges = || self.parts.around[own].iter().map(|&edge| &self.parts.edges[edge]);
                let along = |edge: &MeshEdge| {
                    let other = if edge.ends[0] == own { edge.ends[1] } else { edge.ends[0] };
                    (self.parts.vertices[other] - self.parts.vertices[own]).normalize()
                };
                edges().any(|edge| edge.open) && edges().map(along).all(|along| along.dot(normal) <= ALONG)
            }
            _ => false,
        }
    }

    /// What the general search finds of any shape, for tests: the nearest points, and all places.
    #[cfg(test)]
    pub fn in_general(
        &self,
        b: &Convex,
        at: (&Matrix3<f64>, &Vector3<f64>),
        near: f64,
    ) -> (Option<Candidate>, Vec<Candidate>) {
        (self.nearest_of(b, at.0, at.1, None), self.manifold_of(b, at, near, None))
    }

    /// Which edges can be touched, for tests.
    #[cfg(test)]
    pub fn open_edges(&self) -> usize {
        self.parts.edges.iter().filter(|edge| edge.open).count()
    }
}

/// A triangle that a core pierces: the farthest point of the core behind the side from which it is less deep, and a point of the triangle.
fn through_face(both: &Both, closest: &Candidate) -> Candidate {
    let behind = |(normal, side): (Vector3<f64>, u32)| {
        let farthest = supports(both, (both.separation(&normal), normal));
        let features = [FeatureId::Face(side), farthest.features[1]];
        Candidate { features, points: [closest.points[0], farthest.points[1]], ..farthest }
    };
    let sides = normals(&both.a.core).zip(0..).map(behind);
    sides.max_by(|one, other| one.separation.total_cmp(&other.separation)).unwrap_or(*closest)
}

/// Whether an edge can be touched: it is convex, concave, a border, or has more than two triangles.
fn is_open(ends: &[usize; 2], beside: &[usize], triangles: &[Triangle], vertices: &[Vector3<f64>]) -> bool {
    let [one, other] = beside else { return true };
    let third = triangles[*other].corners.iter().find(|corner| !ends.contains(corner));
    let Some(&third) = third else { return false };
    let (triangle, size) = (&triangles[*one], triangles[*one].facet.shape.size.max(triangles[*other].facet.shape.size));
    triangle.facet.normal.dot(&(vertices[third] - vertices[ends[0]])).abs() > FLAT * size
}
