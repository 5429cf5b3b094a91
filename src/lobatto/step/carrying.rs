//! A companion motion, computed in the steps of a kernel: its distance from the kernel's motion is the error that the steps have made.
//!
//! The iteration of a step ends at a stop, and its remaining increment is the error of the step. A second motion `y` with a start of its own goes
//! through the same steps, from the stages `θ` of the first and a guess of the distance. It is iterated until its remaining error is a small part of
//! the distance:
//!
//! ```text
//!     θ_y ← θ + δ̂                                      δ̂ from the last step's δ, and v_y − v at the start      extrapolation.rs
//!     repeat:  θ_y ← Anderson(θ_y, increments at θ_y)   with the factors that the first motion has left         anderson.rs
//!     until the increments are a small part of δ̂, or of what parted the starts
//!     velocity from H(q̄) v̄ = Sᵀ p̄                      at the end of θ_y                                        (2.5.11h)
//! ```
//!
//! So `y` has the errors of the first motion out of it, and `y − x` is what they have grown to. A step costs one to three iterations.
//!
//! A damper of the rate γ stops `v_y − v` within `(v_y − v)/γ`, so that δ is smaller than the guess by the factor `h γ`. Then a small part of the
//! guess is more than all of δ. Increments of that size become velocities, γ times as large, and grow from step to step as if the motion were
//! chaotic. So the increments of a motion with springs or dampers become a small part of `δ = θ_y − θ` as it is after each iteration. The exact
//! Newton method follows, from `δ = 0`, where the simplified iteration does not get there.

use crate::numbers::lanes::{Lanes, in_lanes};
use crate::numbers::reductions::{largest, largest_difference, write_ends};
use crate::solve::iteration::{Coupling, Equations};
use crate::stages::attempt::Carrying;
use crate::step::carried::Carried;
use crate::step::kernel::{Kernel, land};
use crate::step::workspace::Workspace;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::forces::total::Exchange;
use catena_mechanism::motion::energy::Energy;
use catena_mechanism::motion::state::State;

/// After this number of iterations the distance of the motions is no small difference any more.
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
        carried.at_once = self.closing.is_none() && self.workspace.prepare_two(mechanism);
    }

    /// Moves the carried motion, which is in this state, through the step that was finished and is not accepted yet.
    pub(crate) fn carry(&mut self, mechanism: &Mechanism, state: &mut State, carrying: &Carrying) {
        let Some(mut carried) = self.carried.take() else { return };
        let chord = self.chord;
        carried.part_from(&mut self.workspace);
        if carrying.exactly {
            self.solve_carried_exactly(carrying);
        } else {
            let solved = self.solve_carried(carrying, &carried.apart, &carried.solved);
            if carrying.sprung && !solved {
                let known = self.workspace.known();
                self.workspace.advanced().0[known..].copy_from_slice(&carried.solved[known..]);
                self.make_exact(mechanism);
                self.solve_carried_exactly(carrying);
            }
        }
        carried.part(&mut self.workspace);
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
        workspace.accept_two(false);
        self.chord = chord;
        self.carried = Some(carried);
    }

    /// Moves both motions through the solved step, `states` to their ends, at once: the ends of both are computed side by side
    /// ([`crate::ending::two_motions`]). `None`, without any effect, if the mechanism has no such code. Until [`Kernel::settle_carried`] the carried
    /// motion can still be taken back.
    pub(crate) fn end_both(
        &mut self,
        mechanism: &Mechanism,
        states: [&mut State; 2],
        carrying: &Carrying,
    ) -> Option<Energy> {
        if carrying.exactly || !self.carried.as_ref().is_some_and(|carried| carried.at_once) {
            return None;
        }
        let mut carried = self.carried.take()?;
        let (active, refined, chord) = (self.active(), self.refined, self.chord);
        self.at_contacts = Exchange::default();
        self.workspace.record_end(refined, 0);
        write_ends(self.workspace.displacement(), active, &mut self.displaced);
        carried.part_from(&mut self.workspace);
        self.solve_carried(carrying, &carried.apart, &carried.solved);
        carried.part(&mut self.workspace);
        self.chord = chord;
        let Kernel { workspace, velocity, displaced, end, top_legendre, .. } = self;
        workspace.record_end(refined, 1);
        let mut moved = std::mem::take(&mut carried.displaced);
        write_ends(workspace.displacement(), active, &mut moved);
        if carrying.truncation > 0.0 {
            carried.truncate(*top_legendre, carrying.truncation, &mut moved);
        }
        carried.displaced = moved;
        carried.exchange(workspace);
        let [state, beside] = states;
        let squares = workspace.two_velocities(&carried.start, [velocity, &mut carried.velocity]);
        state.displace(mechanism, displaced);
        state.velocity.copy_from_slice(velocity);
        beside.displace(mechanism, &carried.displaced);
        beside.velocity.copy_from_slice(&carried.velocity);
        workspace.set_two_ends([end, &mut carried.end], mechanism, [state, beside]);
        carried.both_set = true;
        if workspace.lacks_digits(end, squares[0]) {
            carried.both_set = false;
            refine_alone(workspace, refined, velocity, mechanism, state, end);
        }
        carried.exchange(workspace);
        if workspace.lacks_digits(&carried.end, squares[1]) {
            carried.both_set = false;
            refine_alone(workspace, refined, velocity, mechanism, beside, &mut carried.end);
        }
        carried.exchange(workspace);
        self.carried = Some(carried);
        Some(W::energy(&self.end))
    }

    /// The carried motion stays where [`Kernel::end_both`] has taken it: the step is going to be accepted.
    pub(crate) fn settle_carried(&mut self) {
        let Kernel { workspace, carried: Some(carried), .. } = self else { return };
        carried.learn(workspace);
        std::mem::swap(&mut carried.start, &mut carried.end);
        workspace.accept_two(carried.both_set);
    }

    /// The simplified iteration, from the guess `apart` and beside the stages `solved` of the first motion; returns whether it has come to its end.
    fn solve_carried(&mut self, carrying: &Carrying, apart: &[V], solved: &[V]) -> bool {
        let guessed = in_lanes!(V, largest(apart));
        self.chord.begin_with(self.workspace.has_factors());
        self.workspace.leave_single();
        self.anderson.restart();
        for iteration in 1..=HOPELESS {
            let increment = self.iterate(self.refined);
            let ends = if carrying.sprung {
                let known = self.workspace.known();
                let own = &self.workspace.displacement()[known..];
                let parted = in_lanes!(V, largest_difference(own, &solved[known..]));
                increment <= (carrying.part * parted).max(carrying.least)
            } else {
                let left = increment / guessed.max(carrying.apart);
                left <= carrying.part || (iteration >= carrying.most && left <= carrying.rest)
            };
            if ends {
                self.complete();
                return true;
            }
            if iteration < HOPELESS {
                self.advance();
            }
        }
        self.complete();
        false
    }

    /// The exact Newton method, of which one iteration leaves the square of the distance of the motions.
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

/// The velocities at the end of a motion that lack digits, refined, in one lane.
fn refine_alone<V: Lanes, W: Workspace<V>>(
    workspace: &mut W,
    refined: bool,
    velocity: &mut [f64],
    mechanism: &Mechanism,
    state: &mut State,
    end: &mut W::Start,
) {
    if let Some(square) = workspace.end_velocities(refined, velocity)
        && workspace.refine_velocities(end, square, velocity)
    {
        state.velocity.copy_from_slice(velocity);
        workspace.set_end(end, mechanism, state);
    }
}
