//! Ellipsoids on floors: rocking against a quadrature of the exact energy, and rattlebacks against themselves.
//!
//! An ellipsoid that rolls in the plane of its semi-axes a and c, tilted by θ, has with the height h of its centre and the distance r of its point of
//! contact from the centre
//!
//! ```text
//!     h² = a² sin²θ + c² cos²θ,   r² = (a⁴ sin²θ + c⁴ cos²θ)/h²,   ½ (I + m r²) θ̇² + m g h = m g h(A)
//! ```

use crate::common::scratch;
use crate::scene_files::{report, scene_of};
use catena::prelude::Model;
use catena::report::Report;
use std::path::PathBuf;

const GRAVITY: f64 = 9.81;

fn rocker(folder: &str, [a, b, c]: [f64; 3], mass: f64, tilt: f64) -> PathBuf {
    let height = ((a * tilt.sin()).powi(2) + (c * tilt.cos()).powi(2)).sqrt();
    let text = format!(
        "[[body]]\nname = \"stone\"\nshape = {{ type = \"ellipsoid\", radii = [{a}, {b}, {c}] }}\nmass = {mass}\n\
         pose = {{ position = [0, 0, {height}], rpy = [0, {tilt}, 0] }}\n\
         [[obstacle]]\nname = \"floor\"\nshape = {{ type = \"half_space\" }}\nfriction = 0.8\n"
    );
    let file = scratch(folder).join("scene.toml");
    std::fs::write(&file, text).expect("a scene");
    file
}

/// The tilt of the stone at the end (rad): its turn about y.
fn tilt(report: &Report) -> f64 {
    let [w, _, y, _] = report.links.iter().find(|(name, _)| name == "stone").expect("a stone").1.orientation;
    2.0 * y.atan2(w)
}

/// A quarter of the period from a tilt A (s), by the midpoint rule in φ with θ = A sin φ, which converges exponentially.
fn quarter([a, b, c]: [f64; 3], tilt: f64) -> f64 {
    let per_mass = (a * a + c * c) / 5.0 + 0.0 * b;
    let height = |angle: f64| ((a * angle.sin()).powi(2) + (c * angle.cos()).powi(2)).sqrt();
    let count = 64;
    let of = |number: usize| {
        let phase = std::f64::consts::FRAC_PI_2 * (number as f64 + 0.5) / count as f64;
        let angle = tilt * phase.sin();
        let arm = ((a * a * angle.sin()).powi(2) + (c * c * angle.cos()).powi(2)) / height(angle).powi(2);
        // h(A) − h(θ) without cancellation.
        let fall = (a * a - c * c) * (tilt - angle).sin() * (tilt + angle).sin() / (height(tilt) + height(angle));
        ((per_mass + arm) / (2.0 * GRAVITY * fall)).sqrt() * tilt * phase.cos()
    };
    (0..count).map(of).sum::<f64>() * std::f64::consts::FRAC_PI_2 / count as f64
}

#[test]
fn an_ellipsoid_rocks_on_a_floor_with_its_exact_period() {
    for (name, radii, start) in [("rocks_low", [0.3, 0.2, 0.1], 0.02), ("rocks_high", [0.25, 0.1, 0.15], 0.5)] {
        let quarter = quarter(radii, start);
        // Small tilts: ω² = g (a²/c − c)/((a² + c²)/5 + c²). At a tilt of A the point on the floor is (a² − c²)/c A aside, which adds that squared to
        // the inertia per mass at most.
        let [a, _, c] = radii;
        let small = (GRAVITY * (a * a / c - c) / ((a * a + c * c) / 5.0 + c * c)).sqrt();
        let aside = (a * a - c * c) / c * start;
        let part = quarter * small / std::f64::consts::FRAC_PI_2 - 1.0;
        assert!(part.abs() < aside * aside / ((a * a + c * c) / 5.0 + c * c), "{name}: {part}");
        let scene = rocker(name, radii, 2.0, start);
        let turns = report(&scene, &[], &[], Some(quarter), 1e-11);
        // It passes the upright with rates of a few rad/s: 1e-10 s of the quadrature and of the run.
        assert!(tilt(&turns).abs() < 1e-10, "{name}: {:e} after a quarter", tilt(&turns));
        assert!(turns.energy.max_relative_error < 1e-11, "{:?}", turns.energy);
        let back = report(&scene, &[], &[], Some(4.0 * quarter), 1e-11);
        assert!((tilt(&back) - start).abs() < 1e-10, "{name}: {:e} after a period", tilt(&back) - start);
        assert!(back.energy.friction.abs() < 1e-12, "rolling takes no energy: {:e}", back.energy.friction);
    }
}

/// A rattleback: an ellipsoid whose principal axes of inertia are turned about z against its shape, with a spin (rad/s) and a rate of pitch.
fn rattleback(folder: &str, spin: f64) -> PathBuf {
    let (radii, height) = ([0.1, 0.02, 0.015], 0.015);
    let folder = scratch(folder);
    // Moments 3e-5, 5e-4, 5.2e-4 kg m² turned by 5°.
    let (sine, cosine) = 5.0_f64.to_radians().sin_cos();
    let (low, high) = (3e-5, 5e-4);
    let ixx = low * cosine * cosine + high * sine * sine;
    let iyy = low * sine * sine + high * cosine * cosine;
    let ixy = (low - high) * sine * cosine;
    let urdf = format!(
        "<robot name='rattleback'><link name='stone'><inertial><mass value='0.2'/><inertia ixx='{ixx}' iyy='{iyy}' izz='5.2e-4' \
         ixy='{ixy}' ixz='0' iyz='0'/></inertial><collision><geometry><ellipsoid radii='{} {} {}'/></geometry></collision></link></robot>",
        radii[0], radii[1], radii[2]
    );
    std::fs::write(folder.join("stone.urdf"), urdf).expect("a robot");
    let text = format!(
        "[[robot]]\nurdf = \"stone.urdf\"\nbase = \"floating\"\npose = {{ position = [0, 0, {height}], rpy = [0, 0, 0] }}\n\
         velocity = {{ linear = [0, 0, 0], angular = [0.01, 0.02, {spin}] }}\n\
         [[obstacle]]\nname = \"floor\"\nshape = {{ type = \"half_space\" }}\nfriction = 10.0\n"
    );
    let file = folder.join("scene.toml");
    std::fs::write(&file, text).expect("a scene");
    file
}

#[test]
fn a_rattleback_converges_against_itself() {
    let scene = rattleback("rattleback", -2.0);
    let [coarse, fine] = [1e-10, 1e-12].map(|tolerance| report(&scene, &[], &[], Some(1.0), tolerance));
    let [one, other] = [&coarse, &fine].map(|report| report.links.last().expect("a stone").1.center_of_mass);
    let apart = one.iter().zip(other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    // The tolerance is of the whole run, and the estimate of the error has a factor of ten.
    assert!(apart < 1e-9, "{apart:e}");
    assert!(fine.energy.max_relative_error < 1e-10, "{:?}", fine.energy);
}

#[test]
fn an_ellipsoid_beside_another_shape_is_refused_with_both_names_and_what_to_do() {
    let text = "[[body]]\nname = \"egg\"\nshape = { type = \"ellipsoid\", radii = [0.1, 0.1, 0.2] }\nmass = 1\npose.position = [0, 0, 1]\n\
                [[obstacle]]\nname = \"table\"\nshape = { type = \"box\", size = [1, 1, 1] }\n";
    let file = scratch("egg").join("scene.toml");
    std::fs::write(&file, text).expect("a scene");
    let error = Model::load(&file).expect_err("an error").to_string();
    for part in ["\"egg\"", "\"table\"", "half spaces", "ignore = true"] {
        assert!(error.contains(part), "{error}");
    }
}

/// An ellipsoid that rolls on a floor, begins to slip, and rolls again: its mass (kg), inertias (kg m²), semi-axes (m), start, friction, duration (s), and
/// where its centre ends (m).
struct Slipping {
    mass: f64,
    inertia: [f64; 3],
    axes: [f64; 3],
    pose: &'static str,
    velocity: &'static str,
    friction: f64,
    duration: f64,
    end: [f64; 2],
}

/// The ends are those of the six equations of the body integrated with DOP853, apart while it rolls and while it slips. That slip has to begin with a
/// speed; the ends with 1e-8 and 1e-9 m/s are extrapolated to zero, and change by 3e-10 m from the last.
const SLIPPING: [Slipping; 2] = [
    Slipping {
        mass: 0.36340811068878665,
        inertia: [0.00033479102091002, 0.0009758588106675144, 0.0010502912564372693],
        axes: [0.10329804276475694, 0.05390796677038594, 0.04051953561193236],
        pose: "position = [0, 0, 0.05746789756309326], rpy = [-1.82966541437223, 0.24973790198347381, 2.0638649661292465]",
        velocity: "linear = [0.468353422077003, -0.19750919210734208, -0.19586298603335578], \
                   angular = [4.3062012219452175, 5.637553479332565, 4.612180502197905]",
        friction: 0.31376445705458317,
        duration: 0.7071450320352012,
        end: [0.01192214990, -0.00748991622],
    },
    Slipping {
        mass: 0.33511022350011027,
        inertia: [0.0012487596732872956, 0.0009101171927523453, 0.0006769169286051704],
        axes: [0.04371299771961088, 0.08683173793128669, 0.11196893613665042],
        pose: "position = [0, 0, 0.10515623635263935], rpy = [-2.6068491392608872, 0.1398847230839443, 2.629552806396516]",
        velocity: "linear = [0.6510006011917624, -0.002749013860677591, 0.004138929169279824], \
                   angular = [0.05133775674978125, 5.125320374267339, -4.6706123656698235]",
        friction: 0.2764116300023359,
        duration: 1.1538650121134943,
        end: [0.49916635629, -0.28494183348],
    },
];

#[test]
fn a_rolling_ellipsoid_begins_to_slip_in_steps_of_the_scheme_to_the_tolerance() {
    for (number, of) in SLIPPING.iter().enumerate() {
        let ([x, y, z], [a, b, c]) = (of.inertia, of.axes);
        let robot = format!(
            "<link name='p'><inertial><mass value='{}'/><inertia ixx='{x}' iyy='{y}' izz='{z}' ixy='0' ixz='0' iyz='0'/></inertial>\
             <collision><geometry><ellipsoid radii='{a} {b} {c}'/></geometry></collision></link>",
            of.mass
        );
        let text = format!(
            "[[robot]]\nurdf = \"robot.urdf\"\nbase = \"floating\"\npose = {{ {} }}\nvelocity = {{ {} }}\n\
             [[obstacle]]\nname = \"floor\"\nshape = {{ type = \"half_space\" }}\nfriction = {}\n",
            of.pose, of.velocity, of.friction
        );
        let file = scene_of(&format!("slipping_{number}"), &robot, &text);
        for tolerance in [1e-6, 1e-7, 1e-8] {
            let found = report(&file, &[], &[], Some(of.duration), tolerance);
            let (_, link) = &found.links[0];
            let off = (link.center_of_mass[0] - of.end[0]).hypot(link.center_of_mass[1] - of.end[1]);
            assert!(off < tolerance, "{number} at {tolerance:e}: {off:e} m beside the other integration");
            assert!(found.accuracy.as_ref().is_some_and(|accuracy| accuracy.reached), "{number} at {tolerance:e}");
            // The start of a slip is no crowd of events.
            assert_eq!(found.method.crowd.steps, 0, "{number} at {tolerance:e}");
        }
    }
}
