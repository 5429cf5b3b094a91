//! Convex pieces of concave surfaces: exact where their planes are few.

use super::scenes::{at, pair};
use crate::{GeometryError, decompose};
use catena_mechanism::description::contact::{Shape, Surface};
use catena_mechanism::description::joint::Pose;
use nalgebra::{Rotation3, Vector3};
use std::collections::HashMap;
use std::sync::Arc;

/// The surface of the cells of a grid that are filled, between these coordinates (m), in squares of two triangles.
pub fn grid(lines: [&[f64]; 3], filled: impl Fn(usize, usize, usize) -> bool) -> Surface {
    let counts = lines.map(|line| line.len() as i32 - 1);
    let is_filled = |cell: [i32; 3]| {
        (0..3).all(|axis| (0..counts[axis]).contains(&cell[axis])) && {
            let [i, j, k] = cell.map(|number| number as usize);
            filled(i, j, k)
        }
    };
    let mut surface = Surface::default();
    let mut known: HashMap<[i32; 3], u32> = HashMap::new();
    for number in 0..counts.iter().product::<i32>() {
        let cell = [number % counts[0], number / counts[0] % counts[1], number / counts[0] / counts[1]];
        for (axis, side) in (0..3).flat_map(|axis| [(axis, 0), (axis, 1)]) {
            let mut neighbour = cell;
            neighbour[axis] += 2 * side - 1;
            if !is_filled(cell) || is_filled(neighbour) {
                continue;
            }
            let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
            let corner = |one: i32, other: i32| {
                let mut corner = cell;
                corner[axis] += side;
                corner[next] += one;
                corner[last] += other;
                corner
            };
            let mut square = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
            if side == 0 {
                square.reverse();
            }
            let square = square.map(|corner| {
                *known.entry(corner).or_insert_with(|| {
                    surface.vertices.push(Vector3::from_fn(|axis, _| lines[axis][corner[axis] as usize]));
                    surface.vertices.len() as u32 - 1
                })
            });
            surface.triangles.extend([[square[0], square[1], square[2]], [square[0], square[2], square[3]]]);
        }
    }
    surface
}

/// A cup of 0.2 m by 0.2 m by 0.15 m: walls of 0.02 m, and a bottom of 0.03 m that stands on z = 0.
fn cup() -> Surface {
    let across = [-0.1, -0.08, 0.08, 0.1];
    grid([&across, &across, &[0.0, 0.03, 0.15]], |i, j, k| k == 0 || (i, j) != (1, 1))
}

/// A U: a gap of 0.06 m between two arms of 0.07 m, on a base of 0.04 m.
fn fork() -> Surface {
    grid([&[-0.1, -0.03, 0.03, 0.1], &[-0.05, 0.05], &[0.0, 0.04, 0.2]], |i, _, k| k == 0 || i != 1)
}

/// An L.
fn angle() -> Surface {
    grid([&[0.0, 0.05, 0.2], &[-0.05, 0.05], &[0.0, 0.06, 0.2]], |i, _, k| k == 0 || i == 0)
}

/// A round cup with `sides` sides, of the radii 0.1 and 0.08 m, 0.15 m high, with a bottom of 0.03 m.
fn round(sides: u32) -> Surface {
    let ring = |radius: f64, height: f64| {
        let place = move |side: u32| std::f64::consts::TAU * f64::from(side) / f64::from(sides);
        (0..sides).map(move |side| Vector3::new(radius * place(side).cos(), radius * place(side).sin(), height))
    };
    let rings = [ring(0.1, 0.0), ring(0.1, 0.15), ring(0.08, 0.15), ring(0.08, 0.03)];
    let mut vertices: Vec<Vector3<f64>> = rings.into_iter().flatten().collect();
    vertices.extend([Vector3::zeros(), Vector3::z() * 0.03]);
    let mut triangles = Vec::new();
    for side in 0..sides {
        let next = (side + 1) % sides;
        for ring in 0..3 {
            let [a, b, c, d] =
                [ring * sides + side, ring * sides + next, (ring + 1) * sides + next, (ring + 1) * sides + side];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
        triangles.extend([[4 * sides, next, side], [4 * sides + 1, 3 * sides + side, 3 * sides + next]]);
    }
    Surface { vertices, triangles }
}

/// The pieces of a surface, which are exact.
fn exact(surface: &Surface) -> Vec<Vec<Vector3<f64>>> {
    let pieces = decompose(surface, 16).expect("pieces");
    assert!(pieces.exact, "{} approximate pieces", pieces.hulls.len());
    pieces.hulls
}

/// Volume that triangles enclose (m³).
fn enclosed(surface: &Surface) -> f64 {
    let of = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|corner| surface.vertices[corner as usize]);
        a.dot(&b.cross(&c)) / 6.0
    };
    surface.triangles.iter().map(of).sum()
}

/// Volumes of the hulls of pieces (m³).
fn volumes(pieces: &[Vec<Vector3<f64>>]) -> Vec<f64> {
    pieces.iter().map(|piece| enclosed(&crate::shapes::hull_surface::hull_surface(piece).expect("a hull"))).collect()
}

/// How far the nearest of the pieces is from a shape at a place (m).
fn nearest(pieces: &[Vec<Vector3<f64>>], shape: &Shape, place: &Pose) -> f64 {
    let distance = |piece: &Vec<Vector3<f64>>| {
        pair(Shape::Hull(Arc::new(piece.clone())), shape.clone()).distance(&Pose::identity(), place).distance
    };
    pieces.iter().map(distance).fold(f64::INFINITY, f64::min)
}

#[test]
fn pieces_enclose_together_what_the_surface_encloses_wherever_it_is_turned() {
    let turns = [Rotation3::identity(), Rotation3::new(Vector3::new(0.3, -1.1, 0.7))];
    for (name, surface, most) in
        [("cup", cup(), 5), ("fork", fork(), 3), ("angle", angle(), 2), ("round cup", round(24), 49)]
    {
        for turn in turns {
            for size in [1e-3, 1.0, 1e3] {
                let mut surface = surface.clone();
                surface.vertices.iter_mut().for_each(|vertex| *vertex = turn * *vertex * size);
                let pieces = exact(&surface);
                let (sum, wanted) = (volumes(&pieces).iter().sum::<f64>(), enclosed(&surface));
                println!("{name}: {} pieces, {sum} m³ for {wanted} m³", pieces.len());
                assert!((sum - wanted).abs() <= 1e-12 * wanted, "{name}: {sum} m³ for {wanted} m³");
                assert!(pieces.len() <= most, "{name}: {} pieces", pieces.len());
            }
        }
    }
}

#[test]
fn hollows_are_as_deep_and_as_wide_as_those_of_the_surface() {
    let ball = Shape::Sphere { radius: 0.03 };
    let pieces = exact(&cup());
    // Over the bottom, at a wall, and over the mouth, nearest to the inner edge of a wall.
    let over = f64::hypot(0.04, 0.02) - 0.03;
    for (place, wanted) in [([0.0, 0.0, 0.07], 0.01), ([0.045, 0.0, 0.1], 0.005), ([0.0, -0.04, 0.17], over)] {
        let found = nearest(&pieces, &ball, &at(place[0], place[1], place[2]));
        assert!((found - wanted).abs() < 1e-15, "{place:?}: {found} for {wanted}");
    }
    let pieces = exact(&fork());
    // A peg a tenth of a millimetre thinner than the gap.
    let peg = Shape::Box { half: Vector3::new(0.02995, 0.2, 0.05) };
    let found = nearest(&pieces, &peg, &at(0.0, 0.0, 0.1));
    assert!((found - 5e-5).abs() < 1e-15, "{found}");
    let pieces = exact(&round(24));
    let (apothem, place) = (0.08 * (std::f64::consts::PI / 24.0).cos(), Vector3::new(0.04, 0.0, 0.0));
    let turned = Rotation3::from_axis_angle(&Vector3::z_axis(), std::f64::consts::PI / 24.0) * place;
    let found = nearest(&pieces, &ball, &at(turned.x, turned.y, 0.1));
    assert!((found - (apothem - 0.07)).abs() < 1e-14, "{found} for {}", apothem - 0.07);
}

#[test]
fn a_surface_with_very_many_planes_has_approximate_pieces_and_says_so() {
    let pieces = decompose(&round(90), 16).expect("pieces");
    assert!(!pieces.exact && pieces.hulls.len() > 1, "{} pieces", pieces.hulls.len());
}

#[test]
fn what_is_flat_or_not_closed_has_no_pieces() {
    let flat =
        Surface { vertices: vec![Vector3::zeros(), Vector3::x(), Vector3::y()], triangles: vec![[0, 1, 2], [0, 2, 1]] };
    assert_eq!(decompose(&flat, 16), Err(GeometryError::EnclosesNothing));
    for mut surface in [cup(), angle()] {
        surface.triangles.pop();
        assert_eq!(decompose(&surface, 16), Err(GeometryError::Open { edges: 3 }));
    }
}
