//! Rebounds in a step of a crowd: rounds of Newton's law among the contacts and limits that approach, before (B) holds what is closed.
//!
//! ```text
//!     round:   M̃ (v_N − v) = Hᵀ r,   K_μ ∋ r ⊥ u + μ|u_T| n ∈ K_μ*,   u = H v_N + e min(0, H_N v) n       if H_N v < −2 h |g · n|
//!     v ← v_C + σ (v_N − v_C),   v_C: the same with e = 0,   σ the largest in [0, 1] that gains no energy
//! ```
//!
//! v are the rates in the middle of the step without impulses, H and M̃ those at its end, e restitutions, g gravity, h the length of the step. Contacts that were closed before take part
//! once others make them approach: a ball that strikes a row of balls in touch sends off the last one, as in `instant/cone/impact.rs`, of which this is the
//! law. (B) ends what is left after the last round, without rebounds.

use crate::crowd::islands::{Island, islands};
use crate::crowd::newton::Workspace;
use crate::crowd::problem::{Given, Problem};
use crate::crowd::solver::{TOLERANCE, solve};
use crate::crowd::trees::Trees;
use crate::events::crowd::contacts::{Candidate, Contacts, Key, Scene};
use crate::instant::cone::impact::share_without_gain;
use nalgebra::Vector3;

/// The most rounds of a step.
const ROUNDS: usize = 100;
/// A round whose law is solved less well is plastic: contacts that pinch a body cannot all rebound.
const SOLVED: f64 = 1e-4;
/// Normals across the gravity count as if this part of it were along them.
const ACROSS: f64 = 0.05;
/// A gain of this part of the energies that are exchanged is rounding.
const ROUNDING: f64 = 1e-12;

/// The contacts of a step at its end.
pub(super) struct Rebounding<'r> {
    pub scene: Scene<'r>,
    pub trees: &'r Trees,
    pub contacts: &'r Contacts,
    /// h (s).
    pub step: f64,
    /// What gravity adds to the velocities in two steps, `2 h g` [m/s].
    pub fall: Vector3<f64>,
}

impl Rebounding<'_> {
    /// An approach below this has no rebound [m/s]: gravity along the normal makes it in a step. Bodies that roll into each other on a floor part again.
    fn slowest(&self, number: usize) -> f64 {
        let (candidate, fall) = (&self.contacts.list[number], self.fall.norm());
        match candidate.key {
            Key::Touch(..) => candidate.frame[0].dot(&self.fall).abs().max(ACROSS * fall),
            _ => fall,
        }
    }

    /// Whether a candidate has closed in this step so fast that it rebounds.
    pub fn rebounds(&self, number: usize, velocity: &[f64]) -> bool {
        let candidate = &self.contacts.list[number];
        let closes = candidate.closes() && !candidate.was_closed && candidate.restitution > 0.0;
        closes && self.contacts.closing_rate(number, self.trees, velocity) < -self.slowest(number)
    }

    /// Makes the rounds among candidates of whole islands: changes the rates of their freedoms, and adds the impulses of all. Returns how many have met,
    /// the largest residual, and how many rounds of a group were not solved.
    pub fn rounds(
        &self,
        candidates: impl Iterator<Item = usize>,
        velocity: &mut [f64],
        impulses: &mut [Vector3<f64>],
        room: &mut Workspace,
    ) -> (usize, f64, usize) {
        let (mut met, mut residual, mut unsolved) = (0, 0.0_f64, 0);
        let mut places = vec![0; self.trees.trees.len()];
        let closing = candidates.filter(|&number| self.contacts.list[number].closes());
        let closing: Vec<(usize, f64)> =
            closing.map(|number| (number, self.contacts.closing_rate(number, self.trees, velocity))).collect();
        for round in 0..ROUNDS {
            let approaches = |&&(number, first): &&(usize, f64)| {
                let rate = self.contacts.closing_rate(number, self.trees, velocity);
                let slowest = self.slowest(number);
                rate < -slowest && (!self.contacts.list[number].was_closed || rate < first - slowest)
            };
            let part: Vec<usize> = closing.iter().filter(approaches).map(|&(number, _)| number).collect();
            if part.is_empty() {
                break;
            }
            met += if round == 0 { part.len() } else { 0 };
            let sides = part.iter().map(|&number| (number, self.contacts.list[number].sides));
            for own in islands(self.trees.trees.len(), sides) {
                let left = self.round(&own, &mut places, velocity, impulses, room);
                residual = residual.max(left);
                unsolved += usize::from(left > TOLERANCE);
            }
        }
        (met, residual, unsolved)
    }

    /// One round among the candidates of a group, whose trees get their places there; returns its residual.
    fn round(
        &self,
        group: &Island,
        places: &mut [usize],
        velocity: &mut [f64],
        impulses: &mut [Vector3<f64>],
        room: &mut Workspace,
    ) -> f64 {
        group.trees.iter().enumerate().for_each(|(place, &tree)| places[tree] = place);
        let list = &self.contacts.list;
        let given = |&number: &usize| {
            let Candidate { sides, belt, .. } = list[number];
            let law = list[number].law(self.scene.elements, self.step);
            Given { sides, law, bias: Vector3::new(0.0, belt.y, belt.z), compliance: 0.0 }
        };
        let blocks = group.candidates.iter().map(given);
        let mut problem = Problem::new(self.trees, &self.contacts.rows, [&group.trees, places], velocity, blocks);
        let before = problem.free.clone();
        let mut rebounds = Vec::with_capacity(group.candidates.len());
        for (place, &number) in group.candidates.iter().enumerate() {
            let approach = problem.moved(place, &before).x;
            let block = &mut problem.blocks[place];
            block.bias.x = list[number].restitution * approach;
            rebounds.push(Vector3::x() * (-(1.0 + list[number].restitution) * approach * block.rho));
        }
        problem.set_scale();
        let mut after = Vec::new();
        let mut residual = solve(&mut problem, &mut rebounds, &mut after, (TOLERANCE, true), room);
        let (gain, size) = gained(&problem, &before, &after);
        if residual > SOLVED || gain > ROUNDING * size {
            problem.blocks.iter_mut().for_each(|block| block.bias.x = 0.0);
            problem.set_scale();
            let (mut plastic, mut slower) = (rebounds.clone(), Vec::new());
            let of_plastic = solve(&mut problem, &mut plastic, &mut slower, (TOLERANCE, true), room);
            let share = if residual > SOLVED { 0.0 } else { largest_share(&problem, [&before, &slower, &after]) };
            residual = if residual > SOLVED { of_plastic } else { residual.max(of_plastic) };
            for (impulse, plastic) in rebounds.iter_mut().zip(&plastic) {
                *impulse = plastic + (*impulse - plastic) * share;
            }
            for (rate, slower) in after.iter_mut().zip(&slower) {
                *rate = slower + (*rate - slower) * share;
            }
        }
        self.trees.spread(&group.trees, &after, velocity);
        group.candidates.iter().zip(rebounds).for_each(|(&number, impulse)| impulses[number] += impulse);
        residual
    }
}

/// The kinetic energy gained between two rates of the trees of a problem, and the size of its terms (J).
fn gained(problem: &Problem, before: &[f64], after: &[f64]) -> (f64, f64) {
    let change: Vec<f64> = after.iter().zip(before).map(|(after, before)| after - before).collect();
    let mut momenta = vec![0.0; change.len()];
    problem.multiply_inertia(&change, &mut momenta);
    let term = |(momentum, (before, after)): (&f64, (&f64, &f64))| 0.5 * momentum * (before + after);
    let terms = momenta.iter().zip(before.iter().zip(after)).map(term);
    terms.fold((0.0, 0.0), |(sum, size): (f64, f64), term| (sum + term, size + term.abs()))
}

/// σ: the largest part of the way from the plastic rates to those with rebounds that gains no energy on the rates before.
fn largest_share(problem: &Problem, [before, plastic, after]: [&[f64]; 3]) -> f64 {
    let (constant, _) = gained(problem, before, plastic);
    let change: Vec<f64> = after.iter().zip(plastic).map(|(after, plastic)| after - plastic).collect();
    let mut momenta = vec![0.0; change.len()];
    problem.multiply_inertia(&change, &mut momenta);
    let dot = |other: &[f64]| momenta.iter().zip(other).map(|(one, other)| one * other).sum::<f64>();
    let (linear, square) = (dot(plastic), dot(&change));
    let share = share_without_gain(constant, linear, square);
    // Rebounds that change no rate have no share.
    if share.is_nan() { 0.0 } else { share }
}
