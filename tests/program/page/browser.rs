//! Pages in a real browser: the canvas shows the robot, where it is at the time of the slider.
//!
//! The browser is Chromium, which `.ci/run` installs where it can; without one these tests say so and skip.

use super::{done, with_log};
use crate::common::command::text;
use std::io::BufReader;
use std::path::Path;
use std::process::Command;

pub const WIDTH: usize = 1366;
const HEIGHT: usize = 768;

/// A Chromium that runs.
pub fn chromium() -> Option<&'static str> {
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let runs = |name: &&str| Command::new(name).arg("--version").output().is_ok_and(|output| output.status.success());
    let found = names.into_iter().find(runs);
    if found.is_none() {
        println!("skipped: there is no Chromium to open pages with; on Debian: apt-get install chromium");
    }
    found
}

/// Opens a page without a display and with OpenGL in software.
pub fn open(chromium: &str, page: &Path, hash: &str, what: &str) -> Vec<u8> {
    let profile = page.with_extension("profile");
    let output = Command::new("timeout")
        .args([
            "-k",
            "5",
            "120",
            chromium,
            "--headless",
            "--no-sandbox",
            "--disable-dev-shm-usage",
            "--hide-scrollbars",
        ])
        .args([
            "--use-gl=angle",
            "--use-angle=swiftshader",
            "--enable-unsafe-swiftshader",
            "--virtual-time-budget=8000",
        ])
        .arg(format!("--user-data-dir={}", profile.display()))
        .arg(format!("--window-size={WIDTH},{HEIGHT}"))
        .arg(what)
        .arg(format!("file://{}#{hash}", page.display()))
        .output()
        .expect("Chromium runs");
    let _ = std::fs::remove_dir_all(profile);
    assert!(output.status.success(), "{}", text(&output.stderr));
    output.stdout
}

/// The picture of a page: rows of red, green, blue.
pub fn picture(chromium: &str, page: &Path, hash: &str) -> Vec<[u8; 3]> {
    let file = page.with_extension("png");
    open(chromium, page, hash, &format!("--screenshot={}", file.display()));
    let png = png::Decoder::new(BufReader::new(std::fs::File::open(&file).expect("a picture")));
    let mut reader = png.read_info().expect("PNG");
    let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
    let info = reader.next_frame(&mut pixels).expect("a picture");
    assert_eq!((info.width as usize, info.bit_depth), (WIDTH, png::BitDepth::Eight));
    pixels.chunks_exact(info.color_type.samples()).map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect()
}

/// The red pixels of the left half of a picture.
#[derive(Debug)]
struct Red {
    count: usize,
    /// Mean of their columns and rows.
    middle: [f64; 2],
    /// Standard deviation of both.
    spread: [f64; 2],
}

fn red(pixels: &[[u8; 3]]) -> Red {
    let is_red = |&(k, &[r, g, b]): &(usize, &[u8; 3])| k % WIDTH < WIDTH / 2 && r > 90 && g < r / 3 && b < r / 3;
    let places: Vec<[f64; 2]> =
        pixels.iter().enumerate().filter(is_red).map(|(k, _)| [(k % WIDTH) as f64, (k / WIDTH) as f64]).collect();
    let mean = |of: &dyn Fn(&[f64; 2]) -> f64| places.iter().map(of).sum::<f64>() / places.len().max(1) as f64;
    let middle = [0, 1].map(|axis| mean(&|place| place[axis]));
    let spread = [0, 1].map(|axis| mean(&|place| (place[axis] - middle[axis]).powi(2)).sqrt());
    Red { count: places.len(), middle, spread }
}

#[test]
fn the_canvas_of_a_run_shows_the_robot_and_it_moves_with_the_time() {
    let Some(chromium) = chromium() else { return };
    let folder = with_log("run");
    done(&folder, &["report", "red.mcap"]);
    let page = folder.join("red.html");
    let dom = open(chromium, &page, "t=0", "--dump-dom");
    assert!(text(&dom).contains("data-state=\"ready\""), "{}", &text(&dom)[..300]);
    let (start, later) = (red(&picture(chromium, &page, "t=0")), red(&picture(chromium, &page, "t=0.4")));
    // A rod of 1 m by 0.2 m that fills a third of the height of the window has some thousands of pixels.
    assert!(start.count > 3000 && later.count > 3000, "{start:?} {later:?}");
    // It swings from 1 rad, where it points sideways, down: by a good part of its length.
    assert!(later.middle[1] - start.middle[1] > 30.0, "{start:?} {later:?}");
}

#[test]
fn the_canvas_of_a_model_shows_it_at_its_start_and_sliders_have_the_names_of_joints() {
    let Some(chromium) = chromium() else { return };
    let folder = with_log("model");
    done(&folder, &["model", "red.urdf", "-o", "model.html"]);
    let page = folder.join("model.html");
    let dom = open(chromium, &page, "", "--dump-dom");
    assert!(text(&dom).contains("data-state=\"ready\"") && text(&dom).contains("aria-label=\"hinge\""));
    // At zero the rod hangs, five times as long as wide; at 1.2 rad about y it points to (-0.93, 0, -0.36), which is flat from the side
    // of +x and -y, where the camera is.
    let (hanging, turned) = (red(&picture(chromium, &page, "")), red(&picture(chromium, &page, "hinge=1.2")));
    assert!(hanging.count > 3000 && turned.count > 3000, "{hanging:?} {turned:?}");
    assert!(hanging.spread[1] > 2.0 * hanging.spread[0], "{hanging:?}");
    assert!(turned.spread[1] < turned.spread[0], "{turned:?}");
}

/// Places the bodies by the page's own tree and by the simulator's poses, then moves one joint by 0.3 and closes the loops.
const COMPARED: &str = r#"<script>
  const said = document.documentElement.dataset;
  const of = JSON.parse(byId("header").textContent);
  unpackedBytes(byId("packed").textContent).then((bytes) => {
    const tree = new Tree(of.tree);
    const [ours, theirs] = [0, 1].map(() => of.tree.bodies.map(() => new THREE.Matrix4()));
    new Motion(unpackedDoubles(bytes, of.times), unpackedFloats(bytes, of.poses), ours.length).place(0, theirs);
    tree.lead();
    tree.place(ours);
    const apart = ours.map((matrix, k) => Math.max(...matrix.elements.map((x, i) => Math.abs(x - theirs[k].elements[i]))));
    said.apart = Math.max(...apart);
    const held = tree.bodies.findIndex((body) => body.q.length === 1 && !body.follows);
    if (held >= 0) tree.bodies[held].q[0] += 0.3;
    said.gap = tree.close(ours, held);
    // The ends of loops that coincide, without the page's equations.
    const at = (end) => poseMatrix(end.pose).premultiply(end.body === null ? new THREE.Matrix4() : ours[end.body]).elements.slice(12, 15);
    const whole = of.tree.loops.filter((loop) => loop.slides.length === 3);
    said.ends = Math.max(0, ...whole.map(({ a, b }) => Math.hypot(...at(a).map((x, k) => x - at(b)[k]))));
    said.held = held < 0 ? 0 : tree.bodies[held].q[0] - of.tree.bodies[held].start[0];
  });
</script></body>"#;

#[test]
fn the_page_places_bodies_where_the_simulator_has_them_and_closes_loops() {
    let Some(chromium) = chromium() else { return };
    let folder = with_log("placed");
    // Every kind of joint, followers and loops, at starts away from zero.
    let cases: [(&str, &[&str]); 5] = [
        ("andrews_squeezer.toml", &[]),
        ("stewart_platform.toml", &[]),
        ("gripper.toml", &[]),
        ("planar_slider.urdf", &["--position", "glide=0.3,-0.2,1", "--position", "hinge=0.7"]),
        ("spherical_chain.urdf", &["--position", "ball1=0.3,-0.5,1", "--position", "ball2=1,0.2,-0.4"]),
    ];
    for (robot, starts) in cases {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots").join(robot);
        let arguments =
            ["simulate", &file.to_string_lossy(), "--duration", "0.01", "--quiet", "--report", "placed.html"];
        done(&folder, &[&arguments, starts].concat());
        let page = folder.join("placed.html");
        let text_of_page = std::fs::read_to_string(&page).expect("a page");
        std::fs::write(&page, text_of_page.replace("</body>", COMPARED)).expect("written");
        let dom = open(chromium, &page, "", "--dump-dom");
        let number = |name: &str| -> f64 {
            let text = super::between(text(&dom), &format!("data-{name}=\""), "\"");
            text.parse().unwrap_or_else(|_| panic!("{robot}: {name} is {text}"))
        };
        // Poses are in single precision: 6e-8 of the lengths, which are some metres.
        assert!(number("apart") < 1e-6, "{robot}: {}", number("apart"));
        assert!(number("ends") < 1e-6, "{robot}: {}", number("ends"));
        assert!(number("gap") < 1e-6, "{robot}: {}", number("gap"));
        assert!((number("held") - 0.3).abs() < 1e-12 || number("held") == 0.0, "{robot}: {}", number("held"));
    }
}

#[test]
fn a_page_fits_a_telephone_and_its_slider_can_be_used_there() {
    let Some(chromium) = chromium() else { return };
    let folder = with_log("telephone");
    done(&folder, &["report", "red.mcap"]);
    // The page in a frame of 390 pixels tells the width that it takes and the place of its slider.
    let tell = "<script>setTimeout(() => { const at = document.getElementById('slider').getBoundingClientRect(); \
                parent.postMessage([innerWidth, document.documentElement.scrollWidth, at.left, at.right, at.height].join(' '), '*'); }, 2000)</script></body>";
    let page = std::fs::read_to_string(folder.join("red.html")).expect("a page");
    let (before, after) = page.rsplit_once("</body>").expect("a body");
    std::fs::write(folder.join("told.html"), format!("{before}{tell}{after}")).expect("written");
    let frame = "<html><body style='margin:0'><script>addEventListener('message', told => document.body.setAttribute('data-told', told.data))</script>\
                 <iframe src='told.html' style='width:390px;height:844px;border:0'></iframe></body></html>";
    let framed = folder.join("framed.html");
    std::fs::write(&framed, frame).expect("written");
    let dom = open(chromium, &framed, "", "--dump-dom");
    let (_, told) = text(&dom).split_once("data-told=\"").expect("the page has told its sizes");
    let numbers: Vec<f64> =
        told.split('"').next().unwrap_or_default().split(' ').filter_map(|number| number.parse().ok()).collect();
    let &[width, taken, left, right, height] = numbers.as_slice() else { panic!("{numbers:?}") };
    assert_eq!((width, taken), (390.0, 390.0), "nothing is wider than the telephone");
    // Half of the width in which the time is set, and no lower than letters are.
    assert!(left >= 0.0 && right <= 390.0 && right - left > 195.0 && height >= 12.0, "{numbers:?}");
}
