//! The state of a run as a value: taken, given back, copied; and other starts in the middle of a run.
//!
//! ```text
//!     state c = state() ──step──▶ x        set_state(c) ──step──▶ x, bit for bit        place(t, q, v) ──step──▶ as a new run from there
//! ```

use crate::model::Start;
use crate::session::description::STEPPED;
use crate::session::error::Error;
use crate::session::held_start::{HeldTargets, motors_from};
use crate::session::model::Model;
use crate::session::running::Running;
use crate::session::simulation::Simulation;
use crate::session::state::State;
use std::cell::OnceCell;
use std::sync::Arc;

impl Simulation {
    /// The present state as a value. Begins the run if it has not begun.
    ///
    /// # Errors
    /// Invalid settings, and a run that has ended.
    pub fn state(&mut self) -> Result<State, Error> {
        self.begin(STEPPED)?;
        let kept = self.running.as_ref().and_then(|running| running.simulation.checkpoint());
        let kept = kept.ok_or(Error::Over(self.begin))?;
        Ok(State { model: self.model.clone(), kept, asked: self.control.as_ref().map(|control| control.ticks()) })
    }

    /// Goes on from a state of this run, or of another run of the same model with the same settings, bit for bit. The figures of the report begin
    /// anew there. What a controller remembers itself is not part of the state.
    ///
    /// # Errors
    /// A state of another model or of other settings, and a run with a log, which cannot go back.
    pub fn set_state(&mut self, state: &State) -> Result<(), Error> {
        self.refuse_log()?;
        if !self.model.is(&state.model) {
            return Err(Error::OtherModel {
                state: state.model.description().mechanism.name.clone(),
                run: self.model.description().mechanism.name.clone(),
            });
        }
        if self.running.is_none() {
            self.take_observers();
            let (q, v) = state.coordinates();
            self.start_anew(state.time(), &q, &v)?;
            self.begin(STEPPED)?;
        }
        let restored = self.running.as_mut().is_some_and(|running| running.restore(&state.kept));
        if !restored {
            return Err(Error::OtherSettings);
        }
        self.efforts = Some(state.kept.efforts().to_vec()).filter(|efforts| !efforts.is_empty());
        if let (Some(control), Some(asked)) = (&mut self.control, state.asked) {
            control.ask_from(asked);
        }
        Ok(())
    }

    /// Another run with the same model, settings and state, which goes on to the same bits. It has no controller, observers or log.
    ///
    /// # Errors
    /// As of [`Simulation::state`].
    pub fn copy(&mut self) -> Result<Self, Error> {
        let state = self.state()?;
        let mut copy = Simulation::new(&self.model);
        (copy.asked, copy.figures) = (self.asked, self.figures);
        copy.kept.clone_from(&self.kept);
        copy.set_state(&state)?;
        Ok(copy)
    }

    /// Goes on from other coordinates at a time (s): as a new run with these settings from there, without the price of a new one. Efforts from
    /// outside are taken away, and a controller is asked at once. A run that has ended begins again.
    ///
    /// # Errors
    /// As of [`Simulation::start_from`], and a run with a log.
    pub fn place(&mut self, time: f64, q: &[f64], v: &[f64]) -> Result<(), Error> {
        self.refuse_log()?;
        if !time.is_finite() {
            return Err(Error::Option { option: "time", value: time, wanted: "give a finite number" });
        }
        let mut motion = self.model.coordinates().state(self.model.description(), q, v)?;
        motion.time = time;
        self.model.description().keep_to_motions(&mut motion)?;
        let started = self.model.loaded().settled(motion, &Start::default())?;
        // Motors that hold their joints where a run starts are other ones from another start.
        let held = motors_from(self.model.description(), &started.state, &HeldTargets::new());
        let motors = &self.model.description().mechanism.nonsmooth.motors;
        // Motors that hold efforts are other ones, too.
        let holds = !std::mem::take(&mut self.held).is_empty() | !std::mem::take(&mut self.held_at).is_empty();
        let known = !holds && started.warnings.is_empty() && held.is_none_or(|held| held == *motors);
        let placed = known && self.running.as_mut().is_some_and(|running| running.place(&started.state));
        self.efforts = None;
        if !placed {
            self.take_observers();
            self.begin = time;
            (self.positions, self.velocities) = self.listed(q, v);
            self.started = OnceCell::from(started);
        }
        if let Some(control) = &mut self.control {
            control.ask_from((time, 0));
        }
        Ok(())
    }

    fn start_anew(&mut self, time: f64, q: &[f64], v: &[f64]) -> Result<(), Error> {
        self.begin = time;
        self.held.clear();
        self.held_at.clear();
        (self.positions, self.velocities) = self.listed(q, v);
        self.started = OnceCell::new();
        self.started().map(drop)
    }

    /// Ends the run without a report, and takes its observers back for the next one.
    fn take_observers(&mut self) {
        let running = self.running.take().map(Running::into_others);
        let ended = self.ended.take().map(|over| over.others);
        self.observers.extend(running.or(ended).into_iter().flatten());
    }

    fn refuse_log(&self) -> Result<(), Error> {
        if self.log.is_some() { Err(Error::Logged) } else { Ok(()) }
    }
}

impl Model {
    /// Whether both are the same model: one is a clone of the other, or both are of one file with the same options.
    pub(crate) fn is(&self, other: &Model) -> bool {
        Arc::ptr_eq(self.shared(), other.shared()) || (self.path() == other.path() && self.world() == other.world())
    }
}
