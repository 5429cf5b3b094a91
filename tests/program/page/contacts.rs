//! Pages of runs with contact: the arrows are the forces of the log, and the obstacles of the scene are drawn where they are.

use super::numbers::{bytes, floats, words};
use super::{browser, done, header};
use crate::common::command::{folder, text};
use catena::output::log::reading::decode::LoggedContact;
use catena::output::log::reading::frames::{Frame, Visitor, visit};
use serde_json::{Value, json};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// A ball that falls through 5 cm onto a floor and rests there, beside an obstacle of each other shape.
const SCENE: &str = r#"
[[robot]]
name = "ball"
urdf = "ball.urdf"
base = "floating"
pose = { position = [0, 0, 0.15] }
[[obstacle]]
name = "floor"
shape = { type = "half_space" }
[[obstacle]]
name = "crate"
shape = { type = "box", size = [0.3, 0.4, 0.2] }
pose = { position = [1, 2, 3] }
[[obstacle]]
name = "globe"
shape = { type = "sphere", radius = 0.25 }
pose = { position = [0, 2, 0] }
[[obstacle]]
name = "pill"
shape = { type = "capsule", radius = 0.1, length = 0.5 }
pose = { position = [0, -2, 0] }
[[obstacle]]
name = "can"
shape = { type = "cylinder", radius = 0.125, length = 0.75 }
pose = { position = [2, 0, 0] }
[[obstacle]]
name = "wedge"
shape = { type = "mesh", file = "wedge.obj" }
pose = { position = [-2, 0, 0] }
[simulation]
duration = 0.5
"#;

const WEDGE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

/// A folder with that scene, its log `scene.mcap` and its page `scene.html`.
fn with_contacts(name: &str) -> PathBuf {
    let folder = folder(name);
    let ball = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/parts/ball.urdf");
    std::fs::copy(ball, folder.join("ball.urdf")).expect("copied");
    std::fs::write(folder.join("wedge.obj"), WEDGE).expect("written");
    std::fs::write(folder.join("scene.toml"), SCENE).expect("written");
    done(&folder, &["simulate", "scene.toml", "--quiet", "--report", "scene.html"]);
    folder
}

fn page(folder: &Path, name: &str) -> String {
    std::fs::read_to_string(folder.join(name)).expect("a page")
}

/// The contacts of all samples of a log.
fn logged(log: &Path) -> Vec<Vec<LoggedContact>> {
    struct All(Vec<Vec<LoggedContact>>);
    impl Visitor for All {
        fn frame(&mut self, frame: &Frame) -> ControlFlow<()> {
            self.0.push(frame.contacts.clone());
            ControlFlow::Continue(())
        }
    }
    let mut all = All(Vec::new());
    visit(log, &mut all).expect("a log");
    all.0
}

#[test]
fn contact_arrows_of_a_page_are_the_forces_of_the_log_and_events_name_their_pairs() {
    let folder = with_contacts("contact_arrows");
    let page = page(&folder, "scene.html");
    let (header, bytes) = (header(&page), bytes(&page));
    let samples = logged(&folder.join("scene.mcap"));
    // In the air for sqrt(2 · 0.05 / 9.81) = 0.101 s, which are the first seven of 31 samples, then on the floor.
    assert_eq!((samples.len(), samples.iter().filter(|contacts| contacts.is_empty()).count()), (31, 7));
    let layer = &header["contacts"];
    assert_eq!((&layer["pairs"], &layer["most"]), (&json!(["ball|floor"]), &json!(1)));
    let starts = words(&bytes, &layer["starts"]);
    let (which, numbers) = (words(&bytes, &layer["which"]), floats(&bytes, &layer["numbers"]));
    let all = samples.iter().map(Vec::len).sum::<usize>();
    assert_eq!((starts.len(), which.len(), numbers.len()), (samples.len() + 1, all, 6 * all));
    for (sample, contacts) in samples.iter().enumerate() {
        let range = starts[sample] as usize..starts[sample + 1] as usize;
        assert_eq!(range.len(), contacts.len(), "sample {sample}");
        for (k, contact) in range.zip(contacts) {
            let LoggedContact { a, b, position, force, .. } = contact;
            assert_eq!(layer["pairs"][which[k] as usize], format!("{a}|{b}"));
            let expected = position.iter().chain(force).map(|number| *number as f32);
            let found = (0..6).map(|column| numbers[column * all + k]);
            assert!(found.eq(expected), "sample {sample}: {contact:?}");
        }
    }
    // At rest the floor carries the ball: 1 kg in single precision.
    assert!((f64::from(numbers[6 * all - 1]) - 9.81).abs() < 1e-6, "{}", numbers[6 * all - 1]);
    let events = header["events"].as_array().expect("events");
    assert!(!events.is_empty() && events.iter().all(|event| event["what"] == "ball|floor"), "{events:?}");
}

#[test]
fn obstacles_of_a_scene_are_in_the_pages_of_its_run_and_of_its_model_and_of_a_run_without_contact_none() {
    let folder = with_contacts("obstacles");
    done(&folder, &["model", "scene.toml", "-o", "model.html"]);
    let at = |x: f64, y: f64, z: f64| json!([x, y, z, 1.0, 0.0, 0.0, 0.0]);
    let expected = json!([
        { "name": "floor", "kind": "half_space", "size": [], "pose": at(0.0, 0.0, 0.0) },
        { "name": "crate", "kind": "box", "size": [0.3, 0.4, 0.2], "pose": at(1.0, 2.0, 3.0) },
        { "name": "globe", "kind": "sphere", "size": [0.25], "pose": at(0.0, 2.0, 0.0) },
        { "name": "pill", "kind": "capsule", "size": [0.1, 0.5], "pose": at(0.0, -2.0, 0.0) },
        { "name": "can", "kind": "cylinder", "size": [0.125, 0.75], "pose": at(2.0, 0.0, 0.0) },
        { "name": "wedge", "kind": "mesh", "size": [1.0, 1.0, 1.0], "pose": at(-2.0, 0.0, 0.0), "mesh": 0 },
    ]);
    for name in ["scene.html", "model.html"] {
        let header = header(&page(&folder, name));
        assert_eq!(header["obstacles"], expected, "{name}");
        assert_eq!(header["meshes"][0]["parts"][0]["triangles"]["count"], 12, "{name}: four triangles");
    }
    assert_eq!(header(&page(&folder, "model.html"))["contacts"], Value::Null);
    done(&folder, &["model", "scene.toml", "-o", "model.html", "--mesh-limit", "0"]);
    let few = header(&page(&folder, "model.html"));
    assert_eq!(few["obstacles"].as_array().map(Vec::len), Some(5));
    assert!(few["notes"].to_string().contains("1 obstacle is not drawn"), "{}", few["notes"]);
    let free =
        ["simulate", "scene.toml", "--without", "contact", "--quiet", "-o", "free.mcap", "--report", "free.html"];
    done(&folder, &free);
    let free = header(&page(&folder, "free.html"));
    assert_eq!((&free["contacts"], &free["obstacles"]), (&Value::Null, &json!([])));
    assert_eq!(free["collision_shapes"], json!([]));
}

/// A body with a ball in its link frame and the wedge beside it, both turned with the body.
#[test]
fn collision_shapes_of_links_are_in_the_page_of_a_run_with_contact_in_their_bodies() {
    let folder = with_contacts("shapes");
    let ball = std::fs::read_to_string(folder.join("ball.urdf")).expect("a robot");
    let wedge = "<collision><origin xyz=\"0.5 0 0\"/><geometry><mesh filename=\"wedge.obj\" scale=\"0.1 0.1 0.1\"/></geometry></collision></link>";
    std::fs::write(folder.join("ball.urdf"), ball.replace("</link>", wedge)).expect("written");
    done(&folder, &["simulate", "scene.toml", "--quiet", "--duration", "0.1", "--report", "scene.html"]);
    let header = header(&page(&folder, "scene.html"));
    let at = |x: f64| json!([x, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
    // The obstacle's mesh is of another size, so another one.
    let expected = json!([
        { "name": "ball", "body": 0, "kind": "sphere", "size": [0.1], "pose": at(0.0) },
        { "name": "ball", "body": 0, "kind": "mesh", "size": [1.0, 1.0, 1.0], "pose": at(0.5), "mesh": 0 },
    ]);
    assert_eq!(header["collision_shapes"], expected);
    assert_eq!(header["obstacles"][5]["mesh"], 1);
    assert_eq!(header["meshes"][0]["parts"][0]["triangles"]["count"], 12, "four triangles of a hull");
    done(&folder, &["model", "scene.toml", "-o", "model.html", "--mesh-limit", "0"]);
    let few = super::header(&page(&folder, "model.html"));
    assert_eq!(few["collision_shapes"].as_array().map(Vec::len), Some(1));
    assert!(few["notes"].to_string().contains("1 collision shape of a link is not drawn"), "{}", few["notes"]);
}

/// What the page's own scripts read of the last sample, and what they draw of the obstacles.
const READ: &str = r#"<script>
  const said = document.documentElement.dataset;
  const of = JSON.parse(byId("header").textContent);
  unpackedBytes(byId("packed").textContent).then((bytes) => {
    const [{ name, at, force }] = new Contacts(of.contacts, bytes, of.samples).forces(of.samples - 1);
    said.force = JSON.stringify([name, ...at, ...force].map((value) => (typeof value === "number" ? value.toFixed(5) : value)).map(String)).replaceAll('"', "");
    const view = { obstacles: new THREE.Group() };
    const around = new THREE.Box3(new THREE.Vector3(0, 0, 0), new THREE.Vector3(0.2, 0.2, 0.2));
    new Obstacles(of, bytes, view, around, 0.3);
    const boxes = view.obstacles.children.filter((one) => one.isMesh).map((one) => {
      one.updateMatrixWorld(true);
      return one.userData.link + " " + new THREE.Box3().setFromObject(one, true).getSize(new THREE.Vector3()).toArray().map((x) => x.toFixed(2)).join(" ");
    });
    said.drawn = boxes.join(", ");
  });
</script></body>"#;

#[test]
fn the_page_reads_the_forces_and_draws_each_obstacle_in_its_size() {
    let Some(chromium) = browser::chromium() else { return };
    let folder = with_contacts("contacts_drawn");
    let file = folder.join("read.html");
    std::fs::write(&file, page(&folder, "scene.html").replace("</body>", READ)).expect("written");
    let dom = browser::open(chromium, &file, "", "--dump-dom");
    let said = |name: &str| super::between(text(&dom), &format!("data-{name}=\""), "\"").to_string();
    assert_eq!(said("state"), "ready");
    let rest = logged(&folder.join("scene.mcap")).pop().and_then(|contacts| contacts.into_iter().next());
    let rest = rest.expect("the ball rests on the floor");
    let numbers: Vec<f64> = rest.position.into_iter().chain(rest.force).collect();
    let found = said("force");
    let mut parts = found.trim_matches(['[', ']']).split(',');
    assert_eq!(parts.next(), Some("ball|floor"));
    for (part, expected) in parts.zip(numbers) {
        // Five decimals, of numbers in single precision below 16.
        assert!((part.parse::<f64>().expect(part) - expected).abs() < 1e-5, "{found}");
    }
    // A tile of the floor reaches five times the size of the robot to each side; the box of a robot of 0.2 m has a diagonal of 0.35 m.
    let expected =
        "crate 0.30 0.40 0.20, globe 0.50 0.50 0.50, pill 0.20 0.20 0.70, can 0.25 0.25 0.75, wedge 1.00 1.00 1.00";
    let (solids, floor) = found_floor(&said("drawn"));
    assert_eq!(solids, expected);
    assert!(floor[0] >= 3.0 && floor[0] == floor[1] && floor[2] == 0.0, "{floor:?}");
}

/// The words about solids, and the size of the floor.
fn found_floor(drawn: &str) -> (String, Vec<f64>) {
    let (solids, floor) = drawn.split_once(", floor ").expect("a floor, drawn last");
    (solids.to_string(), floor.split(' ').map(|number| number.parse().expect("a number")).collect())
}

#[test]
fn arrows_of_contacts_and_obstacles_are_seen_and_can_be_left_out() {
    let Some(chromium) = browser::chromium() else { return };
    let folder = with_contacts("contacts_seen");
    let file = folder.join("scene.html");
    let picture = |hash: &str| browser::picture(chromium, &file, hash);
    let different = |a: &[[u8; 3]], b: &[[u8; 3]]| a.iter().zip(b).filter(|(a, b)| a != b).count();
    let green = |pixels: &[[u8; 3]]| {
        let left = pixels.iter().enumerate().filter(|(k, _)| k % browser::WIDTH < browser::WIDTH / 2);
        left.filter(|(_, [r, g, b])| *g > 110 && *r < g / 2 && *b < 4 * (g / 5)).count()
    };
    let (falling, resting) = (picture("t=0.05"), picture("t=0.5"));
    let without = picture("t=0.5&nocontacts");
    let bare = picture("t=0.5&nocontacts&noobstacles&nogrid");
    // A shaft of some ten pixels by some hundred; nothing else of the page is green.
    assert!(green(&resting) > 200, "{}", green(&resting));
    assert_eq!((green(&falling), green(&without)), (0, 0));
    // The ball is orange, and violet over that where its collision shape is shown; that lies at the same place, falling and resting.
    let violet = |pixels: &[[u8; 3]]| {
        let left = pixels.iter().enumerate().filter(|(k, _)| k % browser::WIDTH < browser::WIDTH / 2);
        left.filter(|(_, [r, g, b])| g.saturating_add(8) < *r.min(b)).count()
    };
    let shapes = ["t=0.05&shapes&nocontacts", "t=0.5&shapes&nocontacts"].map(picture);
    assert_eq!((violet(&falling), violet(&resting)), (0, 0));
    assert!(shapes.iter().all(|shapes| violet(shapes) > 1000), "{} {}", violet(&shapes[0]), violet(&shapes[1]));
    // The tile of the floor fills most of the lower half of the view.
    assert!(different(&without, &bare) > 30_000, "{}", different(&without, &bare));
}
