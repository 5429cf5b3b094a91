//! Linear equations of motion and their modes, against closed forms, differences, and runs.

use crate::{folder, robot};
use catena::prelude::*;
use catena::session::{Hold, Linear, Stability};
use nalgebra::DVector;

fn urdf(name: &str, text: &str) -> std::path::PathBuf {
    let path = folder("linear").join(name);
    std::fs::write(&path, text).expect("a file");
    path
}

/// A link of a mass at (x, y, z) with these moments of inertia about its centre.
fn link(name: &str, mass: f64, at: [f64; 3], moments: [f64; 3]) -> String {
    let ([x, y, z], [xx, yy, zz]) = (at, moments);
    format!(
        "<link name=\"{name}\"><inertial><origin xyz=\"{x} {y} {z}\"/><mass value=\"{mass}\"/>\
         <inertia ixx=\"{xx}\" iyy=\"{yy}\" izz=\"{zz}\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>"
    )
}

fn joint(name: &str, kind: &str, [parent, child]: [&str; 2], at: [f64; 3], axis: &str) -> String {
    let [x, y, z] = at;
    format!(
        "<joint name=\"{name}\" type=\"{kind}\"><origin xyz=\"{x} {y} {z}\"/><parent link=\"{parent}\"/>\
         <child link=\"{child}\"/><axis xyz=\"{axis}\"/></joint>"
    )
}

/// Two rods that hang from each other: hinges about y and about x.
fn two_rods() -> Model {
    let text = format!(
        "<robot name=\"rods\"><link name=\"base\"/>{}{}{}{}</robot>",
        link("upper", 2.0, [0.0, 0.0, -0.3], [0.05, 0.06, 0.02]),
        link("lower", 1.0, [0.0, 0.0, -0.25], [0.03, 0.02, 0.01]),
        joint("shoulder", "continuous", ["base", "upper"], [0.0; 3], "0 1 0"),
        joint("elbow", "continuous", ["upper", "lower"], [0.0, 0.0, -0.6], "1 0 0"),
    );
    Model::load(urdf("rods.urdf", &text)).expect("a model")
}

#[test]
fn a_hanging_double_pendulum_swings_at_the_frequencies_of_its_closed_form() {
    let linear = two_rods().linearize_at_rest(Some(&[0.2, -0.3])).expect("linear equations");
    let g = 9.81;
    // The hinges are perpendicular: the shoulder swings both rods as one, the elbow the lower rod alone.
    let shoulder = (2.0 * 0.3 + 1.0 * 0.85) * g / (0.06 + 2.0 * 0.09 + 0.02 + 0.85 * 0.85);
    let elbow = 0.25 * g / (0.03 + 0.0625);
    let wanted = [shoulder, elbow].map(|square: f64| square.sqrt() / std::f64::consts::TAU);
    for (mode, wanted) in linear.modes.iter().zip(wanted) {
        // Roundings of a few dozen products.
        assert!((mode.frequency - wanted).abs() < 1e-14 * wanted * 10.0, "{} and {wanted}", mode.frequency);
        assert_eq!((mode.stability, mode.damping_ratio), (Stability::Neutral, Some(0.0)));
    }
    // Newton's iteration ends at rounding, within 1e-15 rad times the condition of the stiffness.
    assert!(linear.q.iter().all(|angle| angle.abs() < 1e-14), "{:?}", linear.q);
    assert!(linear.largest_acceleration < 1e-13, "{}", linear.largest_acceleration);
}

#[test]
fn a_pendulum_near_the_top_stays_there_and_is_unstable() {
    let model = two_rods();
    let linear = model.linearize_at_rest(Some(&[std::f64::consts::PI - 0.1, 0.05])).expect("linear equations");
    assert!((linear.q[0] - std::f64::consts::PI).abs() < 1e-14, "{:?}", linear.q);
    assert!(linear.modes.iter().any(|mode| mode.stability == Stability::Unstable));
}

#[test]
fn a_damped_oscillator_has_its_frequency_and_damping_and_input() {
    let linear = Model::load(robot("damped_oscillator.toml")).expect("a model").linearize_at_rest(None).expect("them");
    let mode = &linear.modes[0];
    // x'' + 4 x' + 100 x = u.
    assert!((mode.eigenvalue.re + 2.0).abs() < 1e-13 && (mode.eigenvalue.im - 96.0_f64.sqrt()).abs() < 1e-13);
    assert!((mode.damping_ratio.expect("a ratio") - 0.2).abs() < 1e-14);
    assert!((mode.time_constant.expect("a time") - 0.5).abs() < 1e-14);
    assert!((linear.b[(1, 0)] - 1.0).abs() < 1e-15);
    // The discrete system over half a second is the motion of the closed form from x = 1.
    let (a, [b, _]) = linear.discrete(0.5);
    let w = 96.0_f64.sqrt();
    let x = (-1.0_f64).exp() * ((0.5 * w).cos() + 2.0 / w * (0.5 * w).sin());
    assert!((a[(0, 0)] - x).abs() < 1e-13, "{} and {x}", a[(0, 0)]);
    // A constant force of 100 N holds x = 1.
    assert!((100.0 * b[(0, 0)] - (1.0 - x)).abs() < 1e-13, "{}", b[(0, 0)]);
}

/// The rows of A and B for velocities are the derivatives of the accelerations of forward dynamics.
fn agrees_with_differences(model: &Model, q: &[f64], v: &[f64], tau: &[f64]) {
    let linear = model.linearize(q, v, tau).expect("linear equations");
    let d = v.len();
    assert_eq!(linear.names.len(), d, "all coordinates are independent");
    let a = |q: &[f64], v: &[f64], tau: &[f64]| model.forward_dynamics(q, v, tau).expect("accelerations");
    let scale = linear.a.amax().max(1.0);
    for index in 0..d {
        let moved = |numbers: &[f64], by: f64| {
            let mut moved = numbers.to_vec();
            moved[index] += by;
            moved
        };
        // Differences of order six with a width of 2e-3: 6e-17 of the seventh derivative, which is up to 1e8, and roundings over 2e-3.
        let difference = |of: &dyn Fn(f64) -> DVector<f64>| {
            let h = 2e-3;
            let pair = |k: f64| of(k * h) - of(-k * h);
            (pair(1.0) * 45.0 - pair(2.0) * 9.0 + pair(3.0)) / (60.0 * h)
        };
        let columns = [
            (difference(&|by| a(&moved(q, by), v, tau)), linear.a.view((d, index), (d, 1)).into_owned()),
            (difference(&|by| a(q, &moved(v, by), tau)), linear.a.view((d, d + index), (d, 1)).into_owned()),
            (difference(&|by| a(q, v, &moved(tau, by))), linear.b.view((d, index), (d, 1)).into_owned()),
        ];
        for (difference, column) in columns {
            assert!((&difference - &column).amax() < 1e-8 * scale, "{index}: {difference} {column}");
        }
    }
}

#[test]
fn at_any_instant_the_matrices_are_the_derivatives_of_forward_dynamics() {
    let numbers = |count: usize, seed: f64| -> Vec<f64> { (0..count).map(|i| (seed + 1.7 * i as f64).sin()).collect() };
    for name in ["arm7.urdf", "chain_10.urdf", "planar_slider.urdf"] {
        let model = Model::loader().without(catena::session::Left::Limits).load(robot(name)).expect("a model");
        let n = model.coordinates().v_count();
        agrees_with_differences(&model, &numbers(n, 0.3), &numbers(n, 1.1), &numbers(n, 2.5));
    }
}

/// A scene of the arm of seven joints with a motor in each.
pub fn driven_arm(name: &str, kp: f64, kd: f64) -> std::path::PathBuf {
    let mut scene = format!("[[robot]]\nurdf = {:?}\n", robot("arm7.urdf"));
    for (index, target) in [0.1, 0.3, -0.2, 0.6, 0.2, -0.3, 0.1].iter().enumerate() {
        scene += &format!(
            "[[motor]]\njoint = \"joint{}\"\nkind = \"position\"\ntarget = {target}\nkp = {kp}\nkd = {kd}\nmax_effort = 1e6\n",
            index + 1
        );
    }
    urdf(name, &scene)
}

/// The run that starts a small way off goes as the linear equations say, to the third order of the way.
fn agrees_with_runs(model: &Model, linear: &Linear, along: usize, time: f64, bound: f64) {
    let places = model.coordinates();
    let freedom = |name: &str| places.joint(name).expect("a joint").v.start;
    let way = 1e-4;
    let d = linear.names.len();
    let run = |sign: f64| {
        let mut q = linear.q.clone();
        q[freedom(&linear.names[along])] += sign * way;
        let start = places.by_joint(&q, |joint| &joint.q);
        let own: Vec<_> = start.into_iter().filter(|(name, _)| linear.names.contains(name)).collect();
        let run = Simulation::new(model).tolerance(1e-12).without_figures().duration(time);
        let still = places.joints().iter().map(|joint| (joint.name.clone(), vec![0.0; joint.v.len()]));
        let mut run = run.start(own).expect("a start").velocities(still).expect("a start at rest");
        // Loops that are assembled may move the joint whose start is given.
        let began = run.coordinates().expect("coordinates").0[freedom(&linear.names[along])];
        run.run().expect("a run");
        let (q, v) = run.coordinates().expect("coordinates");
        (q, v, began)
    };
    let (ahead, behind) = (run(1.0), run(-1.0));
    let apart = ahead.2 - behind.2;
    let (matrix, _) = linear.discrete(time);
    for (row, name) in linear.names.iter().enumerate() {
        let entry = freedom(name);
        let moved = (ahead.0[entry] - behind.0[entry]) / apart;
        let speed = (ahead.1[entry] - behind.1[entry]) / apart;
        assert!((moved - matrix[(row, along)]).abs() < bound, "{name}: {moved} and {}", matrix[(row, along)]);
        // Speeds that stiff motors take away are as small as the tolerance over the deviation, times their stiffness.
        let scale = linear.a.amax().max(1.0);
        assert!((speed - matrix[(d + row, along)]).abs() < bound * scale, "{name}: {speed}");
    }
}

#[test]
fn runs_with_closed_loops_springs_and_motors_begin_as_their_linear_equations_say() {
    // The third order of a deviation of 1e-4 rad is some 1e-7 of it; the tolerance of 1e-12 m over the deviation is 1e-8.
    let four_bar = Model::load(robot("four_bar_1.toml")).expect("a model");
    let linear = four_bar.linearize_at_rest(None).expect("linear equations");
    assert_eq!(linear.names.len(), 1);
    agrees_with_runs(&four_bar, &linear, 0, 0.5, 1e-6);
    let held = Model::load(driven_arm("driven_arm.toml", 400.0, 30.0)).expect("a model");
    let linear = held.linearize_at_rest(None).expect("linear equations");
    // Angles of the flange, which turns within a centimetre of its axis, are known a hundred times less than places.
    assert_eq!(linear.targets.len(), 7);
    agrees_with_runs(&held, &linear, 1, 0.1, 1e-5);
    agrees_with_runs(&held, &linear, 3, 0.1, 1e-5);
}

#[test]
fn a_sleeping_top_nutates_and_falls_at_the_rates_of_its_closed_form() {
    let text = format!(
        "<robot name=\"top\"><link name=\"base\"/>{}{}</robot>",
        link("body", 1.0, [0.0, 0.0, 0.4], [0.06, 0.06, 0.03]),
        joint("pivot", "spherical", ["base", "body"], [0.0; 3], "0 0 1"),
    );
    let model = Model::load(urdf("top.urdf", &text)).expect("a model");
    let (about_pivot, along, weight) = (0.06 + 0.16, 0.03, 9.81 * 0.4);
    for spin in [90.0_f64, 50.0] {
        let linear = model.linearize(&[1.0, 0.0, 0.0, 0.0], &[0.0, 0.0, spin], &[]).expect("linear equations");
        // ν = (J₃ω ± √(J₃²ω² − 4 J₁ m g l))/2 J₁, seen from the parent.
        let square = (along * spin).powi(2) - 4.0 * about_pivot * weight;
        let middle = along * spin / (2.0 * about_pivot);
        let swing = square.abs().sqrt() / (2.0 * about_pivot);
        let eigenvalues: Vec<_> = linear.modes.iter().map(|mode| mode.eigenvalue).collect();
        let wanted = if square > 0.0 {
            [(0.0, middle - swing), (0.0, middle + swing)]
        } else {
            [(swing, middle), (-swing, middle)]
        };
        for (re, im) in wanted {
            let nearest = eigenvalues.iter().map(|own| (own.re - re).hypot(own.im - im)).fold(f64::INFINITY, f64::min);
            // Schur's decomposition: roundings of the size of A, about 1e4.
            assert!(nearest < 1e-11, "{spin}: {re} + {im} i among {eigenvalues:?}");
        }
    }
}

#[test]
fn a_mimic_relation_a_stuck_joint_and_a_motor_leave_one_mode_of_the_closed_form() {
    let text = format!(
        "<robot name=\"fingers\"><link name=\"base\"/>{}{}{}{}{}{}</robot>",
        link("left", 0.3, [0.0; 3], [1e-3; 3]),
        link("right", 0.5, [0.0; 3], [1e-3; 3]),
        link("arm", 1.0, [0.4, 0.0, 0.0], [1e-2; 3]),
        "<joint name=\"drive\" type=\"prismatic\"><parent link=\"base\"/><child link=\"left\"/><axis xyz=\"1 0 0\"/>\
         <limit lower=\"-1\" upper=\"1\" effort=\"100\" velocity=\"10\"/></joint>",
        "<joint name=\"follower\" type=\"prismatic\"><parent link=\"base\"/><child link=\"right\"/><axis xyz=\"1 0 0\"/>\
         <limit lower=\"-3\" upper=\"3\" effort=\"100\" velocity=\"10\"/><mimic joint=\"drive\" multiplier=\"-2\"/></joint>",
        "<joint name=\"stiff\" type=\"continuous\"><parent link=\"base\"/><child link=\"arm\"/><axis xyz=\"0 1 0\"/>\
         <dynamics friction=\"50\"/></joint>",
    );
    let path = urdf("fingers.urdf", &text);
    let scene = format!(
        "[[robot]]\nurdf = {path:?}\n[[motor]]\njoint = \"drive\"\nkind = \"position\"\ntarget = 0.1\nkp = 80.0\nkd = 6.0\nmax_effort = 100.0\n"
    );
    let model = Model::load(urdf("fingers.toml", &scene)).expect("a model");
    let linear = model.linearize_at_rest(None).expect("linear equations");
    assert_eq!(linear.names, ["drive"]);
    assert_eq!(linear.stuck, [("stiff".to_string(), "friction".to_string())]);
    let mass: f64 = 0.3 + 4.0 * 0.5;
    let mode = &linear.modes[0];
    let wanted = (80.0 / mass - (3.0 / mass) * (3.0 / mass)).sqrt();
    assert!((mode.eigenvalue.re + 3.0 / mass).abs() < 1e-13, "{}", mode.eigenvalue);
    assert!((mode.eigenvalue.im - wanted).abs() < 1e-13, "{}", mode.eigenvalue);
    assert!((linear.q[0] - 0.1).abs() < 1e-14 && (linear.q[1] + 0.2).abs() < 1e-14, "{:?}", linear.q);
    assert_eq!(linear.targets, ["drive"]);
    assert!((linear.b_targets[(1, 0)] - 80.0 / mass).abs() < 1e-12);
}

#[test]
fn a_base_that_floats_without_weight_moves_freely_and_one_with_weight_has_no_equilibrium() {
    let text = format!(
        "<robot name=\"pair\">{}{}{}</robot>",
        link("body", 2.0, [0.0, 0.1, -0.3], [0.05, 0.06, 0.02]),
        link("arm", 1.0, [0.3, 0.0, 0.0], [0.03, 0.02, 0.01]),
        joint("hinge", "continuous", ["body", "arm"], [0.1; 3], "0 1 0"),
    );
    let path = urdf("pair.urdf", &text);
    let weightless = Model::loader().floating().gravity([0.0; 3]).load(&path).expect("a model");
    let linear = weightless.linearize_at_rest(None).expect("linear equations");
    // Six of the base, one of the joint.
    assert_eq!(linear.modes.iter().filter(|mode| mode.stability == Stability::Free).count(), 7);
    let falling = Model::loader().floating().load(&path).expect("a model");
    let error = falling.linearize_at_rest(None).expect_err("it falls").to_string();
    assert!(error.contains("no equilibrium") && error.contains("out of balance"), "{error}");
}

#[test]
fn a_screw_on_a_spring_finds_its_rest_twenty_and_two_thousand_turns_away() {
    let text = format!(
        "<robot name=\"screw\"><link name=\"base\"/>{}{}</robot>",
        link("nut", 2.0, [0.0; 3], [1e-4; 3]),
        joint("turn", "screw", ["base", "nut"], [0.0; 3], "0 0 1")
            .replace("</joint>", "<thread_pitch value=\"PITCH\"/></joint>"),
    );
    for pitch in [0.02, 2e-4] {
        let robot = urdf("screw.urdf", &text.replace("PITCH", &pitch.to_string()));
        let scene = format!(
            "[[robot]]\nurdf = {robot:?}\nname = \"screw\"\nbase = \"fixed\"\n[[spring]]\na = {{ link = \"nut\", position = [0, 0, 0] }}\n\
             b = {{ link = \"world\", position = [0, 0, 1] }}\nstiffness = 200.0\nrest_length = 0.5\n"
        );
        let model = Model::load(urdf("screw.toml", &scene)).expect("a model");
        let found = model.linearize_at_rest(None).expect("linear equations");
        // k (1 − z − l) = m g.
        let turned = (0.5 - 2.0 * 9.81 / 200.0) / pitch * std::f64::consts::TAU;
        assert!((found.q[0] - turned).abs() < 1e-9 * turned, "{} for {turned}", found.q[0]);
        assert!(found.iterations < Some(40), "{:?}", found.iterations);
    }
}

#[test]
fn the_matrices_of_a_model_without_motion_are_empty() {
    let model = Model::load(robot("friction_pendulum.toml")).expect("a model");
    let linear = model.linearize_at_rest(None).expect("linear equations");
    assert_eq!((linear.modes.len(), linear.a.len(), linear.stuck.len()), (0, 0, 1));
}

#[test]
fn motors_that_hold_from_the_start_are_in_linear_equations() {
    let text = format!(
        "<robot name=\"rod\"><link name=\"base\"/>{}{}</robot>",
        link("rod", 2.0, [0.0, 0.0, -0.3], [0.05, 0.06, 0.02]),
        joint("hinge", "continuous", ["base", "rod"], [0.0; 3], "0 1 0"),
    );
    let held = Model::loader().hold(Hold::default()).load(urdf("held.urdf", &text)).expect("a model");
    let linear = held.linearize(&[0.0], &[0.0], &[]).expect("linear equations");
    // The gains I ω² and 2 I ω with ω = 20 π rad/s: λ = −ω ± i √(m g l/I).
    let swing = (2.0 * 9.81 * 0.3 / (0.06 + 2.0 * 0.09_f64)).sqrt() / std::f64::consts::TAU;
    let mode = &linear.modes[0];
    // Roundings of products of 4e3 under a root whose square is 6e-3 of them.
    assert!((mode.frequency - swing).abs() < 1e-12 * swing, "{} and {swing}", mode.frequency);
    let constant = mode.time_constant.expect("it is damped") * 20.0 * std::f64::consts::PI;
    assert!((constant - 1.0).abs() < 1e-13, "{constant}");
}

#[test]
fn a_weight_on_a_taut_rope_swings_as_on_a_rod() {
    let body = "[[body]]\nname = \"b\"\nshape = { type = \"sphere\", radius = 0.1 }\nmass = 2\n";
    let ends = "{ link = \"world\", position = [0, 0, 1] }, { link = \"b\", position = [0, 0, 0] }";
    let rope = format!("{body}[[rope]]\npoints = [{ends}]\nlength = 1\n");
    let linear = Model::load(urdf("rope.toml", &rope)).expect("a model").linearize_at_rest(None).expect("equations");
    assert_eq!((linear.names.len(), linear.modes.len()), (5, 5));
    let wanted = 9.81_f64.sqrt() / std::f64::consts::TAU;
    let swinging: Vec<f64> =
        linear.modes.iter().map(|mode| mode.frequency).filter(|&frequency| frequency > 0.0).collect();
    assert_eq!(swinging.len(), 2, "{swinging:?}");
    // Roundings of a few dozen products.
    assert!(swinging.iter().all(|frequency| (frequency - wanted).abs() < 1e-12), "{swinging:?}");
}
