//! Crowds that follow each other, and how many calm steps end the next one.
//!
//! ```text
//!     m₀ = 10;   m_{k+1} = 2 m_k  if it begins less than ten of its lengths, or 20 ms, after the last one ended, at most 512, else m₀
//!     h_k = h₀ m_k / m₀,  1 ms at most                      length of a step that does not keep to the tolerance (s)
//! ```

/// m₀ and the most.
const CALM: usize = 10;
const MOST: usize = 512;
/// A crowd follows soon within this many lengths of the last one, and within this time (s).
const SOON: f64 = 10.0;
const SOON_AT_LEAST: f64 = 2e-2;

/// The last crowd.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spells {
    /// Steps without an event until now, and how many end it.
    calm: (usize, usize),
    /// When it began and ended (s).
    began: f64,
    ended: f64,
}

impl Spells {
    /// Before the first one.
    pub const NONE: Spells = Spells { calm: (0, CALM), began: 0.0, ended: f64::NEG_INFINITY };

    /// A crowd begins at a time (s).
    pub fn enter(&mut self, time: f64) {
        let soon = time - self.ended <= (SOON * (self.ended - self.began)).max(SOON_AT_LEAST);
        self.calm = (0, if soon { (2 * self.calm.1).min(MOST) } else { CALM });
        self.began = time;
    }

    /// Counts a step with this number of events; returns whether they have been calm for long enough.
    pub fn is_calm(&mut self, events: usize) -> bool {
        self.calm.0 = if events == 0 { self.calm.0 + 1 } else { 0 };
        self.calm.0 >= self.calm.1
    }

    /// It ends at a time (s).
    pub fn leave(&mut self, time: f64) {
        self.ended = time;
    }

    /// The factor by which steps that do not keep to the tolerance are longer, because crowds follow soon.
    pub fn longer(&self) -> f64 {
        self.calm.1 as f64 / CALM as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crowds_that_follow_soon_take_twice_as_many_calm_steps_up_to_512_and_one_that_follows_later_takes_ten() {
        let mut spells = Spells::NONE;
        let mut needed = |time: f64| {
            spells.enter(time);
            let steps = (1..).find(|_| spells.is_calm(0)).expect("a calm step");
            spells.leave(time + 1e-3);
            (steps, spells.longer())
        };
        for k in 0..8 {
            let steps = (10 << k).min(512);
            assert_eq!(needed(0.02 * f64::from(k)), (steps, f64::from(steps) / 10.0));
        }
        assert_eq!(needed(0.2), (10, 1.0));
        // An event among them begins the count again.
        spells.enter(1.0);
        assert!((0..9).all(|_| !spells.is_calm(0)) && !spells.is_calm(1) && (0..9).all(|_| !spells.is_calm(0)));
        assert!(spells.is_calm(0));
    }
}
