//! Functions whose sign is watched: positive while the mode lasts.
//!
//! | function | φ | event |
//! |---|---|---|
//! | distance to a limit | `q − lower`, `upper − q` | impact |
//! | rate of a joint that slides | `σ q̇` | friction decides anew |
//! | what a held joint can still bear | `λ − lo`, `hi − λ` | it slips, or leaves its limit |
//! | what all held joints can still bear | m of [`crate::events::holding`] | the same, where their efforts are not unique |
//! | what a motor can still do | `bound − u`, `bound + u` | it reaches its bound |
//! | what a motor at its bound has too much | `± u − bound` | it comes back |

use crate::events::holding::Holding;
use crate::events::mode::{JointMode, Mode, MotorMode};
use crate::instant::elements::Elements;
use crate::mechanism::motion::event::Side;
use crate::mechanism::motion::state::State;

/// One function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Watched {
    /// Distance of a joint to a bound.
    Gap(usize, Side),
    /// Rate of a joint that slides.
    Slide(usize),
    /// What a held joint can bear towards the lower or upper end of its efforts.
    Bears(usize, Side),
    /// What all held joints can bear together.
    Margin,
    /// What a motor can do more, upwards or downwards.
    Motor(usize, Side),
    /// What a motor at its bound has too much.
    Excess(usize),
}

impl Watched {
    /// The functions of a mode; `unique` says whether the efforts of held joints are.
    pub fn of(elements: &Elements, mode: &Mode, unique: bool) -> Vec<Watched> {
        let mut all = Vec::new();
        let mut holds = false;
        for (index, (joint, state)) in elements.joints.iter().zip(&mode.joints).enumerate() {
            match state {
                JointMode::Free { sliding } => {
                    all.extend(joint.sides().map(|side| Watched::Gap(index, side)));
                    if *sliding != 0 {
                        all.push(Watched::Slide(index));
                    }
                }
                JointMode::Held { .. } => {
                    let (low, high) = state.holding(joint);
                    let ends = [(Side::Lower, low), (Side::Upper, high)];
                    let finite: Vec<_> = ends.into_iter().filter(|(_, effort)| effort.is_finite()).collect();
                    holds |= !finite.is_empty();
                    if unique {
                        all.extend(finite.into_iter().map(|(side, _)| Watched::Bears(index, side)));
                    }
                }
            }
        }
        if holds && !unique {
            all.push(Watched::Margin);
        }
        for (index, (motor, state)) in elements.motors.iter().zip(&mode.motors).enumerate() {
            match state {
                MotorMode::Unbounded if motor.max_effort.is_finite() => {
                    all.extend([Side::Lower, Side::Upper].map(|side| Watched::Motor(index, side)));
                }
                MotorMode::Unbounded | MotorMode::Given(_) => {}
                MotorMode::Saturated(_) => all.push(Watched::Excess(index)),
            }
        }
        all
    }

    /// Its value at a time (s) of a state; `since` is the start of the piece of the targets.
    pub fn value(
        self,
        elements: &Elements,
        mode: &Mode,
        efforts: &Holding,
        since: f64,
        time: f64,
        state: &State,
    ) -> f64 {
        match self {
            Watched::Gap(index, side) => {
                let joint = &elements.joints[index];
                let rest = state.compensation[joint.coordinate.position];
                let rest = if side == Side::Lower { rest } else { -rest };
                joint.gap(side, state.position[joint.coordinate.position]) + rest
            }
            Watched::Slide(index) => match mode.joints[index] {
                JointMode::Free { sliding } => f64::from(sliding) * elements.joints[index].rate(state),
                JointMode::Held { .. } => f64::INFINITY,
            },
            Watched::Bears(index, side) => {
                let (low, high) = mode.joints[index].holding(&elements.joints[index]);
                let effort = efforts.of(index);
                let left = if side == Side::Lower { effort - low } else { high - effort };
                // What rests unloaded is not let go by roundings.
                left + efforts.rounding(index)
            }
            Watched::Margin => efforts.margin(),
            Watched::Motor(index, side) => {
                let bound = elements.motors[index].max_effort;
                let unbounded = unbounded(elements, index, since, time, state);
                if side == Side::Lower { bound + unbounded } else { bound - unbounded }
            }
            Watched::Excess(index) => match mode.motors[index] {
                MotorMode::Saturated(sign) => {
                    let bound = elements.motors[index].max_effort;
                    f64::from(sign) * unbounded(elements, index, since, time, state) - bound
                }
                MotorMode::Unbounded | MotorMode::Given(_) => f64::INFINITY,
            },
        }
    }

    /// What its roundings are relative to.
    pub fn scale(self, elements: &Elements) -> f64 {
        match self {
            Watched::Gap(index, side) => elements.joints[index].bound(side).abs().max(1.0),
            Watched::Slide(_) | Watched::Margin => 1.0,
            Watched::Bears(index, _) => elements.joints[index].friction.max(1.0),
            Watched::Motor(index, _) | Watched::Excess(index) => elements.motors[index].max_effort.max(1e-3),
        }
    }

    /// Whether it is a function of the efforts that hold joints.
    pub fn needs_efforts(self) -> bool {
        matches!(self, Watched::Bears(..) | Watched::Margin)
    }
}

/// The effort of a motor without bound.
pub(crate) fn unbounded(elements: &Elements, index: usize, since: f64, time: f64, state: &State) -> f64 {
    let motor = &elements.motors[index];
    let at = motor.coordinate;
    let position = state.position[at.position] + state.compensation[at.position];
    motor.unbounded(since, time, position, state.velocity[at.freedom])
}
