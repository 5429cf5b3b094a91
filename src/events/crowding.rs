//! Crowds of events: when so many steps end at events that first-order steps are taken instead, and how many.
//!
//! A crowd is a given number of steps within a given time. One first-order step ends it; each crowd that follows soon is ended by twice as many as the one before.

/// Length of a step of first order (s).
pub(super) const STEP: f64 = 1e-4;
/// So many steps within such times (s) are a crowd.
const CROWDS: [(usize, f64); 2] = [(100, 1e-5), (400, 1e-3)];
/// A crowd is left by one such step; if another follows within so many of them by twice as many as before,
const SOON: f64 = 10.0;
/// up to so many.
const LONGEST: usize = 64;

/// Steps that have become many, and the steps of first order that are to be made.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crowding {
    /// Steps since a time (s), for each kind of crowd.
    counts: [(usize, f64); 2],
    /// Steps of first order still to be made, those of the last crowd, and when it ended (s).
    left: usize,
    made: usize,
    ended: f64,
}

impl Crowding {
    /// Nothing has happened yet.
    pub const CALM: Crowding =
        Crowding { counts: [(0, f64::NEG_INFINITY); 2], left: 0, made: 0, ended: f64::NEG_INFINITY };

    /// Counts steps that would only repeat what has happened, and are not made.
    pub fn count_repeated(&mut self, steps: usize) {
        self.counts.iter_mut().for_each(|(count, _)| *count += steps);
    }

    /// Counts a step that begins at a time (s); whether it is to be one of first order.
    pub fn count(&mut self, time: f64) -> bool {
        if self.left == 0 {
            let mut crowded = false;
            for ((count, since), (most, within)) in self.counts.iter_mut().zip(CROWDS) {
                if time - *since > within {
                    (*count, *since) = (0, time);
                }
                *count += 1;
                crowded |= *count > most;
            }
            if !crowded {
                return false;
            }
            let again = time - self.ended <= SOON * self.made as f64 * STEP;
            self.made = if again { (2 * self.made).min(LONGEST) } else { 1 };
            self.left = self.made;
        }
        self.left -= 1;
        self.ended = time + STEP;
        self.counts = Crowding::CALM.counts;
        true
    }
}
