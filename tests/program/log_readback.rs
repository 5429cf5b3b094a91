//! The log, read back by the mcap crate and decoded by hand: what it says is what was simulated.

use catena::kinematics::{WORLD, forward_kinematics};
use catena::log::{Ending, Recorder, Severity};
use catena::model::{Base, Mechanism, Model, ModelOptions, joint::rotation_from_wxyz};
use catena::scene::{PackagePath, robot_from_text};
use catena::simulation::{
    Integrator, MethodDescription, Observer, ObserverError, RunOptions, Sample, StepError, StepOutcome, run,
};
use catena::state::State;
use foxglove::Decode;
use foxglove::messages::{FrameTransforms, Log, SceneUpdate};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use nalgebra::{UnitQuaternion, Vector3};
use std::collections::{BTreeMap, HashMap};
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
    fn advance(&mut self, mechanism: &Mechanism, state: &mut State, until: f64) -> Result<StepOutcome, StepError> {
        let end = (state.time + self.step).min(until);
        let increment: Vec<f64> = state.velocity.iter().map(|rate| rate * (end - state.time)).collect();
        state.displace(mechanism, &increment);
        let step = end - state.time;
        state.time = end;
        Ok(StepOutcome { step, iterations: 1, ..StepOutcome::default() })
    }

    fn dense(&mut self, _: &Mechanism, time: f64, position: &mut [f64], velocity: &mut [f64]) {
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
            frequency_step: None,
            ringing: None,
            singular: None,
            digits: 16,
            reversible_resets: None,
        }
    }
}

const VELOCITY: [f64; 2] = [1.25, -0.5];

fn model_of(urdf: &str, base: Base) -> Model {
    let robot = robot_from_text(urdf, Path::new("folder/arm.urdf"), &PackagePath::default()).expect("a robot");
    Model::new(robot, &ModelOptions { base, ..ModelOptions::default() }).expect("a model")
}

fn arm() -> Model {
    model_of(URDF, Base::Fixed)
}

fn simulation() -> BTreeMap<String, String> {
    BTreeMap::from([("robot".to_string(), "arm".to_string())])
}

fn temporary(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name)
}

/// The bytes of a log of `duration` seconds, with steps of 0.05 s that do not fit the samples.
fn log(name: &str, duration: f64) -> Vec<u8> {
    log_seen_by(name, duration, &mut Onlooker { path: None, seen: 0 })
}

fn log_seen_by(name: &str, duration: f64, onlooker: &mut Onlooker) -> Vec<u8> {
    let path = temporary(name);
    let model = arm();
    let mut state = model.zero_state();
    state.velocity.copy_from_slice(&VELOCITY);
    let mut recorder = Recorder::create(&path, &model, simulation()).expect("the log is created");
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
        ("/solver", ("std_msgs/msg/Float64MultiArray", "cdr")),
        ("/reactions", ("sensor_msgs/msg/MultiDOFJointState", "cdr")),
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
    let described = description.string();
    description.assert_ended();
    let robot = robot_from_text(&described, Path::new("described.urdf"), &PackagePath::default()).expect("a robot");
    let mut expected = arm().robots[0].robot.clone();
    let slider = robot.link("slider").expect("a slider");
    assert_eq!(robot.links[slider].visuals.len(), 1, "its stand-in is in the description too");
    expected.links[slider].visuals.clone_from(&robot.links[slider].visuals);
    let looks = |robot: &catena::scene::Robot| robot.links.iter().map(|link| link.visuals.len()).collect::<Vec<_>>();
    assert_eq!(looks(&robot), looks(&expected));
    let warning = Log::decode(&*of_topic(&messages, "/log")[0].data).expect("a log line");
    assert_eq!(warning.message, arm().warnings[0].to_string());
    let scene = SceneUpdate::decode(&*of_topic(&messages, "/scene")[0].data).expect("a scene");
    let names: Vec<&str> = scene.entities.iter().map(|entity| entity.frame_id.as_str()).collect();
    // The slider has mass and no looks: it gets the box of its inertia, 0.1 kg m² about every axis.
    assert_eq!(names, ["base", "upper", "slider"]);
    let size = scene.entities[2].cubes[0].size.expect("a size");
    assert!([size.x, size.y, size.z].iter().all(|edge| (edge - 0.6_f64.sqrt()).abs() < 1e-12), "{size:?}");
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
    let mechanism = arm().mechanism;
    for (index, message) in of_topic(&messages, "/energy").into_iter().enumerate() {
        let time = message.log_time as f64 * 1e-9;
        assert!((time - 0.05 * index as f64).abs() < 1e-9, "{index}: {time}");
        let mut cdr = Cdr::new(message);
        assert_eq!(
            (cdr.unsigned(), cdr.string().as_str()),
            (1, "kinetic, potential, total; since the start: dissipated, work put in [J]")
        );
        assert_eq!([cdr.unsigned(), cdr.unsigned(), cdr.unsigned()], [5, 5, 0]);
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
    let model = arm();
    let states = of_topic(&messages, "/joint_states");
    for (state, transforms) in states.into_iter().zip(of_topic(&messages, "/tf")) {
        let mut cdr = Cdr::new(state);
        let stamp = u64::from(cdr.unsigned()) * 1_000_000_000 + u64::from(cdr.unsigned());
        assert_eq!(stamp, state.log_time);
        assert_eq!(cdr.string(), "");
        assert_eq!(cdr.strings(), ["turn", "slide"]);
        let (position, velocity, effort) = (cdr.doubles(), cdr.doubles(), cdr.doubles());
        cdr.assert_ended();
        assert_eq!(velocity, VELOCITY);
        // Nothing drives the joints: what is left along their axes is the rounding of torques of some 30 N m.
        assert!(effort.len() == 2 && effort.iter().all(|effort| effort.abs() < 1e-12), "{effort:?}");
        let mut bodies = [WORLD; 2];
        forward_kinematics(&model.mechanism, &position, &velocity, &mut bodies);
        let logged = FrameTransforms::decode(&*transforms.data).expect("transforms");
        assert_eq!(logged.transforms.len(), 5, "every link of the URDF, also those that are no bodies");
        for (index, transform) in logged.transforms.iter().enumerate() {
            assert_eq!((&*transform.parent_frame_id, &transform.child_frame_id), ("world", &model.links[index].name));
            assert_eq!(transform.timestamp.expect("a stamp").total_nanos(), state.log_time);
            let (position, rotation) = model.link_pose(&bodies, index);
            let translation = transform.translation.expect("a translation");
            assert!((Vector3::new(translation.x, translation.y, translation.z) - position).amax() < 1e-14);
            let q = transform.rotation.expect("a rotation");
            let norm = (q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z).sqrt();
            assert!((norm - 1.0).abs() < 1e-12, "{norm}");
            assert!((rotation_from_wxyz(&[q.w, q.x, q.y, q.z]) - rotation).amax() < 1e-14);
        }
    }
}

#[test]
fn reactions_are_those_of_the_report() {
    let bytes = log("reactions.mcap", 1.0);
    let messages = messages(&bytes);
    let model = arm();
    for message in of_topic(&messages, "/reactions") {
        let mut cdr = Cdr::new(message);
        let _stamp = (cdr.unsigned(), cdr.unsigned());
        assert_eq!((cdr.string(), cdr.strings()), ("world".to_string(), vec!["turn".to_string(), "slide".to_string()]));
        assert_eq!(
            [cdr.unsigned(), cdr.unsigned(), cdr.unsigned()],
            [0, 0, 2],
            "no transforms, no twists, two wrenches"
        );
        let mut state = model.zero_state();
        let time = message.log_time as f64 * 1e-9;
        state.position.copy_from_slice(&VELOCITY.map(|rate| rate * time));
        state.velocity.copy_from_slice(&VELOCITY);
        for (name, report) in catena::report::joint_reports(&model, &state) {
            let expected = [report.reaction_force, report.reaction_torque].concat();
            for expected in expected {
                let logged = f64::from_le_bytes(cdr.take());
                // The times of log and samples differ by half a nanosecond, at rates of some 100 N/s.
                assert!((logged - expected).abs() < 1e-6, "{name} at {time}: {logged} {expected}");
            }
        }
        cdr.assert_ended();
    }
}

/// A floating base and a ball: their logged transforms place the links as `/tf` does.
#[test]
fn joints_of_several_numbers_are_logged_as_transforms_and_twists() {
    let path = temporary("floating.mcap");
    let inertial = r#"<inertial><origin xyz="0.1 0.2 0"/><mass value="2"/>
        <inertia ixx="0.1" iyy="0.2" izz="0.25" ixy="0.01" ixz="0" iyz="0"/></inertial>"#;
    let urdf = format!(
        r#"<robot name="r"><link name="base">{inertial}</link><link name="arm">{inertial}</link>
        <joint name="ball" type="spherical"><parent link="base"/><child link="arm"/><origin xyz="1 2 3" rpy="1 0 0"/></joint>
        </robot>"#
    );
    let model = model_of(&urdf, Base::Floating);
    let name = model.joints[0].name.clone();
    let positions = [(name.clone(), vec![1.0, 2.0, 3.0, 0.1, 0.2, 0.3]), ("ball".to_string(), vec![0.4, 0.5, 0.6])];
    let velocities = [(name.clone(), vec![1.0, -2.0, 3.0, 4.0, -5.0, 6.0]), ("ball".to_string(), vec![7.0, 8.0, 9.0])];
    let mut state = model.initial_state(&positions, &velocities, None).expect("the joints exist");
    let mut recorder = Recorder::create(&path, &model, simulation()).expect("the log is created");
    let options = RunOptions { duration: 1e-9, rate: None, interrupt: None };
    let (_, ended) = run(&model.mechanism, &mut state, &mut Coasting { step: 1.0 }, &options, &mut [&mut recorder]);
    ended.expect("nothing can fail");
    recorder.finish(Ending::default()).expect("the log is completed");
    let bytes = std::fs::read(&path).expect("the log is readable");
    let messages = messages(&bytes);
    let mut cdr = Cdr::new(of_topic(&messages, "/multi_dof_joint_states")[0]);
    let _stamp = (cdr.unsigned(), cdr.unsigned());
    assert_eq!((cdr.string(), cdr.strings()), (String::new(), vec![name, "ball".to_string()]));
    assert_eq!(cdr.unsigned(), 2);
    let mut numbers = |count: usize| (0..count).map(|_| f64::from_le_bytes(cdr.take())).collect::<Vec<f64>>();
    let near = |got: &[f64], expected: &[f64]| {
        let worst = got.iter().zip(expected).map(|(got, expected)| (got - expected).abs()).fold(0.0, f64::max);
        assert!(got.len() == expected.len() && worst < 1e-14, "{got:?} is not {expected:?}");
    };
    let turn = |roll, pitch, yaw| UnitQuaternion::from_euler_angles(roll, pitch, yaw).coords;
    near(&numbers(7), &[&[1.0, 2.0, 3.0], turn(0.1, 0.2, 0.3).as_slice()].concat());
    near(&numbers(7), &[&[0.0, 0.0, 0.0], turn(0.4, 0.5, 0.6).as_slice()].concat());
    assert_eq!(cdr.unsigned(), 2);
    let mut numbers = |count: usize| (0..count).map(|_| f64::from_le_bytes(cdr.take())).collect::<Vec<f64>>();
    near(&numbers(6), &velocities[0].1);
    near(&numbers(6), &[&[0.0, 0.0, 0.0], &velocities[1].1[..]].concat());
    assert_eq!(cdr.unsigned(), 0, "no wrenches");
    cdr.assert_ended();
}

/// Viewers refuse a frame that is its own parent.
#[test]
fn a_link_that_is_the_world_frame_has_no_transform() {
    let path = temporary("world.mcap");
    let model = model_of(&URDF.replace("\"base\"", "\"world\""), Base::Fixed);
    let mut recorder = Recorder::create(&path, &model, simulation()).expect("the log is created");
    let options = RunOptions { duration: 0.1, rate: None, interrupt: None };
    let mut state = model.zero_state();
    let (_, ended) = run(&model.mechanism, &mut state, &mut Coasting { step: 0.1 }, &options, &mut [&mut recorder]);
    ended.expect("nothing can fail");
    recorder.finish(Ending::default()).expect("the log is completed");
    let bytes = std::fs::read(&path).expect("the log is readable");
    let messages = messages(&bytes);
    let transforms = FrameTransforms::decode(&*of_topic(&messages, "/tf")[0].data).expect("transforms").transforms;
    let names: Vec<&str> = transforms.iter().map(|frame| frame.child_frame_id.as_str()).collect();
    assert_eq!(names, ["upper", "fused", "slider", "massless"]);
    assert!(transforms.iter().all(|frame| frame.parent_frame_id == "world"));
}

/// Long enough for several chunks.
#[test]
fn the_same_run_gives_the_same_bytes() {
    let first = log("first.mcap", 60.0);
    let chunks = mcap::Summary::read(&first).expect("complete").expect("with a summary").chunk_indexes;
    assert!(chunks.len() >= 3, "{} chunks", chunks.len());
    assert!(chunks.iter().all(|chunk| chunk.uncompressed_size <= 1 << 18), "{chunks:?}");
    assert!(first == log("second.mcap", 60.0));
}

#[test]
fn the_summary_leads_to_every_message_attachment_and_record_and_all_checksums_are_right() {
    let bytes = log("summary.mcap", 30.0);
    let summary = mcap::Summary::read(&bytes).expect("the checksum of the summary is right").expect("there is one");
    let statistics = summary.stats.as_ref().expect("there are statistics");
    let in_order = messages(&bytes);
    assert_eq!(statistics.message_count, in_order.len() as u64);
    assert_eq!((statistics.message_start_time, statistics.message_end_time), (0, 30_000_000_000));
    assert_eq!(statistics.chunk_count as usize, summary.chunk_indexes.len());
    for channel in summary.channels.values() {
        let count = of_topic(&in_order, &channel.topic).len() as u64;
        assert_eq!(statistics.channel_message_counts.get(&channel.id), Some(&count), "{}", channel.topic);
        assert!(channel.schema.is_some(), "{}", channel.topic);
    }
    let mut found = 0;
    for chunk in &summary.chunk_indexes {
        for (channel, entries) in summary.read_message_indexes(&bytes, chunk).expect("the index is where it should be")
        {
            for entry in entries {
                let message = summary.seek_message(&bytes, chunk, &entry).expect("a message is where the index says");
                assert_eq!((&message.channel.topic, message.log_time), (&channel.topic, entry.log_time));
                found += 1;
            }
        }
        // Reading a chunk to its end checks its checksum.
        for message in summary.stream_chunk(&bytes, chunk).expect("a chunk is where the index says") {
            let time = message.expect("the checksum of the chunk is right").log_time;
            assert!((chunk.message_start_time..=chunk.message_end_time).contains(&time));
        }
    }
    assert_eq!(found, in_order.len());
    assert_eq!((summary.attachment_indexes.len(), summary.metadata_indexes.len()), (1, 3));
    for index in &summary.attachment_indexes {
        let attachment = mcap::read::attachment(&bytes, index).expect("the checksum of the attachment is right");
        assert_eq!((&attachment.name, &*attachment.data), (&"arm.urdf".to_string(), URDF.as_bytes()));
    }
    for index in &summary.metadata_indexes {
        assert_eq!(mcap::read::metadata(&bytes, index).expect("a record").name, index.name);
    }
    // The checksum of everything before the summary is in the record before that.
    let options = LinearReaderOptions::default().with_validate_data_section_crc(true);
    let (mut reader, mut rest) = (LinearReader::new_with_options(options), &bytes[..]);
    let mut checksums = 0;
    while let Some(event) = reader.next_event() {
        match event.expect("all checksums are right") {
            LinearReadEvent::ReadRequest(wanted) => {
                let (now, later) = rest.split_at(wanted.min(rest.len()));
                reader.insert(now.len()).copy_from_slice(now);
                reader.notify_read(now.len());
                rest = later;
            }
            LinearReadEvent::Record { opcode: mcap::records::op::DATA_END, data } => {
                // Zero would stand for none.
                assert_ne!(data, [0; 4]);
                checksums += 1;
            }
            LinearReadEvent::Record { .. } => {}
        }
    }
    assert_eq!(checksums, 1);
}

fn layout() -> serde_json::Value {
    let layout = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/robots/viewer/lichtblick.json"));
    serde_json::from_str(&layout.expect("the layout")).expect("JSON")
}

/// What the viewer's own settings would do: hide the scene, and lay STL and OBJ meshes on their sides.
#[test]
fn the_layout_for_lichtblick_shows_the_scene_with_meshes_the_right_way_up() {
    let layout = layout();
    let view = &layout["configById"]["3D!catena"];
    assert_eq!(view["topics"]["/scene"]["visible"], true);
    assert_eq!((&view["scene"]["meshUpAxis"], &view["scene"]["ignoreColladaUpAxis"]), (&"z_up".into(), &true.into()));
    assert_eq!(view["followTf"], "world");
}

/// The types of the fields of a message by their names, from the definition of another that uses it; that itself without a name.
fn fields<'d>(definition: &'d str, message: Option<&str>) -> HashMap<&'d str, &'d str> {
    let separator = format!("{}\n", "=".repeat(80));
    let is_it = |part: &&str| message.is_none_or(|name| part.starts_with(&format!("MSG: {name}\n")));
    let part = definition.split(&separator[..]).find(is_it).unwrap_or_else(|| panic!("no {message:?} in {definition}"));
    part.lines()
        .filter(|line| !line.starts_with("MSG: "))
        .filter_map(|line| line.split_once(' '))
        .map(|(a, b)| (b, a))
        .collect()
}

/// A range of indices would be drawn as one curve, from joint to joint and back.
#[test]
fn every_curve_of_the_layout_is_one_number_of_a_message_of_the_log() {
    let bytes = log("layout", 0.1);
    let messages = messages(&bytes);
    let layout = layout();
    let panels = layout["configById"].as_object().expect("panels");
    let mut arrangement = vec![&layout["layout"]];
    let mut shown = 0;
    while let Some(part) = arrangement.pop() {
        match part.as_str() {
            Some(name) => {
                assert!(panels.contains_key(name), "{name}");
                shown += 1;
            }
            None => arrangement.extend([&part["first"], &part["second"]]),
        }
    }
    assert_eq!(shown, panels.len());
    let paths = panels.iter().filter(|(name, _)| name.starts_with("Plot!"));
    let mut paths = paths.flat_map(|(_, panel)| panel["paths"].as_array().expect("curves")).peekable();
    assert!(paths.peek().is_some());
    for path in paths {
        let path = path["value"].as_str().expect("a path");
        let (topic, names) = path.split_once('.').expect("a topic and fields");
        let channel = &of_topic(&messages, topic).first().unwrap_or_else(|| panic!("{path}: no such topic")).channel;
        let schema = channel.schema.as_ref().expect("a schema");
        let definition = std::str::from_utf8(&schema.data).expect("UTF-8");
        let mut kind = fields(definition, None);
        let mut names = names.split('.').peekable();
        while let Some(name) = names.next() {
            let (name, index) = name.split_once('[').map_or((name, None), |(name, index)| (name, Some(index)));
            let found = kind.get(name).unwrap_or_else(|| panic!("{path}: no field {name}"));
            let index = index.map(|index| index.trim_end_matches(']').parse::<usize>().expect("one index"));
            assert_eq!(index.is_some(), found.ends_with("[]"), "{path}: {name}");
            let found = found.trim_end_matches("[]");
            if names.peek().is_some() {
                kind = fields(definition, Some(found));
            } else {
                assert_eq!(found, "float64", "{path}");
            }
        }
    }
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

/// What a killed run leaves behind is what is in the file at that time.
#[test]
fn all_but_the_last_second_is_readable_before_the_log_is_complete_and_leaves_no_trace() {
    let mut onlooker = Onlooker { path: Some(temporary("onlooker.mcap")), seen: 0 };
    let bytes = log_seen_by("onlooker.mcap", 60.0, &mut onlooker);
    assert!(onlooker.seen >= 31, "{} of the 31 samples up to t = 0.5 s", onlooker.seen);
    assert!(bytes == log("undisturbed.mcap", 60.0));
}

#[test]
fn what_ended_a_run_is_the_last_line_of_the_log() {
    let path = temporary("ended.mcap");
    let model = arm();
    let mut recorder = Recorder::create(&path, &model, simulation()).expect("the log is created");
    recorder.say(Severity::Error, "it broke");
    recorder.finish(Ending::default()).expect("the log is completed");
    let bytes = std::fs::read(&path).expect("the log is readable");
    let messages = messages(&bytes);
    let last = Log::decode(&*of_topic(&messages, "/log").last().expect("a line").data).expect("a log line");
    assert_eq!((last.message.as_str(), last.level), ("it broke", 4));
}
