//! Simple shapes that MuJoCo fits to meshes: a `<geom>` of such a type with a `mesh`.
//!
//! The box with the moments A ≥ B ≥ C of a mesh of the volume V and unit density, about its centre and along its principal axes, has the half sides
//!
//! ```text
//!     a = ½ √(6 (B + C − A)/V),   b = ½ √(6 (C + A − B)/V),   c = ½ √(6 (A + B − C)/V)          a ≤ b ≤ c
//! ```
//!
//! | shape | sizes, times `fitscale` |
//! |---|---|
//! | box, ellipsoid | a, b, c |
//! | sphere | (a + b + c)/3 |
//! | cylinder along the axis of C | r = (a + b)/2, c |
//! | capsule along the axis of C | r = (a + b)/2, c − r/2 |
//!
//! with V in m³, moments in m⁵ and sizes in m. Its frame in the mesh has the centre and these axes.
//!
//! Source: MuJoCo documentation, XML reference, `body/geom/mesh` and `compiler/fitaabb`, and what MuJoCo 4.0 computes.

use crate::scene::error::SceneError;
use crate::scene::mjcf_reading::mass::Solid;
use crate::scene::mjcf_reading::reader::Reader;
use crate::scene::mjcf_reading::tree::Element;
use crate::scene::robot::Pose;
use nalgebra::{Matrix3, Rotation3, Translation3, Vector3};

impl Reader<'_> {
    /// The frame and the sizes of a simple shape that is fitted to a mesh; `None` for a geom without one.
    pub fn fitted(&mut self, geom: &Element, kind: &str) -> Result<Option<(Pose, Vec<f64>)>, SceneError> {
        let Some(name) = geom.text("mesh") else { return Ok(None) };
        if !matches!(kind, "box" | "ellipsoid" | "sphere" | "cylinder" | "capsule") {
            return Ok(None);
        }
        let known = self.meshes.get(name).map(|(mesh, _)| mesh.clone());
        let mesh = known.ok_or_else(|| geom.error("mesh", "there is no such mesh among the assets".to_string()))?;
        let Some(solid) = self.solid(geom, &mesh)? else {
            return Err(geom.error("mesh", format!("it encloses nothing that a {kind} could be fitted to")));
        };
        let scale = geom.number("fitscale")?.unwrap_or(1.0);
        let (frame, half) = box_of(&solid);
        Ok(Some((frame, sizes(kind, &(scale * half)))))
    }
}

/// The frame of the box with the moments of a solid, and its half sides in ascending order.
fn box_of(solid: &Solid) -> (Pose, Vector3<f64>) {
    let axes = solid.inertia.symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|a, b| axes.eigenvalues[*b].total_cmp(&axes.eigenvalues[*a]));
    let [a, b, c] = order.map(|own| axes.eigenvalues[own]);
    let [x, y] = [0, 1].map(|place: usize| axes.eigenvectors.column(order[place]).into_owned());
    let turn = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, y, x.cross(&y)]));
    let half =
        Vector3::new(b + c - a, c + a - b, a + b - c).map(|sum| 0.5 * (6.0 * sum.max(0.0) / solid.volume).sqrt());
    (Pose::from_parts(Translation3::from(solid.center), turn), half)
}

/// The sizes of a shape like a box, as a geom has them.
fn sizes(kind: &str, half: &Vector3<f64>) -> Vec<f64> {
    let radius = 0.5 * (half.x + half.y);
    match kind {
        "sphere" => vec![half.sum() / 3.0],
        "cylinder" => vec![radius, half.z],
        "capsule" => vec![radius, half.z - 0.5 * radius],
        _ => half.as_slice().to_vec(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::mjcf_reading::mass::{Inside, of_triangles};

    #[test]
    fn shapes_fitted_to_a_tetrahedron_are_those_of_mujoco() {
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]].map(Vector3::from);
        let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]].map(|face: [usize; 3]| face.map(|at| corners[at]));
        let (frame, half) = box_of(&of_triangles(&faces, Inside::Exact).expect("a solid"));
        // `geom_size` and `mesh_quat` of MuJoCo 4.0.0, to the digits that it prints.
        for (kind, wanted) in [
            ("box", vec![0.2599943, 0.63965268, 1.047973]),
            ("sphere", vec![0.64920666]),
            ("cylinder", vec![0.44982349, 1.047973]),
            ("capsule", vec![0.44982349, 0.82306125]),
        ] {
            let own = sizes(kind, &half);
            let near = own.iter().zip(&wanted).all(|(own, wanted)| (own - wanted).abs() < 5e-9);
            assert!(own.len() == wanted.len() && near, "{kind}: {own:?}");
        }
        let turn = nalgebra::Quaternion::new(0.97290709, 0.15229177, -0.06801209, 0.16010422);
        let wanted = nalgebra::UnitQuaternion::from_quaternion(turn).to_rotation_matrix().into_inner();
        // Axes may have either direction.
        let between = (wanted.transpose() * frame.rotation.matrix()).map(f64::abs);
        assert!((between - Matrix3::identity()).amax() < 1e-7, "{between}");
        assert!((frame.translation.vector - Vector3::new(0.25, 0.5, 0.75)).amax() < 1e-14);
    }
}
