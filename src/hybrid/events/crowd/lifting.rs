//! Shapes that still overlap at the end of a step are moved apart by the least motion.
//!
//! ```text
//!     min ½ |δ|²_M     φ + H_N δ ≥ 0         for all contacts and limits with a gap φ below 1e-6 (m or rad),     q ← q ⊕ δ
//! ```
//!
//! It is a jump of position beside the mechanics. The report tells the largest one, and the energy that it adds is taken from the motion.

use crate::crowd::islands::islands;
use crate::crowd::laws::Law;
use crate::crowd::problem::{Given, Problem};
use crate::crowd::solver::solve;
use crate::events::crowd::contacts::{Candidate, Scene};
use crate::events::crowd::step::Crowd;
use crate::mechanism::motion::kinematics::place_bodies;
use crate::mechanism::motion::state::State;
use nalgebra::Vector3;

/// Overlaps up to this stay (m or rad).
const OVERLAP: f64 = 3e-10;
/// Contacts with gaps up to this take part.
const NEAR: f64 = 1e-6;
const ROUNDS: usize = 6;
/// The residual of their problem: it is repeated in rounds, and only gaps count.
const SOLVED: f64 = 1e-6;

impl Crowd {
    /// Lifts a state whose candidates are at the end of the step; returns the largest overlap before, and what is left (m or rad).
    pub(super) fn lift(&mut self, scene: Scene, state: &mut State, step: f64) -> Option<(f64, f64)> {
        let first = self.next.deepest();
        let mut left = first;
        for _ in 0..ROUNDS {
            if left <= OVERLAP {
                break;
            }
            let Crowd { trees, next, room, .. } = self;
            let nothing = vec![0.0; state.velocity.len()];
            for tree in &mut trees.trees {
                if !tree.factor(0.0, &nothing, &nothing) {
                    return None;
                }
            }
            let mut places = vec![0; trees.trees.len()];
            let mut moved = nothing.clone();
            let near = |candidate: &Candidate| candidate.closes() && candidate.gap <= NEAR;
            for island in islands(trees.trees.len(), next.sides(near)) {
                if island.candidates.iter().all(|&number| next.list[number].gap >= -OVERLAP) {
                    continue;
                }
                island.trees.iter().enumerate().for_each(|(place, &tree)| places[tree] = place);
                let law = Law::Interval(0.0, f64::INFINITY);
                let block = |&number: &usize| {
                    let Candidate { sides, gap, .. } = next.list[number];
                    Given { sides, law, bias: Vector3::new(gap, 0.0, 0.0), compliance: 0.0 }
                };
                let blocks = island.candidates.iter().map(block);
                let mut problem = Problem::new(trees, &next.rows, [&island.trees, &places], &nothing, blocks);
                let mut impulses = vec![Vector3::zeros(); island.candidates.len()];
                let mut v = Vec::new();
                solve(&mut problem, &mut impulses, &mut v, (SOLVED, true), room);
                trees.spread(&island.trees, &v, &mut moved);
            }
            let before = state.clone();
            state.displace(scene.whole, &moved);
            self.resting.keep(scene.whole, &before, state);
            place_bodies(scene.whole, state, &mut self.bodies);
            if !self.trees.close(scene.whole, state, &mut self.bodies) {
                return None;
            }
            self.find_next(scene, state, step);
            self.trees.place(scene.whole, &self.bodies);
            self.next.fill_rows(scene, &self.resting.asleep, &self.trees, &self.bodies, 0);
            left = self.next.deepest();
        }
        Some((if first > OVERLAP { first } else { 0.0 }, left))
    }
}
