//! The ladders: which settings a method is run at, from coarse to fine.
//!
//! Fixed steps divide the duration into a whole number of steps, so that no sliver at the end spoils the order; they
//! start near the scene's own scale of time and shrink by a factor that suits the order. Tolerances go by decades.

use crate::chart::method::{Method, Setting};

/// The longest step over events (s).
const LONGEST: f64 = 8e-3;

/// The longest step of at most `wanted` seconds that divides `duration`.
pub fn whole_step(duration: f64, wanted: f64) -> f64 {
    duration / (duration / wanted).ceil().max(1.0)
}

/// The settings of a method, coarse first. `time_scale` (s) is the mean step of DOP853 at 1e-6.
pub fn ladder(method: Method, duration: f64, time_scale: f64, quick: bool) -> Vec<Setting> {
    let root = std::f64::consts::SQRT_2;
    // First step in units of the time scale, factor from rung to rung, number of rungs.
    let (first, factor, count) = match (method, quick) {
        // A tolerance is one of single steps here: of calm motions a hundred metres leave a millimetre.
        (Method::LobattoTolerance | Method::LobattoUnestimated, _) => return tolerances(-2, 12, quick),
        (Method::Dop853 | Method::Dop853Regularised, _) => return tolerances(0, 14, quick),
        // Whatever the motion is between events.
        (Method::OverEvents, false) => return steps(duration, LONGEST, 2.0, 10),
        (Method::OverEvents, true) => return steps(duration, LONGEST, 4.0, 5),
        (Method::Euler, false) => (0.5, 2.0, 22),
        (Method::Euler, true) => (0.125, 4.0, 5),
        (Method::Rk4, false) => (1.0, root, 30),
        (Method::Rk4, true) => (0.5, 2.0, 9),
        (Method::Lobatto(2), false) => (1.0, 2.0, 20),
        (Method::Lobatto(2), true) => (0.5, 2.0, 8),
        (Method::Lobatto(3), false) => (1.5, root, 26),
        (Method::Lobatto(3), true) => (1.0, 2.0, 7),
        (Method::Lobatto(5), false) => (4.0, root, 18),
        (Method::Lobatto(5), true) => (2.0, root, 8),
        (Method::Lobatto(_) | Method::Precise(_), false) => (8.0, root.sqrt(), 24),
        (Method::Lobatto(_) | Method::Precise(_), true) => (4.0, root, 8),
    };
    steps(duration, first * time_scale, factor, count)
}

fn steps(duration: f64, first: f64, factor: f64, count: i32) -> Vec<Setting> {
    let mut steps: Vec<f64> = (0..count).map(|rung| whole_step(duration, first / factor.powi(rung))).collect();
    // Rounding to a whole number of steps may make neighbours equal.
    steps.dedup();
    steps.into_iter().map(Setting::Step).collect()
}

/// 1e-`first` down to 1e-`last`, by decades, or by two of them.
fn tolerances(first: i32, last: i32, quick: bool) -> Vec<Setting> {
    (first..=last)
        .step_by(if quick { 2 } else { 1 })
        // Parsed rather than computed, so that the file says 1e-3 and not 1.0000000000000002e-3.
        .filter_map(|exponent| format!("1e{}", -exponent).parse().ok())
        .map(Setting::Tolerance)
        .collect()
}
