//! The way to a gap that closes sooner than a step can be solved.
//!
//! ```text
//!     q(δ) = q₀ + δ v₀ + ½ δ² a₀,   v(δ) = v₀ + δ a₀,      δ ≤ 1e-8 s with φ(q(δ)) = 0
//! ```
//!
//! φ is the gap of a pair or of a limit (m or rad), a₀ the accelerations in the mode. In such short steps on closed contacts, roundings of gaps act
//! as forces, and the scheme cannot solve them. The omitted terms are of the order of δ³, so the state is right to its roundings. A pair that entered
//! the other one would have to be moved apart again.

use crate::events::finding::watched::{Seen, Watched};
use crate::events::forces::closed_forces::accelerations;
use crate::events::integrator::{Eventful, InUse};
use crate::events::modes::tolerances::BALLISTIC_GAP;
use crate::events::parts::model::HybridModel;
use crate::events::parts::trial::StepTrial;
use crate::instant::holding::touching::TOUCHED;
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;

/// Attempts at the length of the way.
const ATTEMPTS: usize = 40;

impl Eventful {
    /// Goes from the start of the step to the first watched gap that closes within `longest` (s), and adds it to the triggers. False if no trigger is
    /// open there, or no gap closes.
    pub fn go_ballistically(&mut self, inputs: Inputs, longest: f64, triggers: &mut Vec<Watched>) -> bool {
        if self.mode.contacts.is_empty() {
            return false;
        }
        let open = |watched: &Watched, gap: f64, this: &Self| {
            gap > watched.nearly(TOUCHED, &this.model.elements, &this.model.touching, &this.mode)
        };
        let origin = self.trial.origin.clone();
        let placed = (body_states(&self.model.whole, &origin), origin.clone());
        let opens = triggers.iter().any(|watched| is_gap(*watched) && open(watched, self.gap(*watched, &placed), self));
        let found = if opens { self.first_gap(inputs, longest, &origin) } else { None };
        let Some((end, first)) = found else { return false };
        if !triggers.contains(&first) {
            triggers.push(first);
        }
        let piece = self.workspaces.active_mut();
        piece.small = piece.moving.gather(&self.model.whole, &end);
        true
    }

    /// The state in which the first gap closes, and that gap.
    fn first_gap(&mut self, inputs: Inputs, longest: f64, origin: &State) -> Option<(State, Watched)> {
        let InUse { present, response, efforts, unique } = self.in_use();
        let mut all = vec![0.0; efforts.len()];
        present.mode.efforts_at(present.elements, inputs, origin.time, origin, &mut all);
        let accelerations = accelerations(&present, response, origin, &all, unique);
        let moves: Vec<f64> = accelerations.into_iter().map(|(acceleration, _)| acceleration).collect();
        let (mut until, mut first) = (longest, None);
        let gaps: Vec<Watched> = self.trial.watched.iter().copied().filter(|watched| is_gap(*watched)).collect();
        let placed = |state: State| (body_states(&self.model.whole, &state), state);
        let origin_placed = placed(origin.clone());
        let mut end = placed(self.after(origin, &moves, until));
        for watched in gaps {
            if self.is_apart(watched, &end.0) {
                continue;
            }
            let start = self.gap(watched, &origin_placed);
            let closed = watched.nearly(BALLISTIC_GAP, &self.model.elements, &self.model.touching, &self.mode);
            let after = self.gap(watched, &end);
            if start <= closed || after > 0.0 {
                continue;
            }
            // Illinois, between an end that is open and one that is closed.
            let ([mut low, mut high], [mut above, mut below]) = ([0.0, until], [start, after]);
            let mut last = 0;
            for _ in 0..ATTEMPTS {
                let at = low + (high - low) * (above / (above - below));
                let gap = self.gap(watched, &placed(self.after(origin, &moves, at)));
                if gap > 0.0 {
                    (low, above) = (at, gap);
                    below *= if last == 1 { 0.5 } else { 1.0 };
                    last = 1;
                } else {
                    (high, below) = (at, gap);
                    above *= if last == -1 { 0.5 } else { 1.0 };
                    last = -1;
                }
                if gap.abs() <= closed {
                    high = at;
                    break;
                }
            }
            (until, first) = (high, Some(watched));
            end = placed(self.after(origin, &moves, until));
        }
        Some((end.1, first?))
    }

    /// The state after this time (s) under constant accelerations.
    fn after(&self, origin: &State, accelerations: &[f64], time: f64) -> State {
        let mut state = origin.clone();
        let moved = origin.velocity.iter().zip(accelerations).map(|(rate, a)| time * (rate + 0.5 * time * a));
        state.displace(&self.model.whole, &moved.collect::<Vec<f64>>());
        state.velocity.iter_mut().zip(accelerations).for_each(|(rate, a)| *rate += time * a);
        state.time += time;
        state
    }

    /// Whether little work tells that a pair without a closed contact is open with these bodies.
    fn is_apart(&self, watched: Watched, bodies: &[BodyState]) -> bool {
        let Watched::Approach(pair) = watched else { return false };
        let is_closed = self.mode.touches(pair);
        !is_closed && self.model.touching.least_distance(pair, bodies, 0.0) > 0.0
    }

    /// A gap in a state with its bodies (m or rad).
    fn gap(&self, watched: Watched, (bodies, state): &(Vec<BodyState>, State)) -> f64 {
        let Eventful {
            model: HybridModel { elements, touching, .. },
            trial: StepTrial { holding, slips, turns, .. },
            mode,
            ..
        } = self;
        let [since, time] = [state.time; 2];
        watched.value(&Seen { elements, touching, mode, holding, since, time, state, bodies, slips, turns })
    }
}

/// Whether it is the distance of a pair or to a limit.
fn is_gap(watched: Watched) -> bool {
    matches!(watched, Watched::Approach(_) | Watched::Gap(..))
}
