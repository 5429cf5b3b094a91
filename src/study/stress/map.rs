//! All runs of a problem, on several threads, with results that do not depend on how many or in which order.

use crate::chart::Setting;
use crate::mechanism::description::mechanism::MechanismError;
use crate::stress::cell::{Cell, Verdict};
use crate::stress::method::Method;
use crate::stress::problem::{Case, ThinnedProblem};
use crate::stress::truth::Answer;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread;

/// Why there is no map.
#[derive(Debug, thiserror::Error)]
pub enum StressError {
    /// The bodies of a case are no mechanism.
    #[error(transparent)]
    Mechanism(#[from] MechanismError),
    /// The user asked to stop.
    #[error("interrupted")]
    Interrupted,
}

/// The result of a problem.
#[derive(Clone, Debug)]
pub struct Map {
    /// The mapped problem.
    pub thinned: ThinnedProblem,
    /// The methods, ours first.
    pub methods: [Method; Method::ALL.len()],
    /// For each row, what its right end is.
    pub answers: Vec<Answer>,
    /// Every run: method by method, row by row, coarse settings first.
    pub cells: Vec<Cell>,
}

impl Map {
    /// Runs everything. `told` hears what fraction of the work is behind.
    ///
    /// # Errors
    /// [`StressError`].
    pub fn run(
        thinned: ThinnedProblem,
        threads: usize,
        interrupt: &AtomicBool,
        told: &(dyn Fn(f64) + Sync),
    ) -> Result<Self, StressError> {
        let problem = &thinned.problem;
        let cases = thinned.places.iter().map(|&place| (problem.build)(place)).collect::<Result<Vec<Case>, _>>()?;
        let answers = side_by_side(threads, cases.len(), |row| {
            told(0.0);
            Answer::of(&cases[row], interrupt)
        })
        .ok_or(StressError::Interrupted)?;
        let methods = cases.first().map_or(Method::ALL, |case| Method::of(&case.mechanism));
        let jobs: Vec<(Method, usize, Setting)> = methods
            .into_iter()
            .flat_map(|method| (0..cases.len()).map(move |row| (method, row)))
            .flat_map(|(method, row)| method.settings(problem).into_iter().map(move |setting| (method, row, setting)))
            .collect();
        let done = AtomicUsize::new(0);
        let cells = side_by_side(threads, jobs.len(), |job| {
            let (method, row, setting) = jobs[job];
            let cell = Cell::run(&cases[row], &answers[row], method, setting, thinned.places[row], interrupt);
            told((done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / jobs.len() as f64);
            cell
        })
        .ok_or(StressError::Interrupted)?;
        Ok(Map { thinned, methods, answers, cells })
    }

    /// The cell of a method, a row and a column.
    pub fn cell(&self, method: Method, row: usize, column: usize) -> Option<&Cell> {
        let place = *self.thinned.places.get(row)?;
        self.cells.iter().filter(|cell| cell.method == method && cell.place == place).nth(column)
    }

    /// How many cells of a method ended so.
    pub fn count(&self, method: Method, verdict: Verdict) -> usize {
        self.cells.iter().filter(|cell| cell.method == method && cell.verdict == verdict).count()
    }

    /// Cells of ours that are defects.
    pub fn defects(&self) -> impl Iterator<Item = &Cell> {
        self.cells.iter().filter(|cell| cell.method.is_ours() && cell.is_silent_garbage())
    }
}

/// Does jobs `0..count` on some threads; the results in the order of the jobs, `None` if any job returns `None`.
fn side_by_side<T: Send>(threads: usize, count: usize, job: impl Fn(usize) -> Option<T> + Sync) -> Option<Vec<T>> {
    let next = AtomicUsize::new(0);
    let results: Vec<Mutex<Option<T>>> = (0..count).map(|_| Mutex::new(None)).collect();
    thread::scope(|scope| {
        for _ in 0..threads.max(1) {
            scope.spawn(|| {
                loop {
                    let place = next.fetch_add(1, Ordering::Relaxed);
                    let Some(slot) = results.get(place) else { break };
                    let Some(result) = job(place) else { break };
                    if let Ok(mut slot) = slot.lock() {
                        *slot = Some(result);
                    }
                }
            });
        }
    });
    results.into_iter().map(|slot| slot.into_inner().ok().flatten()).collect()
}
