//! The inputs of many runs: efforts, targets of motors and a feedback at ticks, between which they are held.
//!
//! ```text
//!     τ(t) = u_k − K (x_k − x̄)      for t_k ≤ t < t_{k+1},  t_k = k T       x = (q, v),  K: n × (length of q + length of v),  T: the period (s)
//! ```

use crate::session::error::Error;
use crate::session::many::Rollout;
use crate::session::model::Model;
use crate::simulation::Simulation;

/// The inputs of one run at its ticks.
pub(crate) struct Inputs<'i> {
    period: f64,
    efforts: &'i [f64],
    targets: &'i [f64],
    feedback: &'i [f64],
    reference: &'i [f64],
}

impl Model {
    /// Refuses inputs of wrong lengths and numbers; returns the time between ticks (s), if there are any.
    pub(crate) fn check_inputs(&self, runs: usize, duration: f64, options: &Rollout) -> Result<Option<f64>, Error> {
        let Rollout { period, efforts, targets, feedback, reference, params, .. } = *options;
        let (width_q, width_v) = (self.coordinates().q_count(), self.coordinates().v_count());
        if let Some((_, numbers)) = params.iter().find(|(_, numbers)| numbers.len() != runs) {
            return Err(Error::Count { what: "params, a number a run", given: numbers.len(), wanted: runs });
        }
        if efforts.is_empty() && targets.is_empty() && feedback.is_empty() {
            return Ok(None);
        }
        let Some(period) = period.filter(|period| *period > 0.0 && period.is_finite()) else {
            let (value, wanted) = (period.unwrap_or(0.0), "give the time between ticks, longer than zero");
            return Err(Error::Option { option: "the period", value, wanted });
        };
        let ticks = ticks(duration, period);
        let motors = self.motor_names().len();
        let counts = [
            ("efforts, a row a run and tick", efforts.len(), runs * ticks * width_v),
            ("targets, a row a run and tick", targets.len(), runs * ticks * motors),
            ("feedback, a row a velocity", feedback.len(), width_v * (width_q + width_v)),
            ("reference, q and v", reference.len(), width_q + width_v),
        ];
        if let Some(&(what, given, wanted)) = counts.iter().find(|(_, given, wanted)| *given != 0 && given != wanted) {
            return Err(Error::Count { what, given, wanted });
        }
        for row in efforts.chunks(width_v.max(1)) {
            self.coordinates().check("efforts", row, width_v, |joint| &joint.v)?;
        }
        for (what, numbers) in [("targets", targets), ("feedback", feedback), ("reference", reference)] {
            if let Some(&value) = numbers.iter().find(|number| !number.is_finite()) {
                return Err(Error::Option { option: what, value, wanted: "give finite numbers" });
            }
        }
        Ok(Some(period))
    }
}

/// The number of ticks of a run: one at its start, and after each period before its end (s).
fn ticks(duration: f64, period: f64) -> usize {
    // A period that ends with the run but for a rounding is the last.
    ((duration / period - 1e-9).ceil() as usize).max(1)
}

impl Rollout<'_> {
    /// The inputs of one of all runs.
    pub(crate) fn of_run(&self, run: usize, runs: usize, period: f64) -> Inputs<'_> {
        let part = |all: &'_ [f64]| {
            let width = all.len() / runs;
            run * width..(run + 1) * width
        };
        let Rollout { efforts, targets, feedback, reference, .. } = *self;
        Inputs { period, efforts: &efforts[part(efforts)], targets: &targets[part(targets)], feedback, reference }
    }
}

impl Inputs<'_> {
    /// Makes the steps of a run from tick to tick.
    pub(crate) fn run(&self, model: &Model, simulation: &mut Simulation, duration: f64) -> Result<(), Error> {
        let places = model.coordinates();
        let (width_q, width_v) = (places.q_count(), places.v_count());
        let ticks = ticks(duration, self.period);
        let motors = self.targets.len() / ticks;
        let (mut x, mut law, mut of_state) = (vec![0.0; width_q + width_v], vec![0.0; width_v], vec![0.0; width_v]);
        simulation.together(|simulation| {
            for tick in 0..ticks {
                for (motor, &target) in self.targets[tick * motors..(tick + 1) * motors].iter().enumerate() {
                    simulation.set_target(motor, target)?;
                }
                if !(self.efforts.is_empty() && self.feedback.is_empty()) {
                    let state = simulation.state();
                    let (q, v) = x.split_at_mut(width_q);
                    places.write(model.description(), &state.position, &state.velocity, q, v);
                    law.fill(0.0);
                    if let Some(efforts) = self.efforts.get(tick * width_v..(tick + 1) * width_v) {
                        law.copy_from_slice(efforts);
                    }
                    x.iter_mut().zip(self.reference).for_each(|(x, about)| *x -= about);
                    for (effort, gains) in law.iter_mut().zip(self.feedback.chunks(x.len().max(1))) {
                        *effort -= gains.iter().zip(&x).map(|(gain, x)| gain * x).sum::<f64>();
                    }
                    places.efforts_of_state(model.description(), &state.position, &law, &mut of_state);
                    simulation.set_efforts(&of_state)?;
                }
                let next = (tick + 1) as f64 * self.period;
                simulation.step_to(if tick + 1 == ticks { duration } else { next })?;
            }
            Ok(())
        })
    }
}
