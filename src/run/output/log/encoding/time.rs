//! Times of a run as the nanoseconds of a log.

/// The longest run whose nanoseconds a log can hold (s).
pub const LONGEST: f64 = 1.8e10;

/// Simulated seconds as the nanoseconds of a log: rounded, never negative.
pub fn nanoseconds(time: f64) -> u64 {
    // The cast saturates, so that no time can wrap around.
    (time * 1e9).round() as u64
}

/// The nanoseconds of a log as seconds: divided, because the product with 1e-9 has digits that were not written.
pub fn seconds(nanoseconds: u64) -> f64 {
    nanoseconds as f64 / 1e9
}
