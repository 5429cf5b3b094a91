//! Decides the next mode of elements at rest: which joints are held (by friction or on a limit), which way the others move, which contacts stay
//! closed, and which of these slide.
//!
//! All joints whose rate is zero and that have friction or are on a limit, and all contacts that do not part, are decided together, at the level of
//! accelerations:
//!
//! ```text
//!     a = b + D λ,   b = W a_free + Ẇ v,  D = W Y Wᵀ      a_free under all efforts but λ; friction that slides in joints is among them
//!     joints:    λ_i ∈ [lo_i, hi_i]:   a_i = 0 inside,  a_i ≥ 0 at lo_i,  a_i ≤ 0 at hi_i           (the box of `mode`)
//!     contacts:  Signorini's and Coulomb's law between λ and a; where one slides, λ_T = −μ λ_N t    (`crate::instant::cone`)
//!     turnings:  the same for the moments of rolling and spinning friction                          (`crate::instant::holding::moments`)
//! ```
//!
//! A joint with `a_i = 0` is held; one with `a_i > 0` goes forward with friction `−τ_f = lo_i` against it, or leaves its lower limit. In a mechanism
//! with closures, joints that the held ones immobilise are held, too, so that the reduced mechanism has no redundant closure.
//!
//! Source: Ch. Glocker, Set-Valued Force Laws, Springer 2001, chapter 9.

use crate::events::effects::first_slips::Kept;
use crate::events::effects::shared_pressures::solve_as_steps_share;
use crate::events::finding::watched::Watched;
use crate::events::forces::chosen::Chosen;
use crate::events::modes::mode::{Closed, JointMode, Mode};
use crate::instant::cone::problem::{Answer, BlockState, Law, Unsolved};
use crate::instant::dynamics::response::Response;
use crate::instant::holding::blocks::{Block, Of, Rows, rows_of_contact, second_rates};
use crate::instant::holding::elements::Elements;
use crate::instant::holding::moments::{Turning, blocks_of_turning, solve_with_moments};
use crate::instant::holding::pairs::Pair;
use crate::instant::holding::touching::{Contact, RimOf, Touching};
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::contact::{Moment, Moments, TouchJoint};
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::contact_solvers::ContactSolvers;
use crate::mechanism::motion::event::Side;
use crate::mechanism::motion::kinematics::{BodyAcceleration, body_accelerations, body_states};
use crate::mechanism::motion::state::State;
use crate::mechanism::motion::touches::{tangents, touch_motion};
use nalgebra::Vector3;

/// Accelerations below this part of their terms are zero.
const ROUNDING: f64 = 1e-10;
/// The same of slips that begin where forces are not unique: the contact sticks on its cone.
const TIED: f64 = 2e-8;
/// Accelerations below this part of the largest of all, and of one unit, are rounding as well.
const DIFFERENCE: f64 = 1e-14;
/// The part by which the bound of a joint is reduced if an event has found the joint at that bound.
const LESS: f64 = 1e-9;
/// A point of a flat end that tips over another is unloaded if it carries less than this part of the force of the other.
const UNLOADED: f64 = 1e-9;

/// A mechanism at an event.
pub(crate) struct Scene<'s> {
    pub whole: &'s Mechanism,
    pub elements: &'s Elements,
    pub touching: &'s Touching,
    /// The pairs that may touch in the state of the event, in the order of their numbers.
    pub near: &'s [usize],
    pub response: &'s mut Response,
    /// Counts the contact solvers that its problems need.
    pub solvers: &'s mut ContactSolvers,
}

/// Elements that an event has found at the end of their efforts.
#[derive(Clone, Debug, Default)]
pub(crate) struct Yielding {
    /// Joints at an end of the efforts that can hold them, and the direction in which they go.
    pub joints: Vec<(usize, i8)>,
    /// All held joints and contacts together.
    pub all: bool,
    /// Closed contacts that press no more, and those that stick no more, by their numbers in the mode.
    pub opens: Vec<usize>,
    pub slides: Vec<usize>,
    /// Closed contacts whose slip stops, by their numbers in the mode.
    pub stops: Vec<usize>,
    /// The same whose rolling friction, or spinning friction if so, resists no more; and those whose turning stops.
    pub turns: Vec<(usize, bool)>,
    pub halts: Vec<(usize, bool)>,
    /// Pairs whose slips stop together.
    pub stops_together: Vec<usize>,
}

impl Yielding {
    /// The elements that the functions that are zero name.
    pub fn of(triggers: &[Watched]) -> Self {
        let mut yielding = Yielding::default();
        for trigger in triggers {
            match *trigger {
                // It needs less than the least that can act: it goes forward.
                Watched::Bears(index, Side::Lower) => yielding.joints.push((index, 1)),
                Watched::Bears(index, Side::Upper) => yielding.joints.push((index, -1)),
                Watched::Margin => yielding.all = true,
                Watched::Presses(contact) => yielding.opens.push(contact),
                Watched::Grips(contact) => yielding.slides.push(contact),
                Watched::Slips(contact) => yielding.stops.push(contact),
                Watched::SlipsTogether(pair) => yielding.stops_together.push(pair),
                Watched::Resists(contact, spinning) => yielding.turns.push((contact, spinning)),
                Watched::Turns(contact, spinning) => yielding.halts.push((contact, spinning)),
                _ => {}
            }
        }
        yielding
    }
}

/// A contact that touches, to be decided.
#[derive(Clone, Debug)]
pub(crate) struct Candidate {
    pub contact: Contact,
    /// The velocity of its slip in the world [m/s]; zero if it does not.
    pub slip: Vector3<f64>,
    /// Whether it has been seen to reach the end of what friction can hold, and whether the end of its pressure.
    pub slides: bool,
    pub opens: bool,
    /// How it turns against rolling and spinning friction; zero where it does not. And whether it has been seen to reach the end of what each of them
    /// can hold.
    pub turning: Turning,
    pub turns: [bool; 2],
}

/// Reasons for which accelerations alone decide no mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Undecided {
    /// A candidate that slides, by its number, has no consistent acceleration: an impulse must follow.
    Inconsistent(usize),
    /// The problem could not be solved.
    Unsolved,
}

/// What the decided accelerations are of.
#[derive(Clone, Debug)]
pub(crate) struct Decided {
    /// The residual of the law, as a part of the largest force: zero if it was solved to its accuracy; otherwise the best iterate is taken.
    pub off: f64,
    /// One entry a degree of freedom.
    pub accelerations: Vec<f64>,
    /// λ_N of every candidate (N), and the normal forces that would hold all of them; zero if no candidate is at the rim of a flat end.
    pub pressures: Vec<f64>,
    pub holding: Vec<f64>,
}

impl Decided {
    /// The accelerations of all bodies, in a state with these places and rates of theirs.
    pub fn of_bodies(&self, whole: &Mechanism, state: &State, bodies: &[BodyState]) -> Vec<BodyAcceleration> {
        let mut accelerations = vec![BodyAcceleration::default(); bodies.len()];
        body_accelerations(whole, bodies, &state.velocity, &self.accelerations, &mut accelerations);
        accelerations
    }
}

/// Decides the joints whose rate is zero and the contacts that touch; `efforts` are those from outside and of motors.
pub(crate) fn decide(
    scene: &mut Scene,
    mode: &mut Mode,
    state: &State,
    efforts: &[f64],
    yielding: &Yielding,
    candidates: &[Candidate],
) -> Result<Decided, Undecided> {
    let Scene { whole, elements, touching, response, solvers, .. } = scene;
    let (whole, elements, touching) = (*whole, *elements, *touching);
    let mut blocks: Vec<Block> = Vec::new();
    let mut efforts = efforts.to_vec();
    for (index, joint) in elements.joints.iter().enumerate() {
        let (rate, side) = (joint.rate(state), joint.side(joint.position(state)));
        let goes = yielding.joints.iter().find(|(yields, _)| *yields == index).map(|(_, direction)| *direction);
        let goes = if rate != 0.0 { Some(rate.signum() as i8) } else { goes };
        mode.joints[index] = if let Some(direction) = goes {
            let sliding = if joint.friction > 0.0 { direction } else { 0 };
            efforts[joint.coordinate.freedom] -= f64::from(sliding) * joint.friction;
            JointMode::Free { sliding }
        } else if joint.friction > 0.0 || side.is_some() {
            let held = JointMode::Held { on: side };
            let bounds = held.holding(joint).into();
            blocks.push(Block::of_joint(index, joint.coordinate.freedom, whole.velocity_count, 1.0, bounds));
            held
        } else {
            JointMode::Free { sliding: 0 }
        };
    }
    mode.contacts.clear();
    let bodies = if candidates.is_empty() { Vec::new() } else { body_states(whole, state) };
    for (index, candidate) in candidates.iter().enumerate() {
        if candidate.opens {
            continue;
        }
        let Pair { friction, moments, .. } = &touching.pairs[candidate.contact.pair];
        let joint = &candidate.contact.joint;
        let law = Law::of_contact(*friction, direction_in(joint, &bodies, &candidate.slip));
        let rows = rows_of_contact(whole, &bodies, joint, *friction > 0.0);
        blocks.push(Block { of: Of::Contact(index), law, rows });
        blocks.extend(blocks_of_turning(whole, &bodies, joint, moments, index, &candidate.turning));
    }
    let mut free = vec![0.0; state.velocity.len()];
    let mut pressures = vec![0.0; candidates.len()];
    let mut held = pressures.clone();
    if blocks.is_empty() {
        return Ok(Decided { off: 0.0, accelerations: free, pressures, holding: held });
    }
    response.accelerations(state, &efforts, &mut free);
    let mut rows = Rows::of(response, state, &blocks);
    let mut offset =
        second_rates(whole, elements, &bodies, state, &free, &blocks, |contact| &candidates[contact].contact.joint);
    let mut row = 0;
    for block in &mut blocks {
        let load = offset[row].abs() / rows.square[(row, row)].max(f64::MIN_POSITIVE);
        if let (Of::Joint(index), Law::Interval { lower, upper }) = (block.of, &mut block.law) {
            let less = if yielding.all { LESS * elements.joints[index].friction.max(load) } else { 0.0 };
            let less = less.min(0.25 * (*upper - *lower));
            if lower.is_finite() || upper.is_finite() {
                (*lower, *upper) = (*lower + less, *upper - less);
            }
        }
        if let (Of::Contact(index), Law::Contact { friction }) = (block.of, &mut block.law)
            && (yielding.all || candidates[index].slides)
        {
            *friction *= 1.0 - LESS;
        }
        if let (Of::Moment { contact, spinning }, Law::Contact { friction }) = (block.of, &mut block.law)
            && (yielding.all || candidates[contact].turns[usize::from(spinning)])
        {
            *friction *= 1.0 - LESS;
        }
        row += block.rows.len();
    }
    let is_flat = candidates.iter().any(|candidate| candidate.contact.flat_end().is_some());
    let holding = is_flat.then(|| Chosen::new(&blocks).solve(&rows.square, &offset, false));
    let laws: Vec<Law> = blocks.iter().map(|block| block.law).collect();
    let solved = solve_with_moments(&blocks, &mut rows.square, &mut offset, &laws, |problem| {
        solve_as_steps_share(&blocks, problem, solvers)
    });
    let (found, off) = match solved {
        Ok(found) => (found, 0.0),
        Err(Unsolved::Stopped { best }) => {
            let off = best.residual;
            (*best, off)
        }
        Err(Unsolved::Inconsistent { block, .. }) => {
            return Err(match blocks[block].of {
                Of::Contact(index) => Undecided::Inconsistent(index),
                Of::Joint(_) | Of::Moment { .. } => Undecided::Unsolved,
            });
        }
        Err(_) => return Err(Undecided::Unsolved),
    };
    // Each acceleration is a difference of others.
    let largest = free.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    let accelerates = |row: usize, part: f64| {
        let terms: f64 =
            (0..offset.len()).map(|column| (rows.square[(row, column)] * found.forces[column]).abs()).sum();
        found.rates[row].abs() > part * (terms + offset[row].abs()) + DIFFERENCE * (1.0 + largest)
    };
    let moves = |row: usize| accelerates(row, ROUNDING);
    let ends = if is_flat { tipping_ends(&blocks, &found, candidates, moves) } else { Vec::new() };
    let (mut first, mut kept) = (0, Kept::default());
    let mut decided = None;
    for (block, is) in blocks.iter().zip(&found.states) {
        let row = first;
        first += block.rows.len();
        let rate = found.rates[row];
        let leaves = moves(row);
        match block.of {
            Of::Joint(index) => {
                let joint = &elements.joints[index];
                if *is != BlockState::Inside && leaves && !joint.is_locked() {
                    let sliding = if joint.friction > 0.0 { rate.signum() as i8 } else { 0 };
                    mode.joints[index] = JointMode::Free { sliding };
                    // Its friction pushes as it does now.
                    kept.push(row, found.forces[row]);
                } else {
                    kept.keep(block.clone(), row, false);
                }
            }
            Of::Contact(index) => {
                if let Some(holding) = &holding {
                    (pressures[index], held[index]) = (found.forces[row], holding[row]);
                }
                let Candidate { contact, slip, .. } = &candidates[index];
                if matches!(is, BlockState::Open | BlockState::AtLower) && leaves {
                    continue;
                }
                // Points next to the one over which a flat end tips leave too slowly to be told.
                let end = contact.flat_end();
                let most = ends.iter().find(|(of, _)| Some(*of) == end).map(|(_, most)| *most);
                if most.is_some_and(|most| found.forces[row] <= UNLOADED * most) {
                    continue;
                }
                let [along, across] = tangents(&touch_motion(&contact.joint, &bodies).normal);
                let tangential = |of: &[f64]| along * of[row + 1] + across * of[row + 2];
                let yields = yielding.all || candidates[index].slides;
                // Forces across a slip that hold each other take friction by their square: where forces are not unique, their roundings do so, too.
                let slips = |part: f64| accelerates(row + 1, part) || accelerates(row + 2, part);
                let on_cone = matches!(block.law, Law::Contact { .. })
                    && *is == BlockState::Slips
                    && !yields
                    && !slips(TIED)
                    && (!slips(ROUNDING) || !Chosen::new(&blocks).is_unique(&rows.square));
                let slides = match block.law {
                    Law::Sliding { .. } => slip.try_normalize(0.0),
                    Law::Interval { .. } => Some(slip.try_normalize(0.0).unwrap_or(along)),
                    Law::Contact { .. } if on_cone => None,
                    // A contact that stays closed without pressing, as of a ball that falls along a wall, is not held by friction either. Friction is
                    // against the slip. It gives the better direction where the acceleration nearly cancels.
                    Law::Contact { .. } if *is == BlockState::Slips => {
                        let mobility = rows.square[(row + 1, row + 1)].max(rows.square[(row + 2, row + 2)]);
                        let (begins, rubs) = (tangential(&found.rates), tangential(&found.forces));
                        let slips = if mobility * rubs.norm() > begins.norm() { -rubs } else { begins };
                        slips.try_normalize(0.0)
                    }
                    Law::Contact { .. } if *is == BlockState::Open && (moves(row + 1) || moves(row + 2)) => {
                        tangential(&found.rates).try_normalize(0.0)
                    }
                    Law::Contact { .. } => None,
                };
                let mut block = block.clone();
                if let Some(slides) = slides.filter(|_| block.rows.len() > 1) {
                    let direction = [along.dot(&slides), across.dot(&slides)];
                    block.law = Law::Sliding { friction: touching.pairs[contact.pair].friction, direction };
                }
                let begins = slip.norm() == 0.0 && matches!(block.law, Law::Sliding { .. });
                kept.keep(block, row, begins);
                mode.contacts.push(Closed { contact: contact.clone(), slides, on_cone, moments: Moments::default() });
                decided = Some(index);
            }
            // The contact before it has been left out.
            Of::Moment { contact, .. } if decided != Some(contact) => {}
            Of::Moment { contact: index, spinning } => {
                let Candidate { contact, turning, .. } = &candidates[index];
                let normal = touch_motion(&contact.joint, &bodies).normal;
                let [along, across] = tangents(&normal);
                let axes = if spinning { [normal, Vector3::zeros()] } else { [along, across] };
                let about = |of: &[f64]| axes[0] * of[row + 1] + axes[1] * of[row + 2];
                let direction = match block.law {
                    Law::Sliding { .. } if spinning => Some(normal * turning.along.signum()),
                    Law::Sliding { .. } => turning.across.try_normalize(0.0),
                    _ if *is == BlockState::Slips => {
                        let mobility = rows.square[(row + 1, row + 1)].max(rows.square[(row + 2, row + 2)]);
                        let (begins, rubs) = (about(&found.rates), about(&found.forces));
                        let turns = if mobility * rubs.norm() > begins.norm() { -rubs } else { begins };
                        turns.try_normalize(0.0)
                    }
                    _ if *is == BlockState::Open && (moves(row + 1) || moves(row + 2)) => {
                        about(&found.rates).try_normalize(0.0)
                    }
                    _ => None,
                };
                let lengths = &touching.pairs[contact.pair].moments;
                let length = if spinning { lengths.spinning } else { lengths.rolling };
                let mut block = block.clone();
                let moment = match direction {
                    Some(direction) => {
                        let along = [axes[0].dot(&direction), axes[1].dot(&direction)];
                        block.law = Law::Sliding { friction: length, direction: along };
                        Moment::Brakes { length, direction }
                    }
                    None => Moment::Holds,
                };
                kept.keep(block, row, false);
                if let Some(closed) = mode.contacts.last_mut() {
                    let Moments { rolling, spinning: spins } = &mut closed.moments;
                    *(if spinning { spins } else { rolling }) = moment;
                }
            }
        }
    }
    for (closed, direction) in mode.contacts.iter_mut().zip(kept.first_slips(&rows.square, &offset)) {
        if let Some([x, y]) = direction {
            let [along, across] = tangents(&touch_motion(&closed.contact.joint, &bodies).normal);
            closed.slides = Some(along * x + across * y);
        }
    }
    rows.add(&found.forces, &mut free);
    Ok(Decided { off, accelerations: free, pressures, holding: held })
}

/// The flat ends of which a point leaves, with the largest of the forces at their points (N).
fn tipping_ends(
    blocks: &[Block],
    found: &Answer,
    candidates: &[Candidate],
    moves: impl Fn(usize) -> bool,
) -> Vec<(RimOf, f64)> {
    let mut ends: Vec<(RimOf, f64)> = Vec::new();
    let mut leaving: Vec<RimOf> = Vec::new();
    let mut row = 0;
    for (block, is) in blocks.iter().zip(&found.states) {
        if let Of::Contact(index) = block.of
            && let Some(end) = candidates[index].contact.flat_end()
        {
            match ends.iter_mut().find(|(known, _)| *known == end) {
                Some((_, most)) => *most = most.max(found.forces[row]),
                None => ends.push((end, found.forces[row])),
            }
            if matches!(is, BlockState::Open | BlockState::AtLower) && moves(row) {
                leaving.push(end);
            }
        }
        row += block.rows.len();
    }
    ends.retain(|(end, _)| leaving.contains(end));
    ends
}

/// The direction of a slip in the tangents of a contact; `None` without a slip.
fn direction_in(joint: &TouchJoint, bodies: &[BodyState], slip: &Vector3<f64>) -> Option<[f64; 2]> {
    let direction = slip.try_normalize(0.0)?;
    let [first, second] = tangents(&touch_motion(joint, bodies).normal);
    Some([direction.dot(&first), direction.dot(&second)])
}
