//! The forces at closed contacts and on held joints at an instant, where contacts or closures take part.
//!
//! ```text
//!     D̃ λ = −b,    b = W a_free + Ẇ v,   D̃ = W Y W̃ᵀ
//!     W:  rows of the held freedoms; of a contact that sticks its normal and tangents, of one that slides its normal n
//!     W̃: the same, but n − μ t of a contact that slides along t, t at that instant
//! ```
//!
//! Rolling and spinning friction that holds has rows of its own; while it brakes, the normal forces of contacts push along these rows.
//!
//! They are worked out at the level of accelerations, from the state alone, and have the order of the ends of steps. If some rows imply others, `zᵀ W
//! = 0`, and a contact slides, the λ of steps is taken: `zᵀ C λ = 0` with the same compliance C for all contacts
//! ([`crate::lobatto::coupled::dependent`]). If every contact sticks, the choice of λ does not change the motion. It is the least-norm one, and the
//! question is whether any admissible λ exists ([`crate::instant::cone::margin`]).

use crate::events::forces::chosen::Chosen;
use crate::events::modes::mode::{Closed, JointMode};
use crate::events::modes::present::Present;
use crate::events::modes::tolerances::direction_of_slip;
use crate::instant::cone::apart::blocks_joined;
use crate::instant::cone::problem::{Law, Problem};
use crate::instant::cone::{Known, margin_or_clear};
use crate::instant::dynamics::response::Response;
use crate::instant::holding::blocks::{Block, Of, Rows, fall, least_answer, rows_of_contact, second_rates};
use crate::instant::holding::moments::{Turning, blocks_of_moments, give_loads, have_moments};
use crate::instant::holding::pairs::Pair;
use crate::instant::holding::touching::Contact;
use crate::instant::holding::weights::held_weights;
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use crate::mechanism::motion::touches::{tangents, touch_motion};
use nalgebra::DVector;
use std::ops::Range;

/// Bodies whose relative acceleration is below this part of their fall are in common free fall and do not press. Tilts of 1e-13 that an impact has
/// left make this much of a spin.
const FALLS: f64 = 1e-10;

/// The margin leaves a contact this part of the rounding of its pressure, and so ends before the pressures do: contacts that end with it part together.
const EARLIER: f64 = 0.1;

/// The forces of one instant.
#[derive(Clone)]
pub(crate) struct ClosedForces {
    /// λ of the held joints [N m or N], by their numbers among the elements, each with the size of the terms that cancel in it.
    pub joints: Vec<(usize, f64, f64)>,
    /// λ of the contacts (N): normal, and along both tangents of [`tangents`].
    pub contacts: Vec<[f64; 3]>,
    /// Moments of rolling friction, about both tangents, and of spinning friction [N m].
    pub moments: Vec<[f64; 3]>,
    /// The force with which each contact would press if the bodies beside it fell on each other (N).
    pub weights: Vec<f64>,
    /// The size of the terms that cancel in the force of each contact: the largest of the blocks that feel each other (N).
    pub sizes: Vec<f64>,
    /// The held blocks.
    pub load: Load,
}

/// Held blocks at an instant, each with the size of the terms that cancel in its forces, and with whether it is in free fall with all that feels it.
#[derive(Clone)]
pub(crate) struct Load {
    pub held: Closing,
    sizes: Vec<f64>,
    together: Vec<bool>,
}

impl Load {
    /// The largest margin of admissible forces, where they are not unique; zero of blocks that fall together. Within the rounding `own` of its pressure a
    /// contact may have less than its law says. Blocks that feel each other have as much more as their forces are known, by the names and sizes of
    /// blocks (N).
    pub fn margin(&self, own: impl Fn(usize) -> f64, known: impl Fn(Of, f64) -> f64) -> f64 {
        let laws = self.held.laws();
        let known = |block: usize| {
            let of = self.held.blocks[block].of;
            let own = if let Of::Contact(contact) = of { EARLIER * own(contact) } else { 0.0 };
            Known { part: known(of, self.sizes[block]), own }
        };
        margin_or_clear(&self.held.problem(&laws), known, |block| self.together[block])
    }
}

/// The blocks of a mode: held joints, then closed contacts; joints that slide have given efforts.
fn blocks(at: &Present, bodies: &[BodyState]) -> Vec<Block> {
    let Present { whole, elements, touching, mode, .. } = *at;
    let held = elements.joints.iter().zip(&mode.joints).enumerate();
    let held = held.filter(|(_, (_, mode))| matches!(mode, JointMode::Held { .. })).map(|(index, (joint, mode))| {
        Block::of_joint(index, joint.coordinate.freedom, whole.velocity_count, 1.0, mode.holding(joint).into())
    });
    let contacts = mode.contacts.iter().enumerate().flat_map(|(index, closed)| {
        let Pair { friction, moments, .. } = &touching.pairs[closed.contact.pair];
        let joint = &closed.contact.joint;
        let law = Law::of_contact(*friction, slide(closed, bodies, at.rest));
        let rows = rows_of_contact(whole, bodies, joint, *friction > 0.0);
        let turns = blocks_of_moments(whole, bodies, joint, moments, index, &closed.moments);
        std::iter::once(Block { of: Of::Contact(index), law, rows }).chain(turns)
    });
    held.chain(contacts).collect()
}

/// The direction in which a contact slides now, in its tangents; `None` if it sticks. A slip at rest [m/s] has the direction in which it began: an event at
/// which another slip stops leaves a residual in each slip that begins there.
fn slide(closed: &Closed, bodies: &[BodyState], rest: f64) -> Option<[f64; 2]> {
    let begins = closed.slides?;
    let touch = touch_motion(&closed.contact.joint, bodies);
    let [first, second] = tangents(&touch.normal);
    let direction = direction_of_slip(&touch.slip, begins, SLOWEST.max(rest));
    let along = [direction.dot(&first), direction.dot(&second)];
    let length = along[0].hypot(along[1]).max(f64::MIN_POSITIVE);
    Some(along.map(|part| part / length))
}

/// Slower slips have the direction in which they began [m/s].
const SLOWEST: f64 = 1e-12;

/// Whether the forces on held blocks are unique.
pub(crate) fn are_unique(at: &Present, response: &mut Response, state: &State) -> bool {
    let bodies = body_states(at.whole, state);
    let blocks = blocks(at, &bodies);
    let rows = Rows::of(response, state, &blocks);
    Chosen::new(&blocks).is_unique(&rows.square)
}

/// Closed contacts and held joints at an instant, and their response.
#[derive(Clone)]
pub(crate) struct Closing {
    bodies: Vec<BodyState>,
    pub blocks: Vec<Block>,
    rows: Rows,
    /// The accelerations without the forces of held blocks, one entry a degree of freedom.
    free: Vec<f64>,
    /// The acceleration of each row by weights that motors hold.
    cancelled: Vec<f64>,
    /// b: what the rows of the blocks are accelerated by then.
    offset: Vec<f64>,
}

impl Closing {
    /// In a state of a mode, under efforts from outside, of friction in joints and of motors.
    pub fn at(at: &Present, response: &mut Response, state: &State, efforts: &[f64]) -> Self {
        let whole = at.whole;
        let bodies = body_states(whole, state);
        let blocks = blocks(at, &bodies);
        let rows = Rows::of(response, state, &blocks);
        let cancelled = held_weights(whole, &bodies, &rows);
        let free = vec![0.0; whole.velocity_count];
        let mut closing = Closing { bodies, blocks, rows, free, cancelled, offset: Vec::new() };
        closing.drive(at, response, state, efforts);
        closing
    }

    /// The same in the same state under other efforts: its bodies, rows and their response are functions of the state alone.
    pub fn drive(&mut self, at: &Present, response: &mut Response, state: &State, efforts: &[f64]) {
        let Present { whole, elements, mode, .. } = *at;
        let Closing { bodies, blocks, free, offset, .. } = self;
        response.accelerations(state, efforts, free);
        let joint = |contact: usize| &mode.contacts[contact].contact.joint;
        *offset = second_rates(whole, elements, bodies, state, free, blocks, joint);
    }

    /// How fast what each row is of falls, or would fall without motors that hold it.
    fn falls(&self) -> Vec<f64> {
        let rows = self.blocks.iter().flat_map(|block| &block.rows);
        rows.zip(&self.cancelled).map(|(row, cancelled)| fall(row, &self.free) + cancelled).collect()
    }

    /// Whether a block falls without a relative acceleration. Rows across the fall of a contact have the roundings of the rows along it; a sliding
    /// contact is accelerated along its plane as well, but only its normal is an equation.
    fn falls_along(&self, block: &Block, rows: Range<usize>, falls: &[f64]) -> bool {
        if let Of::Moment { .. } = block.of {
            return true;
        }
        let held = if matches!(block.law, Law::Sliding { .. }) { rows.start..rows.start + 1 } else { rows.clone() };
        let fall = falls[rows].iter().fold(0.0_f64, |most, fall| most.max(*fall));
        self.offset[held].iter().all(|offset| offset.abs() <= FALLS * fall)
    }

    /// For each block the size of the terms that cancel in its forces (N), and whether it is in free fall: both of all blocks that feel each other. A
    /// heavy body does not count for a light one beside it.
    fn sizes(&self, forces: &[f64]) -> (Vec<f64>, Vec<bool>) {
        let Closing { blocks, rows, offset, .. } = self;
        let ranges = self.ranges();
        let falls = self.falls();
        let least = least_answer(&rows.square);
        let size = |block: usize, together: bool| {
            // Torques have another unit, and the rows that stand for normal forces are those forces. Tangents of a sliding contact are no equations:
            // if nothing answers along them, as between a moved cam and a guided follower, they would be of any size.
            let equations = match (blocks[block].of, blocks[block].law) {
                (Of::Moment { .. }, _) => 0,
                (_, Law::Sliding { .. }) => 1,
                _ => ranges[block].len(),
            };
            let equations = ranges[block].clone().take(equations).filter(|&row| rows.square[(row, row)] > least);
            let of_row = |row: usize| {
                let parts = if together { falls[row] } else { offset[row].abs() };
                forces[row].abs().max(parts / rows.square[(row, row)].max(f64::MIN_POSITIVE))
            };
            equations.map(of_row).fold(0.0, f64::max)
        };
        let (mut sizes, mut all_fall) = (vec![0.0; blocks.len()], vec![false; blocks.len()]);
        for part in blocks_joined(&rows.square, &ranges) {
            let together = part.iter().all(|&block| self.falls_along(&blocks[block], ranges[block].clone(), &falls));
            let most = part.iter().map(|&block| size(block, together)).fold(0.0, f64::max);
            part.into_iter().for_each(|block| (sizes[block], all_fall[block]) = (most, together));
        }
        (sizes, all_fall)
    }

    /// The rows of each block.
    fn ranges(&self) -> Vec<Range<usize>> {
        let ends = self.blocks.iter().scan(0, |end, block| {
            let first = *end;
            *end += block.rows.len();
            Some(first..*end)
        });
        ends.collect()
    }

    /// Their rows.
    pub fn rows(&self) -> &Rows {
        &self.rows
    }

    /// λ of all rows.
    pub fn forces(&self, unique: bool) -> Vec<f64> {
        Chosen::new(&self.blocks).solve(&self.rows.square, &self.offset, unique)
    }

    /// The laws of the blocks.
    pub fn laws(&self) -> Vec<Law> {
        self.blocks.iter().map(|block| block.law).collect()
    }

    /// Bounds the moments of rolling and spinning friction by the normal forces of these forces, for [`Closing::problem`].
    pub fn bound_moments(&mut self, forces: &[f64]) {
        if have_moments(&self.blocks) {
            give_loads(&self.blocks, &mut self.rows.square, &mut self.offset, forces);
        }
    }

    /// The problem of these laws.
    pub fn problem<'p>(&'p self, laws: &'p [Law]) -> Problem<'p> {
        Problem { mobility: &self.rows.square, free: &self.offset, laws }
    }
}

/// The forces of held blocks in a state of a mode.
pub(crate) fn closed_forces(at: &Present, mut held: Closing, unique: bool) -> ClosedForces {
    let forces = held.forces(unique);
    held.bound_moments(&forces);
    let Closing { blocks, rows, .. } = &held;
    let (sizes_of_blocks, together) = held.sizes(&forces);
    let (mut joints, mut contacts, mut weights, mut row) = (Vec::new(), Vec::new(), Vec::new(), 0);
    let (mut moments, mut sizes): (Vec<[f64; 3]>, Vec<f64>) = (Vec::new(), Vec::new());
    for (block, &size) in blocks.iter().zip(&sizes_of_blocks) {
        match block.of {
            Of::Joint(index) => joints.push((index, forces[row], size)),
            Of::Contact(_) => {
                sizes.push(size);
                let mut force = [0.0; 3];
                force[..block.rows.len()].copy_from_slice(&forces[row..row + block.rows.len()]);
                contacts.push(force);
                moments.push([0.0; 3]);
                weights.push(at.whole.gravity.norm() / rows.square[(row, row)].max(f64::MIN_POSITIVE));
            }
            Of::Moment { contact, spinning: false } => {
                moments[contact][..2].copy_from_slice(&forces[row + 1..row + 3]);
            }
            Of::Moment { contact, spinning: true } => moments[contact][2] = forces[row + 1],
        }
        row += block.rows.len();
    }
    ClosedForces { joints, contacts, moments, weights, sizes, load: Load { held, sizes: sizes_of_blocks, together } }
}

/// The accelerations of a state in a mode, one entry a degree of freedom, each with the size of the terms that cancel in it.
pub(crate) fn accelerations(
    at: &Present,
    response: &mut Response,
    state: &State,
    efforts: &[f64],
    unique: bool,
) -> Vec<(f64, f64)> {
    let held = Closing::at(at, response, state, efforts);
    let forces = DVector::from_vec(held.forces(unique));
    let columns = held.rows.columns();
    // All forces are the solution of one system, so that the rounding of tiny forces is relative to the largest.
    let largest = forces.iter().fold(0.0_f64, |most, force| most.max(force.abs()));
    let sizes = columns.row_iter().map(|row| largest * row.abs().sum());
    let pushed = columns * forces;
    let all = held.free.iter().zip(pushed.iter().zip(sizes));
    all.map(|(free, (pushed, size))| (free + pushed, free.abs() + size)).collect()
}

/// How slips go on from a state, if their rates stay as they are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Slipping {
    /// The sliding contact, or the sliding contacts of a pair together, that would stop first. A slip at rest has begun just now: its speed and its
    /// acceleration are roundings, and their ratio is no time.
    pub first: Option<Stop>,
    /// When the first slip that is faster than rest would have turned by half a right angle (s).
    pub turns: f64,
}

/// The same of a state.
pub(crate) fn slipping(
    at: &Present,
    response: &mut Response,
    state: &State,
    efforts: &[f64],
    unique: bool,
) -> Slipping {
    let held = Closing::at(at, response, state, efforts);
    let Closing { bodies, blocks, rows, offset, .. } = &held;
    let rates = &rows.square * DVector::from_vec(held.forces(unique)) + DVector::from_column_slice(offset);
    // If forces are not unique, the slips of one pair stop together.
    let mut stops: Vec<Stop> = Vec::new();
    let mut turns = f64::INFINITY;
    let mut row = 0;
    for block in blocks {
        if let Law::Sliding { direction: [x, y], .. } = block.law {
            let (index, what) = match block.of {
                Of::Moment { contact, spinning: true } => (contact, What::Spins),
                Of::Moment { contact, spinning: false } => (contact, What::Rolls),
                Of::Contact(index) | Of::Joint(index) => (index, What::Slips),
            };
            let Contact { pair, joint, .. } = &at.mode.contacts[index].contact;
            let motion = touch_motion(joint, bodies);
            let turning = || Turning::of(joint, bodies, &motion.normal);
            let arm = if what == What::Slips { 1.0 } else { at.touching.pairs[*pair].arm() };
            let speed = match what {
                What::Slips => motion.slip.norm(),
                What::Rolls => arm * turning().across.norm(),
                What::Spins => arm * turning().along.abs(),
            };
            let falls = -arm * (x * rates[row + 1] + y * rates[row + 2]);
            let across = arm * (x * rates[row + 2] - y * rates[row + 1]).abs();
            if speed > at.rest && across > 0.0 {
                turns = turns.min(speed / across);
            }
            match stops.iter_mut().find(|known| !unique && what == What::Slips && known.is_slip_of(*pair)) {
                Some(Stop { speed: all, falls: fall, across: aside, .. }) => {
                    (*all, *fall, *aside) = (*all + speed, *fall + falls, *aside + across);
                }
                None => stops.push(Stop { contact: index, what, pair: *pair, speed, falls, across }),
            }
        }
        row += block.rows.len();
    }
    let moving = stops.into_iter().filter(|stop| stop.speed > at.rest);
    Slipping { first: moving.min_by(|one, other| one.time().total_cmp(&other.time())), turns }
}

/// A motion that friction brakes at a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum What {
    /// Its slip.
    Slips,
    /// Its turning across and along the normal.
    Rolls,
    Spins,
}

/// A slip, or all of a pair together; or a turning, with speeds and accelerations at the arm of its pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stop {
    /// The contact, the first of its pair where forces are not unique; what stops; and its pair.
    pub contact: usize,
    pub what: What,
    pub pair: usize,
    /// Its speed [m/s], and how fast it falls and turns aside [m/s²].
    pub speed: f64,
    pub falls: f64,
    pub across: f64,
}

impl Stop {
    /// Whether it is a slip of a pair.
    fn is_slip_of(&self, pair: usize) -> bool {
        self.what == What::Slips && self.pair == pair
    }

    /// When it would stop (s); infinite if it does not fall.
    pub fn time(&self) -> f64 {
        if self.falls > 0.0 { self.speed / self.falls } else { f64::INFINITY }
    }
}
