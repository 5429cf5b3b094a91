//! Standard deviations of joint positions along a run, from those of its parameters.
//!
//! ```text
//!     σ_q² = Σ_θ (σ_θ ∂q/∂θ)²          of independent parameters; between rows on straight lines
//! ```

use crate::output::log::reading::frames::Slopes;
use crate::output::log::seconds;
use std::collections::HashMap;

/// The standard deviations of all degrees of freedom.
#[derive(Default)]
pub(super) struct Spreads {
    /// Times (s) and σ_q² of each degree of freedom, in order of time.
    rows: HashMap<String, Vec<(f64, f64)>>,
}

impl Spreads {
    /// Takes the derivatives by a parameter; those without a standard deviation tell nothing.
    pub fn take(&mut self, slopes: &Slopes) {
        let time = seconds(slopes.nanoseconds);
        for (name, part) in slopes.by.names.iter().zip(&slopes.by.efforts) {
            let rows = self.rows.entry(name.clone()).or_default();
            match rows.last_mut().filter(|(known, _)| *known == time) {
                Some((_, square)) => *square += part * part,
                None => rows.push((time, part * part)),
            }
        }
    }

    /// The standard deviation of a curve at some times; not a number outside its rows. `None` if it is no position with one.
    pub fn at(&self, curve: &str, times: &[f64]) -> Option<Vec<f32>> {
        let (joint, component) = curve.split_once(".position")?;
        let rows = self.rows.get(&format!("{joint}{component}"))?;
        let at = |time: &f64| {
            let later = rows.partition_point(|(known, _)| known < time);
            let deviation = |row: usize| rows.get(row).map(|(time, square)| (*time, square.sqrt()));
            match (later.checked_sub(1).and_then(deviation), deviation(later)) {
                (_, Some((known, own))) if known == *time => own,
                (Some((before, first)), Some((after, last))) => {
                    first + (last - first) * (time - before) / (after - before)
                }
                _ => f64::NAN,
            }
        };
        Some(times.iter().map(|time| at(time) as f32).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::log::reading::decode::JointStates;

    #[test]
    fn independent_parameters_add_up_as_squares_and_lines_lie_between_rows() {
        let mut spreads = Spreads::default();
        let mut take = |nanoseconds: u64, efforts: Vec<f64>| {
            let names = vec!["elbow".to_string(), "base.x".to_string()];
            let by = JointStates { names, efforts, ..JointStates::default() };
            spreads.take(&Slopes { nanoseconds, key: String::new(), by });
        };
        take(0, vec![3.0, 0.0]);
        take(0, vec![-4.0, 0.0]);
        take(1_000_000_000, vec![1.0, 2.0]);
        take(2_000_000_000, vec![]);
        let times = [0.0, 0.25, 1.0, 1.5];
        let found = spreads.at("elbow.position", &times).expect("a deviation");
        assert_eq!(found[..3], [5.0, 4.0, 1.0]);
        assert!(found[3].is_nan(), "nothing is known after the last row");
        assert_eq!(spreads.at("base.position.x", &[1.0]), Some(vec![2.0]));
        assert_eq!(spreads.at("elbow.velocity", &times), None);
        assert_eq!(spreads.at("base.position.qw", &times), None);
    }
}
