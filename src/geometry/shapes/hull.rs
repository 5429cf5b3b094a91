//! The convex hull of points, as a polytope whose coplanar triangles are merged into faces.
//!
//! The triangles are parry's (quickhull). Two that meet in an edge belong to one face if the opposite vertex of either lies within
//! 1e-10 of the size in the plane of the other. Points in one plane make a plate without thickness, with two faces.

use crate::shapes::error::GeometryError;
use crate::shapes::plane::{across, corners};
use crate::shapes::polytope::{Face, Polytope};
use catena_mechanism::description::contact::Surface;
use nalgebra::{Matrix3, Vector3};
use parry3d_f64::math::Vector;
use parry3d_f64::transformation::try_convex_hull;
use std::collections::BTreeMap;

/// Meshes of more triangles take too long.
const MOST_TRIANGLES: usize = 2_000_000;
/// Hulls of more points take too long.
const MOST_POINTS: usize = 1_000_000;
/// Flat, relative to the size.
const FLAT: f64 = 1e-7;
/// In one plane, relative to the size.
const COPLANAR: f64 = 1e-10;
/// In one plane to rounding, relative to the size.
const PLANE: f64 = 1e-14;

/// The convex hull of points (m).
pub fn convex_hull(points: &[Vector3<f64>]) -> Result<Polytope, GeometryError> {
    check_points(points)?;
    if points.len() < 3 {
        return Err(GeometryError::FewPoints { count: points.len() });
    }
    let middle = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
    let size = points.iter().map(|point| (point - middle).norm()).fold(0.0, f64::max);
    let (normal, thickness) = plane(points, &middle);
    if thickness <= FLAT * size {
        let plate = if thickness <= PLANE * size { plate(points, &normal, size) } else { None };
        return plate.ok_or(GeometryError::Flat { thickness });
    }
    // In units of the size, because parry's tolerances are absolute.
    let unit: Vec<Vector> =
        points.iter().map(|point| (point - middle) / size).map(|p| Vector::new(p.x, p.y, p.z)).collect();
    let hull = try_convex_hull(&unit).map_err(|error| GeometryError::Hull { reason: error.to_string() })?;
    let (vertices, triangles) = hull;
    // Exactly the points that were given, because a place that is scaled forth and back differs in the last digit.
    let vertices = given(&vertices, &unit).into_iter().map(|number| points[number]).collect();
    merged(vertices, &triangles, size)
}

/// The numbers of the given points that are nearest to the vertices of their hull, the first of equally near ones. Points are checked in the order of
/// their x, from the x of the vertex outwards, as long as x alone allows a nearer one.
fn given(vertices: &[Vector], points: &[Vector]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&one, &other| points[one].x.total_cmp(&points[other].x));
    let nearest = |vertex: &Vector| {
        let mut best = (f64::INFINITY, usize::MAX);
        let mut look = |number: usize| {
            let across = points[number].x - vertex.x;
            let is_near = across * across <= best.0;
            if is_near {
                let square = (points[number] - *vertex).length_squared();
                best = if (square, number) < best { (square, number) } else { best };
            }
            is_near
        };
        let middle = order.partition_point(|&number| points[number].x < vertex.x);
        let _ = order[middle..].iter().all(|&number| look(number));
        let _ = order[..middle].iter().rev().all(|&number| look(number));
        best.1
    };
    vertices.iter().map(nearest).collect()
}

/// All coordinates are finite, and there are not too many of them.
pub fn check_points(points: &[Vector3<f64>]) -> Result<(), GeometryError> {
    if points.len() > MOST_POINTS {
        return Err(GeometryError::TooMany { what: "points", count: points.len(), limit: MOST_POINTS });
    }
    for (vertex, point) in points.iter().enumerate() {
        if let Some(axis) = (0..3).find(|&axis| point[axis].is_nan() || point[axis].abs() >= 1e150) {
            let name = ['x', 'y', 'z'][axis];
            return Err(GeometryError::Coordinate { vertex, axis: name, value: point[axis] });
        }
    }
    Ok(())
}

/// All coordinates are finite, all corners of triangles are there, and there are not too many of them.
pub fn check_surface(surface: &Surface) -> Result<(), GeometryError> {
    check_points(&surface.vertices)?;
    if surface.triangles.len() > MOST_TRIANGLES {
        let count = surface.triangles.len();
        return Err(GeometryError::TooMany { what: "triangles", count, limit: MOST_TRIANGLES });
    }
    let count = surface.vertices.len();
    for (triangle, corners) in surface.triangles.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|&&corner| corner as usize >= count) {
            return Err(GeometryError::Index { triangle, vertex, count });
        }
    }
    Ok(())
}

/// The polygon of points in one plane, with a face on either side; `None` if they lie on a line.
fn plate(points: &[Vector3<f64>], normal: &Vector3<f64>, size: f64) -> Option<Polytope> {
    let (x, y) = across(normal);
    let flat: Vec<Vector3<f64>> = points.iter().map(|point| Vector3::new(x.dot(point), y.dot(point), 0.0)).collect();
    let vertices: Vec<Vector3<f64>> =
        corners(&flat, COPLANAR * size).into_iter().map(|corner| points[corner]).collect();
    let count = vertices.len();
    let doubled = (2..count).map(|last| (vertices[last - 1] - vertices[0]).cross(&(vertices[last] - vertices[0])));
    if count < 3 || doubled.sum::<Vector3<f64>>().norm() <= FLAT * size * size {
        return None;
    }
    let front = Face { normal: *normal, corners: (0..count).collect() };
    let back = Face { normal: -normal, corners: (0..count).rev().collect() };
    Some(Polytope::of_faces(vertices, vec![front, back]))
}

/// The normal of the plane of least squares, and the distance of the farthest point from it (m).
fn plane(points: &[Vector3<f64>], middle: &Vector3<f64>) -> (Vector3<f64>, f64) {
    let size = points.iter().map(|point| (point - middle).amax()).fold(f64::MIN_POSITIVE, f64::max);
    let spread: Matrix3<f64> =
        points.iter().map(|point| (point - middle) / size).map(|arm| arm * arm.transpose()).sum();
    let eigen = spread.symmetric_eigen();
    let normal = eigen.eigenvectors.column(eigen.eigenvalues.imin()).into_owned();
    (normal, points.iter().map(|point| normal.dot(&(point - middle)).abs()).fold(0.0, f64::max))
}

/// The polytope whose faces are the triangles; triangles in one plane are merged.
fn merged(vertices: Vec<Vector3<f64>>, triangles: &[[u32; 3]], size: f64) -> Result<Polytope, GeometryError> {
    let triangles: Vec<[usize; 3]> = triangles.iter().map(|corners| corners.map(|corner| corner as usize)).collect();
    let doubled = |corners: &[usize; 3]| {
        let [a, b, c] = corners.map(|corner| vertices[corner]);
        (b - a).cross(&(c - a))
    };
    let beside = Sides::of(&triangles, vertices.len());
    // The largest triangles begin, so that a face has the plane of its best-known part.
    let areas: Vec<f64> = triangles.iter().map(|corners| doubled(corners).norm()).collect();
    let mut order: Vec<usize> = (0..triangles.len()).collect();
    order.sort_by(|&one, &other| areas[other].total_cmp(&areas[one]));
    let mut face_of = vec![usize::MAX; triangles.len()];
    let mut faces = Vec::new();
    for &first in &order {
        if face_of[first] != usize::MAX {
            continue;
        }
        if areas[first] == 0.0 {
            return Err(GeometryError::Hull { reason: "a face has no area".into() });
        }
        let (normal, own) = (doubled(&triangles[first]) / areas[first], faces.len());
        let on_plane =
            |corner: usize| normal.dot(&(vertices[corner] - vertices[triangles[first][0]])).abs() <= COPLANAR * size;
        face_of[first] = own;
        let mut members = vec![first];
        let mut place = 0;
        while place < members.len() {
            let corners = triangles[members[place]];
            for side in 0..3 {
                let other = beside.of_side(corners[(side + 1) % 3], corners[side]);
                if let Some(other) = other.filter(|&other| face_of[other] == usize::MAX)
                    && triangles[other].iter().all(|&corner| on_plane(corner))
                    && !(areas[other] > 1e-9 * size * size && doubled(&triangles[other]).dot(&normal) < 0.0)
                {
                    face_of[other] = own;
                    members.push(other);
                }
            }
            place += 1;
        }
        match outline(&triangles, &members, normal) {
            Ok(face) => faces.push(face),
            // Slivers leave a hole in it, or hang on it by a corner: each triangle is a face of its own.
            Err(_) if members.iter().all(|&member| areas[member] > 0.0) => {
                for &member in &members {
                    face_of[member] = faces.len();
                    faces.push(outline(&triangles, &[member], doubled(&triangles[member]) / areas[member])?);
                }
            }
            Err(open) => return Err(open),
        }
    }
    let polytope = Polytope::of_faces(without_inner_vertices(vertices, &mut faces), faces);
    match polytope.edges.iter().all(|edge| edge.faces.is_some()) {
        true => Ok(polytope),
        false => Err(GeometryError::Hull { reason: "its surface is not closed".into() }),
    }
}

/// The vertices that are corners of faces, which are told their new numbers. Vertices inside a face that several triangles make lie in its plane to a rounding,
/// and have no edges along which a search could come to them.
fn without_inner_vertices(vertices: Vec<Vector3<f64>>, faces: &mut [Face]) -> Vec<Vector3<f64>> {
    let mut numbers = vec![usize::MAX; vertices.len()];
    faces.iter().flat_map(|face| &face.corners).for_each(|&corner| numbers[corner] = 0);
    let mut kept = Vec::with_capacity(vertices.len());
    for (vertex, number) in vertices.into_iter().zip(&mut numbers).filter(|(_, number)| **number == 0) {
        *number = kept.len();
        kept.push(vertex);
    }
    faces.iter_mut().flat_map(|face| &mut face.corners).for_each(|corner| *corner = numbers[*corner]);
    kept
}

/// The triangles by their directed sides, corner after corner.
struct Sides {
    starts: Vec<usize>,
    /// The second corner of each side, and the number of its triangle.
    all: Vec<(usize, usize)>,
}

impl Sides {
    /// The sides of triangles, whose corners are below a number.
    fn of(triangles: &[[usize; 3]], corners: usize) -> Self {
        let mut starts = vec![0; corners + 1];
        triangles.iter().flatten().for_each(|&corner| starts[corner + 1] += 1);
        for corner in 0..corners {
            starts[corner + 1] += starts[corner];
        }
        let mut places = starts.clone();
        let mut all = vec![(0, 0); 3 * triangles.len()];
        for (number, own) in triangles.iter().enumerate() {
            for side in 0..3 {
                all[places[own[side]]] = (own[(side + 1) % 3], number);
                places[own[side]] += 1;
            }
        }
        Sides { starts, all }
    }

    /// The last triangle with a side from a corner to another.
    fn of_side(&self, from: usize, to: usize) -> Option<usize> {
        let own = &self.all[self.starts[from]..self.starts[from + 1]];
        own.iter().rev().find(|(corner, _)| *corner == to).map(|(_, number)| *number)
    }
}

/// The outline of some triangles in one plane.
fn outline(triangles: &[[usize; 3]], members: &[usize], normal: Vector3<f64>) -> Result<Face, GeometryError> {
    if let &[alone] = members {
        // From its first corner on, as longer outlines.
        let mut corners = triangles[alone];
        let first = (0..3).min_by_key(|&side| corners[side]).unwrap_or_default();
        corners.rotate_left(first);
        return Ok(Face { normal, corners: corners.to_vec() });
    }
    let sides = |&member: &usize| {
        let corners = triangles[member];
        (0..3).map(move |side| (corners[side], corners[(side + 1) % 3]))
    };
    let mut next: BTreeMap<usize, usize> = BTreeMap::new();
    let all: std::collections::BTreeSet<(usize, usize)> = members.iter().flat_map(sides).collect();
    for &(from, to) in all.iter().filter(|(from, to)| !all.contains(&(*to, *from))) {
        next.insert(from, to);
    }
    let open = || GeometryError::Hull { reason: "the outline of a face is not closed".into() };
    let first = *next.keys().next().ok_or_else(open)?;
    let mut corners = vec![first];
    while corners.len() <= next.len() {
        let to = *next.get(&corners[corners.len() - 1]).ok_or_else(open)?;
        if to == first {
            break;
        }
        corners.push(to);
    }
    match corners.len() == next.len() {
        true => Ok(Face { normal, corners }),
        false => Err(open()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points on an ellipsoid, and a flat bottom that many vertices share.
    fn points(count: usize, flat: bool) -> Vec<Vector3<f64>> {
        let golden = 2.399_963_229_728_653;
        (0..count)
            .map(|index| {
                let z = 1.0 - 2.0 * (index as f64 + 0.5) / count as f64;
                let (radius, turn) = ((1.0 - z * z).sqrt(), golden * index as f64);
                let z = if flat { z.max(-0.5) } else { z };
                Vector3::new(0.3 * radius * turn.cos(), 0.2 * radius * turn.sin(), 0.1 * z)
            })
            .collect()
    }

    #[test]
    fn vertices_inside_a_face_are_none_of_the_hull_whose_search_goes_along_edges() {
        // A ball above a disc that is flat to less than what makes one face of its triangles, with points inside it.
        let golden = 2.399_963_229_728_653;
        let round = (0..200).map(|number| {
            let z = (f64::from(number) + 0.5) / 200.0;
            let (radius, turn) = ((1.0 - z * z).sqrt(), golden * f64::from(number));
            Vector3::new(radius * turn.cos(), radius * turn.sin(), z)
        });
        let rim = (0..60).map(|number| {
            let turn = std::f64::consts::TAU * f64::from(number) / 60.0;
            Vector3::new(turn.cos(), turn.sin(), 0.0)
        });
        let inside = (0..40).map(|number| {
            let (radius, turn) = (0.1 + 0.015 * f64::from(number), golden * f64::from(number));
            Vector3::new(radius * turn.cos(), radius * turn.sin(), -2e-11 * f64::from(number % 3))
        });
        let hull = convex_hull(&round.chain(rim).chain(inside).collect::<Vec<_>>()).expect("a hull");
        assert!(hull.neighbours.are_known(), "{} vertices", hull.vertices.len());
        let corners = hull.faces.iter().flat_map(|face| &face.corners);
        let used: std::collections::BTreeSet<usize> = corners.copied().collect();
        assert_eq!(used.len(), hull.vertices.len());
    }

    #[test]
    fn faces_of_one_triangle_begin_at_their_first_corner_as_merged_ones_do_and_turn_about_their_normal() {
        let hull = convex_hull(&points(800, true)).expect("a hull");
        assert!(hull.faces.iter().any(|face| face.corners.len() == 3));
        assert!(hull.faces.iter().any(|face| face.corners.len() > 20));
        for Face { normal, corners } in &hull.faces {
            assert_eq!(corners.iter().min(), corners.first());
            let [a, b, c] = [0, 1, 2].map(|place| hull.vertices[corners[place]]);
            assert!((b - a).cross(&(c - a)).dot(normal) > 0.0);
        }
    }

    #[test]
    fn a_face_around_a_point_that_is_a_little_higher_is_made_of_triangles() {
        // A pyramid upside down: around the middle of its base, which is 1e-9 higher, four more points lie in the base.
        let square = |half: f64| [[-half, -half], [half, -half], [half, half], [-half, half]];
        let corners = square(1.0).into_iter().chain(square(0.1)).map(|[x, y]| Vector3::new(x, y, 0.0));
        let vertices: Vec<Vector3<f64>> =
            corners.chain([Vector3::new(0.0, 0.0, 1e-9), Vector3::new(0.0, 0.0, -1.0)]).collect();
        let around = |side: u32| {
            let next = (side + 1) % 4;
            [[side, next, 4 + next], [side, 4 + next, 4 + side], [4 + side, 4 + next, 8], [next, side, 9]]
        };
        let hull = merged(vertices, &(0..4).flat_map(around).collect::<Vec<_>>(), 1.0).expect("a hull");
        assert_eq!((hull.faces.len(), hull.edges.len()), (16, 24));
        assert!(hull.faces.iter().all(|face| face.corners.len() == 3));
    }

    #[test]
    fn the_walk_finds_the_vertex_that_a_look_at_all_of_them_finds() {
        for flat in [false, true] {
            let hull = convex_hull(&points(800, flat)).expect("a hull");
            assert!(hull.neighbours.are_known());
            for index in 0..2000 {
                let at = f64::from(index);
                let direction = if index % 10 == 0 {
                    // Straight down on the flat side, where many vertices are the lowest but for roundings.
                    Vector3::new(1e-13 * at.sin(), 1e-13 * at.cos(), -1.0)
                } else {
                    Vector3::new((1.7 * at).sin(), (2.3 * at).cos(), (0.9 * at).sin())
                };
                let highest = hull.vertices.iter().map(|vertex| direction.dot(vertex)).fold(f64::MIN, f64::max);
                let found = direction.dot(&hull.vertices[hull.support_vertex(&direction)]);
                assert_eq!(found, highest, "{flat} {index}");
            }
        }
    }
}
