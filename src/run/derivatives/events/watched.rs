//! The functions at whose zero a step ends, with their derivatives.
//!
//! ```text
//!     distance to a limit   ±(q − bound)             what a motor can still do   bound ∓ u
//!     rate of a joint       q̇                        what a held joint bears     λ − lo, hi − λ
//!     gap of a pair         φ(q)
//!     closed contacts       λ_N,  μ λ_N − |λ_T|,  u_T · t₀      their forces in accelerations
//! ```

use crate::derivatives::equations::contacts::TouchFigures;
use crate::derivatives::events::instant::{Accelerations, Instant, Moved};
use crate::derivatives::forward::stage_equations::BothFigures;
use crate::derivatives::forward::step::{Part, StepMode};
use crate::derivatives::numbers::number::Number;
use crate::events::trace::{JointMode, Mode, MotorMode, Watched};
use crate::instant::holding::elements::Elements;
use crate::mechanism::motion::event::Side;
use std::cell::OnceCell;

/// A state with its derivatives, in which a function is asked for.
pub(crate) struct Sight<'s> {
    pub at: Instant<'s, Part>,
    /// The figures without derivatives.
    pub constant: &'s BothFigures<Part>,
    pub velocities: &'s [Part],
    pub elements: &'s Elements,
    pub mode: &'s Mode,
    pub equations: &'s StepMode,
    /// The efforts that act (n).
    pub efforts: &'s [Part],
    /// The part of each motor's effort that depends on time alone.
    pub drives: &'s [Part],
    /// The contact of the function, if it is a gap.
    pub touch: Option<&'s TouchFigures<Part>>,
    /// All closed contacts, in the order of the mode.
    pub contacts: &'s [Option<TouchFigures<Part>>],
    /// Of the state without its derivatives, once they were asked for.
    pub accelerations: &'s OnceCell<Option<Accelerations>>,
}

/// The distance of a joint to a bound (rad or m).
pub(super) fn gap_of_joint(at: &Instant<Part>, elements: &Elements, joint: usize, side: Side) -> Part {
    let (place, law) = (elements.joints[joint].coordinate, &at.figures.laws.joints[joint]);
    let value = Part::of(at.state.position[place.position]) + Part::of(at.state.compensation[place.position]);
    let position = value + at.offsets[place.freedom];
    match side {
        Side::Lower => position - law.lower,
        Side::Upper => law.upper - position,
    }
}

impl Sight<'_> {
    /// The value of a function; `None` if it has no derivative that is known here.
    pub fn value(&self, watched: Watched) -> Option<Part> {
        let laws = &self.at.figures.laws;
        Some(match watched {
            Watched::Gap(index, side) => gap_of_joint(&self.at, self.elements, index, side),
            Watched::Slide(index) => {
                let rate = self.velocities[self.elements.joints[index].coordinate.freedom];
                match self.mode.joints[index] {
                    JointMode::Free { sliding } => rate.times(f64::from(sliding)),
                    JointMode::Held { .. } => rate,
                }
            }
            Watched::Bears(index, side) => {
                let bears = self.holding(index)?;
                let friction = laws.joints[index].friction;
                if side == Side::Lower { bears + friction } else { friction - bears }
            }
            Watched::Motor(index, side) => {
                let effort = self.unbounded(index);
                let bound = laws.motors[index].bound;
                if side == Side::Lower { bound + effort } else { bound - effort }
            }
            Watched::Excess(index) => {
                let MotorMode::Saturated(sign) = self.mode.motors[index] else { return None };
                self.unbounded(index).times(f64::from(sign)) - laws.motors[index].bound
            }
            Watched::Approach(_) => self.touch?.at(&self.at.at_rest()).gap,
            Watched::Presses(contact) => self.bearing(contact)?.normal,
            Watched::Grips(contact) => self.grip(contact)?,
            Watched::Slips(contact) => self.slip_along(contact)?,
            Watched::SlipsTogether(pair) => self.slip_of_pair(pair)?,
            Watched::Margin | Watched::Returns(_) | Watched::Resists(..) | Watched::Turns(..) | Watched::Feature(_) => {
                return None;
            }
        })
    }

    /// A closed contact, by its number in the mode.
    pub(super) fn touch_of(&self, contact: usize) -> Option<&TouchFigures<Part>> {
        self.contacts.get(contact)?.as_ref()
    }

    /// The effort of a motor without bound.
    fn unbounded(&self, motor: usize) -> Part {
        let at = self.elements.motors[motor].coordinate;
        let (law, state) = (&self.at.figures.laws.motors[motor], self.at.state);
        let position = Part::of(state.position[at.position]) + self.at.offsets[at.freedom];
        self.drives[motor] - law.kp * position - law.kd * self.velocities[at.freedom]
    }

    /// λ of a held joint.
    pub fn holding(&self, joint: usize) -> Option<Part> {
        let (accelerations, multipliers) = self.accelerations()?;
        let drives = self.equations.drives(&self.at.figures.laws);
        let lacking = self.at.lacking(&Moved {
            velocities: self.velocities,
            accelerations: &accelerations,
            multipliers: &multipliers,
            efforts: self.efforts,
            drives: &drives,
        });
        let members = self.elements.joints[joint].members.iter();
        Some(members.fold(Part::zero(), |sum, member| sum + lacking[member.coordinate.freedom].times(member.factor)))
    }
}
