//! Ropes: taut and slack at located instants, against a parabola between two arcs, a fall, and a joint limit that holds the same link.

use crate::common::scratch;
use crate::scene_files::{apart, report};
use catena::prelude::Model;
use catena::report::Report;
use std::path::{Path, PathBuf};

const GRAVITY: f64 = 9.81;
/// Closed forms are met to this (m, J): tolerances of 1e-11 m, and their factors of some ten in energies.
const BOUND: f64 = 1e-10;

fn near(what: &str, (is, wanted): (f64, f64)) {
    assert!((is - wanted).abs() < BOUND, "{what}: {is} instead of {wanted}, off by {:.1e}", is - wanted);
}

/// A ball of 2 kg that is tied at its centre to the origin, with a start.
fn tied(folder: &str, length: f64, restitution: f64, place: [f64; 2], velocity: [f64; 2]) -> PathBuf {
    let ([x, z], [along, up]) = (place, velocity);
    let text = format!(
        "[[body]]\nname = \"ball\"\nshape = {{ type = \"sphere\", radius = 0.05 }}\nmass = 2.0\n\
         pose.position = [{x}, 0, {z}]\nvelocity = {{ linear = [{along}, 0, {up}], angular = [0, 0, 0] }}\n\
         [[rope]]\nname = \"rope\"\npoints = [{{ link = \"world\" }}, {{ link = \"ball\" }}]\nlength = {length}\nrestitution = {restitution}\n"
    );
    let file = scratch(folder).join("scene.toml");
    std::fs::write(&file, text).expect("a scene");
    file
}

fn ball(report: &Report) -> [f64; 3] {
    report.links.iter().find(|(name, _)| name == "ball").expect("a ball").1.position
}

#[test]
fn a_rope_goes_slack_where_its_tension_ends_and_taut_where_the_parabola_meets_the_circle() {
    slackens_and_tautens("rope_slack", 0.3);
}

#[test]
fn a_rope_that_hangs_plumb_at_the_start_is_exact() {
    slackens_and_tautens("rope_plumb", 0.0);
}

/// From an angle θ₀ off the plumb line, on a rope that is taut.
fn slackens_and_tautens(name: &str, begins: f64) {
    // As if from below with v₀² = 3.5 g L: v² = v₀² − 2 g L (1 − cos θ), and the tension ends where v² = −g L cos θ.
    let (length, mass) = (0.8, 2.0);
    let per = GRAVITY * length;
    let start = 3.5 * per;
    let cosine = -(start - 2.0 * per) / (3.0 * per);
    let slack = f64::acos(cosine);
    let sine = slack.sin();
    // The time on the arc, by Simpson's rule with an error of 1e-15 of it.
    let count = 2000;
    let rate = |angle: f64| length / (start - 2.0 * per * (1.0 - angle.cos())).sqrt();
    let weight = |number: usize| match number {
        0 => 1.0,
        number if number == count => 1.0,
        number => [2.0, 4.0][number % 2],
    };
    let step = (slack - begins) / count as f64;
    let arc = (0..=count).map(|number| weight(number) * rate(begins + number as f64 * step)).sum::<f64>() * step / 3.0;
    let speed = (-per * cosine).sqrt();
    // |r|² = L² again at t = 4 v sin θ/g.
    let taut = 4.0 * speed * sine / GRAVITY;
    let (along, up) = begins.sin_cos();
    let first = length / rate(begins);
    let file = tied(name, length, 0.0, [length * along, -length * up], [first * up, first * along]);
    let run = |duration: f64| {
        let end = report(&file, &[], &[], Some(duration), 1e-11);
        assert!(end.energy.max_relative_error < 0.1 * BOUND, "{:?}", end.energy);
        end
    };
    let on_parabola = |time: f64| {
        let x = length * sine + speed * cosine * time;
        [x, -length * cosine + speed * sine * time - 0.5 * GRAVITY * time * time]
    };
    let flies = run(arc + 0.5 * taut);
    let [x, z] = on_parabola(0.5 * taut);
    near("x of the parabola", (ball(&flies)[0], x));
    near("z of the parabola", (ball(&flies)[2], z));
    near("loss before the blow", (flies.energy.impacts, 0.0));
    // The blow takes the speed along the rope.
    let [x, z] = on_parabola(taut);
    let outwards = (speed * cosine * x + (speed * sine - GRAVITY * taut) * z) / length;
    let swings = run(arc + taut + 0.01);
    near("loss of the blow", (swings.energy.impacts, 0.5 * mass * outwards * outwards));
    let [x, _, z] = ball(&swings);
    near("length", (x.hypot(z), length));
}

#[test]
fn a_rope_that_goes_taut_gives_back_its_restitution() {
    let (length, restitution, mass) = (1.1, 0.5, 2.0);
    let end = |time: f64| {
        report(&tied("rope_bounces", length, restitution, [0.0, -0.1], [0.0, 0.0]), &[], &[], Some(time), 1e-11)
    };
    let (falls, speed) = ((2.0 * 1.0 / GRAVITY).sqrt(), (2.0 * GRAVITY).sqrt());
    let bounces = end(falls + 0.1);
    near("z", (ball(&bounces)[2], -length + restitution * speed * 0.1 - 0.5 * GRAVITY * 0.01));
    near("loss", (bounces.energy.impacts, 0.5 * mass * speed * speed * (1.0 - restitution * restitution)));
    // It hangs at rest in the end, and the rope holds it.
    let hangs = end(10.0);
    near("z at rest", (ball(&hangs)[2], -length));
}

/// Writes a double pendulum: two links of 1 m with hinges about y, `shoulder` at the origin and `elbow`.
pub fn write_double_pendulum(file: &Path) {
    let link = |name: &str| {
        format!(
            "<link name='{name}'><inertial><origin xyz='0 0 -0.5'/><mass value='1'/><inertia ixx='0.02' iyy='0.02' izz='0.02' ixy='0' \
             ixz='0' iyz='0'/></inertial></link>"
        )
    };
    let joint = |name: &str, parent: &str, child: &str, at: &str| {
        format!(
            "<joint name='{name}' type='continuous'><parent link='{parent}'/><child link='{child}'/><origin xyz='{at}'/>\
             <axis xyz='0 1 0'/></joint>"
        )
    };
    let urdf = format!(
        "<robot name='r'><link name='base'/>{}{}{}{}</robot>",
        link("upper"),
        link("lower"),
        joint("shoulder", "base", "upper", "0 0 0"),
        joint("elbow", "upper", "lower", "0 0 -1")
    );
    std::fs::write(file, urdf).expect("a robot");
}

/// A double pendulum whose first link is held by a rope from (0, 0.5) m to its end, or by a limit at the same angle.
fn held_pendulum(folder: &str, rope: bool) -> PathBuf {
    let folder = scratch(folder);
    write_double_pendulum(&folder.join("r.urdf"));
    // The end of the upper link at an angle q about y is (−sin q, −cos q): its distance from (0.5, −0.5) is one at the limit.
    let reach = |angle: f64| (-angle.sin() - 0.5).hypot(-angle.cos() + 0.5);
    let limit = 0.6_f64;
    let held = if rope {
        format!(
            "[[rope]]\npoints = [{{ link = \"world\", position = [0.5, 0, -0.5] }}, {{ link = \"upper\", position = [0, 0, -1] }}]\n\
             length = {}\nrestitution = 0.3\n",
            reach(limit)
        )
    } else {
        format!("[[joint]]\nname = \"shoulder\"\nlimit = [-10, {limit}]\nrestitution = 0.3\n")
    };
    let file = folder.join("scene.toml");
    std::fs::write(&file, format!("[[robot]]\nurdf = \"r.urdf\"\n{held}")).expect("a scene");
    file
}

#[test]
fn a_rope_holds_a_link_of_a_tree_as_a_joint_limit_at_the_same_angle_does() {
    let start = [("shoulder", -0.9), ("elbow", 0.4)];
    let [rope, limit] = [("rope_link", true), ("rope_limit", false)].map(|(folder, rope)| {
        let end = report(&held_pendulum(folder, rope), &start, &[("shoulder", 3.0)], Some(1.2), 1e-11);
        assert!(end.energy.max_relative_error < 1e-10, "{:?}", end.energy);
        end
    });
    assert!(limit.energy.impacts > 0.1, "the limit is met: {} J", limit.energy.impacts);
    near("loss", (rope.energy.impacts, limit.energy.impacts));
    // Two runs with tolerances of 1e-11 m, after blows.
    assert!(apart(&rope, &limit) < BOUND, "{:e} m apart", apart(&rope, &limit));
}

#[test]
fn ropes_that_cannot_be_are_refused_with_their_names() {
    let ball = "[[body]]\nname = \"ball\"\nshape = { type = \"sphere\", radius = 0.05 }\nmass = 2.0\n";
    for (points, said) in [
        ("[{ link = \"ball\" }]", "two points or more"),
        ("[{ link = \"world\" }, { link = \"world\", position = [1, 0, 0] }]", "leave it out"),
    ] {
        let file = scratch("rope_refused").join("scene.toml");
        std::fs::write(&file, format!("{ball}[[rope]]\nname = \"line\"\npoints = {points}\nlength = 1.0\n"))
            .expect("a scene");
        let error = Model::load(&file).expect_err("an error").to_string();
        assert!(error.contains("rope \"line\"") && error.contains(said), "{error}");
    }
}
