//! Many runs of one model from many starts, in parallel.
//!
//! Each run is bit-identical to that of [`Simulation`](crate::session::Simulation) from the same start, for any number of threads. It may have
//! numbers of its own, and efforts and targets of motors of its own at ticks, between which they are held:
//!
//! ```text
//!     τ(t) = u_k − K (x_k − x̄)      for t_k ≤ t < t_{k+1},  t_k = k T       x = (q, v),  K: n × (length of q + length of v),  T: the period (s)
//! ```

use crate::mechanism::motion::contact_point::ContactPoint;
use crate::mechanism::motion::energy::energy_with_forces;
use crate::mechanism::motion::integrator::MethodDescription;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use crate::model::Start;
use crate::session::asked::{Asked, Settled};
use crate::session::error::Error;
use crate::session::held_start::mechanism_from;
use crate::session::many::{Rollout, Trajectories};
use crate::session::model::Model;
use crate::session::ticks::Inputs;
use crate::simulation::parallel::threads::on_one_thread;
use crate::simulation::{Observer, ObserverError, RunError, Sample, Simulation, SimulationOptions};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

impl Model {
    /// Runs the model from each of the starts: q0 (runs × length of q) and v0 (runs × length of v), one run after another.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
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
    /// Wrong lengths, numbers that are not finite, unknown key paths, invalid options, an interruption. A run that fails is listed in [`Trajectories::failures`], and
    /// the others continue.
    pub fn rollout(&self, q0: &[f64], v0: &[f64], options: &Rollout) -> Result<Trajectories, Error> {
        let Rollout { duration, tolerance, no_estimate, fixed, rate, threads, interrupt, .. } = *options;
        let asked = Asked { duration, tolerance, no_estimate, fixed, rate, ..Asked::default() };
        let settled = asked.settle(&self.loaded().simulation)?;
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
        self.know_numbers(options.params.iter().map(|(key, _)| key.as_str()))?;
        let period = self.check_inputs(runs, settled.duration, options)?;
        let times = sample_times(settled.duration, rate);
        let samples = times.len();
        let (mut q, mut v) = (vec![f64::NAN; runs * samples * width_q], vec![f64::NAN; runs * samples * width_v]);
        let width_energy = if options.energies { 4 } else { 0 };
        let mut energies = vec![f64::NAN; runs * samples * width_energy];
        let mut beside: Vec<Beside> = std::iter::repeat_with(Beside::default).take(runs).collect();
        let starts = q0.chunks(width_q.max(1)).zip(v0.chunks(width_v.max(1)));
        let places = q.chunks_mut((samples * width_q).max(1)).zip(v.chunks_mut((samples * width_v).max(1)));
        let mut energy_rows = energies.chunks_mut((samples * width_energy).max(1));
        let places =
            places.zip(&mut beside).map(|(place, beside)| (place, energy_rows.next().unwrap_or_default(), beside));
        let jobs = Mutex::new(starts.zip(places).enumerate());
        let failures = Mutex::new(Vec::new());
        let interrupted = || interrupt.is_some_and(|flag| flag.load(Ordering::Relaxed));
        let work = || {
            while !interrupted() {
                let next = jobs.lock().unwrap_or_else(PoisonError::into_inner).next();
                let Some((run, ((q0, v0), ((q, v), energies, beside)))) = next else { break };
                let inputs = period.map(|period| options.of_run(run, runs, period));
                let numbers = options.params.iter().map(|(key, numbers)| (key.clone(), numbers[run]));
                let own = if options.params.is_empty() { Ok(self.clone()) } else { self.with_params(numbers) };
                let made = own.and_then(|model| {
                    let keeps_contacts = options.contacts;
                    let rows = Rows {
                        model: &model,
                        q,
                        v,
                        energies,
                        beside,
                        keeps_contacts,
                        widths: (width_q, width_v),
                        filled: 0,
                    };
                    model.run_into(q0, v0, settled, rate, interrupt, inputs, rows)
                });
                if let Err(error) = made {
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
        let (contacts, warnings) = beside.into_iter().map(|beside| (beside.contacts, beside.warnings)).unzip();
        Ok(Trajectories { runs, times, q, v, energies, contacts, warnings, failures })
    }

    /// One run.
    #[expect(clippy::too_many_arguments, reason = "the start, what is wanted, what acts, and where it goes are apart")]
    fn run_into(
        &self,
        q0: &[f64],
        v0: &[f64],
        settled: Settled,
        rate: Option<f64>,
        interrupt: Option<&AtomicBool>,
        inputs: Option<Inputs>,
        mut rows: Rows,
    ) -> Result<(), Error> {
        let description = self.description();
        let start = self.coordinates().state(description, q0, v0)?;
        let started = self.loaded().settled(start, &Start::default())?;
        rows.beside.warnings = started.warnings.iter().map(ToString::to_string).collect();
        let Settled { duration, choice, .. } = settled;
        let options = SimulationOptions {
            interrupt,
            counted: started.counted.as_ref(),
            stepped: inputs.is_some(),
            figures: false,
            ..SimulationOptions::new(duration, choice)
        };
        let driven = mechanism_from(description, &started.state);
        let mut simulation = Simulation::new(&driven, started.state, options)?;
        if let Some(rate) = rate {
            simulation.sample_at(rate);
        }
        simulation.observe(&mut rows);
        match inputs {
            None => Ok(simulation.run()?),
            Some(inputs) => inputs.run(self, &mut simulation, duration),
        }
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
    energies: &'r mut [f64],
    beside: &'r mut Beside,
    keeps_contacts: bool,
    widths: (usize, usize),
    filled: usize,
}

/// What else a run leaves.
#[derive(Default)]
struct Beside {
    contacts: Vec<(usize, Vec<ContactPoint>)>,
    warnings: Vec<String>,
}

impl Observer for Rows<'_> {
    fn begin_again(&mut self, _: &MethodDescription) -> Result<(), ObserverError> {
        self.filled = 0;
        self.beside.contacts.clear();
        Ok(())
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), ObserverError> {
        let Rows { model, q, v, energies, widths: (width_q, width_v), filled, .. } = self;
        let rows = (q.get_mut(*filled * *width_q..), v.get_mut(*filled * *width_v..));
        if let (Some(q), Some(v)) = rows
            && q.len() >= *width_q
        {
            let (q, v) = (&mut q[..*width_q], &mut v[..*width_v]);
            model.coordinates().write(model.description(), sample.position, sample.velocity, q, v);
        }
        if let Some(row) = energies.get_mut(4 * *filled..4 * (*filled + 1)) {
            let (time, compensation) = (sample.time, vec![0.0; sample.position.len()]);
            let (position, velocity) = (sample.position.to_vec(), sample.velocity.to_vec());
            let state = State { time, position, velocity, compensation };
            let mechanism = &model.description().mechanism;
            let energy = energy_with_forces(mechanism, &state.position, &body_states(mechanism, &state));
            row.copy_from_slice(&[energy.kinetic, energy.potential, energy.spring, energy.load]);
        }
        *filled += 1;
        Ok(())
    }

    fn contacts(&mut self, points: &[ContactPoint]) {
        if self.keeps_contacts && !points.is_empty() {
            self.beside.contacts.push((self.filled, points.to_vec()));
        }
    }
}
