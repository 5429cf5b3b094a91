//! A convex polytope: a point, a segment, a box, a hull or a plate, with its vertices, edges and faces.
//!
//! Its support number is `h(n) = max n · v` over the vertices v. Lengths are in m, in the frame of the body.

use crate::shapes::beside::Beside;
use crate::shapes::neighbours::Neighbours;
use nalgebra::Vector3;

/// A straight edge.
#[derive(Clone, Debug, PartialEq)]
pub struct Edge {
    /// Its two vertices.
    pub ends: [usize; 2],
    /// The faces that meet in it; `None` for a segment.
    pub faces: Option<[usize; 2]>,
    /// Whether it can be touched; edges of triangles between which a mesh is flat or concave cannot.
    pub open: bool,
}

/// A flat face.
#[derive(Clone, Debug, PartialEq)]
pub struct Face {
    /// Unit normal out of the body.
    pub normal: Vector3<f64>,
    /// Its vertices, counterclockwise from outside.
    pub corners: Vec<usize>,
}

/// A convex polytope.
#[derive(Clone, Debug, PartialEq)]
pub struct Polytope {
    /// m.
    pub vertices: Vec<Vector3<f64>>,
    /// In the order of their vertices.
    pub edges: Vec<Edge>,
    /// Its faces; empty for points and segments.
    pub faces: Vec<Face>,
    /// The neighbours of its vertices, of one with many.
    pub neighbours: Neighbours,
    /// The edges and faces at its vertices, where neighbours are known.
    pub beside: Beside,
    /// Unit vectors along its edges, one for edges that are parallel; none of a polytope with more than [`FEW`] vertices, and none without faces.
    pub directions: Vec<Vector3<f64>>,
}

/// Polytopes with more vertices have no list of directions.
const FEW: usize = 12;
/// Edges with a smaller sine between them are parallel: their axes differ by less than roundings of lengths.
const PARALLEL: f64 = 1e-12;

impl Polytope {
    /// One point (m).
    pub fn point(at: Vector3<f64>) -> Self {
        Polytope {
            vertices: vec![at],
            edges: Vec::new(),
            faces: Vec::new(),
            neighbours: Neighbours::default(),
            beside: Beside::default(),
            directions: Vec::new(),
        }
    }

    /// The segment between two points (m).
    pub fn segment(ends: [Vector3<f64>; 2]) -> Self {
        Polytope {
            vertices: ends.to_vec(),
            edges: vec![Edge { ends: [0, 1], faces: None, open: true }],
            faces: Vec::new(),
            neighbours: Neighbours::default(),
            beside: Beside::default(),
            directions: Vec::new(),
        }
    }

    /// The polytope of these vertices (m) and faces, each counterclockwise from outside; every edge belongs to two faces.
    pub fn of_faces(vertices: Vec<Vector3<f64>>, faces: Vec<Face>) -> Self {
        let sides = faces.iter().enumerate().flat_map(|(number, face)| {
            let count = face.corners.len();
            (0..count).map(move |place| (face.corners[place], face.corners[(place + 1) % count], number))
        });
        let mut sides: Vec<([usize; 2], usize)> =
            sides.map(|(corner, next, number)| ([corner.min(next), corner.max(next)], number)).collect();
        sides.sort_unstable();
        let edge = |sides: &[([usize; 2], usize)]| Edge {
            ends: sides[0].0,
            faces: (sides.len() == 2).then(|| [sides[0].1, sides[1].1]),
            open: true,
        };
        let edges: Vec<Edge> = sides.chunk_by(|one, other| one.0 == other.0).map(edge).collect();
        let neighbours = Neighbours::new(&vertices, edges.iter().map(|edge| edge.ends));
        let beside = if neighbours.are_known() {
            let ends = edges.iter().map(|edge| &edge.ends[..]);
            Beside::new(vertices.len(), ends, faces.iter().map(|face| &face.corners[..]))
        } else {
            Beside::default()
        };
        let directions = if vertices.len() <= FEW { directions(&vertices, &edges) } else { Vec::new() };
        Polytope { vertices, edges, faces, neighbours, beside, directions }
    }

    /// The triangle with these corners (m), with a face on either side: face 0 is the one that they go round counterclockwise.
    pub fn triangle(corners: [Vector3<f64>; 3], normal: Vector3<f64>) -> Self {
        let front = Face { normal, corners: vec![0, 1, 2] };
        let back = Face { normal: -normal, corners: vec![0, 2, 1] };
        Polytope::of_faces(corners.to_vec(), vec![front, back])
    }

    /// `max n · v` (m) for n of any length.
    pub fn support(&self, normal: &Vector3<f64>) -> f64 {
        if self.neighbours.are_known() {
            return normal.dot(&self.vertices[self.support_vertex(normal)]);
        }
        self.vertices.iter().map(|vertex| normal.dot(vertex)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// The vertex that is farthest along a direction.
    pub fn support_vertex(&self, direction: &Vector3<f64>) -> usize {
        if self.neighbours.are_known() {
            return self.neighbours.support(&self.vertices, direction);
        }
        let mut best = (f64::NEG_INFINITY, 0);
        for (number, vertex) in self.vertices.iter().enumerate() {
            let along = direction.dot(vertex);
            if along > best.0 {
                best = (along, number);
            }
        }
        best.1
    }

    /// How far inside the sides of a face a point is (m): the least distance to them in the plane of the face, negative outside.
    pub fn inside_face(&self, face: usize, point: &Vector3<f64>) -> f64 {
        let Face { normal, corners } = &self.faces[face];
        let side = |place: usize| {
            let (from, to) = (self.vertices[corners[place]], self.vertices[corners[(place + 1) % corners.len()]]);
            let inward = normal.cross(&(to - from));
            inward.dot(&(point - from)) / inward.norm()
        };
        (0..corners.len()).map(side).fold(f64::INFINITY, f64::min)
    }
}

/// Unit vectors along edges between vertices (m), one for those that are parallel.
fn directions(vertices: &[Vector3<f64>], edges: &[Edge]) -> Vec<Vector3<f64>> {
    let mut found: Vec<Vector3<f64>> = Vec::new();
    for edge in edges {
        let along = (vertices[edge.ends[1]] - vertices[edge.ends[0]]).normalize();
        if found.iter().all(|other| other.cross(&along).norm() > PARALLEL) {
            found.push(along);
        }
    }
    found
}
