//! Trees at rest: a group of trees that press on each other takes part in no step while nothing reaches it.
//!
//! ```text
//!     a group:        trees that a contact joins whose gap is at most 1 µm, or that presses in the step
//!     falls asleep:   |v| + k |ω| ≤ 1e-6 g h  of all bodies of the group [m/s], in three steps, or at the ends of fifty;      k = (tr J/2m)^½ (m)
//!                     |Δx| + k |ΔR|/√2 ≤ 1e-6 g h²  in fifty steps;
//!                     a(q, 0) = a of the last step to 1e-6 g
//!     wakes:          a(q, 0) at the start or the middle of a step is another in any digit,  or a contact with a tree that is awake exerts an impulse
//! ```
//!
//! Rates within a step belong to its displacement (A). Where a corner lies on the border of a face, the nearest features may change in each step, and (A) closes gaps of
//! some nm that they open again, beside the mechanics: rates that are zero at the ends of many steps are at rest. The rates (B) may know other features than (A),
//! and turn a body that (A) holds in its place: a body that stays in its place is at rest, too.
//!
//! `a` are the accelerations without contacts [m/s² or rad/s²], under all forces, efforts and motors. Trees that are awake meet sleeping ones as parts of the
//! world. A step in which one of these contacts exerts an impulse is made again with the group awake. The others are the same as if the group were awake:
//! contacts without impulses change nothing.
//!
//! Source: M. Anitescu, F. A. Potra (1997) for the problem of a step; sleeping groups are common in engines of games, where they wake by distance.

use crate::crowd::islands::groups;
use crate::crowd::trees::Trees;
use crate::events::crowd::asleep::Asleep;
use crate::events::crowd::contacts::{Candidate, Contacts};
use crate::instant::moved::Moved;
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::mechanism::{Body, Mechanism};
use crate::mechanism::motion::state::State;
use nalgebra::Vector3;

/// Writes the accelerations in a state.
pub(super) type AtRest<'a> = &'a mut dyn FnMut(&State, &mut [f64]);

/// Steps in a row in which all is slower than a part of the speed of a fall in one, at whose ends it is, and between whose ends it moves no faster.
const STILL: [usize; 3] = [3, 50, 50];
/// That part.
const RESTS: f64 = 1e-6;
/// Loads that differ by less than this part of gravity have not changed.
const STEADY: f64 = 1e-6;
/// Contacts with gaps up to this join trees (m).
const JOINS: f64 = 1e-6;

/// The radius of gyration of a body (m): `½ m k² |ω|²` is about the energy of its turning. A body without mass has one of 1 m.
fn gyration(body: &Body) -> f64 {
    if body.mass > 0.0 { (0.5 * body.inertia.sum() / body.mass).sqrt() } else { 1.0 }
}

/// What is known of the trees at rest.
#[derive(Clone, Default)]
pub(crate) struct Resting {
    /// Steps in a row in which a tree has hardly moved, at whose ends it hardly moves, and between whose ends it has hardly moved.
    still: Vec<[usize; 3]>,
    /// The trees that sleep.
    pub asleep: Asleep,
    /// The freedoms of each tree.
    freedoms: Vec<Vec<usize>>,
    /// Trees with motors whose targets change.
    restless: Vec<bool>,
    /// a of the freedoms of trees that sleep.
    steady: Vec<f64>,
    /// The contacts and joints of sleeping trees, each with the length of the step that told its impulses (s).
    candidates: Vec<(Candidate, f64)>,
    count: usize,
}

impl Resting {
    /// For these trees, of which some have motors whose targets change.
    pub fn new(trees: &Trees, freedoms: usize, restless: Vec<bool>) -> Self {
        let count = trees.trees.len();
        Resting {
            still: vec![[0; 3]; count],
            asleep: Asleep::new(trees),
            freedoms: trees.trees.iter().map(|tree| tree.all.clone()).collect(),
            restless,
            steady: vec![0.0; freedoms],
            candidates: Vec::new(),
            count: 0,
        }
    }

    /// From now on no tree falls asleep.
    pub fn keep_awake(&mut self) {
        self.restless.fill(true);
    }

    /// Whether all trees sleep.
    pub fn is_all(&self) -> bool {
        self.count > 0 && self.count == self.asleep.group.len()
    }

    /// The part of the bodies that sleep.
    pub fn part(&self) -> f64 {
        let asleep = self.asleep.of_body.iter().filter(|&&tree| self.asleep.has(tree)).count();
        asleep as f64 / self.asleep.of_body.len().max(1) as f64
    }

    /// The candidates of sleeping trees, each with the length of the step that told its impulses (s).
    pub fn candidates(&self) -> &[(Candidate, f64)] {
        &self.candidates
    }

    /// Wakes all; their contacts are forgotten.
    pub fn wake_all(&mut self) {
        self.still.fill([0; 3]);
        self.asleep.group.fill(None);
        self.candidates.clear();
        self.count = 0;
    }

    /// Wakes the groups of these trees, and gives their candidates to a list, with impulses for steps that are as long as this (s).
    pub fn wake(&mut self, trees: &[usize], list: &mut Vec<Candidate>, step: f64) {
        let mut woken: Vec<usize> = trees.iter().filter_map(|&tree| self.asleep.group[tree]).collect();
        woken.sort_unstable();
        woken.dedup();
        for tree in 0..self.asleep.group.len() {
            if self.asleep.group[tree].is_some_and(|group| woken.binary_search(&group).is_ok()) {
                (self.asleep.group[tree], self.still[tree]) = (None, [0; 3]);
                self.count -= 1;
            }
        }
        let mut asleep = std::mem::take(&mut self.candidates);
        asleep.retain(|(candidate, of)| {
            let stays = self.keeps(candidate);
            if !stays {
                let mut candidate = candidate.clone();
                candidate.moving *= step / of;
                candidate.settling *= step / of;
                list.push(candidate);
            }
            stays
        });
        self.candidates = asleep;
    }

    /// Whether all trees of a candidate sleep.
    fn keeps(&self, candidate: &Candidate) -> bool {
        candidate.ends.into_iter().all(|body| self.asleep.holds(body))
    }

    /// Whether a tree has rested for long enough to fall asleep with its group.
    fn rests(&self, tree: usize) -> bool {
        self.still[tree].iter().zip(STILL).any(|(steps, enough)| *steps >= enough)
    }

    /// The sleeping trees whose accelerations have changed since they fell asleep.
    pub fn loaded(&self, accelerations: &[f64]) -> Vec<usize> {
        if self.count == 0 {
            return Vec::new();
        }
        let changed = |freedom: &usize| accelerations[*freedom].to_bits() != self.steady[*freedom].to_bits();
        let of = |tree: usize| self.asleep.has(tree) && self.freedoms[tree].iter().any(changed);
        (0..self.asleep.group.len()).filter(|&tree| of(tree)).collect()
    }

    /// The sleeping trees of candidates with impulses.
    pub fn pushed<'c>(&self, list: &'c [Candidate], impulse: impl Fn(&'c Candidate) -> &'c Vector3<f64>) -> Vec<usize> {
        if self.count == 0 {
            return Vec::new();
        }
        let pushed = list.iter().filter(|candidate| *impulse(candidate) != Vector3::zeros());
        let trees = pushed.flat_map(|candidate| candidate.ends.into_iter().flatten());
        trees.map(|body| self.asleep.of_body[body]).filter(|&tree| self.asleep.has(tree)).collect()
    }

    /// Puts sleeping bodies where they are in a state.
    pub fn keep(&self, mechanism: &Mechanism, from: &State, to: &mut State) {
        if self.count == 0 {
            return;
        }
        for (_, body) in mechanism.bodies.iter().enumerate().filter(|(index, _)| self.asleep.holds(Some(*index))) {
            let places = body.joint.position_range();
            to.position[places.clone()].copy_from_slice(&from.position[places.clone()]);
            to.compensation[places.clone()].copy_from_slice(&from.compensation[places]);
        }
    }

    /// Sees the bodies at the start and at the end of a step, whose speeds in it were these [m/s, rad/s], its contacts from its start and those at its end,
    /// and the accelerations in it: lets trees fall asleep, whose rates are then zero. `accelerations_at_rest` works them out in a state. Returns whether
    /// there are any.
    pub fn settle(
        &mut self,
        mechanism: &Mechanism,
        [began, bodies]: [&[BodyState]; 2],
        speeds: &[(f64, f64)],
        (moving, contacts): (&Contacts, &mut Contacts),
        (state, step): (&mut State, f64),
        (accelerations, accelerations_at_rest): (&[f64], AtRest),
    ) -> bool {
        let gravity = mechanism.gravity.norm();
        let slow = RESTS * gravity * step;
        let mut moves = vec![[false; 3]; self.asleep.group.len()];
        for (body, tree) in self.asleep.of_body.iter().enumerate() {
            let arm = gyration(&mechanism.bodies[body]);
            let now = bodies[body].velocity.norm() + arm * bodies[body].angular_velocity.norm();
            let rests = |fastest: f64| fastest <= slow && now.is_finite();
            moves[*tree][0] |= !rests((speeds[body].0 + arm * speeds[body].1).max(now));
            moves[*tree][1] |= !rests(now);
            moves[*tree][2] |= !rests(Moved::between(&began[body], &bodies[body]).of_reach(arm) / step);
        }
        let awake: Vec<usize> = (0..moves.len()).filter(|&tree| !self.asleep.has(tree)).collect();
        for &tree in &awake {
            for (count, moves) in self.still[tree].iter_mut().zip(moves[tree]) {
                *count = if moves || self.restless[tree] { 0 } else { *count + 1 };
            }
        }
        if awake.iter().all(|&tree| !self.rests(tree)) {
            return false;
        }
        // Belts work on what rests on them.
        for candidate in contacts.list.iter().filter(|candidate| candidate.belt != Vector3::zeros()) {
            candidate.ends.into_iter().flatten().for_each(|body| self.still[self.asleep.of_body[body]] = [0; 3]);
        }
        // What bore a tree in this step may have left it at its end: a box that slides away under a lever.
        let bore = moving.list.iter().filter(|candidate| candidate.moving.x > 0.0);
        let joining = contacts.list.iter().filter(|candidate| candidate.gap <= JOINS || candidate.settling.x > 0.0);
        let joining = bore.chain(joining);
        let groups = groups(self.asleep.group.len(), joining.map(|candidate| candidate.sides));
        let all_still = |group: &Vec<usize>| group.iter().all(|&tree| !self.asleep.has(tree) && self.rests(tree));
        let groups: Vec<Vec<usize>> = groups.into_iter().filter(all_still).collect();
        if groups.is_empty() {
            return false;
        }
        let mut rest = state.clone();
        for freedom in groups.iter().flatten().flat_map(|&tree| &self.freedoms[tree]) {
            rest.velocity[*freedom] = 0.0;
        }
        let mut at_rest = vec![0.0; accelerations.len()];
        accelerations_at_rest(&rest, &mut at_rest);
        let mut any = false;
        for group in groups {
            let freedoms: Vec<usize> = group.iter().flat_map(|&tree| self.freedoms[tree].iter().copied()).collect();
            let same = |&freedom: &usize| (at_rest[freedom] - accelerations[freedom]).abs() <= STEADY * gravity;
            if !freedoms.iter().all(same) {
                continue;
            }
            any = true;
            for freedom in freedoms {
                (state.velocity[freedom], self.steady[freedom]) = (0.0, at_rest[freedom]);
            }
            group.iter().for_each(|&tree| self.asleep.group[tree] = Some(group[0]));
            self.count += group.len();
        }
        let mut asleep = Vec::new();
        contacts.list.retain(|candidate| {
            let goes = any && self.keeps(candidate);
            asleep.extend(goes.then(|| (candidate.clone(), step)));
            !goes
        });
        self.candidates.append(&mut asleep);
        any
    }
}
