//! The messages: what is known at the start, times, poses, joints, reactions and energy are those of the run.

use super::{Coasting, URDF, VELOCITY, arm, log, messages, model_of, of_topic, simulation};
use crate::common::scratch;
use catena::mechanism::description::body_state::WORLD;
use catena::mechanism::description::joint::rotation_from_wxyz;
use catena::mechanism::motion::kinematics::forward_kinematics;
use catena::model::Base;
use catena::output::log::reading::decode;
use catena::output::log::{Ending, LogOptions, Recorder, Severity};
use catena::scene::{PackagePath, robot_from_text};
use catena::simulation::{RunOptions, run};
use nalgebra::{UnitQuaternion, Vector3};
use std::collections::HashMap;
use std::path::Path;

/// Reads CDR independently of the writer.
pub struct Cdr<'d> {
    data: &'d [u8],
    at: usize,
}

impl<'d> Cdr<'d> {
    pub fn new(message: &'d mcap::Message) -> Self {
        assert_eq!(message.data[..4], [0, 1, 0, 0], "little-endian CDR");
        Cdr { data: &message.data[4..], at: 0 }
    }

    pub fn take<const N: usize>(&mut self) -> [u8; N] {
        self.at = self.at.next_multiple_of(N);
        self.at += N;
        self.data[self.at - N..self.at].try_into().expect("N bytes")
    }

    pub fn unsigned(&mut self) -> u32 {
        u32::from_le_bytes(self.take())
    }

    pub fn string(&mut self) -> String {
        let length = self.unsigned() as usize;
        let bytes = &self.data[self.at..self.at + length];
        self.at += length;
        assert_eq!(bytes[length - 1], 0, "strings end with NUL");
        String::from_utf8(bytes[..length - 1].to_vec()).expect("UTF-8")
    }

    pub fn doubles(&mut self) -> Vec<f64> {
        (0..self.unsigned()).map(|_| f64::from_le_bytes(self.take())).collect()
    }

    pub fn singles<const N: usize>(&mut self) -> [f32; N] {
        [(); N].map(|()| f32::from_le_bytes(self.take()))
    }

    pub fn numbers<const N: usize>(&mut self) -> [f64; N] {
        [(); N].map(|()| f64::from_le_bytes(self.take()))
    }

    pub fn strings(&mut self) -> Vec<String> {
        (0..self.unsigned()).map(|_| self.string()).collect()
    }

    pub fn strings_of_line(&mut self) -> [String; 2] {
        [(); 2].map(|()| self.string())
    }

    pub fn assert_ended(&self) {
        assert_eq!(self.at, self.data.len(), "nothing is left over");
    }
}

/// A marker, read by its definition.
#[derive(Debug)]
pub struct Marker {
    pub frame: String,
    pub namespace: String,
    pub number: u32,
    pub kind: u32,
    pub action: u32,
    /// Position and quaternion x, y, z, w.
    pub pose: [f64; 7],
    pub scale: [f64; 3],
    pub opacity: f32,
    /// Whether it moves with its frame.
    pub follows: bool,
    pub points: Vec<[f64; 3]>,
}

impl Marker {
    /// The markers of a message.
    pub fn read_all(message: &mcap::Message) -> Vec<Self> {
        let mut cdr = Cdr::new(message);
        let markers = (0..cdr.unsigned()).map(|_| Marker::read(&mut cdr)).collect();
        cdr.assert_ended();
        markers
    }

    fn read(cdr: &mut Cdr) -> Self {
        let time = [cdr.unsigned(), cdr.unsigned()];
        let (frame, namespace) = (cdr.string(), cdr.string());
        let (number, kind, action) = (cdr.unsigned(), cdr.unsigned(), cdr.unsigned());
        let (pose, scale, color) = (cdr.numbers(), cdr.numbers(), cdr.singles::<4>());
        assert!(color.iter().all(|part| (0.0..=1.0).contains(part)), "{color:?}");
        assert_eq!([cdr.unsigned(), cdr.unsigned()], [0, 0], "shown for ever");
        let [follows] = cdr.take();
        let points = (0..cdr.unsigned()).map(|_| cdr.numbers()).collect();
        assert_eq!((cdr.unsigned(), cdr.string().as_str()), (0, ""), "no colours and no texture");
        assert_eq!([cdr.unsigned(), cdr.unsigned()], time, "the time of the texture");
        assert_eq!(cdr.strings_of_line(), ["", ""]);
        assert_eq!([cdr.unsigned(), cdr.unsigned()], [0, 0], "no bytes and no coordinates of the texture");
        assert_eq!(
            (cdr.strings_of_line(), cdr.string().as_str()),
            ([String::new(), String::new()], ""),
            "no text, no file"
        );
        assert_eq!((cdr.unsigned(), cdr.take()), (0, [0]));
        let [_, _, _, opacity] = color;
        Marker { frame, namespace, number, kind, action, pose, scale, opacity, follows: follows == 1, points }
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
        ("/visual_markers", ("visualization_msgs/msg/MarkerArray", "cdr")),
        ("/rosout", ("rcl_interfaces/msg/Log", "cdr")),
        ("/tf", ("tf2_msgs/msg/TFMessage", "cdr")),
        ("/joint_states", ("sensor_msgs/msg/JointState", "cdr")),
        ("/energy", ("catena_msgs/msg/Energy", "cdr")),
        ("/constraint", ("catena_msgs/msg/Constraint", "cdr")),
        ("/solver", ("catena_msgs/msg/Solver", "cdr")),
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
    let mut warning = Cdr::new(of_topic(&messages, "/rosout")[0]);
    assert_eq!([warning.unsigned(), warning.unsigned()], [0, 0]);
    // 30 is the level of warnings.
    assert_eq!((warning.take::<1>(), warning.string().as_str()), ([30], "catena"));
    assert_eq!(warning.string(), arm().warnings[0].to_string());
    assert_eq!((warning.strings_of_line(), warning.unsigned()), ([String::new(), String::new()], 0));
    warning.assert_ended();
    let markers = Marker::read_all(of_topic(&messages, "/visual_markers")[0]);
    for marker in &markers {
        assert_eq!((&marker.namespace, marker.number, marker.action, marker.follows), (&marker.frame, 0, 0, true));
    }
    // The slider has mass and no looks: it gets the box of its inertia, 0.1 kg m² about every axis.
    let [base, upper, slider] = &markers[..] else { panic!("{markers:?}") };
    assert_eq!((base.frame.as_str(), base.kind, base.scale), ("base", 1, [1.0, 2.0, 3.0]));
    assert_eq!((upper.frame.as_str(), upper.kind, upper.scale), ("upper", 2, [1.0; 3]));
    assert_eq!(upper.pose, [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    assert!(markers.iter().all(|marker| marker.points.is_empty()), "primitives have no points");
    assert_eq!((slider.frame.as_str(), slider.kind), ("slider", 1));
    assert!(slider.scale.iter().all(|edge| (edge - 0.6_f64.sqrt()).abs() < 1e-12), "{slider:?}");
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
        let stamp = u64::from(cdr.unsigned()) * 1_000_000_000 + u64::from(cdr.unsigned());
        assert_eq!((stamp, cdr.string().as_str()), (message.log_time, ""));
        let figures = cdr.numbers::<7>();
        cdr.assert_ended();
        let mut bodies = [WORLD; 2];
        forward_kinematics(&mechanism, &VELOCITY.map(|rate| rate * time), &VELOCITY, &mut bodies);
        let energy = catena::mechanism::motion::energy::energy(&mechanism, &bodies);
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
        let mut cdr = Cdr::new(transforms);
        assert_eq!(cdr.unsigned(), 5, "every link of the URDF, also those that are no bodies");
        for index in 0..5 {
            let stamp = u64::from(cdr.unsigned()) * 1_000_000_000 + u64::from(cdr.unsigned());
            assert_eq!(stamp, state.log_time);
            assert_eq!((cdr.string().as_str(), &cdr.string()), ("world", &model.links[index].name));
            let (position, rotation) = model.link_pose(&bodies, index);
            assert!((Vector3::from(cdr.numbers::<3>()) - position).amax() < 1e-14);
            let [x, y, z, w] = cdr.numbers();
            let norm = (w * w + x * x + y * y + z * z).sqrt();
            assert!((norm - 1.0).abs() < 1e-12, "{norm}");
            assert!((rotation_from_wxyz(&[w, x, y, z]) - rotation).amax() < 1e-14);
        }
        cdr.assert_ended();
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
        for (name, report) in catena::output::report::joint_reports(&model, &state, &[]) {
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
    let path = scratch("log").join("floating.mcap");
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
    let mut recorder =
        Recorder::create(&path, &model, simulation(), &LogOptions::default()).expect("the log is created");
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
    let path = scratch("log").join("world.mcap");
    let model = model_of(&URDF.replace("\"base\"", "\"world\""), Base::Fixed);
    let mut recorder =
        Recorder::create(&path, &model, simulation(), &LogOptions::default()).expect("the log is created");
    let options = RunOptions { duration: 0.1, rate: None, interrupt: None };
    let mut state = model.zero_state();
    let (_, ended) = run(&model.mechanism, &mut state, &mut Coasting { step: 0.1 }, &options, &mut [&mut recorder]);
    ended.expect("nothing can fail");
    recorder.finish(Ending::default()).expect("the log is completed");
    let bytes = std::fs::read(&path).expect("the log is readable");
    let messages = messages(&bytes);
    let links = decode::transforms(&of_topic(&messages, "/tf")[0].data).expect("transforms");
    let names: Vec<&str> = links.iter().map(|pose| pose.link.as_str()).collect();
    assert_eq!(names, ["upper", "fused", "slider", "massless"]);
}

#[test]
fn what_ended_a_run_is_the_last_line_of_the_log() {
    let path = scratch("log").join("ended.mcap");
    let model = arm();
    let mut recorder =
        Recorder::create(&path, &model, simulation(), &LogOptions::default()).expect("the log is created");
    recorder.say(Severity::Error, "it broke");
    recorder.finish(Ending::default()).expect("the log is completed");
    let bytes = std::fs::read(&path).expect("the log is readable");
    let messages = messages(&bytes);
    let last = decode::log_line(&of_topic(&messages, "/rosout").last().expect("a line").data).expect("a line of text");
    assert_eq!((last.text.as_str(), last.is_problem), ("it broke", true));
}
