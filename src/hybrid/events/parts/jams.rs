//! Steps that cannot be made, and the lengths of the steps of first order in their place.
//!
//! ```text
//!     h₀ = 1 µs;    h_{k+1} = 4 h_k  if the next one jams less than 10 h_k after it, else h₀          (s)
//! ```
//!
//! A slip that jams stops within less than a microsecond, in which roundings of gaps are forces: ε/h² of 1e-17 m is 0.1 m/s² for 1e-8 s. It is passed
//! in one step of first order, and so are a step that fails otherwise and a mode that could not be decided, as of a body that is wedged for a
//! moment. From the length of a step over events on they are a crowd.

/// The first length (s).
pub(crate) const FIRST: f64 = 1e-6;
/// The factor by which the next one is longer, and the time in which it follows soon, in lengths of the last.
const LONGER: f64 = 4.0;
const SOON: f64 = 10.0;

/// The last step in the place of one that could not be made.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Jams {
    /// Its length, and when it ends (s).
    length: f64,
    ends: f64,
    /// Whether it is the next one.
    is_next: bool,
}

impl Jams {
    /// Before the first one.
    pub const NONE: Jams = Jams { length: 0.0, ends: f64::NEG_INFINITY, is_next: false };

    /// A step that begins at a time (s) could not be made; the next one is shorter than `most` (s), or one of a crowd.
    pub fn jam(&mut self, time: f64, most: f64) {
        let length = if self.come_again(time) { LONGER * self.length } else { FIRST };
        let is_next = length < most;
        *self = Jams { length: length.min(most), ends: time + length.min(most), is_next };
    }

    /// Whether a jam at a time (s) follows another one soon.
    pub fn come_again(&self, time: f64) -> bool {
        time - self.ends <= SOON * self.length
    }

    /// The length of the next step, if it is one in the place of a step that jams (s).
    pub fn next(&self) -> Option<f64> {
        self.is_next.then_some(self.length)
    }

    /// The next step passes no jam.
    pub fn pass(&mut self) {
        self.is_next = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_jams_is_left_by_a_microsecond_and_what_jams_again_soon_by_more_up_to_a_crowd() {
        let mut jams = Jams::NONE;
        let (mut time, mut lengths) = (0.1, Vec::new());
        for _ in 0..6 {
            jams.jam(time, 1e-4);
            lengths.push(jams.next());
            time = jams.ends;
        }
        let expected = [1e-6, 4e-6, 1.6e-5, 6.4e-5];
        for (length, wanted) in lengths.iter().zip(expected) {
            assert!((length.expect("a jam") / wanted - 1.0).abs() < 1e-12, "{lengths:?}");
        }
        assert_eq!(lengths[4..], [None, None]);
        // Long after the last one, which was 0.1 ms long.
        jams.jam(time + 1e-2, 1e-4);
        assert_eq!(jams.next(), Some(FIRST));
    }
}
