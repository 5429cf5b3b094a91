//! Ropes in logs and pages: lines through their points, at every sample.

use super::messages::Marker;
use super::{messages, of_topic};
use crate::common::command::{folder, run, text};
use nalgebra::Vector3;

/// A block in the loop of a rope, and a weight on a winch.
const SCENE: &str = "[[body]]\nname = \"block\"\nshape = { type = \"box\", size = [0.2, 0.1, 0.1] }\nmass = 5\npose.position = [0, 0, -1]\n\
    [[body]]\nname = \"weight\"\nshape = { type = \"sphere\", radius = 0.1 }\nmass = 2\npose.position = [1, 0, -1]\n\
    [[rope]]\nname = \"cable\"\npoints = [{ link = \"world\", position = [-0.1, 0, 0] }, { link = \"block\", position = [0, 0, 0.05] }, \
    { link = \"world\", position = [0.1, 0, 0] }]\nlength = 2.5\n\
    [[rope]]\nname = \"lift\"\npoints = [{ link = \"world\", position = [1, 0, 0] }, { link = \"weight\" }]\n\
    length = { formula = \"1 + v*t\", v = 0.1 }\n";

#[test]
fn every_sample_has_each_rope_as_a_line_through_its_points_and_the_page_has_these_points() {
    let folder = folder("ropes_drawn");
    std::fs::write(folder.join("scene.toml"), SCENE).expect("a scene");
    let output =
        run(&folder, &["simulate", "scene.toml", "--duration", "0.5", "--quiet", "-o", "a.mcap", "--report", "a.html"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let bytes = std::fs::read(folder.join("a.mcap")).expect("a log");
    let messages = messages(&bytes);
    let lines = of_topic(&messages, "/ropes");
    assert_eq!(lines.len(), 31);
    for (number, message) in lines.iter().enumerate() {
        let time = number as f64 / 60.0;
        let markers = Marker::read_all(message);
        let [cable, lift] = markers.as_slice() else { panic!("{markers:?}") };
        assert_eq!([cable, lift].map(|line| (line.kind, line.frame.as_str())), [(4, "world"); 2]);
        let place = |line: &Marker, point: usize| Vector3::from(line.points[point]);
        assert_eq!((cable.points.len(), lift.points.len()), (3, 2), "without the slide of the winch");
        assert_eq!([place(cable, 0), place(cable, 2)].map(|at| at.x), [-0.1, 0.1]);
        // The block falls until its rope goes taut, 0.29 m below; the tolerance is 1e-6 m.
        let falls = 0.5 * 9.81 * time * time;
        let reach = (1.25_f64.powi(2) - 0.01).sqrt();
        assert!((place(cable, 1).z + (0.95 + falls).min(reach)).abs() < 1e-5, "{number}: {}", place(cable, 1));
        // From rest, so that the winch pays out faster than the weight falls at first.
        let lowered = falls.min(0.1 * time);
        assert!((place(lift, 1).z + 1.0 + lowered).abs() < 1e-5, "{number}: {}", place(lift, 1));
    }
    let page = std::fs::read_to_string(folder.join("a.html")).expect("a page");
    let end = "{\"body\":0,\"pose\":[0.0,0.0,0.05,1.0,0.0,0.0,0.0]}";
    assert!(page.contains("\"ropes\":[{\"name\":\"cable\"") && page.contains(end), "no ropes in the page");
    let output =
        run(&folder, &["simulate", "scene.toml", "--duration", "0.1", "--quiet", "-o", "b.mcap", "--topics", "tf"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let bytes = std::fs::read(folder.join("b.mcap")).expect("a log");
    assert!(of_topic(&super::messages(&bytes), "/ropes").is_empty());
}
