//! Limits that a joint comes near to within a step and turns back from.
//!
//! ```text
//!     φ(c) = Σ_i φ_i l_i(c)                    c: 0..1, through the stages        φ̇ = 0 at c*
//!     ∂φ(c*)/∂θ = ∂φ/∂q ∂q(c*)/∂θ              ∂q/∂θ: cubic between its values and rates at both ends
//! ```
//!
//! The gap is least where its rate is zero, so that the change of c* has no part in its derivative.

use crate::derivatives::events::walk::Walk;
use crate::derivatives::forward::tangent::Tangent;
use crate::events::trace::{JointMode, TracedStep};
use crate::instant::holding::elements::inward;
use crate::mechanism::motion::event::Side;
use crate::mechanism::motion::state::State;

/// Places at which the polynomial is looked at before its least value is refined: many more than it has extremes.
const LOOKED_AT: usize = 256;

/// A start this close to a limit is on it (rad or m): what assembly leaves.
const ON_LIMIT: f64 = 1e-9;

impl Walk<'_> {
    /// Notes limits that the start is on, if it leaves them with a parameter: such a start is put back on one side, and on the other it is not. And
    /// joints that friction holds from the start on, if they begin to move with a parameter.
    pub(super) fn see_start(&mut self, traced: &TracedStep) {
        let (mechanism, elements) = (self.subject.mechanism, self.subject.elements);
        for (body, _) in mechanism.bodies.iter().zip(&traced.held).filter(|(_, held)| **held) {
            let what = format!("joint {:?} starts at rest and is held", body.joint.name);
            for column in 0..self.tangent.times.len() {
                let rates = self.tangent.velocities.column(column);
                if rates.rows_range(body.joint.velocity_range()).amax() > ON_LIMIT {
                    self.validity.none(column, &what);
                }
            }
        }
        for (index, joint) in elements.joints.iter().enumerate().filter(|(_, joint)| !joint.is_locked()) {
            for side in joint.sides().filter(|&side| joint.gap(side, joint.position(&self.state)).abs() <= ON_LIMIT) {
                let slopes = self.varied.slopes();
                let bound = |column: usize| {
                    let laws = slopes[column].as_ref().map(|slopes| &slopes.laws.joints[index]);
                    laws.map_or(0.0, |laws| if side == Side::Lower { laws.lower } else { laws.upper })
                };
                let row = joint.coordinate.freedom;
                let leaves = (0..slopes.len()).filter(|&column| {
                    let off = self.tangent.positions[(row, column)] - bound(column);
                    off.abs() > ON_LIMIT
                });
                let what = format!("joint {:?} starts on its limit", mechanism.bodies[joint.owner(side)].joint.name);
                leaves.collect::<Vec<usize>>().into_iter().for_each(|column| self.validity.none(column, &what));
            }
        }
    }

    /// Notes limits that a joint has turned back from within a step, from its start with its derivatives and its stages i = 2..s.
    pub(super) fn see_near(&mut self, traced: &TracedStep, (before, was): (&State, &Tangent), stages: &[State]) {
        let (mechanism, elements) = (self.subject.mechanism, self.subject.elements);
        let step = self.state.time - before.time;
        for (joint, mode) in elements.joints.iter().zip(&traced.mode.joints) {
            let JointMode::Free { .. } = mode else { continue };
            for side in joint.sides() {
                let rates = [before, &self.state].map(|state| inward(side) * joint.rate(state));
                if !(rates[0] < 0.0 && rates[1] > 0.0) {
                    continue;
                }
                let gap = |state: &State| joint.gap(side, joint.position(state));
                let gaps: Vec<f64> = std::iter::once(before).chain(stages).map(gap).collect();
                let (place, least) = self.looks.least(&gaps);
                let row = joint.coordinate.freedom;
                let (one, two) = (place * place, place * place * place);
                let by = (was.positions.row(row) * (1.0 - 3.0 * one + 2.0 * two)
                    + was.velocities.row(row) * (step * (place - 2.0 * one + two))
                    + self.tangent.positions.row(row) * (3.0 * one - 2.0 * two)
                    + self.tangent.velocities.row(row) * (step * (two - one)))
                    .transpose();
                let name = &mechanism.bodies[joint.owner(side)].joint.name;
                let what = format!("joint \"{name}\" meets a limit");
                self.validity.see_near(&what, before.time + place * step, least.max(0.0), &by);
            }
        }
    }
}

/// Polynomials through values at nodes between 0 and 1, looked at in many places.
pub(super) struct Looks {
    nodes: Vec<f64>,
    /// l_i of all places, place by place.
    bases: Vec<f64>,
}

impl Looks {
    /// With these nodes.
    pub fn new(nodes: &[f64]) -> Self {
        let nodes = nodes.to_vec();
        let of = |index: usize| bases(&nodes, index as f64 / LOOKED_AT as f64);
        Looks { bases: (0..=LOOKED_AT).flat_map(of).collect(), nodes }
    }

    /// The place and the least value of the polynomial through some values.
    fn least(&self, values: &[f64]) -> (f64, f64) {
        let sum = |bases: &[f64]| bases.iter().zip(values).map(|(base, value)| base * value).sum::<f64>();
        let seen: Vec<f64> = self.bases.chunks_exact(values.len()).map(sum).collect();
        let index = (0..seen.len()).min_by(|&one, &other| seen[one].total_cmp(&seen[other])).unwrap_or_default();
        let (best, width) = (index as f64 / LOOKED_AT as f64, 1.0 / LOOKED_AT as f64);
        // The vertex of the parabola through the neighbours.
        let at = |place: f64| sum(&bases(&self.nodes, place));
        let [before, here, after] = [best - width, best, best + width].map(at);
        let bend = before - 2.0 * here + after;
        let place = if bend > 0.0 { best + 0.5 * width * (before - after) / bend } else { best };
        let place = place.clamp(0.0, 1.0);
        (place, at(place).min(here))
    }
}

/// l_i at a place.
fn bases(nodes: &[f64], place: f64) -> Vec<f64> {
    let base = |i: usize| -> f64 {
        let others = (0..nodes.len()).filter(|&other| other != i);
        others.map(|other| (place - nodes[other]) / (nodes[i] - nodes[other])).product()
    };
    (0..nodes.len()).map(base).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_value_of_a_polynomial_through_stages_is_found_to_rounding() {
        let nodes = [0.0, 0.172_673_164_646_011_4, 0.5, 0.827_326_835_353_988_6, 1.0];
        let of = |place: f64| (place - 0.37).powi(2) * (1.0 + place * place) + 1e-9;
        let values = nodes.map(of);
        let (place, least) = Looks::new(&nodes).least(&values);
        // The parabola of three places 1/256 apart is off by the third derivative, 1e-5 of a place, and its square in value.
        assert!((place - 0.37).abs() < 1e-4 && (least - 1e-9).abs() < 1e-9, "{place} {least}");
    }
}
