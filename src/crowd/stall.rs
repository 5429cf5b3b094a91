//! Iterations whose value no longer falls.

/// How long ago a value was last half of what it had been before.
pub(crate) struct Stall {
    halved: f64,
    since: usize,
}

impl Stall {
    /// With the value before the first iteration.
    pub fn new(value: f64) -> Self {
        Stall { halved: value, since: 0 }
    }

    /// Takes the value after one more iteration.
    pub fn see(&mut self, value: f64) {
        self.since += 1;
        if value < 0.5 * self.halved {
            *self = Stall::new(value);
        }
    }

    /// Whether it has not halved in more than this number of iterations.
    pub fn lasts(&self, iterations: usize) -> bool {
        self.since > iterations
    }
}

#[cfg(test)]
mod tests {
    use super::Stall;

    #[test]
    fn a_value_that_has_not_halved_in_three_iterations_has_stalled_for_more_than_two() {
        let mut stall = Stall::new(1.0);
        [0.6, 0.55, 0.49].into_iter().for_each(|value| stall.see(value));
        assert!(!stall.lasts(0), "0.49 is half of 1");
        [0.48, 0.3].into_iter().for_each(|value| stall.see(value));
        assert!(!stall.lasts(2));
        stall.see(0.25);
        assert!(stall.lasts(2) && !stall.lasts(3));
    }
}
