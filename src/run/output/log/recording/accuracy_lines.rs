//! Lines about the accuracy in the log of a run: one whenever the estimated error has grown tenfold, and one when the tolerance is exceeded.

use crate::mechanism::ground::words::rounded;
use crate::simulation::AccuracySoFar;

/// The first word of lines about the accuracy.
pub(crate) const ACCURACY: &str = "accuracy: ";
/// The least growth of the error between two lines.
const GROWTH: f64 = 10.0;

/// The contents of the last lines.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct AccuracyLines {
    /// The estimated error (m).
    estimate: f64,
    /// Whether a line has said that the tolerance is exceeded.
    lost: bool,
}

impl AccuracyLines {
    /// The next line, if there is news.
    pub(crate) fn line(&mut self, so_far: &AccuracySoFar) -> Option<String> {
        let AccuracySoFar { time, wanted, estimate, holds_until } = *so_far;
        if !so_far.holds() {
            let said = std::mem::replace(&mut self.lost, true);
            return (!said).then(|| format!("{ACCURACY}{wanted:e} m holds until t = {} s", rounded(holds_until)));
        }
        if estimate < GROWTH * self.estimate || estimate == 0.0 {
            return None;
        }
        self.estimate = estimate;
        Some(format!("{ACCURACY}estimated error {estimate:.1e} m up to t = {} s", rounded(time)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_log_says_that_errors_have_grown_tenfold_and_once_until_when_the_accuracy_holds() {
        let mut lines = AccuracyLines::default();
        let mut say = |time, estimate: f64| {
            let holds_until = if estimate <= 1e-6 { time } else { 3.0 };
            lines.line(&AccuracySoFar { time, wanted: 1e-6, estimate, holds_until })
        };
        assert_eq!(say(1.0, 2e-9).as_deref(), Some("accuracy: estimated error 2.0e-9 m up to t = 1.00 s"));
        assert_eq!(say(2.0, 1.9e-8), None, "less than tenfold");
        assert_eq!(say(3.0, 2.1e-8).as_deref(), Some("accuracy: estimated error 2.1e-8 m up to t = 3.00 s"));
        assert_eq!(say(4.0, 3e-6).as_deref(), Some("accuracy: 1e-6 m holds until t = 3.00 s"));
        assert_eq!(say(5.0, f64::INFINITY), None, "said once");
    }
}
