//! The steps of a run: efforts and controllers, one step after the other, and the end with its report.

use crate::output::report::Report;
use crate::session::account::Told;
use crate::session::control::{Control, Moment};
use crate::session::description::{Origin, STEPPED, WENT_ON};
use crate::session::error::{ControllerFailure, Error};
use crate::session::held_start::motors_from;
use crate::session::loaded::Assembled;
use crate::session::model::Model;
#[cfg(feature = "log")]
use crate::session::place::{check_log, check_place};
use crate::session::running::{Course, Running};
use crate::session::simulation::Simulation;
use crate::session::words::words;
use crate::simulation::{InputError, RunError};

impl Simulation {
    /// Sets efforts on the joints from now on, along v, besides the forces of the model [N m or N]. Those on ball and floating joints turn with the
    /// child.
    ///
    /// # Errors
    /// [`Error::Input`] for a wrong number of efforts and for numbers that are not finite; [`Error::Over`] after the end of the run.
    pub fn set_efforts(&mut self, efforts: &[f64]) -> Result<(), Error> {
        let places = self.model.coordinates();
        let wanted = places.v_count();
        if efforts.len() != wanted {
            return Err(InputError::Count { given: efforts.len(), wanted }.into());
        }
        if let Some(index) = efforts.iter().position(|effort| !effort.is_finite()) {
            let joint = places.joints().iter().find(|joint| joint.v.contains(&index));
            let joint = joint.map_or(String::new(), |joint| joint.name.clone());
            return Err(InputError::NotFinite { joint, effort: efforts[index] }.into());
        }
        if let Some(over) = &self.ended {
            return Err(Error::Over(over.state.time));
        }
        let mut of_state = vec![0.0; wanted];
        let model = self.model.clone();
        self.look(|state| {
            model.coordinates().efforts_of_state(model.description(), &state.position, efforts, &mut of_state)
        })?;
        if let Some(running) = &mut self.running {
            running.simulation.set_efforts(&of_state)?;
        }
        self.efforts = Some(of_state);
        Ok(())
    }

    /// Gives the motor of a joint a target from now on, in place of the file's, until it is given another: a position, a velocity or an effort, as
    /// its law says [rad or m, rad/s or m/s, N m or N]. A motor that works out its effort at ticks sees it at the next tick.
    ///
    /// # Errors
    /// A joint without a motor, a target that is not finite, and invalid settings.
    pub fn set_target(&mut self, joint: &str, target: f64) -> Result<(), Error> {
        let names = self.model.motor_names();
        let Some(motor) = names.iter().position(|name| *name == joint) else {
            let known: Vec<String> = names.into_iter().map(str::to_string).collect();
            return Err(Error::NoMotor { joint: joint.to_string(), known: crate::scene::listed(&known) });
        };
        self.aim([(motor, target)])
    }

    /// The same for all motors, in the order of [`Model::motor_names`].
    ///
    /// # Errors
    /// As of [`Simulation::set_target`], and a wrong number of targets.
    pub fn set_targets(&mut self, targets: &[f64]) -> Result<(), Error> {
        let wanted = self.model.description().mechanism.nonsmooth.motors.len();
        if targets.len() != wanted {
            return Err(Error::Count { what: "targets", given: targets.len(), wanted });
        }
        self.aim(targets.iter().copied().enumerate())
    }

    fn aim(&mut self, targets: impl IntoIterator<Item = (usize, f64)>) -> Result<(), Error> {
        self.aimed = true;
        self.begin(STEPPED)?;
        let Some(running) = &mut self.running else { return Err(Error::Over(self.begin)) };
        targets.into_iter().try_for_each(|(motor, target)| running.simulation.set_target(motor, target))?;
        Ok(())
    }

    /// Sets a controller, called now and after every `period` (s). It writes efforts along v, which are held until the next call; entries that it
    /// does not write are zero. For a reproducible run it must give the same efforts for the same state.
    ///
    /// # Errors
    /// [`Error::Option`] for an invalid period.
    pub fn set_controller(
        &mut self,
        period: f64,
        mut controller: impl FnMut(&Moment, &mut [f64]) + Send + 'static,
    ) -> Result<(), Error> {
        self.set_fallible_controller(period, move |moment, efforts| {
            controller(moment, efforts);
            Ok(())
        })
    }

    /// Sets a controller that may fail; its error ends the run.
    ///
    /// # Errors
    /// As of [`Simulation::set_controller`].
    pub fn set_fallible_controller(
        &mut self,
        period: f64,
        controller: impl FnMut(&Moment, &mut [f64]) -> Result<(), ControllerFailure> + Send + 'static,
    ) -> Result<(), Error> {
        let now = self.time();
        self.control = Some(Control::new(&self.model, now, period, Box::new(controller))?);
        Ok(())
    }

    /// Makes steps until `time` (s), exactly.
    ///
    /// # Errors
    /// A time before the present or after the end of the run; invalid settings; an error of a step, an observer, the log or a controller. After an
    /// error the run has ended, and its log is complete up to there.
    pub fn step_to(&mut self, time: f64) -> Result<(), Error> {
        self.begin(STEPPED)?;
        let (now, end) = (self.time(), self.end());
        if !(time >= now && time <= end) {
            return Err(Error::OutOfRun { wanted: time, time: now, end });
        }
        self.proceed(time)
    }

    /// Makes steps to the end of the run.
    ///
    /// # Errors
    /// As of [`Simulation::step_to`].
    pub fn run(&mut self) -> Result<(), Error> {
        self.begin("")?;
        self.proceed(f64::INFINITY)
    }

    /// Ends the run at the present time, completes its log, and returns its report.
    ///
    /// # Errors
    /// Invalid settings, or a log that cannot be completed.
    pub fn finish(mut self) -> Result<Report, Error> {
        self.end_here()?;
        self.ended.take().map(|over| over.report).ok_or(Error::Over(self.begin))
    }

    /// As [`Simulation::finish`], with the entries of a log of the run, and the model with all warnings.
    #[doc(hidden)]
    pub fn finish_told(mut self) -> Result<(Report, Told, Model), Error> {
        self.end_here()?;
        let over = self.ended.take().ok_or(Error::Over(self.begin))?;
        Ok((over.report, over.told, over.model))
    }

    fn end_here(&mut self) -> Result<(), Error> {
        if self.ended.is_none() {
            self.begin(STEPPED)?;
            self.close(Ok(()))?;
        }
        Ok(())
    }

    /// Begins the run if it has not begun. `driven` names inputs that the log does not contain; it may be empty.
    pub(super) fn begin(&mut self, driven: &str) -> Result<(), Error> {
        if let Some(over) = &self.ended {
            return Err(Error::Over(over.state.time));
        }
        if self.running.is_some() {
            return Ok(());
        }
        let settled = self.asked.settle(&self.model.loaded().simulation)?;
        let Assembled { state, counted, warnings } = self.started()?.clone();
        if let Some(motors) = motors_from(self.model.description(), &state, &self.held_at) {
            self.model = self.model.driven_by(motors);
        }
        let model = self.model.warned(warnings).holding(&self.held, state.time);
        #[cfg(feature = "log")]
        if let Some((path, options)) = &self.log {
            check_place(path)?;
            check_log(path, model.description(), self.begin + settled.duration, options)?;
        }
        let stepped = self.control.is_some() || self.efforts.is_some() || driven == STEPPED;
        let driven = match (&self.control, &self.efforts) {
            (Some(_), _) => "a controller of a program has driven it",
            (_, Some(_)) => "efforts of a program have driven it",
            _ if self.begin != 0.0 => WENT_ON,
            _ => driven,
        };
        let origin = self.origin(driven);
        let log = self.log.clone();
        let others = std::mem::take(&mut self.observers);
        let course = Course {
            kept: self.kept.clone(),
            interrupt: self.interrupt.clone(),
            others,
            stepped,
            aimed: self.aimed,
            figures: self.figures,
            efforts: self.efforts.as_deref(),
            log,
            origin,
            ..Course::new(model, settled, state, counted)
        };
        self.running = Some(Running::begin(course)?);
        Ok(())
    }

    /// The origin of this run, from which it can be made again.
    fn origin(&self, driven: &str) -> Origin {
        let Simulation { model, asked, kept, positions, velocities, .. } = self;
        let mut arguments = words(model.path(), model.world(), asked, kept, positions, velocities);
        match &self.log {
            Some((path, _)) => arguments.push(format!("--output={}", path.display())),
            None => arguments.push("--no-log".to_string()),
        }
        let command_line = format!("catena {}", arguments.join(" "));
        Origin { command_line, arguments, driven: (!driven.is_empty()).then(|| driven.to_string()), from_log: None }
    }

    /// Makes steps until `until` (s) or the end of the run, under the controller; an error ends the run.
    fn proceed(&mut self, until: f64) -> Result<(), Error> {
        let Simulation { model, running, control, begin, .. } = self;
        let running = running.as_mut().ok_or(Error::Over(*begin))?;
        match running.proceed(model, control.as_mut(), until) {
            Ok(()) => Ok(()),
            Err(error) => self.close(Err(error)),
        }
    }

    /// Ends the run, and completes its log.
    fn close(&mut self, ended: Result<(), Error>) -> Result<(), Error> {
        let Some(running) = self.running.take() else { return ended };
        let of_state = match (&self.control, &self.efforts) {
            (Some(control), _) => Some(control.of_state()),
            (None, Some(of_state)) => Some(&of_state[..]),
            _ => None,
        };
        let (finish, ended) = running.close(ended, of_state);
        self.ended = Some(finish);
        ended
    }
}

impl Drop for Simulation {
    /// A dropped run has a log that is complete up to there and says that the run was interrupted.
    fn drop(&mut self) {
        if self.running.is_some() {
            let time = self.time();
            let close = || self.close(Err(Error::Run(RunError::Interrupted { time })));
            // The error cannot be returned from `drop`. A second panic in a run that has panicked must not abort the process.
            let _ = std::panic::catch_unwind(std::panic::AssertUnwindSafe(close));
        }
    }
}
