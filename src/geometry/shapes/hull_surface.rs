//! The surface of a convex hull as triangles, for drawing: its faces as fans.
//!
//! A face with the corners c₀ … c_k, counterclockwise from outside, is the triangles (c₀, c_i, c_{i+1}) for i = 1 … k − 1. It is convex, so they
//! cover it once.

use crate::shapes::error::GeometryError;
use crate::shapes::hull::convex_hull;
use crate::shapes::polytope::{Face, Polytope};
use catena_mechanism::description::contact::Surface;
use nalgebra::Vector3;

/// The surface of the convex hull of points (m), counterclockwise from outside.
///
/// # Errors
/// [`GeometryError`] for points on a line, or nearly in a plane; points in a plane have both faces of a plate.
pub fn hull_surface(points: &[Vector3<f64>]) -> Result<Surface, GeometryError> {
    let hull = convex_hull(points)?;
    let triangles = fans(&hull).map(|corners| corners.map(|corner| corner as u32)).collect();
    Ok(Surface { vertices: hull.vertices, triangles })
}

/// The faces of a polytope as triangles, by the numbers of their corners.
pub(crate) fn fans(polytope: &Polytope) -> impl Iterator<Item = [usize; 3]> {
    polytope
        .faces
        .iter()
        .flat_map(|Face { corners, .. }| corners.windows(2).skip(1).map(|pair| [corners[0], pair[0], pair[1]]))
}

#[cfg(test)]
mod tests {
    use super::hull_surface;
    use nalgebra::Vector3;

    #[test]
    fn the_triangles_of_a_hull_enclose_its_volume_and_look_outwards() {
        // A cube of edge 2 with a point inside, and a pyramid of height 3 on a unit square.
        let cube = (0..8).map(|k| [0, 1, 2].map(|axis| if k >> axis & 1 == 1 { 1.0 } else { -1.0 }));
        let cube: Vec<Vector3<f64>> = cube.map(Vector3::from).chain([Vector3::new(0.1, 0.2, 0.3)]).collect();
        let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let pyramid: Vec<Vector3<f64>> = square.into_iter().chain([[0.5, 0.5, 3.0]]).map(Vector3::from).collect();
        for (points, volume, count) in [(cube, 8.0, 12), (pyramid, 1.0, 6)] {
            let surface = hull_surface(&points).expect("a hull");
            assert_eq!(surface.triangles.len(), count);
            let sixfold = surface.triangles.iter().map(|corners| {
                let [a, b, c] = corners.map(|corner| surface.vertices[corner as usize]);
                a.dot(&b.cross(&c))
            });
            // Products of small whole numbers, a few roundings. The sum is negative for triangles that look inwards.
            assert!((sixfold.sum::<f64>() / 6.0 - volume).abs() < 1e-14, "{surface:?}");
        }
    }

    #[test]
    fn a_plate_has_both_of_its_faces_and_points_on_a_line_have_no_surface() {
        let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]].map(Vector3::from);
        let surface = hull_surface(&square).expect("a plate");
        let areas = surface.triangles.iter().map(|corners| {
            let [a, b, c] = corners.map(|corner| surface.vertices[corner as usize]);
            0.5 * (b - a).cross(&(c - a)).z
        });
        let (up, down): (Vec<f64>, Vec<f64>) = areas.partition(|area| *area > 0.0);
        // Areas of halves of a unit square have no roundings.
        assert_eq!((up.iter().sum::<f64>(), down.iter().sum::<f64>()), (1.0, -1.0));
        let line = [0.0, 1.0, 2.0, 3.0].map(|x| Vector3::new(x, 0.0, 0.0));
        assert!(hull_surface(&line).is_err());
    }
}
