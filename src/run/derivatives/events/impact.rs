//! The derivative of an impact at its active set, round by round.
//!
//! ```text
//!     M(q) (v⁺ − v⁻) = Wᵀ P + Gᵀ Λ,   G v⁺ = 0,   u = W v
//!     open     P = 0
//!     closed   u_N + e min(u_N⁻, 0) = 0          sticks   u_T = 0          slides   P_T + μ P_N u_T/|u_T| = 0
//!
//!     v = v_C + σ (v_N − v_C)          σ = 1, or the root of ½ vᵀ M v = ½ v⁻ᵀ M v⁻
//! ```
//!
//! v_C is the plastic answer (e = 0), v_N the one of Newton's law; both have active sets of their own, as in [`crate::instant::cone::impact`]. The
//! equations are solved in doubles ([`crate::derivatives::events::struck`]). The factors of their matrix give all derivatives: these need the residuals
//! over numbers with derivatives, and no matrix.

use crate::derivatives::events::instant::Instant;
use crate::derivatives::events::meet::{InPlace, Meet, Met, Moving};
use crate::derivatives::events::struck::{Struck, StruckRound};
use crate::derivatives::forward::step::{Part, WIDTH, constant};
use crate::derivatives::numbers::number::Number;
use nalgebra::DMatrix;

/// An impact over numbers with derivatives.
pub(super) struct Impact<'i> {
    pub at: Instant<'i, Part>,
    pub met: &'i [Met<Part>],
    /// Independent closures, and the number of all.
    pub closed: &'i [usize],
    pub row_count: usize,
}

/// The places of the blocks, the motion before an impact, and its velocities.
type Before<'b> = (&'b [Option<InPlace<Part>>], &'b Moving<Part>, &'b [Part]);

impl Impact<'_> {
    /// The velocities after all rounds, with their derivatives, and the most that laws of redundant contacts lack by each parameter.
    pub fn after(&self, before: &[Part], rounds: &[StruckRound]) -> Option<(Vec<Part>, [f64; WIDTH])> {
        let mut lacking = [0.0; WIDTH];
        let mut velocities = before.to_vec();
        for round in rounds {
            let meet = Meet { at: &self.at, met: self.met, part: &round.part };
            let places = meet.in_place();
            let begun = meet.moving(&places, &velocities);
            let mut answer = |of: &Struck| self.answer(&meet, (&places, &begun, &velocities), of, &mut lacking);
            let plastic = answer(&round.plastic)?;
            velocities = match &round.rebound {
                None => plastic,
                Some(of) => {
                    let rebound = answer(of)?;
                    match round.share {
                        1.0 => rebound,
                        share => meet.shared(&velocities, &plastic, &rebound, share)?,
                    }
                }
            };
        }
        Some((velocities, lacking))
    }

    /// One answer, with its derivatives, from the places and the motion before it.
    fn answer(
        &self,
        meet: &Meet<Part>,
        (places, begun, before): Before,
        of: &Struck,
        lacking: &mut [f64; WIDTH],
    ) -> Option<Vec<Part>> {
        let (velocities, impulses): (Vec<Part>, Vec<Part>) = (constant(&of.velocities), constant(&of.impulses));
        let mut multipliers = vec![Part::zero(); self.row_count];
        self.closed.iter().zip(&of.multipliers).for_each(|(&row, &value)| multipliers[row] = Part::of(value));
        let after = meet.moving(places, &velocities);
        let mut rows = self.at.momenta_gained([&begun.bodies, &after.bodies], [before, &velocities]);
        let pushed = meet.pushed(places, &after, &impulses, &multipliers);
        rows.iter_mut().zip(pushed).for_each(|(row, push)| *row = *row - push);
        rows.extend(meet.laws(&of.states, of.rebounds, [&begun.rates, &after.rates], &impulses));
        let rates = self.at.closure_rates(&velocities);
        rows.extend(self.closed.iter().map(|&row| rates[row]));
        let right = DMatrix::from_fn(rows.len(), WIDTH, |row, part| -rows[row].parts[part]);
        let found = of.factors.solve(&right)?;
        let lacks = of.factors.lacking(&found, &right, velocities.len());
        lacking.iter_mut().zip(lacks).for_each(|(most, own)| *most = most.max(own));
        let part = |(row, &value): (usize, &f64)| {
            let mut part = Part::of(value);
            (0..WIDTH).for_each(|index| part.parts[index] = found[(row, index)]);
            part
        };
        Some(of.velocities.iter().enumerate().map(part).collect())
    }
}
