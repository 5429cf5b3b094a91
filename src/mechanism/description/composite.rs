//! Mass, centre and inertia of rigidly joined links, and their principal axes.
//!
//! For parts with mass `m`, centre `c` and inertia `I` about it, all in the axes of one frame:
//!
//! ```text
//!     M = Σ m        C = Σ m c / M        J = Σ I + m (|d|² 1 − d dᵀ),   d = c − C        [kg, m, kg m²]
//! ```

use crate::description::joint::Pose;
use nalgebra::{Matrix3, Rotation3, Translation3, Vector3};

/// A rigid mass: one link, or several composed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Composite {
    /// Mass (kg).
    pub mass: f64,
    /// Centre of mass in the common frame (m).
    pub center: Vector3<f64>,
    /// Inertia about the centre of mass, in the axes of the common frame [kg m²].
    pub inertia: Matrix3<f64>,
}

impl Composite {
    /// A part with this inertia in the axes of its inertial frame, placed at `frame` in the common frame.
    pub fn part(mass: f64, inertia: &Matrix3<f64>, frame: &Pose) -> Self {
        let rotation = frame.rotation.matrix();
        Composite { mass, center: frame.translation.vector, inertia: rotation * inertia * rotation.transpose() }
    }

    /// Several parts as one body. Without any mass the centre is the centre of the first part that has inertia, or the origin.
    pub fn of(parts: &[Composite]) -> Self {
        let mass: f64 = parts.iter().map(|part| part.mass).sum();
        let massive: Vec<&Composite> = parts.iter().filter(|part| part.mass > 0.0).collect();
        let center = match massive.as_slice() {
            [] => parts.iter().find(|part| part.inertia.amax() > 0.0).map_or(Vector3::zeros(), |part| part.center),
            // Exactly its own: m c / m would round.
            [only] => only.center,
            _ => massive.iter().map(|part| part.center * (part.mass / mass)).sum(),
        };
        let inertia = parts
            .iter()
            .map(|part| {
                let d = part.center - center;
                part.inertia + (Matrix3::identity() * d.norm_squared() - d * d.transpose()) * part.mass
            })
            .sum();
        Composite { mass, center, inertia }
    }

    /// Whether there is neither mass nor inertia.
    pub fn is_nothing(&self) -> bool {
        self.mass == 0.0 && self.inertia.amax() == 0.0
    }

    /// The principal frame at the centre of mass, and the principal moments in the order of its axes.
    ///
    /// Axes that are principal to rounding are kept; others are numbered and signed so as to turn them least.
    pub fn principal(&self) -> (Pose, Vector3<f64>) {
        let (axes, moments) = principal_axes(&self.inertia);
        (Pose::from_parts(Translation3::from(self.center), Rotation3::from_matrix_unchecked(axes)), moments)
    }
}

/// Right-handed principal axes (as columns) and the moments along them.
fn principal_axes(inertia: &Matrix3<f64>) -> (Matrix3<f64>, Vector3<f64>) {
    if is_diagonal_to_rounding(inertia) {
        return (Matrix3::identity(), inertia.diagonal());
    }
    // symmetric_eigen divides by the largest entry first, so small inertias are as exact as large ones.
    let eigen = inertia.symmetric_eigen();
    const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let alignment = |order: &[usize; 3]| (0..3).map(|axis| eigen.eigenvectors[(axis, order[axis])].abs()).sum::<f64>();
    let mut best = ORDERS[0];
    for order in ORDERS {
        if alignment(&order) > alignment(&best) + 1e-12 {
            best = order;
        }
    }
    let column = |axis: usize| {
        let vector = eigen.eigenvectors.column(best[axis]).into_owned();
        if vector[axis] < 0.0 { -vector } else { vector }
    };
    // Orthonormal to the last digit, whatever the eigenvalue iteration left.
    let x = column(0).normalize();
    let second = column(1);
    let y = (second - x * x.dot(&second)).normalize();
    let axes = Matrix3::from_columns(&[x, y, x.cross(&y)]);
    (axes, Vector3::new(eigen.eigenvalues[best[0]], eigen.eigenvalues[best[1]], eigen.eigenvalues[best[2]]))
}

fn is_diagonal_to_rounding(inertia: &Matrix3<f64>) -> bool {
    [(0, 1), (0, 2), (1, 2)].iter().all(|&(i, j)| {
        // Each by itself, because products of large ones are infinite.
        let scale = inertia[(i, i)].max(0.0).sqrt() * inertia[(j, j)].max(0.0).sqrt();
        inertia[(i, j)].abs() <= 1e-15 * scale
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An inertia with known moments in axes turned by (roll, pitch, yaw).
    fn turned(moments: [f64; 3], rpy: [f64; 3]) -> Matrix3<f64> {
        let rotation = Rotation3::from_euler_angles(rpy[0], rpy[1], rpy[2]).into_inner();
        rotation * Matrix3::from_diagonal(&Vector3::from(moments)) * rotation.transpose()
    }

    #[test]
    fn principal_moments_of_tiny_and_huge_inertias_are_exact_to_rounding() {
        for scale in [1e-9, 1e-20, 1.0, 1e12, 1e160] {
            let inertia = turned([2.0 * scale, 3.0 * scale, 4.0 * scale], [0.3, -1.2, 2.5]);
            let (axes, moments) = principal_axes(&inertia);
            let mut sorted: Vec<f64> = moments.iter().copied().collect();
            sorted.sort_by(f64::total_cmp);
            for (found, wanted) in sorted.iter().zip([2.0, 3.0, 4.0]) {
                assert!((found / scale - wanted).abs() < 1e-14, "{found} at scale {scale}");
            }
            let back = axes * Matrix3::from_diagonal(&moments) * axes.transpose();
            assert!(
                (back - inertia).amax() < 4e-15 * scale * 4.0,
                "scale {scale}: {}",
                (back - inertia).amax() / scale
            );
            assert!((axes.determinant() - 1.0).abs() < 1e-15 * 4.0);
        }
    }

    #[test]
    fn a_diagonal_inertia_keeps_its_axes_and_order() {
        let inertia = Matrix3::from_diagonal(&Vector3::new(3.0, 1.0, 2.0));
        assert_eq!(principal_axes(&inertia), (Matrix3::identity(), Vector3::new(3.0, 1.0, 2.0)));
    }

    #[test]
    fn axes_turned_a_little_stay_near_the_link_axes() {
        let (axes, _) = principal_axes(&turned([3.0, 1.0, 2.0], [0.1, 0.05, -0.1]));
        assert!((axes - Rotation3::from_euler_angles(0.1, 0.05, -0.1).into_inner()).amax() < 1e-14);
    }

    #[test]
    fn one_massive_part_keeps_its_centre_exactly() {
        let frame = Pose::from_parts(Translation3::new(0.1, 0.2, 0.3), Rotation3::identity());
        let part = Composite::part(0.7, &Matrix3::identity(), &frame);
        let empty = Composite::part(0.0, &Matrix3::zeros(), &Pose::identity());
        assert_eq!(Composite::of(&[empty, part]).center, part.center);
    }
}
