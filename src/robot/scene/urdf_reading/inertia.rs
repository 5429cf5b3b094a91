//! Inertias that no rigid body has.

use crate::scene::error::Element;
use crate::scene::warning::Warning;
use nalgebra::Matrix3;
use std::path::Path;

/// A warning of an inertia (kg m²) of which one principal moment exceeds the sum of the others, beside a mass (kg).
pub(crate) fn impossible_inertia(
    file: &Path,
    line: usize,
    link: &Element,
    mass: f64,
    inertia: &Matrix3<f64>,
) -> Option<Warning> {
    let mut moments: Vec<f64> = inertia.symmetric_eigenvalues().iter().copied().collect();
    moments.sort_by(f64::total_cmp);
    // The computed value of a zero moment may be negative by rounding.
    for moment in 0..2 {
        if moments[moment] < 0.0 && moments[moment] > -1e-12 * moments[2] {
            moments[moment] = 0.0;
        }
    }
    let excess = moments[2] - moments[0] - moments[1];
    // Inertias are written with a few digits: less than one part in 10⁴ is their rounding.
    // A radius of gyration below a nanometre is the dust of a computation, not a statement.
    if excess <= 1e-4 * moments[2] || moments[2] <= mass * 1e-18 {
        return None;
    }
    let message = format!(
        "its inertia violates the triangle inequality: of the principal moments {:.4e}, {:.4e}, {:.4e} kg m² the largest exceeds \
         the sum of the others; used as given",
        moments[0], moments[1], moments[2]
    );
    Some(Warning::odd(file, Some(line), Some(link.clone()), message))
}
