//! (B): the rates at the end of a step, with all contacts and limits that are closed there.
//!
//! ```text
//!     M̃ (v⁺ − v_f) = Hᵀ r,     K_μ ∋ r ⊥ u + μ|u_T| n ∈ K_μ*,     u = H v⁺ + s
//! ```
//!
//! H and M are at the end of the step, v at its start. Where a contact with restitution has closed in this step, rebounds come first
//! ([`crate::events::crowd::rebounding`]) and change v_f. There is no gap in it. Belts with the velocity s along the tangents do the work `−s · r`.

use crate::crowd::islands::{Island, islands};
use crate::crowd::laws::Law;
use crate::crowd::newton::Workspace;
use crate::crowd::problem::{Given, Problem};
use crate::crowd::solver::{TOLERANCE, solve};
use crate::crowd::trees::Trees;
use crate::events::crowd::contacts::{Candidate, Contacts, Key, Scene};
use crate::events::crowd::rebounding::Rebounding;
use crate::mechanism::motion::state::State;
use nalgebra::Vector3;

/// The impulses of an impact are guessed from (A), times this factor at most.
const FULL: f64 = 4.0;

/// The displacement and the free rates of a step.
pub(super) struct Settling<'s> {
    pub scene: Scene<'s>,
    pub start: &'s State,
    /// w.
    pub displacement: &'s [f64],
    /// h (s).
    pub step: f64,
    /// v_f.
    pub free: &'s [f64],
}

/// The result.
#[derive(Clone, Default)]
pub(super) struct Settled {
    pub residual: f64,
    pub unsolved: usize,
    /// Contacts and limits that have closed with an impact.
    pub closed: usize,
    /// Work of motors along the freedoms, and of belts at the first freedom of a tree, and what friction of joints and of contacts that stay closed took (J).
    pub work: Vec<f64>,
    pub friction: f64,
}

/// Writes the rates of all freedoms; the candidates at the end keep their impulses.
pub(super) fn settle(
    trees: &Trees,
    next: &mut Contacts,
    settling: &Settling,
    room: &mut Workspace,
    velocity: &mut [f64],
) -> Settled {
    let &Settling { scene, start, displacement, step, free } = settling;
    let mut settled = Settled { work: vec![0.0; velocity.len()], ..Settled::default() };
    velocity.copy_from_slice(free);
    let fall = 2.0 * step * scene.whole.gravity;
    let slow = fall.norm();
    let mut places = vec![0; trees.trees.len()];
    let mut kept = Vec::new();
    let contacts = &*next;
    let islands = islands(trees.trees.len(), contacts.sides(Candidate::settles));
    let rebounding = Rebounding { scene, trees, contacts, step, fall };
    let struck =
        |island: &&Island| island.candidates.iter().any(|&number| rebounding.rebounds(number, &start.velocity));
    let struck: Vec<usize> =
        islands.iter().filter(struck).flat_map(|island| island.candidates.iter().copied()).collect();
    let mut free = free.to_vec();
    let mut rebounds = vec![Vector3::zeros(); contacts.list.len()];
    if !struck.is_empty() {
        // An impact is in the middle of the step, on average.
        let middle: Vec<f64> = start.velocity.iter().zip(&free).map(|(begin, free)| 0.5 * (begin + free)).collect();
        let mut rates = middle.clone();
        (settled.closed, settled.residual, settled.unsolved) =
            rebounding.rounds(struck.into_iter(), &mut rates, &mut rebounds, room);
        free.iter_mut().zip(rates.iter().zip(&middle)).for_each(|(free, (after, before))| *free += after - before);
    }
    let (mut impulses, mut v, mut own) = (Vec::new(), Vec::new(), Vec::new());
    for island in &islands {
        island.trees.iter().enumerate().for_each(|(place, &tree)| places[tree] = place);
        let gather = |from: &[f64], own: &mut Vec<f64>| {
            own.clear();
            own.extend(island.trees.iter().flat_map(|&tree| &trees.trees[tree].freedoms).map(|&freedom| from[freedom]));
        };
        let block = |&number: &usize| {
            let candidate = &contacts.list[number];
            let law = candidate.law(scene.elements, step);
            let (law, bias, compliance) = match candidate.key {
                Key::Motor(motor) => brake(scene, settling, motor, law),
                _ => (law, 0.0, 0.0),
            };
            Given {
                sides: candidate.sides,
                law,
                bias: Vector3::new(bias, candidate.belt.y, candidate.belt.z),
                compliance,
            }
        };
        let blocks = island.candidates.iter().map(block);
        let mut problem = Problem::new(trees, &contacts.rows, [&island.trees, &places], &free, blocks);
        impulses.clear();
        impulses.extend(island.candidates.iter().map(|&number| contacts.list[number].settling));
        gather(&start.velocity, &mut own);
        for (place, &number) in island.candidates.iter().enumerate() {
            let candidate = &contacts.list[number];
            if !candidate.closes() || candidate.was_closed || rebounds[number] != Vector3::zeros() {
                continue;
            }
            let approach = problem.moved(place, &own).x;
            if approach < -slow {
                settled.closed += 1;
                // (A) has taken only a part of the approach from it.
                let taken = (approach + candidate.closing).min(approach / FULL);
                impulses[place] = candidate.moving * (approach / taken);
            }
        }
        let residual = solve(&mut problem, &mut impulses, &mut v, (TOLERANCE, true), room);
        settled.residual = settled.residual.max(residual);
        settled.unsolved += usize::from(residual > TOLERANCE);
        trees.spread(&island.trees, &v, velocity);
        gather(displacement, &mut own);
        for (place, (&number, impulse)) in island.candidates.iter().zip(&impulses).enumerate() {
            let (candidate, impulse) = (&contacts.list[number], impulse + rebounds[number]);
            if matches!(candidate.key, Key::Touch(..)) && candidate.was_closed {
                let slip = problem.moved(place, &own) + candidate.belt;
                settled.friction -= impulse.y * slip.y + impulse.z * slip.z;
            }
        }
        let sums =
            island.candidates.iter().zip(&impulses).map(|(&number, impulse)| (number, impulse + rebounds[number]));
        kept.extend(sums);
    }
    for candidate in &mut next.list {
        candidate.settling = Vector3::zeros();
    }
    for (number, impulse) in kept {
        next.list[number].settling = impulse;
        match next.list[number].key {
            Key::Motor(motor) => {
                let freedom = scene.elements.motors[motor].coordinate.freedom;
                settled.work[freedom] += impulse.x * displacement[freedom];
            }
            Key::Friction(joint) => {
                let freedom = scene.elements.joints[joint].coordinate.freedom;
                settled.friction -= impulse.x * displacement[freedom];
            }
            Key::Touch(..) if next.list[number].belt != Vector3::zeros() => {
                let tree = next.list[number].sides.iter().flatten().next().map(|side| &trees.trees[side.tree]);
                if let Some(&freedom) = tree.and_then(|tree| tree.freedoms.first()) {
                    settled.work[freedom] -= impulse.dot(&next.list[number].belt);
                }
            }
            Key::Touch(..) | Key::Limit(..) => {}
        }
    }
    settled
}

/// Law, bias and compliance of a motor with its stiffness at the middle and its damping at the end of the step: `p = h (kp (r − q̄) + kd (ṙ − v⁺))`.
fn brake(scene: Scene, settling: &Settling, motor: usize, law: Law) -> (Law, f64, f64) {
    let &Settling { start, displacement, step, .. } = settling;
    let motor = &scene.elements.motors[motor];
    let (_, damping) = motor.law.gains();
    let at = motor.coordinate;
    let position =
        start.position[at.position] + start.compensation[at.position] + 0.5 * step * displacement[at.freedom];
    let effort = motor.unbounded(start.time, start.time + 0.5 * step, position, 0.0);
    if damping > 0.0 {
        (law, -effort / damping, 1.0 / (step * damping))
    } else {
        let impulse = step * motor.bounded(effort);
        (Law::Interval(impulse, impulse), 0.0, 0.0)
    }
}
