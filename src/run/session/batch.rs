//! Many runs of one model side by side, a step of all at a time: for learning and for controllers that are compared.
//!
//! ```text
//!     run i: (q_i, v_i), efforts τ_i, targets r_i ──T──▶ (q_i, v_i)        i = 0 … N − 1, on several threads
//! ```
//!
//! Each run has the bits of one [`Simulation`] that is stepped and placed in the same way, for any number of threads.

use crate::session::error::Error;
use crate::session::simulation::Simulation;
use crate::simulation::parallel::threads::on_one_thread;
use std::sync::{Mutex, PoisonError};

/// Runs side by side. Each has a time of its own.
pub struct Batch {
    runs: Vec<Simulation>,
    threads: usize,
    widths: [usize; 3],
}

impl Batch {
    /// So many runs that begin as this one does. Threads share them: 0 stands for all cores.
    ///
    /// # Errors
    /// Invalid settings.
    pub fn new(simulation: &mut Simulation, count: usize, threads: usize) -> Result<Self, Error> {
        let runs = (0..count).map(|_| simulation.copy()).collect::<Result<Vec<_>, _>>()?;
        let model = simulation.model();
        let widths = [model.coordinates().q_count(), model.coordinates().v_count(), model.motor_names().len()];
        let cores = || std::thread::available_parallelism().map_or(1, usize::from);
        Ok(Batch { runs, threads: if threads == 0 { cores() } else { threads }, widths })
    }

    /// Number of runs.
    pub fn count(&self) -> usize {
        self.runs.len()
    }

    /// One run goes on from other coordinates, from time zero ([`Simulation::place`]).
    ///
    /// # Errors
    /// As of [`Simulation::place`], and a run that does not exist.
    pub fn place(&mut self, run: usize, q: &[f64], v: &[f64]) -> Result<(), Error> {
        self.run(run)?.place(0.0, q, v)
    }

    /// A run.
    ///
    /// # Errors
    /// A run that does not exist.
    pub fn run(&mut self, run: usize) -> Result<&mut Simulation, Error> {
        let count = self.runs.len();
        self.runs.get_mut(run).ok_or(Error::Count { what: "the number of a run", given: run, wanted: count })
    }

    /// All runs go on for a duration (s), under efforts (runs × length of v) and targets (runs × motors), which may be empty. Returns the runs that
    /// have failed, with their errors; they stay where they were until they are placed.
    ///
    /// # Errors
    /// Wrong counts of numbers.
    pub fn step(&mut self, duration: f64, efforts: &[f64], targets: &[f64]) -> Result<Vec<(usize, Error)>, Error> {
        let [_, freedoms, motors] = self.widths;
        let count = self.runs.len();
        let rows = [("efforts", efforts.len(), count * freedoms), ("targets", targets.len(), count * motors)];
        if let Some(&(what, given, wanted)) = rows.iter().find(|(_, given, wanted)| *given != 0 && given != wanted) {
            return Err(Error::Count { what, given, wanted });
        }
        let row = |all: &'_ [f64], run: usize, width: usize| {
            if all.is_empty() { 0..0 } else { run * width..(run + 1) * width }
        };
        let failed = Mutex::new(Vec::new());
        let step = |run: usize, simulation: &mut Simulation| {
            let (efforts, targets) = (&efforts[row(efforts, run, freedoms)], &targets[row(targets, run, motors)]);
            let done = step_one(simulation, duration, efforts, targets);
            if let Err(error) = done {
                failed.lock().unwrap_or_else(PoisonError::into_inner).push((run, error));
            }
        };
        let threads = self.threads.min(count).max(1);
        if threads == 1 {
            self.runs.iter_mut().enumerate().for_each(|(run, simulation)| step(run, simulation));
        } else {
            let jobs = Mutex::new(self.runs.iter_mut().enumerate());
            let work = || {
                loop {
                    let next = jobs.lock().unwrap_or_else(PoisonError::into_inner).next();
                    let Some((run, simulation)) = next else { break };
                    step(run, simulation);
                }
            };
            std::thread::scope(|scope| {
                for _ in 1..threads {
                    scope.spawn(|| on_one_thread(work));
                }
                on_one_thread(work);
            });
        }
        let mut failed = failed.into_inner().unwrap_or_else(PoisonError::into_inner);
        failed.sort_unstable_by_key(|(run, _)| *run);
        Ok(failed)
    }

    /// Writes q (runs × length of q) and v (runs × length of v) of all runs, without allocating.
    ///
    /// # Errors
    /// Wrong counts of numbers.
    pub fn write_coordinates(&self, q: &mut [f64], v: &mut [f64]) -> Result<(), Error> {
        let [width_q, width_v, _] = self.widths;
        let count = self.runs.len();
        for (what, given, wanted) in [("q", q.len(), count * width_q), ("v", v.len(), count * width_v)] {
            if given != wanted {
                return Err(Error::Count { what, given, wanted });
            }
        }
        let rows = q.chunks_mut(width_q.max(1)).zip(v.chunks_mut(width_v.max(1)));
        self.runs.iter().zip(rows).try_for_each(|(run, (q, v))| run.write_coordinates(q, v))
    }
}

/// One run goes on.
fn step_one(simulation: &mut Simulation, duration: f64, efforts: &[f64], targets: &[f64]) -> Result<(), Error> {
    if !targets.is_empty() {
        simulation.set_targets(targets)?;
    }
    if !efforts.is_empty() {
        simulation.set_efforts(efforts)?;
    }
    simulation.step_to(simulation.time() + duration)
}
