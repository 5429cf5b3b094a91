//! Which method an integrator is: fixed steps, reversible ones, ones with 32 digits, or steps that are chosen for a tolerance; and why one cannot be
//! used.

use crate::integrator::{Lobatto, Mode};
use crate::length::control::Control;
use crate::length::fixed::FixedSteps;
use crate::length::reversible::Reversible;
use crate::length::stage_choice::StageChoice;
use crate::length::stepper::Stepper;
use catena_kernels::{precise_step_for, step_for};
use catena_lobatto::coupled::counted::Counted;
use catena_lobatto::numbers::lanes::Isa;
use catena_lobatto::stages::attempt::StopRule;
use catena_lobatto::step::interface::Step;
use catena_lobatto::step::make::MOST_PRECISE_STAGES;
use catena_lobatto::tableau::butcher::{Tableau, TableauError};
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::description::rules::Rule;
use std::sync::Arc;

/// A step that a run can be made of (s).
fn usable(step: f64) -> Result<f64, MethodError> {
    if step > 0.0 && step.is_finite() { Ok(step) } else { Err(MethodError::Step { step }) }
}

/// Why a method cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MethodError {
    /// The number of stages.
    #[error(transparent)]
    Tableau(#[from] TableauError),
    /// The length of the steps.
    #[error("a step of {step} s: steps must be longer than zero, and finite")]
    Step {
        /// The given step (s).
        step: f64,
    },
    /// Reversible steps need a motion that is reversible itself and whose pace is known.
    #[error(
        "reversible steps are for trees of joints under gravity alone; this one has loops, mimic joints, forces, or limits, dry friction or motors, which --without leaves out"
    )]
    NotReversible,
    /// Steps with 32 digits know no more than gravity.
    #[error(
        "steps with 32 digits are for trees of joints under gravity alone; this one has loops, mimic joints, forces, or limits, dry friction or motors, which --without leaves out"
    )]
    NotPlain,
    /// One stage steps over events, which some elements need.
    #[error(
        "one stage steps over events: joints that are moved in time, rolling and spinning friction, and ropes through several points need two stages or more"
    )]
    NeedsEvents,
    /// Steps with 32 digits have eight lanes.
    #[error("steps with 32 digits have at most {MOST_PRECISE_STAGES} stages, not {stages}")]
    TooManyStages {
        /// The given number of stages.
        stages: usize,
    },
}

impl Lobatto {
    /// Fixed steps of `step` seconds with `stages` stages, iterated to rounding.
    ///
    /// # Errors
    /// [`MethodError`] if the number of stages is not from 2 to 16, or the step not longer than zero.
    pub fn fixed(mechanism: &Mechanism, stages: usize, step: f64) -> Result<Self, MethodError> {
        Self::fixed_with(mechanism, stages, step, StopRule::ROUNDING, Isa::detect())
    }

    /// Fixed steps with a stop rule and vector instructions of one's own choice (for experiments and tests).
    ///
    /// # Errors
    /// As of [`Lobatto::fixed`].
    pub fn fixed_with(
        mechanism: &Mechanism,
        stages: usize,
        step: f64,
        rule: StopRule,
        isa: Isa,
    ) -> Result<Self, MethodError> {
        let mode = Mode::Fixed(FixedSteps::new(usable(step)?, rule));
        Ok(Self::with_tableau(mechanism, Tableau::of(stages)?, mode, isa))
    }

    /// Fixed steps of `step` seconds, solved to 32 digits ([`catena_lobatto::step::precise`]): conserved quantities do not drift by rounding.
    ///
    /// # Errors
    /// [`MethodError`] if the number of stages is not from 2 to 9, if the step is not longer than zero, or if there is more than a tree under
    /// gravity.
    pub fn precise(mechanism: &Mechanism, stages: usize, step: f64) -> Result<Self, MethodError> {
        let tableau = Tableau::of(stages)?;
        if !mechanism.is_plain_tree() {
            return Err(MethodError::NotPlain);
        }
        if stages > MOST_PRECISE_STAGES {
            return Err(MethodError::TooManyStages { stages });
        }
        let mode = Mode::Fixed(FixedSteps::new(usable(step)?, StopRule::ROUNDING));
        let kernel = precise_step_for(mechanism, tableau, &[]);
        Ok(Lobatto { precise: true, ..Self::with_kernel(mechanism, tableau, kernel, mode, Isa::detect()) })
    }

    /// Steps of varying length for very long runs, the first of `step` seconds, iterated to rounding: a run that is turned
    /// round retraces itself ([`crate::length::reversible`]).
    ///
    /// # Errors
    /// [`MethodError`] if the number of stages is not from 2 to 16, if the step is not longer than zero, or if there is more than a tree under
    /// gravity.
    pub fn reversible(mechanism: &Mechanism, stages: usize, step: f64) -> Result<Self, MethodError> {
        let tableau = Tableau::of(stages)?;
        if !mechanism.is_plain_tree() {
            return Err(MethodError::NotReversible);
        }
        Ok(Self::with_tableau(mechanism, tableau, Mode::Reversible(Reversible::new(usable(step)?)), Isa::detect()))
    }

    /// Steps chosen for a wanted position accuracy [m or rad], with the iteration stop that suits motions of moderate
    /// amplification; `simulation::tolerance::error_estimate` finds the one for the motion at hand.
    pub fn adaptive(mechanism: &Mechanism, tolerance: f64) -> Self {
        Self::adaptive_with_stop(mechanism, tolerance, 1e-4 * tolerance)
    }

    /// Steps chosen for an iteration stop, the local accuracy of joint displacements [m or rad]; `tolerance` bounds the
    /// change of the energy relative to the kinetic energy. The number of stages is the one for this tolerance.
    pub fn adaptive_with_stop(mechanism: &Mechanism, tolerance: f64, stop: f64) -> Self {
        Self::adaptive_with_stages(mechanism, tolerance, stop, StageChoice::of(mechanism, tolerance))
    }

    /// The same with another choice of stages.
    pub fn adaptive_with_stages(mechanism: &Mechanism, tolerance: f64, stop: f64, stages: StageChoice) -> Self {
        let isa = Isa::detect();
        let control = Control::new(mechanism, tolerance, stop, stages);
        Self::with_tableau(mechanism, stages.tableau(), Mode::Chosen(Box::new(control)), isa)
    }

    fn with_tableau(mechanism: &Mechanism, tableau: &'static Tableau, mode: Mode, isa: Isa) -> Self {
        Self::with_kernel(mechanism, tableau, step_for(mechanism, tableau, isa, &[]), mode, isa)
    }

    fn with_kernel(
        mechanism: &Mechanism,
        tableau: &'static Tableau,
        kernel: Box<dyn Step>,
        mode: Mode,
        isa: Isa,
    ) -> Self {
        let mut lobatto =
            Lobatto { stepper: Stepper::new(mechanism, tableau, kernel), mode, isa, precise: false, kept: Vec::new() };
        lobatto.prepare(mechanism);
        lobatto
    }

    /// The same with another stop in steps that given instants end early: this factor times the stop of others.
    #[must_use]
    pub(crate) fn ending_at_instants_with(mut self, factor: f64) -> Self {
        if let Mode::Chosen(control) = &mut self.mode {
            control.bounded = factor;
        }
        self
    }

    /// Makes room, before the first step, for the workspace of coarse stops.
    pub(super) fn prepare(&mut self, mechanism: &Mechanism) {
        if let Mode::Chosen(control) = &self.mode {
            self.stepper.kernel.expect(mechanism, control.rule().increment);
        }
    }

    /// Takes the ranks of the closures in the state that the first step begins from.
    pub fn take_counted(&mut self, counted: Option<Arc<Counted>>) {
        self.stepper.counted = counted;
    }

    /// The same without some rules by which it would do less: without [`Rule::Planar`] every body has six coordinates, without
    /// [`Rule::Translation`], [`Rule::Points`], [`Rule::Spheres`], [`Rule::Pivots`] and [`Rule::Tumblers`] all of their equations.
    #[must_use]
    pub fn keeping(mut self, mechanism: &Mechanism, switched_off: &[Rule]) -> Self {
        if !switched_off.is_empty() {
            let tableau = self.stepper.tableau;
            self.stepper.replace_kernel(if self.precise {
                precise_step_for(mechanism, tableau, switched_off)
            } else {
                step_for(mechanism, tableau, self.isa, switched_off)
            });
            self.prepare(mechanism);
            self.kept = switched_off.to_vec();
        }
        self
    }
}
