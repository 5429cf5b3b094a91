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
//! so little that nothing grows before the motion has left them; those below 1 + 10⁻³ are passed over in the limits.
//!
//! With a damper of ratio ζ, `y″ = −ω² y − 2ζω y′`, forces enter at all stages and the step is stable further than that:
//!
//! ```text
//!     F = −ω² Y − 2ζω V,   V = v₀ + h Ā F,   Y = y₀ + h A V,   y₁ = y₀ + h bᵀV,   v₁ = v₀ + h bᵀF
//! ```
//!
//! while no eigenvalue of `(y₀, v₀) → (y₁, v₁)` exceeds 1 in size; for ζ ≥ ½ up to `(s − 1) √(2s)`, which is where the limit for
//! ζ → ∞ is found to lie, and the least for such ζ within 2·10⁻³ (benches/README.md).
//!
//! The largest ω of a mechanism at an instant is that of `H δq̈ + K δq = 0` with the joint-space inertia and the geometric
//! stiffness of [`super::dynamics`]. With `w = H⁻¹ K v` the power iteration finds it from below,
//!
//! ```text
//!     ω⁴ ← wᵀ H w / vᵀ H v = wᵀ K v / vᵀ H v,     v ← w        [1/s⁴]
//! ```
//!
//! because `H⁻¹ K` is symmetric in the scalar product of H. Negative eigenvalues (an inverted pendulum) count by their size.
//! The direction is kept from instant to instant, so that one iteration now and then follows the mode. With forces and
//! closures [`super::linearised`] does the same.

use super::dynamics::Dynamics;
use super::start::{Plan, Start};
use super::tableau::{MAXIMUM_STAGES, Tableau};
use crate::integrator::{FrequencyStep, Ringing};
use nalgebra::{DMatrix, DVector, Matrix2};
use std::sync::OnceLock;

/// The largest hω up to which steps of 2 … 16 stages are stable. A table, because to find the nine stages' took half of the instructions of a
/// short run; the test below finds all of them anew.
const LIMITS: [f64; MAXIMUM_STAGES - 1] = [
    2.0,
    2.828_427_124_746,
    5.477_225_575_052,
    6.054_049_612_981,
    8.841_474_277_144,
    9.267_346_059_619,
    12.153_145_457_687,
    12.460_979_479_641,
    15.422_567_576_793,
    15.638_352_468_954,
    18.656_610_944_197,
    21.589_891_148_239,
    21.862_695_365_507,
    24.850_194_818_772,
    25.048_060_690_956,
];

/// The largest hω up to which steps of this scheme are stable.
pub fn limit(tableau: &Tableau) -> f64 {
    LIMITS[tableau.stages - 2]
}

/// Damping ratios for which limits are found.
const RATIOS: [f64; 6] = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5];

/// The largest hω up to which steps of this scheme are stable for a mode: found for the next lower of some damping
/// ratios, because the limit grows with it up to ½, and only where the mode comes near to what is stable without damping.
fn limit_for(tableau: &Tableau, product: f64, damping: f64) -> f64 {
    static LIMITS: [[OnceLock<f64>; RATIOS.len()]; MAXIMUM_STAGES + 1] =
        [const { [const { OnceLock::new() }; RATIOS.len()] }; MAXIMUM_STAGES + 1];
    let undamped = limit(tableau);
    let Some(ratio) = RATIOS.iter().rposition(|&ratio| ratio <= damping).filter(|_| product > NEAR * undamped) else {
        return undamped;
    };
    *LIMITS[tableau.stages][ratio].get_or_init(|| damped_limit(tableau, RATIOS[ratio]))
}

/// The largest hω up to which steps of this scheme are stable for `y″ = −ω² y − 2ζω y′`; not less than without damping.
pub fn damped_limit(tableau: &Tableau, ratio: f64) -> f64 {
    let undamped = limit(tableau);
    let stages = tableau.stages as f64;
    let hard = (stages - 1.0) * (2.0 * stages).sqrt();
    if ratio >= 0.5 {
        return hard;
    }
    // What is unstable for less than this is passed in few steps, and grows by less than what follows.
    const STRIDE: f64 = 0.05;
    let mut frequency = undamped;
    while frequency < hard && growth(tableau, frequency + STRIDE, ratio) <= 1.0 {
        frequency += STRIDE;
    }
    frequency
}

/// Growth of the solutions of `y″ = −ω² y − 2ζω y′` in one step with h = 1: the spectral radius of the step.
fn growth(tableau: &Tableau, omega: f64, ratio: f64) -> f64 {
    let s = tableau.stages;
    let (stiffness, damping) = (omega * omega, 2.0 * ratio * omega);
    let a = DMatrix::from_row_slice(s, s, &tableau.a);
    let a_bar = DMatrix::from_row_slice(s, s, &tableau.a_bar);
    let weights = DVector::from_column_slice(&tableau.weights);
    let ones = DVector::from_element(s, 1.0);
    let along = &a * &ones;
    let system = (DMatrix::identity(s, s) + &a * &a_bar * stiffness + &a_bar * damping).lu();
    let (Some(by_position), Some(by_velocity)) =
        (system.solve(&(&ones * -stiffness)), system.solve(&(along * -stiffness - &ones * damping)))
    else {
        return f64::INFINITY;
    };
    let step = Matrix2::new(
        1.0 + weights.dot(&(&a_bar * &by_position)),
        1.0 + weights.dot(&(&a_bar * &by_velocity)),
        weights.dot(&by_position),
        1.0 + weights.dot(&by_velocity),
    );
    step.complex_eigenvalues().iter().map(|value| value.norm()).fold(0.0, f64::max)
}

/// Steps between two looks at the frequency, each of which costs about half a step.
const INTERVAL: usize = 40;
/// Part of the limit from where a step is near to it.
const NEAR: f64 = 0.5;
/// Steps between two looks where a step is near to the limit.
const CLOSE_INTERVAL: usize = 8;
/// Part of the limit that chosen steps keep to.
const SAFE: f64 = 0.8;

/// Shorter steps than this part of the time (s) are not made to stop what rings.
const SHORTEST: f64 = 1e-9;

/// A mode of the linearised motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mode {
    /// ω [rad/s].
    pub frequency: f64,
    /// ζ.
    pub damping: f64,
}

/// A motion that dampers are about to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transient {
    /// γ [1/s].
    pub decay: f64,
    /// The largest rate of any coordinate in it, w [rad/s, m/s].
    pub rate: f64,
}

/// When to look at the frequency, and what has been seen.
pub struct Watch {
    tableau: &'static Tableau,
    /// Steps until the first look,
    first: usize,
    /// and until the next.
    wait: usize,
    latest: Option<FrequencyStep>,
    nearest: Option<FrequencyStep>,
    /// What was seen to ring first.
    ringing: Option<Ringing>,
    /// The longest step that stops it (s), and its largest rate, until it is taken.
    settling: Option<(f64, f64)>,
    /// Whether anybody wants to know what rings.
    listens: bool,
}

impl Watch {
    /// A watch for a scheme. The first look is after some steps, because a run of few steps has no time for it; with `forces`
    /// at once, because springs may leave nothing to look at after a few.
    pub fn new(tableau: &'static Tableau, forces: bool) -> Self {
        let first = if forces { 1 } else { CLOSE_INTERVAL };
        Watch { tableau, first, wait: first, latest: None, nearest: None, ringing: None, settling: None, listens: true }
    }

    /// Forgets the last look: the motion goes on from somewhere else.
    pub fn forget(&mut self) {
        self.latest = None;
        self.wait = self.first;
        self.listens = true;
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

    /// Takes a look: the fastest mode at `time`, where steps of `step` are being made.
    pub fn see(&mut self, mode: Mode, step: f64, time: f64) {
        self.wait = INTERVAL;
        let product = step * mode.frequency;
        let limit = limit_for(self.tableau, product, mode.damping);
        let seen = FrequencyStep { product, limit, step, time };
        if product > NEAR * limit {
            self.wait = CLOSE_INTERVAL;
        }
        self.latest = Some(seen);
        // Beyond the limit the motion is soon none that would tell anything: the first such step counts.
        if self.nearest.is_none_or(|nearest| seen.product > nearest.product && !nearest.is_unstable()) {
            self.nearest = Some(seen);
        }
    }

    /// Whether to look for what dampers are about to stop.
    pub fn listens(&self) -> bool {
        self.listens
    }

    /// Notes at `time` what dampers are about to stop, if it rings in steps of `step`.
    ///
    /// For long steps the velocity of a damped body changes by the factor `±(1 − 2s(s − 1)/(h γ))` in each (benches/README.md).
    pub fn hear(&mut self, Transient { decay, rate }: Transient, step: f64, time: f64) {
        let s = self.tableau.stages as f64;
        if step * decay > 2.0 * s * (s - 1.0) {
            let longest = s / decay;
            self.ringing = self.ringing.or(Some(Ringing { decay, step, longest, time }));
            self.settling = Some((longest, rate));
            self.listens = false;
        }
    }

    /// What was seen to ring first.
    pub fn ringing(&self) -> Option<Ringing> {
        self.ringing
    }

    /// Takes the next step (s) that stops what rings, after the first step of a motion: steps that are chosen grow again from it, with nothing
    /// left to ring. What rings later is not the motion but what iterations leave, which is as large in short steps; and what is slower than
    /// the `tolerance` (m, rad) in a second is nothing to a run that wants no more.
    pub fn take_settling(&mut self, time: f64, tolerance: f64) -> Option<f64> {
        self.listens = false;
        let (settling, rate) = self.settling.take()?;
        let matters = rate > tolerance;
        if matters && settling <= SHORTEST * time {
            return None;
        }
        self.ringing = None;
        matters.then_some(settling)
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

/// A direction that has a part in every mode: these numbers have no symmetry of a mechanism.
pub(super) fn first_guess(freedom: usize) -> f64 {
    (1.0 + 2.4 * freedom as f64).cos()
}

/// Follows the frequency of the fastest mode of a tree under gravity.
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
        for (freedom, value) in self.direction.iter_mut().enumerate() {
            *value = first_guess(freedom);
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Excess of |t| over 1 that is passed over.
    const GAP: f64 = 1e-3;
    /// Gaps that are more than passed over are wider than this.
    const STRIDE: f64 = 0.02;

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
        let stages = matrix.lu().solve(&right).expect("regular below the limit");
        1.0 - entry(unknowns, 0) - (0..unknowns).map(|k| entry(unknowns, k + 1) * stages[k]).sum::<f64>()
    }

    #[test]
    fn the_table_of_limits_is_where_the_trace_of_a_step_leaves_one() {
        for stages in 2..=MAXIMUM_STAGES {
            let tableau = Tableau::of(stages).expect("in range");
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
            // The digits of the table.
            assert!((limit(tableau) - low).abs() < 1e-11, "{stages} stages: {low:?}");
        }
    }
}
