//! The length and the end of a step, which is not longer than the rest of the run.

/// Whatever makes a step shorter does so at most this often before it gives up.
pub(crate) const HALVINGS: u32 = 14;

/// A step that is not longer than the rest of the run.
#[derive(Clone)]
pub(crate) struct Stride {
    /// Its length (s).
    pub length: f64,
    /// Its end (s).
    pub end: f64,
    /// Whether that is where the run ends.
    pub reaches: bool,
}

impl Stride {
    /// A stride from `time` as far as `step`, but exactly to `until` if that is nearer, or further by a rounding.
    pub fn towards(until: f64, time: f64, step: f64) -> Self {
        let remaining = until - time;
        if step >= remaining * (1.0 - 1e-9) {
            Stride { length: remaining, end: until, reaches: true }
        } else {
            Stride { length: step, end: time + step, reaches: false }
        }
    }
}
