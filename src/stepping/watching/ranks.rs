//! Singular positions of loops: solves find more redundant equations than elsewhere, and kinematics confirms it.

use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::motion::integrator::SingularPosition;
use catena_mechanism::motion::state::State;
use catena_mechanism::structure::ranks::counting;

/// The position at which the solves leave more equations redundant than elsewhere, and kinematics confirms it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Ranks {
    fewest: Option<usize>,
    most: usize,
    singular: Option<SingularPosition>,
    /// How often kinematics did not agree.
    refuted: usize,
}

/// Kinematics is not asked again after this number of refutations: the residue of light bodies in the solves is meaningless.
const REFUTED: usize = 64;

/// Whether joints close loops: points of contact that imply each other are no position of theirs, and neither is a joint that is moved in time.
fn has_loops(mechanism: &Mechanism) -> bool {
    !mechanism.loops.is_empty() || mechanism.mimics.iter().any(|mimic| !mimic.is_moved())
}

impl Ranks {
    /// Takes how many equations the last solve left redundant, in the state in which it ended.
    pub(crate) fn see(&mut self, redundant: usize, mechanism: &Mechanism, state: &State, time: f64) {
        let more = self.fewest.is_some_and(|fewest| redundant > self.most.max(fewest));
        self.fewest = Some(self.fewest.map_or(redundant, |fewest| fewest.min(redundant)));
        if more && self.refuted < REFUTED && has_loops(mechanism) {
            self.ask(mechanism, state, time);
            self.most = if self.singular.is_some_and(|seen| seen.time == time) { redundant } else { self.most };
        }
    }

    /// Asks kinematics whether a position is singular.
    fn ask(&mut self, mechanism: &Mechanism, state: &State, time: f64) {
        self.hear(counting::Ranks::at(mechanism, state).weak, mechanism, time);
    }

    /// Takes how many independent equations are weak in a position.
    pub(crate) fn hear(&mut self, weak: usize, mechanism: &Mechanism, time: f64) {
        if weak > 0 && has_loops(mechanism) {
            self.singular = Some(SingularPosition { time, extra: weak });
        } else {
            self.refuted += 1;
        }
    }

    /// The last singular position that was seen.
    pub(crate) fn singular(&self) -> Option<SingularPosition> {
        self.singular
    }
}
