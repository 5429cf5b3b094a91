//! Ellipsoids on floors: rocking against a quadrature of the exact energy, and rattlebacks against themselves.
//!
//! An ellipsoid that rolls in the plane of its semi-axes a and c, tilted by θ, has with the height h of its centre and the distance r of its point of
//! contact from the centre
//!
//! ```text
//!     h² = a² sin²θ + c² cos²θ,   r² = (a⁴ sin²θ + c⁴ cos²θ)/h²,   ½ (I + m r²) θ̇² + m g h = m g h(A)
//! ```

use crate::common::scratch;
use crate::scene_files::report;
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
