//! Scenes of free bodies as somebody writes the first one: no `[contact]`, and nothing passes through anything.

use crate::common::scratch;
use crate::scene_files::report;
use catena::report::Report;
use std::path::PathBuf;

const FLOOR: &str = "[[obstacle]]\nname = \"floor\"\nshape = { type = \"half_space\" }\n";

fn scene(folder: &str, text: &str) -> PathBuf {
    let file = scratch(folder).join("scene.toml");
    std::fs::write(&file, text).expect("a scene");
    file
}

fn cuboid(name: &str, size: f64, position: [f64; 3]) -> String {
    format!(
        "[[body]]\nname = \"{name}\"\nshape = {{ type = \"box\", size = [{size}, {size}, {size}] }}\nmass = 1\n\
         pose.position = {position:?}\n"
    )
}

fn height(report: &Report, name: &str) -> f64 {
    report.links.iter().find(|(of, _)| of == name).expect("a body").1.position[2]
}

#[test]
fn a_box_that_is_dropped_on_another_lies_on_it_unless_the_scene_leaves_out_contact_of_bodies() {
    let boxes = cuboid("lower", 0.3, [0.0, 0.0, 0.2]) + &cuboid("upper", 0.2, [0.02, 0.0, 0.7]) + FLOOR;
    let said = |name: &str, contact: &str| report(&scene(name, &(boxes.clone() + contact)), &[], &[], Some(2.0), 1e-6);
    let lies = said("bodies_stack", "");
    // At rest on faces: roundings alone.
    assert!((height(&lies, "upper") - 0.4).abs() < 1e-12, "{}", height(&lies, "upper"));
    let passes = said("bodies_apart", "[contact]\npairs = \"environment\"\n");
    assert!((height(&passes, "upper") - 0.1).abs() < 1e-12, "{}", height(&passes, "upper"));
}

#[test]
fn two_balls_meet_without_any_obstacle() {
    let ball = |name: &str, x: f64, v: f64| {
        format!(
            "[[body]]\nname = \"{name}\"\nshape = {{ type = \"sphere\", radius = 0.1 }}\nmass = 2\nrestitution = 1\n\
             pose.position = [{x}, 0, 0]\nvelocity = {{ linear = [{v}, 0, 0], angular = [0, 0, 0] }}\n"
        )
    };
    let text = "[scene]\ngravity = [0, 0, 0]\n".to_string() + &ball("one", 0.0, 1.5) + &ball("other", 0.5, 0.0);
    let end = report(&scene("bodies_meet", &text), &[], &[], Some(1.0), 1e-6);
    // Equal masses change their velocities, after 0.2 s.
    let x = |name: &str| end.links.iter().find(|(of, _)| of == name).expect("a ball").1.position[0];
    assert!((x("one") - 0.3).abs() < 1e-12 && (x("other") - 1.7).abs() < 1e-12, "{} {}", x("one"), x("other"));
}

#[test]
fn balls_that_land_together_take_as_many_steps_as_one() {
    let balls = |grid: &str| {
        let text = format!(
            "[[body]]\nname = \"ball\"\nshape = {{ type = \"sphere\", radius = 0.1 }}\nmass = 1\nrestitution = 0.5\n\
             pose.position = [0, 0, 1]\n{grid}\n{FLOOR}"
        );
        report(&scene("bodies_together", &text), &[], &[], Some(3.0), 1e-6)
    };
    let [one, many] = ["", "grid = [3, 3, 1]\nspacing = [0.3, 0.3, 0]"].map(balls);
    // They are nearer to each other than their size, and so one group. Roundings of nine heights may end a step twice, here and there.
    assert!(many.steps <= 2 * one.steps, "{} steps of nine balls, {} of one", many.steps, one.steps);
}

#[test]
fn beyond_the_horizon_steps_over_events_take_over_whatever_the_tolerance() {
    let crates = "[[body]]\nname = \"crate\"\nshape = { type = \"box\", size = [0.3, 0.2, 0.25] }\ndensity = 300\n\
                  pose = { position = [0, 0, 0.6], rpy = [\"20 deg\", \"10 deg\", 0] }\ncount = 4\nspacing = [0.05, 0.02, 0.3]\n\
                  [[obstacle]]\nname = \"ramp\"\nshape = { type = \"box\", size = [3, 2, 0.1] }\n\
                  pose = { position = [0, 0, 0], rpy = [0, \"12 deg\", 0] }\n";
    let end = report(&scene("bodies_horizon", crates), &[], &[], Some(0.7), 1e-6);
    let accuracy = end.accuracy.expect("an accuracy");
    assert!(!accuracy.reached && accuracy.holds_until < 0.45, "{accuracy:?}");
    // The crates tumble for most of the rest; nothing asks for exact events any more.
    let stepped_over = end.method.crowd.time_share * end.duration;
    assert!(stepped_over > 0.4 * (0.7 - accuracy.holds_until), "{stepped_over} s");
}
