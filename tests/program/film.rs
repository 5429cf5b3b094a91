//! Films: `catena film` as GIF, PNG and MP4, drawn by the program and by a browser.

use crate::common::command::{assert_one_error, catena, folder, run, text};
use crate::page::browser::chromium;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

/// A red ball of 0.1 m that is dropped from 1 m onto a floor, with a restitution of 0.7.
const BALL: &str = r#"
[scene]
name = "ball"
[[body]]
name = "ball"
shape = { type = "sphere", radius = 0.1 }
mass = 1.0
color = [0.9, 0.05, 0.05]
pose = { position = [0, 0, 1.1] }
[[obstacle]]
name = "floor"
shape = { type = "half_space" }
restitution = 0.7
[simulation]
duration = 1.0
tolerance = 1e-6
"#;

/// A folder with the log of that ball.
fn with_ball(name: &str) -> PathBuf {
    let folder = folder(name);
    std::fs::write(folder.join("ball.toml"), BALL).expect("written");
    // Lines between samples 10 ms apart are off by g/8 · (10 ms)² = 0.12 mm of the parabola.
    let made = run(&folder, &["simulate", "ball.toml", "-o", "ball.mcap", "--rate", "100", "--quiet"]);
    assert_eq!(made.status.code(), Some(0), "{}", text(&made.stderr));
    folder
}

/// The height of the ball's middle (m): free fall to the impact at √(2 h/g), then up at 0.7 of the speed.
fn height(time: f64) -> f64 {
    let g = 9.81;
    let impact = (2.0f64 / g).sqrt();
    let after = time - impact;
    if after < 0.0 { 1.1 - 0.5 * g * time * time } else { 0.1 + 0.7 * g * impact * after - 0.5 * g * after * after }
}

/// Pixels of a picture: rows of red, green, blue.
struct Picture {
    width: usize,
    pixels: Vec<[u8; 3]>,
}

impl Picture {
    fn of_png(file: &Path) -> Self {
        let mut reader = png::Decoder::new(BufReader::new(File::open(file).expect("a file"))).read_info().expect("PNG");
        let mut bytes = vec![0; reader.output_buffer_size().expect("a size")];
        let info = reader.next_frame(&mut bytes).expect("a picture");
        assert_eq!(info.color_type, png::ColorType::Rgb);
        Picture { width: info.width as usize, pixels: bytes.as_chunks().0.to_vec() }
    }

    /// Mean column and row of the red pixels between two columns, and their number.
    fn red(&self, columns: std::ops::Range<usize>) -> ([f64; 2], usize) {
        // Sky, floor and shadows are grey or bluish; the quarters of the ball are red and pink.
        let is_red = |&(k, &[r, g, b]): &(usize, &[u8; 3])| {
            columns.contains(&(k % self.width)) && r > g.max(b).saturating_add(30)
        };
        let places: Vec<[f64; 2]> = self
            .pixels
            .iter()
            .enumerate()
            .filter(is_red)
            .map(|(k, _)| [(k % self.width) as f64 + 0.5, (k / self.width) as f64 + 0.5])
            .collect();
        let mean = |axis: usize| places.iter().map(|place| place[axis]).sum::<f64>() / places.len().max(1) as f64;
        ([mean(0), mean(1)], places.len())
    }
}

/// Whether the ball is at the heights of theory: rows are linear in the height, because the distance from the camera stays the same.
fn assert_falls(seen: &[(f64, f64)], pixels: f64) {
    let ((first_time, first_row), (last_time, last_row)) = (seen[0], *seen.last().expect("pictures"));
    let scale = (last_row - first_row) / (height(last_time) - height(first_time));
    assert!(scale < -50.0, "{scale} pixels a metre");
    for (time, row) in seen {
        let expected = first_row + scale * (height(*time) - height(first_time));
        assert!((row - expected).abs() < pixels, "at {time} s the ball is in row {row}, not {expected}");
    }
}

#[test]
fn a_ball_is_in_the_pictures_where_theory_has_it() {
    let folder = with_ball("film_png");
    let times = [0.0, 0.15, 0.3, 0.44, 0.6, 0.75, 0.9, 0.45];
    let list = times.map(|time| time.to_string()).join(",");
    let film = ["film", "ball.mcap", "-o", "ball.png", "--size", "300x400", "--view", "right", "--time", &list];
    let made = run(&folder, &film);
    assert_eq!(made.status.code(), Some(0), "{}", text(&made.stderr));
    assert_eq!(text(&made.stdout), "ball.png: 8 pictures of 300 x 400, 0 to 0.45 s of ball.mcap\n");
    let picture = Picture::of_png(&folder.join("ball.png"));
    assert_eq!((picture.width, picture.pixels.len()), (8 * 300, 8 * 300 * 400));
    let seen = times.iter().enumerate().map(|(k, time)| {
        let ([column, row], count) = picture.red(300 * k..300 * (k + 1));
        // The box of the run is 1.2 m high and 0.2 m wide, so its half diagonal is 0.61 m. The picture, narrower than high, shows 1.02 of it to both
        // sides along its width; 0.1 m are 24 pixels at the distance of the middle, and the disc has 1800.
        assert!((1500..2200).contains(&count), "{count} red pixels at {time} s");
        assert!((column - (300 * k + 150) as f64).abs() < 0.5, "it falls straight down, and is in column {column}");
        (*time, row)
    });
    // Edges of the disc are off by a part of a pixel, and its middle by less; the outline of a ball beside the axis is an ellipse.
    assert_falls(&seen.collect::<Vec<_>>(), 0.6);
}

#[test]
fn a_gif_has_the_pictures_of_its_instants_and_lasts_as_long_as_the_run() {
    let folder = with_ball("film_gif");
    let made = run(&folder, &["film", "ball.mcap", "--fps", "30", "--size", "200x300", "--view", "front"]);
    assert_eq!(made.status.code(), Some(0), "{}", text(&made.stderr));
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut decoder = options.read_info(File::open(folder.join("ball.gif")).expect("a file")).expect("GIF");
    assert_eq!((decoder.width(), decoder.height()), (200, 300));
    let mut screen = vec![[0u8; 3]; 200 * 300];
    let (mut seen, mut hundredths) = (Vec::new(), 0);
    while let Some(frame) = decoder.read_next_frame().expect("a frame") {
        for (k, pixel) in frame.buffer.as_chunks::<4>().0.iter().enumerate().filter(|(_, pixel)| pixel[3] == 255) {
            let width = usize::from(frame.width);
            let (column, row) = (usize::from(frame.left) + k % width, usize::from(frame.top) + k / width);
            screen[200 * row + column] = [pixel[0], pixel[1], pixel[2]];
        }
        let picture = Picture { width: 200, pixels: screen.clone() };
        let ([_, row], count) = picture.red(0..200);
        assert!(count > 500, "{count} red pixels");
        seen.push((seen.len() as f64 / 30.0, row));
        hundredths += usize::from(frame.delay);
    }
    // 30 pictures in a second and the last instant; the delays of 31 pictures are 1.033 s, in hundredths.
    assert_eq!((seen.len(), hundredths), (31, 103));
    assert_falls(&seen, 0.6);
}

#[test]
fn the_same_log_gives_the_same_film_and_slow_motion_more_of_it() {
    let folder = with_ball("film_same");
    let film = |name: &str, speed: &str| {
        let options =
            ["film", "ball.mcap", "-o", name, "--size", "160x90", "--speed", speed, "--time", "0.2,0.4", "--quiet"];
        let made = run(&folder, &options);
        assert_eq!((made.status.code(), text(&made.stdout)), (Some(0), ""), "{}", text(&made.stderr));
        std::fs::read(folder.join(name)).expect("a film")
    };
    let one = film("one.gif", "1");
    assert_eq!(one, film("two.gif", "1"));
    let slow = film("slow.gif", "0.1");
    let frames = |bytes: &[u8]| {
        let mut decoder = gif::DecodeOptions::new().read_info(bytes).expect("GIF");
        std::iter::from_fn(|| decoder.next_frame_info().expect("a frame").map(|_| ())).count()
    };
    assert_eq!((frames(&one), frames(&slow)), (6, 51));
}

#[test]
fn a_film_that_cannot_be_is_refused_before_anything_is_written() {
    let folder = with_ball("film_bad");
    let cases: [(&[&str], i32, &str); 9] = [
        (&["-o", "ball.avi"], 2, "none of .gif, .mp4, .png"),
        (&["-o", "ball.mcap"], 2, "none of .gif, .mp4, .png"),
        (&["--size", "9x9"], 2, "both sides must have 16 to 4096 pixels"),
        (&["--size", "wide"], 2, "such as 960x540"),
        (&["-o", "a.mp4", "--size", "101x100"], 2, "give even numbers"),
        (&["--fps", "0"], 2, "--fps 0: it must be from 0.01 to 100"),
        (&["--speed=-1"], 2, "--speed -1: it must be above 0"),
        (&["--time", "0,7"], 2, "--time 7: the log has samples from 0 to 1 s"),
        (&["--view", "side"], 2, "give one of corner, front, back, left, right, top"),
    ];
    let before = std::fs::read_dir(&folder).expect("a folder").count();
    for (options, code, words) in cases {
        let output = run(&folder, &[&["film", "ball.mcap"], options].concat());
        assert_one_error(&output, code, words);
        assert!(text(&output.stderr).contains(words), "{}", text(&output.stderr));
    }
    // Without ffmpeg the message says where it comes from, and no half of a film stays.
    let output =
        catena(&folder, &["film", "ball.mcap", "-o", "ball.mp4"]).env("PATH", "").output().expect("catena runs");
    assert_one_error(&output, 1, "MP4 needs ffmpeg");
    assert!(text(&output.stderr).contains("apt-get install ffmpeg"), "{}", text(&output.stderr));
    assert_eq!(std::fs::read_dir(&folder).expect("a folder").count(), before);
}

#[test]
fn ffmpeg_makes_an_mp4_of_the_pictures() {
    let has =
        |name: &str| std::process::Command::new(name).arg("-version").output().is_ok_and(|said| said.status.success());
    if !has("ffmpeg") {
        println!("skipped: there is no ffmpeg; on Debian: apt-get install ffmpeg");
        return;
    }
    let folder = with_ball("film_mp4");
    let made = run(&folder, &["film", "ball.mcap", "-o", "ball.mp4", "--size", "200x300", "--view", "front"]);
    assert_eq!(made.status.code(), Some(0), "{}", text(&made.stderr));
    let frame = ["-loglevel", "error", "-ss", "0.4", "-i", "ball.mp4", "-frames:v", "1", "-pix_fmt", "rgb24", "at.png"];
    let cut = std::process::Command::new("ffmpeg").current_dir(&folder).args(frame).output().expect("ffmpeg runs");
    assert!(cut.status.success(), "{}", text(&cut.stderr));
    let ([_, at], count) = Picture::of_png(&folder.join("at.png")).red(0..200);
    let made =
        run(&folder, &["film", "ball.mcap", "-o", "own.png", "--size", "200x300", "--view", "front", "--time", "0.4"]);
    assert_eq!(made.status.code(), Some(0), "{}", text(&made.stderr));
    let ([_, own], _) = Picture::of_png(&folder.join("own.png")).red(0..200);
    // The colours of MP4 have half of the resolution.
    assert!(count > 500 && (at - own).abs() < 1.5, "{count} {at} {own}");
}

#[test]
fn a_browser_draws_the_ball_in_the_same_places() {
    if chromium().is_none() {
        return;
    }
    let folder = with_ball("film_browser");
    let times = [0.0, 0.2, 0.4, 0.75];
    let list = times.map(|time| time.to_string()).join(",");
    let film = |name: &str, by: &[&str]| {
        let options = ["film", "ball.mcap", "-o", name, "--size", "500x400", "--view", "right", "--time", &list];
        let made = run(&folder, &[&options, by].concat());
        assert_eq!(made.status.code(), Some(0), "{}", text(&made.stderr));
        let picture = Picture::of_png(&folder.join(name));
        times.iter().enumerate().map(|(k, time)| (*time, picture.red(500 * k..500 * (k + 1)))).collect::<Vec<_>>()
    };
    let (own, browser) = (film("own.png", &[]), film("browser.png", &["--browser"]));
    for ((time, (own, count)), (_, (other, others))) in own.iter().zip(&browser) {
        // Both have the same camera; the browser's edges are lit otherwise.
        assert!((0..2).all(|axis| (own[axis] - other[axis]).abs() < 2.0), "at {time} s: {own:?} and {other:?}");
        assert!(count.abs_diff(*others) < count / 10, "at {time} s: {count} and {others} red pixels");
    }
    assert_falls(&browser.iter().map(|(time, ([_, row], _))| (*time, *row)).collect::<Vec<_>>(), 1.0);
}

#[test]
fn a_ball_that_turns_shows_it_by_its_two_colours() {
    let folder = folder("film_seam");
    let ball = "[scene]\ngravity = [0, 0, 0]\n[[body]]\nname = \"ball\"\nshape = { type = \"sphere\", radius = 0.1 }\nmass = 1\ncolor = [0.9, 0.1, 0.1]\n\
                velocity = { linear = [0, 0, 0], angular = [0, 0, \"90 deg/s\"] }\n[simulation]\nduration = 1.0\ntolerance = 1e-6\n";
    std::fs::write(folder.join("ball.toml"), ball).expect("written");
    for line in [
        &["simulate", "ball.toml", "-o", "ball.mcap", "--quiet"][..],
        &["film", "ball.mcap", "-o", "ball.png", "--size", "300x300", "--view", "top", "--time", "0,1"],
    ] {
        let made = run(&folder, line);
        assert_eq!(made.status.code(), Some(0), "{}", text(&made.stderr));
    }
    let picture = Picture::of_png(&folder.join("ball.png"));
    // Red of the middle of each quarter of the disc, of which the middle is that of the picture.
    let red = |number: usize, right: bool, up: bool| {
        let column = 300 * number + if right { 165 } else { 135 };
        f64::from(picture.pixels[(if up { 135 } else { 165 }) * picture.width + column][0])
    };
    for (right, up) in [(true, true), (true, false), (false, true), (false, false)] {
        let (before, beside, after) = (red(0, right, up), red(0, !right, up), red(1, right, up));
        // A quarter turn brings the other colour there; shading differs by less than the colours do.
        assert!((before - beside).abs() > 40.0, "{before} beside {beside}");
        assert!((after - beside).abs() < 0.5 * (before - beside).abs(), "{before} {beside}, then {after}");
    }
}
