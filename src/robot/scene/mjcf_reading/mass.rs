//! Masses and inertias of geoms, and of bodies composed of them.
//!
//! ```text
//!     ellipsoid  V = 4/3 π a b c       Ixx = m (b² + c²)/5
//!     mesh       V = Σ det(p q r)/6    ∫ x xᵀ = Σ det (p pᵀ + q qᵀ + r rᵀ + s sᵀ)/120,  s = p + q + r
//!     composed   m = Σ mᵢ,  c = Σ mᵢ cᵢ/m,  I = Σ (Rᵢ Iᵢ Rᵢᵀ + mᵢ (|dᵢ|² 1 − dᵢ dᵢᵀ)),  dᵢ = cᵢ − c
//! ```
//!
//! with lengths in m, masses in kg, inertias about centres of mass in kg m². The other shapes are those of `[[body]]`.

use crate::scene::robot::Pose;
use nalgebra::{Matrix3, Rotation3, Translation3, Vector3};

/// Mass, the frame of the centre of mass, and the inertia in its axes.
#[derive(Clone, Debug)]
pub(crate) struct MassOf {
    pub mass: f64,
    pub frame: Pose,
    pub inertia: Matrix3<f64>,
}

/// How the solid inside triangles is counted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Inside {
    /// As it is: parts that a fold hides from a point are taken away.
    Exact,
    /// Every pyramid from the middle counts, whichever way its base looks: MuJoCo's default, which counts hollows twice.
    Legacy,
}

/// A solid of unit density.
#[derive(Clone, Debug)]
pub(crate) struct Solid {
    /// m³.
    pub volume: f64,
    /// m.
    pub center: Vector3<f64>,
    /// About the centre, for a density of 1 kg/m³ [kg m²].
    pub inertia: Matrix3<f64>,
}

/// The solid inside triangles; `None` if it is empty.
pub(crate) fn of_triangles(triangles: &[[Vector3<f64>; 3]], inside: Inside) -> Option<Solid> {
    let sixths = |corners: [Vector3<f64>; 3]| {
        let determinant = corners[0].dot(&corners[1].cross(&corners[2]));
        if inside == Inside::Legacy { determinant.abs() } else { determinant }
    };
    let from = |apex: Vector3<f64>| triangles.iter().map(move |corners| corners.map(|corner| corner - apex));
    // The middle of the surface.
    let (mut area, mut middle) = (0.0, Vector3::zeros());
    for [p, q, r] in triangles {
        let twice = (q - p).cross(&(r - p)).norm();
        area += twice;
        middle += twice / 3.0 * (p + q + r);
    }
    let middle = middle / area;
    let (mut volume, mut first) = (0.0, Vector3::zeros());
    for corners in from(middle) {
        let determinant = sixths(corners);
        volume += determinant / 6.0;
        first += determinant / 24.0 * corners.iter().sum::<Vector3<f64>>();
    }
    if volume == 0.0 || !volume.is_finite() {
        return None;
    }
    let center = middle + first / volume;
    let mut second = Matrix3::zeros();
    for corners in from(center) {
        let sum: Vector3<f64> = corners.iter().sum();
        let squares: Matrix3<f64> = corners.iter().map(|corner| corner * corner.transpose()).sum();
        second += sixths(corners) / 120.0 * (squares + sum * sum.transpose());
    }
    // A surface inside out has everything with the other sign.
    let sign = volume.signum();
    let inertia = sign * (Matrix3::identity() * second.trace() - second);
    Some(Solid { volume: volume.abs(), center, inertia })
}

/// Several rigid masses as one; `None` without mass.
pub(crate) fn composed(parts: &[MassOf]) -> Option<MassOf> {
    let mass: f64 = parts.iter().map(|part| part.mass).sum();
    if let [one] = parts {
        return (mass > 0.0).then(|| one.clone());
    }
    let center: Vector3<f64> = parts.iter().map(|part| part.mass * part.frame.translation.vector).sum();
    let center = center / mass;
    let mut inertia = Matrix3::zeros();
    for part in parts {
        let turn = part.frame.rotation.matrix();
        let arm = part.frame.translation.vector - center;
        inertia += turn * part.inertia * turn.transpose();
        inertia += part.mass * (Matrix3::identity() * arm.norm_squared() - arm * arm.transpose());
    }
    let frame = Pose::from_parts(Translation3::from(center), Rotation3::identity());
    (mass > 0.0).then_some(MassOf { mass, frame, inertia })
}
