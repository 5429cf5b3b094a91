//! Monitors a run: how near its steps are to the limit of stability ([`catena_lobatto::tableau::stability`]), and whether they leave oscillations.
//!
//! ```text
//!     h ω ≤ 0.8 limit      of the fastest mode, at the first steps and every 40, every 8 once h ω > ½ limit
//!     h γ ≤ 2 s (s − 1)    of what dampers stop at the rate γ, or steps of s/γ stop it
//! ```

use catena_lobatto::tableau::butcher::Tableau;
use catena_lobatto::tableau::stability::{NEAR, limit_for};
use catena_mechanism::motion::integrator::{FrequencyStep, Ringing};

/// Steps between two looks at the frequency, each of which costs about half a step.
const INTERVAL: usize = 40;
/// Steps between two looks where a step is near to the limit.
const CLOSE_INTERVAL: usize = 8;
/// Power iterations of a look without a known mode, because the first direction is only a guess; and of a look at a failed step, which has cost more.
pub const FIRST_LOOK: usize = 4;
/// Part of the limit that chosen steps keep to.
const SAFE: f64 = 0.8;

/// Shorter steps than this part of the time (s) are not made to stop ringing.
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

/// The times of the looks at the frequency, and their results.
#[derive(Clone)]
pub struct Watch {
    tableau: &'static Tableau,
    /// Steps until the first look.
    first: usize,
    /// Steps until the next look.
    wait: usize,
    latest: Option<FrequencyStep>,
    nearest: Option<FrequencyStep>,
    /// The rates γ at which dampers stop the fastest mode and the latest transient [1/s].
    decays: [f64; 2],
    /// The first observed ringing.
    ringing: Option<Ringing>,
    /// The longest step that stops it (s), and its largest rate, until it is taken.
    settling: Option<(f64, f64)>,
    /// Whether ringing is monitored.
    listens: bool,
}

impl Watch {
    /// A watch for a scheme. The first look is after some steps, because a run of few steps has no time for it; with `forces` at once, because
    /// springs may make the run useless after a few.
    pub fn new(tableau: &'static Tableau, forces: bool) -> Self {
        let first = if forces { 1 } else { CLOSE_INTERVAL };
        Watch {
            tableau,
            first,
            wait: first,
            latest: None,
            nearest: None,
            decays: [0.0; 2],
            ringing: None,
            settling: None,
            listens: true,
        }
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

    /// The number of power iterations to look with, if it is time to after one more accepted step.
    pub fn is_due(&self) -> Option<usize> {
        (self.wait == 1).then(|| self.iterations())
    }

    /// The longest step that is safely stable with the fastest mode (s), if steps of `step` are beyond the limit.
    pub fn beyond_limit(&self, mode: Mode, step: f64) -> Option<f64> {
        let seen = self.frequency_step(mode, step, 0.0);
        seen.is_unstable().then(|| SAFE * seen.longest())
    }

    fn frequency_step(&self, mode: Mode, step: f64, time: f64) -> FrequencyStep {
        let product = step * mode.frequency;
        FrequencyStep { product, limit: limit_for(self.tableau, product, mode.damping), step, time }
    }

    /// The number of power iterations to look with.
    pub fn iterations(&self) -> usize {
        if self.latest.is_some() { 1 } else { FIRST_LOOK }
    }

    /// Takes a look: the fastest mode at `time`, where steps of `step` are being made.
    pub fn see(&mut self, mode: Mode, step: f64, time: f64) {
        self.wait = INTERVAL;
        self.decays[0] = 2.0 * mode.damping * mode.frequency;
        let seen = self.frequency_step(mode, step, time);
        if seen.product > NEAR * seen.limit {
            self.wait = CLOSE_INTERVAL;
        }
        self.latest = Some(seen);
        // After the limit the motion soon becomes meaningless: the first such step counts.
        if self.nearest.is_none_or(|nearest| seen.product > nearest.product && !nearest.is_unstable()) {
            self.nearest = Some(seen);
        }
    }

    /// Whether to look for motions that dampers are about to stop.
    pub fn listens(&self) -> bool {
        self.listens
    }

    /// Notes at `time` a motion that dampers are about to stop, if it rings in steps of `step`.
    ///
    /// For long steps the velocity of a damped body changes by the factor `±(1 − 2s(s − 1)/(h γ))` in each
    /// (doc/decisions/007-stability-with-springs-and-dampers.md).
    pub fn hear(&mut self, transient: Transient, step: f64, time: f64) {
        let Transient { decay, rate } = transient;
        self.decays[1] = decay;
        if self.rings(transient, step) {
            let longest = self.tableau.stages as f64 / decay;
            self.ringing = self.ringing.or(Some(Ringing { decay, step, longest, time }));
            self.settling = Some((longest, rate));
            self.listens = false;
        }
    }

    /// Whether a motion that dampers are about to stop rings in steps of `step`.
    pub fn rings(&self, transient: Transient, step: f64) -> bool {
        let s = self.tableau.stages as f64;
        step * transient.decay > 2.0 * s * (s - 1.0)
    }

    /// Whether dampers are too hard for a step (s), as far as is known: half as hard as dampers that reverse a velocity in each step.
    pub fn is_too_hard(&self, step: f64) -> bool {
        let s = self.tableau.stages as f64;
        step * self.hardest() > s * (s - 1.0)
    }

    /// The rate at which the hardest damper stops something, as far as is known [1/s].
    pub fn hardest(&self) -> f64 {
        self.decays[0].max(self.decays[1])
    }

    /// The first observed ringing.
    pub fn ringing(&self) -> Option<Ringing> {
        self.ringing
    }

    /// Takes the next step (s) that stops the ringing, after the first step of a motion: chosen steps grow again from it, and the ringing has ended.
    /// Later ringing comes from the iteration, and is as large in short steps. A run with the `tolerance` (m, rad) ignores ringing that moves less
    /// than this in a second.
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

    /// The latest observation.
    pub fn latest(&self) -> Option<FrequencyStep> {
        self.latest
    }

    /// The nearest to the limit so far, or the first beyond it.
    pub fn nearest(&self) -> Option<FrequencyStep> {
        self.nearest
    }
}
