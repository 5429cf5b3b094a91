//! Rolling and spinning friction at an instant, as blocks beside the blocks of their contacts.
//!
//! The moment of a block is bounded by the normal force λ of its contact, with the length ρ or σ and the turning ω ([`crate::mechanism::description::contact`]):
//!
//! ```text
//!     rows:    [λ; e₁ · ω, e₂ · ω]  of rolling,   [λ; n · ω, 0]  of spinning
//!     law:     |τ| ≤ ρ λ, ω̇ = 0 while it holds;   τ = −ρ λ t while it brakes along t
//! ```
//!
//! The first row stands for λ: it moves no body. In a problem it gets a mobility d of its own and the free rate −d λ, so that its force is λ, and the
//! problem is solved again until λ is the normal force that it gives:
//!
//! ```text
//!     λ⁰ = 0,   λᵏ⁺¹ = normal force of the problem with λᵏ           contracts by about ρ/L, L the size of the body
//! ```
//!
//! Where forces are not unique, as at the corners of a box, each problem shares the load in another way below the accuracy to which it is solved. The
//! rounds end where |λᵏ⁺¹ − λᵏ| no longer shrinks.

use crate::instant::cone::problem::{Answer, Law, Problem, Unsolved};
use crate::instant::holding::blocks::{Block, Of, Row, row_of_torque};
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::contact::{Moment, MomentLengths, Moments, TouchJoint};
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::touches::{tangents, touch_motion};
use nalgebra::{DMatrix, Vector3};

/// Rounds of normal forces, at most; they are found where none changes by more than this part of the largest.
const ROUNDS: usize = 40;
const FOUND: f64 = 1e-14;
/// Normal forces that are not unique change by less than this part of the largest from round to round.
const SHARED: f64 = 1e-6;

/// How a contact turns: the part of `ω_b − ω_a` across the normal, and along it [rad/s].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Turning {
    pub across: Vector3<f64>,
    pub along: f64,
}

impl Turning {
    /// Of a contact with this normal.
    pub fn of(joint: &TouchJoint, bodies: &[BodyState], normal: &Vector3<f64>) -> Self {
        let turning = joint.turning(bodies);
        let along = turning.dot(normal);
        Turning { across: turning - normal * along, along }
    }
}

/// Whether a moment of a contact is of spinning friction, with its length (m); of rolling friction first.
pub(crate) fn moments_of(lengths: &MomentLengths) -> impl Iterator<Item = (bool, f64)> + use<> {
    [(false, lengths.rolling), (true, lengths.spinning)].into_iter().filter(|(_, length)| *length > 0.0)
}

/// The blocks of the moments of a contact, by its number, that turns so: what turns is braked, what does not may be held.
pub(crate) fn blocks_of_turning(
    mechanism: &Mechanism,
    bodies: &[BodyState],
    joint: &TouchJoint,
    lengths: &MomentLengths,
    contact: usize,
    turning: &Turning,
) -> Vec<Block> {
    if lengths.are_zero() {
        return Vec::new();
    }
    let normal = touch_motion(joint, bodies).normal;
    let all = moments_of(lengths).map(|(spinning, length)| {
        let direction = if spinning {
            (turning.along != 0.0).then(|| normal * turning.along.signum())
        } else {
            turning.across.try_normalize(0.0)
        };
        let moment = match direction {
            Some(direction) => Moment::Brakes { length, direction },
            None => Moment::Holds,
        };
        block(mechanism, bodies, joint, [contact, usize::from(spinning)], length, moment)
    });
    all.collect()
}

/// The blocks of the moments of a contact, by its number, in a mode.
pub(crate) fn blocks_of_moments(
    mechanism: &Mechanism,
    bodies: &[BodyState],
    joint: &TouchJoint,
    lengths: &MomentLengths,
    contact: usize,
    moments: &Moments,
) -> Vec<Block> {
    if *moments == Moments::default() {
        return Vec::new();
    }
    let normal = touch_motion(joint, bodies).normal;
    let turning = Turning::of(joint, bodies, &normal);
    let all = moments_of(lengths).map(|(spinning, length)| {
        let of = if spinning { moments.spinning } else { moments.rolling };
        let moment = match of {
            // It brakes against the turning of this instant.
            Moment::Brakes { direction, .. } => {
                let now = if spinning { normal * turning.along } else { turning.across };
                Moment::Brakes { length, direction: now.try_normalize(SLOWEST).unwrap_or(direction) }
            }
            other => other,
        };
        block(mechanism, bodies, joint, [contact, usize::from(spinning)], length, moment)
    });
    all.collect()
}

/// Slower turnings have the direction in which they began [rad/s].
const SLOWEST: f64 = 1e-12;

/// The block of a moment: of the contact `of[0]`, spinning if `of[1]` is one.
fn block(
    mechanism: &Mechanism,
    bodies: &[BodyState],
    joint: &TouchJoint,
    of: [usize; 2],
    length: f64,
    moment: Moment,
) -> Block {
    let normal = touch_motion(joint, bodies).normal;
    let nothing = || Row::from(vec![0.0; mechanism.velocity_count]);
    let row = |along: &Vector3<f64>| row_of_torque(mechanism, bodies, joint, along);
    let [contact, spinning] = of;
    let [first, second] = tangents(&normal);
    let rows = match spinning {
        0 => vec![nothing(), row(&first), row(&second)],
        _ => vec![nothing(), row(&normal), nothing()],
    };
    let law = match moment {
        Moment::Brakes { direction, .. } if spinning == 0 => {
            let along = [direction.dot(&first), direction.dot(&second)];
            let size = along[0].hypot(along[1]).max(f64::MIN_POSITIVE);
            Law::Sliding { friction: length, direction: along.map(|part| part / size) }
        }
        Moment::Brakes { direction, .. } => {
            Law::Sliding { friction: length, direction: [direction.dot(&normal).signum(), 0.0] }
        }
        _ => Law::Contact { friction: length },
    };
    Block { of: Of::Moment { contact, spinning: spinning == 1 }, law, rows }
}

/// Whether some blocks are of moments.
pub(crate) fn have_moments(blocks: &[Block]) -> bool {
    blocks.iter().any(|block| matches!(block.of, Of::Moment { .. }))
}

/// Gives the first row of every moment a mobility and a free rate, for normal forces of the contacts, row by row of all blocks.
pub(crate) fn give_loads(blocks: &[Block], mobility: &mut DMatrix<f64>, free: &mut [f64], forces: &[f64]) {
    let (mut row, mut normal) = (0, 0);
    for block in blocks {
        match block.of {
            Of::Contact(_) => normal = row,
            Of::Moment { .. } => {
                let own = mobility[(row + 1, row + 1)].max(mobility[(row + 2, row + 2)]).max(f64::MIN_POSITIVE);
                mobility[(row, row)] = own;
                free[row] = -own * forces[normal].max(0.0);
                if mobility[(row + 2, row + 2)] == 0.0 {
                    (mobility[(row + 2, row + 2)], free[row + 2]) = (own, 0.0);
                }
            }
            Of::Joint(_) => {}
        }
        row += block.rows.len();
    }
}

/// Solves the laws of blocks under the normal forces that the solution gives, with a mobility and free rates of all rows.
pub(crate) fn solve_with_moments(
    blocks: &[Block],
    mobility: &mut DMatrix<f64>,
    free: &mut [f64],
    laws: &[Law],
    mut solve: impl FnMut(&Problem) -> Result<Answer, Unsolved>,
) -> Result<Answer, Unsolved> {
    if !have_moments(blocks) {
        return solve(&Problem { mobility, free, laws });
    }
    let (mut forces, mut before) = (vec![0.0; free.len()], f64::INFINITY);
    for _ in 0..ROUNDS {
        give_loads(blocks, mobility, free, &forces);
        let answer = solve(&Problem { mobility, free, laws })?;
        let largest = answer.forces.iter().fold(0.0_f64, |most, force| most.max(force.abs()));
        let (mut row, mut changed) = (0, 0.0_f64);
        for block in blocks {
            if let Of::Contact(_) = block.of {
                changed = changed.max((answer.forces[row] - forces[row]).abs());
            }
            row += block.rows.len();
        }
        if changed <= FOUND * largest || (changed <= SHARED * largest && changed >= before) {
            return Ok(answer);
        }
        (forces, before) = (answer.forces, changed);
    }
    give_loads(blocks, mobility, free, &forces);
    let mut best = solve(&Problem { mobility, free, laws })?;
    best.residual = best.residual.max(FOUND);
    Err(Unsolved::Stopped { best: Box::new(best) })
}
