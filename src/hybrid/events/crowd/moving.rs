//! (A): the displacement of a step, after which no gap is negative.
//!
//! ```text
//!     M̃ (w − v_f) = Hᵀ r,     K_μ ∋ r ⊥ u + μ|u_T| n ∈ K_μ*,     u = H w + (φ/h + c) n + s,     q̄ = q ⊕ h w
//!     c ← (φ̄ − φ)/h − H_N w         until |φ̄| ≤ 3e-10 where r_N > 0, and φ̄ ≥ −3e-10 elsewhere
//! ```
//!
//! Rounds that do not bring the gaps nearer, as where a body would turn far in a step, end with the best round, by the product of what gaps and residual are
//! off; the overlap that is left is lifted. The coarse solution is no such round: it has no residual to speak of.
//!
//! H is at the start, and after each round at q̄: corners that close in the step are in the plane of the other shape there, so that they can stick
//! together, and at the start they are not. φ are gaps at the start, φ̄ the gaps of the same features at q̄ (m or rad). The curvature c makes the law
//! exact for positions. It is first taken from a coarse solution. The velocity s [m/s] is the velocity of belts along the tangents.

use crate::crowd::islands::{Island, islands};
use crate::crowd::newton::Workspace;
use crate::crowd::problem::{Given, Problem};
use crate::crowd::rows::Rows;
use crate::crowd::solver::{COARSE, TOLERANCE, solve};
use crate::crowd::trees::Trees;
use crate::events::crowd::contacts::{Contacts, Key, Scene};
use crate::events::crowd::resting::Resting;
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::motion::kinematics::place_bodies;
use crate::mechanism::motion::state::State;
use crate::mechanism::motion::touches::touch_motion;
use nalgebra::Vector3;
use std::cell::OnceCell;

/// A gap that counts as closed (m or rad), and the rounds for it.
const MEETS: f64 = 3e-10;
const ROUNDS: usize = 5;
/// Gaps that are off by more than this times the least so far end the rounds.
const DIVERGES: f64 = 1e3;
/// Gaps that are off by this at most need no more rounds with an island that is not solved (m or rad): what is left is lifted.
const NEARLY: f64 = 1e-6;

/// The start of a step.
pub(super) struct Moving<'m> {
    pub scene: Scene<'m>,
    pub start: &'m State,
    /// h (s).
    pub step: f64,
    /// v_f.
    pub free: &'m [f64],
    /// Trees that sleep.
    pub resting: &'m Resting,
}

/// How well all islands were solved.
#[derive(Clone, Copy, Default)]
pub(super) struct Solved {
    pub residual: f64,
    pub unsolved: usize,
    /// Whether loops do not close at its end.
    pub open: bool,
}

/// Writes the displacement w and the state at its end, which places the bodies; the candidates keep impulses and curvatures.
pub(super) fn move_on(
    trees: &Trees,
    now: &mut Contacts,
    moving: &Moving,
    (room, ahead): (&mut Workspace, &mut Option<Trees>),
    displacement: &mut [f64],
    end: &mut State,
    bodies: &mut [BodyState],
) -> Solved {
    let &Moving { scene, start, step, free, .. } = moving;
    let mut places = vec![0; trees.trees.len()];
    let found = islands(trees.trees.len(), now.sides(|_| true));
    displacement.copy_from_slice(free);
    let contacts = &*now;
    for island in &found {
        island.trees.iter().enumerate().for_each(|(place, &tree)| places[tree] = place);
    }
    struct Own<'p> {
        problem: Problem<'p>,
        impulses: Vec<Vector3<f64>>,
        curves: Vec<f64>,
        v: Vec<f64>,
        residual: f64,
        /// How far gaps are off in the best round (m), times its residual; its impulses, rates and residual.
        off: f64,
        miss: f64,
        best: (Vec<Vector3<f64>>, Vec<f64>, f64),
        open: bool,
        /// Whether a round was not solved: those after it are left to Newton's method alone.
        stuck: bool,
    }
    let at_end: [OnceCell<Rows>; ROUNDS] = std::array::from_fn(|_| OnceCell::new());
    let mut problems: Vec<(Own, &Island)> = found
        .iter()
        .map(|island| {
            let block = |&number: &usize| {
                let candidate = &contacts.list[number];
                let (bias, compliance) = match candidate.key {
                    Key::Motor(motor) => pull(scene, start, motor, 0.5 * step),
                    _ => (candidate.gap / step + candidate.curve, 0.0),
                };
                let law = candidate.law(scene.elements, 0.5 * step);
                Given {
                    sides: candidate.sides,
                    law,
                    bias: Vector3::new(bias, candidate.belt.y, candidate.belt.z),
                    compliance,
                }
            };
            let blocks = island.candidates.iter().map(block);
            let problem = Problem::new(trees, &contacts.rows, [&island.trees, &places], free, blocks);
            let of = |number: &usize| &contacts.list[*number];
            let own = Own {
                problem,
                impulses: island.candidates.iter().map(|number| of(number).moving).collect(),
                curves: island.candidates.iter().map(|number| of(number).curve).collect(),
                v: Vec::new(),
                residual: 0.0,
                off: f64::INFINITY,
                miss: f64::INFINITY,
                best: Default::default(),
                open: true,
                stuck: false,
            };
            (own, island)
        })
        .collect();
    // The choice of rates is that of the trees here.
    if trees.have_choices() {
        *ahead = None;
    }
    if problems.is_empty() {
        let open = !place_end(moving, displacement, end, bodies, (trees, ahead));
        return Solved { open, ..Solved::default() };
    }
    let mut closed = true;
    for round in 0..=ROUNDS {
        for (own, island) in &mut problems {
            if !own.open {
                continue;
            }
            let tolerance = if round == 0 { COARSE } else { TOLERANCE };
            own.residual = solve(&mut own.problem, &mut own.impulses, &mut own.v, (tolerance, !own.stuck), room);
            own.stuck |= own.residual > tolerance;
            trees.spread(&island.trees, &own.v, displacement);
        }
        closed = place_end(moving, displacement, end, bodies, (trees, ahead));
        let mut back = false;
        if round < ROUNDS {
            let ahead = ahead.get_or_insert_with(|| trees.clone());
            ahead.place_for_rows(scene.whole, bodies);
            let rows = at_end[round].get_or_init(|| contacts.rows_at(scene, ahead, bodies));
            let open = problems.iter_mut().filter(|(own, _)| own.open);
            open.for_each(|(own, _)| own.problem.rows = rows);
        }
        for (own, island) in &mut problems {
            if !own.open {
                continue;
            }
            let mut off = 0.0_f64;
            for (place, &number) in island.candidates.iter().enumerate() {
                let candidate = &contacts.list[number];
                let Some(contact) = &candidate.contact else { continue };
                let gap = touch_motion(&contact.joint, bodies).gap;
                let linear = candidate.gap + step * own.problem.moved(place, &own.v).x;
                own.curves[place] = (gap - linear) / step;
                off = off.max(if own.impulses[place].x > 0.0 { gap.abs() } else { -gap });
            }
            let coarse = round == 0 && own.residual > TOLERANCE;
            let meets = off <= if own.stuck { NEARLY } else { MEETS };
            own.open = round < ROUNDS && (coarse || !meets);
            let miss = off.max(MEETS) * own.residual.max(TOLERANCE);
            if coarse || miss <= own.miss {
                if !coarse {
                    (own.off, own.miss) = (off, miss);
                }
                if own.open {
                    own.best = (own.impulses.clone(), own.v.clone(), own.residual);
                }
            } else if off > DIVERGES * own.off || !own.open || off.is_nan() {
                // Back to the best round.
                (own.impulses, own.v, own.residual) = std::mem::take(&mut own.best);
                own.curves.fill(0.0);
                (own.open, back) = (false, true);
                trees.spread(&island.trees, &own.v, displacement);
            }
            if own.open {
                for (place, &number) in island.candidates.iter().enumerate() {
                    let candidate = &contacts.list[number];
                    if candidate.contact.is_some() {
                        own.problem.blocks[place].bias.x = candidate.gap / step + own.curves[place];
                    }
                }
                own.problem.set_scale();
            }
        }
        if back {
            closed = place_end(moving, displacement, end, bodies, (trees, ahead));
        }
        if problems.iter().all(|(own, _)| !own.open) {
            break;
        }
    }
    let mut solved = Solved { open: !closed, ..Solved::default() };
    let mut kept = Vec::new();
    for (own, island) in problems {
        solved.residual = solved.residual.max(own.residual);
        solved.unsolved += usize::from(own.residual > TOLERANCE);
        for (place, &number) in island.candidates.iter().enumerate() {
            kept.push((number, own.impulses[place], own.curves[place]));
        }
    }
    for (number, impulse, curve) in kept {
        (now.list[number].moving, now.list[number].curve) = (impulse, curve);
    }
    solved
}

/// The state after a displacement from the start of a step (s), with closed loops, and the bodies in it; returns whether all loops close.
fn place_end(
    moving: &Moving,
    displacement: &[f64],
    end: &mut State,
    bodies: &mut [BodyState],
    (trees, ahead): (&Trees, &mut Option<Trees>),
) -> bool {
    let &Moving { scene, start, step, resting, .. } = moving;
    end.copy_from(start);
    let moved: Vec<f64> = displacement.iter().map(|rate| step * rate).collect();
    end.displace(scene.whole, &moved);
    resting.keep(scene.whole, start, end);
    place_bodies(scene.whole, end, bodies);
    !trees.have_loops() || ahead.get_or_insert_with(|| trees.clone()).close(scene.whole, end, bodies)
}

/// Bias and compliance of a motor that acts for a time b (s) from a state: `p = b (kp (r − q − b w) + kd (ṙ − w))`.
pub(super) fn pull(scene: Scene, start: &State, motor: usize, time: f64) -> (f64, f64) {
    let motor = &scene.elements.motors[motor];
    let (stiffness, damping) = motor.law.gains();
    let at = motor.coordinate;
    let position = start.position[at.position] + start.compensation[at.position];
    let effort = motor.unbounded(start.time, start.time + time, position, 0.0);
    let per_rate = time * stiffness + damping;
    (-effort / per_rate, 1.0 / (time * per_rate))
}
