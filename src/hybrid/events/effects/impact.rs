//! Impacts: the momentum of the whole mechanism, with all its closures, on all limits and contacts that are met at once.
//!
//! The rows W of all meetings ([`crate::instant::holding::blocks`]) have the rates `u = W v`, and `D = W Y Wᵀ`:
//!
//! ```text
//!     u⁺ = D P + u⁻,     limits:  0 ≤ P ⊥ u⁺ + e min(u⁻, 0) ≥ 0,     contacts: the same along the normal, within Coulomb's cone
//!     v⁺ = v⁻ + Y Wᵀ P,  lost = −½ (u⁻ + u⁺)ᵀ P ≥ 0  (J)
//! ```
//!
//! where the tangents of belts add their velocity w to u, and their drives do the work `−w · P`; in the rounds of [`crate::instant::cone::impact`]. Near gimbal lock the joints of limits have the rates u⁺ of the law, and the others follow from
//! the mass matrix ([`crate::events::effects::resting`]). Efforts that are finite, of friction in joints and of motors, give no impulse, but for
//! joints that would slip by too little to matter ([`crate::events::effects::brakes`]).
//!
//! Source: J. J. Moreau, "Unilateral contact and dry friction in finite freedom dynamics" (1988).

use crate::events::effects::brakes::Brake;
use crate::events::effects::decision::Scene;
use crate::events::effects::resting::{energy, give_rates};
use crate::events::forces::chosen::Chosen;
use crate::events::modes::tolerances::RATE_AFTER_IMPACT;
use crate::instant::cone::impact::impact;
use crate::instant::cone::problem::{Law, Problem, Unsolved};
use crate::instant::holding::blocks::{Block, Of, Rows};
use crate::mechanism::motion::state::State;

/// An impact that gains more than this part of the kinetic energy is wrong.
pub const GAIN: f64 = 1e-6;
/// Limits of a tree whose impact is off balance by more than this part of the kinetic energy are near gimbal lock: D is a difference of large numbers.
const OFF: f64 = 1e-10;

/// Rates that are this part of the terms that they are the sum of are roundings.
const ROUNDING: f64 = 1e-14;

/// A limit or contact that is met.
#[derive(Clone, Debug)]
pub struct Meeting {
    /// Its first row is positive towards the allowed side.
    pub block: Block,
    /// e.
    pub restitution: f64,
    /// Rates along its first row below this are rest [rad/s or m/s].
    pub rest: f64,
}

impl Meeting {
    /// The rate along its first row.
    pub fn rate(&self, velocity: &[f64]) -> f64 {
        self.block.rows[0].rate(velocity)
    }

    /// Whether it approaches at these velocities, faster than rest.
    pub fn approaches(&self, velocity: &[f64]) -> bool {
        self.rate(velocity) < -self.rest
    }
}

/// The results of impacts.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Impulses {
    /// Along the first row of everything that is met [N m s or N s].
    pub normal: Vec<f64>,
    /// Along all rows of everything that is met, one after another.
    pub rows: Vec<f64>,
    /// Kinetic energy that was lost, and the work of driven surfaces (J).
    pub lost: f64,
    pub driven: f64,
    /// The energy that omitted rebounds have not given back (J).
    pub cut: f64,
    /// The joints that friction has held, and by how much they would have slipped (rad or m).
    pub held: Vec<Brake>,
    pub slides: f64,
    /// The part of the rates in which it is not known, because the law could not be solved to its accuracy.
    pub residual: f64,
    /// Rates below this [m/s or rad/s] are roundings of the terms that they are the sum of, as of a light body between heavy ones, or not known.
    pub rounding: f64,
}

impl Impulses {
    /// No impulse on any of these.
    pub fn none(meetings: &[Meeting]) -> Self {
        let rows = meetings.iter().map(|meeting| meeting.block.rows.len()).sum();
        Impulses { normal: vec![0.0; meetings.len()], rows: vec![0.0; rows], ..Impulses::default() }
    }
}

/// The normal impulses that would hold everything that is met (N s), the least ones: where they press says where a flat end begins to tip.
pub fn holding_impulses(scene: &mut Scene, state: &State, meetings: &[Meeting]) -> Vec<f64> {
    let blocks: Vec<Block> = meetings.iter().map(|meeting| meeting.block.clone()).collect();
    let rows = Rows::of(scene.response, state, &blocks);
    let impulses = Chosen::new(&blocks).solve(&rows.square, &rows.rates(&state.velocity), false);
    let mut row = 0;
    let normal = |block: &Block| {
        row += block.rows.len();
        impulses[row - block.rows.len()]
    };
    blocks.iter().map(normal).collect()
}

/// Whether all that can be met are limits of a tree.
fn is_of_limits(scene: &Scene) -> bool {
    !scene.whole.has_closures() && scene.touching.pairs.is_empty()
}

/// The kinetic energy of a state with these velocities (J).
fn kinetic_energy(scene: &Scene, state: &State, velocity: &[f64]) -> f64 {
    energy(scene.whole, &State { velocity: velocity.to_vec(), ..state.clone() }).kinetic
}

/// The freedom of the joint of a block with its rate, along the freedom instead of the row.
fn rate_of_joint(block: &Block, rate: f64) -> Option<(usize, f64)> {
    let row = block.rows.first()?;
    let freedom = row.iter().position(|entry| *entry != 0.0)?;
    Some((freedom, rate / row[freedom]))
}

/// Changes the velocities of a state so that no limit or contact approaches; rates of limits that end at rest are exactly zero. Joints whose brakes bear the
/// blow stay at rest.
pub fn collide(
    scene: &mut Scene,
    state: &mut State,
    meetings: &[Meeting],
    brakes: &[Brake],
) -> Result<Impulses, Unsolved> {
    let mut done = Impulses::none(meetings);
    if meetings.is_empty() {
        return Ok(done);
    }
    if !meetings.iter().any(|meeting| meeting.approaches(&state.velocity)) {
        return Ok(done);
    }
    let count = state.velocity.len();
    let mut blocks: Vec<Block> = meetings.iter().map(|meeting| meeting.block.clone()).collect();
    blocks.extend(brakes.iter().map(|brake| brake.block(count)));
    let rows = Rows::of(scene.response, state, &blocks);
    let before = rows.rates(&state.velocity);
    let laws: Vec<Law> = blocks.iter().map(|block| block.law).collect();
    let mut restitution: Vec<f64> = meetings.iter().map(|meeting| meeting.restitution).collect();
    restitution.resize(blocks.len(), 0.0);
    let problem = Problem { mobility: &rows.square, free: &before, laws: &laws };
    let found = match impact(&problem, &restitution, scene.solvers) {
        Ok(found) if found.residual == 0.0 || brakes.is_empty() => found,
        Err(error) if brakes.is_empty() => return Err(error),
        _ => return collide(scene, state, meetings, &[]),
    };
    let first = before.len() - brakes.len();
    let borne = || brakes.iter().zip(first..).map(|(brake, row)| (brake, row, found.impulses[row]));
    let bears = |(brake, row, impulse): (&Brake, usize, f64)| brake.bears(&rows, row, impulse).then_some(*brake);
    let held: Vec<Brake> = borne().filter_map(bears).collect();
    if held.len() < brakes.len() {
        return collide(scene, state, meetings, &held);
    }
    done.slides = borne().map(|(brake, row, impulse)| brake.slide(&rows, row, impulse)).sum();
    let velocity = state.velocity.clone();
    rows.add(&found.impulses, &mut state.velocity);
    (done.lost, done.cut, done.residual) = (found.lost, found.cut, found.residual);
    done.driven = rows.work_of_belts(&found.impulses);
    // The drive of a joint that is moved in time does work in an impact.
    if is_of_limits(scene) && !scene.whole.moves_joints() {
        let kinetic = kinetic_energy(scene, state, &velocity);
        let off = |done: &Impulses, state: &State| {
            (kinetic - kinetic_energy(scene, state, &state.velocity) - done.lost).abs()
        };
        // NaN is off, too.
        let balances = off(&done, state) <= OFF * kinetic;
        if !balances {
            state.velocity.copy_from_slice(&velocity);
            let rates = blocks.iter().zip(&found.rates).zip(&found.impulses).filter(|(_, impulse)| **impulse != 0.0);
            let rates: Vec<(usize, f64)> = rates.filter_map(|((block, rate), _)| rate_of_joint(block, *rate)).collect();
            done.lost = give_rates(scene.whole, state, &rates);
        }
        let gains_nothing = done.lost >= -GAIN * kinetic;
        if !gains_nothing {
            state.velocity = velocity;
            return Err(Unsolved::Numbers { block: 0 });
        }
    }
    let terms = rows.square.row_iter().map(|row| row.iter().zip(&found.impulses).map(|(d, p)| (d * p).abs()).sum());
    let largest = before.iter().fold(0.0_f64, |most, rate| most.max(rate.abs()));
    done.rounding = ROUNDING * terms.fold(0.0, f64::max) + found.residual * largest;
    let mut row = 0;
    for (index, meeting) in meetings.iter().enumerate() {
        done.normal[index] = found.impulses[row];
        if let Of::Joint(joint) = meeting.block.of
            && done.normal[index] > 0.0
            && found.rates[row].abs() <= RATE_AFTER_IMPACT * largest.max(meeting.rest)
        {
            // A joint that an impulse has stopped is at rest.
            state.velocity[scene.elements.joints[joint].coordinate.freedom] = 0.0;
        }
        row += meeting.block.rows.len();
    }
    brakes.iter().for_each(|brake| state.velocity[brake.freedom] = 0.0);
    done.held = brakes.to_vec();
    done.rows = found.impulses[..first].to_vec();
    Ok(done)
}
