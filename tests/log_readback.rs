//! The log, read back by the mcap crate and decoded by hand: what it says is what was simulated.

use catena::kinematics::{WORLD, forward_kinematics};
use catena::log::{LinkFrame, LogSetup, Recorder, Severity};
use catena::model::{Body, Joint, JointKind, Mechanism, Pose, joint::rotation_from_wxyz};
use catena::scene::{PackagePath, Robot, robot_from_text};
use catena::simulation::{
    Integrator, MethodDescription, Observer, ObserverError, RunOptions, Sample, StepError, StepOutcome, run,
};
use catena::state::State;
use foxglove::Decode;
use foxglove::messages::{FrameTransforms, Log, SceneUpdate};
use nalgebra::{Matrix3, Rotation3, Translation3, Vector3};
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

const URDF: &str = r#"<robot name="arm">
  <joint name="upper_joint" type="continuous"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/></joint>
  <link name="base"><visual><geometry><box size="1 2 3"/></geometry></visual></link>
  <link name="upper"><visual><origin xyz="0 0 1"/><geometry><sphere radius="0.5"/></geometry></visual></link>
</robot>"#;

/// Every joint keeps its velocity: motion enough for a log, and exact.
struct Coasting {
    step: f64,
}

impl Integrator for Coasting {
    fn advance(&mut self, mechanism: &Mechanism, state: &mut State, until: f64) -> Result<StepOutcome, StepError> {
        let end = (state.time + self.step).min(until);
        let increment: Vec<f64> = state.velocity.iter().map(|rate| rate * (end - state.time)).collect();
        state.displace(mechanism, &increment);
        let step = end - state.time;
        state.time = end;
        Ok(StepOutcome { step, iterations: 1, rejected: 0 })
    }

    fn dense(&self, _: &Mechanism, time: f64, position: &mut [f64], velocity: &mut [f64]) {
        velocity.copy_from_slice(&VELOCITY);
        position[0] = VELOCITY[0] * time;
        position[1] = VELOCITY[1] * time;
    }

    fn description(&self) -> MethodDescription {
        MethodDescription {
            name: "coasting".into(),
            stages: 1,
            order: 1,
            step: self.step,
            adaptive: false,
            tolerance: None,
        }
    }
}

const VELOCITY: [f64; 2] = [1.25, -0.5];

/// A turning and a sliding joint in general position.
fn arm() -> Mechanism {
    let tilted = |x: f64, y: f64, z: f64| {
        Pose::from_parts(Translation3::new(x, y, z), Rotation3::from_euler_angles(0.3 * x, 0.7 + y, -z))
    };
    let body = |name: &str, parent, kind| Body {
        name: name.to_string(),
        parent,
        mass: 2.0,
        inertia: Vector3::new(0.1, 0.2, 0.25),
        joint: Joint::new(&format!("{name}_joint"), kind, tilted(0.1, 0.2, 0.3), tilted(-0.3, 0.1, 0.2)),
    };
    let bodies = vec![body("upper", None, JointKind::Revolute), body("slider", Some(0), JointKind::Prismatic)];
    Mechanism::new("arm", Vector3::new(0.0, 0.0, -9.81), bodies).expect("a tree")
}

fn links() -> Vec<LinkFrame> {
    let pose = Pose::from_parts(Translation3::new(0.5, -0.25, 0.125), Rotation3::from_euler_angles(0.1, 0.2, 0.3));
    let link = |name: &str, body| LinkFrame { name: name.to_string(), body, pose };
    vec![link("base", None), link("upper", Some(0)), link("fused", Some(0)), link("slider", Some(1))]
}

fn robot() -> Robot {
    robot_from_text(URDF, Path::new("folder/arm.urdf"), &PackagePath::from_environment(Vec::new())).expect("a robot")
}

fn setup(robot: &Robot) -> LogSetup<'_> {
    LogSetup {
        simulation: BTreeMap::from([("robot".to_string(), "arm".to_string())]),
        robot: Some(robot),
        links: links(),
        warnings: vec!["something was left out".to_string()],
    }
}

fn temporary(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name)
}

/// The bytes of a log of `duration` seconds, with steps of 0.05 s that do not fit the samples.
fn log(name: &str, duration: f64) -> Vec<u8> {
    log_seen_by(name, duration, &mut Onlooker { path: PathBuf::new(), seen: usize::MAX })
}

fn log_seen_by(name: &str, duration: f64, onlooker: &mut Onlooker) -> Vec<u8> {
    let path = temporary(name);
    let mechanism = arm();
    let mut state = State::zero(&mechanism);
    state.velocity.copy_from_slice(&VELOCITY);
    let mut recorder = Recorder::create(&path, &mechanism, &setup(&robot())).expect("the log is created");
    let options = RunOptions { duration, rate: Some(60.0), interrupt: None };
    let (_, ended) =
        run(&mechanism, &mut state, &mut Coasting { step: 0.05 }, &options, &mut [&mut recorder, onlooker]);
    ended.expect("nothing can fail");
    recorder.finish().expect("the log is completed");
    std::fs::read(&path).expect("the log is readable")
}

fn messages(bytes: &[u8]) -> Vec<mcap::Message<'_>> {
    mcap::MessageStream::new(bytes).expect("a log").collect::<Result<_, _>>().expect("every message is readable")
}

fn of_topic<'m>(messages: &'m [mcap::Message<'m>], topic: &str) -> Vec<&'m mcap::Message<'m>> {
    messages.iter().filter(|message| message.channel.topic == topic).collect()
}

/// Reads CDR independently of the writer.
struct Cdr<'d> {
    data: &'d [u8],
    at: usize,
}

impl<'d> Cdr<'d> {
    fn new(message: &'d mcap::Message) -> Self {
        assert_eq!(message.data[..4], [0, 1, 0, 0], "little-endian CDR");
        Cdr { data: &message.data[4..], at: 0 }
    }

    fn take<const N: usize>(&mut self) -> [u8; N] {
        self.at = self.at.next_multiple_of(N);
        self.at += N;
        self.data[self.at - N..self.at].try_into().expect("N bytes")
    }

    fn unsigned(&mut self) -> u32 {
        u32::from_le_bytes(self.take())
    }

    fn string(&mut self) -> String {
        let length = self.unsigned() as usize;
        let bytes = &self.data[self.at..self.at + length];
        self.at += length;
        assert_eq!(bytes[length - 1], 0, "strings end with NUL");
        String::from_utf8(bytes[..length - 1].to_vec()).expect("UTF-8")
    }

    fn doubles(&mut self) -> Vec<f64> {
        (0..self.unsigned()).map(|_| f64::from_le_bytes(self.take())).collect()
    }

    fn strings(&mut self) -> Vec<String> {
        (0..self.unsigned()).map(|_| self.string()).collect()
    }

    fn assert_ended(&self) {
        assert_eq!(self.at, self.data.len(), "nothing is left over");
    }
}

#[test]
fn every_channel_has_a_schema_and_the_run_is_described() {
    let bytes = log("schemas.mcap", 1.0);
    let summary = mcap::Summary::read(&bytes).expect("a complete log").expect("with a summary");
    let schemas: HashMap<&str, (&str, &str)> = summary
        .channels
        .values()
        .map(|channel| {
            let schema = channel.schema.as_ref().expect("PlotJuggler skips channels without a schema");
            assert!(!schema.data.is_empty());
            (channel.topic.as_str(), (schema.name.as_str(), channel.message_encoding.as_str()))
        })
        .collect();
    let expected = [
        ("/robot_description", ("std_msgs/msg/String", "cdr")),
        ("/scene", ("foxglove.SceneUpdate", "protobuf")),
        ("/log", ("foxglove.Log", "protobuf")),
        ("/tf", ("foxglove.FrameTransforms", "protobuf")),
        ("/joint_states", ("sensor_msgs/msg/JointState", "cdr")),
        ("/energy", ("std_msgs/msg/Float64MultiArray", "cdr")),
        ("/constraint", ("std_msgs/msg/Float64MultiArray", "cdr")),
    ];
    assert_eq!(schemas, HashMap::from(expected));
    let metadata = mcap::read::metadata(&bytes, &summary.metadata_indexes[0]).expect("metadata");
    assert_eq!((metadata.name.as_str(), metadata.metadata["robot"].as_str()), ("simulation", "arm"));
    let attachment = mcap::read::attachment(&bytes, &summary.attachment_indexes[0]).expect("an attachment");
    assert_eq!((attachment.name.as_str(), &*attachment.data), ("arm.urdf", URDF.as_bytes()));
}

#[test]
fn what_is_known_at_the_start_is_in_the_log() {
    let bytes = log("start.mcap", 1.0);
    let messages = messages(&bytes);
    let mut description = Cdr::new(of_topic(&messages, "/robot_description")[0]);
    assert_eq!(description.string(), robot().description);
    description.assert_ended();
    let warning = Log::decode(&*of_topic(&messages, "/log")[0].data).expect("a log line");
    assert_eq!(warning.message, "something was left out");
    let scene = SceneUpdate::decode(&*of_topic(&messages, "/scene")[0].data).expect("a scene");
    let names: Vec<&str> = scene.entities.iter().map(|entity| entity.frame_id.as_str()).collect();
    assert_eq!(names, ["base", "upper"]);
    assert_eq!(scene.entities[1].spheres[0].size.expect("a size").x, 1.0);
    assert_eq!(scene.entities[1].spheres[0].pose.expect("a pose").position.expect("a position").z, 1.0);
}

#[test]
fn times_never_go_back_and_samples_are_at_the_rate() {
    let bytes = log("times.mcap", 2.0);
    let messages = messages(&bytes);
    let times: Vec<u64> = messages.iter().map(|message| message.log_time).collect();
    assert!(times.is_sorted(), "{times:?}");
    assert!(messages.iter().all(|message| message.publish_time == message.log_time));
    for topic in ["/tf", "/joint_states"] {
        let times: Vec<u64> = of_topic(&messages, topic).iter().map(|message| message.log_time).collect();
        let expected: Vec<u64> = (0..=120_u64).map(|k| (k as f64 / 60.0 * 1e9).round() as u64).collect();
        assert_eq!(times, expected, "{topic}");
    }
}

/// Steps are 0.05 s and samples 1/60 s apart, so every step is seen, once, at its own end.
#[test]
fn energy_is_logged_once_a_step_at_the_end_of_the_step() {
    let bytes = log("energy.mcap", 1.0);
    let messages = messages(&bytes);
    let mechanism = arm();
    for (index, message) in of_topic(&messages, "/energy").into_iter().enumerate() {
        let time = message.log_time as f64 * 1e-9;
        assert!((time - 0.05 * index as f64).abs() < 1e-9, "{index}: {time}");
        let mut cdr = Cdr::new(message);
        assert_eq!((cdr.unsigned(), cdr.string().as_str()), (1, "kinetic, potential, total [J]"));
        assert_eq!([cdr.unsigned(), cdr.unsigned(), cdr.unsigned()], [3, 3, 0]);
        let figures = cdr.doubles();
        cdr.assert_ended();
        let mut bodies = [WORLD; 2];
        forward_kinematics(&mechanism, &VELOCITY.map(|rate| rate * time), &VELOCITY, &mut bodies);
        let energy = catena::invariants::energy(&mechanism, &bodies);
        for (logged, expected) in figures.iter().zip([energy.kinetic, energy.potential, energy.total()]) {
            assert!((logged - expected).abs() < 1e-7, "{index}: {logged} {expected}");
        }
    }
    assert_eq!(of_topic(&messages, "/energy").len(), 21);
    assert_eq!(of_topic(&messages, "/constraint").len(), 21);
}

#[test]
fn poses_are_the_forward_kinematics_of_the_logged_joint_states() {
    let bytes = log("poses.mcap", 2.0);
    let messages = messages(&bytes);
    let mechanism = arm();
    let states = of_topic(&messages, "/joint_states");
    for (state, transforms) in states.into_iter().zip(of_topic(&messages, "/tf")) {
        let mut cdr = Cdr::new(state);
        let stamp = u64::from(cdr.unsigned()) * 1_000_000_000 + u64::from(cdr.unsigned());
        assert_eq!(stamp, state.log_time);
        assert_eq!(cdr.string(), "");
        assert_eq!(cdr.strings(), ["upper_joint", "slider_joint"]);
        let (position, velocity, effort) = (cdr.doubles(), cdr.doubles(), cdr.doubles());
        cdr.assert_ended();
        assert_eq!((velocity.as_slice(), effort.as_slice()), (&VELOCITY[..], &[][..]));
        let mut bodies = [WORLD; 2];
        forward_kinematics(&mechanism, &position, &velocity, &mut bodies);
        let logged = FrameTransforms::decode(&*transforms.data).expect("transforms");
        assert_eq!(logged.transforms.len(), links().len());
        for (link, transform) in links().iter().zip(&logged.transforms) {
            assert_eq!((&*transform.parent_frame_id, &transform.child_frame_id), ("world", &link.name));
            assert_eq!(transform.timestamp.expect("a stamp").total_nanos(), state.log_time);
            let body = link.body.map_or(WORLD, |body| bodies[body]);
            let translation = transform.translation.expect("a translation");
            let expected = body.position + body.rotation * link.pose.translation.vector;
            assert!((Vector3::new(translation.x, translation.y, translation.z) - expected).amax() < 1e-14);
            let q = transform.rotation.expect("a rotation");
            let norm = (q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z).sqrt();
            assert!((norm - 1.0).abs() < 1e-12, "{norm}");
            let expected: Matrix3<f64> = body.rotation * link.pose.rotation.matrix();
            assert!((rotation_from_wxyz(&[q.w, q.x, q.y, q.z]) - expected).amax() < 1e-14);
        }
    }
}

#[test]
fn a_link_that_is_the_world_frame_has_no_transform_and_a_moving_one_no_loop() {
    let mechanism = arm();
    for (body, parents) in [(None, vec![]), (Some(0), vec!["simulation_world"])] {
        let path = temporary("world.mcap");
        let link = LinkFrame { name: "world".to_string(), body, pose: Pose::identity() };
        let setup = LogSetup { links: vec![link], ..LogSetup::default() };
        let mut recorder = Recorder::create(&path, &mechanism, &setup).expect("the log is created");
        let options = RunOptions { duration: 0.1, rate: None, interrupt: None };
        let mut state = State::zero(&mechanism);
        run(&mechanism, &mut state, &mut Coasting { step: 0.1 }, &options, &mut [&mut recorder]).1.expect("it runs");
        recorder.finish().expect("the log is completed");
        let bytes = std::fs::read(&path).expect("the log is readable");
        let messages = messages(&bytes);
        let transforms = FrameTransforms::decode(&*of_topic(&messages, "/tf")[0].data).expect("transforms");
        let found: Vec<&str> = transforms.transforms.iter().map(|frame| frame.parent_frame_id.as_str()).collect();
        assert_eq!(found, parents);
    }
}

/// Long enough for several chunks.
#[test]
fn the_same_run_gives_the_same_bytes() {
    let first = log("first.mcap", 60.0);
    let chunks = mcap::Summary::read(&first).expect("complete").expect("with a summary").chunk_indexes;
    assert!(chunks.len() >= 3, "{} chunks", chunks.len());
    assert!(chunks.iter().all(|chunk| chunk.uncompressed_size <= 1 << 20), "{chunks:?}");
    assert!(first == log("second.mcap", 60.0));
}

/// Looks at the log while it is written, after a pause in the middle of a chunk.
struct Onlooker {
    path: PathBuf,
    seen: usize,
}

impl Observer for Onlooker {
    fn sample(&mut self, sample: &Sample) -> Result<(), ObserverError> {
        if self.seen == usize::MAX {
            return Ok(());
        }
        if sample.time == 0.5 {
            std::thread::sleep(std::time::Duration::from_millis(1100));
        } else if sample.time > 0.5 && self.seen == 0 {
            // The log is written by another thread; it gets all the time it may need.
            for _ in 0..100 {
                self.seen = readable_transforms(&self.path)?;
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

/// What a killed run leaves behind is what is in the file at that time.
#[test]
fn all_but_the_last_second_is_readable_before_the_log_is_complete_and_leaves_no_trace() {
    let path = temporary("onlooker.mcap");
    let mut onlooker = Onlooker { path: path.clone(), seen: 0 };
    let bytes = log_seen_by("onlooker.mcap", 60.0, &mut onlooker);
    // 31 samples up to t = 0.5 s, and the one after the pause.
    assert_eq!(onlooker.seen, 32);
    assert!(bytes == log("undisturbed.mcap", 60.0));
}

#[test]
fn what_ended_a_run_is_the_last_line_of_the_log() {
    let path = temporary("ended.mcap");
    let mut recorder = Recorder::create(&path, &arm(), &setup(&robot())).expect("the log is created");
    recorder.say(Severity::Error, "it broke");
    recorder.finish().expect("the log is completed");
    let bytes = std::fs::read(&path).expect("the log is readable");
    let messages = messages(&bytes);
    let last = Log::decode(&*of_topic(&messages, "/log")[1].data).expect("a log line");
    assert_eq!((last.message.as_str(), last.level), ("it broke", 4));
}
