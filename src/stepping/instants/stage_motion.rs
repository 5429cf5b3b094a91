//! Position and velocity of a degree of freedom at the stages of a step that has just been solved, as dampers see it.
//!
//! ```text
//!     ẏ_j = ẏ₀ + h⁻¹ Σ_i (Ā B)_ji (y_i − y₀ − h c_i ẏ₀),     j = 1..s           [m/s or rad/s]
//! ```
//!
//! Source: [`catena_lobatto::equations::forces`]; of a ball joint y is the rotation vector since the start of the step.

use catena_lobatto::step::interface::Step;
use catena_lobatto::tableau::butcher::{MAXIMUM_STAGES, Tableau};

/// Writes the displacements since the start (m or rad) and the rates at all stages of a step of `length` seconds; `rate` is ẏ₀.
pub(crate) fn stage_motion(
    kernel: &dyn Step,
    tableau: &Tableau,
    freedom: usize,
    (length, rate): (f64, f64),
    displacements: &mut [f64],
    rates: &mut [f64],
) {
    let active = tableau.stages - 1;
    let mut moved = [0.0; MAXIMUM_STAGES];
    kernel.stage_displacements(freedom, &mut moved[1..=active]);
    displacements.copy_from_slice(&moved[..tableau.stages]);
    let ahead = |lane: usize| moved[lane + 1] - length * tableau.nodes[lane + 1] * rate;
    for (row, out) in tableau.velocity.chunks(active).zip(rates) {
        *out = rate + (0..active).map(|lane| row[lane] * ahead(lane)).sum::<f64>() / length;
    }
}
