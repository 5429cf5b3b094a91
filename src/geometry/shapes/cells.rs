//! Exact convex pieces of a closed surface with few planes: its hull, cut along the planes of the surface until no triangle is inside of a cell.
//!
//! A cell that contains parts of the surface in its interior is cut along the plane of one of them, the one that cuts the fewest others. A cell
//! without any lies inside or outside of the surface as a whole, by the winding number of its middle c:
//!
//! ```text
//!     w(c) = Σ Ω/4π,     tan(Ω/2) = a · (b × c) / (abc + (a·b) c + (b·c) a + (c·a) b)        a, b, c from the middle to the corners of a triangle
//! ```
//!
//! Cells inside whose hull encloses as much as both are joined again. The pieces have the vertices of the surface as they are, and points where its
//! edges go through planes of others, exact to rounding. They do not overlap, and together enclose the same volume as the surface.
//!
//! Source: B. Chazelle, Convex partitions of polyhedra, SIAM Journal on Computing 13 (1984): cuts along the planes of notches. A. van Oosterom, J.
//! Strackee, The solid angle of a plane triangle, IEEE Transactions on Biomedical Engineering 30 (1983).

use crate::shapes::hull::convex_hull;
use crate::shapes::hull_surface::fans;
use crate::shapes::plane::across;
use crate::shapes::polytope::Polytope;
use catena_mechanism::description::contact::Surface;
use nalgebra::Vector3;

/// On a plane by rounding, relative to the size of the surface.
const ON: f64 = 1e-9;
/// Volumes that differ by less than this part are the same.
const SAME_VOLUME: f64 = 1e-7;
/// No more cells are made, inside and outside together, and no surface with more triangles is cut.
const MOST_CELLS: usize = 1024;
const MOST_TRIANGLES: usize = 4096;

/// The plane `n · p = offset`.
#[derive(Clone, Copy, Debug)]
struct Plane {
    normal: Vector3<f64>,
    /// m.
    offset: f64,
}

/// A polygon of the surface and the plane that it lies in, by number.
#[derive(Clone, Debug)]
struct Fragment {
    points: Vec<Vector3<f64>>,
    plane: usize,
}

/// A convex cell by its faces, counterclockwise from outside, with the parts of the surface in its interior.
#[derive(Clone, Debug)]
struct Cell {
    faces: Vec<Vec<Vector3<f64>>>,
    within: Vec<Fragment>,
}

impl Plane {
    fn height(&self, point: &Vector3<f64>) -> f64 {
        self.normal.dot(point) - self.offset
    }
}

/// The convex pieces of a closed surface with this hull, each by its corners (m); `None` if they are more than wanted, or if the surface has too many
/// planes.
pub fn exact_pieces(surface: &Surface, hull: &Polytope, most: usize) -> Option<Vec<Vec<Vector3<f64>>>> {
    if surface.triangles.len() > MOST_TRIANGLES {
        return None;
    }
    let middle = hull.vertices.iter().sum::<Vector3<f64>>() / hull.vertices.len() as f64;
    let on = ON * hull.vertices.iter().map(|vertex| (vertex - middle).norm()).fold(0.0, f64::max);
    let triangles: Vec<[Vector3<f64>; 3]> =
        surface.triangles.iter().map(|corners| corners.map(|corner| surface.vertices[corner as usize])).collect();
    let (planes, within) = fragments(&triangles, hull, on);
    let faces = hull.faces.iter().map(|face| face.corners.iter().map(|&corner| hull.vertices[corner]).collect());
    let mut open = vec![Cell { faces: faces.collect(), within }];
    let (mut inside, mut made) = (Vec::new(), 1);
    while let Some(cell) = open.pop() {
        match cell.cutting(&planes, on) {
            Some(plane) => {
                open.extend(cell.cut(&planes, plane, on));
                made += 1;
            }
            None if cell.is_inside(&triangles) => inside.push(cell.corners(on)),
            None => {}
        }
        if made > MOST_CELLS {
            return None;
        }
    }
    let pieces = joined(inside, on)?;
    (pieces.len() <= most).then_some(pieces)
}

/// The planes of triangles, and the triangles that do not lie in a face of the hull; points nearer than `on` (m) to a plane lie in it.
fn fragments(triangles: &[[Vector3<f64>; 3]], hull: &Polytope, on: f64) -> (Vec<Plane>, Vec<Fragment>) {
    let mut planes: Vec<Plane> = Vec::new();
    let mut within = Vec::new();
    let on_hull = |points: &[Vector3<f64>; 3]| {
        let in_face =
            |normal: &Vector3<f64>, at: &Vector3<f64>| points.iter().all(|p| normal.dot(&(p - at)).abs() <= on);
        hull.faces.iter().any(|face| in_face(&face.normal, &hull.vertices[face.corners[0]]))
    };
    for points in triangles.iter().filter(|points| !on_hull(points)) {
        let [a, b, c] = points;
        let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
        // A triangle thinner than a rounding has no plane.
        let Some(normal) = (b - a).cross(&(c - a)).try_normalize(on * longest) else { continue };
        let plane = Plane { normal, offset: normal.dot(a) };
        let known = planes.iter().position(|known| {
            points.iter().all(|point| known.height(point).abs() <= on) && known.normal.cross(&normal).norm() < 1e-6
        });
        let number = known.unwrap_or_else(|| {
            planes.push(plane);
            planes.len() - 1
        });
        within.push(Fragment { points: points.to_vec(), plane: number });
    }
    (planes, within)
}

/// The part of a polygon below a plane, and the part above; points in the plane are in neither.
fn clip(points: &[Vector3<f64>], plane: &Plane, on: f64) -> [Vec<Vector3<f64>>; 2] {
    let heights: Vec<f64> = points.iter().map(|point| plane.height(point)).collect();
    let mut parts = [Vec::new(), Vec::new()];
    for (number, (point, &height)) in points.iter().zip(&heights).enumerate() {
        if height <= on {
            parts[0].push(*point);
        }
        if height >= -on {
            parts[1].push(*point);
        }
        let next = (number + 1) % points.len();
        if height.min(heights[next]) < -on && height.max(heights[next]) > on {
            let crossing = point + (points[next] - point) * (height / (height - heights[next]));
            parts.iter_mut().for_each(|part| part.push(crossing));
        }
    }
    let reaches = [heights.iter().any(|&height| height < -on), heights.iter().any(|&height| height > on)];
    for (part, reaches) in parts.iter_mut().zip(reaches) {
        if !reaches {
            part.clear();
        }
    }
    parts
}

impl Cell {
    /// The plane that cuts the fewest of the parts of the surface inside, by number; `None` without such parts.
    fn cutting(&self, planes: &[Plane], on: f64) -> Option<usize> {
        let mut numbers: Vec<usize> = self.within.iter().map(|fragment| fragment.plane).collect();
        numbers.sort_unstable();
        numbers.dedup();
        let cuts = |&number: &usize| {
            let is_cut =
                |fragment: &&Fragment| clip(&fragment.points, &planes[number], on).iter().all(|part| !part.is_empty());
            self.within.iter().filter(is_cut).count()
        };
        numbers.into_iter().min_by_key(cuts)
    }

    /// The two cells below and above a plane.
    fn cut(self, planes: &[Plane], number: usize, on: f64) -> Vec<Cell> {
        let plane = &planes[number];
        let mut parts = [0, 1].map(|_| Cell { faces: Vec::new(), within: Vec::new() });
        for face in &self.faces {
            for (part, clipped) in parts.iter_mut().zip(clip(face, plane, on)) {
                part.faces.extend((!clipped.is_empty()).then_some(clipped));
            }
        }
        let in_plane =
            parts.iter().flat_map(|part| part.faces.iter().flatten()).filter(|p| plane.height(p).abs() <= on);
        let cap = ordered(in_plane.copied().collect(), &plane.normal, on);
        for fragment in self.within {
            if fragment.plane == number {
                continue;
            }
            for (part, points) in parts.iter_mut().zip(clip(&fragment.points, plane, on)) {
                part.within.extend((!points.is_empty()).then_some(Fragment { points, plane: fragment.plane }));
            }
        }
        let [below, above] = &mut parts;
        above.faces.push(cap.iter().rev().copied().collect());
        below.faces.push(cap);
        parts.into_iter().filter(|part| part.faces.len() > 3).collect()
    }

    /// Its corners, each once.
    fn corners(&self, on: f64) -> Vec<Vector3<f64>> {
        distinct(self.faces.iter().flatten().copied(), on)
    }

    /// Whether its middle is inside of the surface of triangles.
    fn is_inside(&self, triangles: &[[Vector3<f64>; 3]]) -> bool {
        let count = self.faces.iter().map(Vec::len).sum::<usize>() as f64;
        let middle = self.faces.iter().flatten().sum::<Vector3<f64>>() / count;
        let half_angle = |corners: &[Vector3<f64>; 3]| {
            let [a, b, c] = corners.map(|corner| corner - middle);
            let [long_a, long_b, long_c] = [a.norm(), b.norm(), c.norm()];
            let below = long_a * long_b * long_c + a.dot(&b) * long_c + b.dot(&c) * long_a + c.dot(&a) * long_b;
            a.dot(&b.cross(&c)).atan2(below)
        };
        // Ω/2 sums up to 2π w; a surface that is inside out has w = −1.
        triangles.iter().map(half_angle).sum::<f64>().abs() > std::f64::consts::PI
    }
}

/// Points, each once.
fn distinct(points: impl Iterator<Item = Vector3<f64>>, on: f64) -> Vec<Vector3<f64>> {
    let mut kept: Vec<Vector3<f64>> = Vec::new();
    for point in points {
        if !kept.iter().any(|other| (other - point).norm() <= 4.0 * on) {
            kept.push(point);
        }
    }
    kept
}

/// The corners of a convex polygon in a plane, counterclockwise about its normal.
fn ordered(points: Vec<Vector3<f64>>, normal: &Vector3<f64>, on: f64) -> Vec<Vector3<f64>> {
    let mut corners = distinct(points.into_iter(), on);
    let middle = corners.iter().sum::<Vector3<f64>>() / corners.len().max(1) as f64;
    let (x, y) = across(normal);
    let angle = |point: &Vector3<f64>| y.dot(&(point - middle)).atan2(x.dot(&(point - middle)));
    corners.sort_by(|one, other| angle(one).total_cmp(&angle(other)));
    corners
}

/// Volume of the hull of points (m³).
fn volume(points: &[Vector3<f64>]) -> Option<f64> {
    let hull = convex_hull(points).ok()?;
    let at = |corner: usize| hull.vertices[corner] - hull.vertices[0];
    let sixfold = |[a, b, c]: [Vector3<f64>; 3]| a.dot(&b.cross(&c));
    Some(fans(&hull).map(|corners| sixfold(corners.map(at))).sum::<f64>() / 6.0)
}

/// Joins cells, each given by its corners, whose union is convex, until no such pair remains.
fn joined(cells: Vec<Vec<Vector3<f64>>>, on: f64) -> Option<Vec<Vec<Vector3<f64>>>> {
    let mut pieces =
        cells.into_iter().map(|points| volume(&points).map(|size| (points, size))).collect::<Option<Vec<_>>>()?;
    let mut first = 0;
    while first < pieces.len() {
        let together = |second: usize| {
            let [(one, size), (other, more)] = [&pieces[first], &pieces[second]];
            let shared = one.iter().filter(|point| other.iter().any(|place| (*point - place).norm() <= 4.0 * on));
            // Convex unions have a whole face of both in common.
            if shared.count() < 3 {
                return None;
            }
            let points = distinct(one.iter().chain(other).copied(), on);
            let whole = volume(&points)?;
            (whole <= (size + more) * (1.0 + SAME_VOLUME)).then_some((second, points, whole))
        };
        match (first + 1..pieces.len()).find_map(together) {
            Some((second, points, whole)) => {
                pieces.remove(second);
                pieces[first] = (points, whole);
                // An earlier cell may fit the joined one now.
                first = 0;
            }
            None => first += 1,
        }
    }
    // Points that are inside an edge or a face of a joined piece are no corners of it.
    pieces.into_iter().map(|(points, _)| convex_hull(&points).ok().map(|hull| hull.vertices)).collect()
}
