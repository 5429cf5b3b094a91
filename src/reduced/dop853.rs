//! DOP853 in joint coordinates: the explicit Runge–Kutta method of Dormand and Prince of order 8, with step control.
//!
//! ```text
//!     Y_i = y₀ + h Σ_{j<i} a_ij k_j,   k_i = f(Y_i),   i = 1..12            y₁ = y₀ + h Σ b_i k_i
//!     e₅ = h Σ (b_i − b̂_i) k_i,   e₃ = h Σ (b_i − b̃_i) k_i                  the embedded orders 5 and 3
//!     err = |e₅|² / √(|e₅|² + 0.01 |e₃|²)                                   accepted if err ≤ 1; of order h⁸
//!     h_new = h · min(6, max(1/3, 0.9 err^(−(1/8 − β/5)) err_before^β))      β = 0.04: proportional-integral control
//! ```
//!
//! `|e|` is the root mean square of `e_j / (tol (1 + max(|y₀|, |y₁|)))`: absolute and relative tolerance are the same
//! number, in the units of each entry. The slope at y₁ is the first of the next step, so a step costs 12 evaluations.
//! Dense output has order 7 and costs three evaluations in each step that is asked for it.
//!
//! Source: E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed., Springer 1993,
//! sections II.4 (initial step, control), II.6 (dense output) and II.10 (error estimate), with the constants of the
//! authors' code.

use crate::dop853_step::{END_SLOPE, ORDER, Work};
use crate::dop853_table::SOLUTION;
use crate::ode::{ReducedOde, joint_of_entry};
use catena_mechanism::description::closure::Coordinate;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::ground::guarded::Guarded;
use catena_mechanism::motion::inputs::Inputs;
use catena_mechanism::motion::integrator::{Cost, Integrator, MethodDescription, Rejected, StepError, StepOutcome};
use catena_mechanism::motion::state::State;
use catena_stepping::step_maker::{PieceSteps, StepFigures, StepMaker, StepPace};

/// Factor on the step that the error estimate asks for.
const SAFETY: f64 = 0.9;
/// Bounds of the ratio of a step to the one before.
const SHRINK_LIMIT: f64 = 1.0 / 3.0;
const GROWTH_LIMIT: f64 = 6.0;
/// The weight of the error before in the choice of the next step. The authors' code has 0 and allows 0.04, which is
/// the better rival: half the rejections, and 8 % less work for the same error on the four reference scenes.
const INTEGRAL_GAIN: f64 = 0.04;
/// An error before that is smaller than this counts as this.
const LEAST_ERROR_BEFORE: f64 = 1e-4;
/// The end is reached with a step longer by up to this factor, so that no sliver of a step remains.
const STRETCH: f64 = 1.01;

/// DOP853 with a step chosen from a tolerance, or with a fixed one.
#[derive(Clone, Debug)]
pub struct Dop853 {
    control: Control,
    /// Step to try next [s]; `None` before the first step.
    next_step: Option<f64>,
    /// The error of the last accepted step, in units of the tolerance.
    error_before: f64,
    start_time: f64,
    end_time: f64,
    accepted: usize,
    accepted_time: f64,
    /// Efforts that drive the joints.
    efforts: Vec<f64>,
    /// In a cell because dense output evaluates further slopes, and only when it is asked for.
    work: Guarded<Work>,
    /// The cost of steps that failed.
    abandoned: Cost,
}

/// How steps are chosen.
#[derive(Clone, Copy, Debug)]
enum Control {
    Tolerance(f64),
    Fixed(f64),
}

impl Dop853 {
    /// For one mechanism, with `tolerance` both absolute and relative on every entry of the state.
    pub fn new(mechanism: &Mechanism, tolerance: f64) -> Self {
        Dop853::with_control(mechanism, Control::Tolerance(tolerance))
    }

    /// For one mechanism, with a fixed step (s) and no error control.
    pub fn with_fixed_step(mechanism: &Mechanism, step: f64) -> Self {
        Dop853::with_control(mechanism, Control::Fixed(step))
    }

    /// For a system, with `tolerance` both absolute and relative on every entry of the state.
    pub fn of_system(ode: ReducedOde, tolerance: f64) -> Self {
        Dop853::with_system(ode, Control::Tolerance(tolerance))
    }

    fn with_control(mechanism: &Mechanism, control: Control) -> Self {
        Dop853::with_system(ReducedOde::new(mechanism), control)
    }

    fn with_system(ode: ReducedOde, control: Control) -> Self {
        Dop853 {
            control,
            next_step: None,
            error_before: LEAST_ERROR_BEFORE,
            start_time: 0.0,
            end_time: f64::NAN,
            accepted: 0,
            accepted_time: 0.0,
            efforts: Vec::new(),
            work: Guarded::new(Work::new(ode)),
            abandoned: Cost::default(),
        }
    }
}

impl Integrator for Dop853 {
    fn step(
        &mut self,
        mechanism: &Mechanism,
        inputs: Inputs,
        state: &mut State,
        until: f64,
    ) -> Result<StepOutcome, StepError> {
        if let Some(now) = self.work.get_mut().ode.changed(mechanism, inputs) {
            *self = Dop853 { abandoned: self.abandoned, ..Dop853::with_control(&now, self.control) };
        }
        if self.efforts != inputs.efforts {
            self.efforts = inputs.efforts.to_vec();
            self.work.get_mut().ode.drive_at(state.time, inputs);
            // The first slope of the next step is another.
            self.end_time = f64::NAN;
        }
        let work = self.work.get_mut();
        work.clock = work.ode.depends_on_time(inputs).then_some(state.time);
        work.polynomial_is_current = false;
        work.ode.load(state, &mut work.start);
        let mut evaluations = 0;
        // Unless somebody has changed the state since the last step, its first slope is known.
        let continues = state.time == self.end_time && work.start == work.end;
        if !continues {
            self.next_step = None;
            self.error_before = LEAST_ERROR_BEFORE;
        }
        let n = work.start.len();
        // Driving efforts may jump at the end of a step.
        if continues && work.clock.is_none() {
            work.slopes.copy_within(END_SLOPE * n..(END_SLOPE + 1) * n, 0);
        } else {
            work.slope_of_start(inputs);
            evaluations += 1;
            work.check_finite(mechanism, &work.slopes[..n], state.time, 0.0)?;
        }
        let mut wanted = match (self.control, self.next_step) {
            (Control::Fixed(step), _) => step,
            (Control::Tolerance(_), Some(step)) => step,
            (Control::Tolerance(tolerance), None) => {
                evaluations += 1;
                work.initial_step(tolerance, until - state.time, inputs)
            }
        };
        let mut rejected = Cost::default();
        loop {
            let remaining = until - state.time;
            let stretch = if matches!(self.control, Control::Fixed(_)) { 1.000_000_1 } else { STRETCH };
            let last = wanted * stretch >= remaining;
            let step = if last { remaining } else { wanted };
            work.attempt(step, inputs);
            evaluations += 11;
            let error = match self.control {
                Control::Tolerance(tolerance) => work.error(step, tolerance),
                Control::Fixed(_) => {
                    work.check_finite(mechanism, &work.end, state.time, step)?;
                    0.0
                }
            };
            if error <= 1.0 {
                work.finish(step, inputs);
                evaluations += 1;
                work.ode.store(&work.end, state);
                self.start_time = state.time;
                state.time = if last { until } else { state.time + step };
                self.end_time = state.time;
                self.accepted += 1;
                self.accepted_time += step;
                // The step does not grow right after a rejection. A step that the end of the run cuts short is no argument against longer ones.
                let growth = if rejected.rejected.total() > 0 { 1.0 } else { GROWTH_LIMIT };
                let proportional = error.powf(0.2 * INTEGRAL_GAIN - 1.0 / ORDER);
                let factor = SAFETY * proportional * self.error_before.powf(INTEGRAL_GAIN);
                let proposed = step * factor.clamp(SHRINK_LIMIT, growth);
                self.error_before = error.max(LEAST_ERROR_BEFORE);
                self.next_step = Some(if last { proposed.max(wanted) } else { proposed });
                let exchange = work.ode.exchange(&work.start, &work.end);
                let mut outcome = StepOutcome::new(step, evaluations, exchange);
                outcome.cost.add(&rejected);
                return Ok(outcome);
            }
            rejected.reject(Rejected::NotSmooth);
            // A step that ran into infinity has no error to go by.
            let factor = if error.is_finite() { SAFETY * error.powf(-1.0 / ORDER) } else { 0.0 };
            wanted = step * factor.max(SHRINK_LIMIT);
            if wanted <= 10.0 * f64::EPSILON * state.time.abs().max(until.abs()) {
                work.check_finite(mechanism, &work.end, state.time, step)?;
                let joint = joint_of_entry(mechanism, work.worst_entry());
                rejected.iterations = evaluations;
                self.abandoned.add(&rejected);
                return Err(StepError::NotConverged { time: state.time, step, joint, increment: error });
            }
        }
    }

    fn dense(&mut self, mechanism: &Mechanism, time: f64, position: &mut [f64], velocity: &mut [f64]) {
        let step = self.end_time - self.start_time;
        let work = &mut *self.work.lock();
        if !work.polynomial_is_current {
            work.find_polynomial(step, Inputs::NONE);
        }
        let s = (time - self.start_time) / step;
        let (value, n) = (&work.polynomial, work.start.len());
        // Nested in s and 1 − s by turns, so that both ends are met exactly.
        let at = |i: usize| {
            let upper =
                value[4 * n + i] + s * (value[5 * n + i] + (1.0 - s) * (value[6 * n + i] + s * value[7 * n + i]));
            let lower = value[2 * n + i] + s * (value[3 * n + i] + (1.0 - s) * upper);
            value[i] + s * (value[n + i] + (1.0 - s) * lower)
        };
        position.iter_mut().enumerate().for_each(|(i, entry)| *entry = at(i));
        velocity.iter_mut().enumerate().for_each(|(i, entry)| *entry = at(mechanism.position_count + i));
        work.ode.normalise(position);
    }

    fn take_abandoned(&mut self) -> Cost {
        std::mem::take(&mut self.abandoned)
    }

    fn description(&self) -> MethodDescription {
        let (adaptive, tolerance, step) = match self.control {
            Control::Tolerance(tolerance) => (true, Some(tolerance), self.accepted_time / self.accepted.max(1) as f64),
            Control::Fixed(step) => (false, None, step),
        };
        MethodDescription { adaptive, tolerance, ..MethodDescription::fixed("dop853", 12, 8, step) }
    }
}

/// The interface of the steps to the location of events.
impl StepMaker for Dop853 {
    fn figures(&self) -> StepFigures {
        StepFigures { between: None, ..StepFigures::NONE }
    }
}

/// The first step of every piece is chosen anew.
impl PieceSteps for Dop853 {
    fn duplicate(&self) -> Box<dyn PieceSteps> {
        Box::new(self.clone())
    }

    /// Without error control.
    fn again(
        &mut self,
        mechanism: &Mechanism,
        inputs: Inputs,
        state: &mut State,
        length: f64,
    ) -> Result<StepOutcome, StepError> {
        let work = self.work.get_mut();
        work.attempt(length, inputs);
        work.check_finite(mechanism, &work.end, self.start_time, length)?;
        work.finish(length, inputs);
        work.ode.store(&work.end, state);
        state.time = self.start_time + length;
        self.end_time = state.time;
        let exchange = work.ode.exchange(&work.start, &work.end);
        Ok(StepOutcome::new(length, 12, exchange))
    }

    /// `Σ b_i q̇_i²`.
    fn mean_square_rate(&self, coordinate: Coordinate, _rates: &mut Vec<f64>) -> f64 {
        let work = self.work.lock();
        let n = work.start.len();
        SOLUTION.iter().map(|&(stage, weight)| weight * work.slopes[stage * n + coordinate.position].powi(2)).sum()
    }

    fn step_pace(&self, origin: f64) -> StepPace {
        StepPace::Grid { origin }
    }

    fn keep_pace(&mut self, _pace: StepPace, _time: f64) {}
}
