//! A factor over time: of loads that change, begin or end while a run goes on.
//!
//! ```text
//!     f(t) = table(t),   or   m + a sin(ω t + φ)          from ≤ t < until,   else 0
//! ```

use crate::description::target::Target;

/// A factor over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Course {
    values: Values,
    /// s; the factor is zero before.
    from: f64,
    /// s; the factor is zero from then on.
    until: f64,
}

#[derive(Clone, Debug, PartialEq)]
enum Values {
    Table(Target),
    Wave(Wave),
}

/// `m + a sin(ω t + φ)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wave {
    /// m.
    pub mean: f64,
    /// a.
    pub amplitude: f64,
    /// ω [rad/s].
    pub frequency: f64,
    /// φ (rad).
    pub phase: f64,
}

/// An instant that a step has reached but for a rounding is reached: this part of a time, or of a second.
const REACHED: f64 = 1e-12;

/// The largest turn of the phase of a wave in a step (rad), more than steps that resolve it make.
const RESOLVED: f64 = 8.0;

fn reaches(time: f64, instant: f64) -> bool {
    instant <= time + REACHED * time.abs().max(1.0)
}

impl Course {
    /// A factor that does not change while it acts.
    pub fn constant(value: f64) -> Self {
        Course::table(Target::constant(value))
    }

    /// The values of a table, which hold before the first and after the last.
    pub fn table(table: Target) -> Self {
        Course { values: Values::Table(table), from: f64::NEG_INFINITY, until: f64::INFINITY }
    }

    /// A wave.
    pub fn wave(wave: Wave) -> Self {
        Course { values: Values::Wave(wave), from: f64::NEG_INFINITY, until: f64::INFINITY }
    }

    /// The same from one time until another (s).
    #[must_use]
    pub fn between(self, from: f64, until: f64) -> Self {
        Course { from, until, ..self }
    }

    /// Whether its factor is a formula of time.
    pub fn has_formula(&self) -> bool {
        matches!(&self.values, Values::Table(table) if table.as_formula().is_some())
    }

    /// Whether it never changes.
    pub fn is_constant(&self) -> bool {
        let still = match &self.values {
            Values::Table(table) => table.is_constant(),
            Values::Wave(wave) => wave.amplitude == 0.0,
        };
        still && self.from == f64::NEG_INFINITY && self.until == f64::INFINITY
    }

    /// The factor at a time (s), in a step that began at `since`: where an instant ends the step, its value before that.
    pub fn value(&self, since: f64, time: f64) -> f64 {
        if !reaches(since, self.from) || reaches(since, self.until) {
            return 0.0;
        }
        match &self.values {
            Values::Table(table) => table.piece(since, time).0,
            Values::Wave(Wave { mean, amplitude, frequency, phase }) => {
                mean + amplitude * (frequency * time + phase).sin()
            }
        }
    }

    /// The longest step from a time on, of `step` seconds at most, over which stages resolve it; the run goes on to `until` (s).
    pub fn resolved_step(&self, time: f64, step: f64, until: f64) -> f64 {
        match &self.values {
            Values::Table(table) if reaches(time, self.from) && !reaches(time, self.until) => {
                table.resolved_step(time, step, until.min(self.until))
            }
            Values::Wave(wave) if wave.amplitude != 0.0 => step.min(RESOLVED / wave.frequency.abs()),
            _ => step,
        }
    }

    /// The next instant after `time` (s) at which it jumps or has a kink.
    pub fn next_instant(&self, time: f64) -> f64 {
        let knot = match &self.values {
            Values::Table(table) => table.next_knot(time),
            Values::Wave(_) => f64::INFINITY,
        };
        let ends = [self.from, self.until].into_iter().filter(|&end| !reaches(time, end));
        ends.fold(knot, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::target::Interpolation;

    #[test]
    fn a_table_acts_between_its_ends_and_every_jump_and_kink_is_an_instant() {
        let table = Target::table(&[(0.0, 1.0), (2.0, 5.0)], Interpolation::Linear).unwrap();
        let course = Course::table(table).between(0.5, 3.0);
        let values = [0.0, 0.5, 1.0, 2.5, 3.0].map(|time| course.value(time, time));
        assert_eq!(values, [0.0, 2.0, 3.0, 5.0, 0.0]);
        // A step that ends where the factor ends has its value until there.
        assert_eq!(course.value(2.5, 3.0), 5.0);
        let next = [-1.0, 0.0, 0.5, 2.0, 3.0].map(|time| course.next_instant(time));
        assert_eq!(next, [0.0, 0.5, 2.0, 3.0, f64::INFINITY]);
        assert!(!course.is_constant() && Course::constant(2.0).is_constant());
        let wave = Course::wave(Wave { mean: 1.0, amplitude: 2.0, frequency: 3.0, phase: 0.5 });
        // The phase 3 · 0.7 + 0.5 is rounded.
        assert!((wave.value(0.0, 0.7) - (1.0 + 2.0 * 2.6_f64.sin())).abs() < 1e-15);
        assert_eq!(wave.next_instant(0.0), f64::INFINITY);
    }
}
