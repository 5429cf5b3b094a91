//! The reserves of pairs: lower bounds of their gaps, by the looks at steps before.
//!
//! ```text
//!     φ(t) ≥ r(t) = S − D_a(t) − D_b(t),    S = φ(t₁) + D_a(t₁) + D_b(t₁)      t₁: when the gap was looked at last
//!     a queue in the order of M(t₁) + r(t₁): a step asks only those pairs that M has reached since then
//!     a pair that was asked has r(t₀) − V h at the end of the step, or is looked at
//! ```
//!
//! D and M (m) are the travel of bodies and the most that any gap can have fallen by ([`crate::events::finding::travel`]); V is the bound of the
//! speed of the pair in the step [m/s], h its length (s). A pair whose reserve lasts to the end of a step cannot close in it, and is not looked at.
//! Bodies that stand beside each other are asked seldom, however short the steps are and however many pairs there are: a step takes a time in
//! proportion to the bodies. Reserves last until a mode ends. Bodies that the next mode does not touch keep theirs.
//!
//! Source: B. Mirtich, Impulse-based Dynamic Simulation, PhD thesis, Berkeley 1996, chapter 2 (a heap of times before which no pair can collide).

use crate::events::finding::speeds::Speeds;
use crate::events::finding::travel::Travel;
use crate::events::modes::tolerances::AT_EVENT;
use crate::instant::holding::pairs::{Pair, Pairs};
use crate::instant::holding::per_pair::PerPair;
use crate::mechanism::description::mechanism::Mechanism;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// The sums of travel of a pair cancel to this part of them.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// The reserves of all pairs where the step in question begins, and where it ends.
#[derive(Clone, Debug, Default)]
pub(crate) struct Reserves {
    travel: Travel,
    pairs: PerPair<Reserve>,
    /// The first body of the robot of each body.
    roots: Vec<usize>,
    /// The bits of `M + r` and the number of each pair that is not to be asked; numbers above zero have the order of their bits.
    queue: BinaryHeap<Reverse<(u64, usize)>>,
    /// The pairs that the step asks, in the order of their numbers.
    asked: Vec<usize>,
    /// The reserves that are left of some of these at the end of the step (m).
    left: Vec<(usize, f64)>,
}

/// The reserve of one pair.
#[derive(Clone, Copy, Debug)]
struct Reserve {
    /// Its bodies among the travellers.
    bodies: [Option<usize>; 2],
    /// S (m); minus infinity if it is not known.
    spent_at: f64,
    /// A gap of at most this (m) may be closed.
    closed: f64,
}

impl Reserves {
    /// For the bodies of a mechanism, without pairs.
    pub fn new(mechanism: &Mechanism) -> Self {
        let mut roots: Vec<usize> = Vec::with_capacity(mechanism.bodies.len());
        for (index, body) in mechanism.bodies.iter().enumerate() {
            roots.push(body.parent.map_or(index, |parent| roots[parent]));
        }
        Reserves { roots, ..Reserves::default() }
    }

    /// Takes these pairs, whose numbers ascend, instead of those before; new ones are unknown.
    pub fn take(&mut self, near: &[usize], all: &Pairs) {
        if self.pairs.iter().map(|(pair, _)| pair).eq(near.iter().copied()) {
            return;
        }
        let Reserves { travel, pairs, roots, queue, asked, left } = self;
        let stays = |pair: usize| near.binary_search(&pair).is_ok();
        if pairs.iter().any(|(pair, _)| !stays(pair)) {
            pairs.retain(stays);
            queue.retain(|Reverse((_, pair))| stays(*pair));
            asked.retain(|&pair| stays(pair));
            left.retain(|&(pair, _)| stays(pair));
        }
        let new: Vec<usize> = near.iter().copied().filter(|&pair| pairs.get(pair).is_none()).collect();
        let made: Vec<Reserve> = new.iter().map(|&pair| Reserve::unknown(&all[pair], roots, travel)).collect();
        pairs.extend(&new, |pair| made[new.binary_search(&pair).unwrap_or_default()]);
        asked.extend(new);
        asked.sort_unstable();
    }

    /// Forgets the reserves of all pairs but those that are as they were: another mode begins, in which bodies may be quicker between the samples of
    /// steps than those before told.
    pub fn forget(&mut self, is_as_before: impl Fn(usize) -> bool) {
        let Reserves { pairs, queue, asked, left, .. } = self;
        let mut changed = Vec::new();
        for (pair, known) in pairs.iter_mut().filter(|(pair, _)| !is_as_before(*pair)) {
            known.spent_at = f64::NEG_INFINITY;
            changed.push(pair);
        }
        let stays = |pair: usize| changed.binary_search(&pair).is_err();
        queue.retain(|Reverse((_, pair))| stays(*pair));
        left.retain(|&(pair, _)| stays(pair));
        asked.retain(|&pair| stays(pair));
        asked.extend(changed);
        asked.sort_unstable();
    }

    /// A look at a step with these speeds and this length (s) begins. The same step may be looked at again with another end.
    pub fn begin(&mut self, speeds: &Speeds, length: f64) {
        if self.travel.counts(speeds.first()) {
            self.take_left();
            self.travel.move_to(speeds.first());
            self.put_back();
        }
        self.left.clear();
        self.travel.go_on(speeds, length);
        let [_, most] = self.travel.most();
        let asked = self.asked.len();
        while let Some(&Reverse((bits, pair))) = self.queue.peek()
            && (most.is_nan() || f64::from_bits(bits) <= most)
        {
            self.queue.pop();
            self.asked.push(pair);
        }
        if self.asked.len() > asked {
            self.asked.sort_unstable();
        }
    }

    /// The step before is done, with these reserves at its end.
    fn take_left(&mut self) {
        for &(pair, rest) in &self.left {
            let known = self.pairs.of(pair);
            let [sum, _] = self.travel.of(known.bodies);
            known.spent_at = rest + sum;
        }
    }

    /// Pairs that have a reserve go back to the queue.
    fn put_back(&mut self) {
        let Reserves { travel, pairs, queue, asked, .. } = self;
        let [most, _] = travel.most();
        asked.retain(|&pair| {
            let known = pairs.of(pair);
            let [rest, _] = known.left(travel);
            let last = most + (rest - known.closed);
            let waits = last > most && last.is_finite();
            if waits {
                queue.push(Reverse((last.to_bits(), pair)));
            }
            !waits
        });
    }

    /// The pairs that may close in the step, as far as the travel of all bodies tells.
    pub fn asked(&self) -> &[usize] {
        &self.asked
    }

    /// A lower bound of the gap of a pair at the end of the step (m), unless it was looked at.
    pub fn at_end(&self, pair: usize) -> f64 {
        self.pairs.get(pair).map_or(f64::NEG_INFINITY, |known| known.left(&self.travel)[1])
    }

    /// Whether an asked pair that closes by no more than `closes` (m) in the step keeps enough of its reserve; the rest of it (m), if it does.
    pub fn lasts(&mut self, pair: usize, closes: f64) -> Option<f64> {
        let known = self.pairs.of(pair);
        let [start, _] = known.left(&self.travel);
        let rest = start - closes;
        if rest > known.closed {
            self.note(pair, rest);
            return Some(rest);
        }
        None
    }

    /// Takes the gap of an asked pair at the end of the step (m).
    pub fn note(&mut self, pair: usize, gap: f64) {
        self.left.push((pair, gap));
    }
}

impl Default for Reserve {
    fn default() -> Self {
        Reserve { bodies: [None, None], spent_at: f64::NEG_INFINITY, closed: 0.0 }
    }
}

impl Reserve {
    /// Of a pair of which nothing is known.
    fn unknown(pair: &Pair, roots: &[usize], travel: &mut Travel) -> Self {
        let carrier = match pair.bodies {
            [Some(a), Some(b)] if roots[a] == roots[b] => Some(roots[a]),
            _ => None,
        };
        let bodies = [0, 1].map(|side| {
            let body = pair.bodies[side].filter(|body| Some(*body) != carrier)?;
            Some(travel.traveller(body, carrier, pair.reach[side]))
        });
        Reserve { bodies, spent_at: f64::NEG_INFINITY, closed: pair.within(AT_EVENT) }
    }

    /// r at the start and at the end of the step (m).
    fn left(&self, travel: &Travel) -> [f64; 2] {
        travel.of(self.bodies).map(|sum| self.spent_at - sum - ROUNDING * sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::events::finding::detection::SAMPLES;
    use crate::mechanism::description::body_state::{BodyState, WORLD};
    use nalgebra::Vector3;

    /// Pairs of two bodies and the world, with a reach of 0.1 m.
    fn reserves(pairs: &[[Option<usize>; 2]]) -> Reserves {
        let mut travel = Travel::default();
        let mut reserves = Reserves::default();
        for (number, bodies) in pairs.iter().enumerate() {
            let bodies = bodies.map(|body| body.map(|body| travel.traveller(body, None, 0.1)));
            *reserves.pairs.of(number) = Reserve { bodies, spent_at: f64::NEG_INFINITY, closed: 1e-12 };
        }
        Reserves { asked: (0..pairs.len()).collect(), travel, ..reserves }
    }

    /// The first body moves along x at 1 m/s, the second one rests at −1 m.
    fn step(reserves: &mut Reserves, from: f64, to: f64) {
        let mut speeds = Speeds::default();
        speeds.reset(2);
        let still = BodyState { position: -Vector3::x(), ..WORLD };
        for (sample, time) in [(0, from), (SAMPLES, to)] {
            let moves = BodyState { position: Vector3::x() * time, velocity: Vector3::x(), ..WORLD };
            speeds.take(sample, &[moves, still]);
        }
        reserves.begin(&speeds, to - from);
    }

    #[test]
    fn a_reserve_is_used_up_by_the_steps_that_are_made_and_not_by_repeated_looks_at_one() {
        let mut reserves = reserves(&[[Some(0), None], [Some(1), None]]);
        step(&mut reserves, 0.0, 0.1);
        assert_eq!(reserves.asked(), [0, 1]);
        assert_eq!(reserves.lasts(0, 0.0), None);
        reserves.note(0, 1.0);
        // The step is looked at five times with other ends: each time it has its reserve of the start, and asks the pair of which nothing is known.
        for end in [0.2, 0.18, 0.16, 0.14, 0.15] {
            step(&mut reserves, 0.1, end);
            assert_eq!(reserves.asked(), [1]);
            let rest = reserves.at_end(0);
            assert!((rest - (1.0 - 1.25 * (end - 0.1))).abs() < 1e-14, "{rest}");
            assert_eq!(reserves.lasts(1, 0.0), None);
        }
        // M falls by 2.5 m/s, so that the pair is asked soon after 0.1 + 0.4 s; its own travel leaves it a half then.
        for (from, to, asks) in [(0.15, 0.3, false), (0.3, 0.49, false), (0.49, 0.6, true)] {
            step(&mut reserves, from, to);
            assert_eq!(reserves.asked().contains(&0), asks, "{from}");
        }
        let rest = reserves.lasts(0, 0.11).expect("a reserve");
        assert!((rest - (1.0 - 1.25 * 0.39 - 0.11)).abs() < 1e-14, "{rest}");
        assert_eq!(reserves.lasts(0, 0.6), None);
    }

    #[test]
    fn pairs_that_are_as_they_were_keep_their_reserves_when_a_mode_begins() {
        let mut reserves = reserves(&[[Some(0), None], [Some(1), None], [Some(1), None]]);
        step(&mut reserves, 0.0, 1e-3);
        reserves.note(0, 1.0);
        reserves.note(1, 0.5);
        // Pair 1 keeps its reserve and its place in the queue. Pair 2 has no reserve yet and is still asked.
        reserves.forget(|pair| pair > 0);
        step(&mut reserves, 1e-3, 2e-3);
        assert_eq!(reserves.asked(), [0, 2]);
        reserves.note(0, 1.0);
        step(&mut reserves, 2e-3, 3e-3);
        assert_eq!(reserves.asked(), [2]);
        reserves.forget(|pair| pair > 0);
        assert_eq!(reserves.asked(), [0, 2]);
        assert!((reserves.at_end(1) - 0.5).abs() < 1e-14 && reserves.at_end(0) == f64::NEG_INFINITY);
    }

    #[test]
    fn a_pair_that_rests_is_not_asked_however_many_steps_are_made_while_another_one_moves() {
        let mut reserves = reserves(&[[Some(0), None], [Some(1), None]]);
        step(&mut reserves, 0.0, 1e-3);
        reserves.note(0, 1e-2);
        reserves.note(1, 1e-2);
        let mut asked = [0; 2];
        for count in 1..10_000 {
            let from = 1e-3 * f64::from(count);
            step(&mut reserves, from, from + 1e-3);
            for pair in reserves.asked().to_vec() {
                asked[pair] += 1;
                // It is looked at where its reserve is spent, and has moved to another place by then.
                if reserves.lasts(pair, if pair == 0 { 1.25e-3 } else { 0.0 }).is_none() {
                    reserves.note(pair, 1e-2);
                }
            }
        }
        // 10 s at 1.25 m/s use up 1 cm 1250 times, and are asked a few times for each; the other one is asked each time that M has fallen by 1 cm.
        assert!((1_250..7_500).contains(&asked[0]) && asked[1] <= 2_500, "{asked:?}");
        assert!((reserves.at_end(1) - 1e-2).abs() < 1e-14);
    }
}
