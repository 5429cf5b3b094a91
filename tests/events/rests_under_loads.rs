//! Bodies that rest under loads that change in time: they move when the forces that hold them leave their sets, however long nothing moves before.

use crate::common::scratch;
use crate::scene_files::report;
use catena::report::Report;

const GRAVITY: f64 = 9.81;

/// A body of 1 kg, 0.2 m high, on a floor with a friction, under a force along an axis of 8 N or less.
fn run(folder: &str, shape: &str, friction: f64, load: &str, duration: f64, tolerance: f64) -> Report {
    let text = format!(
        "[[body]]\nname = \"body\"\nshape = {shape}\nmass = 1\npose.position = [0, 0, 0.1]\n[[obstacle]]\nname = \"floor\"\n\
         shape = {{ type = \"half_space\" }}\nfriction = {friction}\n[[load]]\nlink = \"body\"\n{load}"
    );
    let file = scratch(folder).join("scene.toml");
    std::fs::write(&file, text).expect("a scene");
    report(&file, &[], &[], Some(duration), tolerance)
}

const BOX: &str = "{ type = \"box\", size = [0.2, 0.2, 0.2] }";

/// The integral of a smooth function, by Simpson's rule with 4000 intervals.
fn integral(from: f64, to: f64, f: impl Fn(f64) -> f64) -> f64 {
    let h = (to - from) / 4000.0;
    let sum: f64 = (0..=4000).map(|i| f(from + h * f64::from(i)) * [2.0, 4.0, 1.0][weight(i)]).sum();
    sum * h / 3.0
}

fn weight(i: i32) -> usize {
    if i == 0 || i == 4000 { 2 } else { usize::from(i % 2 == 1) }
}

#[test]
fn a_box_slides_under_a_push_that_is_small_at_the_start_and_at_the_end_of_the_run() {
    let grip = 0.4 * GRAVITY;
    let push = |time: f64| 8.0 * (-(time - 3.2) * (time - 3.2)).exp();
    let slips = 3.2 - (8.0_f64 / grip).ln().sqrt();
    // It still slides at 5 s: x = ∫ (T − t) a dt. At 60 s it has stopped.
    let expected = integral(slips, 5.0, |time| (5.0 - time) * (push(time) - grip));
    let load = "force = [8, 0, 0]\nfactor = { formula = \"exp(-(t-3.2)^2)\" }\n";
    for tolerance in [1e-3, 1e-6, 1e-9] {
        let end = run("pushed_in_the_middle", BOX, 0.4, load, 5.0, tolerance);
        let off = (end.links[0].1.position[0] - expected).abs();
        // Steps of nine stages between the slip and the end err by less than a thousandth of the tolerance; Simpson's rule by 1e-12.
        assert!(off < 1e-3 * tolerance + 1e-11, "{tolerance:e}: off by {off:e}");
    }
    let end = run("pushed_in_the_middle", BOX, 0.4, load, 60.0, 1e-6);
    assert!(end.links[0].1.position[0] > expected, "it slept: {}", end.links[0].1.position[0]);
}

#[test]
fn a_box_that_rests_for_a_minute_is_moved_by_a_pulse_of_some_milliseconds() {
    // Ranges of the formula, and no samples of it, say where the steps have to end in which nothing moves.
    let (grip, width, at) = (0.4 * GRAVITY, 0.005, 31.7123);
    let push = |time: f64| 800.0 * (-((time - at) / width).powi(2)).exp();
    let slips = at - width * (800.0 / grip).ln().sqrt();
    // It slides until friction has taken all the momentum: x = ∫ (T − t) a dt.
    let behind = at + 10.0 * width;
    let stops = slips + integral(slips, behind, push) / grip;
    let expected = integral(slips, behind, |time| (stops - time) * push(time)) - 0.5 * grip * (stops - slips).powi(2);
    assert!(behind < stops && stops < 60.0);
    let load = "force = [800, 0, 0]\nfactor = { formula = \"exp(-((t-31.7123)/0.005)^2)\" }\n";
    for tolerance in [1e-3, 1e-6, 1e-9] {
        let end = run("pushed_by_a_pulse", BOX, 0.4, load, 60.0, tolerance);
        let off = (end.links[0].1.position[0] - expected).abs();
        assert!(off < tolerance, "{tolerance:e}: off by {off:e}");
    }
}

#[test]
fn a_box_that_slides_and_stops_again_and_again_under_a_sine_is_where_the_closed_form_has_it() {
    let grip = 0.4 * GRAVITY;
    let slips = (grip / 8.0).asin();
    let rate = |time: f64| 8.0 * (slips.cos() - time.cos()) - grip * (time - slips);
    let place = |time: f64| {
        8.0 * (slips.cos() * (time - slips) - (time.sin() - slips.sin())) - 0.5 * grip * (time - slips).powi(2)
    };
    // It turns where its speed is zero, by halving. Then friction pushes the other way.
    let (mut low, mut high) = (3.0, 4.5);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if rate(middle) > 0.0 { low = middle } else { high = middle }
    }
    let after = |time: f64| {
        place(low) + 8.0 * (low.cos() * (time - low) - (time.sin() - low.sin())) + 0.5 * grip * (time - low).powi(2)
    };
    let load = "force = [8, 0, 0]\nfactor = { formula = \"sin(t)\" }\n";
    for duration in [2.0, 4.0, 5.5, 6.3] {
        let end = run("pushed_by_a_sine", BOX, 0.4, load, duration, 1e-6);
        let expected = if duration < low { place(duration) } else { after(duration) };
        let off = (end.links[0].1.position[0] - expected).abs();
        assert!(off < 1e-9, "{duration} s: off by {off:e}");
        assert!(end.accuracy.expect("an accuracy").reached && end.method.crowd.steps == 0, "{duration} s");
    }
}

#[test]
fn what_lies_without_friction_under_a_changing_weight_is_at_rest_in_steps_of_the_method() {
    // The force is never more than the weight: it does not part.
    let load = "force = [0, 0, 5]\nfactor = { formula = \"sin(7*t)\" }\n";
    for shape in [BOX, "{ type = \"sphere\", radius = 0.1 }"] {
        for tolerance in [1e-3, 1e-6, 1e-9] {
            let end = run("lies_without_friction", shape, 0.0, load, 2.0, tolerance);
            assert_eq!((end.method.crowd.steps, end.events.list.len()), (0, 0), "{tolerance:e}");
            assert!(end.accuracy.expect("an accuracy").reached && end.steps < 50, "{} steps", end.steps);
            // Roundings of a tenth.
            assert!((end.links[0].1.position[2] - 0.1).abs() < 1e-14, "{}", end.links[0].1.position[2]);
        }
    }
}
