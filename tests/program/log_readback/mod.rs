//! The log, read back by the mcap crate and decoded by hand: what it says is what was simulated.

mod collision_shapes;
mod contacts;
mod events;
mod file;
mod layout;
mod messages;
mod ropes;

use crate::common::scratch;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::description::nonsmooth::Nonsmooth;
use catena::mechanism::forces::total::Exchange;
use catena::mechanism::motion::inputs::Inputs;
use catena::mechanism::motion::integrator::{Integrator, MethodDescription, StepError, StepOutcome};
use catena::mechanism::motion::state::State;
use catena::model::{Base, Model, ModelOptions};
use catena::output::log::{Ending, LogOptions, Recorder};
use catena::scene::{PackagePath, robot_from_text};
use catena::simulation::{Observer, ObserverError, RunOptions, Sample, run};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A turning and a sliding joint in general position, a fixed link, and links with and without mass and shape.
const URDF: &str = r#"<robot name="arm">
  <link name="base"><visual><geometry><box size="1 2 3"/></geometry></visual></link>
  <joint name="turn" type="continuous">
    <parent link="base"/><child link="upper"/><origin xyz="0.1 0.2 0.3" rpy="0.3 0.7 -0.2"/><axis xyz="0.6 0 0.8"/>
  </joint>
  <link name="upper">
    <inertial><origin xyz="0.1 0 0.3"/><mass value="2"/><inertia ixx="0.1" iyy="0.2" izz="0.25" ixy="0.01" ixz="0" iyz="0"/></inertial>
    <visual><origin xyz="0 0 1"/><geometry><sphere radius="0.5"/></geometry></visual>
  </link>
  <joint name="weld" type="fixed"><parent link="upper"/><child link="fused"/><origin xyz="0.4 0 0.1" rpy="1 0 0"/></joint>
  <link name="fused"/>
  <joint name="slide" type="prismatic">
    <parent link="fused"/><child link="slider"/><origin xyz="-0.3 0.1 0.2" rpy="0.1 0.2 0.3"/><axis xyz="0 0.6 -0.8"/>
    <limit lower="-9" upper="9" effort="1" velocity="1"/>
  </joint>
  <link name="slider">
    <inertial><origin xyz="0 0.2 0"/><mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <joint name="lost" type="continuous"><parent link="slider"/><child link="massless"/></joint>
  <link name="massless"/>
</robot>"#;

/// Every joint keeps its velocity: motion enough for a log, and exact.
struct Coasting {
    step: f64,
}

impl Integrator for Coasting {
    fn step(
        &mut self,
        mechanism: &Mechanism,
        _: Inputs,
        state: &mut State,
        until: f64,
    ) -> Result<StepOutcome, StepError> {
        let end = (state.time + self.step).min(until);
        let increment: Vec<f64> = state.velocity.iter().map(|rate| rate * (end - state.time)).collect();
        state.displace(mechanism, &increment);
        let step = end - state.time;
        state.time = end;
        Ok(StepOutcome::new(step, 1, Exchange::default()))
    }

    fn dense(&mut self, _: &Mechanism, time: f64, position: &mut [f64], velocity: &mut [f64]) {
        velocity.copy_from_slice(&VELOCITY);
        position[0] = VELOCITY[0] * time;
        position[1] = VELOCITY[1] * time;
    }

    fn description(&self) -> MethodDescription {
        MethodDescription::fixed("coasting", 1, 1, self.step)
    }
}

const VELOCITY: [f64; 2] = [1.25, -0.5];

fn model_of(urdf: &str, base: Base) -> Model {
    let robot = robot_from_text(urdf, Path::new("folder/arm.urdf"), &PackagePath::default()).expect("a robot");
    Model::new(robot, &ModelOptions { base, ..ModelOptions::default() }).expect("a model")
}

/// The arm, smooth: its slide never gets near its limits.
fn arm() -> Model {
    let mut model = model_of(URDF, Base::Fixed);
    model.mechanism.nonsmooth = Nonsmooth::default();
    model
}

fn simulation() -> BTreeMap<String, String> {
    BTreeMap::from([("robot".to_string(), "arm".to_string())])
}

/// The bytes of a log of `duration` seconds, with steps of 0.05 s that do not fit the samples.
fn log(name: &str, duration: f64) -> Vec<u8> {
    log_seen_by(name, duration, &mut Onlooker { path: None, seen: 0 })
}

fn log_seen_by(name: &str, duration: f64, onlooker: &mut Onlooker) -> Vec<u8> {
    let path = scratch("log").join(name);
    let model = arm();
    let mut state = model.zero_state();
    state.velocity.copy_from_slice(&VELOCITY);
    let mut recorder =
        Recorder::create(&path, &model, simulation(), &LogOptions::default()).expect("the log is created");
    let options = RunOptions { duration, rate: Some(60.0), interrupt: None };
    let (_, ended) =
        run(&model.mechanism, &mut state, &mut Coasting { step: 0.05 }, &options, &mut [&mut recorder, onlooker]);
    ended.expect("nothing can fail");
    recorder.finish(Ending::default()).expect("the log is completed");
    std::fs::read(&path).expect("the log is readable")
}

fn messages(bytes: &[u8]) -> Vec<mcap::Message<'_>> {
    mcap::MessageStream::new(bytes).expect("a log").collect::<Result<_, _>>().expect("every message is readable")
}

fn of_topic<'m>(messages: &'m [mcap::Message<'m>], topic: &str) -> Vec<&'m mcap::Message<'m>> {
    messages.iter().filter(|message| message.channel.topic == topic).collect()
}

/// Looks at the log while it is written, after a pause in the middle of a chunk.
struct Onlooker {
    /// `None` when there is nothing to look at, or it has been looked at.
    path: Option<PathBuf>,
    seen: usize,
}

impl Observer for Onlooker {
    fn sample(&mut self, sample: &Sample) -> Result<(), ObserverError> {
        let Some(path) = self.path.clone() else { return Ok(()) };
        if sample.time == 0.5 {
            std::thread::sleep(std::time::Duration::from_millis(1100));
        } else if sample.time > 0.5 {
            self.path = None;
            // The log is written by another thread; it gets all the time it may need.
            for _ in 0..100 {
                self.seen = readable_transforms(&path)?;
                if self.seen >= 31 {
                    break;
                }
                std::thread::sleep(std::time::Duration::from_millis(100));
            }
        }
        Ok(())
    }
}

/// Samples in a log that need not be complete.
fn readable_transforms(path: &Path) -> Result<usize, ObserverError> {
    let bytes = std::fs::read(path)?;
    let stream = mcap::MessageStream::new_with_options(&bytes, mcap::read::Options::IgnoreEndMagic.into())?;
    let messages: Vec<mcap::Message> = stream.map_while(Result::ok).collect();
    Ok(of_topic(&messages, "/tf").len())
}
