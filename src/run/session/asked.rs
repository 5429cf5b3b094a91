//! The requested settings of a run: its duration, the choice of its steps, and its sampling rate.

use crate::scene::SimulationSettings;
use crate::session::error::Error;
use crate::simulation::StepChoice;

/// Default of the simulated time (s).
pub const DEFAULT_DURATION: f64 = 10.0;
/// Default of the wanted accuracy of positions (m).
pub const DEFAULT_TOLERANCE: f64 = 1e-6;
/// Default of the samples per simulated second.
pub const DEFAULT_RATE: f64 = 60.0;

/// The highest rate at which sample times differ when rounded to nanoseconds.
const HIGHEST_RATE: f64 = 1e6;

/// The requested settings. A setting that is `None` comes from the file, or else from the defaults.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Asked {
    /// Simulated time (s).
    pub duration: Option<f64>,
    /// Wanted accuracy of positions (m).
    pub tolerance: Option<f64>,
    /// Whether the run leaves out the estimate of its error ([`StepChoice::Unestimated`]).
    pub no_estimate: bool,
    /// Number of stages and length of steps (s).
    pub fixed: Option<(usize, f64)>,
    /// Whether given steps vary with the pace of the motion ([`StepChoice::Reversible`]).
    pub reversible: bool,
    /// Whether given steps are solved to 32 digits ([`StepChoice::Precise`]).
    pub precise: bool,
    /// Samples per simulated second.
    pub rate: Option<f64>,
}

/// The settings of a run after defaults are applied.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settled {
    /// Simulated time (s).
    pub duration: f64,
    /// How steps are chosen.
    pub choice: StepChoice,
    /// Samples per simulated second.
    pub rate: f64,
}

impl Asked {
    /// Combines the requested settings with the settings of the file and the defaults.
    ///
    /// # Errors
    /// [`Error::Option`]: invalid numbers, which the command line and files refuse before.
    pub fn settle(&self, file: &SimulationSettings) -> Result<Settled, Error> {
        let given = [
            ("duration", self.duration),
            ("tolerance", self.tolerance),
            ("step", self.fixed.map(|(_, step)| step)),
            ("rate", self.rate),
        ];
        for (option, value) in given {
            match value {
                Some(value) if !value.is_finite() => {
                    return Err(Error::Option { option, value, wanted: "give a finite number" });
                }
                Some(value) if value <= 0.0 => {
                    return Err(Error::Option { option, value, wanted: "must be greater than zero" });
                }
                Some(value) if option == "rate" && value > HIGHEST_RATE => {
                    return Err(Error::Option { option, value, wanted: "must be at most 1e6" });
                }
                _ => {}
            }
        }
        let duration = self.duration.or(file.duration).unwrap_or(DEFAULT_DURATION);
        let rate = self.rate.or(file.rate).unwrap_or(DEFAULT_RATE);
        Ok(Settled { duration, choice: self.choice(file).within(duration), rate })
    }

    fn choice(&self, file: &SimulationSettings) -> StepChoice {
        let fixed = self.fixed.or(file.fixed.filter(|_| self.tolerance.is_none()));
        match fixed {
            Some((stages, step)) if self.reversible => StepChoice::Reversible { stages, step },
            Some((stages, step)) if self.precise => StepChoice::Precise { stages, step },
            Some((stages, step)) => StepChoice::Fixed { stages, step },
            None => {
                let choice = StepChoice::Tolerance(self.tolerance.or(file.tolerance).unwrap_or(DEFAULT_TOLERANCE));
                if self.no_estimate || file.estimate == Some(false) { choice.without_estimate() } else { choice }
            }
        }
    }
}
