//! Targets of motors that a program sets during a run.
//!
//! A motor that is given a target follows it from then on, with rate zero, until it is given another:
//!
//! ```text
//!     τ = kp (r − q) − kd q̇,    τ = kd (r − q̇)    or    τ = r           r: the last target that was given
//! ```
//!
//! The target is part of the efforts at the stages, not of a spring's rest, so that another one asks for no other workspace. A motor that works out
//! its effort at ticks sees it at the next tick. A jump of the effort may let go of joints and contacts at rest, or reach the bound of the motor: the
//! mode is decided anew then.

use crate::events::integrator::Eventful;
use crate::events::modes::drives::Commands;
use crate::mechanism::description::target::Target;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::state::State;

impl Eventful {
    /// Gives a motor a target from now on: rad or m, rad/s or m/s, N m or N.
    pub fn aim(&mut self, motor: usize, value: f64) {
        let Some(known) = self.model.elements.motors.get_mut(motor) else { return };
        if known.target.is_commanded() {
            if known.target.value(0.0) != value {
                known.target.command(value);
                self.commands = self.commands.max(Commands::Given);
            }
        } else {
            known.target = Target::commanded(value);
            self.commands = Commands::Begun;
        }
    }

    /// Takes the targets that were given since the last step.
    pub(super) fn follow_commands(&mut self, inputs: Inputs, state: &mut State) {
        let commands = std::mem::take(&mut self.commands);
        if commands == Commands::Known {
            return;
        }
        self.trial.forget_looks();
        let mut changed = commands == Commands::Begun;
        if changed {
            self.workspaces.pieces.clear();
            (self.workspaces.current, self.workspaces.last) = (0, 0);
        }
        for index in 0..self.model.elements.motors.len() {
            // Between ticks the effort is held.
            let held = self.model.elements.motors[index].period > 0.0;
            let mode = self.motor_mode(index, state);
            if !held && mode != self.mode.motors[index] {
                self.mode.motors[index] = mode;
                changed = true;
            }
        }
        if changed || self.progress.asleep || !self.goes_on_under(inputs, state, false) {
            let exchanged = self.pass(inputs, state, &[], false);
            self.tally.lost_at_start += exchanged;
        }
        // A piece that is shared with a copy of the run is changed only if it has other targets.
        for piece in self.workspaces.pieces.iter_mut().filter(|piece| piece.drives.is_behind(&self.model.elements)) {
            piece.drives.heed(&self.model.elements);
        }
    }
}
