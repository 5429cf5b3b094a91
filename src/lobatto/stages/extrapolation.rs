//! The polynomial through the past, as columns that stages are mixed by.
//!
//! In units of the old step, with the new start at 0, the old stages lie at `t_n = c_n − 1`, the newest first, the new ones at
//! `t = c_j h/h_old`. Newton's form of order κ through the past `y_n` with the value 0 and the velocity `v` at 0 is linear in both,
//!
//! ```text
//!     p_κ(t) = t h_old v + Σ_{m<κ} d_m N_m(t),      N_m(t) = t² Π_{k<m} (t − t_k)
//!     d_m    = Σ_{n≤m} w_mn (y_n − t_n h_old v),    w_mn   = t_n⁻² Π_{k≤m, k≠n} 1/(t_n − t_k)
//! ```
//!
//! (divided differences `d_m`), and the `w_mn` are constants of the scheme, so that a guess is one mix of lanes for each degree of freedom. Newton's
//! form holds all orders at once: an order less or more is a term less or more, so the vote knows the guesses of the neighbouring orders.

use crate::numbers::arithmetic::Numbers;
use crate::numbers::lanes::{Lanes, MAX_LANES};
use crate::numbers::reductions::at_end;
use crate::stages::unknowns::Unknowns;
use crate::tableau::butcher::Tableau;
use crate::tableau::dense::scales;

/// Largest number of degrees of freedom that vote on the order.
const VOTERS: usize = 48;

/// A polynomial in the past and the velocity of a degree of freedom, at the new stages.
#[derive(Clone, Copy)]
struct Columns<V> {
    /// Weight of each past displacement, lane by lane.
    past: [V; MAX_LANES],
    /// Weight of `h_old v`.
    rate: V,
}

impl<V: Lanes> Columns<V> {
    /// The polynomial for a past and `h_old v`.
    #[inline(always)]
    fn of(&self, past: V, advance: f64) -> V {
        let [mixed] = Numbers::mix_all([past], &self.past);
        self.rate.mul_add(V::splat(advance), mixed)
    }
}

/// The past, and the guesses that it allows.
#[derive(Clone)]
pub struct Extrapolation<V> {
    /// Displacements from the new start, one entry a degree of freedom: stage 1 in the last lane in use, the stages 2 … s − 1 in the others.
    pub(crate) past: Vec<V>,
    /// `t_n`, newest first.
    nodes: Vec<f64>,
    /// `w_mn` in the lane of n, one entry for each m.
    shares: Vec<V>,
    /// `Σ_n w_mn t_n`.
    rate_shares: Vec<f64>,
    /// `N_m` of the last guess, the one after its last term included.
    basis: [V; MAX_LANES],
    /// The last guess without its last term.
    before: Columns<V>,
    /// Length of the step the past comes from, zero without a past.
    old_step: f64,
    /// The order in use.
    order: usize,
    /// The order the last guess was made with; zero for one that was not made from the past.
    used: usize,
}

impl<V: Lanes> Extrapolation<V> {
    /// Memory for a number of degrees of freedom.
    pub fn new(freedoms: usize, tableau: &Tableau) -> Self {
        let nodes: Vec<f64> = tableau.nodes[..tableau.stages - 1].iter().rev().map(|node| node - 1.0).collect();
        let count = nodes.len();
        let (mut shares, mut rate_shares) = (Vec::new(), Vec::new());
        for m in 0..count {
            let mut row = vec![0.0; count];
            let mut rate_share = 0.0;
            for (n, others) in scales(&nodes[..=m]).into_iter().enumerate() {
                let share = 1.0 / (nodes[n] * nodes[n] * others);
                row[lane_of(n, count)] = share;
                rate_share += share * nodes[n];
            }
            shares.push(V::from_slice(&row));
            rate_shares.push(rate_share);
        }
        Extrapolation {
            past: vec![V::zero(); freedoms],
            order: first_order(count),
            nodes,
            shares,
            rate_shares,
            basis: [V::zero(); MAX_LANES],
            before: Columns { past: [V::zero(); MAX_LANES], rate: V::zero() },
            old_step: 0.0,
            used: 0,
        }
    }

    /// Forgets the past: the next step starts from something else.
    pub fn forget(&mut self) {
        self.old_step = 0.0;
        self.order = first_order(self.nodes.len());
    }

    /// Whether there is a past.
    pub fn has_past(&self) -> bool {
        self.old_step > 0.0
    }

    /// The guess of the present step is made from something else.
    pub fn leave(&mut self) {
        self.used = 0;
    }

    /// Writes the guess into the displacements.
    #[inline(always)]
    pub fn guess(&mut self, unknowns: Unknowns<V>) {
        let Unknowns { displacement, rates, step, coefficients } = unknowns;
        let count = self.nodes.len();
        let t = coefficients.nodes * V::splat(step / self.old_step);
        let mut columns = Columns { past: [V::zero(); MAX_LANES], rate: t };
        self.used = self.order;
        self.basis[0] = t * t;
        for m in 0..self.used {
            if m + 1 == self.used {
                self.before = columns;
            }
            let basis = self.basis[m];
            let shares = self.shares[m].to_array();
            for n in 0..=m {
                let lane = lane_of(n, count);
                columns.past[lane] = basis.mul_add(V::splat(shares.as_ref()[lane]), columns.past[lane]);
            }
            columns.rate = basis.neg_mul_add(V::splat(self.rate_shares[m]), columns.rate);
            if m + 1 < count {
                self.basis[m + 1] = basis * (t - V::splat(self.nodes[m]));
            }
        }
        for ((displacement, &past), &rate) in displacement.iter_mut().zip(&self.past).zip(rates) {
            *displacement = columns.of(past, self.old_step * rate);
        }
    }

    /// Learns from the converged step: picks the order that would have guessed best, keeps the displacements.
    #[inline(always)]
    pub fn learn(&mut self, unknowns: &Unknowns<V>) {
        if self.used > 0 {
            self.vote(unknowns);
        }
        let (moved, active) = (unknowns.coefficients.moved, unknowns.coefficients.active);
        for (past, &displacement) in self.past.iter_mut().zip(unknowns.displacement.iter()) {
            *past = displacement * moved - V::splat(at_end(displacement, active));
        }
        self.old_step = unknowns.step;
    }

    #[inline(always)]
    fn vote(&mut self, unknowns: &Unknowns<V>) {
        let (used, count) = (self.used, self.nodes.len());
        // An order less, the same order, and one more.
        let mut worst = [V::zero(); 3];
        let freedoms = unknowns.displacement.len();
        let stride = freedoms.div_ceil(VOTERS).max(1);
        let mut freedom = 0;
        while freedom < freedoms {
            let past = self.past[freedom];
            let advance = self.old_step * unknowns.rates[freedom];
            let mut missing = unknowns.displacement[freedom] - self.before.of(past, advance);
            worst[0] = missing.max_abs(worst[0]);
            for m in used - 1..(used + 1).min(count) {
                let difference = (past * self.shares[m]).sum() - self.rate_shares[m] * advance;
                missing = self.basis[m].neg_mul_add(V::splat(difference), missing);
                worst[m + 2 - used] = missing.max_abs(worst[m + 2 - used]);
            }
            freedom += stride;
        }
        let mut best = (f64::INFINITY, used);
        for order in (used - 1).max(1)..=(used + 1).min(count) {
            let error = worst[order + 1 - used].largest();
            if error < best.0 {
                best = (error, order);
            }
        }
        self.order = best.1;
    }
}

/// The lane of the n-th newest of `count` old stages: stage s − 1 − n has lane s − 3 − n, but stage 1 the last in use.
fn lane_of(n: usize, count: usize) -> usize {
    if n + 1 == count { n } else { count - 2 - n }
}

/// The order of the first guess from a past of this number of stages.
fn first_order(count: usize) -> usize {
    count.min(2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stages::coefficients::Coefficients;
    use crate::vectors::portable::Portable;

    type Vector = Portable<16>;

    /// Newton's form word for word: through the `order` newest of the old stages, at `x` old steps from the new start.
    fn newton(nodes: &[f64], past: &[f64], advance: f64, order: usize, x: f64) -> f64 {
        let mut differences: Vec<f64> =
            nodes[..order].iter().zip(past).map(|(t, y)| (y - t * advance) / (t * t)).collect();
        for level in 1..order {
            for n in (level..order).rev() {
                differences[n] = (differences[n] - differences[n - 1]) / (nodes[n] - nodes[n - level]);
            }
        }
        let (mut sum, mut product) = (x * advance, x * x);
        for (difference, node) in differences.iter().zip(nodes) {
            sum += difference * product;
            product *= x - node;
        }
        sum
    }

    /// A motion since some start (rad), of which no polynomial is the whole.
    fn turned(freedom: usize, time: f64) -> f64 {
        let pace = 1.0 + 0.3 * freedom as f64;
        (pace * time).sin() + 0.2 * (time * time) * pace
    }

    const FREEDOMS: usize = 6;
    const OLD_STEP: f64 = 0.4;

    /// The memory after a step of the motion, and the rates at its end.
    fn learned(tableau: &Tableau) -> (Extrapolation<Vector>, [f64; FREEDOMS]) {
        let coefficients = Coefficients::new(tableau);
        let mut displacement: Vec<Vector> = (0..FREEDOMS)
            .map(|freedom| {
                let since = |node: &f64| turned(freedom, OLD_STEP * node) - turned(freedom, 0.0);
                Portable::from_slice(&tableau.nodes[1..].iter().map(since).collect::<Vec<f64>>())
            })
            .collect();
        let mut extrapolation = Extrapolation::new(FREEDOMS, tableau);
        let rates = [0.0; FREEDOMS];
        let unknowns =
            Unknowns { displacement: &mut displacement, rates: &rates, step: OLD_STEP, coefficients: &coefficients };
        extrapolation.learn(&unknowns);
        let rate = |freedom: usize| {
            let pace = 1.0 + 0.3 * freedom as f64;
            pace * (pace * OLD_STEP).cos() + 0.4 * OLD_STEP * pace
        };
        (extrapolation, std::array::from_fn(rate))
    }

    #[test]
    fn the_guess_is_the_polynomial_of_the_order_in_use_and_the_vote_is_for_the_one_that_guessed_best() {
        for stages in [2, 3, 5, 9, 12] {
            let tableau = Tableau::of(stages).expect("stages");
            let coefficients = Coefficients::new(tableau);
            let count = stages - 1;
            for (order, step) in (1..=count).zip([0.3, 0.4, 0.5, 0.45].into_iter().cycle()) {
                let (mut extrapolation, rates) = learned(tableau);
                extrapolation.order = order;
                let mut displacement = vec![<Vector as Lanes>::zero(); FREEDOMS];
                let unknowns =
                    Unknowns { displacement: &mut displacement, rates: &rates, step, coefficients: &coefficients };
                extrapolation.guess(unknowns);

                let nodes: Vec<f64> = (0..count).map(|n| tableau.nodes[count - 1 - n] - 1.0).collect();
                let literal = |freedom: usize, order: usize, node: f64| {
                    let past: Vec<f64> = nodes
                        .iter()
                        .map(|t| turned(freedom, OLD_STEP * (1.0 + t)) - turned(freedom, OLD_STEP))
                        .collect();
                    newton(&nodes, &past, OLD_STEP * rates[freedom], order, node * step / OLD_STEP)
                };
                for (freedom, guess) in displacement.iter().enumerate() {
                    for (lane, &node) in tableau.nodes[1..].iter().enumerate() {
                        let (got, wanted) = (guess.to_array()[lane], literal(freedom, order, node));
                        // Roundings of the past, 1e-16, times their magnification by an extrapolation over `order` nodes.
                        let bound = 1e-14 * 6_f64.powi(order as i32);
                        assert!((got - wanted).abs() < bound, "{stages} stages, order {order}: {got} and {wanted}");
                    }
                }

                // The step as it was: the vote is for the nearest guess.
                let true_turn =
                    |freedom: usize, node: f64| turned(freedom, OLD_STEP + step * node) - turned(freedom, OLD_STEP);
                for (freedom, displacement) in displacement.iter_mut().enumerate() {
                    let turns: Vec<f64> = tableau.nodes[1..].iter().map(|&node| true_turn(freedom, node)).collect();
                    *displacement = Portable::from_slice(&turns);
                }
                let worst = |order: usize| {
                    let off = |freedom: usize, node: f64| literal(freedom, order, node) - true_turn(freedom, node);
                    let freedoms = (0..FREEDOMS)
                        .flat_map(|freedom| tableau.nodes[1..].iter().map(move |&node| off(freedom, node).abs()));
                    freedoms.fold(0.0, f64::max)
                };
                let candidates = order.saturating_sub(1).max(1)..=(order + 1).min(count);
                let best = candidates.min_by(|&a, &b| worst(a).total_cmp(&worst(b))).expect("one at least");
                let unknowns =
                    Unknowns { displacement: &mut displacement, rates: &rates, step, coefficients: &coefficients };
                extrapolation.learn(&unknowns);
                // Rounding may decide between two that are as good.
                let voted = worst(extrapolation.order);
                assert!(voted <= worst(best) * (1.0 + 1e-6) + 1e-12, "{stages} stages, order {order}: {voted:e}");
            }
        }
    }
}
