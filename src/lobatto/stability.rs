//! Where the scheme itself becomes unstable, and how near to it a step is.
//!
//! Applied to `y″ = −ω² y`, a step of length h is a 2 × 2 matrix of determinant 1 with equal diagonal entries
//! `t(h²ω²) = Q_s` for `(y, y′) = (1, 0)`,
//!
//! ```text
//!     Q_i = 1 − h²ω² Σ_{k<s} Â_ik Q_k,   i = 2..s,   Q₁ = 1              stable while |t| ≤ 1
//! ```
//!
//! and beyond that no solver helps: the fastest mode grows by `(hω)²` a step. There are gaps, in which |t| exceeds 1 by
//! so little that nothing grows before the motion has left them; those below 1 + 10⁻³ are passed over here.
//!
//! The largest ω of a mechanism at an instant is that of `H δq̈ + K δq = 0` with the joint-space inertia and the geometric
//! stiffness of [`super::dynamics`]. With `w = H⁻¹ K v` the power iteration finds it from below,
//!
//! ```text
//!     ω⁴ ← wᵀ H w / vᵀ H v = wᵀ K v / vᵀ H v,     v ← w        [1/s⁴]
//! ```
//!
//! because `H⁻¹ K` is symmetric in the scalar product of H. Negative eigenvalues (an inverted pendulum) count by their size.
//! The direction is kept from instant to instant, so that one iteration now and then follows the mode.

use super::dynamics::Dynamics;
use super::start::{Plan, Start};
use super::tableau::{MAXIMUM_STAGES, Tableau};
use crate::simulation::FrequencyStep;
use nalgebra::{DMatrix, DVector};
use std::sync::OnceLock;

/// Excess of |t| over 1 that is passed over.
const GAP: f64 = 1e-3;

/// The largest hω up to which steps of this scheme are stable.
pub fn limit(tableau: &Tableau) -> f64 {
    static LIMITS: [OnceLock<f64>; MAXIMUM_STAGES + 1] = [const { OnceLock::new() }; MAXIMUM_STAGES + 1];
    *LIMITS[tableau.stages].get_or_init(|| {
        // Gaps that are more than passed over are wider than this.
        const STRIDE: f64 = 0.02;
        let excess = |frequency: f64| half_trace(tableau, frequency).abs() - 1.0;
        let (mut low, mut frequency) = (0.0, 0.0);
        while excess(frequency) <= GAP {
            if excess(frequency) <= 0.0 {
                low = frequency;
            }
            frequency += STRIDE;
        }
        let mut high = low + STRIDE;
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            *(if excess(middle) <= 0.0 { &mut low } else { &mut high }) = middle;
        }
        low
    })
}

/// Half the trace of the step for `y″ = −ω² y`, as a function of hω.
fn half_trace(tableau: &Tableau, frequency: f64) -> f64 {
    let inner = tableau.stages - 1;
    let square = frequency * frequency;
    let entry = |i: usize, k: usize| square * tableau.a_hat[i * inner + k];
    // The unknowns are Q_2 … Q_{s−1}: rows 0 … s−3 of Â, whose columns 1 … s−2 belong to them.
    let unknowns = inner - 1;
    if unknowns == 0 {
        return 1.0 - entry(0, 0);
    }
    let matrix = DMatrix::from_fn(unknowns, unknowns, |i, k| if i == k { 1.0 } else { 0.0 } + entry(i, k + 1));
    let right = DVector::from_fn(unknowns, |i, _| 1.0 - entry(i, 0));
    let Some(stages) = matrix.lu().solve(&right) else { return f64::INFINITY };
    1.0 - entry(unknowns, 0) - (0..unknowns).map(|k| entry(unknowns, k + 1) * stages[k]).sum::<f64>()
}

/// Steps between two looks at the frequency, each of which costs about half a step.
const INTERVAL: usize = 40;
/// Steps between two looks where a step is more than half as long as it may be.
const CLOSE_INTERVAL: usize = 8;
/// Part of the limit that chosen steps keep to.
const SAFE: f64 = 0.8;

/// When to look at the frequency, and what has been seen.
pub struct Watch {
    limit: f64,
    /// Steps until the next look.
    wait: usize,
    latest: Option<FrequencyStep>,
    nearest: Option<FrequencyStep>,
}

impl Watch {
    /// A watch for a scheme. The first look is after some steps, because a run of few steps has no time for it.
    pub fn new(tableau: &Tableau) -> Self {
        Watch { limit: limit(tableau), wait: CLOSE_INTERVAL, latest: None, nearest: None }
    }

    /// Counts an accepted step; returns the number of power iterations to look with, if it is time to.
    pub fn due(&mut self) -> Option<usize> {
        self.wait -= 1;
        (self.wait == 0).then(|| self.iterations())
    }

    /// The number of power iterations to look with: the first direction is only a guess.
    pub fn iterations(&self) -> usize {
        if self.latest.is_some() { 1 } else { 4 }
    }

    /// The number of power iterations to look with where a step has failed, which has cost more than they do.
    pub fn iterations_after_failure(&self) -> usize {
        4
    }

    /// Takes a look: the frequency at `time`, if it can be known, where steps of `step` are being made.
    pub fn see(&mut self, frequency: Option<f64>, step: f64, time: f64) {
        self.wait = INTERVAL;
        let Some(frequency) = frequency else { return };
        let seen = FrequencyStep { product: step * frequency, limit: self.limit, step, time };
        if seen.product > 0.5 * self.limit {
            self.wait = CLOSE_INTERVAL;
        }
        self.latest = Some(seen);
        // Beyond the limit the motion is soon none that would tell anything: the first such step counts.
        if self.nearest.is_none_or(|nearest| seen.product > nearest.product && !nearest.is_unstable()) {
            self.nearest = Some(seen);
        }
    }

    /// The longest step that is safely stable as far as is known (s).
    pub fn safe_step(&self) -> f64 {
        self.latest.map_or(f64::INFINITY, |seen| SAFE * seen.longest())
    }

    /// What was seen last.
    pub fn latest(&self) -> Option<FrequencyStep> {
        self.latest
    }

    /// The nearest to the limit so far, or the first beyond it.
    pub fn nearest(&self) -> Option<FrequencyStep> {
        self.nearest
    }
}

/// Follows the frequency of the fastest mode.
pub struct Fastest {
    /// The mode.
    direction: Vec<f64>,
    image: Vec<f64>,
}

impl Fastest {
    /// Nothing known yet.
    pub fn new(freedoms: usize) -> Self {
        let mut fastest = Fastest { direction: vec![0.0; freedoms], image: vec![0.0; freedoms] };
        fastest.restart();
        fastest
    }

    /// Forgets the mode.
    fn restart(&mut self) {
        // Any direction will do that has a part in every mode; these numbers have no symmetry of a mechanism.
        for (freedom, value) in self.direction.iter_mut().enumerate() {
            *value = (1.0 + 2.4 * freedom as f64).cos();
        }
    }

    /// The frequency at an instant [rad/s], from below, after some power iterations; zero where nothing is stiff or the state
    /// is not finite.
    pub fn estimate(
        &mut self,
        dynamics: &mut Dynamics,
        plan: &Plan,
        start: &Start,
        gravity: &[f64; 3],
        iterations: usize,
    ) -> f64 {
        dynamics.set(plan, start, gravity);
        let mut power = 0.0;
        for _ in 0..iterations {
            let size = dynamics.stiffness(plan, start, &self.direction, &mut self.image);
            self.direction.copy_from_slice(&self.image);
            dynamics.solve(plan, start, &mut self.direction);
            let product: f64 = self.direction.iter().zip(&self.image).map(|(a, b)| a * b).sum();
            if !(product / size).is_normal() || product < 0.0 {
                self.restart();
                return 0.0;
            }
            power = product / size;
            let scale = 1.0 / product.sqrt();
            self.direction.iter_mut().for_each(|value| *value *= scale);
        }
        power.sqrt().sqrt()
    }
}
