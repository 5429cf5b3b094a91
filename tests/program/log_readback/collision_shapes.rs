//! Collision shapes in a log: they are what touches, each in the frame of its link.

use super::messages::Marker;
use super::{messages, of_topic};
use crate::common::command::{folder, run, text};
use catena::output::log::reading::decode;
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use std::collections::{BTreeSet, HashMap};
use std::path::Path;

/// The log of a run of these words into `NAME.mcap`.
fn simulate(folder: &Path, name: &str, words: &[&str]) -> Vec<u8> {
    let log = format!("{name}.mcap");
    let output = run(folder, &[&["simulate"], words, &["--quiet", "-o", &log]].concat());
    assert_eq!(output.status.code(), Some(0), "{words:?}: {}", text(&output.stderr));
    std::fs::read(folder.join(log)).expect("a log")
}

fn robots(name: &str) -> String {
    format!("{}/robots/{name}", env!("CARGO_MANIFEST_DIR"))
}

/// The collision shapes of a log, which are one message at its start.
fn shapes(log: &[u8]) -> Vec<Marker> {
    let messages = messages(log);
    let found = of_topic(&messages, "/collision_shapes");
    let [message] = found[..] else { panic!("{} messages", found.len()) };
    assert_eq!(message.log_time, 0);
    Marker::read_all(message)
}

/// A pose from a position and a quaternion x, y, z, w.
fn placed([x, y, z, qx, qy, qz, qw]: [f64; 7]) -> Isometry3<f64> {
    let turn = UnitQuaternion::new_unchecked(Quaternion::new(qw, qx, qy, qz));
    Isometry3::from_parts(Translation3::new(x, y, z), turn)
}

const CUBE: u32 = 1;
const SPHERE: u32 = 2;
const TRIANGLES: u32 = 11;

#[test]
fn the_feet_of_a_robot_touch_the_floor_where_their_shapes_in_the_log_do() {
    let log = simulate(&folder("feet"), "feet", &[&robots("quadruped_dropped.toml"), "--duration", "0.6"]);
    let markers = shapes(&log);
    let kinds: Vec<(&str, u32)> = markers.iter().map(|marker| (marker.namespace.as_str(), marker.kind)).collect();
    let feet = ["front_left_foot", "front_right_foot", "rear_left_foot", "rear_right_foot"].map(|foot| (foot, SPHERE));
    let mut expected = vec![("trunk", CUBE)];
    expected.extend(feet);
    expected.push(("floor", CUBE));
    assert_eq!(kinds, expected);
    for marker in &markers {
        let frame = if marker.namespace == "floor" { "world" } else { &marker.namespace };
        assert_eq!((marker.frame.as_str(), marker.number, marker.action, marker.follows), (frame, 0, 0, true));
        assert!(marker.opacity > 0.2 && marker.opacity < 0.8, "looks are seen through it: {marker:?}");
    }
    let messages = messages(&log);
    let last = |topic: &str| of_topic(&messages, topic).pop().expect("a sample");
    let links = decode::transforms(&last("/tf").data).expect("poses");
    let links: HashMap<String, Isometry3<f64>> = links
        .into_iter()
        .map(|link| {
            let ([x, y, z], [qw, qx, qy, qz]) = (link.position, link.orientation);
            (link.link, placed([x, y, z, qx, qy, qz, qw]))
        })
        .collect();
    let contacts = decode::contacts(&last("/contacts").data).expect("contacts");
    assert_eq!(contacts.len(), 4, "it stands");
    for contact in contacts {
        let of = |name: &str| markers.iter().find(|marker| marker.namespace == name).expect(name);
        let (foot, floor) = (of(&contact.a), of(&contact.b));
        let centre = (links[&contact.a] * placed(foot.pose)).translation.vector;
        let radius = (Vector3::from(contact.position) - centre).norm();
        // The foot and the floor overlap by at most 1e-12 m.
        assert!((2.0 * radius - foot.scale[0]).abs() < 1e-11 && foot.scale == [foot.scale[0]; 3], "{radius}");
        let top = floor.pose[2] + 0.5 * floor.scale[2];
        assert!((top - contact.position[2]).abs() < 1e-11, "{top}");
    }
}

/// A ball with a wedge for a collision shape, and a smaller ball on a link that is fixed to it, over a floor.
const SCENE: &str = "[[robot]]\nname = \"ball\"\nurdf = \"wedged.urdf\"\nbase = \"floating\"\npose = { position = [0, 0, 1] }\n\
                     [[obstacle]]\nname = \"floor\"\nshape = { type = \"half_space\" }\n\
                     [[obstacle]]\nname = \"wall\"\nshape = { type = \"mesh\", file = \"wedge.obj\" }\npose = { position = [5, 0, 0] }\n";
/// Three edges of length one, and a point on one of its faces, so that there are more triangles than a hull has.
const WEDGE: &str =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0.2 0.2 0\nf 1 3 5\nf 3 2 5\nf 2 1 5\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

fn with_wedge(name: &str) -> std::path::PathBuf {
    let folder = folder(name);
    let ball = std::fs::read_to_string(robots("parts/ball.urdf")).expect("a robot");
    let mesh = "<mesh filename=\"wedge.obj\" scale=\"0.1 0.2 0.3\"/>";
    let (looks, touches) = ball.split_once("<collision>").expect("a shape");
    let pad = "<link name=\"pad\"><collision><origin xyz=\"0.1 0 0\"/><geometry><sphere radius=\"0.05\"/></geometry></collision></link>\
               <joint name=\"weld\" type=\"fixed\"><parent link=\"ball\"/><child link=\"pad\"/><origin xyz=\"0 0 0.3\" rpy=\"0 0.5 0.2\"/></joint>\
               </robot>";
    let touches = touches.replace("<sphere radius=\"0.1\"/>", mesh).replace("</robot>", pad);
    let wedged = format!("{looks}<collision>{touches}");
    for (file, content) in [("wedged.urdf", wedged.as_str()), ("wedge.obj", WEDGE), ("scene.toml", SCENE)] {
        std::fs::write(folder.join(file), content).expect("written");
    }
    folder
}

/// Six times what triangles enclose: negative if they look inwards.
fn sixfold_volume(points: &[[f64; 3]]) -> f64 {
    let triangles = points.chunks_exact(3).map(|corners| [0, 1, 2].map(|corner| Vector3::from(corners[corner])));
    triangles.map(|[a, b, c]| a.dot(&b.cross(&c))).sum()
}

#[test]
fn meshes_are_the_hull_that_touches_and_the_surface_of_the_obstacle() {
    let folder = with_wedge("wedges");
    let embedded = simulate(&folder, "embedded", &["scene.toml", "--duration", "0.1"]);
    let markers = shapes(&embedded);
    let [ball, pad, floor, wall] = &markers[..] else { panic!("{markers:?}") };
    assert_eq!([ball.kind, pad.kind, floor.kind, wall.kind], [TRIANGLES, SPHERE, CUBE, TRIANGLES]);
    assert_eq!((pad.frame.as_str(), pad.namespace.as_str(), pad.scale), ("pad", "pad", [0.1; 3]));
    let wanted = [0.1, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    // Into the body and back: some roundings of 0.3 m.
    assert!(pad.pose.iter().zip(wanted).all(|(found, wanted)| (found - wanted).abs() < 1e-15), "{pad:?}");
    assert_eq!((ball.namespace.as_str(), wall.namespace.as_str(), wall.frame.as_str()), ("ball", "wall", "world"));
    assert_eq!((ball.points.len(), wall.points.len(), wall.pose[0]), (3 * 4, 3 * 6, 5.0));
    // Of the scales 0.1, 0.2, 0.3, as single precision has them.
    assert!((sixfold_volume(&ball.points) - 0.006).abs() < 1e-8, "{ball:?}");
    assert!((sixfold_volume(&wall.points) - 1.0).abs() < 1e-6, "{wall:?}");
    let linked = simulate(&folder, "linked", &["scene.toml", "--duration", "0.1", "--meshes", "link"]);
    let count = |log: &[u8], what: &[u8]| {
        let messages = messages(log);
        let data = &of_topic(&messages, "/collision_shapes")[0].data;
        (data[4], data.windows(what.len()).filter(|part| part == &what).count())
    };
    // The files of the link and of the wall, the pad and the floor; no corner of a triangle.
    let corner = f64::from(0.2_f32).to_le_bytes();
    assert_eq!((count(&embedded, b"wedge.obj"), count(&linked, b"wedge.obj")), ((4, 0), (4, 2)));
    assert!(count(&embedded, &corner).1 > 0 && count(&linked, &corner).1 == 0);
}

#[test]
fn shapes_that_touch_nothing_are_in_a_log_only_if_they_are_named_and_never_without_meshes() {
    let folder = with_wedge("unasked");
    let topics = |log: &[u8]| -> BTreeSet<String> {
        messages(log).iter().map(|message| message.channel.topic.clone()).collect()
    };
    let has = |log: &[u8]| topics(log).contains("/collision_shapes");
    let short = ["--duration", "0.1"];
    let log = |name: &str, words: &[&str]| simulate(&folder, name, &[words, &short[..]].concat());
    assert!(!has(&log("none", &["wedged.urdf", "--base", "floating"])));
    assert!(!has(&log("left_out", &["scene.toml", "--topics", "tf"])));
    assert!(!has(&log("no_meshes", &["scene.toml", "--meshes", "none"])));
    let named = log("named", &["wedged.urdf", "--base", "floating", "--topics", "tf,collision_shapes"]);
    let [ball, pad] = &shapes(&named)[..] else { panic!("two shapes") };
    assert_eq!((ball.kind, ball.points.len(), pad.kind, topics(&named).len()), (TRIANGLES, 12, SPHERE, 3));
    assert!(!has(&log("no_shapes", &["pendulum.urdf", "--topics", "tf,collision_shapes"])));
}
