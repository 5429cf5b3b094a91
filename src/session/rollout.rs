//! Many runs of one model from many starts, in parallel.
//!
//! Each run is bit-identical to the run of a [`Simulation`](crate::session::Simulation) from the same start, for any number of threads.

use crate::mechanism::motion::integrator::MethodDescription;
use crate::model::Start;
use crate::session::asked::{Asked, Settled};
use crate::session::error::Error;
use crate::session::held_start::mechanism_from;
use crate::session::model::Model;
use crate::simulation::parallel::threads::on_one_thread;
use crate::simulation::{Observer, ObserverError, RunError, Sample, Simulation, SimulationOptions};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

/// The options of all runs.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rollout<'r> {
    /// Simulated time (s); by default that of the file, or 10 s.
    pub duration: Option<f64>,
    /// Wanted accuracy of positions (m); by default the accuracy of the file, or 1e-6 m.
    pub tolerance: Option<f64>,
    /// Stages and length of steps (s), instead of a tolerance.
    pub fixed: Option<(usize, f64)>,
    /// Samples per simulated second; `None` for the start and the end only.
    pub rate: Option<f64>,
    /// Number of threads; 0 for all cores.
    pub threads: usize,
    /// A flag that ends all runs when it is set.
    pub interrupt: Option<&'r AtomicBool>,
}

/// The results of the runs.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Trajectories {
    /// Number of runs.
    pub runs: usize,
    /// Times of the samples (s), the same for all runs.
    pub times: Vec<f64>,
    /// q of every sample of every run (runs × samples × length of q); NaN after the failure of a run.
    pub q: Vec<f64>,
    /// v of every sample of every run (runs × samples × length of v); NaN after the failure of a run.
    pub v: Vec<f64>,
    /// Runs that failed, and their errors.
    pub failures: Vec<(usize, String)>,
}

impl Model {
    /// Runs the model from each of the starts: q0 (runs × length of q) and v0 (runs × length of v), one run after another.
    ///
    /// ```
    /// use catena::prelude::*;
    /// use catena::session::Rollout;
    ///
    /// let model = Model::load("robots/double_pendulum.urdf")?;
    /// let (q0, v0) = ([0.1, 0.0, 0.2, 0.0], [0.0; 4]);
    /// let runs = model.rollout(&q0, &v0, &Rollout { duration: Some(1.0), rate: Some(10.0), ..Rollout::default() })?;
    /// assert_eq!((runs.runs, runs.times.len(), runs.q.len()), (2, 11, 2 * 11 * 2));
    /// # Ok::<(), catena::session::Error>(())
    /// ```
    ///
    /// # Errors
    /// Wrong lengths, numbers that are not finite, invalid options, an interruption. A run that fails is listed in [`Trajectories::failures`], and
    /// the others continue.
    pub fn rollout(&self, q0: &[f64], v0: &[f64], options: &Rollout) -> Result<Trajectories, Error> {
        let Rollout { duration, tolerance, fixed, rate, threads, interrupt } = *options;
        let settled =
            Asked { duration, tolerance, fixed, rate, ..Asked::default() }.settle(&self.loaded().simulation)?;
        let (width_q, width_v) = (self.coordinates().q_count(), self.coordinates().v_count());
        let runs = q0.len().checked_div(width_q).unwrap_or(0);
        if q0.len() != runs * width_q {
            return Err(Error::Count { what: "q0, a row a run", given: q0.len(), wanted: (runs + 1) * width_q });
        }
        if v0.len() != runs * width_v {
            return Err(Error::Count { what: "v0, a row a run", given: v0.len(), wanted: runs * width_v });
        }
        for (q, v) in q0.chunks(width_q.max(1)).zip(v0.chunks(width_v.max(1))) {
            self.coordinates().check("q0", q, width_q, |joint| &joint.q)?;
            self.coordinates().check("v0", v, width_v, |joint| &joint.v)?;
        }
        let times = sample_times(settled.duration, rate);
        let samples = times.len();
        let (mut q, mut v) = (vec![f64::NAN; runs * samples * width_q], vec![f64::NAN; runs * samples * width_v]);
        let starts = q0.chunks(width_q.max(1)).zip(v0.chunks(width_v.max(1)));
        let places = q.chunks_mut((samples * width_q).max(1)).zip(v.chunks_mut((samples * width_v).max(1)));
        let jobs = Mutex::new(starts.zip(places).enumerate());
        let failures = Mutex::new(Vec::new());
        let interrupted = || interrupt.is_some_and(|flag| flag.load(Ordering::Relaxed));
        let work = || {
            while !interrupted() {
                let next = jobs.lock().unwrap_or_else(PoisonError::into_inner).next();
                let Some((run, ((q0, v0), (q, v)))) = next else { break };
                let rows = Rows { model: self, q, v, widths: (width_q, width_v), filled: 0 };
                if let Err(error) = self.run_into(q0, v0, settled, rate, interrupt, rows) {
                    failures.lock().unwrap_or_else(PoisonError::into_inner).push((run, error.to_string()));
                }
            }
        };
        let cores = || std::thread::available_parallelism().map_or(1, usize::from);
        let threads = if threads == 0 { cores() } else { threads }.min(runs).max(1);
        std::thread::scope(|scope| {
            for _ in 1..threads {
                scope.spawn(|| on_one_thread(work));
            }
            on_one_thread(work);
        });
        if interrupted() {
            return Err(RunError::Interrupted { time: 0.0 }.into());
        }
        let mut failures = failures.into_inner().unwrap_or_else(PoisonError::into_inner);
        failures.sort_unstable_by_key(|(run, _)| *run);
        Ok(Trajectories { runs, times, q, v, failures })
    }

    /// One run.
    fn run_into(
        &self,
        q0: &[f64],
        v0: &[f64],
        settled: Settled,
        rate: Option<f64>,
        interrupt: Option<&AtomicBool>,
        mut rows: Rows,
    ) -> Result<(), Error> {
        let description = self.description();
        let start = self.coordinates().state(description, q0, v0)?;
        let started = self.loaded().settled(start, &Start::default())?;
        let Settled { duration, choice, .. } = settled;
        let options = SimulationOptions { duration, steps: choice, switched_off: &[], interrupt };
        let driven = mechanism_from(description, &started.state);
        let mut simulation = Simulation::at_once(&driven, started.state, started.counted, options)?;
        if let Some(rate) = rate {
            simulation.sample_at(rate);
        }
        simulation.leave_out_figures();
        simulation.observe(&mut rows);
        Ok(simulation.run()?)
    }
}

/// Sample times of a run: `k/rate`, and its end.
fn sample_times(duration: f64, rate: Option<f64>) -> Vec<f64> {
    let Some(rate) = rate else { return vec![0.0, duration] };
    let inside = (0_u64..).map(|k| k as f64 / rate).take_while(|&time| time < duration);
    inside.chain([duration]).collect()
}

/// The destination of a run's samples.
struct Rows<'r> {
    model: &'r Model,
    q: &'r mut [f64],
    v: &'r mut [f64],
    widths: (usize, usize),
    filled: usize,
}

impl Observer for Rows<'_> {
    fn begin_again(&mut self, _: &MethodDescription) -> Result<(), ObserverError> {
        self.filled = 0;
        Ok(())
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), ObserverError> {
        let Rows { model, q, v, widths: (width_q, width_v), filled } = self;
        let rows = (q.get_mut(*filled * *width_q..), v.get_mut(*filled * *width_v..));
        if let (Some(q), Some(v)) = rows
            && q.len() >= *width_q
        {
            let (q, v) = (&mut q[..*width_q], &mut v[..*width_v]);
            model.coordinates().write(model.description(), sample.position, sample.velocity, q, v);
        }
        *filled += 1;
        Ok(())
    }
}
