//! The problem of the elements at rest, at the level of accelerations: posed and solved.
//!
//! ```text
//!     a = b + D λ,   b = W a_free + Ẇ v,   D = W Y Wᵀ        a_free: accelerations under all efforts but λ
//! ```
//!
//! with the law of each element (header of [`crate::events::effects::deciding`]). The rows of W stand in the order of the joints, then of the contacts
//! that do not open, each before its moments.

use crate::events::effects::decision::{Candidate, Scene, Undecided, Yielding};
use crate::events::effects::shared_pressures::solve_as_steps_share;
use crate::events::forces::chosen::Chosen;
use crate::events::modes::mode::{JointMode, Mode};
use crate::instant::cone::problem::{Answer, Law, Unsolved};
use crate::instant::holding::blocks::{Block, Of, Rows, rows_of_contact, second_rates};
use crate::instant::holding::elements::Elements;
use crate::instant::holding::moments::{blocks_of_turning, solve_with_moments};
use crate::instant::holding::pairs::Pair;
use crate::instant::holding::weights::held_weights;
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::contact::TouchJoint;
use crate::mechanism::motion::contact_solvers::ContactSolvers;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use crate::mechanism::motion::touches::{tangents, touch_motion};
use nalgebra::{DMatrix, Vector3};

/// Accelerations below this part of the largest of all, and of one unit, are rounding.
const DIFFERENCE: f64 = 1e-14;
/// The part by which the bound of an element is reduced if an event has found the element at that bound.
const LESS: f64 = 1e-9;

/// The elements at rest with their laws, before it is known how they respond.
pub(super) struct AtRest {
    /// Places and rates of all bodies; empty without candidates and without weights that motors hold.
    bodies: Vec<BodyState>,
    blocks: Vec<Block>,
    /// Those from outside and of motors, and friction of joints that move; one entry a degree of freedom.
    efforts: Vec<f64>,
}

impl AtRest {
    /// The joints whose rate is zero and that are held, and the contacts that do not open; `efforts` are those from outside and of motors. Joints get
    /// their modes, and the contacts of the mode are cleared.
    pub fn of(
        scene: &Scene,
        mode: &mut Mode,
        state: &State,
        efforts: &[f64],
        yielding: &Yielding,
        candidates: &[Candidate],
    ) -> Self {
        let asked = !candidates.is_empty() || !scene.whole.forces.gravity_compensations.is_empty();
        let bodies = if asked { body_states(scene.whole, state) } else { Vec::new() };
        let mut at_rest = AtRest { bodies, blocks: Vec::new(), efforts: efforts.to_vec() };
        for (index, joint) in scene.elements.joints.iter().enumerate() {
            let (rate, side) = (joint.rate(state), joint.side(joint.position(state)));
            let goes = yielding.joints.iter().find(|(yields, _)| *yields == index).map(|(_, direction)| *direction);
            let goes = if rate != 0.0 { Some(rate.signum() as i8) } else { goes };
            mode.joints[index] = if let Some(direction) = goes {
                let sliding = if joint.friction > 0.0 { direction } else { 0 };
                at_rest.efforts[joint.coordinate.freedom] -= f64::from(sliding) * joint.friction;
                JointMode::Free { sliding }
            } else if joint.friction > 0.0 || side.is_some() {
                let held = JointMode::Held { on: side };
                let (count, bounds) = (scene.whole.velocity_count, held.holding(joint).into());
                at_rest.blocks.push(Block::of_joint(index, joint.coordinate.freedom, count, 1.0, bounds));
                held
            } else {
                JointMode::Free { sliding: 0 }
            };
        }
        mode.contacts.clear();
        for (index, candidate) in candidates.iter().enumerate().filter(|(_, candidate)| !candidate.opens) {
            at_rest.add_contact(scene, index, candidate);
        }
        at_rest
    }

    fn add_contact(&mut self, scene: &Scene, index: usize, candidate: &Candidate) {
        let (whole, bodies) = (scene.whole, &self.bodies);
        let Pair { friction, moments, .. } = &scene.touching.pairs[candidate.contact.pair];
        let joint = &candidate.contact.joint;
        let law = Law::of_contact(*friction, direction_in(joint, bodies, &candidate.slip));
        let rows = rows_of_contact(whole, bodies, joint, *friction > 0.0);
        self.blocks.push(Block { of: Of::Contact(index), law, rows });
        self.blocks.extend(blocks_of_turning(whole, bodies, joint, moments, index, &candidate.turning));
    }

    pub fn is_empty(&self) -> bool {
        self.blocks.is_empty()
    }

    /// With D and b at a state.
    pub fn respond(self, scene: &mut Scene, state: &State, candidates: &[Candidate]) -> RestProblem {
        let AtRest { bodies, blocks, efforts } = self;
        let mut free = vec![0.0; state.velocity.len()];
        scene.response.accelerations(state, &efforts, &mut free);
        let rows = Rows::of(scene.response, state, &blocks);
        let of_contact = |contact: usize| &candidates[contact].contact.joint;
        let offset = second_rates(scene.whole, scene.elements, &bodies, state, &free, &blocks, of_contact);
        let largest = free.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        let cancelled = held_weights(scene.whole, &bodies, &rows);
        RestProblem { bodies, blocks, free, largest, cancelled, rows, offset }
    }
}

/// The elements at rest with their laws, and how they respond.
pub(super) struct RestProblem {
    /// Places and rates of all bodies; empty without candidates and without weights that motors hold.
    pub bodies: Vec<BodyState>,
    pub blocks: Vec<Block>,
    /// a_free, one entry a degree of freedom.
    free: Vec<f64>,
    /// The largest of them.
    largest: f64,
    /// The acceleration of each row by weights that motors hold.
    cancelled: Vec<f64>,
    rows: Rows,
    /// b, one entry a row.
    pub offset: Vec<f64>,
}

impl RestProblem {
    /// D.
    pub fn mobility(&self) -> &DMatrix<f64> {
        &self.rows.square
    }

    /// Reduces the bounds of the elements that an event has found there.
    pub fn weaken(&mut self, elements: &Elements, yielding: &Yielding, candidates: &[Candidate]) {
        let mut row = 0;
        for block in &mut self.blocks {
            let load = self.offset[row].abs() / self.rows.square[(row, row)].max(f64::MIN_POSITIVE);
            match (block.of, &mut block.law) {
                (Of::Joint(index), Law::Interval { lower, upper }) => {
                    let less = if yielding.all { LESS * elements.joints[index].friction.max(load) } else { 0.0 };
                    let less = less.min(0.25 * (*upper - *lower));
                    if lower.is_finite() || upper.is_finite() {
                        (*lower, *upper) = (*lower + less, *upper - less);
                    }
                }
                (Of::Contact(index), Law::Contact { friction }) if yielding.all || candidates[index].slides => {
                    *friction *= 1.0 - LESS;
                }
                (Of::Moment { contact, spinning }, Law::Contact { friction })
                    if yielding.all || candidates[contact].turns[usize::from(spinning)] =>
                {
                    *friction *= 1.0 - LESS;
                }
                _ => {}
            }
            row += block.rows.len();
        }
    }

    /// The forces that would hold all elements; one entry a row.
    pub fn holding_forces(&self) -> Vec<f64> {
        Chosen::new(&self.blocks).solve(&self.rows.square, &self.offset, false)
    }

    /// λ and a under the laws, and the residual as a part of the largest force: zero if they were solved to their accuracy.
    pub fn solve(&mut self, solvers: &mut ContactSolvers) -> Result<(Answer, f64), Undecided> {
        let RestProblem { blocks, rows, offset, .. } = self;
        let laws: Vec<Law> = blocks.iter().map(|block| block.law).collect();
        let solved = solve_with_moments(blocks, &mut rows.square, offset, &laws, |problem| {
            solve_as_steps_share(blocks, problem, solvers)
        });
        match solved {
            Ok(found) => Ok((found, 0.0)),
            Err(Unsolved::Stopped { best }) => {
                let off = best.residual;
                Ok((*best, off))
            }
            Err(Unsolved::Inconsistent { block, .. }) => Err(match blocks[block].of {
                Of::Contact(index) => Undecided::Inconsistent(index),
                Of::Joint(_) | Of::Moment { .. } => Undecided::Unsolved,
            }),
            Err(_) => Err(Undecided::Unsolved),
        }
    }

    /// The forces along the normals of all contacts of `count` candidates, among forces of all rows (N).
    pub fn along_normals(&self, forces: &[f64], count: usize) -> Vec<f64> {
        let (mut normal, mut row) = (vec![0.0; count], 0);
        for block in &self.blocks {
            if let Of::Contact(index) = block.of {
                normal[index] = forces[row];
            }
            row += block.rows.len();
        }
        normal
    }

    /// Whether the acceleration of a row is more than this part of the terms that it is the sum of.
    pub fn accelerates(&self, found: &Answer, row: usize, part: f64) -> bool {
        // Each acceleration is a difference of others.
        let terms: f64 =
            (0..self.offset.len()).map(|column| (self.rows.square[(row, column)] * found.forces[column]).abs()).sum();
        found.rates[row].abs()
            > part * (terms + self.offset[row].abs()) + DIFFERENCE * (1.0 + self.largest + self.cancelled[row])
    }

    /// The accelerations under these forces; one entry a degree of freedom.
    pub fn into_accelerations(mut self, forces: &[f64]) -> Vec<f64> {
        self.rows.add(forces, &mut self.free);
        self.free
    }
}

/// The direction of a slip in the tangents of a contact; `None` without a slip.
fn direction_in(joint: &TouchJoint, bodies: &[BodyState], slip: &Vector3<f64>) -> Option<[f64; 2]> {
    let direction = slip.try_normalize(0.0)?;
    let [first, second] = tangents(&touch_motion(joint, bodies).normal);
    Some([direction.dot(&first), direction.dot(&second)])
}
