//! What is asked of many runs, and what they leave.

use crate::mechanism::motion::contact_point::ContactPoint;
use std::sync::atomic::AtomicBool;

/// The options of all runs.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rollout<'r> {
    /// Simulated time (s); by default that of the file, or 10 s.
    pub duration: Option<f64>,
    /// Wanted accuracy of positions (m); by default that of the file, or 1e-6 m.
    pub tolerance: Option<f64>,
    /// Stages and length of steps (s), instead of a tolerance.
    pub fixed: Option<(usize, f64)>,
    /// Whether runs with a tolerance leave out the estimate of their error, for about half of the time.
    pub no_estimate: bool,
    /// Samples per simulated second; `None` for the start and the end only.
    pub rate: Option<f64>,
    /// Number of threads; 0 for all cores.
    pub threads: usize,
    /// A flag that ends all runs when it is set.
    pub interrupt: Option<&'r AtomicBool>,
    /// The time between ticks (s), for efforts, targets and feedback.
    pub period: Option<f64>,
    /// Efforts u along v (runs × ticks × length of v) [N m or N]; or empty.
    pub efforts: &'r [f64],
    /// Targets of motors (runs × ticks × motors), in the order of [`motor_names`](crate::session::Model::motor_names); or empty.
    pub targets: &'r [f64],
    /// The gain K of a feedback (length of v × (length of q + length of v)), row after row; or empty.
    pub feedback: &'r [f64],
    /// The q and v about which the feedback acts, x̄; or empty for zeros.
    pub reference: &'r [f64],
    /// Numbers by their key paths ([`with_params`](crate::session::Model::with_params)): one for each run.
    pub params: &'r [(String, Vec<f64>)],
    /// Whether energies are wanted.
    pub energies: bool,
    /// Whether contacts are wanted.
    pub contacts: bool,
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
    /// Kinetic, potential, spring and load energy of every sample of every run (runs × samples × 4) (J), if they were wanted; NaN after a failure.
    pub energies: Vec<f64>,
    /// The closed contacts of each run, with the indices of their samples, if they were wanted.
    pub contacts: Vec<Vec<(usize, Vec<ContactPoint>)>>,
    /// Warnings of each run: about a start that was moved.
    pub warnings: Vec<Vec<String>>,
    /// Runs that failed, and their errors.
    pub failures: Vec<(usize, String)>,
}
