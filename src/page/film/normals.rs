//! Normals of meshes: smooth, but for sharp edges.
//!
//! ```text
//!     n_c = Σ_t A_t n_t / |…|     over the triangles t around the corner c with n_t · n ≥ cos 40°
//! ```
//!
//! with the areas A_t (m²) and normals n_t of triangles, and the normal n of the triangle that the corner belongs to. `page/assets/surfaces.js` has the
//! same rule.

use crate::film::primitives::Triangles;
use nalgebra::Vector3;

/// Edges between triangles that are turned by more than this stay sharp: cosine of 40 degrees.
const SHARP: f64 = 0.766;

/// The triangles of a mesh with a normal at each corner; triangles without area are left out.
pub(super) fn creased(corners: &[[f64; 3]], triangles: &[[u32; 3]]) -> Triangles {
    let place = |index: u32| Vector3::from(corners[index as usize]);
    let areas: Vec<Vector3<f64>> = triangles
        .iter()
        .map(|corners| {
            let [a, b, c] = corners.map(place);
            (b - a).cross(&(c - a))
        })
        .collect();
    // The triangles around each corner, in one list: those of the corner k begin at starts[k].
    let mut starts = vec![0usize; corners.len() + 1];
    for corner in triangles.iter().flatten() {
        starts[*corner as usize + 1] += 1;
    }
    for k in 0..corners.len() {
        starts[k + 1] += starts[k];
    }
    let (mut filled, mut around) = (starts.clone(), vec![0usize; 3 * triangles.len()]);
    for (triangle, corners) in triangles.iter().enumerate() {
        for corner in corners {
            around[filled[*corner as usize]] = triangle;
            filled[*corner as usize] += 1;
        }
    }
    let unit = |area: &Vector3<f64>| area.try_normalize(f64::MIN_POSITIVE);
    let with_normals = |(corners, area): (&[u32; 3], &Vector3<f64>)| {
        let own = unit(area)?;
        let normal = |corner: u32| {
            let near = around[starts[corner as usize]..starts[corner as usize + 1]].iter().map(|other| &areas[*other]);
            let sum = near.filter(|other| own.dot(other) >= SHARP * other.norm()).sum::<Vector3<f64>>();
            unit(&sum).unwrap_or(own)
        };
        Some(corners.map(|corner| (place(corner), normal(corner))))
    };
    triangles.iter().zip(&areas).filter_map(with_normals).collect()
}

#[cfg(test)]
mod tests {
    use super::creased;
    use nalgebra::Vector3;

    #[test]
    fn a_ridge_of_sixty_degrees_is_sharp_and_one_of_thirty_smooth() {
        for (degrees, is_smooth) in [(60f64, false), (30.0, true)] {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            // Two squares that share the edge along y.
            let corners = [[-1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [cosine, 0.0, -sine]];
            let triangles = creased(&corners, &[[0, 1, 2], [1, 3, 2]]);
            let at_edge = triangles[0][1].1;
            let between = Vector3::new((0.5 * degrees.to_radians()).sin(), 0.0, (0.5 * degrees.to_radians()).cos());
            let expected = if is_smooth { between } else { Vector3::z() };
            assert!((at_edge - expected).norm() < 1e-12, "{degrees}: {at_edge}");
        }
    }

    #[test]
    fn triangles_without_area_are_left_out() {
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        assert_eq!(creased(&corners, &[[0, 1, 2], [0, 1, 3]]).len(), 1);
    }
}
