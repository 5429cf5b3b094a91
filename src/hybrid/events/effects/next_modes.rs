//! The next modes of the elements at rest, by the forces λ and accelerations a that their laws have given.
//!
//! | element | leaves or moves | stays |
//! |---|---|---|
//! | joint | λ at a bound and a ≠ 0 | held |
//! | contact, normal | λ_N = 0 and a_N > 0 | closed |
//! | contact, tangents | λ_T on the cone and a_T ≠ 0: slides along a_T | sticks |
//! | turning | its moment on its disk and α ≠ 0 | holds |
//!
//! Source: Ch. Glocker, Set-Valued Force Laws, Springer 2001, chapter 9.

use crate::events::effects::decision::{Candidate, Scene, Yielding};
use crate::events::effects::first_slips::Kept;
use crate::events::effects::rest_problem::RestProblem;
use crate::events::forces::chosen::Chosen;
use crate::events::modes::mode::{Closed, JointMode, Mode};
use crate::instant::cone::problem::{Answer, BlockState, Law};
use crate::instant::holding::blocks::{Block, Of};
use crate::instant::holding::elements::Elements;
use crate::instant::holding::touching::{RimOf, Touching};
use crate::mechanism::description::contact::{Moment, Moments};
use crate::mechanism::motion::touches::{tangents, touch_motion};
use nalgebra::Vector3;

/// Accelerations below this part of their terms are zero.
const ROUNDING: f64 = 1e-10;
/// The same of slips that begin where forces are not unique: the contact sticks on its cone.
const TIED: f64 = 2e-8;
/// A point of a flat end that tips over another is unloaded if it carries less than this part of the force of the other.
const UNLOADED: f64 = 1e-9;

/// The next modes by a problem of elements at rest that has been solved.
pub(super) struct NextModes<'s> {
    elements: &'s Elements,
    touching: &'s Touching,
    problem: &'s RestProblem,
    found: &'s Answer,
    yielding: &'s Yielding,
    candidates: &'s [Candidate],
    /// The flat ends of which a point leaves, with the largest of the forces at their points (N).
    tipping: Vec<(RimOf, f64)>,
}

impl<'s> NextModes<'s> {
    pub fn new(
        scene: &Scene<'s>,
        problem: &'s RestProblem,
        found: &'s Answer,
        yielding: &'s Yielding,
        candidates: &'s [Candidate],
    ) -> Self {
        let (elements, touching) = (scene.elements, scene.touching);
        let mut next = NextModes { elements, touching, problem, found, yielding, candidates, tipping: Vec::new() };
        next.tipping = next.tipping_ends();
        next
    }

    /// The blocks, each with its first row and its state.
    fn blocks(&self) -> impl Iterator<Item = (&Block, usize, BlockState)> {
        let firsts = self.problem.blocks.iter().scan(0, |row, block| {
            *row += block.rows.len();
            Some(*row - block.rows.len())
        });
        self.problem.blocks.iter().zip(firsts).zip(&self.found.states).map(|((block, row), is)| (block, row, *is))
    }

    fn moves(&self, row: usize) -> bool {
        self.problem.accelerates(self.found, row, ROUNDING)
    }

    /// The flat ends of which a point leaves, with the largest of the forces at their points (N).
    fn tipping_ends(&self) -> Vec<(RimOf, f64)> {
        let mut ends: Vec<(RimOf, f64)> = Vec::new();
        let mut leaving: Vec<RimOf> = Vec::new();
        for (block, row, is) in self.blocks() {
            if let Of::Contact(index) = block.of
                && let Some(end) = self.candidates[index].contact.flat_end()
            {
                match ends.iter_mut().find(|(known, _)| *known == end) {
                    Some((_, most)) => *most = most.max(self.found.forces[row]),
                    None => ends.push((end, self.found.forces[row])),
                }
                if matches!(is, BlockState::Open | BlockState::AtLower) && self.moves(row) {
                    leaving.push(end);
                }
            }
        }
        ends.retain(|(end, _)| leaving.contains(end));
        ends
    }

    /// Writes the modes of the joints that are at rest, and the contacts that stay closed.
    pub fn write(&self, mode: &mut Mode) {
        let mut kept = Kept::default();
        let mut closed = None;
        for (block, row, is) in self.blocks() {
            match block.of {
                Of::Joint(index) => match self.joint_that_moves(index, row, is) {
                    Some(moves) => {
                        mode.joints[index] = moves;
                        // Its friction pushes as it does now.
                        kept.push(row, self.found.forces[row]);
                    }
                    None => kept.keep(block.clone(), row, false),
                },
                Of::Contact(index) if self.opens(index, row, is) => {}
                Of::Contact(index) => {
                    let (contact, law) = self.closed_contact(index, block, row, is);
                    let begins = self.candidates[index].slip.norm() == 0.0 && matches!(law, Law::Sliding { .. });
                    kept.keep(Block { law, ..block.clone() }, row, begins);
                    mode.contacts.push(contact);
                    closed = Some(index);
                }
                // The contact before it has been left out.
                Of::Moment { contact, .. } if closed != Some(contact) => {}
                Of::Moment { contact, spinning } => {
                    let (moment, law) = self.moment(contact, spinning, block, row, is);
                    kept.keep(Block { law, ..block.clone() }, row, false);
                    if let Some(closed) = mode.contacts.last_mut() {
                        let Moments { rolling, spinning: spins } = &mut closed.moments;
                        *(if spinning { spins } else { rolling }) = moment;
                    }
                }
            }
        }
        self.turn_first_slips(kept, mode);
    }

    /// The mode of a joint if it is no longer held.
    fn joint_that_moves(&self, index: usize, row: usize, is: BlockState) -> Option<JointMode> {
        let joint = &self.elements.joints[index];
        let moves = is != BlockState::Inside && self.moves(row) && !joint.is_locked();
        let sliding = if joint.friction > 0.0 { self.found.rates[row].signum() as i8 } else { 0 };
        moves.then_some(JointMode::Free { sliding })
    }

    /// Whether a contact parts.
    fn opens(&self, index: usize, row: usize, is: BlockState) -> bool {
        if matches!(is, BlockState::Open | BlockState::AtLower) && self.moves(row) {
            return true;
        }
        // Points next to the one over which a flat end tips leave too slowly to be told.
        let end = self.candidates[index].contact.flat_end();
        let tips = self.tipping.iter().find(|(of, _)| Some(*of) == end);
        tips.is_some_and(|(_, most)| self.found.forces[row] <= UNLOADED * most)
    }

    /// A contact that stays closed, and the law that it keeps.
    fn closed_contact(&self, index: usize, block: &Block, row: usize, is: BlockState) -> (Closed, Law) {
        let Candidate { contact, slip, .. } = &self.candidates[index];
        let axes = tangents(&touch_motion(&contact.joint, &self.problem.bodies).normal);
        let yields = self.yielding.all || self.candidates[index].slides;
        // Forces across a slip that hold each other take friction by their square: where forces are not unique, their roundings do so, too.
        let slips = |part: f64| [row + 1, row + 2].iter().any(|row| self.problem.accelerates(self.found, *row, part));
        let is_unique = || Chosen::new(&self.problem.blocks).is_unique(self.problem.mobility());
        let on_cone = matches!(block.law, Law::Contact { .. })
            && is == BlockState::Slips
            && !yields
            && !slips(TIED)
            && (!slips(ROUNDING) || !is_unique());
        let slides = match block.law {
            Law::Sliding { .. } => slip.try_normalize(0.0),
            Law::Interval { .. } => Some(slip.try_normalize(0.0).unwrap_or(axes[0])),
            Law::Contact { .. } if on_cone => None,
            // A contact that stays closed without pressing, as of a ball that falls along a wall, is not held by friction either.
            Law::Contact { .. } => self.begins(axes, row, is),
        };
        let law = match slides {
            Some(slides) if block.rows.len() > 1 => {
                let friction = self.touching.pairs[contact.pair].friction;
                Law::Sliding { friction, direction: [axes[0].dot(&slides), axes[1].dot(&slides)] }
            }
            _ => block.law,
        };
        (Closed { contact: contact.clone(), slides, on_cone, moments: Moments::default() }, law)
    }

    /// What the rolling or spinning friction of a closed contact does, and the law that it keeps.
    fn moment(&self, index: usize, spinning: bool, block: &Block, row: usize, is: BlockState) -> (Moment, Law) {
        let Candidate { contact, turning, .. } = &self.candidates[index];
        let normal = touch_motion(&contact.joint, &self.problem.bodies).normal;
        let axes = if spinning { [normal, Vector3::zeros()] } else { tangents(&normal) };
        let direction = match block.law {
            Law::Sliding { .. } if spinning => Some(normal * turning.along.signum()),
            Law::Sliding { .. } => turning.across.try_normalize(0.0),
            _ => self.begins(axes, row, is),
        };
        let lengths = &self.touching.pairs[contact.pair].moments;
        let length = if spinning { lengths.spinning } else { lengths.rolling };
        match direction {
            Some(direction) => {
                let along = [axes[0].dot(&direction), axes[1].dot(&direction)];
                (Moment::Brakes { length, direction }, Law::Sliding { friction: length, direction: along })
            }
            None => (Moment::Holds, block.law),
        }
    }

    /// The direction in which a slip or a turning at rest begins; `None` if it does not. Friction is against it, and gives the better direction where
    /// the acceleration nearly cancels.
    fn begins(&self, axes: [Vector3<f64>; 2], row: usize, is: BlockState) -> Option<Vector3<f64>> {
        let along = |of: &[f64]| axes[0] * of[row + 1] + axes[1] * of[row + 2];
        match is {
            BlockState::Slips => {
                let mobility = self.problem.mobility();
                let mobility = mobility[(row + 1, row + 1)].max(mobility[(row + 2, row + 2)]);
                let (begins, rubs) = (along(&self.found.rates), along(&self.found.forces));
                let slips = if mobility * rubs.norm() > begins.norm() { -rubs } else { begins };
                slips.try_normalize(0.0)
            }
            BlockState::Open if self.moves(row + 1) || self.moves(row + 2) => {
                along(&self.found.rates).try_normalize(0.0)
            }
            _ => None,
        }
    }

    /// Gives contacts that begin to slide their directions where the forces are not unique.
    fn turn_first_slips(&self, kept: Kept, mode: &mut Mode) {
        let directions = kept.first_slips(self.problem.mobility(), &self.problem.offset);
        for (closed, direction) in mode.contacts.iter_mut().zip(directions) {
            if let Some([x, y]) = direction {
                let [along, across] = tangents(&touch_motion(&closed.contact.joint, &self.problem.bodies).normal);
                closed.slides = Some(along * x + across * y);
            }
        }
    }
}
