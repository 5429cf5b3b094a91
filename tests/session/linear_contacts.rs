//! Linear equations of motion with closed contacts that roll or slide, against closed forms and the derivatives of runs.

use crate::folder;
use catena::prelude::*;
use catena::session::{Linear, Stability};
use nalgebra::{Complex, DMatrix};

fn file(name: &str, text: &str) -> std::path::PathBuf {
    let path = folder("linear_contacts").join(name);
    std::fs::write(&path, text).expect("a file");
    path
}

const FLOOR: &str = "[[obstacle]]\nname = \"floor\"\nshape = { type = \"half_space\" }\n";

/// A body of 3 kg whose centre of mass is 0.06 m below the centre of its shape, 0.2 m above a floor.
fn rocker(name: &str, shape: &str) -> Model {
    let urdf = format!(
        "<robot name=\"r\"><link name=\"r\"><inertial><origin xyz=\"0 0 -0.06\"/><mass value=\"3\"/>\
         <inertia ixx=\"0.02\" iyy=\"0.03\" izz=\"0.025\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial><collision>{shape}</collision></link></robot>"
    );
    let urdf = file(&format!("{name}.urdf"), &urdf);
    let text = format!("[[robot]]\nurdf = {urdf:?}\nbase = \"floating\"\npose = {{ position = [0, 0, 0.2] }}\n{FLOOR}");
    Model::load(file(&format!("{name}.toml"), &text)).expect("a model")
}

fn frequencies(linear: &Linear) -> Vec<f64> {
    linear.modes.iter().map(|mode| mode.frequency).filter(|&frequency| frequency > 0.0).collect()
}

/// The frequency of a rocker with a moment of inertia about its centre of mass (Hz): it turns about the place on the floor.
fn rocking(inertia: f64) -> f64 {
    (3.0 * 9.81 * 0.06 / (inertia + 3.0 * 0.14_f64.powi(2))).sqrt() / std::f64::consts::TAU
}

fn near(found: &[f64], wanted: &[f64]) {
    assert_eq!(found.len(), wanted.len(), "{found:?}");
    for (found, wanted) in found.iter().zip(wanted) {
        // Roundings of a few dozen products.
        assert!((found - wanted).abs() < 1e-12 * wanted.abs(), "{found} and {wanted}");
    }
}

#[test]
fn a_ball_and_a_cylinder_with_a_weight_below_their_centres_rock_at_the_frequencies_of_their_closed_forms() {
    let ball = rocker("ball", "<geometry><sphere radius=\"0.2\"/></geometry>");
    let linear = ball.linearize_at_rest(None).expect("linear equations");
    near(&frequencies(&linear), &[rocking(0.03), rocking(0.02)]);
    // A ball has five coordinates on a floor and turns in three ways; nothing turns it back about the vertical, or to where it was.
    assert_eq!((linear.names.len(), linear.velocities.len(), linear.rolling_contacts), (5, 3, 1));
    assert_eq!(linear.modes.iter().filter(|mode| mode.stability == Stability::Free).count(), 3);
    assert_eq!(linear.stiffness.shape(), (3, 5));
    let lying = "<origin xyz=\"0 0 0\" rpy=\"1.5707963267948966 0 0\"/><geometry><cylinder radius=\"0.2\" length=\"0.4\"/></geometry>";
    let linear = rocker("cylinder", lying).linearize_at_rest(None).expect("linear equations");
    near(&frequencies(&linear), &[rocking(0.03)]);
    assert_eq!((linear.names.len(), linear.velocities.len(), linear.rolling_contacts), (4, 1, 2));
}

#[test]
fn a_ball_that_starts_aside_of_its_rest_rolls_to_it() {
    let ball = rocker("ball_aside", "<geometry><sphere radius=\"0.2\"/></geometry>");
    let (half, place) = (0.15_f64, [0.3, -0.1, 0.2]);
    let q = [place[0], place[1], place[2], half.cos(), half.sin() * 0.6, half.sin() * 0.8, 0.0];
    let linear = ball.linearize_at_rest(Some(&q)).expect("linear equations");
    // It has turned by 0.3 rad about (0.6, 0.8, 0), over 0.2 m, to where its weight is below.
    let moved = [q[0] - 0.2 * 0.3 * 0.8, q[1] + 0.2 * 0.3 * 0.6];
    // Newton's method goes along chords of the curve, of up to 0.3 rad.
    assert!((linear.q[0] - moved[0]).abs() < 1e-3 && (linear.q[1] - moved[1]).abs() < 1e-3, "{:?}", linear.q);
    assert!(linear.largest_acceleration < 1e-12, "{}", linear.largest_acceleration);
    near(&frequencies(&linear), &[rocking(0.03), rocking(0.02)]);
}

#[test]
fn a_ball_on_a_globe_and_a_plank_on_a_log_have_the_eigenvalues_of_their_closed_forms() {
    let ball = "[[body]]\nname = \"b\"\nshape = { type = \"sphere\", radius = 0.1 }\nmass = 2\npose = { position = [0, 0, 0.6] }\n\
                [[obstacle]]\nname = \"globe\"\nshape = { type = \"sphere\", radius = 0.5 }\n";
    let linear = Model::load(file("globe.toml", ball)).expect("a model").linearize_at_rest(None).expect("equations");
    // λ² = 5 g/(7 (R + r)), in two directions.
    let rate = (5.0 * 9.81 / (7.0 * 0.6_f64)).sqrt();
    let real: Vec<f64> = linear.modes.iter().map(|mode| mode.eigenvalue.re).filter(|re| *re != 0.0).collect();
    near(&real, &[-rate, -rate, rate, rate]);
    let plank = "[[body]]\nname = \"b\"\nshape = { type = \"box\", size = [1, 0.2, 0.04] }\nmass = 2\npose = { position = [0, 0, 0.32] }\n\
                 [[obstacle]]\nname = \"log\"\nshape = { type = \"cylinder\", radius = 0.3, length = 1 }\npose = { rpy = [\"90 deg\", 0, 0] }\n";
    let linear = Model::load(file("plank.toml", plank)).expect("a model").linearize_at_rest(None).expect("equations");
    let inertia: f64 = 2.0 * (1.0 + 0.04 * 0.04) / 12.0 + 2.0 * 0.02 * 0.02;
    near(&frequencies(&linear), &[(2.0 * 9.81 * 0.28 / inertia).sqrt() / std::f64::consts::TAU]);
    let free = linear.modes.iter().filter(|mode| mode.stability == Stability::Free);
    let along: Vec<f64> = free.map(|mode| mode.shape[1].norm()).collect();
    assert!(along.iter().any(|&along| along > 0.5), "it may lie elsewhere along the log: {along:?}");
}

#[test]
fn a_ball_or_a_wheel_on_a_floor_is_free_at_all_sizes() {
    for radius in [0.1, 0.2, 0.25, 0.3, 0.35, 0.5, 0.7, 1.3] {
        let wheel = format!(
            "[[body]]\nname = \"wheel\"\nshape = {{ type = \"cylinder\", radius = {radius}, length = 0.1 }}\nmass = 10\n\
             pose = {{ position = [-1, 0, {radius}], rpy = [\"90 deg\", 0, 0] }}\n{FLOOR}"
        );
        let model = Model::load(file(&format!("wheel{radius}.toml"), &wheel)).expect("a model");
        let linear = model.linearize_at_rest(None).expect("linear equations");
        let is_free = linear.modes.iter().all(|mode| mode.stability == Stability::Free);
        assert!(is_free && linear.modes.len() == 4, "{radius}: {:?}", linear.modes);
        assert_eq!((linear.velocities.len(), linear.rolling_contacts), (1, 2), "{radius}");
    }
}

/// A run that starts at the equilibrium with slight velocities goes as the linear equations say, to the second order of the speeds.
fn agrees_with_runs(model: &Model, linear: &Linear, time: f64, bound: f64) {
    let places = model.coordinates();
    let row = |name: &String| match name.split_once('.') {
        None => places.joint(name).expect("a joint").v.start,
        Some((joint, axis)) => {
            let first = places.joint(joint).expect("a joint").v.start;
            first + ["x", "y", "z", "rx", "ry", "rz"].iter().position(|of| *of == axis).expect("an axis")
        }
    };
    let (d, e) = (linear.names.len(), linear.velocities.len());
    // All modes that swing at once: velocities that the contacts allow.
    let mut velocities = vec![0.0; linear.v.len()];
    for mode in linear.modes.iter().filter(|mode| mode.frequency > 0.0) {
        let along = linear.freedoms.iter().zip(&mode.shape);
        along.for_each(|(name, part)| velocities[row(name)] += part.re);
    }
    let speed = 1e-4;
    let run = |sign: f64| {
        let run = Simulation::new(model).tolerance(1e-13).without_figures().duration(time);
        let run = run.start(places.by_joint(&linear.q, |joint| &joint.q)).expect("a start");
        let moving: Vec<f64> = velocities.iter().map(|own| sign * speed * own).collect();
        let mut run = run.velocities(places.by_joint(&moving, |joint| &joint.v)).expect("a start");
        run.run().expect("a run");
        run.coordinates().expect("coordinates")
    };
    let (ahead, behind) = (run(1.0), run(-1.0));
    let began = DMatrix::from_fn(d + e, 1, |entry, _| match entry.checked_sub(d) {
        Some(own) => velocities[row(&linear.velocities[own])],
        None => 0.0,
    });
    let foreseen = linear.discrete(time).0 * began;
    let scale = foreseen.amax();
    for (own, name) in linear.velocities.iter().enumerate() {
        let found = (ahead.1[row(name)] - behind.1[row(name)]) / (2.0 * speed);
        println!("{name}: off by {:e} of {scale}", (found - foreseen[d + own]).abs());
        assert!((found - foreseen[d + own]).abs() < bound * scale, "{name}: {found} for {}", foreseen[d + own]);
    }
    for (own, name) in linear.names.iter().enumerate().filter(|(_, name)| !name.contains(".r")) {
        let place = |q: &[f64]| match name.split_once('.') {
            None => q[places.joint(name).expect("a joint").q.start],
            Some((joint, axis)) => {
                q[places.joint(joint).expect("a joint").q.start
                    + ["x", "y", "z"].iter().position(|of| *of == axis).expect("an axis")]
            }
        };
        let found = (place(&ahead.0) - place(&behind.0)) / (2.0 * speed);
        println!("{name}: off by {:e} of {scale}", (found - foreseen[own]).abs());
        assert!((found - foreseen[own]).abs() < bound * scale, "{name}: {found} for {}", foreseen[own]);
    }
}

#[test]
fn runs_of_a_robot_on_feet_that_roll_go_as_their_linear_equations_say() {
    let ball = rocker("ball_flow", "<geometry><sphere radius=\"0.2\"/></geometry>");
    agrees_with_runs(&ball, &ball.linearize_at_rest(None).expect("linear equations"), 0.4, 1e-6);
    let standing = Model::load(stool(2.0)).expect("a model");
    let linear = standing.linearize_at_rest(None).expect("linear equations");
    assert_eq!((linear.rolling_contacts, linear.largest_acceleration < 1e-9), (4, true), "{:?}", linear);
    agrees_with_runs(&standing, &linear, 0.03, 1e-6);
}

#[test]
fn rest_that_needs_more_friction_than_there_is_says_so() {
    let standing = Model::load(stool(0.3)).expect("a model");
    let error = standing.linearize_at_rest(None).expect_err("it slips").to_string();
    assert!(error.contains("more friction than there is") && !error.contains('\n'), "{error}");
}

#[test]
fn a_ball_that_spins_about_its_weight_has_the_eigenvalues_of_its_closed_form() {
    let model = rocker("spinning", "<geometry><sphere radius=\"0.2\"/></geometry>");
    let model = model.with_params([("r.inertia.ixx", 0.03)]).expect("a model");
    for spin in [2.0, 9.0] {
        let linear = model.linearize(&[0.0, 0.0, 0.2, 1.0, 0.0, 0.0, 0.0], &[0.0, 0.0, 0.0, 0.0, 0.0, spin], &[]);
        let linear = linear.expect("linear equations");
        // The tilt φ (complex: about x and y) turns the place of contact along: with h = R − e and φ̇ = w + i Ω φ
        //     (A + m h²) φ̈ − i (C + m h R) Ω φ̇ + m g e φ = 0.
        let (mass, below, radius, across, along) = (3.0, 0.06, 0.2_f64, 0.03, 0.025);
        let height = radius - below;
        let (inertia, turns) = (across + mass * height * height, (along + mass * height * radius) * spin);
        let root = (turns * turns + 4.0 * inertia * mass * 9.81 * below).sqrt();
        let wanted = [turns + root, turns - root].map(|im| Complex::new(0.0, im / (2.0 * inertia)));
        for value in wanted {
            let near = linear.modes.iter().map(|mode| mode.eigenvalue);
            let near =
                near.map(|own| (own - value).norm().min((own.conj() - value).norm())).fold(f64::INFINITY, f64::min);
            // Schur's decomposition: roundings of the size of A, below 1e2.
            assert!(
                near < 1e-11,
                "{spin}: {value} among {:?}",
                linear.modes.iter().map(|mode| mode.eigenvalue).collect::<Vec<_>>()
            );
        }
    }
}

#[test]
fn a_ball_that_slides_has_the_derivatives_of_its_friction() {
    let text = format!(
        "[[body]]\nname = \"b\"\nshape = {{ type = \"sphere\", radius = 0.1 }}\nmass = 2\npose = {{ position = [0, 0, 0.1] }}\n{FLOOR}friction = 0.3\n"
    );
    let model = Model::load(file("sliding.toml", &text)).expect("a model");
    let (place, speed) = ([0.0, 0.0, 0.1, 1.0, 0.0, 0.0, 0.0], 2.0);
    let linear = model.linearize(&place, &[speed, 0.0, 0.0, 0.0, 0.0, 0.0], &[]).expect("linear equations");
    assert_eq!((linear.sliding_contacts, linear.names.len(), linear.velocities.len()), (1, 5, 5));
    let row = |name: &str| 5 + linear.velocities.iter().position(|own| own == name).expect("a velocity");
    // The force −μ m g u/|u|, u_y = v_y + R ω_x, turns with the slip; its size stays.
    let turns = -0.3 * 9.81 / speed;
    let of_arm = turns * 0.1 * 5.0 / (2.0 * 0.01);
    for (of, by, wanted) in [
        ("b.x", "b.x", 0.0),
        ("b.y", "b.y", turns),
        ("b.y", "b.rx", 0.1 * turns),
        ("b.rx", "b.y", of_arm),
        ("b.rx", "b.rx", 0.1 * of_arm),
        ("b.ry", "b.ry", 0.0),
    ] {
        let found = linear.a[(row(of), row(by))];
        assert!((found - wanted).abs() < 1e-12, "{of} by {by}: {found} for {wanted}");
    }
    // A motion that begins without slip has friction in no direction yet.
    let text = format!("[scene]\ngravity = [9, 0, -5]\n{text}");
    let inclined = Model::load(file("inclined.toml", &text)).expect("a model");
    let error = inclined.linearize(&place, &[0.0; 6], &[]).expect_err("it begins to slide").to_string();
    assert!(error.starts_with("1 closed contact begins to slide here"), "{error}");
}

/// A body on four legs with two hinges each and balls for feet.
fn stool(friction: f64) -> std::path::PathBuf {
    let mut urdf = String::from(
        "<robot name=\"stool\"><link name=\"body\"><inertial><origin xyz=\"0.02 0.01 0\"/><mass value=\"5\"/>\
         <inertia ixx=\"0.05\" iyy=\"0.06\" izz=\"0.07\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>",
    );
    let limit = "<limit lower=\"-1\" upper=\"1\" effort=\"1000\" velocity=\"100\"/>";
    for (leg, (x, y)) in [(0.2, 0.15), (0.2, -0.15), (-0.2, 0.15), (-0.2, -0.15)].into_iter().enumerate() {
        let link = |name: &str, collision: &str| {
            format!(
                "<link name=\"{name}{leg}\"><inertial><origin xyz=\"0 0 -0.1\"/><mass value=\"0.5\"/>\
                 <inertia ixx=\"0.005\" iyy=\"0.005\" izz=\"0.001\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>{collision}</link>"
            )
        };
        let joint = |name: &str, parent: &str, child: &str, at: [f64; 3], axis: &str| {
            format!(
                "<joint name=\"{name}{leg}\" type=\"revolute\"><origin xyz=\"{} {} {}\"/><parent link=\"{parent}\"/>\
                 <child link=\"{child}{leg}\"/><axis xyz=\"{axis}\"/>{limit}</joint>",
                at[0], at[1], at[2]
            )
        };
        let foot = "<collision><origin xyz=\"0 0 -0.2\"/><geometry><sphere radius=\"0.03\"/></geometry></collision>";
        urdf += &link("thigh", "");
        urdf += &link("shank", foot);
        urdf += &joint("hip", "body", "thigh", [x, y, 0.0], "1 0 0");
        urdf += &joint("knee", &format!("thigh{leg}"), "shank", [0.0, 0.0, -0.2], "0 1 0");
    }
    let urdf = file("stool.urdf", &(urdf + "</robot>"));
    let (hip, knee) = (0.3_f64, 0.5_f64);
    let height = (0.2 + 0.2 * knee.cos()) * hip.cos() + 0.03;
    let signs = [(1.0, -1.0), (-1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let angles = signs.iter().enumerate();
    let angles: Vec<(String, f64)> =
        angles.flat_map(|(leg, (x, y))| [(format!("hip{leg}"), x * hip), (format!("knee{leg}"), y * knee)]).collect();
    let bent: Vec<String> = angles.iter().map(|(joint, angle)| format!("{joint} = {angle}")).collect();
    let mut text = format!(
        "[[robot]]\nurdf = {urdf:?}\nbase = \"floating\"\npose = {{ position = [0, 0, {height}] }}\npositions = {{ {} }}\n{FLOOR}friction = {friction}\n",
        bent.join(", ")
    );
    for (joint, angle) in angles {
        text += &format!(
            "[[motor]]\njoint = \"{joint}\"\nkind = \"position\"\ntarget = {angle}\nkp = 200.0\nkd = 3.0\nmax_effort = 1e6\n"
        );
    }
    file("stool.toml", &text)
}
