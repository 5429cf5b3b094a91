//! Functions whose sign is watched: positive while the mode lasts.
//!
//! | function | φ | event |
//! |---|---|---|
//! | distance to a limit | `q − lower`, `upper − q` | impact |
//! | rate of a joint that slides | `σ q̇` | friction decides anew |
//! | what a held joint can still bear | `λ − lo`, `hi − λ` | it slips, or leaves its limit |
//! | what all held joints can still bear | m of [`crate::events::forces::holding`] | the same, where their efforts are not unique |
//! | what a motor can still do | `bound − u`, `bound + u` | it reaches its bound |
//! | what a motor at its bound has too much | `± u − bound` | it comes back |
//! | distance of a pair; where it is closed, least gap of its other features | φ | impact |
//! | pressure of a closed contact | `λ_N` | it parts |
//! | what keeps a contact from pressing again that the closed ones keep at its place | `−λ'` | it presses |
//! | what a contact that sticks can still bear | `μ λ_N − |λ_T|` | it slides |
//! | slip of a contact along its direction where the step starts | `u_T · t₀` | friction decides anew |
//! | what rolling or spinning friction that holds can still bear | `(ρ λ_N − |τ|)/L`, L the arm of the pair | it turns |
//! | turning of a contact along its direction where the step starts | `L ω_T · t₀`, `L s ω_n` | friction decides anew |
//! | slips of the contacts of a pair together, where their forces are not unique | mean of `u_T · t₀` | the same |
//! | how far inside its features a contact is | distance to the nearest side (m) | other features touch |

use crate::events::forces::holding::Holding;
use crate::events::modes::mode::{JointMode, Mode, MotorMode};
use crate::instant::cone::problem::outside_cone;
use crate::instant::holding::elements::Elements;
use crate::instant::holding::moments::Turning;
use crate::instant::holding::pairs::Pair;
use crate::instant::holding::touching::{Contact, Touching};
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::contact::Moment;
use crate::mechanism::motion::event::Side;
use crate::mechanism::motion::state::State;
use crate::mechanism::motion::touches::touch_motion;
use nalgebra::Vector3;
use std::collections::BTreeSet;

/// One function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Watched {
    /// Distance of a joint to a bound.
    Gap(usize, Side),
    /// Rate of a joint that slides.
    Slide(usize),
    /// Remaining effort of a held joint towards the lower or upper end of its efforts.
    Bears(usize, Side),
    /// Remaining effort of all held joints together.
    Margin,
    /// Remaining effort of a motor, upwards or downwards.
    Motor(usize, Side),
    /// Effort of a motor's law beyond its bound.
    Excess(usize),
    /// The distance of a pair, or the least gap of its open features.
    Approach(usize),
    /// The pressure of a closed contact.
    Presses(usize),
    /// What keeps a contact without pressure from pressing again, by its number among these in the mode.
    Returns(usize),
    /// Remaining friction of a contact that sticks.
    Grips(usize),
    /// The slip of a closed contact that slides.
    Slips(usize),
    /// The slips of the contacts of a pair that slide.
    SlipsTogether(usize),
    /// Remaining moment of rolling friction, or of spinning friction if so, of a contact that does not turn.
    Resists(usize, bool),
    /// The turning of a closed contact across its normal, or along it if so.
    Turns(usize, bool),
    /// How far inside its features a closed contact is.
    Feature(usize),
}

/// The inputs of the functions at an instant.
pub(crate) struct Seen<'s> {
    pub elements: &'s Elements,
    pub touching: &'s Touching,
    pub mode: &'s Mode,
    pub holding: &'s Holding,
    /// Start of the piece of the targets, and the instant (s).
    pub since: f64,
    pub time: f64,
    pub state: &'s State,
    /// The states of the bodies, if contacts are among the functions.
    pub bodies: &'s [BodyState],
    /// t₀ of every closed contact.
    pub slips: &'s [Vector3<f64>],
    /// Of every closed contact t₀ of its turning across the normal, and s n of the turning along it.
    pub turns: &'s [[Vector3<f64>; 2]],
}

/// Closed features count as open down to this part of the size of a pair, because its other features may lie in the same plane.
const COPLANAR: f64 = 1e-13;
/// A closed contact leaves its features this far beyond their borders, as a part of the size of the pair. The search for touching features includes
/// borders up to 1.1e-11 beyond ([`crate::instant::holding::touching::TOUCHED`]), and at a nearer border would find the same features again.
pub(crate) const BORDER: f64 = 1.2e-11;
/// The other features of a closed pair are looked at within this part of its size. Features of a half space, which has no borders, are looked at
/// everywhere.
const NEARBY: f64 = 0.02;

impl Watched {
    /// The functions of a mode and of the pairs that are near; `unique` says whether the forces that hold joints and contacts are, `apart` whether a
    /// pair can close.
    pub(crate) fn of(
        elements: &Elements,
        touching: &Touching,
        mode: &Mode,
        near: &[usize],
        unique: bool,
        apart: impl Fn(usize) -> bool,
    ) -> Vec<Watched> {
        let mut all = Vec::new();
        let mut holds = !mode.contacts.is_empty();
        all.extend(near.iter().copied().filter(|&pair| apart(pair)).map(Watched::Approach));
        let slide = |pair: usize| {
            mode.contacts.iter().filter(|closed| closed.contact.pair == pair && closed.slides.is_some()).count()
        };
        for (index, closed) in mode.contacts.iter().enumerate() {
            let pair = closed.contact.pair;
            let rubs = touching.pairs[pair].friction > 0.0;
            let own = [
                (unique || closed.shares(touching), Watched::Presses(index)),
                (unique && rubs && closed.slides.is_none(), Watched::Grips(index)),
                (rubs && closed.slides.is_some() && (unique || slide(pair) > 1), Watched::Slips(index)),
                // A ball has no border that its contact could leave.
                (apart(pair) && !touching.pairs[pair].has_one_place(), Watched::Feature(index)),
            ];
            all.extend(own.into_iter().filter(|(is, _)| *is).map(|(_, watched)| watched));
            for (moment, spinning) in [(closed.moments.rolling, false), (closed.moments.spinning, true)] {
                match moment {
                    Moment::Free => {}
                    Moment::Brakes { .. } => all.push(Watched::Turns(index, spinning)),
                    Moment::Holds if unique => all.push(Watched::Resists(index, spinning)),
                    Moment::Holds => {}
                }
            }
        }
        all.extend((0..mode.unpressed.len()).map(Watched::Returns));
        // The slips of one pair stop together, up to the unknown part of their forces; one of them stops alone if the bodies turn about it.
        let slides = |pair: &usize| touching.pairs[*pair].friction > 0.0 && slide(*pair) > 0;
        if !unique {
            let closed: BTreeSet<usize> = mode.contacts.iter().map(|closed| closed.contact.pair).collect();
            all.extend(closed.into_iter().filter(slides).map(Watched::SlipsTogether));
        }
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

    /// The number of the first function that is not the gap of a pair: those come first, in the order of their pairs.
    pub fn after_gaps(all: &[Watched]) -> usize {
        all.partition_point(|watched| matches!(watched, Watched::Approach(_)))
    }

    /// The number of the gap of a pair among all functions.
    pub fn gap_of(all: &[Watched], pair: usize) -> Option<usize> {
        let before = |watched: &Watched| matches!(watched, Watched::Approach(other) if *other < pair);
        let index = all.partition_point(before);
        (all.get(index) == Some(&Watched::Approach(pair))).then_some(index)
    }

    /// Its value.
    pub(crate) fn value(self, seen: &Seen) -> f64 {
        let Seen { elements, touching, mode, holding, since, time, state, bodies, slips, turns } = *seen;
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
                let effort = holding.of(index);
                let left = if side == Side::Lower { effort - low } else { high - effort };
                // Roundings must not release an unloaded joint at rest.
                left + holding.rounding(index)
            }
            Watched::Margin => holding.margin(),
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
            Watched::Approach(pair) => {
                let closed: Vec<&Contact> = mode.touching(pair).collect();
                let of = &touching.pairs[pair];
                if closed.is_empty() {
                    let rounding = if mode.idle.contains(&pair) { of.within(COPLANAR) } else { 0.0 };
                    return touching.gap(pair, bodies) + rounding;
                }
                let within = of.size() * if of.reach.contains(&f64::INFINITY) { 1.0 } else { NEARBY };
                touching.beside(&closed, within, bodies) + of.within(COPLANAR)
            }
            Watched::Presses(index) => holding.of_contact(index)[0] + holding.rounding_of_pressure(index),
            Watched::Returns(index) => -holding.of_unpressed(index),
            Watched::Grips(index) => {
                let friction = touching.pairs[mode.contacts[index].contact.pair].friction;
                holding.beyond_cone(index) - outside_cone(friction, holding.of_contact(index))
            }
            Watched::Resists(index, spinning) => {
                let Pair { moments, .. } = &touching.pairs[mode.contacts[index].contact.pair];
                let [pressure, ..] = holding.of_contact(index);
                let [first, second, normal] = holding.moments_of(index);
                let (length, moment) =
                    if spinning { (moments.spinning, normal.abs()) } else { (moments.rolling, first.hypot(second)) };
                let arm = touching.pairs[mode.contacts[index].contact.pair].arm();
                (length * pressure - moment) / arm + holding.rounding_of_contact(index)
            }
            Watched::Turns(index, spinning) => {
                let Contact { pair, joint, .. } = &mode.contacts[index].contact;
                let normal = touch_motion(joint, bodies).normal;
                let [across, along] = turns[index];
                let turning = Turning::of(joint, bodies, &normal);
                let speed =
                    if spinning { turning.along * normal.dot(&along).signum() } else { turning.across.dot(&across) };
                touching.pairs[*pair].arm() * speed
            }
            Watched::Slips(index) => touch_motion(&mode.contacts[index].contact.joint, bodies).slip.dot(&slips[index]),
            Watched::SlipsTogether(pair) => {
                let own = mode.contacts.iter().zip(slips).filter(|(closed, _)| closed.contact.pair == pair);
                let own = own.filter(|(closed, _)| closed.slides.is_some());
                let along = own.map(|(closed, along)| touch_motion(&closed.contact.joint, bodies).slip.dot(along));
                let (sum, count) = along.fold((0.0, 0.0), |(sum, count), slip| (sum + slip, count + 1.0));
                sum / count
            }
            Watched::Feature(index) => {
                let contact = &mode.contacts[index].contact;
                touching.margin(contact, bodies) + touching.pairs[contact.pair].within(BORDER)
            }
        }
    }

    /// The scale of its roundings.
    pub(crate) fn scale(self, elements: &Elements, touching: &Touching, mode: &Mode) -> f64 {
        let size = |pair: usize| touching.pairs[pair].extents.larger.max(touching.pairs[pair].extents.farthest);
        match self {
            Watched::Gap(index, side) => elements.joints[index].bound(side).abs().max(1.0),
            Watched::Slide(_) | Watched::Margin => 1.0,
            Watched::Bears(index, _) => elements.joints[index].friction.max(1.0),
            Watched::Motor(index, _) | Watched::Excess(index) => elements.motors[index].max_effort.max(1e-3),
            Watched::Approach(pair) => size(pair),
            Watched::Feature(contact) => size(mode.contacts[contact].contact.pair),
            Watched::Presses(_) | Watched::Returns(_) | Watched::Grips(_) | Watched::Resists(..) => 1.0,
            Watched::Slips(_) | Watched::SlipsTogether(_) | Watched::Turns(..) => 1.0,
        }
    }

    /// The distance from zero that counts as zero, for this part of the scale of the function.
    pub(crate) fn nearly(self, part: f64, elements: &Elements, touching: &Touching, mode: &Mode) -> f64 {
        match self {
            Watched::Approach(pair) => touching.pairs[pair].within(part),
            Watched::Feature(contact) => touching.pairs[mode.contacts[contact].contact.pair].within(part),
            _ => part * self.scale(elements, touching, mode),
        }
    }

    /// Rounding of its value, if it is known.
    pub(crate) fn rounding(self, holding: &Holding) -> f64 {
        match self {
            Watched::Bears(index, _) => holding.rounding(index),
            Watched::Presses(index) => holding.rounding_of_pressure(index),
            Watched::Returns(index) => holding.rounding_of_unpressed(index),
            Watched::Grips(index) => holding.beyond_cone(index),
            Watched::Resists(index, _) => holding.rounding_of_contact(index),
            _ => 0.0,
        }
    }

    /// Whether it is a function of the forces that hold joints and contacts.
    pub fn needs_efforts(self) -> bool {
        self.is_force() || matches!(self, Watched::Margin)
    }

    /// Whether it is what one held joint or contact can still bear.
    pub fn is_force(self) -> bool {
        matches!(
            self,
            Watched::Bears(..) | Watched::Presses(_) | Watched::Returns(_) | Watched::Grips(_) | Watched::Resists(..)
        )
    }

    /// Whether it is a slip or a turning that friction brakes at a contact.
    pub fn is_braked(self) -> bool {
        matches!(self, Watched::Slips(_) | Watched::SlipsTogether(_) | Watched::Turns(..))
    }

    /// Whether it is a function of where the bodies are.
    pub fn needs_bodies(self) -> bool {
        self.is_braked() || matches!(self, Watched::Approach(_) | Watched::Feature(_))
    }
}

/// The effort of a motor without bound.
pub(crate) fn unbounded(elements: &Elements, index: usize, since: f64, time: f64, state: &State) -> f64 {
    let motor = &elements.motors[index];
    let at = motor.coordinate;
    let position = state.position[at.position] + state.compensation[at.position];
    motor.unbounded(since, time, position, state.velocity[at.freedom])
}
