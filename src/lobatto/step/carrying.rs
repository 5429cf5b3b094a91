//! A companion motion, computed in the steps of a kernel: its distance from the kernel's motion is the error that the steps have made.
//!
//! The iteration of a step ends at a stop, and what it leaves is the error of the step. A second motion `y` with a start of its own goes through
//! the same steps, from the stages `θ` of the first and a guess of what parts them, and is iterated until what is left is a small part of that:
//!
//! ```text
//!     θ_y ← θ + δ̂                                      δ̂ from the last step's δ, and v_y − v at the start      extrapolation.rs
//!     repeat:  θ_y ← Anderson(θ_y, increments at θ_y)   with the factors that the first motion has left         anderson.rs
//!     until the increments are a small part of δ = θ_y − θ, or of what parted the starts
//!     velocity from H(q̄) v̄ = Sᵀ p̄                      at the end of θ_y                                        (2.5.11h)
//! ```
//!
//! So `y` has the errors of the first motion out of it, and `y − x` is what they have grown to. A step costs one to three iterations.

use crate::numbers::lanes::{Lanes, in_lanes};
use crate::numbers::reductions::{largest, write_ends};
use crate::solve::iteration::{Coupling, Equations};
use crate::stages::attempt::Carrying;
use crate::step::carried::Carried;
use crate::step::kernel::{Kernel, land};
use crate::step::workspace::Workspace;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::motion::state::State;

/// After so many iterations what parts the motions is no small difference any more.
const HOPELESS: usize = 12;

impl<V: Lanes, W: Workspace<V>> Kernel<V, W> {
    /// A motion is carried from this state on.
    pub(crate) fn start_carrying(&mut self, mechanism: &Mechanism, state: &State) {
        let (freedoms, iterated) = (self.displaced.len(), self.displaced.len() - self.workspace.known());
        let carried = self
            .carried
            .get_or_insert_with(|| Box::new(Carried::new::<W>(mechanism, freedoms, iterated, self.tableau)));
        carried.past.forget();
        self.workspace.set_end(&mut carried.start, mechanism, state);
    }

    /// Moves the carried motion, which is in this state, through the step that was finished and is not accepted yet.
    pub(crate) fn carry(&mut self, mechanism: &Mechanism, state: &mut State, carrying: &Carrying) {
        let Some(mut carried) = self.carried.take() else { return };
        let chord = self.chord;
        carried.part_from(&mut self.workspace);
        if carrying.exactly {
            self.solve_carried_exactly(carrying);
        } else {
            self.solve_carried(carrying, &carried.apart);
        }
        carried.learn(&mut self.workspace);
        let active = self.active();
        let Kernel { workspace, velocity, displaced, top_legendre, refined, .. } = self;
        let square = workspace.end_velocities(*refined, velocity);
        write_ends(workspace.displacement(), active, displaced);
        if carrying.truncation > 0.0 {
            carried.truncate(*top_legendre, carrying.truncation, displaced);
        }
        land(workspace, square, displaced, velocity, mechanism, state, &mut carried.end);
        std::mem::swap(workspace.start_mut(), &mut carried.start);
        std::mem::swap(&mut carried.start, &mut carried.end);
        workspace.advanced().0.copy_from_slice(&carried.solved);
        self.chord = chord;
        self.carried = Some(carried);
    }

    /// The simplified iteration.
    fn solve_carried(&mut self, carrying: &Carrying, apart: &[V]) {
        let guessed = in_lanes!(V, largest(apart));
        self.chord.begin_with(self.workspace.has_factors());
        self.workspace.leave_single();
        self.anderson.restart();
        for iteration in 1.. {
            let increment = self.iterate(self.refined);
            let left = increment / guessed.max(carrying.apart);
            if left <= carrying.part || (iteration >= carrying.most && left <= carrying.rest) || iteration >= HOPELESS {
                return self.complete();
            }
            self.advance();
        }
    }

    /// The exact Newton method, of which one iteration leaves the square of what parts the motions.
    fn solve_carried_exactly(&mut self, carrying: &Carrying) {
        let Kernel { workspace, newton: Some(newton), .. } = self else { return };
        workspace.begin_exactly();
        let stages = workspace.stage_unknowns();
        // Only trees carry a motion.
        newton.begin(stages.plan, stages.start, None);
        for iteration in 1.. {
            let increment = self.couple();
            self.add_increments();
            if iteration >= carrying.most || increment <= carrying.part * carrying.apart {
                return;
            }
        }
    }
}
