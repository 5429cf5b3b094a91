//! The numbers in a page are those of the log and of the files, unpacked here by the letter of `packing.rs`.

use super::{RED, between, done, folder, header, with_log};
use serde_json::Value;
use std::path::Path;

/// The bytes of all arrays of a page.
pub fn bytes(page: &str) -> Vec<u8> {
    const DIGITS: &str = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let text = between(page, r#"id="packed">"#, "</script>").trim_end_matches('=');
    let bits = text.chars().flat_map(|letter| {
        let digit = DIGITS.find(letter).expect("a digit of base64");
        (0..6).rev().map(move |bit| (digit >> bit & 1) as u8)
    });
    let bits: Vec<u8> = bits.collect();
    let zlib: Vec<u8> = bits.chunks_exact(8).map(|byte| byte.iter().fold(0, |sum, bit| 2 * sum + bit)).collect();
    miniz_oxide::inflate::decompress_to_vec_zlib(&zlib).expect("zlib")
}

/// The words of an array.
pub fn words(bytes: &[u8], place: &Value) -> Vec<u64> {
    let [at, count, width, column] =
        ["at", "count", "width", "column"].map(|key| place[key].as_u64().expect(key) as usize);
    let mut words: Vec<u64> = Vec::new();
    for k in 0..count {
        let word = (0..width).map(|b| u64::from(bytes[at + b * count + k]) << (8 * b)).sum::<u64>();
        let before = if column > 0 && k % column > 0 { words[k - 1] } else { 0 };
        let sum = word.wrapping_add(before);
        words.push(if width == 8 { sum } else { sum & ((1 << (8 * width)) - 1) });
    }
    words
}

pub fn floats(bytes: &[u8], place: &Value) -> Vec<f32> {
    words(bytes, place).into_iter().map(|word| f32::from_bits(word as u32)).collect()
}

#[test]
fn curves_poses_and_events_of_a_page_are_those_of_the_log() {
    let folder = with_log("curves");
    done(&folder, &["report", "red.mcap"]);
    done(&folder, &["inspect", "red.mcap", "--csv", "red.csv"]);
    let page = std::fs::read_to_string(folder.join("red.html")).expect("a page");
    let (header, bytes) = (header(&page), bytes(&page));
    let table = std::fs::read_to_string(folder.join("red.csv")).expect("a table");
    let mut rows = table.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let head = rows.next().expect("a head");
    let rows: Vec<Vec<f64>> =
        rows.map(|row| row.iter().map(|cell| cell.parse().unwrap_or(f64::NAN)).collect()).collect();
    let column = |name: &str| {
        let place = head.iter().position(|head| head.split(" [").next() == Some(name)).expect(name);
        rows.iter().map(|row| row[place]).collect::<Vec<f64>>()
    };
    let times: Vec<f64> = words(&bytes, &header["times"]).into_iter().map(f64::from_bits).collect();
    assert_eq!(times, column("time"));
    let samples = times.len();
    assert_eq!((samples, header["samples"].as_u64()), (121, Some(121)));
    let values = floats(&bytes, &header["values"]);
    for name in ["hinge.position", "hinge.velocity", "hinge.reaction_force.z"] {
        let curves = header["curves"].as_array().expect("curves");
        let place = curves.iter().position(|curve| curve["name"] == name).expect(name);
        for (sample, (found, expected)) in values[place * samples..].iter().zip(column(name)).enumerate() {
            assert_eq!(*found, expected as f32, "{name} of sample {sample}");
        }
    }
    // Figures of steps are in the page once for each step, and on both sides of each event.
    let steps = &header["steps"];
    let ends: Vec<f64> = words(&bytes, &steps["times"]).into_iter().map(f64::from_bits).collect();
    let curves = steps["curves"].as_array().expect("curves of steps");
    let place = curves.iter().position(|curve| curve["name"] == "energy.kinetic").expect("an energy");
    let energies = &floats(&bytes, &steps["values"])[place * ends.len()..][..ends.len()];
    for (end, expected) in column("step_end").into_iter().zip(column("energy.kinetic")) {
        let found = ends.iter().position(|time| *time == end).unwrap_or_else(|| panic!("no step ends at {end} s"));
        assert_eq!(energies[found], expected as f32, "the kinetic energy at {end} s");
    }
    let events: Value =
        serde_json::from_str(&done(&folder, &["inspect", "red.mcap", "--events", "--json"])).expect("JSON");
    assert_eq!(header["events"], events["list"]);
    let impacts: Vec<&Value> =
        events["list"].as_array().expect("events").iter().filter(|event| event["kind"] == "limit_impact").collect();
    assert!(!impacts.is_empty(), "it runs into its limit");
    let of_steps = |name: &str| {
        let place = curves.iter().position(|curve| curve["name"] == name).expect(name);
        floats(&bytes, &steps["values"])[place * ends.len()..][..ends.len()].to_vec()
    };
    let (kinetic, lost) = (of_steps("energy.kinetic"), of_steps("energy.impacts"));
    for impact in impacts {
        let time = impact["time"].as_f64().expect("a time");
        let before = ends.windows(2).position(|pair| (pair[0] - time).abs() < 2e-9 && pair[1] - pair[0] < 2e-9);
        let before = before.unwrap_or_else(|| panic!("no figures on both sides of {time} s"));
        let (taken, told) = (kinetic[before] - kinetic[before + 1], lost[before + 1] - lost[before]);
        // Joules in single precision.
        assert!(taken > 0.0 && (taken - told).abs() < 1e-6, "{taken} J and {told} J at {time} s");
    }
    // The origin of the link from the pose of its body, as the page places it: p_body + R(q) arm.
    let poses = floats(&bytes, &header["poses"]);
    let link = &header["tree"]["links"][1];
    assert_eq!((&link["name"], &link["body"]), (&"rod".into(), &0.into()));
    let arm = nalgebra::Vector3::from_fn(|k, _| link["pose"][k].as_f64().expect("a number"));
    let [x, y, z] = ["rod.x", "rod.y", "rod.z"].map(column);
    for sample in 0..samples {
        let at = |k: usize| f64::from(poses[k * samples + sample]);
        let turn = nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(at(3), at(4), at(5), at(6)));
        let origin = nalgebra::Vector3::new(at(0), at(1), at(2)) + turn * arm;
        let expected = nalgebra::Vector3::new(x[sample], y[sample], z[sample]);
        // Half a metre in single precision.
        assert!((origin - expected).norm() < 2e-7, "sample {sample}");
    }
}

#[test]
fn energies_of_two_balls_that_bounce_apart_from_each_other_are_level_on_both_sides_of_every_bounce() {
    let folder = super::folder("level");
    // Two islands: they never touch each other. Without losses; the flights last 0.64 and 0.45 s.
    let ball = |name: &str, x: f64, height: f64| {
        format!(
            "[[body]]\nname = \"{name}\"\nshape = {{ type = \"sphere\", radius = 0.1 }}\nmass = 1.0\n\
             pose = {{ position = [{x:?}, 0.0, {:?}] }}\n",
            0.1 + height
        )
    };
    let scene = format!(
        "{}{}[[obstacle]]\nshape = {{ type = \"half_space\" }}\n[contact]\nrestitution = 1.0\nfriction = 0.0\n\
         [simulation]\nduration = 2.0\n",
        ball("one", 0.0, 0.5),
        ball("other", 3.0, 0.25)
    );
    std::fs::write(folder.join("balls.toml"), scene).expect("written");
    done(&folder, &["simulate", "balls.toml", "--report", "balls.html", "--quiet"]);
    let page = std::fs::read_to_string(folder.join("balls.html")).expect("a page");
    let (header, bytes) = (header(&page), bytes(&page));
    let times: Vec<f64> = words(&bytes, &header["steps"]["times"]).into_iter().map(f64::from_bits).collect();
    let values = floats(&bytes, &header["steps"]["values"]);
    let column = |number: usize| &values[number * times.len()..][..times.len()];
    let (kinetic, total) = (column(0), column(2));
    // Single precision of 7.4 J.
    assert!(total.iter().all(|energy| (energy - total[0]).abs() < 2e-6), "{total:?}");
    let events = header["events"].as_array().expect("events");
    assert_eq!(events.len(), 7, "three bounces of one, and four of the other");
    for event in events {
        let at = event["time"].as_f64().expect("a time");
        let near = (0..times.len()).filter(|&place| (times[place] - at).abs() < 3e-9);
        let own: Vec<f32> = near.map(|place| kinetic[place]).collect();
        assert_eq!(own.len(), 2, "a value on either side of {at} s");
        // The one that bounces has all its energy in its speed: m g h.
        let least = 9.80 * if event["what"].as_str().is_some_and(|what| what.contains("one")) { 0.5 } else { 0.25 };
        assert!(own.iter().all(|energy| f64::from(*energy) >= least), "{own:?} at {at} s");
    }
}

#[test]
fn the_page_of_two_logs_has_both_motions() {
    let folder = with_log("two");
    let other = ["simulate", "red.urdf", "--duration", "1", "--position", "hinge=0.5", "-o", "other.mcap", "--quiet"];
    done(&folder, &other);
    let said = done(&folder, &["report", "red.mcap", "other.mcap", "-o", "two.html"]);
    assert_eq!(said, "two.html: 2 s of red.mcap beside other.mcap\n");
    let page = std::fs::read_to_string(folder.join("two.html")).expect("a page");
    let (header, bytes) = (header(&page), bytes(&page));
    let angle = |run: &Value| {
        let samples = run["samples"].as_u64().expect("a number") as usize;
        let place =
            run["curves"].as_array().expect("curves").iter().position(|curve| curve["name"] == "hinge.position");
        floats(&bytes, &run["values"])[place.expect("a curve") * samples..][..samples].to_vec()
    };
    let (first, second) = (angle(&header), angle(&header["second"]));
    // 60 samples a second and the start; both begin at rest where they were put.
    assert_eq!((first.len(), first[0], second.len(), second[0]), (121, 1.0, 61, 0.5));
    assert_eq!((&header["source"], &header["second"]["source"]), (&"red.mcap".into(), &"other.mcap".into()));
    let Some(chromium) = super::browser::chromium() else { return };
    let dom = super::browser::open(chromium, &folder.join("two.html"), "t=0.5", "--dump-dom");
    let dom = crate::common::command::text(&dom);
    assert!(dom.contains("data-state=\"ready\"") && dom.contains("hinge.position (second run)"), "{}", &dom[..300]);
}

#[test]
fn meshes_are_drawn_once_simplified_to_the_limit_and_boxes_stand_for_those_that_are_missing() {
    let folder = with_log("meshes");
    // A ball of 80 by 40 cells.
    let at = |i: u32, j: u32| {
        let (a, b) = (f64::from(i) / 80.0 * std::f64::consts::TAU, f64::from(j) / 40.0 * std::f64::consts::PI);
        // The poles exactly: all their corners are one.
        let ring = if j.is_multiple_of(40) { 0.0 } else { b.sin() };
        format!("v {} {} {}\n", a.cos() * ring, a.sin() * ring, b.cos())
    };
    let mut ball: String = (0..80).flat_map(|i| (0..=40).map(move |j| at(i, j))).collect();
    for (i, j) in (0..80u32).flat_map(|i| (0..40).map(move |j| (i, j))) {
        let corner = |i: u32, j: u32| (i % 80) * 41 + j + 1;
        ball += &format!("f {} {} {} {}\n", corner(i, j), corner(i, j + 1), corner(i + 1, j + 1), corner(i + 1, j));
    }
    std::fs::write(folder.join("ball.obj"), ball).expect("written");
    let mesh =
        |name: &str| format!(r#"<visual><geometry><mesh filename="{name}" scale="0.5 0.5 0.5"/></geometry></visual>"#);
    let visuals = [mesh("ball.obj"), mesh("ball.obj")].concat();
    let with = |visuals: &str| super::RED.replace("</inertial>", &format!("</inertial>{visuals}"));
    std::fs::write(folder.join("ball.urdf"), with(&visuals)).expect("written");
    let page = |name: &str, more: &[&str]| {
        done(&folder, &[&["model", name, "-o", "page.html"], more].concat());
        let page = std::fs::read_to_string(folder.join("page.html")).expect("a page");
        (header(&page), bytes(&page))
    };
    let triangles =
        |header: &Value| header["meshes"][0]["parts"][0]["triangles"]["count"].as_u64().map(|count| count / 3);
    let (full, packed) = page("ball.urdf", &[]);
    assert_eq!(full["meshes"].as_array().map(Vec::len), Some(1), "two visuals share it");
    // Cells at the poles are triangles: their other half has no area.
    assert_eq!(triangles(&full), Some(2 * 80 * 40 - 160));
    let corners = words(&packed, &full["meshes"][0]["parts"][0]["corners"]);
    let number = |value: &Value| value.as_f64().expect("a number");
    let (origin, step) = (&full["meshes"][0]["origin"], number(&full["meshes"][0]["step"]));
    let count = corners.len() / 3;
    for k in 0..count {
        let at = |axis: usize| number(&origin[axis]) + step * corners[axis * count + k] as f64;
        let radius = at(0).hypot(at(1)).hypot(at(2));
        // Half a step of the grid along each axis.
        assert!((radius - 1.0).abs() < step, "{radius}");
    }
    let (few, _) = page("ball.urdf", &["--mesh-limit", "500"]);
    assert!(triangles(&few).is_some_and(|count| count > 300 && count <= 500), "{:?}", triangles(&few));
    assert!(few["notes"].to_string().contains("simplified from 6240 to"), "{}", few["notes"]);
    let (none, _) = page("ball.urdf", &["--mesh-limit", "0"]);
    assert!(none["notes"].to_string().contains("2 meshes are left out"), "{}", none["notes"]);
    assert_eq!(none["shapes"].as_array().map(Vec::len), Some(1), "the box of the URDF is left");
    let lost = with(&mesh("lost.stl")).replace("<box size=\"0.2 0.2 1\"/>", r#"<mesh filename="lost.dae"/>"#);
    std::fs::write(folder.join("lost.urdf"), lost).expect("written");
    let (lost, _) = page("lost.urdf", &[]);
    assert!(lost["notes"].to_string().contains("lost.stl"), "{}", lost["notes"]);
    assert_eq!(lost["shapes"][0]["kind"], "box", "of the same inertia");
}

#[test]
fn a_page_of_a_log_draws_the_meshes_in_it_when_their_files_are_gone() {
    let folder = with_log("meshes_of_log");
    let paint = "newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\n";
    let shape =
        "mtllib two.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl red\nf 1 2 3\nusemtl blue\nf 1 2 4\nf 1 4 3\n";
    std::fs::write(folder.join("two.mtl"), paint).expect("written");
    std::fs::write(folder.join("two.obj"), shape).expect("written");
    // Two meshes at the same place, which only the numbers of their markers tell apart, and one of the same triangles.
    let visual =
        |scale: &str| format!(r#"<visual><geometry><mesh filename="two.obj" scale="{scale}"/></geometry></visual>"#);
    let visuals = [visual("1 1 1"), visual("-2 2 2"), visual("1 1 1")].concat();
    std::fs::write(folder.join("two.urdf"), super::RED.replace("</inertial>", &format!("</inertial>{visuals}")))
        .expect("written");
    done(&folder, &["simulate", "two.urdf", "--duration", "0.1", "--quiet"]);
    std::fs::remove_file(folder.join("two.obj")).expect("removed");
    done(&folder, &["report", "two.mcap", "-o", "two.html"]);
    let header = header(&std::fs::read_to_string(folder.join("two.html")).expect("a page"));
    let meshes = header["meshes"].as_array().expect("meshes");
    assert_eq!(meshes.len(), 2, "the first and the third are one");
    for (mesh, origin) in meshes.iter().zip([0.0, -2.0]) {
        assert_eq!(mesh["origin"][0], origin);
        let parts = mesh["parts"].as_array().expect("parts");
        let of_parts = parts.iter().map(|part| (part["color"].clone(), part["triangles"]["count"].as_u64()));
        let expected =
            [(serde_json::json!([1.0, 0.0, 0.0, 1.0]), Some(3)), (serde_json::json!([0.0, 0.0, 1.0, 1.0]), Some(6))];
        assert_eq!(of_parts.collect::<Vec<_>>(), expected);
    }
    let drawn: Vec<&Value> =
        header["shapes"].as_array().expect("shapes").iter().filter(|shape| shape["kind"] == "mesh").collect();
    assert_eq!(drawn.iter().map(|shape| shape["mesh"].as_u64()).collect::<Vec<_>>(), [Some(0), Some(1), Some(0)]);
    // The scale is in the triangles.
    assert!(drawn.iter().all(|shape| shape["size"] == serde_json::json!([1.0, 1.0, 1.0])), "{drawn:?}");
}

#[test]
fn a_page_of_an_arm_is_small() {
    let folder = with_log("small");
    let arm = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/arm7.urdf");
    done(&folder, &["simulate", &arm.to_string_lossy(), "--duration", "10", "--report", "arm.html", "--quiet"]);
    let size = std::fs::metadata(folder.join("arm.html")).expect("a page").len();
    // What issue 35 asks for.
    assert!(size <= 1_500_000, "{size} bytes");
}

#[test]
fn a_page_has_the_standard_deviation_of_a_position_at_every_sample_through_an_impact() {
    let folder = folder("spread");
    std::fs::write(folder.join("red.urdf"), RED).expect("written");
    let asked = ["--position", "hinge=1", "--sensitivity", "start.q.hinge=0.01", "--report", "red.html", "--quiet"];
    done(&folder, &[&["simulate", "red.urdf", "--duration", "2"][..], &asked[..]].concat());
    done(&folder, &["inspect", "red.mcap", "--csv", "red.csv"]);
    let page = std::fs::read_to_string(folder.join("red.html")).expect("a page");
    let (header, bytes) = (header(&page), bytes(&page));
    let samples = header["samples"].as_u64().expect("samples") as usize;
    let curves = header["curves"].as_array().expect("curves");
    let spreads: Vec<&Value> = curves.iter().filter(|curve| curve.get("spread").is_some()).collect();
    assert_eq!(spreads.len(), 1, "positions alone have a standard deviation");
    assert_eq!(spreads[0]["name"], "hinge.position");
    let column = spreads[0]["spread"].as_u64().expect("a column") as usize;
    let values = &floats(&bytes, &header["values"])[column * samples..][..samples];
    let table = std::fs::read_to_string(folder.join("red.csv")).expect("a table");
    let rows: Vec<Vec<&str>> = table.lines().map(|line| line.split(',').collect()).collect();
    let place = |name: &str| rows[0].iter().position(|head| *head == name).expect(name);
    let (time, at) = (place("time [s]"), place("sensitivity_at [s]"));
    let slope = place("dhinge.position/dstart.q.hinge");
    assert_eq!(rows.len(), 1 + samples);
    for (row, value) in rows[1..].iter().zip(values) {
        assert_eq!(row[time], row[at], "each sample has derivatives of its own");
        let slope: f64 = row[slope].parse().expect("a number");
        // The page has single precision.
        assert!((f64::from(*value) - 0.01 * slope.abs()).abs() <= 1e-9, "{}: {value} and {slope}", row[time]);
    }
    assert_eq!(values[0], 0.01);
    assert!(values.iter().all(|value| value.is_finite()), "also behind the impact");
}
