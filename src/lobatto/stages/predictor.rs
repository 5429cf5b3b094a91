//! The first guess of a step: the last step's joint displacements, extrapolated.
//!
//! The guess is a polynomial in time from the new start at 0. It has the value 0 and the velocity `v` there and meets the κ newest of the old stages
//! (`extrapolation`). After the step has converged, the order κ that would have guessed best is read off and used next time. κ = 0 is the guess
//! `q₀ + h c v₀`, which needs no past.
//!
//! After an attempt `h_a > h` at the same step, which was too long, its own stages `θ_j` are the better guess, however far it was iterated:
//!
//! ```text
//!     p(x) = Σ_j ℓ_j(x h/h_a) θ_j,     ℓ_j(x) = Π_{k≠j} (x − c_k)/(c_j − c_k)
//! ```

use crate::numbers::lanes::{Lanes, MAX_LANES};
use crate::stages::attempt::Guess;
use crate::stages::unknowns::Unknowns;
use crate::tableau::butcher::Tableau;
use crate::tableau::dense::scales;

use crate::stages::extrapolation::Extrapolation;

/// The memory from which guesses are made.
#[derive(Clone)]
pub struct Predictor<V> {
    /// The first of the three degrees of freedom of every ball joint.
    balls: Vec<usize>,
    /// The step before.
    pub(crate) extrapolation: Extrapolation<V>,
    /// `c_j` and `Π_{k≠j} 1/(c_j − c_k)` of the stages 2 … s.
    inner: Vec<(f64, f64)>,
}

impl<V: Lanes> Predictor<V> {
    /// Memory for a number of degrees of freedom; each of `balls` is the first of the three of a ball joint.
    pub fn new(freedoms: usize, balls: Vec<usize>, tableau: &Tableau) -> Self {
        let weights = scales(&tableau.nodes).into_iter().map(|scale| 1.0 / scale);
        let inner = tableau.nodes.iter().copied().zip(weights).skip(1);
        Predictor { balls, extrapolation: Extrapolation::new(freedoms, tableau), inner: inner.collect() }
    }

    /// Forgets the past: the next step starts from something else.
    pub fn forget(&mut self) {
        self.extrapolation.forget();
    }

    /// Whether there is a step before this one to guess from.
    pub fn has_past(&self) -> bool {
        self.extrapolation.has_past()
    }

    /// Writes the guess into the displacements, in which the last attempt has left its own.
    #[inline(always)]
    pub fn guess(&mut self, unknowns: Unknowns<V>, guess: Guess) {
        match guess {
            Guess::Longer(attempted) => self.shorten(unknowns, attempted),
            Guess::Past if self.has_past() => self.extrapolation.guess(unknowns),
            Guess::Past | Guess::Plain => {
                self.extrapolation.leave();
                let Unknowns { displacement: displacements, rates, step, coefficients } = unknowns;
                for (displacement, &rate) in displacements.iter_mut().zip(rates) {
                    *displacement = coefficients.nodes * V::splat(step * rate);
                }
            }
        }
    }

    /// The beginning of a longer attempt.
    #[inline(always)]
    fn shorten(&mut self, unknowns: Unknowns<V>, attempted: f64) {
        self.extrapolation.leave();
        let Unknowns { displacement: displacements, step, coefficients, .. } = unknowns;
        let x = coefficients.nodes * V::splat(step / attempted);
        let count = self.inner.len();
        // ℓ_j from the products of the factors before and after its own; for stage 1, with displacement zero, it is x.
        let mut columns = [V::zero(); MAX_LANES];
        let mut before = x;
        for (column, &(node, weight)) in columns.iter_mut().zip(&self.inner) {
            *column = before * V::splat(weight);
            before = before * (x - V::splat(node));
        }
        let mut after = V::splat(1.0);
        for (column, &(node, _)) in columns[..count].iter_mut().zip(&self.inner).rev() {
            *column = *column * after;
            after = after * (x - V::splat(node));
        }
        for displacement in displacements {
            *displacement = displacement.mix(&columns);
        }
    }

    /// Learns from the converged step.
    #[inline(always)]
    pub fn learn(&mut self, unknowns: Unknowns<V>) {
        self.extrapolation.learn(&unknowns);
        for ball in 0..self.balls.len() {
            self.learn_ball(&unknowns, self.balls[ball]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stages::coefficients::Coefficients;
    use crate::vectors::portable::Portable;
    use nalgebra::{UnitQuaternion, Vector3};

    #[test]
    fn the_beginning_of_a_longer_attempt_is_that_of_its_polynomial() {
        let polynomial = |x: f64| x * (0.3 + x * (-1.1 + x * (0.7 + x * (0.2 - x * x * x * x * 0.4))));
        for stages in [9, 8, 5] {
            let tableau = Tableau::of(stages).expect("stages");
            let coefficients = Coefficients::<Portable<8>>::new(tableau);
            let nodes = &tableau.nodes[1..];
            // For few stages it is of degree s − 1, the highest that they can distinguish.
            let value = |x: f64| if stages > 8 { polynomial(x) } else { x * (0.3 + x * (-1.1 + x * (0.7 + x * 0.2))) };
            let mut displacement = [Portable::from_slice(&nodes.iter().map(|&c| value(c)).collect::<Vec<_>>())];
            let unknowns =
                Unknowns { displacement: &mut displacement, rates: &[5.0], step: 0.06, coefficients: &coefficients };
            Predictor::new(1, Vec::new(), tableau).guess(unknowns, Guess::Longer(0.1));
            for (lane, &node) in nodes.iter().enumerate() {
                let off = displacement[0].to_array()[lane] - value(0.6 * node);
                // Some roundings of eight products of size one.
                assert!(off.abs() < 1e-14, "{stages} stages, lane {lane}: {off:e}");
            }
            assert!(displacement[0].to_array()[nodes.len()..].iter().all(|&unused| unused == 0.0));
        }
    }

    #[test]
    fn the_past_of_a_ball_joint_is_the_logarithm_of_its_turns_since_the_new_start() {
        let tableau = Tableau::of(9).expect("stages");
        let coefficients = Coefficients::<Portable<8>>::new(tableau);
        // The relative turns of the two paths go up to 1.4 rad and to 2.9 rad.
        for (pace, bound) in [(1.0, 1e-14), (2.0, 1e-5)] {
            let turn = |node: f64| pace * Vector3::new(1.3 * node, 0.4 - 0.4 * (2.0 * node).cos(), -0.2 * node * node);
            let mut displacement: Vec<Portable<8>> = (0..3)
                .map(|axis| {
                    Portable::from_slice(&tableau.nodes[1..].iter().map(|&c| turn(c)[axis]).collect::<Vec<_>>())
                })
                .collect();
            let mut predictor = Predictor::new(3, vec![0], tableau);
            let rates = [0.0; 3];
            predictor.learn(Unknowns {
                displacement: &mut displacement,
                rates: &rates,
                step: 1.0,
                coefficients: &coefficients,
            });
            let back = UnitQuaternion::from_scaled_axis(turn(1.0)).inverse();
            for n in 0..8 {
                let expected = (back * UnitQuaternion::from_scaled_axis(turn(tableau.nodes[7 - n]))).scaled_axis();
                for axis in 0..3 {
                    let lane = if n == 7 { 7 } else { 6 - n };
                    let off = (predictor.extrapolation.past[axis].to_array()[lane] - expected[axis]).abs();
                    // Rounding, and the truncation after sixteen terms of the series.
                    assert!(off < bound, "pace {pace}, stage {n}, axis {axis}: {off:e}");
                }
            }
        }
    }
}
