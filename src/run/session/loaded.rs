//! A loaded model, and the state in which its run starts.

use crate::instant::start::assembly::{assemble_counted, assemble_on_closures, overlap_in_words};
use crate::instant::start::damped_points::{DECAY, rotors_of_dampers};
use crate::instant::start::gimbal_lock::leave_gimbal_lock;
use crate::instant::start::long_periods::long_periods;
use crate::lobatto::coupled::counted::Counted;
use crate::mechanism::description::nonsmooth::Motor;
use crate::mechanism::ground::words::{decimals, short};
use crate::mechanism::motion::energy::violation;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use crate::model::{Model, ModelError, Start};
use crate::output::report::{Numbers, joint_name, joint_reports};
use crate::scene::{SimulationSettings, Warning};
use crate::session::between_ticks::hold;
use crate::session::error::Error;
use crate::session::held_start::{HeldTargets, motors_from};
use std::collections::HashMap;
use std::sync::Arc;

/// A loaded model, its start, and the run settings of its file.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The model.
    pub model: Model,
    /// The start in the file.
    pub start: Start,
    /// The run settings of the file.
    pub simulation: SimulationSettings,
    /// The ranks of the closures at the start, once it is assembled.
    pub counted: Option<Arc<Counted>>,
}

/// A start that satisfies all loops.
#[derive(Clone, Debug)]
pub struct Assembled {
    /// The state.
    pub state: State,
    /// The ranks of the closures there, if there are closures.
    pub counted: Option<Arc<Counted>>,
    /// Warnings about changes of the start.
    pub warnings: Vec<Warning>,
}

/// Smaller changes of the start cause no warning [m, rad, m/s, rad/s].
const UNNOTICEABLE: f64 = 1e-9;

/// Most changed joints that a warning names.
const NAMED: usize = 3;

impl Loaded {
    /// A model with its start. Joints whose dampers move next to nothing there get rotors.
    pub(crate) fn new(model: Model, start: Start, simulation: SimulationSettings) -> Self {
        let mut loaded = Loaded { model, start, simulation, counted: None };
        if let Ok(state) = loaded.unassembled_state() {
            loaded.give_rotors(&state);
        }
        loaded
    }

    /// The start, moved to satisfy limits, loops and mimic relations. Changes become warnings of the model.
    ///
    /// # Errors
    /// As of [`Loaded::assembled`].
    pub fn initial_state(
        &mut self,
        positions: &[(String, Vec<f64>)],
        velocities: &[(String, Vec<f64>)],
        base_velocity: Option<[f64; 6]>,
    ) -> Result<State, Error> {
        let (given, wanted) = self.given(0.0, positions, velocities, base_velocity)?;
        self.model.leave_out_overlaps(&given);
        self.give_rotors(&given);
        let assembled = self.settled(given, &wanted)?;
        Ok(self.begun(assembled, &HeldTargets::new()))
    }

    /// A given state as the start, moved to satisfy limits, loops and mimic relations. Changes become warnings of the model. Motors hold their joints at the
    /// targets of the run before where they are known.
    ///
    /// # Errors
    /// As of [`Loaded::assembled`].
    pub fn settled_from(&mut self, state: State, known: &HeldTargets) -> Result<State, Error> {
        self.model.leave_out_overlaps(&state);
        self.give_rotors(&state);
        let assembled = self.settled(state, &Start::default())?;
        Ok(self.begun(assembled, known))
    }

    /// Lets sampled motors hold, from the start of a run on (s), what a log says, by the names of their joints.
    pub fn hold(&mut self, efforts: &HashMap<String, f64>, since: f64) {
        let motors = &self.model.mechanism.nonsmooth.motors;
        let of = |motor: &Motor| efforts.get(joint_name(&self.model, motor.coordinate.body)).copied();
        let efforts: Vec<Option<f64>> = motors.iter().map(of).collect();
        hold(&mut self.model.mechanism.nonsmooth.motors, &efforts, since);
    }

    /// Lets motors that hold their joints where a run starts hold them in this state, or at the targets of the run before where they are known.
    pub fn hold_start(&mut self, start: &State, known: &HeldTargets) {
        if let Some(motors) = motors_from(&self.model, start, known) {
            self.model.mechanism.nonsmooth.motors = motors;
        }
    }

    /// Gives rotors to joints whose dampers move next to nothing at the start.
    fn give_rotors(&mut self, start: &State) {
        let rotors = rotors_of_dampers(&self.model.mechanism, start);
        let Some(time) = rotors.first().map(|rotor| rotor.time) else { return };
        let names = rotors.iter().map(|rotor| {
            let unit = if self.model.mechanism.bodies[rotor.body].joint.kind.unit(0) == "m" { "kg" } else { "kg m²" };
            format!("{:?} {:.0e} {unit}", joint_name(&self.model, rotor.body), rotor.armature)
        });
        let message = format!(
            "dampers of joints have next to no inertia to move, because links are points of mass or have none: a motion of them decays in {time:.1e} s. \
             They got rotors, with which it takes {DECAY:.0e} s: {}; `armature` of a [[joint]] sets others",
            names.collect::<Vec<_>>().join(", ")
        );
        for rotor in &rotors {
            self.model.mechanism.bodies[rotor.body].joint.armature += rotor.armature;
        }
        self.model.warnings.push(Warning::odd(self.model.path(), None, None, message));
    }

    /// Takes the start and the known targets of motors into the model.
    fn begun(&mut self, Assembled { state, counted, warnings }: Assembled, known: &HeldTargets) -> State {
        self.counted = counted;
        self.hold_start(&state, known);
        self.model.warnings.extend(warnings);
        state
    }

    /// The start at time zero, moved to satisfy limits, loops and mimic relations, and warnings about the changes.
    ///
    /// # Errors
    /// As [`Loaded::unassembled_state`]; also if a joint is given twice, if a loop cannot be closed or the velocities contradict one, and if forces
    /// or energies are undefined or infinite there.
    pub fn assembled(
        &self,
        positions: &[(String, Vec<f64>)],
        velocities: &[(String, Vec<f64>)],
        base_velocity: Option<[f64; 6]>,
    ) -> Result<Assembled, Error> {
        let (given, wanted) = self.given(0.0, positions, velocities, base_velocity)?;
        self.settled(given, &wanted)
    }

    /// The state of such a start on its closures alone, past limits and through other shapes.
    ///
    /// # Errors
    /// As of [`Loaded::assembled`].
    pub(crate) fn assembled_on_closures(
        &self,
        positions: &[(String, Vec<f64>)],
        velocities: &[(String, Vec<f64>)],
    ) -> Result<State, Error> {
        let (mut state, _) = self.given(0.0, positions, velocities, None)?;
        let file = self.model.path();
        self.model.check_representable(&state).map_err(|error| Error::from(error).in_file(file))?;
        assemble_on_closures(&self.model.mechanism, &mut state).map_err(|error| Error::from(error).in_file(file))?;
        Ok(state)
    }

    /// The same at a time (s), at which joints that are moved in time are elsewhere.
    ///
    /// # Errors
    /// As of [`Loaded::assembled`].
    pub fn assembled_at(
        &self,
        time: f64,
        positions: &[(String, Vec<f64>)],
        velocities: &[(String, Vec<f64>)],
    ) -> Result<Assembled, Error> {
        let (given, wanted) = self.given(time, positions, velocities, None)?;
        self.settled(given, &wanted)
    }

    /// The start of the file, overridden by the given positions and velocities, without assembly.
    pub(crate) fn given(
        &self,
        time: f64,
        positions: &[(String, Vec<f64>)],
        velocities: &[(String, Vec<f64>)],
        base_velocity: Option<[f64; 6]>,
    ) -> Result<(State, Start), Error> {
        refuse_repeated("position", positions)?;
        refuse_repeated("velocity", velocities)?;
        let wanted = self.wanted(positions, velocities, base_velocity)?;
        let state = self.model.initial_state_at(time, &wanted.positions, &wanted.velocities, None)?;
        Ok((state, wanted))
    }

    /// A state, moved to satisfy limits, loops and mimic relations, and warnings about the changes from `wanted`.
    ///
    /// # Errors
    /// As of [`Loaded::assembled`].
    pub(crate) fn settled(&self, mut state: State, wanted: &Start) -> Result<Assembled, Error> {
        let file = self.model.path();
        let in_file = |error: Error| error.in_file(file);
        self.model.check_representable(&state).map_err(|error| in_file(error.into()))?;
        let given = state.clone();
        let mechanism = &self.model.mechanism;
        let (correction, counted) = assemble_counted(mechanism, &mut state).map_err(|error| in_file(error.into()))?;
        let unlocked = leave_gimbal_lock(mechanism, &mut state).map(|by| {
            format!(
                "the start is in gimbal lock, where links without mass leave rates of their joints undetermined: it was moved by {by:e} rad or m, and \
                 the motion is that of starts beside the lock"
            )
        });
        self.model.check_springs(&state).map_err(|error| in_file(error.into()))?;
        // A move by limits alone has another warning.
        let open = || violation(mechanism, &given, &body_states(mechanism, &given)).position > UNNOTICEABLE;
        let apart = correction.overlap.and_then(|(number, depth)| {
            let [words, _] = overlap_in_words(mechanism, number, depth)?;
            Some(format!(
                "{words}: initial positions were adjusted to it, by up to {:.1e} rad or m",
                correction.position
            ))
        });
        let moved = mechanism.has_closures()
            && ((correction.position > UNNOTICEABLE && open())
                // The others take their velocities from joints that are moved in time.
                || (correction.velocity > UNNOTICEABLE && !mechanism.moves_joints()));
        let onto_loops = moved.then(|| {
            let part =
                |what: &str, most: f64, unit: &str| (most > 0.0).then(|| format!("{what} by up to {most:.1e} {unit}"));
            let parts = [
                part("positions", correction.position, "rad or m"),
                part("velocities", correction.velocity, "rad/s or m/s"),
            ];
            let parts: Vec<String> = parts.into_iter().flatten().collect();
            format!("the start was adjusted to close the loops: {}{}", parts.join(", "), self.moved(wanted, &state))
        });
        let warning = |message: String| Warning::odd(file, None, None, message);
        let mut warnings: Vec<Warning> = onto_loops.into_iter().chain(apart).chain(unlocked).map(warning).collect();
        warnings.extend(self.model.moved_in_warning(&given, &state));
        warnings.extend(self.model.locked_warning(&given));
        warnings.extend(self.model.limit_warning(&state));
        warnings.extend(self.long_periods(&state).map(warning));
        Ok(Assembled { state, counted, warnings })
    }

    /// Motors that hold their efforts for so long that the motion grows.
    fn long_periods(&self, start: &State) -> impl Iterator<Item = String> {
        long_periods(&self.model.mechanism, start).into_iter().take(NAMED).map(|found| {
            format!(
                "motor on {:?}: it holds its effort for {} s, in which it more than reverses the motion that it damps, so that the motion grows, or chatters at \
                 the largest effort; at the start a period below {:.1e} s, a smaller kd or an armature of the joint avoids that",
                joint_name(&self.model, found.body),
                found.period,
                found.longest
            )
        })
    }

    /// The first joints with one coordinate that do not start as wanted, as the end of a sentence.
    fn moved(&self, wanted: &Start, state: &State) -> String {
        let unit = |joint: &str| {
            let record = self.model.joints.iter().find(|record| record.name == joint);
            let body = record.and_then(|record| record.body);
            body.map_or("", |body| self.model.mechanism.bodies[body].joint.kind.unit(0))
        };
        let reports = joint_reports(&self.model, state, &[]);
        let mut all = Vec::new();
        for (joint, report) in &reports {
            for (given, starts, per_second) in
                [(&wanted.positions, &report.position, ""), (&wanted.velocities, &report.velocity, "/s")]
            {
                // The last entry counts.
                let given = given.iter().rev().find(|(name, _)| name == joint).map(|(_, numbers)| numbers.as_slice());
                if let (Some(&[given]), &Numbers::One(starts)) = (given, starts)
                    && decimals(given) != decimals(starts)
                {
                    let (starts, given, unit) = (decimals(starts), short(given), unit(joint));
                    all.push(format!("; {joint} starts at {starts} {unit}{per_second}, not at {given}"));
                }
            }
        }
        all.truncate(NAMED);
        all.concat()
    }

    /// The start of the file without assembly. It may violate the loops.
    ///
    /// # Errors
    /// [`ModelError`] for joints that do not exist or do not move, and for wrong counts of numbers.
    pub fn unassembled_state(&self) -> Result<State, ModelError> {
        self.model.initial_state(&self.start.positions, &self.start.velocities, None)
    }

    /// The start of the file, overridden by the given positions and velocities.
    fn wanted(
        &self,
        positions: &[(String, Vec<f64>)],
        velocities: &[(String, Vec<f64>)],
        base_velocity: Option<[f64; 6]>,
    ) -> Result<Start, Error> {
        let mut wanted = self.start.clone();
        // The last entry counts.
        wanted.positions.extend_from_slice(positions);
        wanted.velocities.extend_from_slice(velocities);
        if let Some(velocity) = base_velocity {
            let only = self.model.only_robot().ok_or(Error::SeveralBases(self.model.robots.len()))?;
            // The velocity of the base is the velocity of its joint.
            let base = self.model.joints.iter().find(|joint| joint.is_base && joint.robot == only);
            let base = base.ok_or(ModelError::BaseDoesNotFloat)?;
            if velocities.iter().any(|(name, _)| *name == base.name) {
                return Err(Error::BaseVelocityTwice(base.name.clone()));
            }
            wanted.velocities.push((base.name.clone(), velocity.to_vec()));
        }
        Ok(wanted)
    }
}

/// Refuses two values for one joint, because it is unclear which one is meant.
fn refuse_repeated(option: &'static str, given: &[(String, Vec<f64>)]) -> Result<(), Error> {
    for (index, (joint, _)) in given.iter().enumerate() {
        if given[..index].iter().any(|(earlier, _)| earlier == joint) {
            return Err(Error::GivenTwice { option, joint: joint.clone() });
        }
    }
    Ok(())
}
