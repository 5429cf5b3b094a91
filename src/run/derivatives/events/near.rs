//! Limits that a joint comes near to within a step and turns back from.
//!
//! ```text
//!     φ(c) = Σ_i φ_i l_i(c)                    c: 0..1, through the stages        φ̇ = 0 at c*
//!     ∂φ(c*)/∂θ = ∂φ/∂q ∂q(c*)/∂θ              ∂q/∂θ: cubic between its values and rates at both ends
//! ```
//!
//! The gap is least where its rate is zero, so that the change of c* has no part in its derivative.

use crate::derivatives::events::looks::Looks;
use crate::derivatives::events::walk::Walk;
use crate::derivatives::forward::tangent::Tangent;
use crate::events::trace::{JointMode, TracedStep};
use crate::instant::holding::elements::inward;
use crate::mechanism::motion::state::State;

impl Walk<'_> {
    /// Notes limits that a joint has turned back from within a step, from its start with its derivatives and its stages i = 2..s.
    pub(super) fn see_near(&mut self, traced: &TracedStep, (before, was): (&State, &Tangent), stages: &[State]) {
        if !self.tells || stages.len() + 1 != self.subject.tableau.stages {
            return;
        }
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
                let (place, least) = self.looks.get_or_init(|| Looks::new(&self.subject.tableau.nodes)).least(&gaps);
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
