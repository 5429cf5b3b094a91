//! The figures of steps as curves: energies, constraint errors, lengths of steps.
//!
//! They have times of their own, the ends of steps and both sides of each event. Lines between samples would give a false slope to an energy that jumps
//! between two of them.

use crate::output::log::reading::frames::Figures;
use crate::output::page::curve_name::CurveName;

/// Figures in a page: beyond this number every second one is left out, again and again, but for those beside an event.
const MOST: usize = 20_000;

/// Figures as near in time as this are the two sides of an event (ns): the log puts the state before an event a nanosecond before it.
const BESIDE: u64 = 2;

/// Numbers about steps: name, group, unit, whether the axis is logarithmic.
const CURVES: [(&str, &str, &str, bool); 11] = [
    ("energy.kinetic", "Energy", "J", false),
    ("energy.potential", "Energy", "J", false),
    ("energy.total", "Energy", "J", false),
    ("energy.dissipated", "Energy", "J", false),
    ("energy.work", "Energy", "J", false),
    ("energy.friction", "Energy", "J", false),
    ("energy.impacts", "Energy", "J", false),
    ("energy.error", "Energy error", "J", true),
    ("constraint.position", "Constraint error", "m or rad", true),
    ("constraint.velocity", "Constraint error, velocities", "m/s or rad/s", true),
    ("solver.step", "Step", "s", false),
];

/// Collects the figures of steps.
#[derive(Default)]
pub(super) struct StepFigures {
    initial_balance: Option<f64>,
    /// The time of each step (ns, and s), and its numbers.
    rows: Vec<(u64, f64, [f32; CURVES.len()])>,
}

impl StepFigures {
    /// Takes the figures of the next step; a figure that the log does not have is not a number.
    pub(super) fn take(&mut self, figures: &Figures) {
        let mut numbers = [f64::NAN; CURVES.len()];
        if let Some(energy) = figures.energy {
            numbers[..7].copy_from_slice(&energy);
        }
        if let Some(balance) = figures.balance() {
            numbers[7] = (balance - *self.initial_balance.get_or_insert(balance)).abs();
        }
        if let Some(violation) = figures.violation {
            numbers[8..10].copy_from_slice(&violation);
        }
        if let Some([step, ..]) = figures.solver {
            numbers[10] = step;
        }
        self.rows.push((figures.nanoseconds, figures.time(), numbers.map(|number| number as f32)));
    }

    /// Leaves out figures while there are more than [`MOST`].
    pub(super) fn thin(&mut self) {
        let mut before = usize::MAX;
        while self.rows.len() > MOST && self.rows.len() < before {
            before = self.rows.len();
            let times: Vec<u64> = self.rows.iter().map(|(time, ..)| *time).collect();
            let is_event = |k: usize| {
                let near = |other: Option<&u64>| other.is_some_and(|other| other.abs_diff(times[k]) <= BESIDE);
                near(times.get(k + 1)) || k > 0 && near(times.get(k - 1))
            };
            let mut number = 0..;
            self.rows.retain(|_| number.next().is_some_and(|k| k % 2 == 0 || k + 1 == before || is_event(k)));
        }
    }

    /// The names of the curves; none without figures.
    pub(super) fn curves(&self) -> Vec<CurveName> {
        let curve = |&(name, group, unit, logarithmic): &(&str, &'static str, &'static str, bool)| CurveName {
            name: name.to_string(),
            group,
            unit,
            logarithmic,
            spread: None,
        };
        if self.rows.is_empty() { Vec::new() } else { CURVES.iter().map(curve).collect() }
    }

    /// The times of the figures (s).
    pub(super) fn times(&self) -> Vec<f64> {
        self.rows.iter().map(|(_, time, _)| *time).collect()
    }

    /// The numbers of all curves, one curve after the other.
    pub(super) fn columns(&self) -> impl Iterator<Item = f32> {
        (0..CURVES.len()).flat_map(|curve| self.rows.iter().map(move |(_, _, numbers)| numbers[curve]))
    }
}

#[cfg(test)]
mod tests {
    use super::{MOST, StepFigures};
    use crate::output::log::reading::frames::Figures;

    #[test]
    fn both_sides_of_an_event_stay_when_other_figures_are_left_out() {
        let mut steps = StepFigures::default();
        for k in 0..3 * MOST as u64 {
            steps.take(&Figures { nanoseconds: 1000 * k, ..Figures::default() });
            if k % 5000 == 77 {
                steps.take(&Figures { nanoseconds: 1000 * k + 1, ..Figures::default() });
            }
        }
        steps.thin();
        let times: Vec<u64> = steps.rows.iter().map(|(time, ..)| *time).collect();
        assert!(times.len() <= MOST && times.len() > MOST / 3, "{}", times.len());
        for k in (77..3 * MOST as u64).step_by(5000) {
            assert!(times.contains(&(1000 * k)) && times.contains(&(1000 * k + 1)), "{k}");
        }
        assert_eq!(times.last(), Some(&(1000 * (3 * MOST as u64 - 1))));
    }
}
