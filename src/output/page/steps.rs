//! Curves of the figures of steps: energies, constraint errors, lengths of steps, at the ends of steps and on both sides of each event.
//!
//! ```text
//!     energy.error   |B − B₀|   (J)      B = E + D − W + lost: the balance of energies; B₀ its first value
//! ```
//!
//! A log has figures one nanosecond before an event, without its impacts, and at it. Both are drawn, so that an energy that an impact takes is a vertical
//! line, and a fall without losses is level. Figures beside events are drawn where the samples are: at most one for each drawn sample.

use crate::output::log::reading::frames::Figures;
use crate::output::log::seconds;
use crate::output::page::curve_name::CurveName;

/// The most events whose both sides are drawn.
const MOST_EVENTS: usize = 20_000;

/// Name, group, unit, whether the axis is logarithmic.
const NAMES: [(&str, &str, &str, bool); 11] = [
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

/// Collects these curves.
#[derive(Default)]
pub(super) struct StepCurves {
    initial: Option<f64>,
    /// Whether a sample has been drawn since the figures that were taken last.
    is_due: bool,
    /// The figures that came last, if they were not taken.
    held: Option<Figures>,
    /// Events whose both sides were taken.
    events: usize,
    /// Times (s), and the values of all curves at them.
    pub times: Vec<f64>,
    pub values: [Vec<f32>; NAMES.len()],
}

impl StepCurves {
    /// The curves with their names.
    pub fn names() -> impl Iterator<Item = CurveName> {
        let name = |(name, group, unit, logarithmic): (&str, _, _, _)| CurveName {
            name: name.to_string(),
            group,
            unit,
            logarithmic,
            of_steps: true,
        };
        NAMES.into_iter().map(name)
    }

    /// A sample is drawn.
    pub fn sample(&mut self) {
        self.is_due = true;
    }

    /// Figures of the log, in the order of their times.
    pub fn see(&mut self, figures: &Figures) {
        if self.initial.is_none() {
            self.initial = figures.balance();
        }
        if let Some(before) = self.held.take_if(|held| held.nanoseconds + 1 == figures.nanoseconds)
            && self.events < MOST_EVENTS
        {
            self.events += 1;
            self.take(&before);
            self.take(figures);
        } else {
            if self.is_due {
                self.take_held();
            }
            self.held = Some(*figures);
        }
    }

    /// Takes the last figures.
    pub fn finish(&mut self) {
        self.take_held();
    }

    fn take_held(&mut self) {
        if let Some(held) = self.held.take() {
            self.take(&held);
        }
    }

    fn take(&mut self, figures: &Figures) {
        self.is_due = false;
        let mut numbers = [f64::NAN; NAMES.len()];
        if let Some(energy) = figures.energy {
            numbers[..7].copy_from_slice(&energy);
        }
        if let (Some(balance), Some(initial)) = (figures.balance(), self.initial) {
            numbers[7] = (balance - initial).abs();
        }
        if let Some(violation) = figures.violation {
            numbers[8..10].copy_from_slice(&violation);
        }
        if let Some([step, ..]) = figures.solver {
            numbers[10] = step;
        }
        self.times.push(seconds(figures.nanoseconds));
        self.values.iter_mut().zip(numbers).for_each(|(values, number)| values.push(number as f32));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(nanoseconds: u64, kinetic: f64, impacts: f64) -> Figures {
        let energy = Some([kinetic, 0.0, kinetic, 0.0, 0.0, 0.0, impacts]);
        Figures { nanoseconds, energy, ..Figures::default() }
    }

    #[test]
    fn both_sides_of_an_event_are_drawn_and_other_figures_once_a_drawn_sample() {
        let mut curves = StepCurves::default();
        curves.sample();
        // A sample is drawn after every third of these steps; an impact at 4 µs takes 2 of 5 J.
        for step in 0..10 {
            let time = 1000 * step;
            if step == 4 {
                curves.see(&at(time - 1, 5.0, 0.0));
            }
            curves.see(&if step < 4 { at(time, 5.0, 0.0) } else { at(time, 3.0, 2.0) });
            if step % 3 == 2 {
                curves.sample();
            }
        }
        curves.finish();
        let nanoseconds: Vec<i64> = curves.times.iter().map(|time| (time * 1e9).round() as i64).collect();
        assert_eq!(nanoseconds, [0, 2000, 3999, 4000, 5000, 8000, 9000]);
        let kinetic = &curves.values[0];
        assert_eq!(kinetic[..], [5.0, 5.0, 5.0, 3.0, 3.0, 3.0, 3.0]);
        // The balance is that of the start on both sides.
        assert!(curves.values[7].iter().all(|error| *error == 0.0));
    }
}
