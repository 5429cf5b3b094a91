//! The derivatives of an impact on limits of joints of a tree.
//!
//! ```text
//!     M δv⁺ − Wᵀ δP = M δv⁻ − ∂(M Δv)/∂q δq − ∂(M Δv)/∂θ δθ        Δv = v⁺ − v⁻ stays
//!     closed   δu⁺ = −e δu⁻ − u⁻ δe          open   δP = 0
//! ```
//!
//! W is constant. Contacts and closures have the equations of [`crate::derivatives::events::impact`].

use crate::derivatives::equations::figures::Figures;
use crate::derivatives::events::meet::Met;
use crate::derivatives::events::struck::{Struck, StruckRound};
use crate::derivatives::forward::figure_slopes::FigureSlopes;
use crate::derivatives::forward::tree::Momenta;
use crate::instant::cone::problem::BlockState;
use crate::mechanism::motion::state::State;
use nalgebra::DMatrix;

/// An impact on limits.
pub(super) struct LimitImpact<'i> {
    pub figures: &'i Figures<f64>,
    pub state: &'i State,
    pub met: &'i [Met<f64>],
    /// ∂e/∂θ of a limit, by its number among those that meet, by a parameter.
    pub restitution: &'i dyn Fn(usize, usize) -> f64,
    pub slopes: &'i [Option<FigureSlopes>],
}

/// Whether an impact has these equations alone.
pub(super) fn is_on_limits(figures: &Figures<f64>, met: &[Met<f64>], rounds: &[StruckRound]) -> bool {
    figures.loops.is_empty()
        && figures.mimics.is_empty()
        && met.iter().all(|met| matches!(met, Met::Joint { .. }))
        && rounds.iter().all(|round| round.share == 1.0)
}

impl LimitImpact<'_> {
    /// ∂v⁺/∂θ (n × p) after all rounds, from the derivatives of places and of velocities before; `None` if a matrix is singular.
    pub fn after(
        &self,
        positions: &DMatrix<f64>,
        velocities: &DMatrix<f64>,
        rounds: &[StruckRound],
    ) -> Option<DMatrix<f64>> {
        let mut before = self.state.velocity.clone();
        let mut tangent = velocities.clone();
        for round in rounds {
            let answer = round.rebound.as_ref().unwrap_or(&round.plastic);
            tangent = self.answer(round, answer, positions, (&before, &tangent))?;
            before.copy_from_slice(&answer.velocities);
        }
        Some(tangent)
    }

    fn answer(
        &self,
        round: &StruckRound,
        answer: &Struck,
        positions: &DMatrix<f64>,
        (before, tangent): (&[f64], &DMatrix<f64>),
    ) -> Option<DMatrix<f64>> {
        let (n, p) = tangent.shape();
        let gained: Vec<f64> = answer.velocities.iter().zip(before).map(|(after, before)| after - before).collect();
        let momenta = Momenta::new(self.figures, self.state, &gained);
        let mut right = DMatrix::zeros(n + answer.impulses.len(), p);
        let mut of_motion = &answer.mass * tangent - momenta.by_positions() * positions;
        for (column, slopes) in self.slopes.iter().enumerate() {
            if let Some(slopes) = slopes {
                let mut own = of_motion.column_mut(column);
                own -= momenta.by_figures(slopes);
            }
        }
        right.rows_mut(0, n).copy_from(&of_motion);
        for (row, (&block, &state)) in round.part.iter().zip(&answer.states).enumerate() {
            let Met::Joint { freedom, sign, restitution } = self.met[block] else { continue };
            let rate = sign * before[freedom];
            if state == BlockState::Inside && answer.rebounds && rate < 0.0 {
                for column in 0..p {
                    let own = restitution * sign * tangent[(freedom, column)];
                    right[(n + row, column)] = -own - rate * (self.restitution)(block, column);
                }
            }
        }
        Some(answer.factors.solve(&right)?.rows(0, n).into_owned())
    }
}

#[cfg(test)]
mod tests {
    use crate::derivatives::events::instant::Instant;
    use crate::derivatives::forward::stage_equations::BothFigures;
    use crate::derivatives::forward::step::Part;
    use crate::derivatives::forward::tangent::Varied;
    use crate::derivatives::forward::tree::Momenta;
    use crate::derivatives::numbers::number::Number;
    use crate::instant::holding::elements::Elements;
    use crate::mechanism::description::joint::Pose;
    use crate::mechanism::motion::state::State;
    use crate::model::{Base, Model, ModelOptions};
    use crate::scene::{PackagePath, read_urdf};
    use std::path::Path;

    /// Numbers in (−1, 1) that look random.
    fn number(seed: usize) -> f64 {
        let mixed =
            (seed as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(31).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        (mixed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    #[test]
    fn momenta_of_trees_vary_as_those_of_numbers_with_derivatives_do() {
        for (file, base) in
            [("arm7.urdf", Base::Fixed), ("humanoid.urdf", Base::Floating), ("spherical_chain.urdf", Base::Fixed)]
        {
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots").join(file);
            let robot = read_urdf(&path, &PackagePath::default()).expect("a robot");
            let options = ModelOptions { base, ..ModelOptions::default() };
            let mechanism = Model::new(robot, &options).expect("a model").mechanism;
            let (n, bodies) = (mechanism.velocity_count, mechanism.bodies.len());
            let elements = Elements::new(&mechanism);
            let frames = vec![Pose::identity(); bodies];
            let mut state = State::zero(&mechanism);
            let moved: Vec<f64> = (0..n).map(|freedom| 0.7 * number(freedom)).collect();
            state.displace(&mechanism, &moved);
            let velocities: Vec<f64> = (0..n).map(|freedom| number(50 + freedom)).collect();
            // Masses and first moments, and the origins of frames, which a list of figures has from these entries of each body on.
            let count = std::cell::Cell::new(0);
            let figures = BothFigures::taken(&mechanism, &elements, &frames, |entry, value| {
                count.set(count.get().max(entry + 1));
                value
            });
            let mut slopes = vec![0.0; count.get()];
            for body in 0..bodies {
                for entry in (0..4).chain(22..25).chain(34..37) {
                    slopes[3 + 37 * body + entry] = number(900 + 37 * body + entry);
                }
            }
            let varied = Varied::new(&mechanism, &elements, &frames, &[slopes]);
            let momenta = Momenta::new(&figures.plain, &state, &velocities);
            let by_figures = momenta.by_figures(varied.slopes()[0].as_ref().expect("figures that change"));
            let by_positions = momenta.by_positions();
            let constant = BothFigures::taken(&mechanism, &elements, &frames, |_, value| Part::of(value));
            let rates: Vec<Part> = velocities.iter().map(|&rate| Part::of(rate)).collect();
            let of = |figures: &BothFigures<Part>, offsets: &[Part]| {
                let closed = Default::default();
                Instant { figures, state: &state, offsets, closed: &closed }.momenta(&rates)
            };
            let size = mechanism.bodies.iter().map(|body| body.mass).sum::<f64>();
            let still = vec![Part::zero(); n];
            for (row, value) in of(&varied.chunks()[0], &still).iter().enumerate() {
                // Both take the same sums in another order.
                let apart = (value.parts[0] - by_figures[row]).abs();
                assert!(apart < 1e-13 * size.max(1.0), "{file}, row {row}: {} and {}", value.parts[0], by_figures[row]);
            }
            for freedom in 0..n {
                let mut offsets = still.clone();
                offsets[freedom] = Part::parameter(0.0, 0);
                for (row, value) in of(&constant, &offsets).iter().enumerate() {
                    let (other, own) = (value.parts[0], by_positions[(row, freedom)]);
                    assert!(
                        (other - own).abs() < 1e-13 * size.max(1.0),
                        "{file}, {row} by {freedom}: {other} and {own}"
                    );
                }
            }
        }
    }
}
