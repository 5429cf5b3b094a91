//! The ladders: which settings a method is run at, from coarse to fine.
//!
//! Fixed steps divide the duration into a whole number of steps, so that no sliver at the end spoils the order; they
//! start near the scene's own scale of time and shrink by a factor that suits the order. Tolerances go by decades.

use super::method::{Method, Setting};

/// The longest step of at most `wanted` seconds that divides `duration`.
pub fn whole_step(duration: f64, wanted: f64) -> f64 {
    duration / (duration / wanted).ceil().max(1.0)
}

/// The settings of a method, coarse first. `time_scale` [s] is the mean step of DOP853 at 1e-6.
pub fn ladder(method: Method, duration: f64, time_scale: f64, quick: bool) -> Vec<Setting> {
    let root = std::f64::consts::SQRT_2;
    match method {
        Method::Lobatto(2) => steps(duration, 0.5 * time_scale, 2.0, if quick { 8 } else { 18 }),
        Method::Lobatto(3) => steps(duration, time_scale, if quick { 2.0 } else { root }, if quick { 7 } else { 24 }),
        Method::Lobatto(5) => steps(duration, 2.0 * time_scale, root, if quick { 8 } else { 16 }),
        Method::Lobatto(_) => {
            let factor = if quick { root } else { root.sqrt() };
            steps(duration, 4.0 * time_scale, factor, if quick { 8 } else { 20 })
        }
        Method::Euler => steps(duration, 0.125 * time_scale, if quick { 4.0 } else { 2.0 }, if quick { 5 } else { 20 }),
        Method::Rk4 => steps(duration, 0.25 * time_scale, if quick { 2.0 } else { root }, if quick { 8 } else { 26 }),
        Method::LobattoTolerance => tolerances(12, quick),
        Method::Dop853 => tolerances(14, quick),
    }
}

fn steps(duration: f64, first: f64, factor: f64, count: i32) -> Vec<Setting> {
    let mut steps: Vec<f64> = (0..count).map(|rung| whole_step(duration, first / factor.powi(rung))).collect();
    // Rounding to a whole number of steps may make neighbours equal.
    steps.dedup();
    steps.into_iter().map(Setting::Step).collect()
}

/// 1e-2 down to 1e-`last`, by decades, or by two of them.
fn tolerances(last: usize, quick: bool) -> Vec<Setting> {
    (2..=last)
        .step_by(if quick { 2 } else { 1 })
        // Parsed rather than computed, so that the file says 1e-3 and not 1.0000000000000002e-3.
        .filter_map(|exponent| format!("1e-{exponent}").parse().ok())
        .map(Setting::Tolerance)
        .collect()
}
